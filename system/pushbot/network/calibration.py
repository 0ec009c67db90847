"""Calibration of the Pushbot's network on a die: codes and neurons with which it does what it is made for.

The paper's robot was tuned by hand, for one chip. Here a chip is brought to the rates that at 27 degC the
codes of `system.pushbot.network.biases` give on the nominal die, as a lab would bring its chips to one data
sheet; how codes are searched is in `chips.rolls.calibration`. Programmed for it is the part of the network in
which nothing competes, so that each knob has populations of its own:

    events -> OL, OR     VA_EXC_N                   OL -> DR, OR -> DL    EXC1 (level 3)
    exc -> exc           IF_RFR2_N (refractory)     OL, OR -| sp          INH (level -1)
    events -> target     IF_TAU1_N (its leak)

Weights without a knob follow that of their sign, by the same factor: pulse width and filters, which all
share, are most of what differs. Of each population of 16 at most four neurons are left out afterwards.

Then, with the neurons that are left, the loop is closed that ends a turn:

    events -> OL, OR -> drives -| OL, OR            INH0 (level -2), at as many events as a turn makes

The first search says little of it: at so many events OL and OR fire nearly as fast as their refractory period
lets them. With its codes alone the drives of ten dies (100 to 109) fired at 40 to 223 Hz in this loop, and
the robot of die 104, at 204 and 152 Hz, turned on the spot for nine tenths of its time in clutter. The rate
asked for was chosen in closed loop, with the codes. The two sides of a die still differ, up to threefold:
one code sets the middle of both. The modified network goes on from the codes found here, in
`system.pushbot.network.modified_calibration`. Rates, drives and pairings are ours.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from chips.rolls.calibration import Calibration, Knob, Target, Task, calibrate, code_for
from chips.rolls.chip import Inputs
from chips.rolls.program.address import VIRTUAL_EXCITATORY
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.network import Network, PopulationInput, network_program
from chips.rolls.program.population import Population, Projection
from circuits.arrays import F64, I64
from circuits.blocks.rolls.bias import current_of
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.silicon import Silicon
from system.pushbot.network.biases import STEP

ROUNDS = 10  # runs of the chip at most
MOST = 4  # neurons that a population may do without
EVENTS = 200.0  # 1/s, to both obstacle populations, each for all of their neurons
_OWNED = 45.0  # 1/s, to each driven neuron of the field
FIELD = (48, 80)  # neurons of the field that are driven
START, START_RATE = 0.05, 1000.0  # s and 1/s: events that start exc
TURN_EVENTS = 3000.0  # 1/s, as EVENTS; about what a turn of 0.6 to 1 rad/s makes on a side in clutter
TURN_RATE = 104.0  # Hz of DL and DR under these, both inhibiting OL and OR; 95 on the nominal die
SEED = 8  # of when events come, the same in all runs and on all dies
OPEN = frozenset(
    {("OR", "DL"), ("OL", "DR"), ("OL", "sp"), ("OR", "sp"), ("exc", "exc"), ("exc", "sp")}
)  # connections of the first search
LOOP = frozenset({("OR", "DL"), ("OL", "DR"), *((d, o) for d in ("DL", "DR") for o in ("OL", "OR"))})
# Hz: what the codes of `system.pushbot.network.biases` give on the nominal die under these drives
RATES: Mapping[str, float] = {
    "OL": 170.0, "OR": 170.0, "DL": 190.0, "DR": 190.0, "sp": 30.0, "exc": 313.0, "target": 169.0,
}  # fmt: skip


def calibrate_pushbot(
    network: Network, biases: BiasTable, silicon: Silicon, kind: BiasKind = "ideal"
) -> Calibration:
    """Calibrate the plain network on the die of `silicon`, at its temperature.

    Rates of both searches are told, those of the second by the names of `turn`; `runs` counts both.
    """
    found = calibrate(calibration_task(network, biases), silicon, kind, ROUNDS, STEP)
    followed = _followed(biases, found.biases)
    loop = loop_task(without(network, dropped(found)), followed)
    closed = calibrate(loop, silicon, kind, ROUNDS, STEP)
    both = (
        {**first, **{turn(name): rate for name, rate in second.items()}}
        for first, second in ((found.before, closed.before), (found.rates, closed.rates))
    )
    before, rates = both
    return replace(found, biases=closed.biases, before=before, rates=rates, runs=found.runs + closed.runs)


def turn(name: str) -> str:
    """Name of a drive population's rate under the events of a turn."""
    return f"{name} in a turn"


def dropped(found: Calibration) -> frozenset[int]:
    """Return the neurons that are left out."""
    return frozenset(k for gone in found.blacklist.values() for k in gone)


