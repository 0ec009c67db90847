"""Pictures of small signals and noise, also of nothing."""

import io

import numpy as np
import pytest
from matplotlib.figure import Figure

from circuits.solver.noise.analysis import Noise
from circuits.solver.small_signal import Response
from system.cli.small_signal_picture import draw_bode, draw_noise

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
    assert len(top.lines) == 3
    widths = [bar.get_width() for bar in bottom.patches]
    # parts and sum interpolate different powers of frequency between points
    assert sum(widths) == pytest.approx(100.0, rel=0.02)
    assert bottom.get_yticklabels()[0].get_text() == "m2"


def test_nothing_can_be_drawn() -> None:
    bode, density = Figure(), Figure()
    draw_bode([("27 °C", response(0.0))], ("y",), bode)
    draw_noise([("27 °C", noise(0.0))], density)
    for figure in (bode, density):
        buffer = io.BytesIO()
        figure.savefig(buffer, format="png")
        assert len(figure.axes) == 2
        assert buffer.getvalue().startswith(b"\x89PNG")
