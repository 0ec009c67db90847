"""The process of a foundry: its model cards, corners and statistics, and the file that says where they are.

A process's file, or a user's own mapping, is TOML (`netlists/foundry/processes/gf180mcu.toml` is one, with
its meaning in comments):

    [process]     name, package, extra, file, notice (of the cards), v_dd (V), temperature_c (degC);
                  statistics_of: noctule's process whose statistics stand for those that the package lacks
    [n], [p]      model: name of the cards; section: where they stand in the file, `.lib section` to `.endl`,
    or
                  empty for the whole file; corners: section, or file, of the foundry's other corners by name
    [sizes]       diffusion (m); the rest where sizes are changed: width_factor, length_factor (1),
                  least_width, least_length, most_width (m)
    [parameters]  numbers for names that the cards use
    [statistics]  process, n, p, mismatch: sections of the foundry's Monte Carlo; switches: numbers of its own
    [biases]      NAME = { gate_of = "instance.device" } or { volts = 1.2 } for biases of kind voltage

`package` is the distribution on PyPI that brings `file`. It is an optional extra; only the file is read, none
of its code runs. Cards are binned: `nfet_03v3.0`, `nfet_03v3.1`, ... hold for W and L from wmin to wmax and
lmin to lmax; a deck gets the bins that its devices use, as literal text, and so runs where no package is.
"""

from __future__ import annotations

import functools
import re
import sys
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import metadata
from math import inf
from pathlib import Path
from typing import Any

from circuits.errors import DataError, ParameterError, meant
from circuits.silicon.process import POLARITIES, Polarity

_SHIPPED = Path(__file__).parent / "processes"
_CARD = re.compile(r"\.model\s+(\S+)\s", re.IGNORECASE)
_BOUND = re.compile(r"\b([lw])(min|max)\s*=\s*([-+.0-9e]+)", re.IGNORECASE)
_KEPT = {
    "width_factor": 1.0,
    "length_factor": 1.0,
    "least_width": 0.0,
    "least_length": 0.0,
    "most_width": inf,
}
_SIZES = (*_KEPT, "diffusion")
TYPICAL = "typical"


@dataclass(frozen=True, slots=True)
class Sizes:
    """The rule of sizes: `W' = max(width_factor W, least_width)`, and L likewise.

    Attributes
    ----------
    width_factor, length_factor
        What widths and lengths are multiplied by.
    least_width, least_length
        The least width and length, m.
    most_width
        Wider devices become equal parallel ones, m.
    diffusion
        Length of drain and source, m.
    """

    width_factor: float
    length_factor: float
    least_width: float
    least_length: float
    most_width: float
    diffusion: float

    @property
    def kept(self) -> bool:
        """Whether all sizes stay as they are drawn."""
        return all(getattr(self, name) == value for name, value in _KEPT.items())

    def width(self, width: float) -> float:
        """Width on the foundry's process, m."""
        return max(self.width_factor * width, self.least_width)

    def length(self, length: float) -> float:
        """Length on the foundry's process, m."""
        return max(self.length_factor * length, self.least_length)

    def __str__(self) -> str:
        """The rule in a line, in um."""
        if self.kept:
            return "as drawn"
        um = 1e6
        return (
            f"W' = {self.width_factor:g} W, at least {um * self.least_width:g} um;"
            f" L' = {self.length_factor:g} L, at least {um * self.least_length:g} um;"
            f" wider than {um * self.most_width:g} um in equal parts; capacitors as they are"
        )


