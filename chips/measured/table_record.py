"""Tables of a record over temperature and over the threshold shift that the transistors of a die share.

A quantity q is measured over temperature and over the threshold shift that all transistors of a polarity
share on a die, and put together as `q(T, s_n, s_p) = q_n(T, s_n) + q_p(T, s_p) - q_n(T, 0)`: a polynomial
through all temperatures, monotone cubics through the shifts. Mismatch inside a board is left to the errors,
but where a block's own measurement says otherwise.

The key of such a record (`chips.record`) is of the circuits with their biases, the process, the version of
the measurement and its grid.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from chips.measured.interpolation import lagrange_weights, monotone_cubic
from chips.record import Record, Table, content, in_force, matching_record, record_key
from chips.validity import require_inside
from circuits.arrays import F64
from circuits.circuit import Circuit
from circuits.silicon.die import shared
from circuits.silicon.process import AMI_1500_IDEAL, Polarity, Process
from circuits.silicon.silicon import Silicon

VERSION = 2  # of the measurements: what they measure and how
TEMPERATURES = (-10.0, 8.0, 27.0, 46.0, 65.0)  # degC
WIDEST = 0.12  # V, largest shared threshold shift that is measured: 3.6 sigma
POLARITIES: tuple[Polarity, ...] = ("n", "p")
PLANE = ("temperature", "polarity", "shift")  # axes of a quantity that is measured here, before its own

Quantities = Mapping[str, F64 | float]
Circuits = Callable[[], Sequence[Circuit]]


def shifts(count: int) -> tuple[float, ...]:
    """Return so many threshold shifts (V), an odd number, evenly spaced from -`WIDEST` to `WIDEST`."""
    return tuple(float(s) for s in np.linspace(-WIDEST, WIDEST, count))


def board_key(circuits: Sequence[Circuit], process: Process, shifts: Sequence[float]) -> str:
    """Return the key of the record of `circuits` in `process`, measured at the threshold `shifts` (V)."""
    return record_key([content(c) for c in circuits], process, VERSION, TEMPERATURES, tuple(shifts))


def measure_over(
    measure: Callable[[Silicon], Quantities],
    circuits: Sequence[Circuit],
    shifts: Sequence[float],
    axes: Mapping[str, tuple[str, ...]],
    process: Process = AMI_1500_IDEAL,
) -> Record:
    """Measure quantities at every temperature and shared threshold shift; return a record without errors.

    measure: of a silicon, gives the quantities by name; circuits: what is measured, for the key; shifts: V,
    rising, 0 among them; axes: names of a quantity's own axes, for those that have any; process: of the
    silicons.
    """
    rows = [
        [[measure(_shifted(process, t, polarity, s)) for s in shifts] for polarity in POLARITIES]
        for t in TEMPERATURES
    ]
    tables = {}
    for name in rows[0][0][0]:
        values = np.array([[[q[name] for q in line] for line in plane] for plane in rows])
        tables[name] = Table((*PLANE, *axes.get(name, ())), values)
    key = board_key(circuits, process, shifts)
    return Record(key, VERSION, {"temperature": TEMPERATURES, "shift": tuple(shifts)}, tables)


def tables_of(block: str, circuits: Circuits, process: Process) -> Record:
    """Return the record of a block; raises `DataError` unless it is of these circuits in this process.

    circuits: a function of a module that builds what the model stands for, the same at every call.
    """
    if in_force(block, process):
        return _matching(block, circuits, process)
    return _kept(block, circuits, process)


def tables_on(silicon: Silicon, block: str, circuits: Circuits, path: str) -> Record:
    """The record of a block for a silicon, raising as `tables_of` and `check_box`, which names the path."""
    data = tables_of(block, circuits, silicon.process)
    check_box(path, silicon, data)
    return data


@lru_cache(maxsize=32)
def _kept(block: str, circuits: Circuits, process: Process) -> Record:
    return _matching(block, circuits, process)


def _matching(block: str, circuits: Circuits, process: Process) -> Record:
    return matching_record(
        block, lambda found: board_key(circuits(), process, found.numbers("shift")), process
    )


def on_silicon(record: Record, name: str, silicon: Silicon, axis: str = "shift") -> F64:
    """Return a quantity at the silicon's temperature on its die; axis: of its shared threshold shift."""
    return all_on_silicon(record, (name,), silicon, axis)[0]


def all_on_silicon(record: Record, names: Sequence[str], silicon: Silicon, axis: str = "shift") -> list[F64]:
    """Return several quantities in the order of `names`, each as `on_silicon` does."""
    weights = temperature_weights(record, silicon.temperature_c)
    shift = record[axis]
    moved = [float(shared(silicon.die, silicon.process, polarity).v_t0) for polarity in POLARITIES]
    unmoved = int(np.argmin(np.abs(shift)))
    found = []
    for name in names:
        table = record[name]
        columns = (weights @ table.reshape(weights.size, -1)).reshape(len(moved), shift.size, -1)
        parts = np.empty((len(moved), columns.shape[-1]))
        for k, x in enumerate(moved):
            monotone_cubic(shift, columns[k], x, parts[k])
        found.append((parts[0] + parts[1] - columns[0, unmoved]).reshape(table.shape[3:]))
    return found


def temperature_weights(record: Record, temperature_c: float) -> F64:
    """Return the weights of a record's temperatures at a temperature (degC), float64.

    They must not be written to.
    """
    return lagrange_weights(record.numbers("temperature"), temperature_c)


def check_temperature(path: str, silicon: Silicon, record: Record) -> None:
    """Raise as `check_box`, for silicon at a temperature outside of the record's box alone."""
    require_inside(f"{path}.temperature", silicon.temperature_c, record.limits("temperature"), "degC")


def check_box(path: str, silicon: Silicon, record: Record) -> None:
    """Raise `ParameterError`, with the instance path, for silicon outside the record's box.

    What is raised, and when a warning takes its place, is `chips.validity`'s.
    """
    check_temperature(path, silicon, record)
    for polarity in POLARITIES:
        shift = shared(silicon.die, silicon.process, polarity).v_t0
        require_inside(f"{path}.{polarity}.shared_v_t0_shift", shift, record.limits("shift"), "V")


def _shifted(process: Process, temperature_c: float, polarity: Polarity, shift: float) -> Silicon:
    model = process.model(polarity)
    moved = replace(model, v_t0=model.v_t0 + shift)
    other = replace(process, n=moved) if polarity == "n" else replace(process, p=moved)
    return Silicon(other, temperature_c)
