"""What a flight that is steered by spikes is asked to do: brain, bat, forest, and the silicon of a chip."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from circuits.errors import ParameterError
from system.openspace import map as forest
from system.openspace.law import Bat
from system.option import check_options, option
from system.options.codes import Coded, check_codes
from system.options.noise import Noisy, check_device_noise, noise_option, noise_seed_option
from system.spiking_bat.numbers import PATHS, UNITS, Numbers, numbers_at

BRAINS = ("network", "chip", "lif")
PING_RATE = 10.0  # Hz; the paper's in Figure 13
PINGS = 1000  # of a flight: 100 s, or some 40 s of computing the network; ours


def read_unit(text: str, name: str) -> tuple[int, int]:
    """Return memory and number of a unit of the text `MEMORY,UNIT`; raises `ParameterError`."""
    parts = text.split(",")
    if len(parts) != 2 or not all(part.strip().isdecimal() for part in parts):
        raise ParameterError(f'{name}: "{text}", must be MEMORY,UNIT; write as in `{name}=16,5`')
    return int(parts[0]), int(parts[1])


@dataclass(frozen=True, slots=True)
class Scenario(Coded):
    """One flight of a bat whose brain answers by spike latencies.

    `paths` are its memories, and `taps` those of a delay line. `map` is a file of obstacles, None to plant
    `obstacles` from the seed. Of a chip: `area` is that of its devices over the circuits'; `units` are those
    at transistor level, by memory and number. `course` has pairs of time (s) and degC that the temperature
    follows after its beginning, `temperature_c`.
    """

    CALIBRATED: ClassVar[tuple[str, ...]] = ("latency-chip",)

    brain: str = option(BRAINS[0], "Ideal neurons, a die's, or integrate-and-fire ones", choices=BRAINS)
    max_speed: float = option(
        Bat().max_speed, "Straight ahead", name="vmax", unit="m/s", above=0.0, study=True
    )
    ping_rate: float = option(PING_RATE, "Of pings", unit="Hz", above=0.0, study=True)
    paths: int = option(PATHS, "Memories", study=True)
    taps: int = option(UNITS, "Of a delay line", study=True)
    map: str | None = forest.map_option()
    obstacles: int = forest.obstacles_option()
    start: tuple[float, float] | None = forest.start_option(forest.read_place)
    pings: int = option(PINGS, "Ends undecided after these", least=1, study=True)
    area: float = option(1.0, "Of the chip's devices, over the circuits'", unit="", study=True, silicon=True)
    units: tuple[tuple[int, int], ...] = option(
        (), "A chip's unit at transistor level, repeatable", name="unit", read=read_unit, collect=tuple,
        metavar="MEMORY,UNIT", silicon=True, key="transistor_units",
    )  # fmt: skip
    silicon_noise: Noisy = noise_option()
    noise_seed: int | None = noise_seed_option()

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self, no_silicon(self))
        if self.map is None:
            forest.check_count(self.obstacles)
        check_device_noise(self)
        check_codes(self)
        if self.area != 1.0 and self.units:
            raise ParameterError("area: not with `unit`, whose devices are the circuit's; leave one out")

    @property
    def bat(self) -> Bat:
        """The bat that flies."""
        return Bat(max_speed=self.max_speed, ping_rate=self.ping_rate)

    @property
    def numbers(self) -> Numbers:
        """Numbers of its network or chip, at its rate of pings."""
        return numbers_at(self.ping_rate, self.taps, self.paths)


def no_silicon(scenario: Scenario) -> str:
    """Say what puts a chip into the loop.

    The text is empty where a chip is in the loop.
    """
    return "" if scenario.brain == "chip" else "add `brain=chip`"


def make(fields: dict[str, Any], _: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields as they are, after a check that a map is not given other obstacles."""
    forest.check_source(fields)
    return fields
