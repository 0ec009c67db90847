"""Agreement of the solver with ngspice: every block, cold, at room temperature and hot.

Both engines get the same testbench and the same equations, and both are converged; ngspice is shown to be so
by halving its tolerances (`netlists.agreement` states the rules). Stimuli are scaled to the delay at each
temperature. No value is fitted, and the paper has none.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from matplotlib.figure import Figure

from circuits.registry import block_names, load_block
from circuits.silicon import Silicon
from netlists.agreement import (
    CONVERGED,
    NODE_RMS,
    OPERATING_POINT,
    SPIKE_SHARE,
    SPIKE_TIME,
    Agreement,
    compare,
)
from system.experiment import Experiment, Progress, Report, Row
from system.plot import COLOURS, INK, PALE

TEMPERATURES = (-20.0, 27.0, 85.0)  # degC
DRAWN = ("rebound-neuron", 27.0)


def run(progress: Progress) -> Report:
    """Compare every registered block at every temperature."""
    cases = list(product(block_names(), TEMPERATURES))
    found: dict[tuple[str, float], Agreement] = {}
    for k, (block, temperature) in enumerate(cases):
        found[block, temperature] = compare(load_block(block), Silicon(temperature_c=temperature))
        progress((k + 1) / len(cases))
    rows = tuple(row for (block, _), agreement in found.items() for row in _rows(block, agreement))
    notes = tuple(_note(block, agreement) for (block, _), agreement in found.items())
    return Report(rows, lambda figure: draw_beside(found[DRAWN], "v_mem", figure), notes)


def _rows(block: str, agreement: Agreement) -> list[Row]:
    """Statements about one block at one temperature; none agrees unless ngspice is converged."""
    apart, converged = agreement.difference, agreement.converged
    name = f"{block.replace('-', '_')}_at_{agreement.temperature_c:g}_degC".replace("-", "minus_")
    rows = [
        Row(f"{name}_{what}", None, value, rule, allowed, fitted=False, agrees=converged and value <= allowed)
        for what, value, rule, allowed in (
            (
                "node_rms_V",
                apart.worst_rms,
                f"worst node within {1e3 * NODE_RMS:g} mV rms of ngspice",
                NODE_RMS,
            ),
            (
                "operating_point_V",
                apart.operating_point,
                f"worst node within {1e3 * OPERATING_POINT:g} mV of ngspice",
                OPERATING_POINT,
            ),
        )
    ]
    if agreement.solver.spikes:
        rule = f"as many spikes, worst within {1e6 * SPIKE_TIME:g} us + {100 * SPIKE_SHARE:g} % of ngspice"
        late = apart.spike_time if apart.same_count else None
        agrees = converged and apart.same_count and apart.spike_time <= apart.spike_allowance
        rows.insert(
            0,
            Row(f"{name}_spike_time_s", None, late, rule, apart.spike_allowance, fitted=False, agrees=agrees),
        )
    return rows


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
    summary="the solver against ngspice: every block at -20, 27 and 85 degC",
    run=run,
)
