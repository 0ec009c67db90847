"""Neurons, encoder stages and filters of the NEF chip on a die, as numbers from their own transistors.

Each is a closed form of the devices' law, with the deviations that the transistor level has at the same
places; currents are in units of the design's threshold, `LEAK`, voltages in volt:

* neuron: `leak` of mf1 at v_leak; `charge = C (V_th - v_reset) / LEAK`, V_th where mc1 carries mc2's current,
  C of the membrane's node with all others held; `refractory = C_ref (V_dd - V_inv) / I_rfr`; a membrane that
  is drawn down ends at ground, `floor = -v_reset / (V_th - v_reset)`. The rate at a current J is
  `1 / (refractory + charge / (J - leak))`;
* stage: the current of each bit of both banks at a unit's gate voltage, and the mirror's ratio; under the law
  with second-order effects also what switches that are off let through, and what the mirror draws more;
* filter: `s = I_in / I_mid` low-passed with `tau (1 + 1 / S)`, and an output of `gain s^power` full scales,
  gain from the pair, I_th and the output;
* line: of a sum Y, `above max(Y - zero, 0)` and `below max(zero - Y, 0)`, in full scales.

Left out, all measured small beside the circuits in `system.papers.checks.nef_chip`: the feedback of the
neuron's threshold, and the time in which a spike resets its membrane.

Under the law with second-order effects each part is solved where its devices stand (`chips.nef.whole`); a
filter and a line are then curves, and a membrane leaks.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from chips.nef import devices
from chips.nef.devices import (
    Biases,
    filter_capacitances,
    more_capacitance,
    neuron_capacitances,
    on_chip,
    plain_stage,
    set_tau,
    without_mismatch,
)
from chips.nef.whole.filter import LOG_S, Curves, curves_of
from chips.nef.whole.line import APART, HALF, line_numbers
from chips.nef.whole.neuron import neuron_numbers
from chips.nef.whole.rate import Law, fill_rates
from chips.nef.whole.stage import bank, drains, mirror, mirror_line, shut, unit_current, units
from circuits.arrays import F64, I64
from circuits.blocks.nef.encoder import BITS, MEMBRANE
from circuits.blocks.nef.neuron import LEAK
from circuits.blocks.nef.synapse import LINE_UNITS
from circuits.devices.ekv import of_weak
from circuits.devices.pinch_off import pinch_off
from circuits.lowering.on_die import DieDevices, mirror_of
from circuits.silicon.silicon import Silicon

LEAST = 1e-12  # of s, from which its logarithm is taken; ours
NEAR = 1.1  # of s, by which the output's power at the middle is taken; ours
SPAN = 0.4  # of s about its middle, over which a filter's output is compared with another's; ours
NUDGE = 1e-3  # V, of a gate, for a slope; ours
BIAS_COLUMN = 0
_NEURON_DEVICES = ("mf1", "mc1", "mc2", "mk5", "mk6p", "mk6n")
_WHOLE_NEURON_DEVICES = (*_NEURON_DEVICES, "mc4", "mk4", "mk8")
_STAGE_DEVICES = (*(f"m{bank}{k}" for bank in "dr" for k in range(BITS)), "mm1", "mm2")
_SWITCHES = tuple(f"ms{bank}{k}" for bank in "dr" for k in range(BITS))


class NeuronLaw(NamedTuple):
    """Neurons on a die, float64[n] each.

    leak: current, thresholds; charge: of a spike, thresholds s; refractory: period, s; floor: of the
    membrane, 1; rise: of the leak from reset to threshold, thresholds, 0 without Early effect; mirrored: the
    same of a mirrored current, a share of it.
    """

    leak: F64
    charge: F64
    refractory: F64
    floor: F64
    rise: F64
    mirrored: float

    def rates(self, first: int, current: F64, sunk: F64 | float = 0.0) -> F64:
        """Return the rates of neurons from `first` on, Hz.

        current: thresholds, float64[..., n]; sunk: how much of it, in magnitude, mirrors draw.
        """
        own, n = slice(first, first + current.shape[-1]), current.shape[-1]
        given, drawn = (
            np.ascontiguousarray(np.broadcast_to(x, current.shape).reshape(-1, n), dtype=np.float64)
            for x in (current, sunk)
        )
        found = np.empty(given.shape)
        fill_rates(self.own(own), given, drawn, found)
        return found.reshape(current.shape)

    def spare(self, first: int, current: F64, sunk: F64 | float = 0.0) -> F64:
        """Return how far currents are above the least that fires a neuron, thresholds, as `rates`."""
        own = slice(first, first + current.shape[-1])
        return current - self.leak[own] - 0.5 * (self.rise[own] + self.mirrored * sunk)

    def own(self, which: slice) -> Law:
        """Return what the rates of some neurons follow, in a form for kernels."""
        leak, charge, refractory, rise = (
            np.ascontiguousarray(x[which]) for x in (self.leak, self.charge, self.refractory, self.rise)
        )
        return Law(leak, charge, refractory, rise, self.mirrored)

    def head(self, count: int) -> NeuronLaw:
        """Return the first `count` neurons."""
        return self.each(lambda a: a[:count])

    def each(self, made: Callable[[F64], F64]) -> NeuronLaw:
        """Return neurons whose arrays are what `made` makes of these."""
        leak, charge, refractory, floor, rise = (made(a) for a in self[:5])
        return NeuronLaw(leak, charge, refractory, floor, rise, self.mirrored)


class Column(NamedTuple):
    """Stages of a column: currents of the bits, thresholds, float64[n, bits], and the mirror's ratio.

    off: of a bank's current, what is left of it with its gate at the supply, 0 without leakage in the model;
    shut: what switches of both banks let through that are off, thresholds, float64[2, n, bits]; lost: what
    the mirror draws more, thresholds, float64[n]. Both are None without leakage.
    """

    signal: F64
    reference: F64
    mirror: F64
    off: float = 0.0
    shut: F64 | None = None
    lost: F64 | None = None

    def banks(self, own: slice, codes: I64) -> tuple[F64, F64, F64]:
        """Return what codes of stages draw in both banks, thresholds, and their mirrors, float64[n] each."""
        on = _on(codes)
        signal = np.where(on, self.signal[own], 0.0).sum(axis=1)
        reference = np.where(on, self.reference[own], 0.0).sum(axis=1)
        return signal, reference, self.mirror[own]

    def still(self, own: slice, codes: I64, shares: tuple[float, float]) -> tuple[F64, F64]:
        """Return what codes give where both gates stand still, and what of it the mirrors draw, thresholds.

        Both are float64[n]; shares: of full scale that a unit of either bank carries.
        """
        on, mirror = _on(codes), self.mirror[own]
        signal, reference = (
            self._through(bank, on, share * bits[own], own)
            for bank, (bits, share) in enumerate(zip(self[:2], shares, strict=True))
        )
        direct, turned = (np.where(codes >= 0, *x) for x in ((signal, reference), (reference, signal)))
        sunk = mirror * turned + (0.0 if self.lost is None else self.lost[own])
        return direct - sunk, sunk

    def _through(self, bank: int, on: I64, units: F64, own: slice) -> F64:
        """What bits let through, of which those that are not on have units and a switch in series."""
        if self.shut is None:
            return np.asarray(np.where(on, units, 0.0).sum(axis=1))
        switch = self.shut[bank, own]
        return np.asarray(np.where(on, units, switch * units / (switch + units)).sum(axis=1))

    def bias(self, own: slice, codes: I64) -> tuple[F64, F64]:
        """Return what `still` does where the other bank's gate is at the supply."""
        return self.still(own, codes, (1.0, self.off))


