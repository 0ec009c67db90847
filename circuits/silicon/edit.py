"""Edits of a die: devices without their deviations, devices that alone have them, and deviations as told.

An edit names devices by a path as instance paths are written, `ranging_chip/neuron[2].membrane.mr1`. Between
names `/` and `.` are the same, and `-` is `_`. `*` stands for any part of a path, in brackets for any index,
and `?` for one letter. A path means all that is below it: `ranging_chip/neuron[2]` all devices of that
neuron, `ranging_chip/neuron` those of all 13, and `...mr1.v_t0` one parameter of one device. What all devices
of a polarity share on a die is `process.n` and `process.p`, what its capacitors, resistors and diodes share
`process.capacitor`, `process.resistor` and `process.diode`. Of a die with components of variation `lot.n`,
`wafer.n` and `die.n` are the parts that its lot, its wafer and itself have in that, and `gradient.n` the
planes across it, `gradient.n.x.v_t0` one slope; a device that is healed or set has nothing of a plane.

| kind | what it does |
|---|---|
| `only` | nothing but what the paths match deviates, the process included |
| `heal` | what the paths match does not deviate |
| `set` | a parameter of what the path matches deviates by a value, whatever the die draws |

A die has one `only` at most. What is healed is taken from it, and what is set goes over both, the last one
first. A corner is edited as the draw is in whose place it stands.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.checks import require_choice, require_real
from circuits.errors import ParameterError
from circuits.silicon.sampling import labels

Path = tuple[tuple[str, tuple[int, ...]], ...]
Kind = Literal["only", "heal", "set"]
KINDS: tuple[Kind, ...] = ("only", "heal", "set")

DEVIATIONS = {"v_t0": "V", "beta": "", "capacitance": "", "resistance": "", "saturation_current": ""}
"""Parameters that an edit can set, with the unit of their deviation: V_T0's in V, the others relative."""

SHARED = "shared."  # before a parameter that a die's devices share
_BRACKETS = re.compile(r"\[([0-9,*]*)\]")
_ANY = r"(?:[^\[\]]|\[[0-9,]*\])*"


@dataclass(frozen=True, slots=True)
class Edit:
    """One edit of a die.

    Attributes
    ----------
    kind : str
        `heal`, `only` or `set`.
    paths : tuple of str
        What it is about, each as the module says.
    parameter : str
        What is set, one of `DEVIATIONS`; empty for the other kinds.
    value : float
        What it deviates by, V of the threshold's magnitude, else relative; 0 for the other kinds.

    Raises
    ------
    ParameterError
        The kind or the parameter is unknown, there is no path, the value is not finite, or a relative one is
        not above -1.
    """

    kind: Kind
    paths: tuple[str, ...]
    parameter: str = ""
    value: float = 0.0

    def __post_init__(self) -> None:
        require_choice("edit.kind", self.kind, KINDS)
        object.__setattr__(self, "paths", tuple(_canonical(path) for path in self.paths))
        if not self.paths or not all(self.paths):
            raise ParameterError(f"{self.kind}: no path, must name devices as chip/neuron[2].m1")
        if self.kind == "set":
            require_choice(f"{self.paths[0]}.parameter", self.parameter, tuple(DEVIATIONS))
            require_real(f"{self.paths[0]}.{self.parameter}", self.value, DEVIATIONS[self.parameter])
            if not math.isfinite(self.value):
                raise ParameterError(f"{self.paths[0]}.{self.parameter}: {self.value:g}, must be finite")
            if not DEVIATIONS[self.parameter] and self.value <= -1.0:  # a current or a size of no device
                raise ParameterError(
                    f"{self.paths[0]}.{self.parameter}: changes by {100.0 * self.value:g} %, must be above"
                    " -100 %; state a smaller deviation"
                )

    def __str__(self) -> str:
        """In words: `healed chip.neuron[2]`, `only chip.m1`, `chip.m1.v_t0 set to 0.01`."""
        if self.kind == "set":
            return f"{self.paths[0]}.{self.parameter} set to {self.value!r}"
        return f"{'healed' if self.kind == 'heal' else 'only'} {', '.join(self.paths)}"


