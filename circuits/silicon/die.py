"""Deviations of devices on a die, each a pure function of the die and of the device's name.

A die is a key, not a stream of random numbers. The deviation of a parameter of a device follows from the lot,
the die's number, the device's instance path and the parameter's name: the counter-based generator
Philox4x32-10 takes a key hashed from these names, and the array indices of the path as its counter. So
neither the order of the draws, nor edits elsewhere in a circuit, nor the number of workers change a device's
deviation, and whole arrays are drawn at once. A name with indices and the same name without any are two
places: `neuron` and `neuron[0]` differ, while `neuron[0]` of an array of 1 and of 13 are the same.

Local mismatch falls with the square root of area (Pelgrom 1989). Published coefficients A are those of a pair
of devices, so that one device has `sigma = A / sqrt(2 m W L)`. Process variation is one draw for each die,
polarity and parameter; a corner sets it to plus or minus 3 sigma instead.

A die may have more components (`circuits.silicon.components`). What its devices share is then the sum of
draws of its lot, its wafer and its own, `sqrt(share) z` each, so that their variance together is the same,
and nFETs and pFETs are correlated. Each draw is keyed by what it belongs to: the lot, the lot and the wafer,
the lot and the die. A draw of a lot or a wafer is that of all its dies.

Source: Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3" (2011), Philox4x32-10.
"""

from __future__ import annotations

import hashlib
import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import lru_cache
from typing import Literal, NamedTuple

import numpy as np

from circuits.arrays import F64, I64, U32, in_rows
from circuits.checks import require_choice, require_type
from circuits.compiled import compiled
from circuits.errors import ParameterError
from circuits.silicon.components import DIES_A_WAFER, EXTENTS, Components, Extent
from circuits.silicon.edit import SHARED, Edit, edited, edits_of, ordered
from circuits.silicon.normal import fill_normals, philox_words
from circuits.silicon.process import Polarity, Process
from circuits.silicon.sampling import Sampling

Path = tuple[tuple[str, tuple[int, ...]], ...]  # ((name, shape), ...): all places of an array
Place = tuple[tuple[str, tuple[int, ...]], ...]  # ((name, index), ...): one place

Corner = Literal["random", "typical", "ss", "ff", "sf", "fs"]
CORNERS: tuple[Corner, ...] = ("random", "typical", "ss", "ff", "sf", "fs")
"""Corners that a die can have: `random` draws it, the others are 3 sigma of both polarities either way."""
CORNER_SIGMAS = 3.0
# Direction of (n, p) at each corner: slow is a higher |V_T0| and a lower beta.
_SLOW = {"typical": (0, 0), "ss": (1, 1), "ff": (-1, -1), "sf": (1, -1), "fs": (-1, 1)}

PARAMETERS = ("v_t0", "beta")
# no device has a dotted parameter, so that a circuit called `process` shares no key with `shared.v_t0`
_SHARED = SHARED
SHARED_PLACE: Place = (("process", ()),)
WAFER_PLACE: Place = (("wafer", ()),)
LOT_PLACE: Place = (("lot", ()),)
DIE_PLACE: Place = (("die", ()),)
"""Of edits: what a die has beside its lot and its wafer; its draws are those of `SHARED_PLACE`."""
LEVELS = (LOT_PLACE, WAFER_PLACE, DIE_PLACE)
"""What makes up what a die's devices share, as edits name it one by one."""
GRADIENT_PLACE: Place = (("gradient", ()),)
SHARED_NAMES = tuple(place[0][0] for place in (SHARED_PLACE, *LEVELS, GRADIENT_PLACE))
"""Names at which paths begin that are of no single device."""

_SHARED_KINDS = tuple(
    (kind, name)
    for kinds, names in (
        (("n", "p"), PARAMETERS),
        (("capacitor",), ("capacitance",)),
        (("resistor",), ("resistance",)),
        (("diode",), ("saturation_current",)),
    )
    for kind in kinds
    for name in names
)  # kind and parameter of what devices of a kind share

_COUNTERS = 4  # 32-bit words of the counter: index dimensions that a path may have


