"""Parts of a die: what a run draws, as a tree from its circuits down to a parameter of a device.

A part is a name after another as paths of edits have them (`circuits.silicon.edit`). Below a circuit come its
blocks, then its populations and cells, `neuron[*].membrane.mr1` for a device of all neurons; then single
devices, `neuron[3].membrane.mr1`; then `v_t0` and `beta`. Only what deviates on the die is a part of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from circuits.arrays import F64, I64
from circuits.silicon.die import (
    LEVELS as SHARED_LEVELS,
)
from circuits.silicon.die import (
    SHARED_NAMES,
    SHARED_PLACE,
    SLOPE,
    Die,
    Drawn,
    Family,
    Path,
    Place,
    level_normal,
    level_value,
    shared_normal,
    standard_normals,
)
from circuits.silicon.edit import SHARED, edited
from circuits.silicon.process import Process

MOST_INDICES = 4096  # of an array whose elements are told apart; ours
PLANTED = 10.0  # standard deviations that a deviation counts for where no draw says what one is; ours
LEVELS = ("circuit", "block", "device of all cells", "device", "parameter")

_Step = tuple[str, tuple[int, ...] | None]  # a name with its index, None for all or none


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a die.

    Attributes
    ----------
    steps : tuple
        Its names with their indices, None for any.
    shapes : tuple
        Number of places at each name, by dimension.
    parameter : str
        Parameter of its devices, empty for all.
    """

    steps: tuple[_Step, ...]
    shapes: tuple[tuple[int, ...], ...]
    parameter: str = ""

    @property
    def path(self) -> str:
        """As a path of an edit."""
        names = [
            f"{name}[{'*' if index is None else ','.join(map(str, index))}]" if shape else name
            for (name, index), shape in zip(self.steps, self.shapes, strict=True)
        ]
        return ".".join([*names, self.parameter] if self.parameter else names)


@dataclass(slots=True)
class _Branch:
    """A name in the tree: those below it, and where it is a device, its deviations by parameter."""

    shape: tuple[int, ...] = ()
    below: dict[str, _Branch] = field(default_factory=dict)
    value: dict[str, F64] = field(default_factory=dict)
    sigma: dict[str, F64] = field(default_factory=dict)
    slope: dict[str, F64] = field(default_factory=dict)  # what gradients add to the value


@dataclass(frozen=True, slots=True, eq=False)
class Alike:
    """Single devices, of which a chip may have a million, in order.

    groups : a device of all cells, and the places of it that are meant, counted through, each.
    """

    groups: tuple[tuple[Part, I64], ...]

    def __len__(self) -> int:
        """How many there are."""
        return sum(places.size for _, places in self.groups)

    def __getitem__(self, number: int) -> Part:
        """One of them."""
        for group, places in self.groups:
            if number < places.size:
                index = iter(
                    np.unravel_index(places[number], [n for shape in group.shapes for n in shape] or [1])
                )
                at = [tuple(int(next(index)) for _ in shape) or None for shape in group.shapes]
                steps = tuple((name, one) for (name, _), one in zip(group.steps, at, strict=True))
                return replace(group, steps=steps)
            number -= places.size
        raise IndexError(number)


