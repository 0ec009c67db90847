"""Figure 4 of Cheely & Horiuchi 2003: a rebound neuron's answer to an echo before, after and at best delay.

The paper shows call, echo, V_mem and output of one neuron for (a) a shorter, (b) a longer and (c) a
facilitative delay and gives no numbers; the delays 3, 9 and 6.4 ms are ours, for neuron 2 of the array
(best delay 6.33 ms). The neuron's transistors are simulated with each of these delays, with the call alone
and with the echo alone. Its spikes are compared with the paper's traces, and so is V_mem while it is
inhibited, when an echo comes meanwhile, and after the inhibition. Runs are at rtol 1e-6, so that two of them
can be compared to well below 1 mV.

Inhibition lasts from the end of the call's pulse to the fall of the inhibition's gate through half the
supply. What the biases were chosen for proves nothing and is marked as fitted: that the neuron fires at
6.4 ms (I_inh_tau), that it rebounds, and that neither the rebound nor the echo alone reaches the threshold.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from circuits.arrays import F64
from circuits.blocks.sonar import rebound_neuron
from circuits.event import LENGTH
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from system.experiment import Experiment, Progress, Report, with_progress
from system.plot import COLOURS, INK, PALE
from system.rule import above, as_many, below
from system.statement import Statement

RTOL = 1e-6
DURATION = 17e-3  # s
PULSE_END = rebound_neuron.CALL_TIME + LENGTH  # s, of the call
GROUNDED = 0.1  # V, ours: V_mem below it is held at ground
MOVED = 1e-3  # V, ours: an echo that moves V_mem by less is suppressed
DIP = 1e-6  # s, left out before the release: both runs' release lies within the solver's error of spike times


@dataclass(frozen=True, slots=True)
class Case:
    """One stimulus: echo `delay` after the call (s), and the spikes that the paper's neuron gives."""

    name: str
    title: str
    delay: float
    spikes: int
    fitted: bool
    off: str | None = None


SHORTER = Case("shorter", "(a) shorter delay", 3e-3, 0, fitted=False)
LONGER = Case("longer", "(b) longer delay", 9e-3, 0, fitted=False)
FACILITATIVE = Case("facilitative", "(c) facilitative delay", 6.4e-3, 1, fitted=True)
CALL_ALONE = Case("call_alone", "call alone", 3e-3, 0, fitted=True, off="echo")
ECHO_ALONE = Case("echo_alone", "echo alone", 3e-3, 0, fitted=True, off="call")
SHOWN = (SHORTER, LONGER, FACILITATIVE)
CASES = (*SHOWN, CALL_ALONE, ECHO_ALONE)


def run(progress: Progress) -> Report:
    """Simulate the five cases and compare them with the paper's."""
    results: dict[str, Result] = {}
    for case in with_progress(CASES, progress):
        results[case.name] = _simulate(case)
    rows = (*(_spike_row(case, results[case.name]) for case in CASES), *_membrane_rows(results))
    echo = results[ECHO_ALONE.name]
    reach = float((echo["v_mem"] - echo["v_mem"][0]).max())
    notes = (
        f"An echo without a call moves V_mem by {1e3 * reach:.1f} mV; during inhibition it is suppressed.",
        "Delays are ours; the paper gives none for this figure.",
    )
    return Report(rows, lambda figure: _draw(results, figure), notes)


def _simulate(case: Case) -> Result:
    stimuli: dict[str, float | None] = {"delay": case.delay, "call": 1.0, "echo": 1.0, "duration": DURATION}
    if case.off is not None:
        stimuli[case.off] = None
    circuit = rebound_neuron.build()
    bench = rebound_neuron.testbench(circuit, stimuli, AMI_1500_IDEAL.v_dd)
    return simulate(bench, Silicon(AMI_1500_IDEAL), rtol=RTOL)


def _spike_row(case: Case, result: Result) -> Statement:
    count = int(result.spikes["spike"].size)
    return Statement(f"spikes_{case.name}", case.spikes, count, as_many(), case.fitted)


