"""Agreement of the solver with ngspice: every block cold, at room temperature and hot, and the whole chip.

Both engines get the same testbench and the same equations, and both are converged; ngspice is shown to be so
by halving its tolerances (`netlists.ngspice.agreement` states the rules). Stimuli are scaled to the delay at
each temperature. No value is fitted, and the paper has none.

The chip is the ranging chip with its bias chain inside, 566 transistors fully coupled on both sides. ngspice
runs it with trapezoidal integration from the solver's rest state; the operating point that is compared is the
one that it finds without that start. The last rows are the solver's alone: by how much the fully coupled chip
differs from its separately stepped neurons (`chips.ranging.coupling`), against the figures of
docs/circuits.md.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
from matplotlib.figure import Figure

from chips.ranging.coupling import measure_coupling
from circuits.registry import block_names, load_block
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.ngspice import engine
from netlists.ngspice.agreement import (
    CONVERGED,
    NODE_RMS,
    OPERATING_POINT,
    SPIKE_SHARE,
    SPIKE_TIME,
    Agreement,
    compare,
    delay_ratio,
    started,
)
from system.experiment import Experiment, Progress, Report
from system.options.block import block_named
from system.papers.checks.chip_coupling import coupling_note, coupling_rows
from system.plot import COLOURS, INK, PALE
from system.rule import Rule, within
from system.statement import Statement

TEMPERATURES = (-20.0, 27.0, 85.0)  # degC
DRAWN = ("rebound-neuron", 27.0)
CHIP = "ranging-chip-biased"
CHIP_TEMPERATURES = (27.0,)  # degC; ngspice takes 11 minutes of CPU time
CHIP_RELTOL, CHIP_POINTS = 5e-5, 1800  # where ngspice begins, trapezoidal; at twice both it is not converged


def run(progress: Progress) -> Report:
    """Compare every registered block at every temperature, then the chip, then its coupling."""
    cases = [*product(block_names(), TEMPERATURES), *((CHIP, t) for t in CHIP_TEMPERATURES)]
    found: dict[tuple[str, float], Agreement] = {}
    for k, (block, temperature) in enumerate(cases):
        silicon = Silicon(block_named(block).process, temperature)
        found[block, temperature] = (
            compare_chip(silicon) if block == CHIP else compare(load_block(block), silicon)
        )
        progress((k + 1) / (len(cases) + 1))
    coupling = measure_coupling(Silicon())
    progress(1.0)
    rows = tuple(row for (block, _), agreement in found.items() for row in _rows(block, agreement))
    notes = tuple(_note(block, agreement) for (block, _), agreement in found.items())
    return Report(
        (*rows, *coupling_rows(coupling)),
        lambda figure: draw_beside(found[DRAWN], "v_mem", figure),
        (*notes, coupling_note(coupling)),
    )


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
    chip = block_named(CHIP)
    circuit, v_dd = chip.build(chip.params()), silicon.process.v_dd
    stimuli: dict[str, float | None] = {s.name: s.default for s in chip.stimuli}
    ratio = delay_ratio(load_block("rebound-neuron"), silicon)
    usual = chip.testbench(circuit, stimuli, v_dd).stop
    stimuli |= {"delay": ratio * (stimuli["delay"] or 0.0), "duration": ratio * usual}
    return chip.testbench(circuit, stimuli, v_dd)


def _rows(block: str, agreement: Agreement) -> list[Statement]:
    """Statements about one block at one temperature; none agrees unless ngspice is converged."""
    apart, far = agreement.difference, not agreement.converged
    name = f"{block.replace('-', '_')}_at_{agreement.temperature_c:g}_degC".replace("-", "minus_")
    node = within(NODE_RMS, "worst node within {milli:g} mV rms of ngspice", of=0.0)
    point = within(OPERATING_POINT, "worst node within {milli:g} mV of ngspice", of=0.0)
    rows: list[tuple[str, float | None, Rule]] = [
        ("node_rms_V", apart.worst_rms, node),
        ("operating_point_V", apart.operating_point, point),
    ]
    if agreement.solver.spikes:
        allowed = f"{1e6 * SPIKE_TIME:g} us + {100 * SPIKE_SHARE:g} %"
        text = f"as many spikes, worst within {{micro:.3g}} us ({allowed}) of ngspice"
        late = apart.spike_time if apart.same_count else None
        rows.insert(0, ("spike_time_s", late, within(apart.spike_allowance, text, of=0.0)))
    return [
        Statement(f"{name}_{what}", None, ours, rule.unless(far, "ngspice is not converged"))
        for what, ours, rule in rows
    ]


def _note(block: str, agreement: Agreement) -> str:
    halved, apart = agreement.convergence, agreement.difference
    state = "converged" if agreement.converged else "not converged"
    spikes = sum(times.size for times in agreement.solver.spikes.values())
    return (
        f"{block} at {agreement.temperature_c:g} degC: {spikes} spikes; worst node {apart.worst_node};"
        f" {100 * apart.excluded:.1f} % of the time left out around edges; ngspice {state} at reltol"
        f" {agreement.reltol:g}, steps to {1e6 * agreement.tmax:.3g} us: halving moves spikes by"
        f" {1e6 * halved.spike_time:.2g} us and nodes by {1e3 * halved.worst_rms:.2g} mV rms"
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
    limit = 3e3 * NODE_RMS
    below.plot(1e3 * time, 1e3 * apart, color=INK, linewidth=0.8)
    below.axhspan(-1e3 * NODE_RMS, 1e3 * NODE_RMS, color=PALE, alpha=0.4, linewidth=0.0)
    below.annotate(
        f"band: {1e3 * NODE_RMS:g} mV; edges exceed the axis",
        (0.01, 0.04),
        xycoords="axes fraction",
        fontsize=7,
    )
    below.set_ylim(-limit, limit)
    below.set_ylabel("difference (mV)")
    below.set_xlabel("time (ms)")
    below.set_xlim(0.0, 1e3 * float(ours.time[-1]))
    figure.align_ylabels([above, below])


EXPERIMENT = Experiment(
    name="agreement",
    summary="the solver against ngspice: every block at -20, 27 and 85 degC, and the whole ranging chip",
    run=run,
)
