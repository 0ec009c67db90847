"""Calibration of a whole ROLLS die: the mean rate of its neurons, and which of them are left out.

On the bench every neuron gets regular events, `INPUT_RATE` a second, and spikes are counted with their
addresses; then none gets any.

    IF_TAU2_N  the leak of all neurons; its code brings their mean rate to the nominal die's at 27 degC, at
               the codes of the same table
    off        a neuron that is silent under events, or hot, above `HOT` times the median of those that fire,
               or restless, which fires without events: it gets none, and its spikes are not counted

Half more of the leak takes 42 % of the rate (`rolls_parallella`, die 11), half more of the refractory bias
gives 5 %, half more of a virtual synapse's weight nothing, since whole spikes follow each event. What stays
is how much neurons differ: they share all biases. On the nominal die at 27 degC nothing is searched. Numbers
of what is driven are ours.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache, partial

import numpy as np

from chips.codes import Calibration, Codes, Measured, codes_begun, left_off
from chips.rolls.calibration import MEASURE, SETTLE, Knob, Target, Task, calibrate, neuron_rates
from chips.rolls.chip import RollsChip
from chips.rolls.program.bias_file import BiasTable, default_biases
from chips.rolls.program.population import Population
from chips.rolls.validity import require_temperature
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.silicon.die import NOMINAL
from circuits.silicon.process import ROLLS_180, Process
from circuits.silicon.silicon import Silicon
from system.rolls.drive import ALL, program_of, regular_events

NAME = "rolls"  # of the calibration
KNOB, NEURON = "IF_TAU2_N", "neuron"
INPUT_RATE = 100.0  # Hz, of the events of a neuron; ours
HOT = 2.0  # times the median rate; ours
ROUNDS = 8  # runs of the search at most; ours
LEAST = 128  # neurons without which a chip is of no use; ours
OFF = 0.05  # share of a rate beyond which it is told to stay off; ours
USUAL_C = 27.0  # degC
_GROUP = Population("neurons", ALL)
_events = partial(regular_events, INPUT_RATE, seed=0)
_nothing = partial(regular_events, 0.0, seed=0)


def calibrate_rolls(silicon: Silicon, kind: BiasKind, table: BiasTable) -> Codes:
    """Calibrate a die at its temperature; table: the codes with which it begins."""
    wanted = _nominal_rate(silicon.process, kind, table)
    found, before, runs = table, wanted, 0
    if wanted > 0.0 and not (silicon.die == NOMINAL and silicon.temperature_c == USUAL_C):
        task = Task(
            program_of(table), (Target(_GROUP, wanted),), (Knob(KNOB, (_GROUP.name,), -1),), _events, 0
        )
        searched = calibrate(task, silicon, kind, ROUNDS)
        found, before, runs = searched.biases, searched.before[_GROUP.name], searched.runs
    chip = RollsChip(program_of(found), silicon, kind)
    rates, still = neuron_rates(chip, _events), neuron_rates(chip, _nothing)
    bad = dict(_useless(rates, still))
    left = np.delete(rates, list(bad))
    measured = (Measured("rate", "Hz", wanted, before, float(left.mean()) if left.size else 0.0),)
    told = tuple(f"{NEURON}[{k}]: {why}, switched off" for k, why in bad.items())
    return replace(
        codes_begun(NAME, silicon, kind, table),
        biases={KNOB: (found.code(KNOB),)},
        off={NEURON: tuple(bad)} if bad else {},
        measured=measured,
        bench_s=(runs + 2) * (SETTLE + MEASURE),
        unmended=(*told, *left_off(measured, OFF)),
        failed="" if left.size >= LEAST else f"{len(bad)} of {len(ALL)} neurons cannot be used",
    )


def table_at(table: BiasTable, codes: Codes | None) -> BiasTable:
    """Return a table with the code that a calibration found; as it is without one."""
    return table if codes is None else table.with_code(KNOB, *codes.biases[KNOB][0])


def off_of(codes: Codes | None) -> tuple[int, ...]:
    """Return the neurons that a calibration leaves out; none without one."""
    return () if codes is None else codes.off.get(NEURON, ())


@lru_cache(maxsize=8)
def _nominal_rate(process: Process, kind: BiasKind, table: BiasTable) -> float:
    """Mean rate of the nominal die's neurons at a table, Hz."""
    chip = RollsChip(program_of(table), Silicon(process, USUAL_C, NOMINAL), kind)
    return float(neuron_rates(chip, _events).mean())


def _useless(rates: F64, still: F64) -> Iterator[tuple[int, str]]:
    """Neurons that cannot be used, and why; rates: under events, still: without any, Hz."""
    firing = rates[rates > 0.0]
    most = HOT * float(np.median(firing)) if firing.size else np.inf
    for k in ALL:
        if rates[k] == 0.0:
            yield k, "it is silent"
        elif still[k] > 0.0:
            yield k, "it fires without events"
        elif rates[k] > most:
            yield k, f"it fires above {HOT:g} times the median rate"


CALIBRATION = Calibration(
    NAME, "mean rate of a ROLLS die's neurons, and those that cannot be used", ROLLS_180, calibrate_rolls,
    default_biases(), require_temperature,
)  # fmt: skip
