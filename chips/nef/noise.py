"""Noise of a network on the NEF chip from that of its devices: one die does not run alike twice.

* neuron: shot noise of its leak and of the currents of its stages, each once, and three times where a stage's
  mirror turns it round; the jitter of the refractory period, `sqrt(q t_ref / I_rfr)`, and k T C of the reset;
* filter: shot noise of I_tau and of what the pair passes, `q kappa_n / (C U_T)` of the output's logarithm
  squared, which forgets with the filter's time constant;
* flicker of leak and refractory current, of relative density `(kappa / U_T)^2 K_F / (W L Cox f)`.

Under the law with second-order effects kappa / U_T is how a device follows its gate where it stands.

The generator's lines of leak, refractory current and biases wander (`chips.lines.steps`), and all neurons
with them. Left out: the comparator (0.5 us at 40 V/s), lines and drivers of signals (a tenth of the filter's
density), flicker of stages and filters (0.02 to 0.03 %), the lines of filters; decoders and curves are those
of a chip without noise.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chips.lines.steps import LineSteps, copied_steps, drawn_steps, line_steps
from chips.lines.wander import apart, wander_of
from chips.nef import devices
from chips.nef.chip import Conditions
from chips.nef.circuit import NAME
from chips.nef.kernel import ChipNet
from chips.nef.model import BIAS_COLUMN, bias_slope, filter_capacitance, flicker_slopes, neuron_charges
from chips.nef.network.kernel import DT
from chips.nef.noise_kernel import NefNoise
from chips.noise import SiliconNoise, die_name
from chips.noise_draw import Slow, copied_slow, new_draws, new_slow
from circuits.arrays import F64
from circuits.blocks.nef.neuron import LEAK, build
from circuits.devices.noise import gate_flicker
from circuits.lowering.on_die import transistor_of
from circuits.silicon.process import ELEMENTARY_CHARGE

USUAL = 5e-3  # s, time constant of a filter whose slope stands for all
MIRRORED = 3.0  # noise currents of a current that passes a mirror, each like its own


def noise_of(chip: ChipNet, where: Conditions) -> NefNoise | None:
    """Return the noise of a network on a chip as it is `where`, from its first step on, None without any."""
    noise = where.chip.noise
    if noise is None:
        return None
    silicon, neurons = where.silicon, chip.leak.size
    capacitance, emptied = neuron_charges(silicon, neurons, where.biases)
    grain = ELEMENTARY_CHARGE / LEAK
    keep = chip.net.keep
    filters = ELEMENTARY_CHARGE * _following(where) / filter_capacitance()
    analog = (chip.step > 0.0) & (keep > 0.0)
    name = die_name(NAME, silicon.die)
    return NefNoise(
        _shots(chip.net.encoder),
        _shots(chip.below),
        _shots(chip.net.bias),
        grain,
        ELEMENTARY_CHARGE * chip.refractory**2 / emptied,
        capacitance * grain * silicon.thermal_voltage / LEAK,
        # what a step adds fades with the filter before it is read
        np.sqrt(np.where(analog, filters * (1.0 / np.where(analog, keep, 1.0) ** 2 - 1.0), 0.0)),
        np.zeros(neurons),
        np.zeros(neurons),
        _slow(noise, where, neurons),
        new_draws(noise.seed, noise.trial, f"{name}, neurons", neurons),
        new_draws(noise.seed, noise.trial, f"{name}, filters", keep.size),
        np.zeros(1, np.int64),
        _lines(noise, where, name),
    )


def redrawn(noise: NefNoise, where: Conditions, by: SiliconNoise) -> NefNoise:
    """Return the same noise with the draws of another seed and trial, from its first step on.

    noise: of `noise_of`; where: the chip, as there; by: what differs from its noise by seed and trial alone.
    """
    name = die_name(NAME, where.silicon.die)
    return copied(noise)._replace(
        neurons=new_draws(by.seed, by.trial, f"{name}, neurons", noise.dead.size),
        filters=new_draws(by.seed, by.trial, f"{name}, filters", noise.lanes.size),
        lines=drawn_steps(noise.lines, by, name),
    )


def copied(noise: NefNoise) -> NefNoise:
    """Return the same noise from its first step on, with working space of its own."""
    draws = [d._replace(**{n: getattr(d, n).copy() for n in ("counters", "words", "normal")})
             for d in (noise.neurons, noise.filters)]  # fmt: skip
    return noise._replace(
        slow=copied_slow(noise.slow), neurons=draws[0], filters=draws[1], total=noise.total.copy(),
        late=noise.late.copy(),
        step=np.zeros(1, np.int64), lines=copied_steps(noise.lines),
    )  # fmt: skip


def _shots(current: F64) -> F64:
    """Currents as often as their noise is that of an electron's; what is below 0 has passed a mirror."""
    return np.where(current >= 0.0, current, -MIRRORED * current)


def _following(where: Conditions) -> float:
    """By what share a filter's state follows its voltage, 1/V."""
    if where.full:
        return float(where.filters(np.array([USUAL])).slopes()[0])
    return where.silicon.law("n").kappa / where.silicon.thermal_voltage


def _slow(noise: SiliconNoise, where: Conditions, neurons: int) -> Slow:
    """Flicker of mf1 and of mk5."""
    neuron = build()
    model = noise.flicker_in(where.silicon.process)
    area = np.array([transistor_of(neuron, name).gate_area for name in ("mf1", "mk5")]) * where.chip.area
    gates = gate_flicker(model, where.silicon.process, np.ones(2, np.bool_), area)
    return new_slow(flicker_slopes(where.silicon, where.biases) ** 2 * gates, model, DT, neurons)


def _lines(noise: SiliconNoise, where: Conditions, name: str) -> LineSteps:
    """Lines by `LINE_LEAK`, `LINE_REFRACTORY` and `LINE_BIAS`; a column has a generator of its own."""
    silicon, wanders = where.silicon, []
    for circuit, names, inside in (
        (devices.neurons(1), ("i_leak", "i_rfr"), ()),
        (devices.column(1), ("i_pos",), (("column", (BIAS_COLUMN,)),)),
    ):
        there = replace(silicon, place=(*devices.PLACE, *inside))
        wanders.append(wander_of(devices.biased(circuit, where.biases), names, there, noise))
    slope = np.append(flicker_slopes(silicon, where.biases), bias_slope(silicon, where.biases))
    return line_steps(apart(wanders), slope, silicon, noise, name, DT)