def _on(codes: I64) -> I64:
    """Bits of the magnitudes of codes, [n, bits]."""
    return (np.abs(codes)[:, None] >> np.arange(BITS)) & 1


class Lines(NamedTuple):
    """Lines: where a sum is the reference, and slopes of what they give above and below, float64[n] each.

    shape: of what they give, over `chips.nef.whole.line.APART`, None where it is straight; rest: what either
    half lets through always, full scales.
    """

    zero: F64
    above: F64
    below: F64
    shape: F64 | None = None
    rest: float = 0.0

    def given(self, line: I64 | int, total: F64) -> tuple[F64, F64]:
        """Return what lines give above and below at a sum, full scales; both broadcast."""
        apart = total - self.zero[line]
        if self.shape is not None:
            apart = np.interp(apart, APART, self.shape)
        return self.above[line] * np.maximum(apart, 0.0), self.below[line] * np.maximum(-apart, 0.0)


class Filters(NamedTuple):
    """Filters on a die.

    tau: time constant, s; gain: output at the middle, full scales; power: of the output; middle: how far
    v_syn is below the supply at the middle, V; fold: how much farther it is an e-fold of s above it, V.
    Arrays are float64[n]. Under the law with second-order effects power is that at the middle, there is no
    fold, and curves have the output in full scales.
    """

    tau: F64
    gain: F64
    power: float
    middle: F64
    fold: float
    curves: Curves | None = None

    def slopes(self) -> F64:
        """Return by what share each filter's s follows v_syn at the middle, 1/V, float64[n]."""
        if self.curves is not None:
            near, one = np.full(len(self.tau), NEAR), np.ones(len(self.tau))
            moved = self.curves.at(self.curves.volts, near) - self.curves.at(self.curves.volts, one)
            return np.asarray(np.log(NEAR) / moved)
        return np.full(len(self.tau), 1.0 / self.fold)

    def outputs(self, s: F64) -> F64:
        """Return what the first filter gives at s, full scales, in its shape."""
        if self.curves is not None:
            return np.asarray(np.exp(np.interp(np.log(np.maximum(s, LEAST)), LOG_S, self.curves.output[0])))
        return np.asarray(self.gain[0] * s**self.power)

    def scale_for(self, output: F64) -> F64:
        """Return the s at which each filter gives an output, full scales, float64[n]."""
        if self.curves is not None:
            return self.curves.inverse(self.curves.output, np.log(output))
        return np.asarray((output / self.gain) ** (1.0 / self.power))

    def swing(self, s: F64) -> F64:
        """Return how far each filter's output goes about its s, full scales, float64[n]; there are curves."""
        if self.curves is None:
            raise TypeError("filters without curves")
        more, less = (self.curves.at(self.curves.output, x * s) for x in (1.0 + SPAN, 1.0 - SPAN))
        return np.asarray(np.exp(more) - np.exp(less))

    def repeated(self, count: int) -> Filters:
        """Return so many filters like the first."""
        first = np.zeros(count, dtype=np.int64)
        curves = None if self.curves is None else self.curves.taken(first)
        return Filters(self.tau[first], self.gain[first], self.power, self.middle[first], self.fold, curves)

    def volts(self, s: F64) -> F64:
        """Return how far v_syn is below the supply at each filter's s, V, float64[n]."""
        if self.curves is not None:
            return self.curves.at(self.curves.volts, s)
        return np.asarray(self.middle + self.fold * np.log(np.maximum(s, LEAST)))

    def of_volts(self, volts: F64) -> F64:
        """Return each filter's s, where v_syn is so far below the supply, V, float64[n]."""
        if self.curves is not None:
            return self.curves.inverse(self.curves.volts, volts)
        return np.asarray(np.exp((volts - self.middle) / self.fold))