@dataclass(frozen=True, slots=True)
class Die:
    """A die, chosen by its lot and its number.

    Attributes
    ----------
    lot : str
        Name of the lot.
    number : int or None
        Number in the lot; None is the nominal die, without mismatch and with the process as the corner says,
        where `random` means typical.
    corner : str
        Process corner, or `random` for the die's own draw.
    mismatch, process : bool
        Whether local deviations, and those that all devices of a die share, are drawn.
    sampling : Sampling or None
        Plan of a study whose draws take the place of the die's own.
    variation : str
        Which components of variation it has beside: `plain` for none, `transistors` for those of
        transistors, `full` for those of capacitors and resistors too.
    edits : tuple of Edit
        What was changed of it by hand (`circuits.silicon.edit`), in the order in which it holds.
    """

    lot: str = "A"
    number: int | None = None
    corner: Corner = "random"
    mismatch: bool = True
    process: bool = True
    sampling: Sampling | None = None
    variation: Extent = "plain"
    edits: tuple[Edit, ...] = ()

    def __post_init__(self) -> None:
        """Keep lot and number in Python's own types: the key is made of their text."""
        object.__setattr__(self, "lot", str(self.lot))
        if self.number is not None:
            object.__setattr__(self, "number", _whole(self.number))
        require_choice("corner", self.corner, CORNERS)
        require_choice("variation", self.variation, EXTENTS)
        object.__setattr__(self, "edits", ordered(self.edits))
        for name in ("mismatch", "process"):
            require_type(f"die.{name}", getattr(self, name), bool, "True or False")

    def __repr__(self) -> str:
        """As of every dataclass; plain variation and no edits go unsaid, as names of kept runs have it."""
        unsaid = {"variation": self.variation == "plain", "edits": not self.edits}
        told = [f.name for f in fields(self) if not unsaid.get(f.name, False)]
        return f"Die({', '.join(f'{name}={getattr(self, name)!r}' for name in told)})"

    def __str__(self) -> str:
        """As in a netlist's title: `die A/1003`, with the corner where one is set."""
        name = "die nominal" if self.number is None else f"die {self.lot}/{self.number}"
        parts = [name, "" if self.corner == "random" else self.corner]
        if self.number is not None:
            parts += ["" if self.mismatch else "no mismatch", "" if self.process else "no process variation"]
            parts += ["" if self.variation == "plain" else f"{self.variation} variation"]
        if self.number is not None and self.sampling is not None:
            parts.append(f"plan {self.sampling.name}")
        return ", ".join([" ".join(p for p in parts if p), *map(str, self.edits)])

    @property
    def deviates(self) -> bool:
        """Whether some device may deviate on it: it is a drawn die, or a deviation is set by hand."""
        return self.number is not None or any(edit.kind == "set" for edit in self.edits)

    def sets(self, *parameters: str) -> bool:
        """Whether an edit sets a parameter.

        Parameters
        ----------
        parameters
            Names of some parameters, of which any will do.
        """
        return any(edit.parameter in parameters for edit in self.edits)

    def healed(self, *paths: str) -> Die:
        """Return the die with devices that do not deviate.

        Parameters
        ----------
        paths
            Paths of the devices, as `ranging_chip/neuron[2].membrane.mr1` or `ranging_chip/*`
            (`circuits.silicon.edit`).

        Raises
        ------
        ParameterError
            There is no path.
        """
        return replace(self, edits=(*self.edits, Edit("heal", paths)))

    def only(self, *paths: str) -> Die:
        """Return the die on which these devices alone deviate; what devices share does not, unless named.

        Parameters
        ----------
        paths
            Paths of the devices, as of `healed`.

        Raises
        ------
        ParameterError
            There is no path, or the die has others that alone deviate.
        """
        return replace(self, edits=(*self.edits, Edit("only", paths)))

    def with_(self, path: str, parameter: str, value: float) -> Die:
        """Return the die with a parameter of devices that deviates by a value, whatever the die draws.

        Parameters
        ----------
        path
            Path of the devices, as of `healed`.
        parameter
            `v_t0`, `beta`, `capacitance`, `resistance` or `saturation_current`.
        value
            Its deviation: V of the threshold's magnitude, else relative and dimensionless.

        Raises
        ------
        ParameterError
            The parameter is unknown, or the value is not finite.
        """
        return replace(self, edits=(*self.edits, Edit("set", (path,), parameter, float(value))))

    def without_mismatch(self) -> Die:
        """Return the die with what its devices share alone: neither draws nor edits of single devices."""
        return replace(self, mismatch=False, edits=self.shared_edits)

    def seen_by(self, *names: str) -> Die:
        """Return the die without those edits that are of other circuits.

        Parameters
        ----------
        names
            Names at which the paths of the circuits' devices begin.
        """
        return replace(self, edits=edits_of(self.edits, (*names, *SHARED_NAMES)))

    @property
    def shared_edits(self) -> tuple[Edit, ...]:
        """What its edits do to what devices share, as edits that touch no single device."""
        found: list[Edit] = []
        for kind, name in _SHARED_KINDS if self.edits else ():
            changed = edited(self.edits, SHARED_PLACE, (((kind, ()),),), _SHARED + name)
            whole = math.nan if changed is None else float(changed.of(0.0)[0])
            set_whole = changed is not None and not math.isnan(float(changed.value[0]))
            levels = [level_value(self.edits, level, kind, name) for level in LEVELS]
            if set_whole or (changed is not None and (self.corner != "random" or levels == [0.0] * 3)):
                found.append(_as_edit(SHARED_PLACE, kind, name, whole))
            elif self.corner == "random":
                found += [
                    _as_edit(level, kind, name, value)
                    for level, value in zip(LEVELS, levels, strict=True)
                    if value is not None
                ]
        return tuple(found)

    @property
    def components(self) -> bool:
        """Whether its transistors have components of variation beside the plain ones."""
        return self.number is not None and self.variation != "plain"


