"""Figure 9 of Cheely & Horiuchi 2003: centroid voltage against target distance, with a linear look-up.

Two chips of 13 neurons are simulated at transistor level, and how well the centroid's voltage tells the
distance is compared with the paper's words about near and far targets. In one chip I_inh_tau is linear in the
index, as the paper's chip has it; in the other it falls as 1/delay ("reciprocal"), which makes the best
delays near-linear. For delays over the span of the look-up (2 to 28 ms) each neuron gets a call and an echo.
Its spikes drive the centroid board for 20 calls at 30 Hz, the controller's highest rate, after which it is
settled to 10 uV; the proximity voltage is its mean over the last interval. Where no neuron fires the board
goes to its far default, 0 V: such gaps are counted, and belong to the curve.

Errors are means of absolute values over the near and the far half of the range (the middle counts as near):

- `near_line`: voltage against the straight line by least squares through the near half. It is the measure of
  the paper's statement, "works well for closer ranges, but loses accuracy at distant ranges": the line is the
  reading of the distance that works for closer ranges, and what is asked is how it does beyond.
- `near_line_answered`: the same with line and means over the delays at which a neuron fires, gaps left out.
- `end_line`: voltage against the line through the first and the last entry at the first and the last best
  delay, that is "a linear set of BDs" taken literally. With linear currents this must contradict the paper's
  statement: 10 of the 13 best delays lie below 5 ms, so that already there the voltage has fallen to the
  entries that the line assigns to 20 ms and more, while far away even the far default is nearer to the line.
- `whole_line`: voltage against the line by least squares through all points; no expectation, for the notes.
- `ambiguity`: distance from the median of all distances at which the same neurons fire, which no other
  look-up could repair. It must be larger in the far half where two neurons serve it, and gaps.

Each with linear currents, and with the others beside, which must do better far away by the first measure and
stay within one step of the look-up by the second wherever a neuron fires.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from chips.ranging import circuit as ranging_chip
from circuits.arrays import F64, Bools
from circuits.bias import rebias
from circuits.blocks.sonar import centroid_board, rebound_neuron
from circuits.circuit import Circuit
from circuits.devices.source import Polyline, polyline
from circuits.event import pulse
from circuits.lowering.kernel import to_kernel
from circuits.silicon.process import AMI_1500_IDEAL, kelvin
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import Runner
from system.experiment import Experiment, Progress, Report, part, with_progress
from system.plot import COLOURS, INK, PALE
from system.rule import above, below, within
from system.statement import Statement
from system.worlds.sound.acoustics import speed_of_sound

Spikes = tuple[tuple[float, int], ...]  # (s after the call, neuron)

STEP = 0.5e-3  # s, between delays
CALL_RATE = 30.0  # Hz
CALLS = 20
AFTER_ECHO = 5e-3  # s, how long a neuron is watched after its echo
FIRST_CALL = 1e-3  # s
MEASURES = ("near_line", "near_line_answered", "end_line", "whole_line", "ambiguity")
NAMES = ("linear", "reciprocal")
LESS_FAR = "loses accuracy far away"


@dataclass(frozen=True, slots=True)
class Curve:
    """One chip: delay (s), distance (m) and proximity (V), float64[T], and the spikes at each delay."""

    delay: F64
    distance: F64
    proximity: F64
    spikes: tuple[Spikes, ...]

    @property
    def fired(self) -> tuple[frozenset[int], ...]:
        """Neurons that fire at each delay."""
        return tuple(frozenset(k for _, k in spikes) for spikes in self.spikes)

    @property
    def silent(self) -> Bools:
        """Where no neuron fires, bool[T]."""
        return np.array([not fired for fired in self.fired])

    @property
    def near(self) -> Bools:
        """The near half, bool[T]."""
        middle = 0.5 * (ranging_chip.BEST_DELAYS[0] + ranging_chip.BEST_DELAYS[-1])
        return self.delay < middle + 1e-9


def run(progress: Progress) -> Report:
    """Measure both chips at delays in steps of 0.5 ms."""
    return run_on_grid(progress, STEP)


def run_on_grid(progress: Progress, step: float) -> Report:
    """Measure both chips at delays in steps of `step` s."""
    first, last = ranging_chip.BEST_DELAYS[0], ranging_chip.BEST_DELAYS[-1]
    delays = np.linspace(first, last, round((last - first) / step) + 1)
    chip = ranging_chip.build()
    fast = rebias(chip, {"i_inh_tau": ranging_chip.linear_currents()})
    linear = _curve(fast, delays, part(progress, 0.0, 0.5))
    reciprocal = _curve(chip, delays, part(progress, 0.5, 1.0))
    curves = dict(zip(NAMES, (linear, reciprocal), strict=True))
    return Report(_rows(linear, reciprocal), lambda figure: _draw(curves, figure), _notes(curves))


def _curve(chip: Circuit, delays: F64, progress: Progress) -> Curve:
    trains: list[list[tuple[float, int]]] = [[] for _ in delays]
    for k in with_progress(range(ranging_chip.NEURONS), part(progress, 0.0, 0.7)):
        for train, times in zip(trains, _neuron_spikes(chip, k, delays), strict=True):
            train += [(time, k) for time in times]
    spikes = tuple(tuple(sorted(train)) for train in trains)
    proximity = _proximity(spikes)
    progress(1.0)
    speed = speed_of_sound(kelvin(Silicon(AMI_1500_IDEAL).temperature_c))
    return Curve(delays, 0.5 * speed * delays, proximity, spikes)


def _neuron_spikes(chip: Circuit, k: int, delays: F64) -> list[list[float]]:
    """Spikes of neuron `k` after the call, s, for an echo at each of `delays`."""
    neuron = rebias(rebound_neuron.build(), ranging_chip.neuron_biases(chip, k))
    v_dd = Silicon(AMI_1500_IDEAL).process.v_dd
    stimuli: dict[str, float | None] = {"delay": 0.0, "call": 1.0, "echo": None, "duration": None}
    machine = to_kernel(rebound_neuron.testbench(neuron, stimuli, v_dd), Silicon(AMI_1500_IDEAL))
    runner, rest = Runner(machine), operating_point(machine)
    found = []
    for delay in delays:
        echo = rebound_neuron.CALL_TIME + float(delay)
        line = polyline("echo", pulse((echo,), v_dd))
        _, segment = runner.advance(
            runner.begin(rest), echo + AFTER_ECHO, {"echo": line}, stop_at_event=False
        )
        found.append([time - rebound_neuron.CALL_TIME for _, time in segment.spikes])
    return found


def _proximity(trains: tuple[Spikes, ...]) -> F64:
    """Settled proximity voltage (V) of the board for each train of spikes that follows every call."""
    v_dd = Silicon(AMI_1500_IDEAL).process.v_dd
    stop = FIRST_CALL + CALLS / CALL_RATE
    stimuli: dict[str, float | None] = {"neuron": 0.0, "second": None, "rate": None, "duration": stop}
    machine = to_kernel(
        centroid_board.testbench(centroid_board.build(), stimuli, v_dd), Silicon(AMI_1500_IDEAL)
    )
    runner, rest = Runner(machine, ("proximity",)), operating_point(machine)
    settled = []
    for spikes in trains:
        state, _ = runner.advance(
            runner.begin(rest), stop - 1.0 / CALL_RATE, _lines(spikes, v_dd), stop_at_event=False
        )
        start = float(state.voltage[0][machine.column_of("proximity")])
        _, last = runner.advance(state, stop, stop_at_event=False)
        time = np.concatenate([[state.now], last.time])
        voltage = np.concatenate([[start], last.voltage[:, 0]])
        settled.append(float(np.trapezoid(voltage, time)) * CALL_RATE)
    return np.array(settled)


def _lines(spikes: Spikes, v_dd: float) -> dict[str, Polyline]:
    """The board's inputs while `spikes` follow every call."""
    calls = [FIRST_CALL + n / CALL_RATE for n in range(CALLS)]
    lines = {}
    for k in range(ranging_chip.NEURONS):
        times = tuple(call + time for call in calls for time, neuron in spikes if neuron == k)
        lines[f"spike[{k}]"] = polyline(f"spike[{k}]", pulse(times, v_dd))
    return lines


