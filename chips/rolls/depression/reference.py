"""Depressed synapses of a ROLLS chip beside the transistors of the same row of the same die.

`simulated` runs the row as a circuit (`chips.rolls.cut`); `drawn` has the charge that each of its pulses drew
from the line of the excitatory filter, `gates` how far it found the weight's gate above its bias; `stepped`
is the charge that the chip's kernel has for the same events, which act at the beginning of their step.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from chips.rolls.chip import RollsChip
from chips.rolls.cut import Cut, cut_row, silicon_of, testbench
from chips.rolls.depression.kernel import deliver_depressed
from chips.rolls.depression.state import depressing_of
from chips.rolls.layout import COUNTS, VIRTUAL, Traffic, new_scratch
from chips.rolls.program.address import NEURONS
from circuits.arrays import F64
from circuits.blocks.rest import started_at_rest
from circuits.errors import ParameterError
from circuits.event import pulse
from circuits.solver.power import drain_current
from circuits.solver.transient import Result, simulate

Events = Mapping[int, F64]  # times (s, rising) by column, which is the presynaptic neuron

WINDOW = 0.3e-3  # s, ours: from an event on, in which its pulse ends
AFTER = 2e-3  # s, ours: of a run behind its last event


def simulated(
    chip: RollsChip, neuron: int, events: Events, rtol: float = 1e-5, duration: float | None = None
) -> tuple[Cut, Result]:
    """Return the row of `neuron` as a circuit, and its run from rest by its transistors.

    Raises `ParameterError` for a column whose synapse onto it is not latched.
    """
    cut = cut_row(chip.program, neuron, chip.kind, chip.params)
    v_dd = chip.silicon.process.v_dd
    waves = {f"event[{_place(cut, column)}]": pulse(tuple(t), v_dd) for column, t in events.items()}
    last = max(float(t[-1]) for t in events.values())
    bench = testbench(cut, waves, last + AFTER if duration is None else duration, v_dd)
    bench = started_at_rest(bench, chip.silicon.process)
    return cut, simulate(bench, silicon_of(cut, chip.silicon), rtol=rtol)


def _place(cut: Cut, column: int) -> int:
    if column not in cut.columns:
        raise ParameterError(f"row[{cut.neuron}].column: {column}, must be latched; it is not in the program")
    return cut.columns.index(column)


def drawn(cut: Cut, result: Result, events: Events) -> dict[int, F64]:
    """Return the charge of each event of a column in such a run, C."""
    found = {}
    for column, times in events.items():
        current = drain_current(result, f"row[0].synapse[{_place(cut, column)}].me9")
        begin = np.searchsorted(result.time, times)
        end = np.searchsorted(result.time, times + WINDOW)
        parts = zip(begin, end, strict=True)
        found[column] = np.array([np.trapezoid(current[a:b], result.time[a:b]) for a, b in parts])
    return found


def gates(cut: Cut, result: Result, events: Events) -> dict[int, F64]:
    """Return how far each event found the gate of the constant weight above its rest, V."""
    found = {}
    for column, times in events.items():
        x = result[f"row[0].w_exc[{_place(cut, column)}]"]
        found[column] = np.interp(times, result.time, x) - float(x[0])
    return found


def stepped(chip: RollsChip, neuron: int, events: Events) -> dict[int, F64]:
    """Return the charge of each event of a column by the chip's kernel, C.

    Raises `ParameterError` for a chip without depressed synapses.
    """
    built = chip.built()
    depressing = depressing_of(built.depression, chip.at_rest().depression)
    if depressing is None:
        raise ParameterError("program.depression: None, must be given; give the program one")
    scratch, unit = new_scratch(NEURONS), float(built.filters[0].unit[neuron])
    none, counts = np.zeros(1, np.int64), np.zeros(COUNTS, np.int64)
    found = {}
    for column, times in events.items():
        brought = []
        for t in times:
            at = np.array([t]), np.array([VIRTUAL + column]), np.array([neuron])
            traffic = Traffic(*at, np.empty(0), none, none, counts)
            deliver_depressed(depressing, traffic, round(t / chip.step), np.inf, scratch)
            brought.append(float(scratch.charge[0, neuron]) * unit)
            scratch.charge[0, neuron] = 0.0
        found[column] = np.array(brought)
    return found
