"""Pictures of blame: what deviates, the steps of the search, and the robot's ways side by side."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from circuits.catalogue import later
from circuits.silicon.edit import DEVIATIONS
from system.plot import COLOURS, INK, STYLE, settle
from system.study.blame.blame import Blame
from system.study.blame.story import Told

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

matplotlib, figures, images = later("matplotlib"), later("matplotlib.figure"), later("matplotlib.image")
agg = later("matplotlib.backends.backend_agg")


MOST_BARS = 16
WIDE, HEAD = 5.6, 0.4  # inches: a run, and its heading
SIGMAS = 3.0  # to which a picture of deviations reaches at least, either way


def draw_blame(found: Blame, told: Told, figure: Figure) -> None:
    """Fill a figure: deviations of the culprits above, below each run as its system draws it."""
    ways = [drawn(found, told.traces[name]) for name in told.traces]
    tall = HEAD + WIDE * max((image.shape[0] / image.shape[1] for image in ways), default=0.0)
    bars = 1.0 + 0.25 * min(shown(found), MOST_BARS) if shown(found) else 0.0
    figure.set_size_inches(WIDE * max(len(ways), 1), bars + tall)
    below: Any = figure
    if bars:
        both: Any = figure.subfigures(2, 1, height_ratios=(bars, tall))
        above, below = both
        draw_culprits(found, above.subplots())
    for ax, name, image in zip(np.ravel(below.subplots(1, len(ways))), told.traces, ways, strict=True):
        ax.imshow(image)
        ax.axis("off")
        word = "succeeds" if found.case.success(told.summaries[name]) else "fails"
        ax.set_title(f"{name} {word}, seed {told.seed}", fontsize=9)


def shown(found: Blame) -> int:
    """How many deviations its culprits have."""
    return sum(len(each.deviations) for each in found.culprits)


def draw_culprits(found: Blame, ax: Axes) -> None:
    """Draw the first deviations of the culprits in standard deviations, one bar a parameter."""
    rows = [
        (_label(each.path, name, value, sigma), value / sigma if sigma > 0.0 else 0.0)
        for each in found.culprits
        for name, (value, sigma) in each.deviations.items()
    ][:MOST_BARS]
    ax.barh(range(len(rows)), [z for _, z in rows], 0.5, color=COLOURS[0])
    reach = max([SIGMAS, *(1.05 * abs(z) for _, z in rows)])
    ax.set_xlim(-reach, reach)
    ax.set_ylim(-0.6, len(rows) - 0.4)
    ax.set_yticks(range(len(rows)), [text for text, _ in rows], fontsize=7)
    ax.axvline(0.0, color=INK, lw=0.8)
    ax.invert_yaxis()
    ax.set_xlabel("deviation (sigma)")


def _label(path: str, name: str, value: float, sigma: float) -> str:
    set_by_hand = "" if sigma > 0.0 else f" set to {value:g} {DEVIATIONS.get(name, '')}".rstrip()
    return f"{path.removesuffix(f'.{name}')} {name}{set_by_hand}"


def draw_run(found: Blame, trace: Any, figure: Figure) -> None:
    """Draw a run as its system does, its die named without what was healed: the title around it says that."""
    scenario = trace.scenario
    plain = replace(scenario, die=replace(scenario.die, edits=()))
    found.case.system.draw(replace(trace, scenario=plain), figure)


def drawn(found: Blame, trace: Any) -> Any:
    """A run as its system draws it, as an image, float[height, width, 4]."""
    return _image(lambda figure: draw_run(found, trace, figure))


def _image(draw: Callable[[Figure], None]) -> Any:
    with matplotlib.rc_context(STYLE):
        figure = figures.Figure(figsize=(7.0, 4.5), dpi=110, layout="constrained")
        agg.FigureCanvasAgg(figure)
        draw(figure)
        settle(figure)
        data = io.BytesIO()
        figure.savefig(data, format="png")
        data.seek(0)
        return images.imread(data)
