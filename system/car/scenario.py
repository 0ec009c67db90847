"""What a drive of the car is asked to do: robot, forest, how ranges are found, and on which silicon."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

from chips.codes import Codes
from chips.ranging.calibration.found import NAME
from circuits.errors import ParameterError
from system.car.numbers import OpenspaceNumbers, Robot
from system.car.world import FORESTS, check_forest, is_file, read_pipes
from system.openspace.map import start_option
from system.option import check_options, option
from system.options.codes import Coded, check_codes
from system.options.noise import Noisy, check_device_noise, noise_option, noise_seed_option
from system.reader import place

RANGES = ("flight", "exact", "chip")
PINGS = 1500  # of a run, three times those of a drive without detours; ours


@dataclass(frozen=True, slots=True)
class Scenario(Coded):
    """One drive of the car through a forest of pipes.

    `start` is drawn unless given, x and y in m; `pings` is how many are made before the drive ends.
    `occlusion`, `multipath` and `soft_pings` are None where there is no sonar to have them. Noise is that of
    the chip's devices, drawn from `noise_seed`, which is `seed` unless given. Codes are those of the ranging
    chip.
    """

    CALIBRATED: ClassVar[tuple[str, ...]] = (NAME,)

    robot: Robot = field(default_factory=Robot)
    openspace: OpenspaceNumbers = field(default_factory=OpenspaceNumbers)
    forest: str = option(
        FORESTS[0],
        "As corridor, open, dense, or a FILE",
        metavar="FOREST",
        study=True,
        names="system.car.world:FORESTS",
    )
    ranges: str = option(
        RANGES[0], "Of the echoes' flight, exact places, or chip to time echoes", choices=RANGES, study=True
    )
    occlusion: bool | None = option(None, "Pipes hide those behind; they do", study=True)
    multipath: bool | None = option(None, "Echoes by way of two pipes; there are", study=True)
    soft_pings: bool | None = option(None, "A softer ping where something is near; there is", study=True)
    silicon_noise: Noisy = noise_option()
    noise_seed: int | None = noise_seed_option()
    start: tuple[float, float] | None = start_option(place)
    pings: int = option(PINGS, "Ends undecided after these", least=1, study=True)

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self, no_silicon(self))
        check_forest(self.forest)
        check_device_noise(self)
        check_codes(self)
        for name in ("occlusion", "multipath", "soft_pings"):
            if getattr(self, name) and self.ranges == "exact":
                raise ParameterError(f"{name}: not with `ranges=exact`; give `ranges=flight` or chip")

    @property
    def silicon(self) -> bool:
        """Whether a chip is in the loop."""
        return self.ranges == "chip"

    @property
    def ranging_codes(self) -> Codes | None:
        """Codes of the ranging chip; None for those of its design, and without it. Raises as `codes_of`."""
        return self.codes_of(NAME) if self.silicon else None

    @property
    def senses(self) -> dict[str, bool]:
        """Options of the sonar as they are in force: all of them on with a sonar, unless given."""
        names = ("occlusion", "multipath", "soft_pings")
        if self.ranges == "exact":
            return dict.fromkeys(names, False)
        return {name: getattr(self, name) is not False for name in names}


def no_silicon(scenario: Scenario) -> str:
    """Say what puts a chip into the loop.

    The text is empty where a chip is in the loop.
    """
    return "" if scenario.silicon else "give `ranges=chip`"


def check_pipes(scenario: Scenario) -> None:
    """Raise `DataError` for a file that is no list of pipes."""
    if is_file(scenario.forest):
        read_pipes(scenario.forest)
