"""Jitter of the rebound neuron's inhibition: why one die answers two calls after different times.

Inhibition lasts while I_inh empties a capacitor. The shot noise of mi5 makes a charge whose variance is q
times itself, so that `sigma(t_inh) = sqrt(q t_inh / I_inh)` from call to call; its flicker moves its
threshold, `dt_inh = t_inh kappa_n dV_T0 / U_T` (under the
full law by d ln I / dV_T0 of the device), by the mean over t_inh of a sum of relaxations that go on
from call to call (`circuits.solver.noise.transient.relaxations`). The mean over T of a relaxation of rate
lambda and variance 1 has the variance `2 (l - 1 + e^-l) / l^2`, l = lambda T; between the means of two calls
it is taken to decay as the relaxation does. Where a line of the bias generator gives
I_inh_tau, it moves the gate of mi5 likewise (`chips.lines.wander`): by its own noise, by what all neurons get
from the masters alike, each from eight sources that are drawn once a chip, and by a ripple of the supply.
Left out: the noise of the membrane and of the comparator, kT/C
at the release; against the transistors in the experiment `device-noise`.

Draws are keyed by (seed, trial, neuron's place, call): the same in any order, another seed or trial is
another run of the same die.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from chips.lines.wander import Wander, swing_of, wander_of
from chips.noise import SiliconNoise, mean_variance
from chips.ranging.law import Neurons
from chips.ranging.model import Located, ReboundModel, inhibition_current, located, neuron_of
from circuits.arrays import F64, I64, U32
from circuits.compiled import compiled
from circuits.devices.noise import gate_flicker
from circuits.lowering.on_die import transistor_of
from circuits.silicon.die import philox
from circuits.silicon.process import ELEMENTARY_CHARGE
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.steps import normal_pair
from circuits.solver.noise.transient import noise_keys, noise_place, relaxations

_DEVICE, _BIAS = "inhibition.mi5", "i_inh_tau"
_FASTEST = 10.0  # relaxations in the shortest inhibition up to which they are told apart; ours
_PER_BLOCK = 4  # normals of a Philox block
_SHIFT = 1e-3  # V, of a derivative by the gate; ours
SURE = 6.0  # deviations beyond which jitter is not looked for

_compiled = compiled()


class Jitter(NamedTuple):
    """How t_inh of n neurons varies from call to call; n is 0 for neurons without noise.

    t_inh, white: mean, and standard deviation by white noise, s, float64[n]; amplitude: of each relaxation,
    s, float64[n, r]; rate: of the relaxations, 1/s, float64[r]. follow, follow_white: s, float64[n, m], what
    neurons get from m shared sources, whose relaxations count by `share`, float64[n, r]. ripple, lag: peak,
    s, and phase, rad, by a ripple of the supply of `pace` rad/s, float64[n], 0 for none. relaxation: unit
    normals of the neurons, then of the shared sources, float64[n + m, r], last: time of the last call, s,
    float64[1], and calls: int64[1], are the state.
    """

    t_inh: F64
    white: F64
    amplitude: F64
    rate: F64
    follow: F64
    follow_white: F64
    share: F64
    ripple: F64
    lag: F64
    pace: float
    relaxation: F64
    last: F64
    calls: I64
    keys: U32  # [2, (n + m) * blocks], the blocks of a neuron or source side by side
    counters: U32  # [4, (n + m) * blocks]
    words: U32  # [4, (n + m) * blocks]


def no_jitter() -> Jitter:
    """Return the jitter of neurons without noise."""
    none, flat, words = np.zeros(0), np.zeros((0, 0)), np.zeros((4, 0), np.uint32)
    return Jitter(
        none, none, flat, none, flat, flat, flat, none, none, 0.0, flat, np.zeros(1), np.zeros(1, np.int64),
        words[:2], words, words,
    )  # fmt: skip


def lines_at(model: ReboundModel, silicon: Silicon, noise: SiliconNoise, count: int) -> Wander:
    """Return how the lines behind the inhibitions of `count` neurons wander on a silicon."""
    found = wander_of(model.circuit, [_BIAS], silicon, noise)
    return Wander(*(np.resize(x, (count, *x.shape[1:])) for x in found))


def new_jitter(
    model: ReboundModel, neurons: Neurons, silicon: Silicon, noise: SiliconNoise, shortest: float,
    area: float = 1.0, found: Located | None = None,
) -> Jitter:  # fmt: skip
    """Return the jitter of the neurons of `model` on a silicon, before any call.

    shortest: an inhibition (s) that says how fast relaxations are told apart, the same for all temperatures
    between which a state goes on; area: of the drawn devices over the circuit's, for flicker; found: what
    `located` finds there, where that is known.
    """
    gate, devices = located(model, silicon) if found is None else found
    current = inhibition_current(devices, gate[_BIAS])
    flicker = noise.flicker_in(silicon.process)
    rate, variance = relaxations(flicker, shortest / _FASTEST)
    mean = np.sqrt(variance * mean_variance(rate * neurons.t_inh[:, None]))
    slope = neurons.t_inh * neurons.kappa_n / silicon.thermal_voltage
    if devices.on_die.full:
        up, down = (inhibition_current(devices, gate[_BIAS] + x) for x in (_SHIFT, -_SHIFT))
        slope = neurons.t_inh * np.log(up / down) / (2.0 * _SHIFT)
    n = slope.size
    areas = np.full(n, area * transistor_of(neuron_of(model.circuit), _DEVICE).gate_area)
    lines, swing = lines_at(model, silicon, noise, n), swing_of(noise)
    at_gate = gate_flicker(flicker, silicon.process, np.ones(n, np.bool_), areas)
    followed = lines.rate[:, None] / (lines.rate[:, None] + rate)  # of flicker, by the line's capacitor
    # Hz, of white noise in the mean over an inhibition
    averaged = 0.25 * lines.rate * mean_variance(lines.rate * neurons.t_inh)
    sources, blocks = lines.follow.shape[1], 1 + -(-rate.size // _PER_BLOCK)
    keys = noise_keys(noise.seed, noise.trial, [*_paths(model, silicon), *_sources(model, silicon, sources)])
    counters = np.zeros((4, (n + sources) * blocks), np.uint32)
    counters[1] = np.tile(np.arange(blocks), n + sources)
    return Jitter(
        t_inh=neurons.t_inh.copy(),
        white=np.sqrt(ELEMENTARY_CHARGE * neurons.t_inh / current + slope**2 * lines.white * averaged),
        amplitude=slope[:, None] * np.sqrt(at_gate[:, None] + lines.flicker[:, None] * followed) * mean,
        rate=rate,
        follow=slope[:, None] * lines.follow,
        follow_white=(slope * np.sqrt(averaged))[:, None] * lines.follow_white,
        share=mean * np.sqrt(followed),
        ripple=slope * np.abs(lines.supply),
        lag=np.angle(lines.supply) + swing.phase,
        pace=swing.pace,
        relaxation=np.zeros((n + sources, rate.size)),
        last=np.full(1, -math.inf),
        calls=np.zeros(1, np.int64),
        keys=np.repeat(keys, blocks, axis=1),
        counters=counters,
        words=np.zeros_like(counters),
    )


def spread(jitter: Jitter) -> F64:
    """Return the standard deviation of t_inh by white noise and flicker, s, float64[n]."""
    shared = (jitter.follow_white**2).sum(axis=1)
    shared += (jitter.follow**2).sum(axis=1) * (jitter.share**2).sum(axis=1)
    return np.asarray(np.sqrt(jitter.white**2 + (jitter.amplitude**2).sum(axis=1) + shared))


def most(jitter: Jitter) -> F64:
    """Return by how much t_inh is moved at most, s, float64[n]: `SURE` deviations, and the ripple's peak."""
    return np.asarray(SURE * spread(jitter) + jitter.ripple)


