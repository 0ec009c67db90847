"""Noise of the hearing's thresholds from that of its devices.

Noise of the voltage that a neuron compares, v, makes it hear a sound sooner or later, or not at all, as if
its threshold were another: a step D that has just to be reached is one of `D + v`, of a sound whose peak is
another by

    delta ln A = v / (D p),     p = d ln(step) / d ln A at the threshold

and the latency follows from the measured table over peak / threshold, with the crossing's own slope. v is the
noise of the whole chain from the microphone on, integrated over frequency about rest
(`circuits.solver.noise_analysis`): for the onset neuron at v_h, for the high-threshold neuron at the
envelope. p is the detector's, whose step goes as `ln I_0(kappa A / U_T)`. The comparators take microseconds,
far less than the detector's 64 us. Each sound has a draw a neuron.
Left out: noise of the comparators and of the onset neuron's own threshold branch (a hundredth of v), what a
loud sound does to the detector's noise while it lasts.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.special import i0e, i1e

from chips.board_kernel import Hearing
from chips.noise_draw import Draws, draw, new_draws
from chips.rebound_jitter import SiliconNoise
from circuits.blocks import envelope_detector, high_threshold_neuron, onset_neuron
from circuits.circuit import Circuit, Instance, Port
from circuits.compiled import compiled
from circuits.devices import Source
from circuits.devices.source import Constant
from circuits.noise import NoiseModel, noise_model
from circuits.silicon import Silicon
from circuits.solver.noise_analysis import noise as noise_at
from circuits.solver.noise_transient import noise_place
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench

BAND = (0.1, 10e6, 161)  # Hz, Hz, points: from where flicker levels off to beyond all poles; ours


class HearingNoise(NamedTuple):
    """Deviations of ln(threshold) of the onset and the high-threshold neuron; draws: of a sound."""

    onset: float
    high_threshold: float
    draws: Draws


def no_hearing_noise() -> HearingNoise:
    """Of a hearing without noise."""
    return HearingNoise(0.0, 0.0, new_draws(0, 0, "", 0))


def hearing_noise(
    onset: Hearing, high: Hearing, silicon: Silicon, noise: SiliconNoise | None
) -> HearingNoise:
    """Noise of a hearing of these numbers on `silicon`; None for none."""
    if noise is None:
        return no_hearing_noise()
    model = noise_model(silicon.process) if noise.flicker is None else noise.flicker
    volts = dict(zip(("onset", "high"), rest_noise(silicon, model), strict=True))
    steps = steps_of(silicon)
    found = [
        volts[name] / (steps[k] * exponent(m.threshold, silicon))
        for k, (name, m) in enumerate((("onset", onset), ("high", high)))
    ]
    path = f"{noise_place(silicon, 'hearing')}, sound"
    return HearingNoise(found[0], found[1], new_draws(noise.seed, noise.trial, path, 2))


def exponent(peak: float, silicon: Silicon) -> float:
    """`d ln(step) / d ln A` of the detector at a peak (V): 2 of weak sounds, 1 of loud ones."""
    z = silicon.law("n").kappa * peak / silicon.thermal_voltage
    return float(z * (i1e(z) / i0e(z)) / (np.log(i0e(z)) + z))


def steps_of(silicon: Silicon) -> tuple[float, float]:
    """Steps (V) that are asked for: of v_h, and of the envelope above its pedestal."""
    onset = {b.name: float(np.asarray(b.value)) for b in onset_neuron.BIASES}
    high = {b.name: float(np.asarray(b.value)) for b in high_threshold_neuron.BIASES}
    pedestal = {b.name: float(np.asarray(b.value)) for b in envelope_detector.BIASES}["v_pedestal"]
    own = silicon.law("n").kappa * (onset["v_level"] - onset["v_base"])
    return own, high["v_threshold"] - pedestal


@lru_cache(maxsize=16)
def rest_noise(silicon: Silicon, model: NoiseModel) -> tuple[float, float]:
    """Deviation (V) of v_h and of the envelope at rest, by all devices from the microphone on."""
    circuit = chain(onset_neuron.build())
    v_dd = silicon.process.v_dd
    sources = Source("vdd", "vdd", Constant(v_dd)), Source("microphone", "microphone", Constant(0.5 * v_dd))
    point = operating_point(Testbench("hearing", circuit, sources, 1.0), silicon)
    frequency = np.geomspace(*BAND)
    nodes = "neuron.v_h", "envelope"
    found = [noise_at(point, n, frequency, model=model).variance ** 0.5 for n in nodes]
    return found[0], found[1]


def chain(neuron: Circuit) -> Circuit:
    """Detector and a neuron that hears its envelope: ports microphone, spike, biases and the supply."""
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
    instances = tuple(
        Instance(name, part, {p.name: p.name for p in part.ports}) for name, part in parts.items()
    )
    return Circuit("hearing", ports, instances=instances, biases=tuple(biases))


@compiled()
def threshold_factors(n: HearingNoise, number: int) -> tuple[float, float]:
    """What both neurons' thresholds are multiplied by for sound `number`; 1 without noise."""
    if n.onset == 0.0 and n.high_threshold == 0.0:
        return 1.0, 1.0
    draw(n.draws, number, 0)
    return 1.0 + n.onset * float(n.draws.normal[0]), 1.0 + n.high_threshold * float(n.draws.normal[1])
