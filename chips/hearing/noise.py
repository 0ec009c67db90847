"""Noise of the hearing's thresholds, from that of its devices.

Noise makes a neuron hear a sound sooner or later, or not at all, as if its threshold were another, and does
so by how much the time T of its spike scatters over how much T follows the sound's peak A:

    delta ln(threshold) = sigma(T) / |dT / d ln A|

sigma(T) is that of the chain from the microphone to the spike, of all devices along the way that a sound of
that peak takes (`circuits.solver.noise.event_jitter`), behind a long rest. The way matters: while v_h rises,
the onset neuron's follower carries nothing, which lets slow noise of the envelope pass that it takes away at
rest, and what is compared goes on growing with A while the comparator charges its axon. Both are worked out
on the die at some peaks over threshold; a neuron that does not hear at rest there (`Deafened`) has those of
the nominal die. Between peaks, straight lines over ln(peak / threshold), held beyond them. Each sound has a
draw a neuron.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from chips.hearing.kernel import SOUND_DURATION, Hearing
from chips.measured.interpolation import table_at
from chips.noise import SiliconNoise
from chips.noise_draw import Draws, draw, new_draws
from circuits.arrays import F64, in_rows
from circuits.blocks.sonar import envelope_detector, high_threshold_neuron, onset_neuron
from circuits.circuit import Circuit, Instance, Port
from circuits.compiled import compiled
from circuits.devices import Source
from circuits.devices.noise import NoiseModel
from circuits.devices.source import Constant, Sampled, polyline
from circuits.errors import ParameterError
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon.die import NOMINAL
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.event_jitter import event_jitter
from circuits.solver.noise.transient import noise_place
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

# peaks over threshold at which jitter is worked out, from where it is still linear on; ours
RATIOS = {"onset": (1.05, 1.2, 2.0, 5.0, 40.0), "high_threshold": (1.05, 1.4, 3.0)}
APART = 0.03  # of ln A to both sides, for dT / d ln A; ours
REST = 10e-3  # s, before a sound, longer than any memory of the chain; ours
ONSET = 50e-6  # s, when the sound begins, whole periods of its carrier
LATEST = 0.7e-3  # s, of a run; what is heard is heard within 0.5 ms
RTOL = 2e-6  # of a run: latencies within 0.05 us of the converged ones; ours


class HearingNoise(NamedTuple):
    """Noise of both neurons' thresholds, none if the arrays are empty.

    onset_knots, high_knots: ln(peak / threshold), float64[k]; onset, high: standard deviation of
    ln(threshold) there, float64[k]; draws: of each sound.
    """

    onset_knots: F64
    onset: F64
    high_knots: F64
    high: F64
    draws: Draws


def no_hearing_noise() -> HearingNoise:
    """Return the noise of a hearing that has none."""
    none = np.zeros(0)
    return HearingNoise(none, none, none, none, new_draws(0, 0, "", 0))


def hearing_noise(
    onset: Hearing, high: Hearing, silicon: Silicon, noise: SiliconNoise | None
) -> HearingNoise:
    """Return the noise of a hearing of these numbers on a silicon, or none where `noise` is None."""
    if noise is None:
        return no_hearing_noise()
    model = noise.flicker_in(silicon.process)
    path = f"{noise_place(silicon, 'hearing')}, sound"
    found = [
        threshold_spread(name, numbers.threshold, silicon.seen_by("hearing"), model)
        for name, numbers in (("onset", onset), ("high_threshold", high))
    ]
    return HearingNoise(*found[0], *found[1], new_draws(noise.seed, noise.trial, path, 2))


@lru_cache(maxsize=128)
def threshold_spread(name: str, threshold: float, silicon: Silicon, model: NoiseModel) -> tuple[F64, F64]:
    """Return ln(peak / threshold), and the standard deviation of ln(threshold) there, float64[knots] each.

    name: of the neuron; threshold: of the neuron on this silicon, V at the microphone; model: flicker of the
    devices. Raises `ParameterError` where even the nominal die hears no sound so many times as loud.
    """
    found = list(_spreads(name, threshold, silicon, model))
    if not found:
        found = list(_spreads(name, threshold, replace(silicon, die=NOMINAL), model))
    if not found:
        raise ParameterError(
            f"hearing.{name}.threshold: {threshold:g} V, must be one that makes a spike; take a larger one"
        )
    knots, spread = in_rows(np.array(found).T)
    return knots, spread


def _spreads(
    name: str, threshold: float, silicon: Silicon, model: NoiseModel
) -> Iterator[tuple[float, float]]:
    """ln(peak / threshold) and deviation of those sounds that are heard."""
    quiet = chain_machine(name, 0.0, silicon)
    rest = operating_point(quiet, time=0.0)  # before all sounds, which move the microphone alone
    for ratio in RATIOS[name]:
        peak = ratio * threshold
        earlier, later = (_first_spike(_loud(quiet, peak * math.exp(x)), rest) for x in (APART, -APART))
        if earlier is None or later is None:
            continue
        jitter = event_jitter(_loud(quiet, peak), "spike", model, rest=REST, rtol=RTOL, point=rest)
        yield math.log(ratio), jitter.deviation * 2.0 * APART / (later - earlier)


def _first_spike(machine: Machine, rest: OperatingPoint) -> float | None:
    """When the sound is heard, s; None where it is not."""
    spikes = simulate(machine, rtol=RTOL, record=(), point=rest).spikes["spike"]
    return float(spikes[0]) if spikes.size else None


def _loud(quiet: Machine, peak: float) -> Machine:
    """A chain with a sound of another peak, V; it is not lowered again."""
    sound, lines = _sound(peak, quiet.silicon.process.v_dd, ONSET, LATEST), list(quiet.polylines)
    lines[quiet.source_names.index("microphone")] = polyline("hearing.microphone", sound)
    return replace(quiet, polylines=tuple(lines))


def _sound(peak: float, v_dd: float, onset: float, stop: float) -> Sampled:
    """A sound at the microphone."""
    return envelope_detector.tone_bursts(((onset, SOUND_DURATION, peak),), stop, 0.5 * v_dd, v_dd)


def chain_machine(
    name: str, peak: float, silicon: Silicon, onset: float = ONSET, stop: float = LATEST
) -> Machine:
    """Return a neuron behind the detector, lowered for the solver, that hears a sound.

    name: of the neuron; peak: V; onset: when the sound begins, s; stop: end of the run, s.
    """
    v_dd = silicon.process.v_dd
    wave = Source("microphone", "microphone", _sound(peak, v_dd, onset, stop))
    sources = Source("vdd", "vdd", Constant(v_dd)), wave
    neuron = {"onset": onset_neuron, "high_threshold": high_threshold_neuron}[name].build()
    return to_kernel(Testbench("hearing", chain(neuron), sources, stop, watch=("spike",)), silicon)


def chain(neuron: Circuit) -> Circuit:
    """Return the circuit of the detector and a neuron that hears its envelope.

    Its ports are microphone, spike, the biases and the supply.
    """
    parts = {"detector": envelope_detector.build(), "neuron": neuron}
    biases = [
        bias if bias.device is None else replace(bias, device=f"{name}.{bias.device}")
        for name, part in parts.items()
        for bias in part.biases
    ]
    ports = (
        Port("vdd", "supply"),
        Port("microphone", "analog"),
        Port("spike", "event", "out"),
        *(Port(b.port, "bias") for b in biases),
    )
    instances = tuple(Instance(name, part, part.wired()) for name, part in parts.items())
    return Circuit("hearing", ports, instances=instances, biases=tuple(biases))


@compiled()
def threshold_factors(n: HearingNoise, number: int, onset: float, high: float) -> tuple[float, float]:
    """Return what both thresholds are multiplied by for sound `number`; onset, high: its peak over them."""
    if n.onset.size == 0:
        return 1.0, 1.0
    draw(n.draws, number, 0)
    one = table_at(n.onset_knots, n.onset, math.log(onset)) * float(n.draws.normal[0])
    return 1.0 + one, 1.0 + table_at(n.high_knots, n.high, math.log(high)) * float(n.draws.normal[1])
