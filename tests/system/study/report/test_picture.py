"""Pictures of a study: scales that fit a metric, limits and means by name, whole numbers as such."""

from __future__ import annotations

import numpy as np
import pytest

from circuits.arrays import F64
from system.study.report.picture import draw_study, is_log_normal, normal_quantiles
from system.study.specification import Limits
from system.study.table import Table
from system.study.target import Quantity
from tests.pictures import figure_of_files, leaving, legend_of

RANDOM = np.random.default_rng(5)
DELAYS = 6e-3 * np.exp(0.6 * RANDOM.standard_normal(200))
COUNTS = RANDOM.integers(0, 4, 200).astype(np.float64)


def table(values: F64) -> Table:
    n = len(values)
    return Table(
        ("it",), np.arange(1000, 1000 + n), ("random",) * n, np.full(n, 27.0), np.zeros(n, np.int64),
        ("works",) * n, ("",) * n, np.asarray(values)[:, None],
    )  # fmt: skip


@pytest.mark.parametrize(
    ("values", "told"),
    [
        (DELAYS, True),
        (6e-3 + 1e-3 * RANDOM.standard_normal(200), False),  # within a factor of two or so, and normal
        (DELAYS - DELAYS.mean(), False),  # some below 0
        (1.0 + COUNTS**4, False),  # whole
        (DELAYS[:2], False),
    ],
)
def test_what_is_log_normal(values: F64, told: bool) -> None:
    assert is_log_normal(values) is told


def test_a_log_normal_metric_has_a_logarithmic_axis_and_its_unit() -> None:
    figure = figure_of_files()
    limits = Limits("it", 3e-3, 9e-3, "s")
    draw_study(table(DELAYS), [Quantity("it", "s")], [limits], figure, "rebound-neuron at 27 °C")
    outcomes, ax = figure.axes
    assert outcomes.get_title() == "rebound-neuron at 27 °C"
    assert ax.get_xscale() == "log"
    assert sum(bar.get_height() for bar in ax.patches) == len(DELAYS)  # the least and the largest too
    mean = f"mean {1e3 * DELAYS.mean():.2f} ms"
    assert legend_of(figure) == {mean, "at least 3.00 ms", "at most 9.00 ms"}
    assert leaving(figure) == []
    ticks = [t.get_text() for t in ax.get_xticklabels() if t.get_text()]
    assert "5 ms" in ticks
    quantiles = figure_of_files().subplots()
    normal_quantiles(table(DELAYS), Quantity("it", "s"), quantiles)
    assert quantiles.get_yscale() == "log"
    line = np.log(np.asarray(quantiles.lines[1].get_ydata()))
    z = np.asarray(quantiles.lines[1].get_xdata())
    assert np.diff(line)[0] / np.diff(z)[0] == pytest.approx(np.log(DELAYS).std(ddof=1))


def test_whole_numbers_have_a_bar_and_a_tick_each() -> None:
    figure = figure_of_files()
    draw_study(table(COUNTS), [Quantity("it", "")], [], figure)
    ax = figure.axes[1]
    assert [bar.get_height() for bar in ax.patches] == [int((k == COUNTS).sum()) for k in range(4)]
    figure.draw_without_rendering()
    ticks = [float(t.get_text().replace("\N{MINUS SIGN}", "-")) for t in ax.get_xticklabels() if t.get_text()]
    assert ticks
    assert all(tick == round(tick) for tick in ticks)


def test_one_whole_number_has_one_tick() -> None:
    figure = figure_of_files()
    draw_study(table(np.ones(5)), [Quantity("it", "")], [], figure)
    figure.draw_without_rendering()
    ax = figure.axes[1]
    low, high = ax.get_xlim()
    assert [tick for tick in ax.get_xticks() if low <= tick <= high] == [1.0]


def test_equal_values_have_one_bar_about_them() -> None:
    figure = figure_of_files()
    draw_study(table(np.full(5, 1.04e-6)), [Quantity("it", "s")], [], figure)
    (bar,) = figure.axes[1].patches
    assert (bar.get_x(), bar.get_width()) == pytest.approx((0.988e-6, 0.104e-6))