Family = tuple[Place, tuple[Path, ...], str]  # place, paths and parameter, as of `standard_normals`


class Drawn(NamedTuple):
    """What was drawn for a family: float64[places], V of V_T0 and else relative, in a process."""

    value: F64
    process: Process


SLOPE = "slope."  # before a parameter of devices by which it is noted what gradients add to it
_NOTED = "noted."  # begins a path that means no device, of a die whose draws are noted


def noted(die: Die, name: str) -> Die:
    """Return the die healed of all, of which this process notes what it would have drawn (`drawn_for`).

    name: of what it is noted for, which must differ between things that are drawn side by side.
    """
    return die.healed("*", f"{_NOTED}{name}")


@lru_cache(maxsize=8)
def drawn_for(die: Die) -> dict[Family, Drawn]:
    """What this process drew for a die of `noted`, before edits."""
    return {}


NOMINAL = Die()
"""The nominal die, on which nothing deviates."""


class Shift(NamedTuple):
    """Deviations that all devices of one polarity share: V_T0 (V, of the magnitude) and relative beta."""

    v_t0: float
    beta: float


def standard_normals(die: Die, place: Place, paths: Sequence[Path], parameter: str) -> F64:
    """Standard normal draws of devices at all their places, path after path, row-major over its shapes.

    place: where the circuit stands, ((chip, ()), (instance, index), ...). paths: ((name, shape), ...) from
    there on, the device's name last with shape (). parameter: name of what is drawn. Raises `ParameterError`
    for more than four index dimensions in all.
    """
    names, key = [place_names(place, path) for path in paths], _key(die, place, parameter)
    own = _normals(key, names, places_of(place, paths), parameter)
    planned = _planned(die, place, paths, parameter, own)
    changed = edited(die.edits, place, tuple(paths), parameter) if die.edits else None
    return planned if changed is None else changed.kept * planned


def mismatch(
    die: Die, process: Process, place: Place, paths: Sequence[Path], area: F64 | float
) -> tuple[F64 | float, F64 | float]:
    """Local deviations of transistors: V_T0 (V) and relative beta, float64[count] in the order of the paths.

    area: m W L of each, float64[count], or of all, m^2. Both results are 0 where the die has no mismatch.
    """
    found = _drawn_mismatch(die, process, place, paths, area)
    if not die.edits:
        return found
    v_t0, beta = (
        _edited(die, process, (place, tuple(paths), name), drawn)
        for name, drawn in zip(PARAMETERS, found, strict=True)
    )
    return v_t0, beta