def calibration_task(network: Network, biases: BiasTable) -> Task:
    """What is programmed, driven and asked for."""
    field = network["target"].part(*FIELD)
    groups = {name: network[name] for name in RATES if name != "target"} | {"target": field}
    targets = tuple(Target(group, RATES[name]) for name, group in groups.items())
    knobs = (
        Knob("VA_EXC_N", ("OL", "OR")), Knob("IF_RFR2_N", ("exc",)), Knob("NPA_WEIGHT_EXC1_P", ("DL", "DR")),
        Knob("NPA_WEIGHT_INH_N", ("sp",), -1), Knob("IF_TAU1_N", (field.name,), -1),
    )  # fmt: skip
    program = network_program(driven_part(network), biases)
    return Task(
        program, targets, knobs, lambda duration: events_of(network, duration), MOST,
        frozenset({field.name, "exc"}),
    )  # fmt: skip


def loop_task(network: Network, biases: BiasTable) -> Task:
    """The loop of obstacle and drive populations under the events of a turn, both drives at once."""
    drives = ("DL", "DR")
    targets = tuple(Target(network[name], TURN_RATE) for name in drives)
    both = (*network["OL"].neurons, *network["OR"].neurons)
    return Task(
        network_program(driven_part(network, LOOP), biases), targets,
        (Knob("NPA_WEIGHT_INH0_N", drives, -1),),
        lambda duration: to_synapses(network, [to_all(poisson_events(TURN_EVENTS, duration, 0), both)]), 0,
    )  # fmt: skip


def driven_part(network: Network, kept: Collection[tuple[str, str]] = OPEN) -> Network:
    """The network with the connections from and to the populations of these names."""
    chosen = (p for p in network.projections if (p.source.name, p.target.name) in kept)
    return replace(network, projections=tuple(chosen))


def events_of(network: Network, duration: float) -> Inputs:
    """Events to OL, OR and the field for `duration` s, and those that start exc, in order of time."""
    start = np.arange(round(START * START_RATE)) / START_RATE
    both = (*network["OL"].neurons, *network["OR"].neurons)
    parts = [
        to_all(start, network["exc"].neurons),
        to_all(poisson_events(EVENTS, duration, 0), both),
        *(to_all(poisson_events(_OWNED, duration, k), (k,)) for k in network["target"].part(*FIELD).neurons),
    ]
    return to_synapses(network, parts)


def to_synapses(network: Network, parts: Sequence[tuple[F64, I64]]) -> Inputs:
    """Events (times, neurons) in order of time, each to all virtual synapses of the network's inputs."""
    synapses = max(each.synapses for each in network.inputs)
    times, neurons = np.concatenate([t for t, _ in parts]), np.concatenate([n for _, n in parts])
    order = np.argsort(times, kind="stable")
    columns = np.tile(VIRTUAL_EXCITATORY + np.arange(synapses), times.size)
    return Inputs(np.repeat(times[order], synapses), np.repeat(neurons[order], synapses), columns)


def without(network: Network, gone: Collection[int]) -> Network:
    """The network without some neurons; raises `ParameterError` where a population would be empty."""

    def left(p: Population) -> Population:
        kept = tuple(n for n in p.neurons if n not in gone)
        if not kept:
            raise ParameterError(
                f"population.{p.name}: none of {len(p)} neurons is left, must be one or more"
            )
        return Population(p.name, kept)

    def cut(p: Projection) -> Projection:
        rows = [k for k, n in enumerate(p.target.neurons) if n not in gone]
        columns = [k for k, n in enumerate(p.source.neurons) if n not in gone]
        return Projection(left(p.source), left(p.target), p.levels[np.ix_(rows, columns)])

    inputs = (PopulationInput(i.name, left(i.target), i.synapses, i.inhibitory) for i in network.inputs)
    return Network(
        tuple(left(p) for p in network.populations), tuple(cut(p) for p in network.projections),
        tuple(inputs), tuple(left(p) for p in network.slow),
    )  # fmt: skip


def _followed(before: BiasTable, found: BiasTable) -> BiasTable:
    """Codes found, and by the factors of their knobs those of the weights without one."""
    leaders = dict.fromkeys(("NPA_WEIGHT_EXC_P", "NPA_WEIGHT_EXC0_P"), "NPA_WEIGHT_EXC1_P")
    leaders |= dict.fromkeys(("NPA_WEIGHT_INH0_N", "NPA_WEIGHT_INH1_N"), "NPA_WEIGHT_INH_N")
    for name, knob in leaders.items():
        factor = current_of(found.code(knob)) / current_of(before.code(knob))
        found = found.with_code(name, *code_for(current_of(before.code(name)) * factor))
    return found


def poisson_events(rate: float, until: float, key: int) -> F64:
    """Times of events from START on, s; a longer run begins as a shorter one does."""
    random = np.random.default_rng((SEED, key))
    times = START + np.cumsum(random.exponential(1.0 / rate, math.ceil(2.0 * rate * until + 50.0)))
    return np.asarray(times[times < until])


def to_all(times: F64, neurons: tuple[int, ...]) -> tuple[F64, I64]:
    """Every event to every neuron: times and neurons."""
    return np.repeat(times, len(neurons)), np.tile(np.array(neurons, dtype=np.int64), times.size)
