"""What a sample of flights through a forest is asked to do: bat, senses, forest and silicon."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from chips.codes import Codes
from chips.ranging.calibration.found import NAME as RANGING
from chips.selection.calibration import NAME as SELECTION
from chips.selection.calibration import Design
from circuits.errors import ParameterError
from system.forest.weights import weighted
from system.openspace.law import Arcs, Bat, arcs_of
from system.openspace.map import (
    check_count,
    check_source,
    map_option,
    obstacles_option,
    read_place,
    start_option,
)
from system.openspace.selecting import FIXED, Selecting, projection
from system.openspace.senses import IDEAL, Sensing, with_area
from system.option import check_options, option
from system.options.codes import Coded, check_codes
from system.options.noise import check_ripple
from system.options.on_silicon import ROOM_TEMPERATURE
from system.options.temperature import temperature_text

PINGS = 20_000  # of a sample: more make a picture of one colour; ours
STUDY_PINGS = 1_250_000  # of a sample of a study: 200 of them are the limit of a configuration, 2.5e8
CHIP_STUDY_PINGS = 125_000  # with chips, whose limit is 2.5e7
ESCAPE = 2  # a way back and forth; ours: a third turn would begin what has been flown
AREA = "area"  # options that set no single field
KINDS = "weights"


@dataclass(frozen=True, slots=True)
class Scenario(Coded):
    """One sample: flights of a bat until a collision, or until so many pings have been made.

    `map` is a file of obstacles, None to plant `obstacles` from the seed. `rows` says of how many pings of
    the first run the path is kept. Without a chip in the loop the number of a die is no more than the number
    of the sample. Codes are those of the chips that are in the loop.
    """

    CALIBRATED: ClassVar[tuple[str, ...]] = (RANGING, SELECTION)

    bat: Bat = field(default_factory=Bat)
    sensing: Sensing = IDEAL
    map: str | None = map_option()
    obstacles: int = obstacles_option()
    start: tuple[float, float] | None = start_option(read_place)
    pings: int = option(PINGS, "Ends undecided after these", least=1, study=True)
    escape: int = option(
        ESCAPE, "Turns round so often in a row, then flies the best arc all the same; 0 for the paper's law",
        least=0, study=True,
    )  # fmt: skip
    rows: int = PINGS

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self, no_silicon(self), but=("die", "temperature_c", "course"))
        way = self.bat.max_speed / self.bat.ping_rate
        if way > self.bat.max_range:
            raise ParameterError(
                f"vmax: {self.bat.max_speed:g} m/s at {self.bat.ping_rate:g} Hz is {way:.3g} m between"
                f" pings, must be at most the {self.bat.max_range:g} m that a ping shows; fly slower"
            )
        if (self.course or self.temperature_c != ROOM_TEMPERATURE) and not self.sensing.silicon:
            warm = temperature_text(self.temperature_c, self.course)
            raise ParameterError(
                f"temperature_c: {warm} degC, must be {ROOM_TEMPERATURE:g}: no chip is in the"
                f" loop; {no_silicon(self)}, or leave it out"
            )
        check_codes(self)
        check_ripple(self.ripple, self.bias_kind, self.sensing.silicon_noise)
        if self.ripple is not None and self.sensing.ranges != "chip":
            raise ParameterError(
                f"ripple: {self.ripple}, moves both sides of what the selection compares alike;"
                " give `ranges=chip`"
            )
        if self.map is None:
            check_count(self.obstacles)

    @property
    def arcs(self) -> Arcs:
        """Its bat's arcs, with the escape."""
        return arcs_of(self.bat)._replace(escape=self.escape)

    @property
    def ranging_codes(self) -> Codes | None:
        """Codes of the ranging chip; None for those of its design, and without it. Raises as `codes_of`."""
        if self.sensing.ranges != "chip":
            return None
        area = self.sensing.ranging_area
        return self.codes_of(RANGING, setup=None if area == 1.0 else area)

    @property
    def selecting(self) -> Selecting:
        """What the selection's chip is biased with; raises as `Coded.codes_of`."""
        if self.sensing.selection == "ideal":
            return FIXED
        design = Design(projection(self.bat), self.sensing.selection_area)
        return Selecting(self.bias_kind, self.codes_of(SELECTION, setup=design))


def no_silicon(scenario: Scenario) -> str:
    """Say what puts a chip into the loop.

    The text is empty where a chip is in the loop.
    """
    return "" if scenario.sensing.silicon else "give `ranges=chip` or `selection=chip`"


def make(fields: dict[str, Any], more: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a scenario, the bat's weights and the area of both chips set as asked."""
    check_source(fields)
    found = dict(fields)
    if KINDS in more:
        found["bat"] = weighted(fields.get("bat", Bat()), more[KINDS])
    if AREA in more:
        sensing = fields.get("sensing", IDEAL)
        if not sensing.silicon:
            raise ParameterError("area: no chip is in the loop; give `ranges=chip` or `selection=chip`")
        found["sensing"] = with_area(sensing, more[AREA])
    return found


def of_study(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of a study's samples: fewer pings with chips, and no rows of a path."""
    silicon = "chip" in (given.get("ranges"), given.get("selection"))
    return {"pings": CHIP_STUDY_PINGS if silicon else STUDY_PINGS, "rows": 0}