class Edited(NamedTuple):
    """What edits make of draws: kept, float64[n], 0 or 1, and value, float64[n], NaN where none is set."""

    kept: F64
    value: F64

    def of(self, drawn: F64 | float) -> F64:
        """Deviations of what was drawn."""
        return np.where(np.isnan(self.value), np.multiply(self.kept, drawn), self.value)


def ordered(edits: Iterable[Edit]) -> tuple[Edit, ...]:
    """Put edits into the order in which they hold; raises `ParameterError` for more than one `only`."""
    found = sorted(edits, key=lambda edit: KINDS.index(edit.kind))
    if len(found) > 1 and found[1].kind == "only":
        raise ParameterError(
            f"only: {found[1].paths[0]} beside {found[0].paths[0]}, must be one list of paths"
        )
    return tuple(found)


def edits_of(edits: Iterable[Edit], names: Iterable[str]) -> tuple[Edit, ...]:
    """Leave out what edits say of circuits whose paths begin with other names.

    A path that begins with a wildcard stays, and so does what alone deviates: without it all would.
    """
    known, found = {*names}, []
    for edit in edits:
        paths = tuple(p for p in edit.paths if edit.kind == "only" or _first_name(p) in known | {""})
        if paths:
            found.append(replace(edit, paths=paths))
    return tuple(found)


def _first_name(path: str) -> str:
    """The name at which a path begins; empty where that has a wildcard."""
    name = re.split(r"[.\[]", path, maxsplit=1)[0]
    return "" if {*"*?"} & {*name} else name


def unmatched(edits: Iterable[Edit], families: Iterable[tuple[Path, Sequence[Path], str]]) -> list[str]:
    """List the paths of edits that mean nothing of what some circuits draw, or nothing of what is set.

    families: place, paths and parameter of what is drawn, each as of `matched`.
    """
    known = list(families)
    return [
        path
        for edit in edits
        for path in edit.paths
        if not any(
            matched((path,), place, paths, name).any()
            for place, paths, name in known
            if edit.parameter in {"", name.removeprefix(SHARED)}
        )
    ]


def edited(edits: Sequence[Edit], place: Path, paths: tuple[Path, ...], parameter: str) -> Edited | None:
    """Return what edits make of a parameter at all places of some paths; None where they leave all as it is.

    edits, place, paths, parameter: as of `circuits.silicon.die.standard_normals`.
    """
    count = sum(math.prod(n for _, shape in path for n in shape) for path in paths)
    kept, value = np.ones(count), np.full(count, np.nan)
    for edit in edits:
        if edit.kind == "set" and edit.parameter != parameter.removeprefix(SHARED):
            continue
        found = np.zeros(count, np.bool_)
        for path in edit.paths:
            asked = _asked(path)
            if (place, paths, parameter) not in asked:
                asked[place, paths, parameter] = np.flatnonzero(matched((path,), place, paths, parameter))
            found[asked[place, paths, parameter]] = True
        if edit.kind == "set":
            value[found] = edit.value
        else:
            healed = found if edit.kind == "heal" else ~found
            kept[healed], value[healed] = 0.0, np.nan
    if kept.all() and np.isnan(value).all():
        return None
    return Edited(kept, value)


@lru_cache(maxsize=4096)
def _asked(path: str) -> dict[tuple[Path, tuple[Path, ...], str], I64]:
    """What was asked of a path in this process, and the numbers of the places that it meant there."""
    return {}


def not_met(edits: Iterable[Edit]) -> dict[str, list[tuple[Path, tuple[Path, ...]]]]:
    """Return the paths of edits that meant nothing of all that this process drew, with what it drew."""
    found = {path: _asked(path) for edit in edits for path in edit.paths}
    return {
        path: [(place, paths) for place, paths, _ in asked]
        for path, asked in found.items()
        if not any(each.size for each in asked.values())
    }


def overlap(one: str, other: str) -> bool:
    """Whether two paths of edits may mean the same device, whatever their indices; so it is in doubt."""
    if all({*"*?"} & {*_BRACKETS.sub("", _canonical(path))} for path in (one, other)):
        return True
    texts = [_BRACKETS.sub("[0]", _canonical(path)) for path in (one, other)]
    patterns = [_patterns(_canonical(path)).loose for path in (one, other)]
    return any(
        pattern.fullmatch(text) is not None for pattern, text in zip(patterns, reversed(texts), strict=True)
    )