def alike(dies: Sequence[Die]) -> bool:
    """Whether these are drawn dies with plain draws of their own, which differ in their numbers alone."""
    kinds = {(die.lot, die.corner, die.mismatch, die.process, die.variation) for die in dies}
    return len(kinds) == 1 and all(
        die.number is not None and die.variation == "plain" and die.sampling is None and not die.edits
        for die in dies
    )


def mismatch_of(
    dies: Sequence[Die],
    process: Process,
    place: Place,
    paths: Sequence[Path],
    area: F64,
    normals: Normals | None = None,
) -> tuple[F64, F64]:
    """What `mismatch` says of each of several dies that are `alike`, float64[dies, count] each.

    normals: what draws, `normals_of` unless given.
    """
    if not dies[0].mismatch:
        return np.zeros((len(dies), area.size)), np.zeros((len(dies), area.size))
    root, names, places = (
        np.sqrt(2.0 * area),
        [place_names(place, path) for path in paths],
        places_of(place, paths),
    )
    owners = _keys(dies)
    draw = normals or normals_of
    v_t0, beta = (draw(owners, names, places, name) for name in PARAMETERS)
    return v_t0 * process.pair_a_vt / root, beta * process.pair_a_beta / root


def shared_of(
    dies: Sequence[Die], process: Process, polarity: Polarity, normals: Normals | None = None
) -> tuple[F64, F64]:
    """What `shared` says of each of several dies that are `alike`, float64[dies] each; normals as there."""
    if dies[0].corner != "random" or not dies[0].process:
        shift = shared(dies[0], process, polarity)
        return np.full(len(dies), shift.v_t0), np.full(len(dies), shift.beta)
    path: Path = ((polarity, ()),)
    names, places = [place_names(SHARED_PLACE, path)], places_of(SHARED_PLACE, [path])
    owners = _keys(dies)
    draw = normals or normals_of
    v_t0, beta = (draw(owners, names, places, _SHARED + name)[:, 0] for name in PARAMETERS)
    return v_t0 * process.variation.sigma_v_t0, beta * process.variation.sigma_beta


def _edited(die: Die, process: Process, what: Family, drawn: F64 | float) -> F64 | float:
    """Deviations after the die's edits."""
    changed = edited(die.edits, *what)
    if changed is None:
        return drawn
    note(die, what, np.broadcast_to(np.asarray(drawn), changed.kept.shape), process)
    return changed.of(drawn)


def _drawn_mismatch(
    die: Die, process: Process, place: Place, paths: Sequence[Path], area: F64 | float
) -> tuple[F64 | float, F64 | float]:
    if die.number is None or not die.mismatch:
        return 0.0, 0.0
    root = np.sqrt(2.0 * np.asarray(area))
    names, places = [place_names(place, path) for path in paths], places_of(place, paths)
    key = _key(die, place, PARAMETERS[0])
    v_t0, beta = (
        _planned(die, place, paths, name, _normals(key, names, places, name)) for name in PARAMETERS
    )
    return v_t0 * process.pair_a_vt / root, beta * process.pair_a_beta / root


def shared(die: Die, process: Process, polarity: Polarity) -> Shift:
    """Deviations that all devices of a polarity share on a die; raises as `components_of`."""
    drawn, variation = _drawn_shared(die, process, polarity), process.variation
    if not die.edits:
        return drawn
    each = zip(PARAMETERS, (variation.sigma_v_t0, variation.sigma_beta), drawn, strict=True)
    return Shift(*(_edited_shared(die, process, (polarity, n, sigma), value) for n, sigma, value in each))


def unnoted(die: Die) -> Die:
    """The die that a die of `noted` was, any other die itself."""
    kept = tuple(edit for edit in die.edits if not any(path.startswith(_NOTED) for path in edit.paths))
    return die if len(kept) == len(die.edits) else replace(die, edits=kept)


def note(die: Die, what: Family, drawn: F64, process: Process) -> None:
    """Keep what was drawn for a family, of a die whose draws are noted; of any other die do nothing."""
    if unnoted(die) is not die:
        drawn_for(die)[what] = Drawn(drawn, process)


