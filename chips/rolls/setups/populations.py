"""Experiments with a calibrated ROLLS chip: eight populations at three rates, and a neural field.

Every number is ours. Populations: 16 neurons each, driven by 250 events/s through a synapse of level 1, 2 or
3, so that three biases set three target rates at once; `NPA_WEIGHT_EXC` those of level 1, and with it
`..EXC0` and `..EXC1` those of levels 2 and 3. Field: 128 neurons on virtual synapses, with `neural_field`
between them; its calibration brings 16 groups of eight to one rate without recurrence.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from chips.rolls.calibration import Calibration, Knob, Target, Task, code_for, neuron_rates
from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.program.address import NEURONS, NONPLASTIC, VIRTUAL_EXCITATORY
from chips.rolls.program.bias_file import BiasTable, default_biases
from chips.rolls.program.population import Population, neural_field
from chips.rolls.program.program import Program, VirtualInput
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.silicon.silicon import Silicon

POPULATIONS, SIZE = 8, 16
RATES = (20.0, 50.0, 100.0)  # Hz, of levels 1, 2, 3; the populations take them in turn
EVENTS = 250.0  # Hz, to every neuron
SOURCE = 248  # presynaptic neuron of level 1; the next two have levels 2 and 3
_LEVEL_BIASES = ("NPA_WEIGHT_EXC_P", "NPA_WEIGHT_EXC0_P", "NPA_WEIGHT_EXC1_P")
_FAST = (7, 150)  # code of a filter's leak and gain: 8.8 pA, 4.5 ms
QUIET = {"IF_DC_P": (7, 0)} | dict.fromkeys(
    (f"{name}_P" for name in ("NPDPIE_TAU", "NPDPIE_THR", "VDPIE_TAU", "VDPIE_THR")), _FAST
)
"""Codes, by bias, under which no neuron fires by itself and the filters of the inputs are fast."""


def table(codes: dict[str, tuple[int, int]], currents: dict[str, float]) -> BiasTable:
    """Return the control software's biases with other codes.

    Parameters
    ----------
    codes
        Code (coarse, fine) by the name of a bias.
    currents
        Current by the name of a bias, A, in the place of a code.
    """
    found = default_biases()
    for name, code in (codes | {name: code_for(i) for name, i in currents.items()}).items():
        found = found.with_code(name, *code)
    return found


def populations_task() -> Task:
    """Return the task of eight populations that are to fire at 20, 50 and 100 Hz."""
    levels = np.zeros((NEURONS, NEURONS), dtype=np.int8)
    targets: list[Target] = []
    names: tuple[list[str], ...] = ([], [], [])
    for k in range(POPULATIONS):
        which = k % len(RATES)
        group = Population(f"p{k}", tuple(range(SIZE * k, SIZE * (k + 1))))
        levels[list(group.neurons), SOURCE + which] = which + 1
        targets.append(Target(group, RATES[which]))
        names[which].append(group.name)
    biases = table(QUIET, dict(zip(_LEVEL_BIASES, (10e-9, 3e-9, 8e-9), strict=True)))
    knobs = tuple(Knob(bias, tuple(each)) for bias, each in zip(_LEVEL_BIASES, names, strict=True))
    return Task(Program(levels, biases), tuple(targets), knobs, populations_drive)


def populations_drive(duration: float, phase: float = 0.0) -> Inputs:
    """Return regular events to every neuron's source, beginning `phase` s late."""
    times = np.arange(1e-3 + phase, duration, 1.0 / EVENTS)
    neurons = np.arange(POPULATIONS * SIZE)
    columns = NONPLASTIC + SOURCE + (neurons // SIZE) % len(RATES)
    return Inputs(np.repeat(times, neurons.size), np.tile(neurons, times.size), np.tile(columns, times.size))


def population_errors(
    task: Task, found: Calibration, silicon: Silicon, kind: BiasKind, duration: float = 2.0
) -> dict[str, float]:
    """Return the mean rate over its target, less one, by population, of a calibrated chip on a silicon.

    It is another run than the calibration's: twice as long, with events at another phase.
    """
    chip = RollsChip(replace(task.program, biases=found.biases), silicon, kind)
    rates = neuron_rates(chip, lambda d: populations_drive(d, 1.7e-3), duration)
    return {
        t.population.name: float(np.mean(rates[list(found.kept(t.population))])) / t.rate - 1.0
        for t in task.targets
    }


FIELD = 128
GROUP = 8  # neurons that are calibrated together, two of which may be dropped
FIELD_RATE, FIELD_EVENTS = 50.0, 600.0  # Hz, of the calibration without recurrence
NEAR, FAR = (1, 1, 1, 1, 1, 1, 1), -1
CENTRES, WIDTH = (32, 96), 8.0  # neurons: of the two inputs, and their Gaussian's sigma
STRONGER = 1.2
FIELD_RUN, FIELD_LATE = 1.5, 1.0  # s: of a run, and from when on it is judged
_FIELD_CODES = QUIET | {"NPDPII_TAU_P": (7, 10), "NPDPII_THR_P": (7, 10)}
_FIELD_CURRENTS = {
    "NPA_WEIGHT_EXC_P": 8e-9, "NPA_WEIGHT_EXC0_P": 4e-9, "NPA_WEIGHT_EXC1_P": 4e-9,
    "NPA_WEIGHT_INH_N": 6e-9, "NPA_WEIGHT_INH0_N": 6e-9, "NPA_WEIGHT_INH1_N": 6e-9, "VA_EXC_N": 3e-9,
}  # fmt: skip


def field_task() -> Task:
    """Return the task of the field without recurrent synapses: 16 groups that are to fire at one rate."""
    groups = [Population(f"g{k}", tuple(range(GROUP * k, GROUP * (k + 1)))) for k in range(FIELD // GROUP)]
    program = Program(
        np.zeros((NEURONS, NEURONS), dtype=np.int8), table(_FIELD_CODES, _FIELD_CURRENTS),
        inputs=(VirtualInput("field", tuple(range(FIELD))),),
    )  # fmt: skip
    knob = Knob("VA_EXC_N", tuple(g.name for g in groups))
    rates = np.full(FIELD, FIELD_EVENTS)
    return Task(
        program, tuple(Target(g, FIELD_RATE) for g in groups), (knob,), lambda d: regular(rates, d), most=2
    )


def regular(rates: F64, duration: float) -> Inputs:
    """Return regular events to the first virtual synapse of neurons from 0 on; rates: Hz, a little apart."""
    found = [np.arange(1e-3 + k % 7 * 1e-3 / 7.0, duration, 1.0 / r) for k, r in enumerate(rates)]
    return _virtual(found)


def irregular(rates: F64, duration: float, seed: int) -> Inputs:
    """Return Poisson events likewise; each neuron's are drawn by themselves."""
    found = []
    for k, rate in enumerate(rates):
        draw = np.random.default_rng((seed, k))
        found.append(np.sort(draw.uniform(0.0, duration, draw.poisson(rate * duration))))
    return _virtual(found)


def _virtual(found: list[F64]) -> Inputs:
    times = np.concatenate(found)
    neurons = np.repeat(np.arange(len(found)), [t.size for t in found])
    order = np.argsort(times, kind="stable")
    return Inputs(times[order], neurons[order], np.full(times.size, VIRTUAL_EXCITATORY))


def field_chip(found: Calibration, silicon: Silicon, kind: BiasKind) -> RollsChip:
    """Return the calibrated field with its recurrent synapses; dropped neurons have none."""
    levels = np.zeros((NEURONS, NEURONS), dtype=np.int8)
    field = Population("field", tuple(range(FIELD)))
    levels[:FIELD, :FIELD] = neural_field(field, NEAR, FAR).levels
    dropped = [k for gone in found.blacklist.values() for k in gone]
    levels[dropped], levels[:, dropped] = 0, 0
    program = Program(levels, found.biases, inputs=(VirtualInput("field", tuple(range(FIELD))),))
    return RollsChip(program, silicon, kind)


@dataclass(frozen=True, slots=True)
class Bump:
    """Rates of the field late in a run, Hz, float64[128], and mean rates near the inputs and elsewhere."""

    rates: F64
    stronger: float
    weaker: float
    elsewhere: float

    @property
    def right(self) -> bool:
        """Whether there is one bump, at the stronger input: elsewhere at most a tenth of its rate."""
        return self.stronger > 5.0 and max(self.weaker, self.elsewhere) < 0.1 * self.stronger


def field_bump(found: Calibration, silicon: Silicon, kind: BiasKind, side: int, seed: int) -> Bump:
    """Run the field with two inputs, of which that at CENTRES[side] is 20 % stronger."""
    place = np.arange(FIELD)
    near = [np.exp(-0.5 * ((place - c) / WIDTH) ** 2) for c in CENTRES]
    strength = np.where(np.arange(2) == side, STRONGER, 1.0)
    rates = FIELD_EVENTS * (strength[:, None] * np.array(near)).sum(axis=0)
    chip = field_chip(found, silicon, kind)
    rates[[k for gone in found.blacklist.values() for k in gone]] = 0.0
    spikes, _ = chip.run(chip.at_rest(), FIELD_RUN, irregular(rates, FIELD_RUN, seed))
    late = spikes.neurons[spikes.times >= FIELD_LATE]
    answer = np.bincount(late, minlength=NEURONS)[:FIELD] / (FIELD_RUN - FIELD_LATE)
    inside = [np.abs(place - c) <= 2.0 * WIDTH for c in CENTRES]
    means = [float(answer[i].mean()) for i in inside]
    elsewhere = float(answer[~(inside[0] | inside[1])].mean())
    return Bump(answer, means[side], means[1 - side], elsewhere)