def matched(wanted: Iterable[str], place: Path, paths: Sequence[Path], parameter: str) -> Bools:
    """Say of each place of some paths whether a path of an edit means it, bool[places]."""
    patterns = [_patterns(_canonical(text)) for text in wanted]
    found = [np.zeros(0, np.bool_)]
    for path in paths:
        shape = [n for _, dimensions in path for n in dimensions]
        own = np.zeros(math.prod(shape), np.bool_)
        for one in patterns if own.size else ():
            first = _shown(labels(place, [_first(path)], parameter)[0])
            if one.loose.fullmatch(first) is None:
                continue
            if one.any_index:
                own[:] = True
                break
            own |= _at_index(one, place, path, parameter)
        found.append(own)
    return np.concatenate(found)


def _at_index(one: _Patterns, place: Path, path: Path, parameter: str) -> Bools:
    """Places of a path that a pattern means by its indices, bool[places]."""
    shape = tuple(n for _, dimensions in path for n in dimensions)
    if one.indices is None:
        each = labels(place, [path], parameter)
        return np.array([one.exact.fullmatch(_shown(label)) is not None for label in each])
    own, where = np.zeros(shape, np.bool_), _selected(one.indices, place, path)
    if where is not None:
        own[where] = True
    return own.ravel()


def _selected(indices: Sequence[_Index], place: Path, path: Path) -> tuple[int | slice, ...] | None:
    """Where in the array of a path's places those of some indices are; None for none.

    indices: those of each indexed name from the first on, None for any.
    """
    wanted = iter(indices)
    where: list[int | slice] = []
    for fixed, own in [(True, index) for _, index in place] + [(False, shape) for _, shape in path]:
        asked = next(wanted, None) if own else ()
        if asked is not None and len(asked) != len(own):
            return None
        if asked is not None and (asked != own if fixed else not _within(asked, own)):
            return None
        where += [] if fixed else [slice(None)] * len(own) if asked is None else asked
    return tuple(where)


def _within(index: tuple[int, ...], shape: tuple[int, ...]) -> bool:
    return all(n < limit for n, limit in zip(index, shape, strict=True))


_Index = tuple[int, ...] | None  # of one name, None for any


class _Patterns(NamedTuple):
    """Patterns of a path: with its indices, and with any in their place; whether it names none.

    indices: of each name that has some, where nothing outside of brackets is a wildcard; else None.
    """

    exact: re.Pattern[str]
    loose: re.Pattern[str]
    any_index: bool
    indices: tuple[_Index, ...] | None


@lru_cache(maxsize=4096)
def _patterns(text: str) -> _Patterns:
    inside = _BRACKETS.findall(text)
    any_index = all(one == "*" for one in inside)
    return _Patterns(
        _compiled(text, exact=True), _compiled(text, exact=False), any_index, _indices(text, inside)
    )


def _indices(text: str, inside: Sequence[str]) -> tuple[_Index, ...] | None:
    if {*"*?"} & {*_BRACKETS.sub("", text)} or any("*" in one and one != "*" for one in inside):
        return None
    if not all(part.isdecimal() for one in inside if one != "*" for part in one.split(",")):
        return None
    return tuple(None if one == "*" else tuple(map(int, one.split(","))) for one in inside)


def _compiled(text: str, *, exact: bool) -> re.Pattern[str]:
    """The pattern of a path and of all that is below it."""
    parts = []
    for k, part in enumerate(_BRACKETS.split(text)):
        if k % 2:
            inside = part.replace("*", "[0-9,]*") if exact and part != "*" else "[0-9,]*"
            parts.append(rf"\[{inside}\]")
        else:
            parts.append(
                "".join(_ANY if c == "*" else r"[^\[\]]" if c == "?" else re.escape(c) for c in part)
            )
    return re.compile(f"{''.join(parts)}(?:[.\\[].*)?")


def _canonical(path: str) -> str:
    return str(path).strip().replace("/", ".").replace("-", "_").rstrip(".")


def _shown(label: str) -> str:
    """A label of a draw as paths of edits are matched against it."""
    owner, _, parameter = label.rpartition(".")
    return f"{owner.removesuffix('.' + SHARED[:-1])}.{parameter}"


def _first(path: Path) -> Path:
    """The first place of a path, as a path of its own."""
    return tuple((name, (1,) * len(shape)) for name, shape in path)