def level_value(edits: Sequence[Edit], level: Place, kind: str, parameter: str) -> float | None:
    """What edits make of the part of a lot, a wafer or a die in what its devices share of a parameter.

    level: one of `LEVELS`. The result is None where they leave it, 0 where it is healed, else what is set.
    What edits do to the whole goes for each part of it, but for a value.
    """
    what = (((kind, ()),),), _SHARED + parameter
    found: float | None = None
    for edit in edits:
        if edit.kind == "set" and edit.parameter != parameter:
            continue
        here, whole = (edited((edit,), place, *what) for place in (level, SHARED_PLACE))
        if edit.kind == "set":
            found = found if here is None else float(here.value[0])
        elif edit.kind == "heal":
            found = 0.0 if here is not None or whole is not None else found
        elif here is not None and whole is not None:  # neither is among what alone deviates
            found = 0.0
    return found


def _as_edit(place: Place, kind: str, parameter: str, value: float) -> Edit:
    """The edit by which a part of what devices share has a value."""
    path = f"{place[0][0]}.{kind}"
    return Edit("set", (path,), parameter, value) if value else Edit("heal", (f"{path}.{parameter}",))


def _edited_shared(die: Die, process: Process, what: tuple[str, str, float], drawn: float) -> float:
    """What devices of a kind share of a parameter, after the die's edits; what: both, and its sigma."""
    kind, parameter, _ = what
    family = SHARED_PLACE, (((kind, ()),),), _SHARED + parameter
    note(die, family, np.array([drawn]), process)
    whole = edited(die.edits, *family)
    told = whole is not None and not math.isnan(float(whole.value[0]))
    parts = _level_parts(die, process, what, drawn) if die.corner == "random" else {}
    if not parts or told:
        return drawn if whole is None else float(whole.of(drawn)[0])
    values = {level: level_value(die.edits, level, kind, parameter) for level in parts}
    for level, part in parts.items():
        note(die, (level, *family[1:]), np.array([part]), process)
    changed = {level: value for level, value in values.items() if value is not None}
    if len(changed) == len(parts):
        return sum(changed.values())
    return drawn + sum(value - parts[level] for level, value in changed.items())


def _level_parts(
    die: Die, process: Process, what: tuple[str, str, float], drawn: float
) -> dict[Place, float]:
    """Parts of what devices of a kind share, by level; what: as of `_edited_shared`."""
    kind, parameter, sigma = what
    if process.components is None:
        return {DIE_PLACE: drawn}
    if not die.components:
        return {LOT_PLACE: 0.0, WAFER_PLACE: 0.0, DIE_PLACE: drawn}
    varies = sigma > 0.0 and die.process
    return {
        level: sigma * share * level_normal(die, process, kind, parameter, level) if varies else 0.0
        for level, share in zip(LEVELS, _shares(process), strict=True)
    }


def _drawn_shared(die: Die, process: Process, polarity: Polarity) -> Shift:
    variation = process.variation
    if die.corner != "random":
        slow = CORNER_SIGMAS * _SLOW[die.corner][0 if polarity == "n" else 1]
        return Shift(slow * variation.sigma_v_t0, -slow * variation.sigma_beta)
    if die.number is None or not die.process:
        return Shift(0.0, 0.0)
    v_t0, beta = (shared_normal(die, process, polarity, name) for name in PARAMETERS)
    return Shift(v_t0 * variation.sigma_v_t0, beta * variation.sigma_beta)


def shared_relative(die: Die, process: Process, kind: str, parameter: str, sigma: float) -> float:
    """Relative shift of all devices of a kind on a die, such as `capacitor` of the parameter `capacitance`.

    sigma: its standard deviation over all lots. It is 0 at a corner, which says transistors alone. Raises as
    `components_of`.
    """
    varies = sigma > 0.0 and die.number is not None and die.process and die.corner == "random"
    drawn = sigma * shared_normal(die, process, kind, parameter) if varies else 0.0
    return _edited_shared(die, process, (kind, parameter, sigma), drawn) if die.edits else drawn


def components_of(process: Process) -> Components:
    """Components of a process; raises `ParameterError` where it states none."""
    if process.components is None:
        raise ParameterError(
            f"{process.name}.components: none stated, a die with components of variation needs them; state"
            " them, or leave the variation plain"
        )
    return process.components