@dataclass(frozen=True, slots=True)
class Statistics:
    """Where a package has the foundry's Monte Carlo.

    process: section of the numbers that a die shares, with their draws. cards: section of the cards that use
    them, by polarity. mismatch: section of the sub-circuits, called as the models, that have a device's own
    draws. switches: numbers of the foundry's own that stand in both.
    """

    process: str
    cards: Mapping[Polarity, str]
    mismatch: str
    switches: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class DeviceMapping:
    """A foundry's process, or a user's mapping onto one.

    Attributes
    ----------
    name, notice
        Name of the process, and the notice that its cards ask for.
    package, extra, file
        Distribution that brings the cards, the extra of noctule that installs it, and the cards' file in it.
    v_dd, temperature_c
        Supply, V, and temperature at which biases are computed, degC.
    models
        Name of the cards and their section of the file, by polarity.
    corners
        Section, or file, of the foundry's corners but the typical one, by polarity and name.
    sizes
        The rule of sizes.
    parameters
        Numbers for names that the cards use, in the cards' own units.
    biases
        For biases of kind voltage, by name: `gate_of` and the path of a device, or `volts` and a voltage, V.
    statistics
        The foundry's Monte Carlo; None where the package has none.
    statistics_of
        Noctule's process whose statistics stand in its place; empty for none.
    """

    name: str
    package: str
    extra: str
    file: str
    notice: str
    v_dd: float
    temperature_c: float
    models: Mapping[Polarity, tuple[str, str]]
    corners: Mapping[Polarity, Mapping[str, str]]
    sizes: Sizes
    parameters: Mapping[str, float]
    biases: Mapping[str, tuple[str, str | float]]
    statistics: Statistics | None = None
    statistics_of: str = ""

    @property
    def corner_names(self) -> tuple[str, ...]:
        """Names of the foundry's corners, the typical one first."""
        return (TYPICAL, *self.corners["n"])


@dataclass(frozen=True, slots=True)
class Card:
    """One bin of a foundry's model.

    name: name of the card. width, length: the bin holds for `width[0] <= W < width[1]`, and for lengths
    likewise, m. text: its `.model` card.
    """

    name: str
    width: tuple[float, float]
    length: tuple[float, float]
    text: str

    def holds(self, width: float, length: float) -> bool:
        """Whether a device of this size, m, is in the bin."""
        return self.width[0] <= width < self.width[1] and self.length[0] <= length < self.length[1]


def process_names() -> list[str]:
    """Names of the foundries' processes that noctule has a file for, in alphabetical order."""
    return sorted(path.stem for path in _SHIPPED.glob("*.toml"))


@functools.lru_cache(maxsize=8)
def read_foundry(name: str) -> DeviceMapping:
    """Read a foundry's process that noctule has a file for.

    Raises
    ------
    DataError
        There is none of this name.
    """
    if name not in process_names():
        raise DataError(
            f"process: {name}, must be one of {', '.join(process_names())}{meant(name, process_names())}"
        )
    return _read(_SHIPPED / f"{name}.toml")


def read_mapping(name: str) -> DeviceMapping:
    """Read a mapping of one's own, a TOML file, by its path.

    Raises
    ------
    DataError
        No such file, no TOML, or an entry is missing or of the wrong kind; or `name` is a foundry's process.
    """
    path = Path(name)
    if name in process_names() and not path.is_file():
        raise DataError(
            f"mapping: {name}, a foundry's process; name it as the process, which keeps sizes, or give a TOML"
            " file of your own"
        )
    return _read(path)


def _read(path: Path) -> DeviceMapping:
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise DataError(f"{path}: no mapping; give a TOML file of your own") from error
    except (ValueError, RecursionError) as error:  # no TOML, no UTF-8, a number or brackets without end
        raise DataError(f"{path}: no TOML, {str(error)[:200]}; see the shipped processes") from None
    return _mapping(str(path), tables)


@functools.lru_cache(maxsize=64)
def _cards_of(path: Path, section: str, model: str) -> tuple[Card, ...]:
    return tuple(_cards(_section(path, section), model))


