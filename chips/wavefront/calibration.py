"""Calibration of a wavefront chip: the unit of its delays, the codes of its cells, and what is left out.

On the bench a cell is started with a code in its axon, and its neighbours' spikes tell its delay, cell after
cell. Two codes, the least and the highest, tell `D = offset + own code`: between them an axon is straight
within 0.04 % of its full scale. Times are the model's own without jitter, as the mean of many waves has them.

    shared    one current sets the delays of all cells: its code brings their mean unit to that of the design
    own       the cells differ by some 4 %: each gets the code that comes nearest to the delay of its cost
              (`chips.wavefront.cell_codes`), which is of use from a cost of about 12 on
    off       a cell that does not tell a cost of 1 from 2, more than half a unit off, is left out by its
              address, and waves go round it

What stays: a cost has steps of a whole code, and a fast cell none above 31. The comparators' current is left
at the code of the design: it moves an axon's offset by a hundredth of a unit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from chips.codes import Calibration, Codes, Measured, attempted, codes_near, left_off
from chips.wavefront.axon_conditions import AxonModel
from chips.wavefront.cell_codes import CellCodes
from chips.wavefront.model import axon_delays, chip_model, input_delay
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.wavefront.axon_delay import HIGHEST, UNIT
from circuits.circuit import BiasKind
from circuits.generator.code import codes_of, currents_of
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon

NAME = "wavefront-chip"  # of the calibration
ROUNDS = 4  # in which all cells are timed and the shared current is moved, before codes between; ours
WAVES = 16  # of which each time is the mean; ours
OFF = 0.5  # unit, by which a cell's delay of a cost of 1 may be off; ours
TOLD = 0.1  # share of a delay beyond which it is told to stay off; ours
_SHARED = "i_delay"


@dataclass(frozen=True, slots=True)
class Design:
    """What a wavefront chip is calibrated for.

    shape: rows and columns of its grid, or how many cells it has. unit: delay of a unit of cost, s.
    """

    shape: tuple[int, ...] = (20, 20)
    unit: float = UNIT


def calibrate(silicon: Silicon, kind: BiasKind, design: Design) -> Codes:
    """Calibrate the chip of a design on a silicon, at its temperature.

    A chip whose current has no code cannot be used.

    Arguments are those of `chips.codes.attempted`; design: its cells and their unit of delay. Raises
    `OutsideBoxError` where its record was not measured for the silicon, or for a current that is tried.
    """
    return attempted(NAME, silicon, kind, design, lambda begun: _found(begun, silicon, design))


def _found(begun: Codes, silicon: Silicon, design: Design) -> Codes:
    """Codes of the chip on a silicon."""
    found = _timed_in_turn(silicon, begun.key.bias_kind, design)
    before, after = found[0], min(found, key=lambda each: abs(math.log(each.unit / design.unit)))
    measured = tuple(_measured(design.unit, before, after))
    return replace(
        begun, biases=codes_near({_SHARED: after.current}),
        off={"cell": tuple(map(int, np.flatnonzero(after.off)))},
        trims={"own": tuple(map(float, after.own)), "offset": tuple(map(float, after.offset))},
        measured=measured, bench_s=sum(WAVES * _bench_time(each) for each in found),
        unmended=left_off(measured, TOLD), failed="no cell is left" if after.off.all() else "",
    )  # fmt: skip


def cell_codes(codes: Codes, design: Design) -> CellCodes:
    """Return what the codes of a chip of a design write to its cells."""
    off = np.zeros(math.prod(design.shape), dtype=np.bool_)
    off[list(codes.off["cell"])] = True
    current = float(np.asarray(codes.current(_SHARED)))
    own, offset = (np.array(codes.trims[name]) for name in ("own", "offset"))
    return CellCodes(current, own, offset, off)


def _timed_in_turn(silicon: Silicon, kind: BiasKind, design: Design) -> list[CellCodes]:
    """The chip as it is timed at the usual current, at what each time makes of it, and at codes between."""
    model = chip_model(design.shape, silicon.process, bias_kind=kind, unit=design.unit)
    current = _nearest_code(float(np.asarray(model.circuit.bias(_SHARED).value)))
    found: list[CellCodes] = []
    while len(found) < ROUNDS and all(current != each.current for each in found):
        found.append(_timed(model, silicon, current, design.unit))
        current = _nearest_code(current * found[-1].unit / design.unit)
    return found + [_timed(model, silicon, between, design.unit) for between in _between(found, design.unit)]


def _between(found: list[CellCodes], unit: float) -> Iterator[float]:
    """Currents of all codes between the slowest that is too fast and the fastest that is too slow, A.

    A line does not rise evenly from code to code, so that steps by its last current need not arrive.
    """
    slow = max((each.current for each in found if each.unit > unit), default=0.0)
    fast = min((each.current for each in found if each.unit <= unit), default=0.0)
    if not 0.0 < slow < fast:
        return
    coarse, fine = codes_of(np.array([slow, fast]))[:, 0], codes_of(np.array([slow, fast]))[:, 1]
    for code in range(int(fine[0]) + 1, int(fine[1]) if coarse[0] == coarse[1] else 0):
        yield float(currents_of(np.array([coarse[0], code])))


def _timed(model: AxonModel, silicon: Silicon, current: float, unit: float) -> CellCodes:
    """The chip as it is timed at a current of its axons, A."""
    here = replace(model, circuit=rebias(model.circuit, {_SHARED: current}))
    count, arrival = math.prod(model.shape), input_delay(silicon)
    least, most = (axon_delays(here, silicon, np.full(count, code)) + arrival for code in (1, HIGHEST))
    own = (most - least) / (HIGHEST - 1)
    off = ~(np.abs(least - unit) <= OFF * unit)
    return CellCodes(current, own, least - own, off)


def _measured(unit: float, before: CellCodes, after: CellCodes) -> Iterator[Measured]:
    """The mean unit, and of every cost the delay of the cell that is farthest off, before as a code."""
    kept = ~after.off
    yield Measured("unit", "s", unit, before.unit, after.unit)
    for cost in range(1, HIGHEST + 1):
        wanted = cost * unit
        usual = before.offset + before.own * cost
        own = after.delays(np.full(after.own.size, cost))[kept]
        yield Measured(f"delay[{cost}]", "s", wanted, _farthest(usual, wanted), _farthest(own, wanted))


def _farthest(delays: F64, wanted: float) -> float:
    """The delay that is farthest from what is wanted, s, NaN of none."""
    return float(delays[np.argmax(np.abs(delays - wanted))]) if delays.size else math.nan


def _nearest_code(current: float) -> float:
    return float(currents_of(codes_of(np.array(current))))


def _bench_time(timed: CellCodes) -> float:
    """How long it takes to time all cells once, s."""
    return float((2.0 * timed.offset + (1 + HIGHEST) * timed.own).sum())


CALIBRATION = Calibration(
    name=NAME,
    summary="unit of delay of the wavefront chip, and the codes of its cells",
    process=AMI_1500,
    calibrate=calibrate,
    setup=Design(),
)
