"""What an approach is asked to do: the targets, the sonar's options, and the silicon that it runs on."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar, Literal

from chips.codes import Codes
from chips.hearing.calibration import NAME as HEARING
from chips.hearing.calibration import level_of
from chips.ranging.calibration.found import NAME
from circuits.errors import ParameterError
from circuits.silicon.course import Course
from circuits.silicon.process import ZERO_CELSIUS
from system.option import check_options, option
from system.options.codes import Coded, check_codes
from system.options.noise import Noisy, check_device_noise, noise_option, noise_seed_option
from system.worlds.sound.acoustics import Air
from system.worlds.sound.targets import Target, default_scene, read_targets

Law = Literal["linear", "d4"]
Level = Literal["transistor", "behavioural"]
Box = Literal["chip", "centroid", "vocalization", "hearing", "isolation"]
LONGEST = 3600.0  # s, of a run; ours
_NOISY: tuple[Box, ...] = ("chip", "vocalization", "hearing")  # boxes whose devices make noise
BOXES: tuple[Box, ...] = ("chip", "centroid", "vocalization", "hearing", "isolation")


def _read_targets(text: str, _: str) -> tuple[Target, ...]:
    return read_targets(text)


@dataclass(frozen=True, slots=True)
class Scenario(Coded):
    """An approach: the targets, how long, and at which level and on which silicon each box is.

    Temperature is that of chip, boards and air; chip and boards follow a `course` of it, pairs of time (s)
    and degC, and the air stays. Each board and each single neuron is a circuit of its own, on the chip's die,
    which is the same lot and number. `transistors` names boxes that stay at transistor level in a behavioural
    run. The noise of devices is that of `noisy_boxes`, drawn from `noise_seed`, which is `seed` unless given.
    Codes are those of the ranging chip, by which the boards behind it are trimmed too, and of the hearing.
    """

    CALIBRATED: ClassVar[tuple[str, ...]] = (NAME, HEARING)

    targets: tuple[Target, ...] = option(
        default_scene, "CSV of moving targets", read=_read_targets, metavar="FILE"
    )
    duration: float = option(4.0, "Length of the run", unit="s", above=0.0, most=LONGEST, study=True)
    isolation: bool = option(default=True, about="First-target isolation")
    amplitude_law: Law = option("linear", "Of the call: linear or d4")
    noise_rms: float = option(0.0, "Rms at a microphone, as 1mV", name="noise", unit="V", least=0.0)
    level: Level = option("transistor", "Of all boxes")
    transistors: frozenset[Box] = option(
        frozenset(), "A box kept as transistors, repeatable", choices=BOXES, collect=frozenset, metavar="BOX"
    )
    silicon_noise: Noisy = noise_option(study=False)
    noise_seed: int | None = noise_seed_option()

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self)
        check_device_noise(self)
        if self.ripple is not None and self.level_of("chip") == "transistor":
            raise ParameterError(
                f"ripple: {self.ripple}, the ranging chip is at transistor level, where the supply stands;"
                " give `level=behavioural`"
            )
        check_codes(self)

    @property
    def ranging_codes(self) -> Codes | None:
        """Codes of the ranging chip; None for those of its design. Raises as `codes_of`."""
        return self.codes_of(NAME)

    @property
    def hearing_level(self) -> float:
        """Level of the hearing's onset neuron, V. Raises as `codes_of`."""
        return level_of(self.codes_of(HEARING))

    @property
    def modelled(self) -> bool:
        """Whether no box is at transistor level."""
        return self.level == "behavioural" and not self.transistors

    def level_of(self, box: Box) -> Level:
        """Return the level at which a box runs."""
        return "transistor" if box in self.transistors else self.level

    @property
    def stretches(self) -> Iterator[tuple[float, float, float]]:
        """Begin and end, s, of each stretch of one temperature, and that, degC."""
        if not self.course:
            return iter([(0.0, self.duration, self.temperature_c)])
        return Course(self.course).stretches(0.0, self.duration)

    @property
    def noisy_boxes(self) -> tuple[Box, ...]:
        """Boxes whose devices make noise, which only models do.

        The noise of the centroid board is contained in the intervals between calls.
        """
        on = self.silicon_noise != "off"
        return tuple(box for box in _NOISY if on and self.level_of(box) == "behavioural")

    @property
    def noiseless_boxes(self) -> tuple[Box, ...]:
        """Boxes whose devices would make noise, were they not at transistor level."""
        on = self.silicon_noise != "off"
        return tuple(box for box in _NOISY if on and self.level_of(box) == "transistor")


def air_of(scenario: Scenario) -> Air:
    """Return the air at the temperature of a scenario, at which it stays."""
    return Air(temperature=scenario.beginning_c + ZERO_CELSIUS)
