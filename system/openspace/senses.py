"""How the bat in the forest senses and selects: exactly, by sound, or by chips on a die.

Ranges are `exact`, as in the paper; of a `sonar`, whose echoes overlap, come while the bat flies on, and by
choice hide behind each other or bounce; or those of a ranging `chip`, which hears whole pings where it has
codes, else one reading an echo (`system.openspace.population`, `.reader`). The chip gives no azimuth:
bearings are exact, or have Gaussian noise from the run's own seed.

The selection's model decides as its transistors on the forest's own currents, with risks of up to 0.8 of the
least excitation: 48 of 48 pairs on dies A/1000 to 1003, the time 5 % off rms (mismatch and process, 27 degC).

Numbers of the senses, all ours:

===============  =====  ====================================================================================
air              degC   20, the approach system's; the reader takes the same for what a delay means
overlap          s      1e-3, length of the approach system's call: an echo that begins within is not told
                        apart; of `sonar` only, because the chip's own neurons decide otherwise
radius           m      0.05, of an obstacle, for its shadow
strength         m      0.2, what an obstacle scatters to 1 m, of the sound that meets it
unit             A      5e-9, of the selection's currents a unit of desirability: D_0 = 10 is 50 nA
deadline         s      1e-3, that a selection may take
===============  =====  ====================================================================================
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from chips.codes import Codes
from chips.selection.kernel import Selection
from chips.selection.model import MARGIN
from chips.selection.noise import no_selection_noise
from chips.selection.whole import no_whole
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.generator.ripple import Ripple
from circuits.silicon.silicon import Silicon
from system.openspace.law import ARCS, Bat
from system.openspace.population import check_rate, coded, forget, no_population, population_on
from system.openspace.reader import CALIBRATIONS, STEP, Calibration, readings
from system.openspace.reader_noise import no_reader, reader_of
from system.openspace.selecting import FIXED, Selecting, chosen_by
from system.openspace.senses_kernel import Senses
from system.option import option
from system.options.noise import Noisy, check_noise, noise_option, noise_seed_option, silicon_noise
from system.worlds.sound.acoustics import AIR_TEMPERATURE, CALL_DURATION, speed_of_sound

RANGES, SELECTIONS = ("exact", "sonar", "chip"), ("ideal", "chip")
SHADOW_RADIUS, STRENGTH = 0.05, 0.2  # m
UNIT, DEADLINE = 5e-9, 1e-3  # A, s
_NOISE = 65_521  # draws, which a run takes in turn
_NOMINAL = Silicon()


@dataclass(frozen=True, slots=True)
class Sensing:
    """What the bat senses and selects with.

    occlusion, multipath: of `sonar` and `chip`; azimuth_noise: rad, standard deviation; reader: look-up
    values of a ranging chip that has no codes of its own; ranging_area, selection_area: of the chips' drawn
    devices over the circuits', which moves their mismatch and flicker alone; silicon_noise: of both chips'
    devices, by noise_seed (or the run's); ripple: of their generator's supply.
    """

    ranges: str = option("exact", "Exact places, of a sonar, or of a chip", choices=RANGES, study=True)
    selection: str = option("ideal", "Ideal, or a die's", choices=SELECTIONS, study=True)
    occlusion: bool = option(default=False, about="Obstacles hide those behind them")
    multipath: bool = option(default=False, about="Echoes by way of two obstacles")
    azimuth_noise: float = option(0.0, "Of every echo, standard deviation", unit="deg", to_field=math.radians)
    reader: Calibration = "nominal"
    ranging_area: float = 1.0
    selection_area: float = 1.0
    silicon_noise: Noisy = noise_option()
    noise_seed: int | None = noise_seed_option()
    ripple: Ripple | None = None

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the option that breaks its rule."""
        if self.ranges not in RANGES:
            raise ParameterError(f"ranges: {self.ranges}, must be {', '.join(RANGES[:-1])} or {RANGES[-1]}")
        if self.selection not in SELECTIONS:
            raise ParameterError(f"selection: {self.selection}, must be {' or '.join(SELECTIONS)}")
        check_noise(self.silicon_noise, self.noise_seed)
        if self.reader not in CALIBRATIONS:
            raise ParameterError(f"reader: {self.reader}, must be {' or '.join(CALIBRATIONS)}")
        if not 0.0 <= self.azimuth_noise < math.pi:
            degrees = math.degrees(self.azimuth_noise)
            raise ParameterError(f"azimuth_noise: {degrees:g} degrees, must be from 0 to below 180")
        self._check_use()

    def _check_use(self) -> None:
        """Refuse options of senses that are not there."""
        asked = {
            "occlusion": (self.occlusion, self.ranges != "exact"),
            "multipath": (self.multipath, self.ranges != "exact"),
            "azimuth_noise": (self.azimuth_noise > 0.0, self.ranges != "exact"),
            "reader": (self.reader != "nominal", self.ranges == "chip"),
        }
        for name, (given, used) in asked.items():
            if given and not used:
                wanted = "chip" if name == "reader" else "sonar` or `ranges=chip"
                raise ParameterError(f"{name}: not with `ranges={self.ranges}`; give `ranges={wanted}`")

    @property
    def silicon(self) -> bool:
        """Whether a chip is in the loop."""
        return "chip" in (self.ranges, self.selection)


IDEAL = Sensing()


def senses_of(
    sensing: Sensing, bat: Bat, silicon: Silicon = _NOMINAL, seed: tuple[int, ...] = (0,),
    begun_c: float | None = None, bias_kind: BiasKind = "generator", codes: Codes | None = None,
    selecting: Selecting = FIXED,
) -> Senses:  # fmt: skip
    """Return the arrays for the compiled loop; both chips are on one silicon.

    seed: of bearings, its first number of the silicon's noise too, whose state one sample overwrites;
    begun_c: temperature of a sample's beginning where it moves; bias_kind, codes: of the ranging chip, which
    hears whole pings and is read by all that answers where it has codes, else by the first neuron; selecting:
    what the selection's chip is biased with.

    Raises `ParameterError` for silicon that a model does not cover, and for pings that come before a
    calibrated ranging chip has answered the last one's echoes; a die outside the validity box of the
    ranging chip's record warns.
    """
    speed = speed_of_sound(AIR_TEMPERATURE)
    reading, reader, population = np.empty(0), no_reader(), no_population()
    noise = silicon_noise(
        sensing.silicon_noise, seed[0] if sensing.noise_seed is None else sensing.noise_seed, sensing.ripple
    )
    if sensing.ranges == "chip":
        area = sensing.ranging_area
        if codes is None:
            delays = readings(silicon, sensing.reader, area, bias_kind)[0]
            reader = reader_of(silicon, sensing.reader, noise, area, bias_kind, begun_c)
            reading = 0.5 * speed * delays
        else:
            check_rate("ping_rate", bat.ping_rate, 2.0 * bat.max_range / speed)
            touched = 2.0 * bat.zone / (speed + bat.max_speed)
            population = population_on(coded(silicon, codes, bias_kind, area, touched), noise, begun_c)
    chip, chip_noise, board = _NO_CHIP, no_selection_noise(), np.ones(ARCS)
    if sensing.selection == "chip":
        chip, chip_noise, board = chosen_by(bat, silicon, sensing.selection_area, selecting, noise)
    return Senses(
        exact=int(sensing.ranges == "exact"),
        occlusion=int(sensing.occlusion),
        multipath=int(sensing.multipath),
        sound_speed=speed,
        overlap=CALL_DURATION if sensing.ranges == "sonar" else 0.0,
        radius=SHADOW_RADIUS,
        strength=STRENGTH,
        noise=_noise(sensing.azimuth_noise, seed),
        reading=reading,
        per_second=1.0 / STEP,
        reader=reader,
        population=population,
        selecting=int(sensing.selection == "chip"),
        unit=UNIT,
        deadline=DEADLINE,
        margin=MARGIN,
        chip=chip,
        chip_noise=chip_noise,
        board=board,
    )


def _noise(sigma: float, seed: tuple[int, ...]) -> F64:
    if sigma == 0.0:
        return np.zeros(1)
    return sigma * np.random.default_rng((*seed, 2)).standard_normal(_NOISE)


def _no_chip() -> Selection:
    """Of the same type for the compiled loop."""
    row, table = np.zeros(0), np.zeros((0, 0))
    lines = (row, row, row, table, table, row, row, row, row, row, row)
    return Selection(*lines, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, row, 0.0, no_whole())


_NO_CHIP = _no_chip()
EXACT = senses_of(IDEAL, Bat())


def begin_again(senses: Senses) -> None:
    """Begin another run, its chip at rest and with draws of its own: what flicker was before is forgotten."""
    senses.reader.jitter.last[:] = -math.inf
    forget(senses.population)


def with_area(sensing: Sensing, area: float) -> Sensing:
    """Return the same senses with the devices of both chips `area` times as large."""
    return replace(sensing, ranging_area=area, selection_area=area)
