"""Agreement of the solver with ngspice: every block cold, at room temperature and hot, and the whole chip.

Both engines get the same testbench and the same equations, and both are converged; ngspice is shown to be so
by halving its tolerances (`netlists.ngspice.agreement` states the rules). Stimuli are scaled to the delay at
each temperature. No value is fitted, and the paper has none.

The chip is the ranging chip with its bias chain inside, 566 transistors fully coupled on both sides. ngspice
runs it with trapezoidal integration from the solver's rest state; the operating point that is compared is the
one that it finds without that start. The last rows are the solver's alone: by how much the fully coupled chip
differs from its separately stepped neurons (`chips.ranging.coupling`), against the figures of
docs/evidence/cheely2003.md.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from importlib.metadata import version
from itertools import product
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure

from chips.ranging.coupling import Coupling, measure_coupling
from circuits.registry import block_names, load_block
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.ngspice import engine
from netlists.ngspice.agreement import CONVERGED, SOLVER_RTOL, USUAL, Agreement, compare
from netlists.ngspice.form import AS_IT_STANDS, Form, delay_ratio, scaled_testbench, started
from netlists.registry import DEFAULT_RELTOL, POINTS
from system.experiment import Experiment, Progress, Report, with_progress
from system.options.block import block_of_target
from system.papers.checks.chip_coupling import coupling_note, coupling_rows
from system.plot import COLOURS, INK, PALE
from system.rule import Rule, within
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution

TEMPERATURES = (-20.0, 27.0, 85.0)  # degC
DRAWN = ("rebound-neuron", 27.0)
# what is smaller than it stands, where ngspice takes more than ten minutes: 16 cells, or many spikes
FORMS = {"winner-take-all-ring": Form({"cells": 4}), "adaptive-neuron": Form(kind="ideal", stop=7e-3)}
CHIP, COUPLING = "ranging-chip-biased", "coupling"
CHIP_TEMPERATURES = (27.0,)  # degC; ngspice takes 11 minutes of CPU time
CHIP_RELTOL, CHIP_POINTS = 5e-5, 1800  # where ngspice begins, trapezoidal; at twice both it is not converged


class Case(NamedTuple):
    """What is compared: a block or the chip, or `COUPLING`, at a temperature in degC."""

    circuit: str
    temperature_c: float


@dataclass(frozen=True, slots=True)
class Compared:
    """What is kept of an agreement, by its names there.

    watched: whether events are watched; spike_time: s, None where one engine has more spikes; node: that
    which differs most, by node_rms, V; moved_spike: by how much halving moves a spike of ngspice, s, None
    where it changes their number; moved_rms: by how much it moves a node, V; tmax: s; spikes: how many.
    """

    watched: bool
    spike_time: float | None
    spike_allowance: float
    node: str
    node_rms: float
    operating_point: float
    excluded: float
    converged: bool
    moved_spike: float | None
    moved_rms: float
    reltol: float
    tmax: float
    spikes: int


@dataclass(frozen=True, slots=True)
class Found:
    """A comparison, or the coupling; the other is None."""

    compared: Compared | None = None
    coupling: Coupling | None = None


def run(progress: Progress, execution: Execution = ALONE, cases: Sequence[Case] | None = None) -> Report:
    """Compare every registered block at every temperature, then the chip, then its coupling."""
    asked = all_cases() if cases is None else cases
    numbers = (version("noctule"), SOLVER_RTOL, DEFAULT_RELTOL, POINTS, CHIP_RELTOL, CHIP_POINTS)
    campaign = Campaign(EXPERIMENT.name, measure, Case, Found, numbers)
    with closing(execution.results(campaign, asked)) as results:
        found = [(case, next(results)) for case in with_progress(asked, progress)]
    compared = [(case, each.compared) for case, each in found if each.compared is not None]
    coupled = [each.coupling for _, each in found if each.coupling is not None]
    rows = [row for case, each in compared for row in _rows(case, each)]
    rows += [row for coupling in coupled for row in coupling_rows(coupling)]
    notes = (*(_note(*each) for each in compared), *(coupling_note(coupling) for coupling in coupled))
    return Report(tuple(rows), lambda figure: draw_beside(compare_block(*DRAWN), "v_mem", figure), notes)


def all_cases() -> list[Case]:
    """Every block at every temperature, the chip, and its coupling."""
    blocks = [Case(*each) for each in product(block_names(), TEMPERATURES)]
    return [
        *blocks,
        *(Case(CHIP, t) for t in CHIP_TEMPERATURES),
        Case(COUPLING, Silicon(AMI_1500_IDEAL).temperature_c),
    ]


def measure(case: Case) -> Found:
    """Compare once, or measure the coupling."""
    if case.circuit == COUPLING:
        return Found(coupling=measure_coupling(Silicon(AMI_1500_IDEAL, temperature_c=case.temperature_c)))
    if case.circuit == CHIP:
        return Found(kept(compare_chip(Silicon(block_of_target(CHIP).process, case.temperature_c))))
    return Found(kept(compare_block(*case)))


def compare_block(block: str, temperature_c: float) -> Agreement:
    """Compare a block in both engines at a temperature in degC."""
    silicon = Silicon(block_of_target(block).process, temperature_c)
    return compare(scaled_testbench(load_block(block), silicon, FORMS.get(block, AS_IT_STANDS)), silicon)


def kept(agreement: Agreement) -> Compared:
    """Keep what rows and notes tell."""
    apart, halved = agreement.difference, agreement.convergence
    return Compared(
        bool(agreement.solver.spikes), apart.spike_time if apart.same_count else None, apart.spike_allowance,
        apart.worst_node, apart.worst_rms, apart.operating_point, apart.excluded, agreement.converged,
        halved.spike_time if halved.same_count else None, halved.worst_rms, agreement.reltol, agreement.tmax,
        agreement.spike_count,
    )  # fmt: skip


def compare_chip(silicon: Silicon, stop: float | None = None) -> Agreement:
    """Compare the fully coupled chip in both engines; `stop` (s) ends the run earlier."""
    bench = chip_testbench(silicon)
    bench = bench if stop is None else replace(bench, stop=stop)
    own = engine.operating_point(bench, silicon)
    found = compare(started(bench, silicon), silicon, reltol=CHIP_RELTOL, points=CHIP_POINTS, method="trap")
    ours = found.solver.operating_point
    apart = max(abs(v - ours[node]) for node, v in own.items())
    return replace(found, difference=replace(found.difference, operating_point=apart))


def chip_testbench(silicon: Silicon) -> Testbench:
    """Give the chip a call and an echo, with delay and length in the ratio of a neuron's delays."""
    chip = block_of_target(CHIP)
    circuit, v_dd = chip.build(), silicon.process.v_dd
    stimuli = chip.defaults
    ratio = delay_ratio(load_block("rebound-neuron"), silicon)
    usual = chip.testbench(circuit, stimuli, v_dd).stop
    stimuli |= {"delay": ratio * (stimuli["delay"] or 0.0), "duration": ratio * usual}
    return chip.testbench(circuit, stimuli, v_dd)


