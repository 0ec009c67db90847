"""Pictures of small signals and noise, also of nothing."""

import io

import numpy as np
import pytest
from matplotlib.figure import Figure

from circuits.solver.noise.analysis import Noise
from circuits.solver.small_signal import Response
from system.cli.small_signal_picture import draw_bode, draw_noise
from tests.pictures import figure_of_files, leaving, legend_of

F = np.geomspace(1.0, 1e4, 81)


def response(scale: float) -> Response:
    low_pass = scale / (1.0 + 1j * F / 100.0)
    return Response("a", "V/V", ("y", "z"), F, np.stack([low_pass, 0.0 * low_pass], axis=1))


def noise(scale: float) -> Noise:
    white = scale * np.stack([1.0 / (1.0 + F**2), 2.0 / (1.0 + F**2)], axis=1)
    return Noise("y", None, "V^2/Hz", ("m1", "m2"), F, white, white / F[:, None], None)


def test_a_bode_plot_has_decibels_and_degrees_of_what_moves() -> None:
    figure = Figure()
    draw_bode([("27 °C", response(10.0)), ("85 °C", response(20.0))], ("y", "z", "elsewhere"), figure)
    top, bottom = figure.axes
    assert len(top.lines) == len(bottom.lines) == 2
    assert top.lines[0].get_ydata()[0] == pytest.approx(20.0, abs=1e-3)
    assert bottom.lines[1].get_ydata()[-1] == pytest.approx(-np.degrees(np.arctan(100.0)))
    assert "2 runs" in top.get_title()


def test_a_noise_plot_has_parts_and_shares() -> None:
    figure = Figure()
    draw_noise([("27 °C", noise(1e-12))], figure)
    top, bottom = figure.axes
    assert len([line for line in top.lines if len(np.asarray(line.get_xdata()))]) == 3
    widths = [bar.get_width() for bar in bottom.patches]
    # parts and sum interpolate different powers of frequency between points
    assert sum(widths) == pytest.approx(100.0, rel=0.02)
    assert bottom.get_yticklabels()[0].get_text() == "m2"


def test_runs_have_a_colour_each_and_parts_have_dashes() -> None:
    figure = figure_of_files()
    runs = [(f"{t} °C, die nominal", noise(1e-12 * k)) for k, t in enumerate((0, 27, 60), 1)]
    draw_noise(runs, figure)
    assert {label for label, _ in runs} | {"all", "white", "flicker"} == legend_of(figure)
    top, bottom = figure.axes
    drawn = {line.get_label(): line.get_color() for line in top.lines if line.get_label() in dict(runs)}
    assert len(set(drawn.values())) == 3
    assert bottom.get_title() == "largest shares at 0 °C, die nominal"
    assert leaving(figure) == []


def test_nodes_and_runs_are_told_apart() -> None:
    figure = figure_of_files()
    runs = [("27 °C", response(10.0)), ("85 °C", response(20.0))]
    draw_bode(runs, ("y",), figure)
    assert legend_of(figure) == {"27 °C", "85 °C"}
    first, second = figure.axes[0].lines
    assert (first.get_color(), first.get_linestyle()) != (second.get_color(), second.get_linestyle())
    assert leaving(figure) == []


def test_nothing_can_be_drawn() -> None:
    bode, density = Figure(), Figure()
    draw_bode([("27 °C", response(0.0))], ("y",), bode)
    draw_noise([("27 °C", noise(0.0))], density)
    for figure in (bode, density):
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png")
        assert len(figure.axes) == 2
        assert buffer.getvalue().startswith(b"\x89PNG")