class Parts:
    """The parts of a die.

    Parameters
    ----------
    die
        The die, with its own edits.
    drawn
        What it draws, as of `circuits.silicon.die.drawn_for`.
    """

    def __init__(self, die: Die, drawn: Mapping[Family, Drawn]) -> None:
        """Take what deviates into a tree."""
        self._root = _Branch()
        plain = replace(die, edits=())
        self.processes: dict[str, Process] = {}
        for family, (own, process) in drawn.items():
            place, paths, parameter = family
            value = None if parameter.startswith(SLOPE) else _after_edits(die, family, own)
            if value is None or not value.any():
                continue
            self.processes[place[0][0]] = process
            z = np.zeros(own.shape) if die.number is None else _normals(plain, process, family)
            with np.errstate(divide="ignore", invalid="ignore"):
                sigma = np.where(z * own != 0.0, np.abs(own / z), 0.0)
            for path, at in _each(paths):
                if value[at].any():
                    branch = self._at(place, path)
                    name, shape = parameter.removeprefix(SHARED), _shape(path)
                    branch.value[name], branch.sigma[name] = (
                        value[at].reshape(shape),
                        sigma[at].reshape(shape),
                    )
        for (place, paths, parameter), (own, _) in drawn.items():
            for path, at in _each(paths) if parameter.startswith(SLOPE) else ():
                if own[at].any():
                    slope = self._at(place, path).slope
                    slope[parameter.removeprefix(SLOPE)] = own[at].reshape(_shape(path))

    def _at(self, place: Place, path: Path) -> _Branch:
        """The branch of a path's devices, which is made where there is none."""
        branch = self._root
        for name, index in place:  # a place with indices is a name of its own
            text = f"{name}[{','.join(map(str, index))}]" if index else name
            branch = branch.below.setdefault(text, _Branch())
        for name, dimensions in path:
            *before, last = name.split(".")
            for text in before:
                branch = branch.below.setdefault(text, _Branch())
            branch = branch.below.setdefault(last, _Branch())
            branch.shape = dimensions
        return branch

    def circuits(self) -> list[Part]:
        """Return the parts at the top: circuits, and what devices share."""
        return [Part(((name, None),), ((),)) for name in sorted(self._root.below)]

    def level(self, part: Part) -> int:
        """Return at which of `LEVELS` a part is."""
        if part.parameter:
            return 4
        if self._branch(part).below:
            return 0 if len(part.steps) == 1 else 1
        return 2 if self._open(part) is not None else 3

    def below(self, part: Part) -> list[Part]:
        """Return what a part is made of, the next level below; none below a parameter."""
        branch = self._branch(part)
        if branch.below:
            found = [
                Part((*part.steps, (name, None)), (*part.shapes, one.shape))
                for name, one in sorted(branch.below.items())
            ]
            return self.below(found[0]) if len(found) == 1 and self._branch(found[0]).below else found
        where = self._open(part)
        if where is None:
            return [] if part.parameter else [replace(part, parameter=name) for name in sorted(branch.value)]
        shape = part.shapes[where]
        if math.prod(shape) > MOST_INDICES:
            return []
        each = [_at(part, where, tuple(map(int, index))) for index in np.ndindex(*shape)]
        return [one for one in each if self.weight(one) > 0.0]

    def block(self, part: Part) -> str:
        """Return the path of the block that a part is in, of all cells; its own above devices."""
        names = part.steps if self.level(part) < 2 else part.steps[:-1]
        return Part(tuple((name, None) for name, _ in names), part.shapes[: len(names)]).path

    def devices(self, part: Part) -> int:
        """Return how many devices a part has."""
        return sum(next(iter(v.values())).size for v, _ in self._values(part))

    def weight(self, part: Part) -> float:
        """Return the largest deviation within a part, in standard deviations of its own."""
        largest = 0.0
        for values, sigmas in self._values(part):
            for name, value in values.items():
                with np.errstate(divide="ignore", invalid="ignore"):
                    z = np.where(sigmas[name] > 0.0, np.abs(value) / sigmas[name], PLANTED * (value != 0.0))
                largest = max(largest, float(z.max(initial=0.0)))
        return largest

    def deviations(self, part: Part) -> dict[str, tuple[float, float]]:
        """Return deviation and sigma of a single device by parameter, V of V_T0, else relative."""
        ((values, sigmas),) = self._values(part)
        return {name: (float(values[name]), float(sigmas[name])) for name in values}

    def slopes(self, part: Part) -> dict[str, float]:
        """Return what gradients across the die add to a single device, by parameter, as `deviations`."""
        index = tuple(n for _, index in part.steps for n in index or ())
        slope = self._branch(part).slope
        return {name: float(value[index]) for name, value in slope.items() if part.parameter in {"", name}}

    def alike(self, part: Part) -> Alike:
        """Return the other single devices of a device's circuit whose standard deviations are the same."""
        own = self.deviations(replace(part, parameter=""))
        groups: list[tuple[Part, I64]] = []
        for group, branch in _devices(
            Part(part.steps[:1], part.shapes[:1]), self._branch(replace(part, steps=part.steps[:1]))
        ):
            found = np.any([value != 0.0 for value in branch.value.values()], axis=0)
            for name, sigma in branch.sigma.items():
                found = found & np.isclose(sigma, own.get(name, (0.0, math.nan))[1], rtol=1e-6, atol=0.0)
            found = np.array(found)  # of a single device too
            if [name for name, _ in group.steps] == [name for name, _ in part.steps]:
                found[tuple(n for _, index in part.steps for n in index or ())] = False
            if found.any():
                groups.append((group, np.flatnonzero(found)))
        return Alike(tuple(groups))

    def _branch(self, part: Part) -> _Branch:
        branch = self._root
        for name, _ in part.steps:
            branch = branch.below[name]
        return branch

    def _open(self, part: Part) -> int | None:
        """The first of its names whose index is open."""
        steps = zip(part.steps, part.shapes, strict=True)
        return next((k for k, ((_, index), shape) in enumerate(steps) if shape and index is None), None)

    def _values(self, part: Part) -> Iterable[tuple[dict[str, F64], dict[str, F64]]]:
        """Deviations and standard deviations of the devices in a part, by device of all cells."""
        index: list[int | slice] = []
        for (_, chosen), shape in zip(part.steps, part.shapes, strict=True):
            index += [slice(None)] * len(shape) if chosen is None else chosen
        for branch in _leaves(self._branch(part)):
            names = [part.parameter] if part.parameter else list(branch.value)
            at = tuple(index)
            yield (
                {n: np.asarray(branch.value[n][at]) for n in names},
                {n: np.asarray(branch.sigma[n][at]) for n in names},
            )