def neurons_on(silicon: Silicon, count: int, biases: Biases) -> NeuronLaw:
    """Return the chip's first `count` neurons on a silicon with these biases."""
    if silicon.process.effects == "full":
        return _whole_neurons(silicon, count, biases)
    d = on_chip("neuron", devices.neurons(count), silicon, biases, _NEURON_DEVICES)
    membrane, timer = _own_capacitances(silicon, count)
    buffer = d.saturated("mc2", d.below("v_buf"))
    reset = float(np.ravel(d.gate["v_reset"])[0])
    swing = d.gate_for("mc1", buffer) - reset
    fall = d.v_dd - d.inverter_threshold("mk6")
    return NeuronLaw(
        d.saturated("mf1", d.gate["v_leak"]) / LEAK,
        membrane * swing / LEAK,
        timer * fall / d.saturated("mk5", d.gate["v_rfr"]),
        -reset / swing,
        np.zeros_like(swing),
        0.0,
    )


def _whole_neurons(silicon: Silicon, count: int, biases: Biases) -> NeuronLaw:
    """The same under the law with second-order effects."""
    d = on_chip("neuron", devices.neurons(count), silicon, biases, _WHOLE_NEURON_DEVICES)
    (membrane, timer), found = _own_capacitances(silicon, count), neuron_numbers(d)
    reset = float(np.ravel(d.gate["v_reset"])[0])
    ends = [reset, reset + float(np.median(found.swing))]
    stage, unit = plain_stage(silicon, biases), _unit_current(silicon, biases)
    low, middle, high = (float(mirror(stage, unit, v)[0]) for v in (ends[0], float(np.mean(ends)), ends[1]))
    return NeuronLaw(
        found.leak / LEAK,
        membrane * found.swing / LEAK,
        timer * found.refractory,
        -reset / found.swing,
        found.rise / LEAK,
        (high - low) / middle,
    )