def read_cards(
    mapping: DeviceMapping, polarity: Polarity, corner: str = TYPICAL, section: str | None = None
) -> tuple[Card, ...]:
    """Bins of the transistor of one polarity.

    mapping: the foundry's process. polarity: `n` or `p`. corner: name of the foundry's corner. section:
    another section of the file, as the one of statistics.

    Raises `DataError` where the package is not installed, or its file has no such section or model. Raises
    `ParameterError` where the foundry has no such corner.
    """
    model, where = mapping.models[polarity]
    file = mapping.file
    if section is not None:
        where = section
    elif corner != TYPICAL:
        known = mapping.corners[polarity]
        if corner not in known:
            raise ParameterError(f"corner: {corner}, {mapping.name} has {', '.join(mapping.corner_names)}")
        if "/" in known[corner]:
            file, where = known[corner], ""
        else:
            where = known[corner]
    path = card_file(mapping, file)
    cards = _cards_of(path, where, model)
    if not cards:
        raise DataError(f"{path}: no card of {model} in section {where}; is the mapping of this release?")
    return cards


def card_file(mapping: DeviceMapping, file: str = "") -> Path:
    """Place of a foundry's file, the one of its cards unless another is given.

    Raises `DataError` where its package is not installed.
    """
    wanted = file or mapping.file
    try:
        found = _located(mapping.package, wanted)
    except metadata.PackageNotFoundError as error:
        raise DataError(
            f"{mapping.name}: {mapping.package} is not installed; pip install 'noctule[{mapping.extra}]'"
        ) from error
    if found is None:
        raise DataError(f"{mapping.name}: {mapping.package} has no {wanted}; install another release")
    return found


@functools.lru_cache(maxsize=32)
def _located(package: str, wanted: str) -> Path | None:
    found = [f for f in metadata.files(package) or () if str(f) == wanted]
    return Path(str(found[0].locate())) if found else None


@functools.lru_cache(maxsize=32)
def _joined(path: Path, section: str) -> str:
    return "".join(_section(path, section))


def section_text(mapping: DeviceMapping, section: str) -> str:
    """Text of a section of the foundry's file; raises `DataError` where it has none of that name."""
    path = card_file(mapping)
    text = _joined(path, section)
    if not text:
        raise DataError(f"{path}: no section {section}; is the mapping of this release?")
    return text


def choose_cards(
    cards: tuple[Card, ...], mapping: DeviceMapping, polarity: Polarity, sizes: Iterable[tuple[float, float]]
) -> str:
    """Text of the bins, of `cards`, that devices of these (width, length), m, use.

    Raises `ParameterError` for a size that no bin has.
    """
    used = set()
    for width, length in sizes:
        held = [k for k, card in enumerate(cards) if card.holds(width, length)]
        if not held:
            raise ParameterError(_no_bin(cards, mapping, polarity, width, length))
        used.add(held[0])
    return "".join(cards[k].text for k in sorted(used))


