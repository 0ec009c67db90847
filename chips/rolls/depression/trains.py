"""Trains of events, and a population, at depressed synapses of a ROLLS chip, beside its transistors.

A chip with a synapse of each level on one row gets trains of one rate until they have settled, or a step of
the rate; a population of one input level gets a step of the rate of its inputs. Numbers are ours; those of
the population were chosen on dies 3 to 8. Its synapses spend less and recover more slowly than with the
cell's own codes: weights follow a new rate f within 1 / (1 / tau + f d / U_T), which at 100 Hz is 17 ms with
those, less than a bin and hardly more than a neuron takes to answer, and 27 ms with these.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from chips.rolls.chip import Inputs, RollsChip
from chips.rolls.depression.layout import BuiltDepression
from chips.rolls.depression.program import STEP_BIAS, ShortTermDepression
from chips.rolls.depression.reference import Events, drawn, gates, simulated, stepped
from chips.rolls.program.address import NEURONS, NONPLASTIC
from chips.rolls.program.bias_file import default_biases
from chips.rolls.program.program import Program
from circuits.arrays import F64
from circuits.blocks.rolls.depressing_synapse import STEP
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

CHIP_STEP = 0.2e-3  # s: all intervals are whole numbers of it
SETTLED = 6.0  # time constants of a train
LEVELS = (1, 2, 3, 4)
ROW, COLUMNS = 5, (17, 18, 19, 20)  # of the levels
LOW, HIGH, AT, UNTIL = 10.0, 100.0, 0.2, 0.5  # Hz, Hz, s, s: of a rate step
SIZE, INPUTS = 64, tuple(range(200, 206))  # of the population
GAIN = {"NPDPIE_TAU_P": (6, 30), "NPDPIE_THR_P": (6, 110), STEP_BIAS: (5, 24)}
SLOW = (7, 14)  # code of the population's recovery: 0.1 s
BIN = 0.02  # s
TABLE = default_biases().with_code("IF_DC_P", 7, 0).with_code(STEP_BIAS, *STEP)


@dataclass(frozen=True, slots=True)
class Train:
    """Charges of the pulses over the first one, by level, of the circuit and of the chip.

    times: s, of level 1; resource: R that the last pulse of level 1 found in the circuit; closed: where the
    closed form has it, what is left of the train's beginning included; kappa: of the pFETs.
    """

    die: int
    temperature_c: float
    rate: float
    times: F64
    circuit: dict[int, F64]
    chip: dict[int, F64]
    resource: float
    closed: float
    kappa: float

    def settled_error(self) -> float:
        """Return the largest difference of the last pulses' shares."""
        return max(abs(float(self.chip[k][-1] - q[-1])) for k, q in self.circuit.items())

    def error(self) -> float:
        """Return the largest difference of all pulses' shares."""
        return max(float(np.abs(self.chip[k] - q).max()) for k, q in self.circuit.items())


@dataclass(frozen=True, slots=True)
class Response:
    """Rates of a population around a step, Hz, float64[bins], with depression and without.

    chip, circuit: spikes (s) of its first neurons, some by their transistors; spread: deviation of R over its
    mean at the end, over the population's synapses.
    """

    die: int
    depressed: F64
    plain: F64
    chip: tuple[F64, ...]
    circuit: tuple[F64, ...]
    spread: float


def chip_on(die: int, temperature_c: float = 27.0, kind: BiasKind = "ideal") -> RollsChip:
    """Return a chip on a die whose neuron ROW has a synapse of each level."""
    levels = np.zeros((NEURONS, NEURONS), np.int8)
    levels[ROW, list(COLUMNS)] = LEVELS
    program = Program(levels, TABLE, depression=ShortTermDepression())
    return RollsChip(program, Silicon(ROLLS_180_IDEAL, temperature_c, Die(number=die)), kind, step=CHIP_STEP)


def constants(chip: RollsChip) -> tuple[float, float]:
    """Return the step over U_T and the time constant (s) of the synapse of level 1.

    Raises `ParameterError` for a chip without depression.
    """
    built = _built(chip)
    first = built.tables.first[built.tables.slot[COLUMNS[0], ROW]]
    return float(built.step[first] / built.u_t), float(built.tau[first])


def _built(chip: RollsChip) -> BuiltDepression:
    built = chip.built().depression
    if built is None:
        raise ParameterError("program.depression: None, must be given; give the program one")
    return built


