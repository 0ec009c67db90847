"""Rows of `chip-noise` about the noise of the selection, and about that of the isolation.

Of the selection is compared when the line of the winner of eight cells goes high, in the model and in
transients with the white noise of all devices, on a risk beside both rivals. The isolation's model has no
noise, because what its devices make is far below the model's own error. How its latch's delays scatter
(`circuits.solver.noise.event_jitter`, flicker included) is compared with the rms error of the delays in its
record, and by how much the voltage that it passes wanders in the mean over an excitation's pulse with the
largest error of its levels.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chips.boards.isolation.model import circuits as isolation_circuits
from chips.measured.table_record import tables_of
from chips.noise import SiliconNoise
from chips.selection.model import selection
from chips.selection.noise import noisy_decide, selection_noise
from circuits.arrays import F64
from circuits.blocks.selection.winner_take_all import RELEASE, STANDING, Params, build, decision_testbench
from circuits.blocks.sonar import first_target_isolation
from circuits.circuit import Port
from circuits.devices.noise import WHITE_ONLY
from circuits.event import WIDTH
from circuits.lowering.kernel import to_kernel
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.analysis import integrate_power, noise
from circuits.solver.noise.event_jitter import event_jitter
from circuits.solver.noise.transient import NoiseRun, map_trials
from circuits.solver.operating_point import OperatingPoint, operating_point
from system.papers.checks.jitter_beside import Beside, known
from system.rule import at_most
from system.statement import Statement

SEED = 1000
DRAWS = 4000  # of the model
SILICON = Silicon(AMI_1500_IDEAL)
CELLS, BEST, OTHERS, RISK = 8, 50e-9, 35e-9, 5e-9  # A
WINNER = 3  # the rival is its neighbour
SELECTIONS = ((0.1, 0.05e-6), (0.01, 0.2e-6))  # contrasts, and the grid of the noise (s)
NEGLIGIBLE = 0.1  # of a model's own error
EDGES = ("q", "open")  # nodes of the isolation's latch: a spike sets it, a call resets it
BAND = (1.0, 1e12, 300)  # Hz, Hz, points


def selection_beside(contrast: float, grid: float, trials: int) -> Beside:
    """Measure the time of a decision between two cells whose currents are a contrast apart."""
    excite, risk = rivals(contrast)
    params = Params(cells=CELLS)
    chip = selection(SILICON, params)
    own = selection_noise(chip, SILICON, SiliconNoise(SEED, flicker=WHITE_ONLY))
    scratch = np.zeros((4, CELLS))
    ours = np.array([noisy_decide(chip, own, k, excite, risk, scratch)[1] for k in range(DRAWS)])
    stop = RELEASE + 1.5 * float(ours.max())
    bench = decision_testbench(build(params), excite, risk, stop, AMI_1500_IDEAL.v_dd)
    port, run = f"line[{WINNER}]", NoiseRun(SEED, grid, WHITE_ONLY)
    found = map_trials(
        lambda r: float(r.spikes[port][0]), to_kernel(bench, SILICON), run, range(trials), 1, record=()
    )
    name = f"selection_contrast_{100.0 * contrast:g}_percent"
    return Beside(name, *known(np.array(found) - RELEASE), float(ours.std(ddof=1)))


def rivals(contrast: float) -> tuple[F64, F64]:
    """Give excitations and risks (A) of two best cells that see as many neighbours and risks."""
    excite, risk = np.full(CELLS, OTHERS), np.full(CELLS, STANDING)
    excite[WINNER], excite[WINNER + 1] = BEST, BEST * (1.0 - contrast)
    risk[WINNER - 1] = risk[WINNER + 2] = RISK
    return excite, risk


def isolation_rows() -> list[Statement]:
    """Compare the noise of the isolation with the error of its model, which has no noise."""
    errors = tables_of("first_target_isolation", isolation_circuits, AMI_1500_IDEAL).errors
    point = _isolation()
    found = {
        f"isolation_delay_{name}": event_jitter(point.machine, name, point=point).deviation
        / errors["change_rms_s"]
        for name in EDGES
    }
    found["isolation_level"] = level_wander(point) / errors["level_max_V"]
    rule = at_most(NEGLIGIBLE, "of the model's own error, at most {limit:g}, so that it has none")
    return [Statement(name, 0.0, share, rule) for name, share in found.items()]


def level_wander(point: OperatingPoint) -> float:
    """Give the deviation (V) of the mean over an excitation's pulse of what the open isolation passes."""
    frequency = np.geomspace(*BAND)
    density = noise(point, "v_ex_max", frequency).output
    return float(np.sqrt(integrate_power(frequency, density * np.sinc(frequency * WIDTH) ** 2)))


def _isolation() -> OperatingPoint:
    """At rest, the array open, with the latch's nodes watched."""
    circuit = first_target_isolation.build()
    ports = (*circuit.ports, *(Port(name, "event", "out") for name in EDGES))
    given = first_target_isolation.BLOCK.defaults
    bench = first_target_isolation.testbench(replace(circuit, ports=ports), given, AMI_1500_IDEAL.v_dd)
    machine = to_kernel(replace(bench, watch=EDGES), SILICON)
    return operating_point(machine, start=first_target_isolation.rest(AMI_1500_IDEAL.v_dd))
