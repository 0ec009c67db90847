"""Every number of the sonar head, and of the targets that it follows.

Cheely & Horiuchi 2003, Figure 7, show two ultrasonic microphones, a speaker and a servo neck, and name an
interaural level difference system (their reference 23, Horiuchi & Hynna 2001); they give no number. So all
of these are ours, but for the transducers' 40 kHz. Lengths in m, times in s, angles in rad, voltages in V.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from chips.lso.measure import LEVELS
from circuits.errors import ParameterError
from system.numbers import check_numbers
from system.option import option

BEHIND = 0.5 * math.pi  # rad from straight ahead: what is further is behind the head


def _radians(degrees: float) -> float:
    return degrees * math.radians(1.0)


@dataclass(frozen=True, slots=True)
class SonarHead:
    """Numbers of the ears, the neck, and the law between them; all are ours.

    gain is the middle of five that were tried on dies 0 to 5: less lags behind the sine, more makes the head
    tremble about a target at rest. The level units' thresholds are for targets between 0.5 and 2 m.

    ============  =====  ================================================================================
    squint        rad    of either microphone from straight ahead
    beam          rad    half-power width of every transducer: 0.6 dB of level difference a degree
    spacing       m      between the microphones
    call          s      length of the tone
    rise          s      of its edges, raised cosines
    volts         V      of the envelope, of an echo from 1 m where both beams point
    rail          V      at which the envelope is cut off
    lowest        V      threshold of the first level unit above the envelope's pedestal
    level_step    dB     from one threshold to the next
    blanking      s      after the call's begin in which the ears are shut
    ear_noise     -      rms of ln amplitude of each ear's echo, on its own
    glint         -      rms of ln amplitude of both ears' echoes together
    ping_rate     Hz     calls
    decision      -      share of a ping's period after which spikes are counted and the neck told
    gain          rad    of neck a spike
    neck_speed    rad/s  as the robot's of Wen & Horiuchi 2022
    neck_step     rad    of the servo: its angles are whole steps
    neck_most     rad    to either side
    ============  =====  ================================================================================
    """

    squint: float = math.radians(45.0)
    beam: float = math.radians(60.0)
    spacing: float = 0.04
    call: float = 1e-3
    rise: float = 0.2e-3
    volts: float = 1.1
    rail: float = 4.0
    lowest: float = 80e-3
    level_step: float = 3.0
    blanking: float = 3e-3
    ear_noise: float = option(
        0.1, "Of each ear's echo, relative rms", name="noise", unit="", least=0.0, study=True, key=""
    )
    glint: float = 0.2
    ping_rate: float = option(10.0, "Of pings", unit="Hz", above=0.0, study=True)
    decision: float = 0.6
    gain: float = option(
        math.radians(1.5), "Of the neck a spike", unit="deg", to_field=_radians, least=0.0, study=True, key=""
    )
    neck_speed: float = math.radians(480.0)
    neck_step: float = math.radians(0.5)
    neck_most: float = math.radians(80.0)

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the number that breaks its rule."""
        check_numbers("head", self, from_zero=("gain", "ear_noise", "glint"))
        if self.decision > 1.0:
            raise ParameterError(f"head.decision: {self.decision:g}, must be at most 1, the whole period")
        if 2.0 * self.rise > self.call:
            raise ParameterError(
                f"head.rise: {self.rise:g} s, must be at most half of the call, {self.call:g} s"
            )

    @property
    def period(self) -> float:
        """From ping to ping, s."""
        return 1.0 / self.ping_rate

    @property
    def thresholds(self) -> tuple[float, ...]:
        """Of the level units, above the envelope's pedestal, V."""
        return tuple(self.lowest * 10.0 ** (self.level_step * k / 20.0) for k in range(LEVELS))


@dataclass(frozen=True, slots=True)
class Motion:
    """Numbers of how a target moves; all are ours.

    =============  =====  ==============================================================================
    azimuth        rad    largest, of a sine and of a walk; of a step, all of it
    period         s      of the sine
    step_at        s      when the step comes
    walk_rate      rad/s  rms of a walk's speed
    walk_time      s      for which it keeps it, about
    distance       m      mean
    swing          m      of the distance, a sine of another period; a walk's stays within it
    swing_period   s
    =============  =====  ==============================================================================
    """

    azimuth: float = option(
        math.radians(40.0), "Of the target", unit="deg", to_field=_radians, least=0.0, study=True, key=""
    )
    period: float = option(10.0, "Of the sine", unit="s", above=0.0, study=True, key="")
    step_at: float = 1.0
    walk_rate: float = math.radians(20.0)
    walk_time: float = 1.0
    distance: float = option(1.0, "Of the target, mean", unit="m", above=0.0, study=True)
    swing: float = option(0.4, "Of the distance", unit="m", least=0.0, study=True)
    swing_period: float = 7.0

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the number that breaks its rule."""
        check_numbers("target", self, from_zero=("swing", "azimuth"))
        if self.azimuth >= BEHIND:
            raise ParameterError(
                f"target.azimuth: {math.degrees(self.azimuth):g} deg, must be below"
                f" {math.degrees(BEHIND):g} deg; what is further is behind the head"
            )
        if self.swing >= self.distance:
            raise ParameterError(
                f"target.swing: {self.swing:g} m, must be below the distance, {self.distance:g} m"
            )