def size_limits(cards: Iterable[Card]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Least and most width, and length, that bins hold for, m."""
    bins = list(cards)
    width, length = ((min(b[0] for b in side), max(b[1] for b in side)) for side in (
        [card.width for card in bins], [card.length for card in bins]
    ))  # fmt: skip
    return width, length


def _no_bin(
    cards: tuple[Card, ...], mapping: DeviceMapping, polarity: Polarity, width: float, length: float
) -> str:
    """Why a size has no card, with the bins' limits."""
    um = 1e6
    (low_w, high_w), (low_l, high_l) = size_limits(cards)
    return (
        f"{mapping.models[polarity][0]}: {um * width:g} um by {um * length:g} um, a size that no card holds"
        f" for; widths are {um * low_w:g} to {um * high_w:g} um and lengths {um * low_l:g} to"
        f" {um * high_l:g} um; change the size"
    )


def _mapping(path: str, tables: Mapping[str, Any]) -> DeviceMapping:
    process = _table(path, tables, "process")
    sizes = {**_KEPT, **_table(path, tables, "sizes")}
    models: dict[Polarity, tuple[str, str]] = {}
    corners: dict[Polarity, Mapping[str, str]] = {}
    for polarity in POLARITIES:
        table = _table(path, tables, polarity)
        models[polarity] = (_text(path, table, "model"), _text(path, table, "section"))
        own = table.get("corners", {})
        corners[polarity] = {name: _text(path, own, name) for name in own}
    return DeviceMapping(
        name=_text(path, process, "name"),
        package=_text(path, process, "package"),
        extra=_text(path, process, "extra"),
        file=_text(path, process, "file"),
        notice=_text(path, process, "notice"),
        v_dd=_number(path, process, "v_dd"),
        temperature_c=_number(path, process, "temperature_c"),
        models=models,
        corners=corners,
        sizes=Sizes(*(_number(path, sizes, key) for key in _SIZES)),
        parameters={k: _number(path, tables["parameters"], k) for k in tables.get("parameters", {})},
        biases={k: _bias(path, k, v) for k, v in tables.get("biases", {}).items()},
        statistics=_statistics(path, tables),
        statistics_of=_text(path, process, "statistics_of") if "statistics_of" in process else "",
    )


def _statistics(path: str, tables: Mapping[str, Any]) -> Statistics | None:
    if "statistics" not in tables:
        return None
    table = _table(path, tables, "statistics")
    switches = table.get("switches", {})
    return Statistics(
        _text(path, table, "process"),
        {polarity: _text(path, table, polarity) for polarity in POLARITIES},
        _text(path, table, "mismatch"),
        {name: _number(path, switches, name) for name in switches},
    )


def _bias(path: str, name: str, entry: Any) -> tuple[str, str | float]:
    if isinstance(entry, dict) and len(entry) == 1:
        if "gate_of" in entry:
            return "gate_of", _text(path, entry, "gate_of")
        if "volts" in entry:
            return "volts", _number(path, entry, "volts")
    raise DataError(f"{path}: biases.{name}, must be {{ gate_of = TEXT }} or {{ volts = NUMBER }}")


def _table(path: str, tables: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    table = tables.get(key)
    if not isinstance(table, dict):
        raise DataError(f"{path}: no table [{key}]; see the shipped processes")
    return table


def _text(path: str, table: Mapping[str, Any], key: str) -> str:
    if not isinstance(table.get(key), str):
        raise DataError(f"{path}: {key}, must be a text; see the shipped processes")
    return str(table[key])


def _number(path: str, table: Mapping[str, Any], key: str) -> float:
    value = table.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise DataError(f"{path}: {key}, must be a number; see the shipped processes")
    unlimited = key == "most_width" and value == inf
    if unlimited or abs(value) <= sys.float_info.max:  # neither NaN nor what no float holds
        return float(value)
    raise DataError(f"{path}: {key}, must be a finite number; see the shipped processes")


def _section(path: Path, section: str) -> Iterable[str]:
    """Lines of a section, `.lib NAME` to `.endl`; a reference `.lib FILE NAME` does not open one.

    An empty name is the whole file.
    """
    inside = not section
    with path.open(encoding="utf-8", errors="replace") as file:
        for line in file:
            words = line.lower().split()
            if inside and words[:1] == [".endl"]:
                return
            if inside:
                yield line
            inside = inside or words == [".lib", section.lower()]


def _cards(lines: Iterable[str], model: str) -> Iterable[Card]:
    """Cards of `model` and of its bins `model.0`, `model.1`, ..., comments and blank lines dropped."""
    text: list[str] = []
    for line in (*lines, ".end"):
        if line.startswith("+") and text:
            text.append(" ".join(line.split()) + "\n")
        elif line.strip() and not line.startswith("*"):
            if text:
                yield _card(text)
            found = _CARD.match(line)
            wanted = found is not None and found[1].lower().partition(".")[0] == model.lower()
            text = [" ".join(line.split()) + "\n"] if wanted else []


def _card(text: list[str]) -> Card:
    whole = "".join(text)
    bounds = {(axis.lower(), end.lower()): float(value) for axis, end, value in _BOUND.findall(whole)}
    width, length = (
        (bounds.get((axis, "min"), 0.0), bounds.get((axis, "max"), float("inf"))) for axis in ("w", "l")
    )
    return Card(whole.split()[1], width, length, whole)