def _membrane_rows(results: dict[str, Result]) -> tuple[Statement, ...]:
    held = max(_held(results[case.name]) for case in SHOWN)
    moved = _moved(results[SHORTER.name], results[CALL_ALONE.name])
    rest = float(results[CALL_ALONE.name].operating_point["v_rest"])
    peak = rebound_neuron.measures(results[CALL_ALONE.name])["v_mem_peak_V"] or 0.0
    return (
        Statement("v_mem_during_inhibition_V", 0.0, held, below(GROUNDED, "below {limit:g} V")),
        Statement(
            "v_mem_moved_by_echo_at_3_ms_V",
            None,
            moved,
            below(MOVED, "less than {limit:g} V before the release"),
        ),
        Statement("v_mem_peak_after_release_V", rest, peak, above(text="above V_rest"), fitted=True),
    )


def _held(result: Result) -> float:
    """Largest V_mem during inhibition, V."""
    inside = (result.time >= PULSE_END) & (result.time <= _release(result))
    return float(result["v_mem"][inside].max())


def _moved(with_echo: Result, without: Result) -> float:
    """Largest difference of V_mem between two runs from the echo to the first release of the two, V."""
    end = min(_release(with_echo), _release(without)) - DIP
    time = np.union1d(with_echo.time, without.time)
    time = time[(time >= rebound_neuron.CALL_TIME + SHORTER.delay) & (time <= end)]
    first, second = (np.interp(time, r.time, r["v_mem"]) for r in (with_echo, without))
    return float(np.abs(first - second).max())


def _release(result: Result) -> float:
    inhibition = rebound_neuron.measures(result)["t_inh_s"] or 0.0
    return rebound_neuron.CALL_TIME + inhibition


TRACES = (("call", "call"), ("echo", "echo"), ("v_mem", "$V_{mem}$"), ("spike", "out"))


def _draw(results: dict[str, Result], figure: Figure) -> None:
    """Three columns of four traces over one time axis, as in the paper."""
    figure.set_size_inches(8.0, 4.6)
    grid = figure.subplots(
        len(TRACES), len(SHOWN), sharex=True, sharey="row", gridspec_kw={"height_ratios": (1, 1, 2.6, 1)}
    )
    for column, case in enumerate(SHOWN):
        grid[0, column].set_title(f"{case.title}, {1e3 * case.delay:g} ms", fontsize=9, loc="left")
        for row, (node, label) in enumerate(TRACES):
            ax = grid[row, column]
            _draw_trace(results[case.name], node, ax)
            if column == 0:
                ax.set_ylabel(f"{label} (V)")
        grid[-1, column].set_xlabel("time (ms)")
    _draw_levels(results[SHORTER.name], grid[2])
    figure.align_ylabels(grid[:, 0])


def _draw_trace(result: Result, node: str, ax: Axes) -> None:
    analog = node == "v_mem"
    colour = COLOURS[0] if analog else COLOURS[1] if node == "spike" else INK
    ax.plot(1e3 * result.time, result[node], color=colour, linewidth=1.2 if analog else 1.0)
    ax.set(xlim=(0.0, 1e3 * DURATION), xticks=range(0, 17, 4))
    if analog:
        ax.set(ylim=(-0.15, 3.0), yticks=(0, 1, 2, 3))
    else:
        ax.set(ylim=(-0.6, 5.8), yticks=(0, 5))


def _draw_levels(result: Result, panels: F64) -> None:
    """Threshold and resting potential, dashed behind V_mem."""
    for node, label in (("v_th", "$V_{th}$"), ("v_rest", "$V_{rest}$")):
        level = float(result.operating_point[node])
        for ax in panels:
            ax.axhline(level, color=PALE, linewidth=0.8, linestyle="--", zorder=0)
        panels[-1].annotate(
            label,
            (1.0, level),
            xycoords=("axes fraction", "data"),
            xytext=(3, 0),
            textcoords="offset points",
            va="center",
            fontsize=8,
        )


EXPERIMENT = Experiment("cheely2003-fig4", "rebound neuron: delay shorter, longer, and facilitative", run)
