"""What a run of the rover is asked to do: map, route, planner, how much it knows, and on which silicon."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from circuits.blocks.wavefront.axon_delay import UNIT
from system.option import check_options, option
from system.options.codes import Coded, check_codes
from system.options.noise import Noisy, check_device_noise, noise_option, noise_seed_option
from system.rover.body import Rover
from system.rover.cost_map import NEEDS, Cell, read_cell
from system.rover.planner import PLANNERS

DEFAULT_MAP = "map1-road-obstacles"
CELLS = ("ideal", "chip")
START, GOAL = (2, 10), (19, 10)  # the paper's first route
PRIOR = 5.0  # delay of all axons before anything is learnt; the paper's


@dataclass(frozen=True, slots=True)
class Scenario(Coded):
    """A route that a rover plans and drives, once or on several trips.

    Attributes
    ----------
    map : str
        Name of the map, or of a file of costs.
    start, goal : (int, int)
        Row, from 0 in the north, and column of a cell.
    planner : str
        What plans, one of `PLANNERS`.
    cells : str
        Cells of the wave: `ideal`, or `chip` for those of a die.
    need : str
        What the costs of the map stand for.
    learn : float or None
        Rate of equation (5), a share above 0 up to 1; None where the map is known.
    prior : float
        Cost that unknown cells are taken for, in units of cost.
    trips : int
        How often the way is planned and driven.
    posts : bool
        Whether there are obstacles that no map has.
    sonar : bool
        Whether the rover sees them.
    unit : float
        Delay of a unit of cost on the chip, s.
    silicon_noise : str
        Which noise the chip's devices make.
    noise_seed : int or None
        Seed of that noise; that of the run unless given.
    rover : Rover
        Numbers of the body and its senses.

    Raises
    ------
    ParameterError
        A field breaks its rule; the text names it.
    DataError
        A file of codes is none.
    """

    CALIBRATED: ClassVar[tuple[str, ...]] = ("wavefront-chip",)

    map: str = option(
        DEFAULT_MAP,
        "As map1-road, or a file of costs",
        metavar="MAP",
        study=True,
        names="system.rover.cost_map:MAPS",
    )
    start: Cell = option(
        START, "From 0, row 0 in the north", read=read_cell, metavar="ROW,COLUMN", study=True
    )
    goal: Cell = option(GOAL, "As the start", read=read_cell, metavar="ROW,COLUMN", study=True)
    planner: str = option("wave", "What plans", choices=tuple(PLANNERS))
    cells: str = option("ideal", "Of the wave: ideal, or a die's", choices=CELLS)
    need: str = option("energy", "What costs stand for, energy the map itself", choices=NEEDS)
    learn: float | None = option(None, "Learn the map, above 0 up to 1", unit="", metavar="RATE")
    prior: float = option(PRIOR, "What unknown cells are taken for", unit="", metavar="COST", key="")
    trips: int = option(1, "How often the way is planned and driven", least=1)
    posts: bool = option(default=False, about="Obstacles that no map has", key="")
    sonar: bool = option(default=False, about="Turn away from what sonars see", key="")
    unit: float = option(
        UNIT, "Of the chip: delay a unit of cost", unit="s", above=0.0, study=True, silicon=True
    )
    silicon_noise: Noisy = noise_option(study=False)
    noise_seed: int | None = noise_seed_option()
    rover: Rover = field(default_factory=Rover)

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self, no_silicon(self))
        check_codes(self)
        check_device_noise(self)


def no_silicon(scenario: Scenario) -> str:
    """Say what puts a chip into the loop.

    The text is empty where a chip is in the loop.
    """
    return "" if scenario.cells == "chip" else "add `cells=chip`"