def copied(jitter: Jitter) -> Jitter:
    """Return the jitter with a state of its own."""
    return jitter._replace(
        relaxation=jitter.relaxation.copy(), last=jitter.last.copy(), calls=jitter.calls.copy()
    )


@_compiled
def next_durations(j: Jitter, time: float, t_inh: F64) -> None:
    """Write the inhibition of every neuron after a call at `time` s into `t_inh`, s.

    It writes nothing for neurons without noise. The first call finds the relaxations in their stationary
    state.
    """
    n, r = j.amplitude.shape
    if n == 0:
        return
    m = j.follow.shape[1]
    j.counters[0, :] = np.uint32(j.calls[0])
    philox(j.keys, j.counters, j.words)
    blocks = j.keys.shape[1] // (n + m)
    for i in range(0, r, 2):
        _relax_two(j, i, time)
    for k in range(n):
        shift = j.white[k] * normal_pair(j.words[0, k * blocks], j.words[1, k * blocks])[0]
        for i in range(r):
            shift += j.amplitude[k, i] * j.relaxation[k, i]
        t_inh[k] = j.t_inh[k] + shift
    if j.pace > 0.0:
        _add_ripple(j, time, t_inh)
    for s in range(m):
        white = normal_pair(j.words[0, (n + s) * blocks], j.words[1, (n + s) * blocks])[0]
        for k in range(n):
            slow = 0.0
            for i in range(r):
                slow += j.share[k, i] * j.relaxation[n + s, i]
            t_inh[k] += j.follow_white[k, s] * white + j.follow[k, s] * slow
    j.last[0] = time
    j.calls[0] += 1