def _rows(case: Case, found: Compared) -> list[Statement]:
    """Statements about one block at one temperature; none agrees unless ngspice is converged."""
    name = f"{case.circuit.replace('-', '_')}_at_{case.temperature_c:g}_degC".replace("-", "minus_")
    node = within(USUAL.node_rms, "worst node within {milli:g} mV rms of ngspice", of=0.0)
    point = within(USUAL.operating_point, "worst node within {milli:g} mV of ngspice", of=0.0)
    rows: list[tuple[str, float | None, Rule]] = [
        ("node_rms_V", found.node_rms, node),
        ("operating_point_V", found.operating_point, point),
    ]
    if found.watched:
        allowed = f"{1e6 * USUAL.spike_time:g} us + {100 * USUAL.spike_share:g} %"
        text = f"as many spikes, worst within {{micro:.3g}} us ({allowed}) of ngspice"
        rows.insert(0, ("spike_time_s", found.spike_time, within(found.spike_allowance, text, of=0.0)))
    return [
        Statement(f"{name}_{what}", None, ours, rule.unless(not found.converged, "ngspice is not converged"))
        for what, ours, rule in rows
    ]


def _note(case: Case, found: Compared) -> str:
    state = "converged" if found.converged else "not converged"
    moved = math.inf if found.moved_spike is None else found.moved_spike
    return (
        f"{case.circuit} at {case.temperature_c:g} degC: {found.spikes} spikes; worst node {found.node};"
        f" {100 * found.excluded:.1f} % of the time left out around edges; ngspice {state} at reltol"
        f" {found.reltol:g}, steps to {1e6 * found.tmax:.3g} us: halving moves spikes by"
        f" {1e6 * moved:.2g} us and nodes by {1e3 * found.moved_rms:.2g} mV rms"
        f" (at most {100 * CONVERGED:g} % of what is allowed)."
    )


def draw_beside(agreement: Agreement, node: str, figure: Figure) -> None:
    """Fill `figure` with a node's voltage in both engines and, below, their difference in mV."""
    figure.set_size_inches(7.0, 4.5)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    ours, peer = agreement.solver, agreement.ngspice
    above.plot(1e3 * peer.time, peer[node], color=PALE, linewidth=4.0, label="ngspice")
    above.plot(1e3 * ours.time, ours[node], color=COLOURS[0], linewidth=1.2, label="solver")
    above.set_ylabel(f"{node} (V)")
    above.legend(loc="upper right")
    above.set_title(f"{agreement.name} at {agreement.temperature_c:g} °C")
    time = np.union1d(ours.time, peer.time)
    apart = np.interp(time, ours.time, ours[node]) - np.interp(time, peer.time, peer[node])
    limit = 3e3 * USUAL.node_rms
    below.plot(1e3 * time, 1e3 * apart, color=INK, linewidth=0.8)
    below.axhspan(-1e3 * USUAL.node_rms, 1e3 * USUAL.node_rms, color=PALE, alpha=0.4, linewidth=0.0)
    below.annotate(
        f"band: {1e3 * USUAL.node_rms:g} mV; edges exceed the axis",
        (0.01, 0.04),
        xycoords="axes fraction",
        fontsize=7,
    )
    below.set(
        ylim=(-limit, limit),
        ylabel="difference (mV)",
        xlabel="time (ms)",
        xlim=(0.0, 1e3 * float(ours.time[-1])),
    )
    figure.align_ylabels([above, below])


EXPERIMENT = Experiment(
    "agreement", "solver against ngspice: every block at three temperatures, and the ranging chip",
    run, {},
)  # fmt: skip