def _own_capacitances(silicon: Silicon, count: int) -> tuple[F64 | float, F64 | float]:
    """Capacitances of v_mem and v_ref of neurons, F, float64[n] where the die's capacitors deviate."""
    matrix, circuit = neuron_capacitances(), devices.neurons(count)
    more = (more_capacitance(silicon, "neuron", circuit, name) for name in ("c_mem", "c_ref"))
    membrane, timer = (own + extra for own, extra in zip(np.diag(matrix), more, strict=True))
    return membrane, timer


def neuron_charges(silicon: Silicon, count: int, biases: Biases) -> tuple[float, F64]:
    """Return a membrane's capacitance, F, and what a refractory period takes from C_ref, C, float64[n]."""
    d = on_chip("neuron", devices.neurons(count), silicon, biases, _NEURON_DEVICES)
    membrane, timer = _own_capacitances(silicon, count)
    return float(np.mean(membrane)), np.asarray(timer * (d.v_dd - d.inverter_threshold("mk6")))


def flicker_slopes(silicon: Silicon, biases: Biases) -> F64:
    """Return by what share the currents of mf1 and of mk5 follow their gates, 1/V, float64[2]."""
    if silicon.process.effects == "ideal":
        return np.full(2, silicon.law("n").kappa / silicon.thermal_voltage)
    d = on_chip("neuron", devices.neurons(1), without_mismatch(silicon), biases, ("mf1", "mk5"))
    found = [
        np.log(d.saturated(name, d.gate[port] + NUDGE) / d.saturated(name, d.gate[port] - NUDGE))
        for name, port in (("mf1", "v_leak"), ("mk5", "v_rfr"))
    ]
    return np.ravel(found) / (2.0 * NUDGE)


def bias_slope(silicon: Silicon, biases: Biases) -> float:
    """Return by what share a stage's unit follows its gate, 1/V."""
    law = silicon.law("p")
    if silicon.process.effects == "ideal":
        return law.kappa / silicon.thermal_voltage
    d = plain_stage(silicon, biases)
    low, high = (np.ravel(d.saturated("md0", d.below("v_pos") + x)) for x in (-NUDGE, NUDGE))
    return float(np.log(high / low)[0] / (2.0 * NUDGE))


def filter_capacitance() -> float:
    """Return the capacitance of a filter's v_syn, F."""
    return float(filter_capacitances()[0, 0])


