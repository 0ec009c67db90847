"""Samples of what a microphone and its amplifier give.

A sample lies on the grid k / sample_rate, and its value does not depend on the segment it is asked in:

    v(t) = v_mid + sum_p A_p e(t - t_p) cos(2 pi f (t - d_p)) + n(t),   cut off at the rails

with the paths of `system.worlds.sound.microphone`. Sums are of the in-phase and quadrature parts about the
carrier.
"""

from __future__ import annotations

import math

import numpy as np

from circuits.arrays import F64
from circuits.errors import ParameterError
from system.worlds.sound.acoustics import baseband_noise, carrier, interpolate_noise, tone_envelope
from system.worlds.sound.microphone import Microphone, MicrophoneState, SoundPath, merged_intervals

CHUNK = 8192  # samples worked on at once, so that they stay in the cache
_GRID_SLACK = 1e-6  # samples: a time this little past a grid point counts as on it


def waveform(
    parameters: Microphone, state: MicrophoneState, start_s: float, stop_s: float, sample_rate: float
) -> tuple[F64, F64]:
    """Return samples of the amplifier's output.

    Sample k lies at k / sample_rate; the segment has those with start_s <= k / sample_rate < stop_s, so
    that adjoining segments share none. A sample's value does not depend on the segment it is asked in.

    Parameters
    ----------
    parameters : the ear.
    state : holds the paths of every call heard so far.
    start_s, stop_s : the segment in s, from 0 on.
    sample_rate : in Hz; more than twice the carrier.

    Returns
    -------
    time : in s, shape (n,).
    voltage : in V, shape (n,), within the rails.
    """
    _check_segment(parameters, start_s, stop_s, sample_rate)
    first, last = _grid_index(start_s, sample_rate), _grid_index(stop_s, sample_rate)
    voltage = np.full(last - first, parameters.mid_supply)
    spans = [_sample_span(path, sample_rate) for path in state.paths]
    noisy = parameters.noise_rms > 0.0
    for begin, end in merged_intervals(
        [(first, last)] if noisy else ((max(a, first), min(b, last)) for a, b in spans)
    ):
        noise, first_noise = _draw_noise(parameters, begin, end, sample_rate)
        low = begin
        while low < end:
            high = min((low // CHUNK + 1) * CHUNK, end)
            in_phase, quadrature = _noise_part(parameters, noise, first_noise, (low, high), sample_rate)
            for path, span in zip(state.paths, spans, strict=True):
                _add_path(parameters, path, span, low, sample_rate, in_phase, quadrature)
            cosine, sine = carrier(parameters.carrier_frequency, low, high, sample_rate)
            in_phase *= cosine
            quadrature *= sine
            in_phase -= quadrature
            voltage[low - first : high - first] += in_phase
            low = high
    np.clip(voltage, 0.0, parameters.supply, out=voltage)
    return np.arange(first, last) / sample_rate, voltage


def clipped_samples(parameters: Microphone, voltage: F64) -> int:
    """How many samples of `voltage` in V are at a rail."""
    return int(np.count_nonzero((voltage <= 0.0) | (voltage >= parameters.supply)))


def _path_phasor(parameters: Microphone, path: SoundPath) -> tuple[float, float]:
    angle = -math.tau * math.fmod(parameters.carrier_frequency * path.delay, 1.0)
    return path.amplitude * math.cos(angle), path.amplitude * math.sin(angle)


def _draw_noise(parameters: Microphone, begin: int, end: int, sample_rate: float) -> tuple[F64, int]:
    if parameters.noise_rms == 0.0:
        return np.zeros((2, 0)), 0
    step = parameters.noise_rate / sample_rate
    first, last = math.floor(begin * step), math.floor((end - 1) * step) + 1
    samples = baseband_noise(parameters.seed, parameters.channel, first, last + 1)
    return parameters.noise_rms * samples, first


def _noise_part(
    parameters: Microphone,
    noise: F64,
    first_noise: int,
    span: tuple[int, int],
    sample_rate: float,
) -> tuple[F64, F64]:
    if parameters.noise_rms == 0.0:
        return np.zeros(span[1] - span[0]), np.zeros(span[1] - span[0])
    position = np.arange(*span, dtype=np.float64) * (parameters.noise_rate / sample_rate)
    return interpolate_noise(noise, first_noise, position)


def _add_path(
    parameters: Microphone,
    path: SoundPath,
    span: tuple[int, int],
    low: int,
    sample_rate: float,
    in_phase: F64,
    quadrature: F64,
) -> None:
    """Add to the baseband samples from `low` on, in place.

    Ramps are worked out whole and then cut, so that a sample's value does not depend on the segment.
    """
    begin, end = max(span[0], low), min(span[1], low + in_phase.size)
    if begin >= end:
        return
    shape = np.ones(end - begin)
    ramp = math.ceil(parameters.rise_time * sample_rate) + 1
    rise, fall = (span[0], min(span[0] + ramp, span[1])), (max(span[1] - ramp, span[0]), span[1])
    for ramp_begin, ramp_end in (rise, fall):
        inner, outer = max(ramp_begin, begin), min(ramp_end, end)
        if inner < outer:
            since_onset = np.arange(ramp_begin, ramp_end) / sample_rate - path.onset
            values = tone_envelope(since_onset, path.offset - path.onset, parameters.rise_time)
            shape[inner - begin : outer - begin] = values[inner - ramp_begin : outer - ramp_begin]
    x, y = _path_phasor(parameters, path)
    in_phase[begin - low : end - low] += x * shape
    quadrature[begin - low : end - low] += y * shape


def _sample_span(path: SoundPath, sample_rate: float) -> tuple[int, int]:
    return math.ceil(path.onset * sample_rate), math.floor(path.offset * sample_rate) + 1


def _grid_index(time: float, sample_rate: float) -> int:
    return math.ceil(time * sample_rate - _GRID_SLACK)


def _check_segment(parameters: Microphone, start_s: float, stop_s: float, sample_rate: float) -> None:
    if not 0.0 <= start_s <= stop_s < math.inf:
        raise ParameterError(
            f"segment: {start_s:g} to {stop_s:g} s, must start at 0 or later and not end before its start; "
            "swap or move it"
        )
    lowest = 2.0 * parameters.carrier_frequency
    if not lowest < sample_rate < math.inf:
        raise ParameterError(
            f"sample_rate: {sample_rate:g} Hz, must be > {lowest:g} Hz, twice the carrier; try 1e6"
        )
