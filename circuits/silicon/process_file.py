"""Processes by name, a foundry's by our law, and a user's own from a file.

`extracted/NAME.toml` is our law as `noctule extract` fitted it to the cards of the foundry's process NAME,
`measured/NAME.toml` as it fitted it to measurements of a chip.

A file is TOML with the fields of `circuits.silicon.process.Process` in SI units; its transistors stand in
the tables `n` and `p` (`TransistorModel`), its spread from die to die in `variation` (`Variation`). Every
field is stated, the second-order effects too: one that the process does not have is 0. These tables may be
left out: `components` (`Components`) by a process whose dies have the plain variation, `diodes`
(`DiodeVariation`) where diodes do not deviate, and `n.size` and `p.size` (`SizeTerms`) where transistors of
all sizes share their numbers.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any

from circuits.catalogue import later
from circuits.checks import require_real
from circuits.errors import DataError, ParameterError, meant
from circuits.silicon.components import Components
from circuits.silicon.process import (
    POLARITIES,
    PROCESSES,
    DiodeVariation,
    Effects,
    Process,
    TransistorModel,
    Variation,
)
from circuits.silicon.size import SizeTerms
from circuits.silicon.toml_file import read_toml

tomli_w = later("tomli_w")  # many a run writes no file

_PARTS: Mapping[str, type] = {"n": TransistorModel, "p": TransistorModel, "variation": Variation}
_EXTRACTED = Path(__file__).parent / "extracted"
_MORE: Mapping[str, type] = {"components": Components, "diodes": DiodeVariation}
_MEASURED = Path(__file__).parent / "measured"
_SIZE = "size"
_LEFT_OUT = {*_MORE, _SIZE}  # tables that may be
_OURS = {"cards"}  # what no file says
_TEXTS = {"name", "law", "cards"}
_SIGNED = {
    "v_t0", "v_t0_drift", "mobility_exponent", "early_rise", "nominal_temperature_c", "correlation_v_t0",
    "correlation_beta",
}  # fmt: skip
_ABOVE_ZERO = {"v_dd", "kappa", "mu_cox"}
_DIVISORS = {"gate_induced_slope": "gate_induced_leakage", "leakage_doubling": "junction_leakage"}
"""Figures by which the law divides, by what they belong to: without that they may be 0."""
_UNLIMITED = {"most_width", "most_length"}  # where a box may have no end

UNREADABLE: Mapping[str, str] = {
    "ihp-sg13g2": (
        "its cards (c4m-pdk-ihpsg13g2) are of PSP 103.6, which ngspice takes as a compiled OSDI library"
        " alone,"
        " and the package brings none"
    ),
}
"""Foundries' processes that are known and cannot be had, with the reason."""


def read_process(path: Path) -> Process:
    """Read a process from a TOML file.

    Raises
    ------
    DataError
        The file cannot be read, is no TOML, lacks a term or has one that no process has, or a number is not
        finite or has a sign that it cannot have.
    ParameterError
        A value breaks a rule of the process.
    """
    given = read_toml(path, "a process's TOML file")
    whole = _complete(path, "process", Process, given)
    tables = {**_PARTS, **{name: kind for name, kind in _MORE.items() if name in whole}}
    parts = {name: kind(**_model(path, name, kind, whole[name])) for name, kind in tables.items()}
    process = Process(**{**whole, **parts})
    for place, value in _numbers(asdict(process)):
        _check_number(f"{path}: {'.'.join(place)}", place, value)
    for polarity in POLARITIES:
        _check_divisors(f"{path}: {polarity}", process.model(polarity))
    return process


def _check_divisors(label: str, model: TransistorModel) -> None:
    """Refuse a figure of 0 by which the law divides."""
    needed = [name for name, effect in _DIVISORS.items() if getattr(model, effect)]
    needed += ["surface_potential"] if model.law == "ekv-gamma" else []
    for name in needed:
        if not getattr(model, name) > 0.0:
            raise DataError(f"{label}.{name}: 0, must be > 0 with this law and its effects; correct it")