@_compiled
def _relax_two(j: Jitter, i: int, time: float) -> None:
    """Take relaxation i of all, and the next one where there is one, to a call at `time` s."""
    sources, row = j.relaxation.shape[0], 2 * (i % _PER_BLOCK // 2)
    blocks = j.keys.shape[1] // sources
    kept = math.exp(-j.rate[i] * (time - j.last[0]))
    renewed = math.sqrt(1.0 - kept * kept)
    both = i + 1 < j.rate.size
    kept_next = math.exp(-j.rate[i + 1] * (time - j.last[0])) if both else 0.0
    renewed_next = math.sqrt(1.0 - kept_next * kept_next)
    for k in range(sources):
        column = k * blocks + 1 + i // _PER_BLOCK
        fresh, fresh_next = normal_pair(j.words[row, column], j.words[row + 1, column])
        j.relaxation[k, i] = kept * j.relaxation[k, i] + renewed * fresh
        if both:
            j.relaxation[k, i + 1] = kept_next * j.relaxation[k, i + 1] + renewed_next * fresh_next


@_compiled
def _add_ripple(j: Jitter, time: float, t_inh: F64) -> None:
    """Take off what more current in the mean over an inhibition from `time` s on shortens it by."""
    for k in range(t_inh.size):
        angle, over = j.pace * time + j.lag[k], j.pace * j.t_inh[k]
        t_inh[k] -= j.ripple[k] * (math.cos(angle) - math.cos(angle + over)) / over


def _paths(model: ReboundModel, silicon: Silicon) -> list[str]:
    """Path of each mi5 on its chip."""
    group = model.transistors[_DEVICE]
    root = noise_place(silicon, model.circuit.name)
    return [f"{root}.{group.label(k)}" for k in range(group.nodes.shape[1])]


def _sources(model: ReboundModel, silicon: Silicon, count: int) -> list[str]:
    """Path of each source of noise that the lines of a chip share, the chip of a lone neuron too."""
    place = (silicon.place or ((model.circuit.name, ()),))[:1]
    root = noise_place(replace(silicon, place=place), model.circuit.name)
    return [f"{root}.bias generator.shared masters.{k}" for k in range(count)]
