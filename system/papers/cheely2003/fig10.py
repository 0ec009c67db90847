"""Figure 10 of Cheely & Horiuchi 2003: amplitude and rate of the vocalization against the proximity voltage.

The transistors of the vocalization controller are simulated at constant proximity voltages over the used
range, which is that of the look-up table. Both laws are compared with their straight lines by least squares;
the largest departure counts, as a share of full scale, which is the span of the quantity over the used range
(stricter than its largest value).

A voltage stands for the range, or echo delay, that the linear look-up assigns to it. The caption asks that an
echo from there has returned before the next call; the board's values were chosen so that even the farthest
look-up entry's has (its docstring), which makes the two interval rows fitted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from chips.ranging.circuit import BEST_DELAYS
from circuits.arrays import F64
from circuits.blocks.sonar import centroid_board, vocalization_controller
from circuits.errors import SolverError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from system.experiment import Experiment, Progress, Report, with_progress
from system.plot import COLOURS, INK, PALE
from system.rule import above, at_most, below
from system.statement import Statement

POINTS = 15
RTOL = 1e-5
LINEAR = 0.02  # of full scale


@dataclass(frozen=True, slots=True)
class Laws:
    """Both laws, at every proximity voltage (V) an entry.

    `rate` is the call rate (Hz), `amplitude` the amplitude (V), `delay` the echo delay that the
    voltage stands for (s); all are float64[points].
    """

    proximity: F64
    rate: F64
    amplitude: F64
    delay: F64


def run(progress: Progress) -> Report:
    """Measure both laws at 15 voltages."""
    return run_on_grid(progress, POINTS)


def run_on_grid(progress: Progress, points: int) -> Report:
    """Measure both laws at `points` voltages over the used range."""
    table = centroid_board.linear_lookup()
    proximity = np.linspace(table[-1], table[0], points)
    measured = np.zeros((points, 2))
    for k, v in with_progress(list(enumerate(proximity.tolist())), progress):
        measured[k] = _measure(v)
    delay = np.interp(proximity, table[::-1], BEST_DELAYS[::-1])
    laws = Laws(proximity, measured[:, 0], measured[:, 1], delay)
    note = (
        f"Rate {laws.rate[0]:.3g} to {laws.rate[-1]:.3g} Hz, amplitude {laws.amplitude[0]:.3g} to"
        f" {laws.amplitude[-1]:.3g} V over {table[-1]:g} to {table[0]:g} V; the board's values are ours."
    )
    return Report(_rows(laws), lambda figure: _draw(laws, figure), (note,))


def _measure(proximity: float) -> tuple[float, float]:
    """Call rate (Hz) and amplitude (V) at a proximity voltage (V)."""
    circuit = vocalization_controller.build()
    stimuli = {"proximity": proximity, "amplitude_control": None, "duration": None}
    bench = vocalization_controller.testbench(circuit, stimuli, Silicon(AMI_1500_IDEAL).process.v_dd)
    found = vocalization_controller.measures(simulate(bench, Silicon(AMI_1500_IDEAL), rtol=RTOL))
    rate, amplitude = found["call_rate_Hz"], found["amplitude_V"]
    if rate is None or amplitude is None:
        raise SolverError(f"proximity: {proximity:g} V, fewer than two calls; lengthen the run")
    return rate, amplitude


def _rows(laws: Laws) -> tuple[Statement, ...]:
    rise, fall = float(np.diff(laws.rate).min()), float(np.diff(laws.amplitude).max())
    interval = 1.0 / laws.rate
    shortest, margin = float(interval.min()), float((interval - laws.delay).min())
    longest = BEST_DELAYS[-1]
    return (
        _linear_row("rate_departure_from_line", laws.proximity, laws.rate),
        _linear_row("amplitude_departure_from_line", laws.proximity, laws.amplitude),
        Statement("smallest_step_of_rate_Hz", "rises", rise, above(0.0, "above {limit:g} at every step")),
        Statement("largest_step_of_amplitude_V", "falls", fall, below(0.0, "below {limit:g} at every step")),
        Statement(
            "smallest_interval_less_echo_delay_s",
            "above 0",
            margin,
            above(0.0, "above {limit:g} at every proximity voltage"),
            fitted=True,
        ),
        Statement(
            "shortest_interval_s",
            longest,
            shortest,
            above(text="longer than the longest best delay"),
            fitted=True,
        ),
    )


def _linear_row(name: str, x: F64, y: F64) -> Statement:
    departure = float(np.abs(y - np.polyval(np.polyfit(x, y, 1), x)).max() / np.ptp(y))
    return Statement(name, 0.0, departure, at_most(LINEAR, "at most {percent:g} % of full scale"))


def _draw(laws: Laws, figure: Figure) -> None:
    """(a) amplitude, (b) rate with the least that an echo needs."""
    figure.set_size_inches(7.5, 3.4)
    left, right = figure.subplots(1, 2, sharex=True)
    for ax, values, colour in ((left, laws.amplitude, COLOURS[0]), (right, laws.rate, COLOURS[1])):
        line = np.polyval(np.polyfit(laws.proximity, values, 1), laws.proximity)
        ax.plot(laws.proximity, line, color=INK, linewidth=0.8, label="straight line")
        ax.plot(laws.proximity, values, color=colour, marker="o", markersize=4, linestyle="", label="circuit")
        ax.set(xlabel="proximity voltage (V)", xlim=(0.0, 3.2))
    left.set(ylabel="vocalization amplitude (V)", ylim=(0.0, 5.0))
    left.set_title("(a)", fontsize=9, loc="left")
    left.legend(loc="upper right", fontsize=8)
    right.fill_between(laws.proximity, 1.0 / laws.delay, 1e3, color=PALE, alpha=0.4, linewidth=0.0)
    told = "next call before the echo:\nrate above 1 / echo delay"
    right.annotate(told, (0.09, 0.95), xycoords="axes fraction", va="top", fontsize=8)
    right.legend(loc="lower right", fontsize=8)
    right.set(ylabel="vocalization rate (Hz)", ylim=(0.0, 70.0))
    right.set_title("(b)", fontsize=9, loc="left")


EXPERIMENT = Experiment(
    "cheely2003-fig10", "rate and amplitude of the vocalization against proximity voltage", run
)