def _end_line(curve: Curve) -> F64:
    """Voltage that the look-up is meant to give at each distance, V."""
    table, delays = centroid_board.linear_lookup(), ranging_chip.BEST_DELAYS
    return np.asarray(
        table[0] + (table[-1] - table[0]) * (curve.delay - delays[0]) / (delays[-1] - delays[0])
    )


def _fitted_line(curve: Curve, inside: Bools) -> F64:
    """Least-squares line through the points inside, at every distance, V."""
    return np.asarray(
        np.polyval(np.polyfit(curve.distance[inside], curve.proximity[inside], 1), curve.distance)
    )


def _errors(curve: Curve, measure: str) -> F64:
    """Absolute errors, V (ambiguity: m), float64[T]; NaN where a measure leaves a delay out."""
    if measure == "ambiguity":
        return _ambiguity(curve)
    if measure == "near_line_answered":
        line = _fitted_line(curve, curve.near & ~curve.silent)
        return np.where(curve.silent, np.nan, np.abs(curve.proximity - line))
    lines = {
        "near_line": lambda: _fitted_line(curve, curve.near),
        "end_line": lambda: _end_line(curve),
        "whole_line": lambda: _fitted_line(curve, np.ones(curve.delay.size, dtype=np.bool_)),
    }
    return np.abs(curve.proximity - lines[measure]())


