"""Scripts of the bench, in TOML: a circuit, its biases and voltages, and a sweep or a record.

    circuit = "NDP"
    read = ["C2F0", "C2F1"]

    [biases]
    NDP_VB_N = "N 30nA 50"         # type, coarse current, fine code

    [voltages]
    AIN5 = "0.9V"

    [sweep]                        # or [record]
    points = 61
    [sweep.over]                   # what moves together, from the first to the second
    AIN5 = ["0.75V", "1.05V"]
    AIN6 = ["1.05V", "0.75V"]

A bias is swept by its fine code, as `NDP_VB_N = ["0", "80"]`. `way = "both"` goes back as well. A record has
`samples`, `interval`, and `steps` of voltages or `events` where it has any. All is read and checked before
anything is measured.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import msgspec
import numpy as np

from chips.coach.generator import Code, Kind, master_named
from chips.coach.readout import RANGES
from chips.coach.wiring import CIRCUITS, Wiring
from circuits.arrays import F64
from circuits.blocks.bench.curve import within_supply
from circuits.checks import require_choice
from circuits.errors import CircuitError, DataError, ParameterError, unknown_name
from circuits.units import parse_quantity
from system.files.document import converted, toml_file

_MOST = 100_000  # points of a sweep
_REMEDY = "see the how-to of the bench"


class _Sweep(msgspec.Struct, forbid_unknown_fields=True):
    points: int
    over: dict[str, tuple[str, str]]
    way: Literal["up", "down", "both"] = "up"


class _Record(msgspec.Struct, forbid_unknown_fields=True):
    samples: int
    interval: str
    steps: dict[str, str] = {}
    events: list[str] = []
    fast: bool = False


class _Document(msgspec.Struct, forbid_unknown_fields=True):
    circuit: str
    read: list[str]
    biases: dict[str, str] = {}
    voltages: dict[str, str] = {}
    range: str = "low"
    counting_time: str = "0.1s"
    sweep: _Sweep | None = None
    record: _Record | None = None


@dataclass(frozen=True, slots=True)
class Sweep:
    """What is swept: pins (V) and biases (fine codes) by name, float64[points], moving together."""

    over: Mapping[str, F64]


@dataclass(frozen=True, slots=True)
class Record:
    """A record of so many samples an interval (s), with steps (V, by pin) and events (s) in it."""

    samples: int
    interval: float
    steps: Mapping[str, float]
    events: tuple[float, ...]
    fast: bool


@dataclass(frozen=True, slots=True)
class Script:
    """A script that was read.

    path : its file.
    circuit : name of the circuit.
    read : pins that are read.
    biases : code of each bias that is set.
    voltages : voltage of each pin that is set, V.
    range : that of the transistors' ammeters.
    counting_time : for how long converters count, s.
    act : the sweep or the record.
    """

    path: str
    circuit: str
    read: tuple[str, ...]
    biases: Mapping[str, Code]
    voltages: Mapping[str, float]
    range: str
    counting_time: float
    act: Sweep | Record

    @property
    def wiring(self) -> Wiring:
        """Pins and biases of its circuit."""
        return CIRCUITS[self.circuit]


def read_script(path: str, v_dd: float) -> Script:
    """Read a script and check all that it says, on a supply, V.

    Raises `DataError`, one line of the file, the key, the value and the rule, for a file that cannot be read,
    a key, pin, bias or circuit that there is not, a code beyond 255, and a voltage that leaves the supply.
    """
    found = converted(toml_file(Path(path)), _Document, path, _REMEDY)
    try:
        return _checked(path, found, v_dd)
    except CircuitError as error:
        raise DataError(f"{path}: {error}") from None


def _checked(path: str, found: _Document, v_dd: float) -> Script:
    if found.circuit not in CIRCUITS:
        raise unknown_name("circuit", found.circuit, CIRCUITS)
    wiring = CIRCUITS[found.circuit]
    require_choice("range", found.range, tuple(RANGES))
    if (found.sweep is None) == (found.record is None):
        raise ParameterError("sweep, record: must be one of them; give [sweep] or [record]")
    if not found.read:
        raise ParameterError("read: nothing, must be at least one pin; give a list of them")
    recorded = {**wiring.outputs, **wiring.counted}
    for pin in found.read:
        _require("read", pin, recorded if found.record else {**recorded, **wiring.ammeters})
    biases = {name: _code(wiring, name, text) for name, text in found.biases.items()}
    return Script(
        path,
        found.circuit,
        tuple(found.read),
        biases,
        {pin: _level(wiring, "voltages", pin, text, v_dd) for pin, text in found.voltages.items()},
        found.range,
        parse_quantity(found.counting_time, "s", "counting_time"),
        _sweep(wiring, found.sweep, biases, v_dd) if found.sweep else _record(wiring, found.record, v_dd),
    )


def _require(where: str, name: str, known: Mapping[str, object]) -> None:
    if name not in known:
        raise unknown_name(where, name, known)


def _code(wiring: Wiring, name: str, text: str) -> Code:
    _require("biases", name, wiring.lines)
    parts = text.split()
    if len(parts) != 3 or not parts[2].isdecimal():
        raise ParameterError(f"biases.{name}: {text!r}, must be type, coarse current and code; as N 30nA 50")
    kind: Kind = "N" if parts[0] == "N" else "P"
    require_choice(f"biases.{name}", parts[0], ("N", "P"))
    try:
        return Code(kind, master_named(parts[1]), int(parts[2]))
    except ParameterError as error:
        raise ParameterError(f"biases.{name}: {error}") from None


def _level(wiring: Wiring, where: str, pin: str, text: str, v_dd: float) -> float:
    _require(where, pin, wiring.inputs)
    volt = parse_quantity(text, "V", f"{where}.{pin}")
    within_supply(f"{where}.{pin}", v_dd, volt)
    return volt


def _sweep(wiring: Wiring, asked: _Sweep, biases: Mapping[str, Code], v_dd: float) -> Sweep:
    if not asked.over:
        raise ParameterError("sweep.over: nothing, must be at least one pin or bias")
    if not 2 <= asked.points <= _MOST:
        raise ParameterError(f"sweep.points: {asked.points}, must be 2 to {_MOST}")
    over = {}
    for name, ends in asked.over.items():
        if name in wiring.lines:
            values = _codes(name, ends, asked.points, biases)
        else:
            _require("sweep.over", name, {**wiring.inputs, **wiring.lines})
            first, last = (_level(wiring, "sweep.over", name, text, v_dd) for text in ends)
            values = np.linspace(first, last, asked.points)
        way = {"up": values, "down": values[::-1], "both": np.concatenate([values, values[::-1]])}
        over[name] = np.asarray(way[asked.way], dtype=np.float64)
    return Sweep(over)


def _codes(name: str, ends: tuple[str, str], points: int, biases: Mapping[str, Code]) -> F64:
    if name not in biases:
        raise ParameterError(
            f"sweep.over.{name}: its type and coarse current are not set; give biases.{name}"
        )
    if not all(text.isdecimal() for text in ends):
        raise ParameterError(f"sweep.over.{name}: {ends[0]} to {ends[1]}, must be fine codes from 0 to 255")
    values = np.rint(np.linspace(int(ends[0]), int(ends[1]), points))
    for fine in (values.min(), values.max()):
        try:
            Code(biases[name].kind, biases[name].master, int(fine))
        except ParameterError as error:
            raise ParameterError(f"sweep.over.{name}: {error}") from None
    return np.asarray(values, dtype=np.float64)


def _record(wiring: Wiring, asked: _Record | None, v_dd: float) -> Record:
    if asked is None:
        raise ParameterError("record: not given")
    if asked.events and not wiring.events:
        raise ParameterError("record.events: no events come in at this circuit; leave them out")
    return Record(
        asked.samples,
        parse_quantity(asked.interval, "s", "record.interval"),
        {pin: _level(wiring, "record.steps", pin, text, v_dd) for pin, text in asked.steps.items()},
        tuple(parse_quantity(text, "s", "record.events") for text in asked.events),
        asked.fast,
    )
