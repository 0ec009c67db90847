"""What reads and sets voltages and currents of the teaching chip's board, and how it errs.

* DAC: 10 bits of 1.759531 mV; the host cuts a voltage down to a code.
* ADC: 12 bits of 0.8056640625 mV behind a buffer that reads from 13 mV to 1.781 V; of fast records 10 bits,
  with an interference near 10 kHz.
* ammeter: a shunt and an amplifier of a hundred; below 66 mV at its output it reads nothing, and at 3.3 V it
  is full.
* converter (C2F): events of a charge Q each, with a dead time; counts of 16 bits in a time, not a frequency:
  `n = T / (Q / I + t_d)`, and dark counts beside. Two of the sixteen channels count each event twice. Above
  some 30 nA the range switches, and readings scatter by 15 %.

Source: steps, ranges, dead zone, charges and dead times are the laboratory's and what its data show; that the
scatter above the range is normal, and the phase of the interference, are ours.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from circuits.arrays import F64
from circuits.blocks.bench.curve import within_supply
from circuits.errors import ParameterError
from circuits.units import quantity

DAC_STEP, DAC_CODES = 1.759531e-3, 1024  # V
ADC_STEP, ADC_CODES = 0.8056640625e-3, 4096  # V
FAST_STEP = 4.0 * ADC_STEP  # V, of 10 bits
AMPLIFIED = 100.0
COUNTS = 65_535  # the most that a converter's word holds


@dataclass(frozen=True, slots=True)
class Channel:
    """A current-to-frequency converter: charge of an event, C, dead time, s, and counts an event."""

    charge: float
    dead_time: float = 2.1e-6
    counts: int = 1


@dataclass(frozen=True, slots=True)
class Range:
    """A range of an ammeter: its shunt, Ohm, the current at which it is full, and what it adds, A."""

    shunt: float
    full: float
    offset: float = 0.0


RANGES = {"low": Range(33e3, 1e-6), "high": Range(330.0, 100e-6)}


@dataclass(frozen=True, slots=True)
class Board:
    """What a board has of errors.

    Attributes
    ----------
    dac_offset
        Added to every voltage that is set, V.
    adc_offset
        Added to every voltage that is read, V.
    adc_scale
        Factor of every voltage that is read; 0.9961 for a reference of 3.313 V.
    buffer_low, buffer_high
        Lowest and highest voltage that the buffer passes on, V.
    dead_zone
        Voltage at the output of an ammeter's amplifier below which it reads nothing, V.
    interference
        Amplitude of what fast records have near 10 kHz, V.
    dark_rate
        Events of a converter without a current, Hz.
    range_current
        Current at which a converter's range switches, A.
    scatter
        Relative standard deviation of readings above it.
    ranges
        Of the ammeters, by name.
    channels
        Converters by the name of the pin; those that are left out are nominal.
    """

    dac_offset: float = quantity(0.0, "V")
    adc_offset: float = quantity(0.0, "V")
    adc_scale: float = quantity(1.0, "")
    buffer_low: float = quantity(13e-3, "V")
    buffer_high: float = quantity(1.781, "V")
    dead_zone: float = quantity(66e-3, "V")
    interference: float = quantity(1.5e-3, "V")
    dark_rate: float = quantity(30.0, "Hz")
    range_current: float = quantity(30e-9, "A")
    scatter: float = quantity(0.15, "")
    ranges: Mapping[str, Range] = field(default_factory=lambda: dict(RANGES))
    channels: Mapping[str, Channel] = field(default_factory=dict)


# Charges on the scale of bias currents of 3 W / L: three times those of calibrations with W / L alone;
# of channels that only the winner-take-all reaches the charge of its calibration, and a usual dead time.
CHANNELS = {
    0: Channel(0.360e-12, 2.35e-6),
    1: Channel(0.436e-12, 2.7e-6),
    2: Channel(0.2332e-12),
    3: Channel(0.2955e-12),
    4: Channel(0.2653e-12),
    5: Channel(0.372e-12, 1.84e-6),
    6: Channel(0.421e-12, 2.29e-6, 2),
    7: Channel(0.426e-12, 2.06e-6),
    8: Channel(0.2798e-12),
    9: Channel(0.2195e-12),
    10: Channel(0.2036e-12),
    11: Channel(0.387e-12, 2.06e-6),
    12: Channel(0.487e-12, 2.19e-6),
    13: Channel(0.434e-12, 1.76e-6),
    14: Channel(0.321e-12, 1.53e-6, 2),
    15: Channel(0.2151e-12),
}


def channel(number: int) -> Channel:
    """The converter of a channel, 0 to 15; raises `ParameterError` for another number."""
    if not 0 <= number < 16:
        raise ParameterError(f"C2F{number}: must be a channel from 0 to 15")
    return CHANNELS[number]


def set_level(board: Board, pin: str, volt: float, v_dd: float) -> float:
    """What the DAC makes of a voltage for a pin, V.

    Raises `ParameterError` for one that leaves the supply `v_dd`, V.
    """
    within_supply(pin, v_dd, volt)
    code = min(int(volt / DAC_STEP * (1.0 + 1e-12)), DAC_CODES - 1)
    return min(max(code * DAC_STEP + board.dac_offset, 0.0), v_dd)


def read_level(board: Board, volt: F64 | float, step: float = ADC_STEP) -> F64:
    """What the ADC reads of voltages behind the buffer, V; step: of its codes, V."""
    passed = np.clip(volt + board.adc_offset, board.buffer_low, board.buffer_high) * board.adc_scale
    code = np.floor(passed / step)
    return np.asarray(np.minimum(code, ADC_CODES * ADC_STEP / step - 1.0) * step)


def read_ammeter(board: Board, current: float, span: Range) -> float:
    """What an ammeter reads of a current, A: nothing in its dead zone, its full scale above it."""
    per_ampere = span.shunt * AMPLIFIED
    if (abs(current) + max(span.offset, 0.0)) * per_ampere < board.dead_zone:
        return 0.0
    at_output = max(abs(current) + span.offset, 0.0) * per_ampere
    code = min(math.floor(at_output / ADC_STEP), ADC_CODES - 1)
    return code * ADC_STEP / per_ampere


def read_counts(board: Board, one: Channel, current: float, time: float, normal: float) -> int:
    """Counts of a converter in a time, s.

    Parameters
    ----------
    board
        The board's errors.
    one
        The converter.
    current
        What it converts, A.
    time
        For how long, s.
    normal
        A standard normal draw, of which the phase of the first event, the dark counts or the scatter above
        the range are made.
    """
    if not time > 0.0:
        raise ParameterError(f"counts: {time:g} s, must be > 0; give the time to count in")
    events = time / (one.charge / current + one.dead_time) if current > 0.0 else 0.0
    if current > board.range_current:
        events *= max(1.0 + board.scatter * normal, 0.0)
    share = 0.5 * (1.0 + math.erf(normal / math.sqrt(2.0)))  # uniform, 0 to 1
    dark = board.dark_rate * time
    whole = math.floor(events + share) + round(max(dark + math.sqrt(dark) * normal, 0.0))
    return min(one.counts * whole, COUNTS)


def counted_current(board: Board, one: Channel, counts: float, time: float) -> float:
    """Current that so many counts in a time (s) mean, A: `read_counts` the other way, without its chance."""
    events = max(counts / one.counts - board.dark_rate * time, 1.0)
    return one.charge / (time / events - one.dead_time)


def interference(board: Board, time: F64, phase: float) -> F64:
    """What a fast record has near 10 kHz at times (s), V; phase: 0 to 1 of a period."""
    return np.asarray(board.interference * np.sin(2.0 * math.pi * (1e4 * time + phase)))
