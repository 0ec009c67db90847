"""The wavefront chip under the full law, held against its transistors on unseen dies.

No figure of a paper. Dies A/1000 to A/1019 with mismatch and process variation, at -10, 27 and 60 degC, with
fixed gates and with the bias generator: what the solver makes of axons of the chip at their places under the
full law of its process, and what the behavioural model does. Compared are

- the delays of the axons;
- contests: of two neighbouring axons of one code, which spike comes first. The model leaves one undecided
  whose ends are nearer than twice its record's own error, and the window of a cell's inputs;
- the jitter of an axon by its devices' noise, on the nominal die;
- whole waves over two by three cells, on four of the dies: when every cell fires.

The margins are those that every model of a chip is held to. No value is fitted.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.figure import Figure

from chips.noise import SiliconNoise
from chips.wavefront.chip import ChipCells, WavefrontChip
from chips.wavefront.model import axon_delays, cell_record, chip_model
from chips.wavefront.noise import axon_spread
from circuits.arrays import F64, I64
from circuits.bias import rebias
from circuits.blocks.wavefront import axon_delay
from circuits.blocks.wavefront.axon_linearity import delay_at, delay_machine
from circuits.blocks.wavefront.grid import CHIP, Params, build, firing_times, plan_testbench
from circuits.circuit import BiasKind
from circuits.lowering.kernel import to_kernel
from circuits.place import circuit_at
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.event_jitter import event_jitter
from circuits.solver.transient import simulate
from system.experiment import Experiment, Progress, Report
from system.papers.checks.beside import (
    ALIKE,
    KINDS,
    NEAR,
    TEMPERATURES,
    TIED,
    draw_errors,
    judged,
    largest_error,
    on_dies,
)
from system.rule import at_most
from system.statement import Statement

DIES = range(1000, 1020)
WAVE_DIES = DIES[:4]
CODES = (1, 1, 9, 9, 9, 31, 31, 31)  # of the axons of the chip's first row
SHAPE = (20, 20)
WAVE = np.array([[1, 2, 1], [1, 2, 1]])  # codes; two ways of one cost to the last column
NOISY_CODES = (1, 9)
NOISE_SHARE = 0.05  # margin; ours
SURE = 2.0  # errors of the record, of each delay, beyond which a contest is decided


@dataclass(frozen=True, slots=True)
class Axons:
    """Axons of one die: their delays by circuit and by model, s, and by how much a contest is sure, s."""

    kind: BiasKind
    temperature_c: float
    codes: I64
    circuit: F64
    model: F64
    sure: F64

    def contests(self) -> list[tuple[bool, bool]]:
        """Of neighbours of one code: whether the model decides, and whether it says what the circuit does."""
        found = []
        for k in np.flatnonzero(np.diff(self.codes) == 0):
            ours, theirs = self.model[k + 1] - self.model[k], self.circuit[k + 1] - self.circuit[k]
            found.append((bool(abs(ours) > self.sure[k]), bool(ours * theirs > 0.0)))
        return found


def axons_of(kind: BiasKind, silicon: Silicon, codes: Sequence[int] = CODES) -> Axons:
    """Return axons of the chip's first row on both levels."""
    given, chip = np.array(codes), rebias(CHIP.build(), kind=kind)
    model = chip_model(SHAPE, silicon.process, bias_kind=kind)
    whole = np.zeros(SHAPE, dtype=np.int64)
    whole[0, : given.size] = given
    delays = axon_delays(model, silicon, whole)[0, : given.size]
    solved = []
    for k, code in enumerate(codes):
        circuit, place = circuit_at(chip, (("axon", (0, k)),))
        solved.append(delay_at(delay_machine(circuit, replace(silicon, place=place)), code))
    sure = SURE * np.hypot(delays[1:], delays[:-1]) * model.record.errors["delay_rms_relative"]
    sure += float(cell_record(silicon.process)["window_s"].max())
    return Axons(kind, silicon.temperature_c, given, np.array(solved), delays, sure)


