"""The process of a foundry: its model cards, and the mapping file that puts our circuits on it.

A mapping is a TOML file (`netlists/foundry/mappings/gf180mcu.toml` is one, with its meaning in comments):

    [process]     name, package, extra, file, notice (of the cards), v_dd (V), temperature_c (degC)
    [n], [p]      model: name of the cards; section: where they stand in the file, `.lib section` to `.endl`
    [sizes]       width_factor, length_factor (1), least_width, least_length, most_width, diffusion (m)
    [parameters]  numbers for names that the cards use
    [biases]      NAME = { gate_of = "instance.device" } or { volts = 1.2 } for biases of kind voltage

`package` is the distribution on PyPI that brings `file`. It is an optional extra; only the file is read, none
of its code runs. Cards are binned: `nfet_03v3.0`, `nfet_03v3.1`, ... hold for W and L from wmin to wmax and
lmin to lmax; a deck gets the bins that its devices use, as literal text, and so runs where no package is.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

from circuits.errors import DataError, ParameterError, meant
from circuits.silicon.process import POLARITIES, Polarity

_SHIPPED = Path(__file__).parent / "mappings"
_CARD = re.compile(r"\.model\s+(\S+)\s", re.IGNORECASE)
_BOUND = re.compile(r"\b([lw])(min|max)\s*=\s*([-+.0-9e]+)", re.IGNORECASE)
_SIZES = ("width_factor", "length_factor", "least_width", "least_length", "most_width", "diffusion")


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

    def width(self, width: float) -> float:
        """Width on the foundry's process, m."""
        return max(self.width_factor * width, self.least_width)

    def length(self, length: float) -> float:
        """Length on the foundry's process, m."""
        return max(self.length_factor * length, self.least_length)

    def __str__(self) -> str:
        """The rule in a line, in um."""
        um = 1e6
        return (
            f"W' = {self.width_factor:g} W, at least {um * self.least_width:g} um;"
            f" L' = {self.length_factor:g} L, at least {um * self.least_length:g} um;"
            f" wider than {um * self.most_width:g} um in equal parts; capacitors as they are"
        )


@dataclass(frozen=True, slots=True)
class DeviceMapping:
    """A mapping file.

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
    sizes
        The rule of sizes.
    parameters
        Numbers for names that the cards use, in the cards' own units.
    biases
        For biases of kind voltage, by name: `gate_of` and the path of a device, or `volts` and a voltage, V.
    """

    name: str
    package: str
    extra: str
    file: str
    notice: str
    v_dd: float
    temperature_c: float
    models: Mapping[Polarity, tuple[str, str]]
    sizes: Sizes
    parameters: Mapping[str, float]
    biases: Mapping[str, tuple[str, str | float]]


@dataclass(frozen=True, slots=True)
class Card:
    """One bin of a foundry's model.

    Attributes
    ----------
    name
        Name of the card.
    width, length
        The bin holds for `width[0] <= W < width[1]`, and for lengths likewise, m.
    text
        Its `.model` card.
    """

    name: str
    width: tuple[float, float]
    length: tuple[float, float]
    text: str

    def holds(self, width: float, length: float) -> bool:
        """Whether a device of this size, m, is in the bin."""
        return self.width[0] <= width < self.width[1] and self.length[0] <= length < self.length[1]


def read_mapping(name: str) -> DeviceMapping:
    """Read a mapping: one that noctule ships, by its `name`, or a TOML file of one's own, by its path.

    Raises
    ------
    DataError
        No such mapping, no TOML, or an entry is missing or of the wrong kind.
    """
    path = _SHIPPED / f"{name}.toml"
    if not path.is_file():
        path = Path(name)
    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        shipped = sorted(p.stem for p in _SHIPPED.glob("*.toml"))
        advice = f"give a TOML file or one of {', '.join(shipped)}{meant(name, shipped)}"
        raise DataError(f"{name}: no mapping; {advice}") from error
    except (ValueError, RecursionError) as error:  # no TOML, no UTF-8, a number or brackets without end
        raise DataError(f"{path}: no TOML, {str(error)[:200]}; see the shipped mappings") from None
    return _mapping(str(path), tables)


def read_cards(mapping: DeviceMapping, polarity: Polarity) -> tuple[Card, ...]:
    """Bins of the transistor of one polarity.

    Raises
    ------
    DataError
        The package is not installed, or its file has no such section or model.
    """
    model, section = mapping.models[polarity]
    path = card_file(mapping)
    cards = tuple(_cards(_section(path, section), model))
    if not cards:
        raise DataError(f"{path}: no card of {model} in section {section}; is the mapping of this release?")
    return cards


def card_file(mapping: DeviceMapping) -> Path:
    """Place of the foundry's file; raises `DataError` where its package is not installed."""
    try:
        found = [f for f in metadata.files(mapping.package) or () if str(f) == mapping.file]
    except metadata.PackageNotFoundError as error:
        raise DataError(
            f"{mapping.name}: {mapping.package} is not installed; pip install 'noctule[{mapping.extra}]'"
        ) from error
    if not found:
        raise DataError(f"{mapping.name}: {mapping.package} has no {mapping.file}; install another release")
    return Path(str(found[0].locate()))


def choose_cards(mapping: DeviceMapping, polarity: Polarity, sizes: Iterable[tuple[float, float]]) -> str:
    """Text of the bins that devices of these (width, length), m, use.

    Raises `ParameterError` for a size that no bin has.
    """
    cards = read_cards(mapping, polarity)
    used = set()
    for width, length in sizes:
        held = [k for k, card in enumerate(cards) if card.holds(width, length)]
        if not held:
            raise ParameterError(
                f"{mapping.models[polarity][0]}: {width:g} m by {length:g} m, a size that no card holds for;"
                " change the mapping's sizes"
            )
        used.add(held[0])
    return "".join(cards[k].text for k in sorted(used))


def _mapping(path: str, tables: Mapping[str, Any]) -> DeviceMapping:
    process = _table(path, tables, "process")
    sizes = _table(path, tables, "sizes")
    models: dict[Polarity, tuple[str, str]] = {}
    for polarity in POLARITIES:
        table = _table(path, tables, polarity)
        models[polarity] = (_text(path, table, "model"), _text(path, table, "section"))
    return DeviceMapping(
        name=_text(path, process, "name"),
        package=_text(path, process, "package"),
        extra=_text(path, process, "extra"),
        file=_text(path, process, "file"),
        notice=_text(path, process, "notice"),
        v_dd=_number(path, process, "v_dd"),
        temperature_c=_number(path, process, "temperature_c"),
        models=models,
        sizes=Sizes(*(_number(path, sizes, key) for key in _SIZES)),
        parameters={k: _number(path, tables["parameters"], k) for k in tables.get("parameters", {})},
        biases={k: _bias(path, k, v) for k, v in tables.get("biases", {}).items()},
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
        raise DataError(f"{path}: no table [{key}]; see the shipped mappings")
    return table


def _text(path: str, table: Mapping[str, Any], key: str) -> str:
    if not isinstance(table.get(key), str):
        raise DataError(f"{path}: {key}, must be a text; see the shipped mappings")
    return str(table[key])


def _number(path: str, table: Mapping[str, Any], key: str) -> float:
    value = table.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise DataError(f"{path}: {key}, must be a number; see the shipped mappings")
    try:
        return float(value)
    except OverflowError:
        raise DataError(f"{path}: {key}, too large for a number; see the shipped mappings") from None


def _section(path: Path, section: str) -> Iterable[str]:
    """Lines of a section, `.lib NAME` to `.endl`; a reference `.lib FILE NAME` does not open one."""
    inside = False
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
