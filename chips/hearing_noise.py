"""Noise of the hearing's thresholds from that of its devices.

Noise of the voltage that a neuron compares, v, makes it hear a sound sooner or later, or not at all, as if
its threshold were another: a step D that has just to be reached is one of `D + v`, of a sound whose peak is
another by

    delta ln A = v / (D p),     p = d ln(step) / d ln A at the threshold

and the latency T follows from the measured table over peak / threshold. The compared voltage passes the
threshold at a slope `S = p D / |dT / d ln(peak / threshold)|`, the comparator then charges its axon for a
time d (`chips.lso_law.ramp_delay`), and what it sees of v it weighs by `sech^2(psi kappa S t / 2 U_T)`. So v
is the noise of the whole chain from the microphone on, at v_h of the onset neuron or at the envelope, times
that weight's transform W(f), integrated over frequency about rest (`circuits.solver.noise_analysis`); the
comparator's own jitter (`chips.lso_noise.level_spread`) is added. p is the detector's, whose step goes as
`ln I_0(kappa A / U_T)`. Each sound has a draw a neuron.
Left out: the onset neuron's own threshold branch, what a sound does to the detector's noise while it lasts.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0e, i1e

from chips.board_kernel import Hearing, table_at
from chips.board_record import all_on_silicon, matching_tables
from chips.lso_law import ramp_delay
from chips.lso_measurement import circuits
from chips.lso_model import RECORD
from chips.lso_noise import level_grain, level_spread
from chips.noise_draw import Draws, draw, new_draws
from chips.rebound_jitter import SiliconNoise
from circuits.bias import die_current
from circuits.blocks import envelope_detector, high_threshold_neuron, onset_neuron
from circuits.circuit import Circuit, Instance, Port
from circuits.compiled import compiled
from circuits.devices import Source
from circuits.devices.source import Constant
from circuits.noise import NoiseModel, noise_model
from circuits.silicon import Silicon
from circuits.solver.noise_analysis import integrate_power
from circuits.solver.noise_analysis import noise as noise_at
from circuits.solver.noise_transient import noise_place
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench

F64 = NDArray[np.float64]

BAND = (0.1, 10e6, 241)  # Hz, Hz, points: from where flicker levels off to beyond all poles; ours
POINTS = 48  # of a comparator's weight over time; ours


class HearingNoise(NamedTuple):
    """Deviations of ln(threshold) of both neurons over ln(peak / threshold); draws: of a sound.

    onset_knots, onset, high_knots, high: float64[knots], empty without noise.
    """

    onset_knots: F64
    onset: F64
    high_knots: F64
    high: F64
    draws: Draws


def no_hearing_noise() -> HearingNoise:
    """Of a hearing without noise."""
    none = np.zeros(0)
    return HearingNoise(none, none, none, none, new_draws(0, 0, "", 0))


def hearing_noise(
    onset: Hearing, high: Hearing, silicon: Silicon, noise: SiliconNoise | None
) -> HearingNoise:
    """Noise of a hearing of these numbers on `silicon`; None for none."""
    if noise is None:
        return no_hearing_noise()
    model = noise_model(silicon.process) if noise.flicker is None else noise.flicker
    path = f"{noise_place(silicon, 'hearing')}, sound"
    found = [
        threshold_spread(numbers, step, density, silicon)
        for numbers, step, density in zip(
            (onset, high), steps_of(silicon), rest_noise(silicon, model), strict=True
        )
    ]
    draws = new_draws(noise.seed, noise.trial, path, 2)
    return HearingNoise(onset.knots, found[0], high.knots, found[1], draws)


def threshold_spread(numbers: Hearing, step: float, density: F64, silicon: Silicon) -> F64:
    """Deviation of ln(threshold) at the latency's knots, float64[knots]; density: V^2/Hz over `BAND`."""
    law, u_t = silicon.law("p"), silicon.thermal_voltage
    level = high_threshold_neuron.build()
    current = die_current(level, level.bias("i_cmp"), silicon)
    (charge,) = all_on_silicon(
        matching_tables(RECORD, circuits, silicon.process).values, ("level_charge",), silicon
    )
    later = np.abs(np.gradient(numbers.latency, numbers.knots))
    per_ln = exponent(numbers.threshold, silicon) * step  # V of the compared voltage an e-fold of the peak
    slope = per_ln / later
    delay = ramp_delay(slope, float(charge), current, law.kappa, u_t)
    grain = level_grain(current, silicon)
    volts = np.array([
        seen(density, 0.5 * grain.per_volt * s, d) for s, d in zip(slope, delay, strict=True)
    ])  # fmt: skip
    own = level_spread(grain, delay, slope, current)
    return np.asarray(np.hypot(volts / per_ln, own / later))


def seen(density: F64, steep: float, delay: float) -> float:
    """Deviation (V) of the mean with weights sech^2(steep t) over `delay` s; density: V^2/Hz over `BAND`."""
    at = delay * (np.arange(POINTS) + 0.5) / POINTS
    weight = 1.0 / np.cosh(np.minimum(steep * at, 50.0)) ** 2
    frequency = np.geomspace(*BAND)
    passed = np.abs(np.exp(-2j * np.pi * frequency[:, None] * at) @ (weight / weight.sum())) ** 2
    passed *= np.sinc(frequency * delay / POINTS) ** 2  # weights are steps, not points
    return float(np.sqrt(integrate_power(frequency, density * passed)))


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
def rest_noise(silicon: Silicon, model: NoiseModel) -> tuple[F64, F64]:
    """Densities (V^2/Hz, over `BAND`) of v_h and of the envelope at rest, of all devices."""
    circuit = chain(onset_neuron.build())
    v_dd = silicon.process.v_dd
    sources = Source("vdd", "vdd", Constant(v_dd)), Source("microphone", "microphone", Constant(0.5 * v_dd))
    point = operating_point(Testbench("hearing", circuit, sources, 1.0), silicon)
    frequency = np.geomspace(*BAND)
    nodes = "neuron.v_h", "envelope"
    found = [noise_at(point, n, frequency, model=model).output for n in nodes]
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
def threshold_factors(n: HearingNoise, number: int, onset: float, high: float) -> tuple[float, float]:
    """What thresholds are multiplied by for sound `number`; onset, high: its peak over them."""
    if n.onset.size == 0:
        return 1.0, 1.0
    draw(n.draws, number, 0)
    one = table_at(n.onset_knots, n.onset, math.log(onset)) * float(n.draws.normal[0])
    return 1.0 + one, 1.0 + table_at(n.high_knots, n.high, math.log(high)) * float(n.draws.normal[1])