def wave_of(kind: BiasKind, silicon: Silicon) -> tuple[F64, F64]:
    """Return when the cells of a small grid fire after the first, s, by circuit and by model."""
    rows, columns = WAVE.shape
    chip = WavefrontChip(rows, columns, cells=ChipCells(silicon, kind))
    model = chip.plan(chip.program(WAVE), (0, 0)).arrivals
    circuit = rebias(build(Params(rows, columns)), kind=kind)
    stop = 1.2 * float(model.max()) + 100e-6
    times = firing_times(simulate(plan_testbench(circuit, WAVE, (0, 0), stop, silicon.process.v_dd), silicon))
    return times - times[0, 0], model


def jitter_of(code: int) -> tuple[float, float]:
    """Return the jitter of the nominal axon at a code by circuit and by model, s."""
    silicon, circuit = Silicon(AMI_1500), axon_delay.build()
    bench = axon_delay.testbench(circuit, {"code": float(code), "duration": None}, silicon.process.v_dd)
    found = event_jitter(to_kernel(bench, silicon), "delayed", rest=axon_delay.FIRE_TIME)
    model = chip_model((1,), silicon.process)
    delays = axon_delays(model, silicon, np.array([code]))
    ours = float(axon_spread(model, silicon, delays, SiliconNoise(0))[0])
    return float(np.sqrt(found.white.sum() + found.flicker.sum())), ours


def compare(dies: Iterable[int], progress: Progress = lambda _: None) -> list[Axons]:
    """Return axons of every die at every temperature with every kind of bias, under the full law."""
    return on_dies(lambda at: axons_of(at.kind, at.silicon), dies, progress)


def waves(dies: Iterable[int]) -> list[tuple[F64, F64]]:
    """Return waves on dies, each at every temperature with every kind of bias."""
    return [
        wave_of(kind, Silicon(AMI_1500, t, Die(number=n)))
        for n in dies
        for t in TEMPERATURES
        for kind in KINDS
    ]


def statements(
    found: list[Axons], jitter: list[tuple[float, float]], grids: list[tuple[F64, F64]]
) -> tuple[Statement, ...]:
    """Return how far the model is off, a row a margin."""
    contests = [c for axons in found for c in axons.contests()]
    decided = [same for sure, same in contests if sure]
    return judged(
        (
            ("delay_error_max", max(_largest(a.circuit, a.model) for a in found), NEAR),
            ("first_of_two_share", sum(decided) / len(decided), ALIKE),
            ("undecided_share", 1.0 - len(decided) / len(contests), TIED),
            ("jitter_error_max", max(abs(m / c - 1.0) for c, m in jitter), at_most(NOISE_SHARE)),
            ("wave_error_max", max(_largest(*grid) for grid in grids), NEAR),
        )
    )


def _largest(circuit: F64, model: F64) -> float:
    """Largest relative difference of times that are above 0."""
    later = circuit > 0.0
    return largest_error(circuit[later], model[later])


def run(progress: Progress) -> Report:
    """Compare both levels on all dies."""
    found = compare(DIES, lambda share: progress(0.5 * share))
    jitter, grids = [jitter_of(code) for code in NOISY_CODES], waves(WAVE_DIES)
    progress(1.0)
    return Report(statements(found, jitter, grids), lambda figure: draw(found, figure))


def draw(found: list[Axons], figure: Figure) -> None:
    """Draw the error of each delay over its length."""
    of_kind = {kind: [a for a in found if a.kind == kind] for kind in KINDS}
    draw_errors({kind: _joined(own) for kind, own in of_kind.items()}, figure, "delay")


def _joined(axons: list[Axons]) -> tuple[F64, F64]:
    """Delays of axons by circuit and by model, s."""
    return np.concatenate([a.circuit for a in axons]), np.concatenate([a.model for a in axons])


EXPERIMENT = Experiment("wavefront-law", "the wavefront chip under the full law against its transistors", run)