def shared_normal(die: Die, process: Process, kind: str, parameter: str) -> float:
    """Standard normal of what all devices of a kind share on a drawn die, n and p correlated, before edits.

    kind, parameter: as of `shared_relative`, or a polarity and one of `PARAMETERS`; raises as
    `components_of`.
    """
    if not die.components:
        return _own(die, kind, parameter)
    own = _levels(die, process, kind, parameter)
    if kind != "p":
        return own
    rho = _correlation(process, parameter)
    return rho * _levels(die, process, "n", parameter) + math.sqrt(1.0 - rho**2) * own


def level_normal(die: Die, process: Process, kind: str, parameter: str, level: Place) -> float:
    """The same of what its lot, its wafer or the die itself has in it, by one of `LEVELS`."""
    level = SHARED_PLACE if level == DIE_PLACE else level
    own = _own(die, kind, parameter, level)
    if kind != "p":
        return own
    rho = _correlation(process, parameter)
    return rho * _own(die, "n", parameter, level) + math.sqrt(1.0 - rho**2) * own


def _correlation(process: Process, parameter: str) -> float:
    """Correlation of what nFETs and pFETs share of a parameter."""
    figures = components_of(process)
    return figures.correlation_v_t0 if parameter == "v_t0" else figures.correlation_beta


def _levels(die: Die, process: Process, kind: str, parameter: str) -> float:
    """Standard normal of a lot, a wafer and a die together."""
    each = (_own(die, kind, parameter, place) for place in (LOT_PLACE, WAFER_PLACE, SHARED_PLACE))
    return sum(share * z for share, z in zip(_shares(process), each, strict=True))


def _shares(process: Process) -> tuple[float, float, float]:
    """Standard deviations of what a lot, a wafer and the die itself have in a standard normal."""
    figures = components_of(process)
    left = max(1.0 - figures.lot_share - figures.wafer_share, 0.0)
    return math.sqrt(figures.lot_share), math.sqrt(figures.wafer_share), math.sqrt(left)


def _own(die: Die, kind: str, parameter: str, place: Place = SHARED_PLACE) -> float:
    drawn = replace(die, edits=()) if die.edits else die  # edits are of what is shared, not of its draws
    return _own_drawn(drawn, kind, parameter, place)


@lru_cache(maxsize=1024)  # asked for with every law of a die
def _own_drawn(die: Die, kind: str, parameter: str, place: Place) -> float:
    return float(standard_normals(die, place, [((kind, ()),)], _SHARED + parameter)[0])


def _key(die: Die, place: Place, parameter: str) -> str:
    """What a draw is keyed by beside its names: the die, or the wafer or lot that it belongs to."""
    owner = repr(die.number)
    if place == WAFER_PLACE and parameter.startswith(_SHARED):
        owner = repr(f"wafer {(die.number or 0) // DIES_A_WAFER}")
    elif place == LOT_PLACE and parameter.startswith(_SHARED):
        owner = repr("lot")
    return f"({die.lot!r}, {owner}, "


def _keys(dies: Sequence[Die]) -> list[str]:
    """`_key` of dies that are `alike`, of what is each one's own."""
    before = f"({dies[0].lot!r}, "
    return [f"{before}{die.number!r}, " for die in dies]


def _planned(die: Die, place: Place, paths: Sequence[Path], parameter: str, own: F64) -> F64:
    if die.sampling is None or die.number is None:
        return own
    return die.sampling.draws(die.number, place, tuple(paths), parameter, own)


def _whole(number: object) -> int:
    try:
        whole = operator.index(number)  # type: ignore[arg-type]  # whatever is no whole number raises
    except TypeError:
        whole = -1
    if not 0 <= whole < 2**63:
        raise ParameterError(f"die: {number}, must be a whole number from 0 to 2^63 - 1")
    return whole


class Places(NamedTuple):
    """All places of some paths, as `normal.fill_normals` takes them, and how many there are."""

    fixed: U32
    shapes: I64
    total: int

    def counters(self) -> tuple[I64, U32]:
        """Path, and counter of each place, int64[places] and uint32[places, 4]."""
        path, counters = [], []
        for k, shape in enumerate(self.shapes):
            lengths = shape[shape >= 0]
            index = np.indices(lengths).reshape(lengths.size, math.prod(lengths)).T
            own = np.zeros((len(index), _COUNTERS), dtype=np.uint32)
            own[:, : self.fixed.size] = self.fixed
            own[:, self.fixed.size : self.fixed.size + index.shape[1]] = index
            path.append(np.full(len(index), k))
            counters.append(own)
        return np.concatenate(path), np.concatenate(counters)