def _numbers(table: Mapping[str, Any], above: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Every number of a process, with the names of its tables and its own."""
    for name, value in table.items():
        if isinstance(value, dict):
            yield from _numbers(value, (*above, name))
        elif value is not None and name not in _TEXTS:
            yield from (((*above, name), one) for one in (value if isinstance(value, tuple) else (value,)))


def _check_number(label: str, place: tuple[str, ...], value: Any) -> None:
    """Refuse what is no number, is not finite, or has a sign that no process has."""
    require_real(label, value, "SI")
    name, signed = place[-1], place[-1] in _SIGNED or _SIZE in place
    if not math.isfinite(value) and not (name in _UNLIMITED and value > 0.0):
        raise DataError(f"{label}: {value:g}, must be finite; correct it")
    if name in _ABOVE_ZERO and not signed and not value > 0.0:
        raise DataError(f"{label}: {value:g}, must be > 0; correct it")
    if not signed and value < 0.0:
        raise DataError(f"{label}: {value:g}, must be >= 0; correct it")


def format_process(process: Process, head: str = "") -> str:
    """Give the text of a file that `read_process` reads as this process, to the bit.

    Parameters
    ----------
    process
        The process; its foundry's cards are no part of a file.
    head
        Lines of comment that come first.
    """
    comment = "".join(f"# {line}".rstrip() + "\n" for line in head.splitlines())
    return f"{comment}{tomli_w.dumps(_stated(asdict(process)))}"


def _stated(table: Mapping[str, Any]) -> dict[str, Any]:
    """A dataclass's fields as a file has them: what is left out has no entry."""
    plain = {name: value for name, value in table.items() if value is not None and name not in _OURS}
    return {name: _stated(value) if isinstance(value, dict) else value for name, value in plain.items()}


def foundry_names() -> list[str]:
    """Names of the foundries' processes that our law was fitted to, in alphabetical order."""
    return sorted(path.stem for path in _EXTRACTED.glob("*.toml"))


@functools.lru_cache(maxsize=8)
def foundry_process(name: str) -> Process:
    """Give our law as it was fitted to a foundry's process, which stands for the foundry's cards.

    Raises `ParameterError` for a name that is none of `foundry_names`.
    """
    if name not in foundry_names():
        raise ParameterError(f"process: {name}, must be one of {', '.join(foundry_names())}")
    return replace(read_process(_EXTRACTED / f"{name}.toml"), cards=name)


def measured_names() -> list[str]:
    """Names of the processes that our law was fitted to by measurements, in alphabetical order."""
    return sorted(path.stem for path in _MEASURED.glob("*.toml"))


def process_of(text: str) -> Process:
    """Give the process of a name, or that of a file.

    Parameters
    ----------
    text
        A name of `PROCESSES`, of a foundry's or a measured process, or a file `.toml`. A foundry's gives our
        law as it was fitted to its cards; what runs in ngspice takes the cards themselves.

    Raises
    ------
    ParameterError
        There is no such name.
    DataError
        The file is missing, or no process.
    """
    if text in PROCESSES:
        return PROCESSES[text]
    if text in measured_names():
        return read_process(_MEASURED / f"{text}.toml")
    if text in foundry_names():
        return foundry_process(text)
    if text in UNREADABLE:
        raise ParameterError(f"process: {text}, {UNREADABLE[text]}; take one of {', '.join(_known())}")
    path = Path(text)
    if path.suffix == ".toml" or path.exists():
        return read_process(path)
    raise ParameterError(
        f"process: {text}, must be one of {', '.join(_known())}, or a .toml file{meant(text, _known())}"
    )


def _known() -> list[str]:
    return [*PROCESSES, *foundry_names(), *measured_names()]


def process_under(own: Process, text: str | None, effects: Effects) -> Process:
    """Give a block's process, or the one that `text` names, under a law.

    Parameters
    ----------
    own
        The block's process, which may be stated without its second-order effects.
    text
        Name or file of another one.
    effects
        `full` for all second-order effects, `ideal` for none.

    Raises
    ------
    DataError, ParameterError
        As `process_of`.
    """
    if text is not None:
        return process_of(text).under(effects)
    stated = PROCESSES.get(own.name)
    whole = stated if stated is not None and stated.ideal() == own else own
    return whole.under(effects)


def _model(path: Path, where: str, kind: type, given: object) -> dict[str, Any]:
    """The table of a dataclass's fields, with the terms of the size as such where it has them."""
    whole = _complete(path, where, kind, given)
    if whole.get(_SIZE) is None:
        return whole
    size = whole[_SIZE]
    if isinstance(size, dict):
        size = {k: tuple(v) if isinstance(v, list) else v for k, v in size.items()}
    return {**whole, _SIZE: SizeTerms(**_complete(path, f"{where}.{_SIZE}", SizeTerms, size))}


def _complete(path: Path, where: str, kind: Any, given: object) -> dict[str, Any]:
    """The table of a dataclass's fields, none missing and no other."""
    if not isinstance(given, dict):
        raise DataError(f"{path}: {where}: {given!r:.40}, must be a table with the terms of a process")
    names = [f.name for f in fields(kind) if f.name not in _OURS]
    missing = [name for name in names if name not in given and name not in _LEFT_OUT]
    if missing:
        raise DataError(
            f"{path}: {where}: lacks {', '.join(missing)}; state each, 0 for an effect it has not"
        )
    unknown = next((name for name in given if name not in names), None)
    if unknown is not None:
        raise DataError(f"{path}: {where}.{unknown}: no such term{meant(unknown, names)}; leave it out")
    return given