def column_on(silicon: Silicon, column: int, count: int, biases: Biases) -> Column:
    """Return the first `count` stages of a column on a silicon with these biases."""
    wanted = (*_STAGE_DEVICES, *_SWITCHES) if silicon.process.effects == "full" else _STAGE_DEVICES
    d = on_chip("stage", devices.column(count), silicon, biases, wanted, (("column", (column,)),))
    gate = d.below("v_pos")
    if d.full:
        unit, stage = _unit_current(silicon, biases), plain_stage(silicon, biases)
        # a signal's gate is not the bias's: its bits are at that at which a unit is defined
        gate = gate if column == BIAS_COLUMN else stage.below("v_pos")
        there = drains(stage, unit * np.exp2(np.arange(BITS, dtype=np.float64)), MEMBRANE)
        signal, reference = (bank(d, letter, gate, there) / LEAK for letter in "dr")
        off = float(unit_current(stage, np.zeros(1), MEMBRANE)[0])
        let = np.stack([shut(d, letter, stage, unit, MEMBRANE) for letter in "dr"])
        ratio, lost = mirror_line(d, unit, MEMBRANE)
        return Column(signal, reference, ratio, off / unit, let / LEAK, lost / LEAK)
    signal, reference = (
        np.stack([d.saturated(f"m{bank}{k}", gate) for k in range(BITS)], axis=1) / LEAK for bank in "dr"
    )
    return Column(signal, reference, d.mirror("mm1", "mm2").weak)


def filters_on(silicon: Silicon, taus: F64, biases: Biases) -> Filters:
    """Return the chip's first filters on a silicon; taus: nominal time constants at 27 degC, s."""
    count = len(taus)
    gain, tau, middle = np.empty((3, count))
    unit = _unit_current(silicon, biases)
    if not count:
        none = np.empty((0, LOG_S.size))
        curves = None if silicon.process.effects == "ideal" else Curves(none, none, none)
        return Filters(tau, gain, 1.0, middle, 1.0, curves)
    circuit = devices.filters(count)
    capacitance = filter_capacitance() + more_capacitance(silicon, "filter", circuit, "filter.c_syn")
    if silicon.process.effects == "full":
        return _whole_filters(silicon, taus, biases, LINE_UNITS * unit, np.broadcast_to(capacitance, count))
    power = fold = 1.0
    for value in np.unique(taus):
        set_to = set_tau(biases, float(value))
        d = on_chip("filter", devices.filters(count), silicon, set_to)
        own = taus == value
        found = _filter(d, capacitance, unit)
        tau[own], gain[own], middle[own] = found.tau[own], found.gain[own], found.middle[own]
        power, fold = found.power, found.fold
    return Filters(tau, gain, power, middle, fold)


def _whole_filters(silicon: Silicon, taus: F64, biases: Biases, scale: float, capacitance: F64) -> Filters:
    """The same under the law with second-order effects; scale: full, A; capacitance: F, float64[n]."""
    diode = on_chip("line", devices.lines(1), without_mismatch(silicon), biases, ("ml1",)).fet["ml1"]
    shape = (len(taus), LOG_S.size)
    curves = Curves(np.empty(shape), np.empty(shape), np.empty(shape))
    for value in np.unique(taus):
        own = np.flatnonzero(taus == value)
        set_to = set_tau(biases, float(value))
        d = on_chip("filter", devices.filters(len(taus)), silicon, set_to).taken(own)
        for whole, part in zip(curves, curves_of(d, capacitance[own], diode), strict=True):
            whole[own] = part
    curves.output[:] -= np.log(scale)
    one = np.ones(len(taus))
    output, volts = curves.at(curves.output, one), curves.at(curves.volts, one)
    power = float(np.mean(curves.at(curves.output, NEAR * one) - output) / np.log(NEAR))
    return Filters(curves.at(curves.tau, one), np.exp(output), power, volts, np.nan, curves)