def shared_by_all(path: str) -> bool:
    """Whether a path is of what devices share, rather than of devices."""
    return path.partition(".")[0] in SHARED_NAMES


def _after_edits(die: Die, family: Family, own: F64) -> F64 | None:
    """Deviations of a family after a die's own edits; None where they are told by other families.

    What devices share is told part by part where a lot or a wafer has one, as a whole where it has not.
    """
    place, paths, parameter = family
    if parameter.startswith(SHARED):
        ((kind, _),) = paths[0]
        name = parameter.removeprefix(SHARED)
        values = {level: level_value(die.edits, level, kind, name) for level in SHARED_LEVELS}
        set_whole = edited([e for e in die.edits if e.kind == "set"], SHARED_PLACE, paths, parameter)
        apart = die.corner == "random" and set_whole is None and (die.components or any(values.values()))
        if apart != (place != SHARED_PLACE):
            return None
        if apart:
            value = values[place]
            return own if value is None else np.full(own.shape, value)
    changed = edited(die.edits, place, paths, parameter) if die.edits else None
    return own if changed is None else changed.of(own)


def _normals(die: Die, process: Process, family: Family) -> F64:
    """Standard normals behind what was drawn for a family on a drawn die without edits."""
    place, paths, parameter = family
    if not parameter.startswith(SHARED):
        return standard_normals(die, place, paths, parameter)
    ((kind, _),) = paths[0]
    name = parameter.removeprefix(SHARED)
    if place == SHARED_PLACE:
        return np.array([shared_normal(die, process, kind, name)])
    if not die.components:  # whose lot and wafer have no draws
        return np.zeros(1)
    return np.array([level_normal(die, process, kind, name, place)])


def _each(paths: Sequence[Path]) -> Iterable[tuple[Path, slice]]:
    """Paths of a family, and where in it the places of each are."""
    start = 0
    for path in paths:
        stop = start + math.prod(_shape(path))
        yield path, slice(start, stop)
        start = stop


def _shape(path: Path) -> tuple[int, ...]:
    return tuple(n for _, dimensions in path for n in dimensions)


def _devices(part: Part, branch: _Branch) -> Iterable[tuple[Part, _Branch]]:
    """Devices of all cells in a part, with their branches, in the order of their names."""
    if branch.value:
        yield part, branch
    for name, one in sorted(branch.below.items()):
        yield from _devices(Part((*part.steps, (name, None)), (*part.shapes, one.shape)), one)


def _leaves(branch: _Branch) -> Iterable[_Branch]:
    if branch.value:
        yield branch
    for one in branch.below.values():
        yield from _leaves(one)


def _at(part: Part, where: int, index: Sequence[int]) -> Part:
    steps = list(part.steps)
    steps[where] = (steps[where][0], tuple(index))
    return replace(part, steps=tuple(steps))