def _ambiguity(curve: Curve) -> F64:
    error = np.zeros(curve.delay.size)
    for group in set(curve.fired):
        here = np.array([fired == group for fired in curve.fired])
        error[here] = np.abs(curve.distance[here] - np.median(curve.distance[here]))
    return error


def _halves(curve: Curve, measure: str) -> tuple[float, float]:
    """Mean absolute error of the near and of the far half, V (ambiguity: m)."""
    error = _errors(curve, measure)
    return float(np.nanmean(error[curve.near])), float(np.nanmean(error[~curve.near]))


def _ratio(curve: Curve, measure: str) -> float:
    near, far = _halves(curve, measure)
    return far / near


def _rows(linear: Curve, reciprocal: Curve) -> tuple[Statement, ...]:
    ratio = {measure: _ratio(linear, measure) for measure in MEASURES}
    beside = _halves(linear, "near_line")[1] / _halves(reciprocal, "near_line")[1]
    step = -float(np.diff(centroid_board.linear_lookup()).mean())
    answered = float(_errors(reciprocal, "end_line")[~reciprocal.silent].max())
    return (
        _above_one("linear_near_line_far_over_near", LESS_FAR, ratio["near_line"]),
        _above_one("linear_near_line_answered_far_over_near", LESS_FAR, ratio["near_line_answered"]),
        _above_one("linear_ambiguity_far_over_near", LESS_FAR, ratio["ambiguity"]),
        Statement(
            "linear_end_line_far_over_near",
            None,
            ratio["end_line"],
            below(1.0, "below {limit:g}: it fails nearby, where delays bunch"),
        ),
        _above_one("far_near_line_linear_over_reciprocal", None, beside),
        Statement(
            "reciprocal_end_line_largest_V",
            None,
            answered,
            within(step, "within a look-up step, {limit:.3g} V, where a neuron fires", of=0.0),
            fitted=True,
        ),
        Statement(
            "linear_silent_delays",
            None,
            int(linear.silent.sum()),
            above(int(reciprocal.silent.sum()), "more than with reciprocal currents ({limit:g})"),
        ),
    )


def _above_one(name: str, paper: str | None, ours: float) -> Statement:
    return Statement(name, paper, ours, above(1.0))


def _notes(curves: dict[str, Curve]) -> tuple[str, ...]:
    worse_near = [measure for measure in MEASURES if _ratio(curves["linear"], measure) < 1.0]
    beside = [f"{_ratio(curves['reciprocal'], measure):.3g} by {measure}" for measure in MEASURES[:2]]
    caution = (
        "A curve tends to do worse beyond the half that its line was fitted to: with reciprocal currents the"
        f" ratio is {' and '.join(beside)}, to be read beside the linear currents'."
    )
    return (
        "The paper's statement is the row linear_near_line_far_over_near; its text gives no numbers.",
        caution,
        f"By {' and '.join(worse_near)} the near half of the linear currents is the worse one.",
        *(note for name, curve in curves.items() for note in _curve_notes(name, curve)),
    )