def middle_over_leak(silicon: Silicon, tau: float, biases: Biases) -> float:
    """Return the middle of a filter without deviations over its leak; tau: its time constant, s."""
    d = on_chip("filter", devices.filters(1), without_mismatch(silicon), set_tau(biases, tau))
    leak = d.saturated("filter.md3", d.below("v_tau"))
    return float((d.saturated("mv1", d.gate["v_mid"]) / leak)[0])


def lines_on(silicon: Silicon, count: int, biases: Biases) -> Lines:
    """Return the chip's first `count` lines on a silicon with these biases."""
    d = on_chip("line", devices.lines(count), silicon, biases)
    scale = LINE_UNITS * _unit_current(silicon, biases)
    if d.full:
        return _whole_lines(d, on_chip("line", devices.lines(1), without_mismatch(silicon), biases),
                            units(plain_stage(silicon, biases), MEMBRANE), scale)  # fmt: skip
    laws = on_chip("line", devices.lines(count), without_mismatch(silicon), biases)
    up, down = (mirror_of(d.fet[name], laws.fet["mu1"], d.u_t).weak for name in ("mu1", "mu2"))
    copied = d.mirror("ml1", "ml2").weak
    taken = d.saturated("mr1", d.below("v_ref")) / scale
    return Lines(taken / copied, copied * up, copied * d.mirror("mr2", "mr3").weak * down)


def _whole_lines(d: DieDevices, plain: DieDevices, unit: Callable[[F64], F64], scale: float) -> Lines:
    """Lines under the law with second-order effects.

    plain: without deviations; unit: as of `units`; scale: full scale, A.
    """
    ends = np.array([HALF, -HALF])
    found, like = line_numbers(d, unit, scale, ends), line_numbers(plain, unit, scale, np.append(APART, ends))
    slopes = like.given[0, -2:] / ends
    shape = like.given[0, :-2] / np.where(APART < 0.0, slopes[1], slopes[0])
    own = found.given / ends * LINE_UNITS / scale
    rest = float(like.rest[0]) * LINE_UNITS / scale
    return Lines(found.zero / scale, own[:, 0], own[:, 1], shape, rest)


def unit_of(silicon: Silicon, biases: Biases) -> float:
    """Return the current of a stage's unit in a device without a deviation of its own, thresholds."""
    return _unit_current(silicon, biases) / LEAK


def _filter(d: DieDevices, capacitance: F64 | float, unit: float) -> Filters:
    """Filters with devices `d`; unit: A, of a stage without mismatch."""
    md1, md2, md5 = (d.fet[f"filter.{name}"] for name in ("md1", "md2", "md5"))
    middle = d.saturated("mv1", d.gate["v_mid"])
    leak = d.saturated("filter.md3", d.below("v_tau"))
    ratio = middle / leak - 1.0  # S at the middle
    power = md5.kappa / md1.kappa
    # v_p of md5 whose gate is off v_thr by what md1's threshold differs from md2's
    gate = d.below("v_thr") - md5.threshold + md1.threshold
    across = pinch_off(md5.kappa, gate, md2.threshold) / d.u_t
    weak = np.exp(across) * (ratio * md2.current / md1.current) ** power
    out = md5.current * of_weak(weak)
    tau = capacitance * d.u_t / (md1.kappa * leak) * (1.0 + 1.0 / ratio)
    volts = md5.threshold + d.u_t * np.log(weak) / md5.kappa
    scaled = np.asarray(out / (LINE_UNITS * unit))
    return Filters(np.asarray(tau), scaled, power, np.asarray(volts), d.u_t * power / md5.kappa)


def _unit_current(silicon: Silicon, biases: Biases) -> float:
    d = plain_stage(silicon, biases)
    if d.full:
        return float(unit_current(d, np.reshape(d.below("v_pos"), 1), MEMBRANE)[0])
    return float(d.saturated("md0", d.below("v_pos"))[0])
