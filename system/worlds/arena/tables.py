"""Tables of a scene file: each is a dataclass whose fields are the keys (`system.table`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from circuits.errors import ParameterError
from system.option import option, required
from system.worlds.arena.keys import from_zero, heading, length, place, share, size, whole
from system.worlds.arena.scene import COLOURS, Led, Motion, Point, Shade, Tape

WALL_HEIGHT = 0.15  # m; ours: the sensor sees the room above it
ROOM = 2.5  # m from the arena to the walls of the room; ours

Size = tuple[float, float]


def _colour(usual: str, about: str = "Name of a colour, or a reflectance") -> Any:
    return option(COLOURS[usual], about, unit="", above=0.0, most=1.0, words=COLOURS)


@dataclass(frozen=True, slots=True)
class StartTable:
    """Where the robot starts."""

    at: Point = place()
    heading: float = heading()


@dataclass(frozen=True, slots=True)
class ArenaTable:
    """The floor, the walls about it, and the room behind them."""

    size: Size | None = option(None, "Of a rectangle, [x, y]; else give corners", unit="m", above=0.0)
    corners: tuple[Point, ...] | None = option(None, "Points [x, y] round the floor", unit="m", fewest=3)
    wall_height: float = from_zero(WALL_HEIGHT, "0 for no walls")
    wall_colour: float = _colour("white")
    tape: Tape | Literal[False] = option(Tape(), "On the walls; false for none")
    room: float = from_zero(ROOM, "From the arena to the walls of the room; 0 for no room")
    seed: int = whole(0, "Of what stands along the walls of the room")

    def __post_init__(self) -> None:
        """Raise `ParameterError` for a tape that does not fit on the walls."""
        if self.wall_height > 0.0:
            _check_tape(self.tape, "wall_height", self.wall_height)


@dataclass(frozen=True, slots=True)
class WallTable:
    """A wall inside the arena."""

    corners: tuple[Point, ...] = required("Points [x, y] along it", unit="m", fewest=2)
    height: float = length(WALL_HEIGHT, "Of the wall")
    colour: float = _colour("white")
    tape: Tape | Literal[False] = option(Tape(), "On the wall; false for none")

    def __post_init__(self) -> None:
        """Raise `ParameterError` unless the tape fits on it, and no two corners in a row are the same."""
        _check_tape(self.tape, "height", self.height)
        for k in range(1, len(self.corners)):
            if self.corners[k] == self.corners[k - 1]:
                raise ParameterError(
                    f"corners[{k}]: {list(self.corners[k])}, must not be the one before; drop it"
                )


def _check_tape(tape: Tape | Literal[False], name: str, height: float) -> None:
    if tape and height < tape.high:
        raise ParameterError(f"tape.high: {tape.high:g} m, must not be above {name}, {height:g} m")


@dataclass(frozen=True, slots=True)
class BlockTable:
    """An upright box."""

    at: Point = place()
    size: Size = size()
    height: float = required("Of its upper side above the floor", unit="m", above=0.0)
    base: float = from_zero(0.0, "Of its underside above the floor")
    colour: float = _colour("blue")
    heading: float = heading()
    motion: Motion | None = option(None, "How it moves; it stands unless given")


@dataclass(frozen=True, slots=True)
class CupTable:
    """An upright cylinder."""

    at: Point = place()
    diameter: float = length(0.08, "Across")
    height: float = length(0.10, "Of its upper side above the floor")
    base: float = from_zero(0.0, "Of its underside above the floor")
    colour: float = _colour("blue")
    motion: Motion | None = option(None, "How it moves; it stands unless given")


@dataclass(frozen=True, slots=True)
class RobotTable:
    """Another Pushbot."""

    at: Point = place()
    heading: float = heading()
    colour: float = _colour("black")
    tracks: float | None = option(
        None, "Colour of both tracks; covered unless given", unit="", above=0.0, most=1.0, words=COLOURS
    )
    led: Led | bool = option(default=True, about="On top: its numbers, true for the usual, false for none")
    motion: Motion | None = option(None, "How it moves; it stands unless given")

    def __post_init__(self) -> None:
        """Raise `ParameterError` for tracks of a robot that moves: covered with paper it has none."""
        if self.tracks is not None and self.motion is not None:
            raise ParameterError(
                f"tracks: {self.tracks:g}, must not be given for a robot that moves; leave it out"
            )


@dataclass(frozen=True, slots=True)
class PersonTable:
    """Two legs of somebody who stands or walks."""

    at: Point = place()
    heading: float = heading()
    colour: float = _colour("black")
    motion: Motion | None = option(None, "How it moves; it stands unless given")


@dataclass(frozen=True, slots=True)
class DeskTable:
    """A table: four legs, a top, and the shade below it."""

    at: Point = place()
    size: Size = size()
    heading: float = heading()
    colour: float = _colour("wood")
    height: float = length(0.72, "Of its upper side above the floor")
    shade: float = share(0.3, "Share of the light that falls below it")


@dataclass(frozen=True, slots=True)
class ChairTable:
    """An office chair: a seat on a foot."""

    at: Point = place()
    heading: float = heading()
    colour: float = _colour("black")


@dataclass(frozen=True, slots=True)
class ClutterTable:
    """Blocks at random places, with random headings."""

    count: int | tuple[int, int] = required("How many, or [from, to]", least=0, below=2**31)
    size: Size = option((0.02, 0.02), "Of each, [length, width]", unit="m", above=0.0)
    height: float = length(0.05, "Of each")
    colours: tuple[float, ...] = option(
        (COLOURS["blue"],), "Of which each has one", unit="", above=0.0, most=1.0, words=COLOURS, fewest=1
    )
    spacing: float = length(0.35, "Between any two")
    clear: float = from_zero(0.6, "Between each and the start")

    def __post_init__(self) -> None:
        """Raise `ParameterError` unless there are some."""
        low, high = self.counts
        if not 1 <= low <= high:
            shown = list(self.count) if isinstance(self.count, tuple) else self.count
            raise ParameterError(f"count: {shown}, must be a number of at least 1, or [from, to]")

    @property
    def counts(self) -> tuple[int, int]:
        """Least and largest number of blocks."""
        return self.count if isinstance(self.count, tuple) else (self.count, self.count)


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneTable:
    """A whole scene file."""

    summary: str = option("", "What it is, in a line")
    duration: float | None = option(None, "Of a run; as the robot needs unless given", unit="s", above=0.0)
    light: float | str = option("normal", "Normal, dark, very-dark, or on the floor", unit="lux", above=0.0)
    floor: float = _colour("white")
    sky: float = _colour("white", "Colour of what nothing stands before")
    start: StartTable = required("Of the robot")
    arena: ArenaTable = required("Floor and walls")
    walls: tuple[WallTable, ...] = option((), "Walls inside", name="wall")
    blocks: tuple[BlockTable, ...] = option((), "Boxes", name="block")
    cups: tuple[CupTable, ...] = option((), "Cylinders", name="cup")
    robots: tuple[RobotTable, ...] = option((), "Other robots", name="robot")
    people: tuple[PersonTable, ...] = option((), "People", name="person")
    desks: tuple[DeskTable, ...] = option((), "Tables", name="table")
    chairs: tuple[ChairTable, ...] = option((), "Chairs", name="chair")
    shades: tuple[Shade, ...] = option((), "Darker parts of the floor", name="shade")
    clutter: ClutterTable | None = option(None, "Blocks at random places")