Normals = Callable[[Sequence[str], Sequence[str], Places, str], F64]
"""Draws of several owners at all places of paths, by their names, float64[owners, places]."""


def place_names(place: Place, path: Path) -> str:
    """Names with their numbers of indices, as text in which no two different paths look alike."""
    return repr(tuple((str(name), len(dimensions)) for name, dimensions in (*place, *path)))


def places_of(place: Place, paths: Sequence[Path]) -> Places:
    """All places of paths; raises `ParameterError` for more than four index dimensions in all."""
    fixed = [i for _, index in place for i in index]
    shapes = [[n for _, shape in path for n in shape] for path in paths]
    found = np.full((len(paths), _COUNTERS), -1)
    for k, (path, shape) in enumerate(zip(paths, shapes, strict=True)):
        if len(fixed) + len(shape) > _COUNTERS:
            label = ".".join(name for name, _ in (*place, *path))
            dimensions = len(fixed) + len(shape)
            raise ParameterError(f"{label}: {dimensions} index dimensions, must be at most {_COUNTERS}")
        found[k, : len(shape)] = shape
    return Places(np.array(fixed, dtype=np.uint32), found, sum(map(math.prod, shapes)))


def _normals(before: str, names: Sequence[str], places: Places, parameter: str) -> F64:
    """Draws at all places, the 64-bit key of each path being a hash of owner, names and parameter."""
    return np.asarray(normals_of((before,), names, places, parameter)[0])


def hashed(names: Sequence[str], parameter: str) -> list[bytes]:
    """What is hashed of each path behind its owner."""
    return [f"{n}, {parameter!r})".encode() for n in names]


def normals_of(owners: Sequence[str], names: Sequence[str], places: Places, parameter: str) -> F64:
    """Draws of several owners at all places, float64[owners, places]."""
    after = hashed(names, parameter)
    digests = [
        hashlib.blake2b(before + each, digest_size=8, person=b"noctule-die").digest()
        for before in map(str.encode, owners)
        for each in after
    ]
    keys = in_rows(np.frombuffer(b"".join(digests), dtype="<u4").astype(np.uint32).reshape(-1, 2).T)
    drawn = np.empty((len(owners), places.total))
    fill_normals(keys, places.fixed, np.tile(places.shapes, (len(owners), 1)), drawn.reshape(-1))
    return drawn


@compiled()
def philox(keys: U32, counters: U32, words: U32) -> None:
    """Fill `words`, uint32[up to 4, n], with the first output words of Philox4x32-10, a key a column.

    keys: uint32[2, n]. counters: uint32[4, n].
    """
    if words.shape[0] == 4:
        _philox_all(keys[0], keys[1], counters, words[0], words[1], words[2], words[3])
        return
    for i in range(counters.shape[1]):
        c0, c1 = np.uint64(counters[0, i]), np.uint64(counters[1, i])
        c2, c3 = np.uint64(counters[2, i]), np.uint64(counters[3, i])
        out = philox_words(c0, c1, c2, c3, np.uint64(keys[0, i]), np.uint64(keys[1, i]))
        for w in range(words.shape[0]):
            words[w, i] = np.uint32(out[w])


@compiled()
def _philox_all(k0: U32, k1: U32, counters: U32, w0: U32, w1: U32, w2: U32, w3: U32) -> None:
    """As `philox` with all four words, side by side in the lanes of the processor's vectors."""
    c0, c1, c2, c3 = counters[0], counters[1], counters[2], counters[3]
    for i in range(w0.size):
        a, b, c, d = philox_words(
            np.uint64(c0[i]), np.uint64(c1[i]), np.uint64(c2[i]), np.uint64(c3[i]),
            np.uint64(k0[i]), np.uint64(k1[i]),
        )  # fmt: skip
        w0[i], w1[i], w2[i], w3[i] = np.uint32(a), np.uint32(b), np.uint32(c), np.uint32(d)
