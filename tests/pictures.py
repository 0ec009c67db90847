"""What a picture says, and what of it leaves its figure."""

from __future__ import annotations

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.text import Text

from system.plot import STYLE, settle

ROUNDED = 1.5  # pixels by which a text may leave its figure: the layout rounds


def figure_of_files() -> Figure:
    """An empty figure as files of pictures begin with."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.0, 4.5), dpi=STYLE["savefig.dpi"], layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def legend_of(figure: Figure) -> set[str]:
    """Entries of all legends of a figure, its axes' too."""
    return {text.get_text() for legend in figure.findobj(Legend) for text in legend.get_texts()}


def leaving(figure: Figure) -> list[str]:
    """Texts that are seen and leave the figure, once it is laid out."""
    settle(figure)
    figure.draw_without_rendering()
    low, high = figure.bbox.min - ROUNDED, figure.bbox.max + ROUNDED
    boxes = {t.get_text(): t.get_window_extent() for t in _seen(figure)}
    return [text for text, box in boxes.items() if (box.min < low).any() or (box.max > high).any()]


def _seen(figure: Figure) -> list[Text]:
    """Texts that are drawn: not those of axes without axes' lines, nor ticks outside of an axis' ends."""
    hidden: set[int] = set()
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            low, high = sorted(axis.get_view_interval())
            ticks = [t for t in axis.get_major_ticks() if not low <= t.get_loc() <= high]
            hidden |= {
                id(text) for text in (axis.findobj(Text) if not ax.axison else [t.label1 for t in ticks])
            }
    texts = [t for t in figure.findobj(Text) if isinstance(t, Text) and id(t) not in hidden]
    return [t for t in texts if t.get_visible() and t.get_text().strip()]
