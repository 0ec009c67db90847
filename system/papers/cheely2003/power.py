"""Power of the 13-neuron array with its bias chain (Cheely & Horiuchi 2003, "Biasing and power consumption").

The chip is solved fully coupled, chain included; power is what all sources deliver, supply and V_rest alike,
over one interval between calls after three others, by when every interval is the same. An echo comes 6.4 ms
after each call; three come at 4, 6.4 and 8.8 ms (ours). The paper's two figures, quiescent and at 50 Hz with
one echo, were used to choose I_cmp (500 nA) and I_lim (6.3 uA): these rows are fitted. The others are
predicted without refitting, and follow rules of ours:

- 10 Hz: not below the line through the two fitted figures. A call that comes before the longest inhibitions
  have ended buys less current than one that finds all neurons at rest.
- 100 Hz: between the figure at 50 Hz and that line, for the same reason.
- no echo and three echoes: within 1 % of one echo. The power is that of the inhibition that every call starts
  in all neurons; an echo starts currents of at most 1 nA and at most a few spikes.

Beside: the sum over neurons that are stepped separately, with the gate voltages of the chain at rest, plus
the chain (coupled, a call also kicks those gates through the overlap of mi5, and inhibition ends earlier);
and the chip with linear currents, whose inhibitions are shorter.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from chips.ranging import circuit as ranging_chip
from circuits.blocks.bias import chain as bias_chain
from circuits.circuit import Circuit
from circuits.devices import Source
from circuits.devices.source import Constant, Driven, Polyline, polyline
from circuits.event import pulse
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.solver.power import delivered_energy
from circuits.solver.transient import Result, Runner, Steps
from circuits.testbench import Testbench
from system.experiment import Experiment, Progress, Report, part, with_progress
from system.papers.cheely2003.fig6 import neurons
from system.plot import COLOURS, INK, sized_axes
from system.rule import Rule, between, within_share
from system.statement import Statement

QUIESCENT, AT_50_HZ = 33e-6, 550e-6  # W; the paper's
TOLERANCE = 0.1
ONE_ECHO = (6.4e-3,)  # s after the call; ours
THREE_ECHOES = (4e-3, 6.4e-3, 8.8e-3)  # s; ours
ECHO_TOLERANCE = 0.01  # ours
APART = 0.01  # ours: of separately stepped neurons from the coupled chip
SETTLING = 3  # calls before the interval that counts
REST = 1e-3  # s, of a run without stimuli
BEFORE = 1e-3  # s, the first call


@dataclass(frozen=True, slots=True)
class Case:
    """Calls at `rate` Hz (0: none), each with echoes at these delays (s)."""

    label: str
    rate: float
    echoes: tuple[float, ...] = ()


REST_CASE = Case("at rest", 0.0)
ONE_CASE = Case("50 Hz, one echo", 50.0, ONE_ECHO)
CASES = (
    REST_CASE,
    ONE_CASE,
    Case("10 Hz, one echo", 10.0, ONE_ECHO),
    Case("100 Hz, one echo", 100.0, ONE_ECHO),
    Case("50 Hz, no echo", 50.0),
    Case("50 Hz, three echoes", 50.0, THREE_ECHOES),
)


@dataclass(frozen=True, slots=True)
class Power:
    """Mean power of an interval, W: all of it, and the share that comes from V_rest."""

    total: float
    from_rest: float


def run(progress: Progress) -> Report:
    """Measure all cases with the reciprocal chain, and rest and 50 Hz with the linear one."""
    return run_cases(progress, CASES)


def run_cases(progress: Progress, cases: tuple[Case, ...]) -> Report:
    """Measure some cases only; the first two of `cases` must be those of the paper."""
    steps = len(cases) + 2
    chip = at_rest(ranging_chip.build_with_chain())
    found = {}
    for case in with_progress(cases, part(progress, 0.0, len(cases) / steps)):
        found[case.label] = interval_power(chip, case)
    apart = separate_power(bias_chain.RECIPROCAL, ONE_CASE)
    progress((len(cases) + 1) / steps)
    other = at_rest(ranging_chip.build_with_chain(ranging_chip.BiasedParams(chain=bias_chain.LINEAR)))
    linear = {case.label: interval_power(other, case) for case in (REST_CASE, ONE_CASE)}
    progress(1.0)
    rows = (*_rows(found), _separate_row(apart, found[ONE_CASE.label]))
    return Report(rows, lambda figure: _draw(found, linear, figure), _notes(found, linear))


def at_rest(circuit: Circuit) -> OperatingPoint:
    """Solve the operating point of a chip, a neuron or a chain, with its events driven from outside."""
    events = [p.name for p in circuit.ports if p.kind == "event" and p.direction == "in"]
    sources = (
        Source("vdd", "vdd", Constant(AMI_1500_IDEAL.v_dd)),
        *(Source(name, name, Driven(0.0)) for name in events),
    )
    bench = Testbench(circuit.name, circuit, sources, math.inf)
    return operating_point(to_kernel(bench, Silicon(AMI_1500_IDEAL)))


def interval_power(rest: OperatingPoint, case: Case) -> Power:
    """Measure the mean power from the last call to where the next one would come, or of a while at rest."""
    machine = rest.machine
    start = BEFORE + SETTLING / case.rate if case.rate else 0.0
    duration = 1.0 / case.rate if case.rate else REST
    settled, _ = Runner(machine).advance(
        Runner(machine).begin(rest), start, _lines(machine, case), stop_at_event=False
    )
    _, segment = Runner(machine, machine.names).advance(settled, start + duration, stop_at_event=False)
    first = settled.voltage[0][machine.column]
    result = Result(
        machine, segment.outcome, np.concatenate([[start], segment.time]),
        np.vstack([first, segment.voltage]), machine.names, {}, Steps(segment.time.size, 0, 0), rest,
    )  # fmt: skip
    energy = delivered_energy(result)
    return Power(sum(energy.values()) / duration, energy.get("v_rest", 0.0) / duration)


def separate_power(params: bias_chain.Params, case: Case) -> Power:
    """Add up the chain at rest and neurons that are stepped separately with its gate voltages at rest."""
    parts = [interval_power(at_rest(bias_chain.build(params)), REST_CASE)]
    parts += [interval_power(at_rest(neuron), case) for neuron in neurons(params)]
    return Power(sum(p.total for p in parts), sum(p.from_rest for p in parts))


def _lines(machine: Machine, case: Case) -> dict[str, Polyline]:
    """Calls and echoes of a case; none at rest."""
    if not case.rate:
        return {}
    v_dd = machine.silicon.process.v_dd
    calls = tuple(BEFORE + n / case.rate for n in range(SETTLING + 1))
    echoes = tuple(sorted(call + echo for call in calls for echo in case.echoes))
    return {name: polyline(name, pulse(times, v_dd)) for name, times in (("call", calls), ("echo", echoes))}


def _rows(found: dict[str, Power]) -> tuple[Statement, ...]:
    rest, one = found[REST_CASE.label].total, found[ONE_CASE.label].total
    rows = [_fitted("quiescent_power_W", QUIESCENT, rest), _fitted("power_50_Hz_one_echo_W", AT_50_HZ, one)]
    for case in CASES[2:]:
        if case.label not in found:
            continue
        ours = found[case.label].total
        name = f"power_{case.label.replace(', ', '_').replace(' ', '_')}_W"
        rows.append(Statement(name, None, ours, _prediction(case, rest, one)))
    return tuple(rows)


def _fitted(name: str, paper: float, ours: float) -> Statement:
    return Statement(name, paper, ours, within_share(TOLERANCE), fitted=True)


def _prediction(case: Case, rest: float, one: float) -> Rule:
    """Rule of a predicted case."""
    line = rest + (one - rest) * case.rate / ONE_CASE.rate
    if case.rate < ONE_CASE.rate:
        return between(line, one, "from the line through rest and 50 Hz, {low_micro:.1f} uW, to 50 Hz")
    if case.rate > ONE_CASE.rate:
        return between(one, line, "from 50 Hz to the line through rest and 50 Hz, {high_micro:.0f} uW")
    return within_share(ECHO_TOLERANCE, "within {percent:g} % of one echo", of=one)


def _separate_row(apart: Power, coupled: Power) -> Statement:
    text = "separately stepped neurons and chain within {percent:g} % of the coupled chip"
    return Statement(
        "separate_over_coupled", None, apart.total / coupled.total, within_share(APART, text, of=1.0)
    )


def _notes(found: dict[str, Power], linear: dict[str, Power]) -> tuple[str, ...]:
    shares = "; ".join(
        f"{label}: {1e6 * p.total:.1f} uW, of it {1e6 * abs(p.from_rest):.1f} uW from V_rest"
        for label, p in found.items()
    )
    rest, one = (1e6 * linear[case.label].total for case in (REST_CASE, ONE_CASE))
    other = (
        f"Currents linear in the index: {rest:.1f} uW at rest, {one:.1f} uW at 50 Hz with one echo, because"
        " most inhibitions last a few ms: the paper's figures were met with currents as 1/delay."
    )
    return (
        "Fitted: I_cmp 500 nA and I_lim 6.3 uA were chosen to meet 33 uW quiescent and 550 uW at 50 Hz.",
        "The paper gives nothing for the other rows; their rules are ours, written after their first values.",
        "Every case is the fully coupled chip with its bias chain, over one interval after three others.",
        f"Currents as 1/delay: {shares}.",
        other,
    )


def _draw(found: dict[str, Power], linear: dict[str, Power], figure: Figure) -> None:
    """A bar a case, by source; the paper's figures and the linear chain beside."""
    ax = sized_axes(figure, 7.5, 4.2)
    labels = list(found)
    place = np.arange(len(labels))
    rest = np.array([1e6 * found[label].from_rest for label in labels])
    supply = np.array([1e6 * found[label].total for label in labels]) - rest
    ax.bar(place, supply, 0.6, color=COLOURS[0], label="from the supply")
    ax.bar(place, rest, 0.6, bottom=supply, color=COLOURS[5], label="from V_rest")
    for k, total in enumerate(supply + rest):
        ax.annotate(f"{total:.0f}", (k, total + 8.0), ha="center", fontsize=8)
    paper = {REST_CASE.label: QUIESCENT, ONE_CASE.label: AT_50_HZ}
    beside = {label: power.total for label, power in linear.items()}
    for marks, shift, marker, colour, name in (
        (paper, -0.38, ">", INK, "paper (used in the fit)"),
        (beside, 0.38, "<", COLOURS[1], "chip with linear currents"),
    ):
        ax.plot(
            [labels.index(label) + shift for label in marks],
            [1e6 * value for value in marks.values()],
            color=colour, marker=marker, linestyle="", label=name,
        )  # fmt: skip
    ax.set_xticks(place, [label.replace(", ", "\n") for label in labels])
    ax.set_ylabel("power (µW)")
    ax.legend(loc="upper left", fontsize=8)


EXPERIMENT = Experiment("cheely2003-power", "power of the array with its bias chain", run)
