"""The check of events for a ROLLS chip: neurons, columns and times that it has."""

from __future__ import annotations

import numpy as np

from chips.rolls.program.address import NEURONS, NONPLASTIC, VIRTUAL_EXCITATORY, VIRTUAL_INHIBITORY
from chips.rolls.program.program import Program
from circuits.arrays import F64, I64, Bools, in_rows
from circuits.compiled import compiled
from circuits.errors import ParameterError

_compiled = compiled()


def check_inputs(times: F64, neurons: I64, columns: I64, now: float, program: Program) -> None:
    """Check events of a run from `now` s on; times: s; neurons, columns: int64.

    Raises `ParameterError` for the first that the chip with this program does not take.
    """
    if times.size == 0:
        return
    known = np.zeros(VIRTUAL_INHIBITORY + 4, np.bool_)
    known[NONPLASTIC:VIRTUAL_EXCITATORY] = True
    for inhibitory in {each.inhibitory for each in program.inputs}:
        known[list(program.virtual.columns(inhibitory=inhibitory))] = True
    if _all_fit(in_rows(times), in_rows(neurons), in_rows(columns), now, known):
        return
    if not times.min() >= now:
        raise ParameterError(f"chip.inputs: an event at {times.min():g} s, must be >= {now:g} s")
    if neurons.min() < 0 or neurons.max() >= NEURONS:
        wrong = neurons[(neurons < 0) | (neurons >= NEURONS)][0]
        raise ParameterError(
            f"chip.inputs: neuron {wrong}, must be 0 to {NEURONS - 1}; the chip has {NEURONS}"
        )
    columns = _check_plastic(neurons, columns, program)
    bad = (columns < 0) | (columns >= known.size)
    bad |= ~known[np.where(bad, 0, columns)]
    if bad.any():
        raise ParameterError(
            f"chip.inputs: column {columns[bad][0]}, must be {NONPLASTIC} to {VIRTUAL_EXCITATORY - 1} or a"
            " virtual synapse of a sign that an input of the program has; declare a VirtualInput"
        )


@_compiled
def _all_fit(times: F64, neurons: I64, columns: I64, now: float, known: Bools) -> bool:
    """Whether all events are of neurons, of columns that are known, and from `now` on."""
    for k in range(times.size):
        if not times[k] >= now or not 0 <= neurons[k] < NEURONS:
            return False
        if not 0 <= columns[k] < known.size or not known[columns[k]]:
            return False
    return True


def _check_plastic(neurons: I64, columns: I64, program: Program) -> I64:
    """Check events of the plastic array, if there is one; returns the columns of all others."""
    if program.plastic is None:
        return columns
    mine = (columns >= 0) & (columns < NEURONS)
    to, column = neurons[mine], columns[mine]
    shut = ~program.plastic.latches[to, column]
    if shut.any():
        raise ParameterError(
            f"chip.inputs: plastic column {column[shut][0]} of neuron {to[shut][0]}, must be latched; set it"
            " in the program's PlasticArray"
        )
    return columns[~mine]
