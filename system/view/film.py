"""What a run shows over time: its world, what moves there, signals, spikes, and neurons with their devices.

A film is plain data. A system makes one of its trace (`system.system.System.film`); `system.view.page` makes
a page of one or two, and `system.view.kept` keeps one in a file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.errors import unknown_name
from system.view.drawing import Drawing

NO_YES = ("no", "yes")
"""Words of a signal that is 0 or 1."""
INSIDE = 8
"""Neurons that can be looked into unless others are asked for; ours."""

Point = tuple[float, float]
Role = Literal["floor", "shade", "obstacle", "wall", "goal", "start", "way", "moving", "sound"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """Something that stands in a world.

    role : what it is, which decides how it is drawn.
    points : corners of an area, or of a line where `closed` is false, in the world's unit.
    radius : of a circle about the first point, in the world's unit; 0 for none.
    closed : whether the points go round an area.
    name : what a reader is told that it is; empty for nothing.
    colour : a colour of its own as `#rrggbb`, empty for that of its role.
    """

    role: Role
    points: tuple[Point, ...]
    radius: float = 0.0
    closed: bool = True
    name: str = ""
    colour: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Track:
    """Something that moves in a world.

    Attributes
    ----------
    name : str
        What it is.
    time : array
        When it is where, s, float64[n], rising.
    x, y : array
        Where it is, in the world's unit, float64[n].
    heading : array or None
        Which way it looks, rad from x to y, float64[n]; None where it has no front.
    outline : tuple of (float, float)
        Its corners about its own place, with the front along x; none for a dot.
    radius : float
        Of its circle, in the world's unit, where it has no outline; 0 for a dot.
    role : str
        `robot`, or `moving` for what it meets.
    longest : float
        Step, in the world's unit, above which it has not gone there but been put there, as over the border of
        a torus; 0 for none.
    """

    name: str
    time: F64
    x: F64
    y: F64
    heading: F64 | None = None
    outline: tuple[Point, ...] = ()
    radius: float = 0.0
    role: Literal["robot", "moving"] = "robot"
    longest: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stage:
    """A world from above.

    unit : unit of its places.
    shapes : what stands in it, in the order in which it is drawn.
    tracks : what moves in it, the robot first.
    north : whether y goes up, as on paper; down, as a map in a file, if false.
    """

    unit: str
    shapes: tuple[Shape, ...]
    tracks: tuple[Track, ...]
    north: bool = True


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Line:
    """A signal over time.

    name : what it is.
    time : s, float64[n], rising.
    value : in the unit of its panel, float64[n]; NaN where there is none.
    step : whether a value holds until the next, instead of going there in a line.
    shown : whether it is drawn before a reader asks for it.
    """

    name: str
    time: F64
    value: F64
    step: bool = False
    shown: bool = True


@dataclass(frozen=True, slots=True)
class Group:
    """Rows of a raster that belong together.

    name : what they are, as a population.
    first : number of their first row.
    count : how many they are.
    """

    name: str
    first: int
    count: int


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Raster:
    """Events of many sources, a row each.

    time : s, float64[n], rising.
    row : number of the source, int64[n].
    rows : name of each source; a neuron's is that of its `Neuron`.
    groups : sources that belong together, in the order of their rows; none where each stands for itself.
    """

    time: F64
    row: I64
    rows: tuple[str, ...]
    groups: tuple[Group, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Panel:
    """Signals that share an axis.

    title : what they are.
    unit : unit of its lines; empty for none.
    words : what 0, 1 and so on mean where its lines have such values alone; none for numbers.
    lines : its signals.
    raster : events in it instead.
    """

    title: str
    unit: str = ""
    words: tuple[str, ...] = ()
    lines: tuple[Line, ...] = ()
    raster: Raster | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Eye:
    """What a camera sends: events of single pixels.

    name : what it is.
    columns, rows : pixels across and up.
    time : s, float64[n], rising.
    x, y : column from the left and row from the bottom, int64[n].
    on : whether it has become brighter, bool[n].
    """

    name: str
    columns: int
    rows: int
    time: F64
    x: I64
    y: I64
    on: Bools


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """A device of a neuron on the run's die.

    Attributes
    ----------
    path : str
        Its path from the chip on.
    what : str
        What it is, with its size.
    deviation : str
        What deviates in it and by how much, with units.
    sigma : float
        The largest of its deviations over its standard deviation, without sign.
    mended : str
        What would be if it alone did not deviate; empty where that was not asked.
    waveform : Panel or None
        What that looks like.
    """

    path: str
    what: str
    deviation: str
    sigma: float
    mended: str = ""
    waveform: Panel | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Neuron:
    """A neuron, or a device of a circuit, that can be looked into.

    name : as its row in a raster; a device's is its path.
    devices : its devices, those that deviate most first.
    waveform : its nodes at transistor level, or a device's current; None where the run has none.
    """

    name: str
    devices: tuple[Device, ...]
    waveform: Panel | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """A moment of a run that deserves a look.

    Attributes
    ----------
    time : float
        When, s.
    name : str
        What happens then.
    neuron : str
        Name of the neuron that it is about; empty where it is about none.
    why : str
        What that neuron did, in words that follow its name.
    begin, end : float
        The stretch of time that shows it, s.
    """

    time: float
    name: str
    neuron: str
    begin: float
    end: float
    why: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Film:
    """What a run shows.

    title : what ran, on what.
    headline : whether it succeeded and why it ended.
    command : the command that makes it again.
    duration : s.
    world : where it was; None for what is in no world.
    panels : signals, from above downwards.
    eye : what its camera sent.
    drawing : schematic whose nets and devices are called as lines of voltage (V) and of current (A).
    neurons : those that can be looked into; of a circuit its devices.
    moments : moments that deserve a look, in the order of time.
    facts : what is told of the run beside: die, temperature and the like.
    """

    title: str
    headline: str
    duration: float
    command: str = ""
    world: Stage | None = None
    panels: tuple[Panel, ...] = ()
    eye: Eye | None = None
    drawing: Drawing | None = None
    neurons: tuple[Neuron, ...] = ()
    moments: tuple[Moment, ...] = ()
    facts: Mapping[str, str] = field(default_factory=dict)


def merged(trains: Sequence[F64]) -> tuple[F64, I64]:
    """Return times (s) and numbers of trains, float64[n] each, in the order of time."""
    times = np.concatenate([np.zeros(0), *trains])
    rows = np.repeat(np.arange(len(trains), dtype=np.int64), [len(train) for train in trains])
    order = np.argsort(times, kind="stable")
    return times[order], rows[order]


def busiest(names: Sequence[str], rows: F64 | I64, asked: Sequence[str] | None) -> list[str]:
    """Return the names of neurons to look into.

    Parameters
    ----------
    names
        Names of all neurons.
    rows
        Number of the neuron of each spike.
    asked
        Those that are asked for; None for the `INSIDE` that spike most, in their order.

    Raises
    ------
    UnknownNameError
        A name that is asked for is no neuron's.
    """
    if asked is not None:
        for name in asked:
            if name not in names:
                raise unknown_name("neuron", name, names)
        return list(asked)
    counts = np.bincount(np.asarray(rows, dtype=np.int64), minlength=len(names))
    chosen = np.sort(np.argsort(-counts, kind="stable")[:INSIDE])
    return [names[k] for k in chosen]


def signal(
    title: str, unit: str, time: F64, value: F64, name: str = "", words: tuple[str, ...] = ()
) -> Panel:
    """Return the panel of one signal whose values hold until the next.

    time: s, float64[n]; value: in the panel's unit, of that length; name: of its line, else the title's;
    words: what its values 0, 1 and so on mean.
    """
    line = Line(name=name or title, time=time, value=value, step=True)
    return Panel(title=title, unit=unit, words=words, lines=(line,))


def circles(role: Role, places: F64, radius: float = 0.0, name: str = "") -> list[Shape]:
    """Return circles about places, float64[n, 2], of a radius in the world's unit; dots where it is 0."""
    return [Shape(role=role, points=((float(x), float(y)),), radius=radius, name=name) for x, y in places]


def corners(points: F64) -> tuple[Point, ...]:
    """Return points, float64[n, 2], as a shape has them."""
    return tuple((float(x), float(y)) for x, y in points)