def _curve_notes(name: str, curve: Curve) -> tuple[str, ...]:
    errors = []
    for measure in MEASURES:
        near, far = _halves(curve, measure)
        unit = "m" if measure == "ambiguity" else "V"
        errors.append(f"{measure} {near:.3g} and {far:.3g} {unit}")
    silent, inside = curve.silent, curve.near
    gaps = [f"{int((silent & half).sum())} of {int(half.sum())}" for half in (inside, ~inside)]
    return (
        f"{name} currents, mean absolute error of near and far half: {'; '.join(errors)}.",
        f"{name} currents, delays at which no neuron fires (far default): {gaps[0]} near, {gaps[1]} far.",
        f"{name} currents, distances (m) at which each neuron fires: {_coverage(curve)}.",
    )


def _coverage(curve: Curve) -> str:
    spans = []
    for k in range(ranging_chip.NEURONS):
        here = curve.distance[[k in fired for fired in curve.fired]]
        spans.append(f"{k}: {here.min():.2f} to {here.max():.2f}" if here.size else f"{k}: none")
    return ", ".join(spans)


TITLES = {"linear": "(a) currents linear in the index", "reciprocal": "(b) currents as 1/delay"}


def _draw(curves: dict[str, Curve], figure: Figure) -> None:
    """Voltage against distance for both chips, above the neurons that fire."""
    figure.set_size_inches(8.0, 5.4)
    axes = figure.subplots(2, 2, sharex=True, sharey="row", gridspec_kw={"height_ratios": (2.2, 1)})
    for column, (name, curve) in enumerate(curves.items()):
        axes[0, column].set_title(TITLES[name], fontsize=9, loc="left")
        _draw_voltage(curve, axes[0, column])
        _draw_neurons(curve, axes[1, column])
    axes[0, 0].set_ylabel("proximity voltage (V)")
    axes[1, 0].set_ylabel("neuron that fires")
    figure.legend(*axes[0, 1].get_legend_handles_labels(), loc="outside upper center", ncols=3, fontsize=8)
    figure.align_ylabels(axes[:, 0])


def _draw_voltage(curve: Curve, ax: Axes) -> None:
    silent, near = curve.silent, curve.near
    ax.axvspan(0.0, float(curve.distance[near][-1]), color=PALE, alpha=0.2, linewidth=0.0)
    ax.plot(
        curve.distance,
        _end_line(curve),
        color=INK,
        linewidth=0.9,
        linestyle="--",
        label="line of first and last entry",
    )
    ax.plot(
        curve.distance,
        _fitted_line(curve, near),
        color=COLOURS[1],
        linewidth=1.0,
        label="line fitted to the near half",
    )
    answered = _fitted_line(curve, near & ~silent)
    ax.plot(curve.distance, answered, color=COLOURS[2], linewidth=1.0, label="the same, gaps left out")
    ax.plot(
        curve.distance[~silent],
        curve.proximity[~silent],
        color=COLOURS[0],
        marker="o",
        markersize=3.5,
        linestyle="",
        label="circuit",
    )
    ax.plot(
        curve.distance[silent],
        curve.proximity[silent],
        color=COLOURS[0],
        marker="x",
        markersize=3.5,
        linestyle="",
        label="no neuron fires",
    )
    ax.set(ylim=(-0.3, 3.3), xlim=(0.0, 5.0))


def _draw_neurons(curve: Curve, ax: Axes) -> None:
    marks = [(d, k) for d, fired in zip(curve.distance, curve.fired, strict=True) for k in sorted(fired)]
    ax.plot(*np.array(marks).reshape(-1, 2).T, color=INK, marker="s", markersize=2.5, linestyle="")
    ax.set(ylim=(-1, ranging_chip.NEURONS), yticks=(0, 4, 8, 12), xlabel="target distance (m)")


EXPERIMENT = Experiment("cheely2003-fig9", "centroid voltage against target distance, linear look-up", run)