def train(chip: RollsChip, rate: float) -> Train:
    """Run trains of one rate (Hz) at levels 1 and 4 until they have settled, half an interval apart."""
    spent, tau = constants(chip)
    count = int(np.ceil(SETTLED / (1.0 / (rate * tau) + spent))) + 2
    half = CHIP_STEP * (round(1.0 / (rate * CHIP_STEP)) // 2)
    own = 5 * CHIP_STEP + np.arange(count) / rate
    return _beside(chip, {COLUMNS[0]: own, COLUMNS[-1]: own + half}, rate)


def rate_step(chip: RollsChip) -> Train:
    """Run a step of the rate from LOW to HIGH at AT, at all levels."""
    own = np.concatenate((np.arange(0.0, AT, 1.0 / LOW), np.arange(AT, UNTIL, 1.0 / HIGH)))
    return _beside(chip, {c: own + (5 + 10 * k) * CHIP_STEP for k, c in enumerate(COLUMNS)}, HIGH)


def _beside(chip: RollsChip, events: Events, rate: float) -> Train:
    cut, result = simulated(chip, ROW, events)
    theirs, ours, lifted = drawn(cut, result, events), stepped(chip, ROW, events), gates(cut, result, events)
    (spent, tau), first = constants(chip), COLUMNS[0]
    gone, kept = np.exp(-1.0 / (rate * tau)), np.exp(-spent)
    settled = (1.0 - gone) / (1.0 - gone * kept)
    level = dict(zip(COLUMNS, LEVELS, strict=True))
    on = chip.silicon
    return Train(
        on.die.number or 0, on.temperature_c, rate, events[first],
        {level[c]: q / q[0] for c, q in theirs.items()}, {level[c]: q / q[0] for c, q in ours.items()},
        float(np.exp(-lifted[first][-1] / on.thermal_voltage)),
        float(settled + (1.0 - settled) * (gone * kept) ** (events[first].size - 1)), on.law("p").kappa,
    )  # fmt: skip


def response(die: int, rows: int, size: int = SIZE) -> Response:
    """Run a population of `size` on a die over a rate step, `rows` of its neurons also as transistors."""
    levels = np.zeros((NEURONS, NEURONS), np.int8)
    levels[:size, list(INPUTS)] = 1
    table = TABLE
    for name, code in GAIN.items():
        table = table.with_code(name, *code)
    program = Program(levels, table, depression=ShortTermDepression(SLOW))
    silicon, events = Silicon(ROLLS_180_IDEAL, 27.0, Die(number=die)), inputs_of(die)
    chip = RollsChip(program, silicon, "ideal")
    plain = RollsChip(replace(program, depression=None), silicon, "ideal")
    inputs = _to_all(events, size)
    spikes, state = chip.run(chip.at_rest(), UNTIL, inputs)
    without, _ = plain.run(plain.at_rest(), UNTIL, inputs)
    edges = np.arange(AT, UNTIL + 0.5 * BIN, BIN)
    rates = [np.histogram(s.times, edges)[0] / (size * BIN) for s in (spikes, without)]
    left = np.ones(1) if state.depression is None else state.depression.resource
    return Response(
        die, rates[0], rates[1], tuple(spikes.times[spikes.neurons == k] for k in range(rows)),
        tuple(simulated(chip, k, events, duration=UNTIL)[1].spikes["spike[0]"] for k in range(rows)),
        float(left.std() / left.mean()),
    )  # fmt: skip


def inputs_of(die: int) -> dict[int, F64]:
    """Return regular events of the population's inputs, whose phases the die's number draws."""
    phase = np.random.default_rng(die).uniform(0.0, 1.0, len(INPUTS))
    slow, fast = np.arange(round(LOW * AT)), np.arange(round(HIGH * (UNTIL - AT)))
    both = (np.concatenate(((slow + p) / LOW, AT + (fast + p) / HIGH)) for p in phase)
    return dict(zip(INPUTS, both, strict=True))


def _to_all(events: Events, size: int) -> Inputs:
    times = np.concatenate(list(events.values()))
    columns = np.repeat([NONPLASTIC + c for c in events], [t.size for t in events.values()])
    order = np.argsort(times, kind="stable")
    neurons = np.tile(np.arange(size), times.size)
    return Inputs(np.repeat(times[order], size), neurons, np.repeat(columns[order], size))
