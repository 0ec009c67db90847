"""Neurons, encoder stages and filters of the NEF chip on a die, as numbers from their own transistors.

Each is a closed form of the devices' law, with the deviations that the transistor level has at the same
places; currents are in units of the design's threshold, `LEAK`, voltages in volt:

* neuron: `leak` of mf1 at v_leak; `charge = C (V_th - v_reset) / LEAK`, V_th where mc1 carries mc2's current,
  C of the membrane's node with all others held; `refractory = C_ref (V_dd - V_inv) / I_rfr`; a membrane that
  is drawn down ends at ground, `floor = -v_reset / (V_th - v_reset)`. The rate at a current J is
  `1 / (refractory + charge / (J - leak))`;
* stage: the current of each bit of both banks at a unit's gate voltage, and the mirror's ratio;
* filter: `s = I_in / I_mid` low-passed with `tau (1 + 1 / S)`, and an output of `gain s^power` full scales,
  gain from the pair, I_th and the output;
* line: of a sum Y, `above max(Y - zero, 0)` and `below max(zero - Y, 0)`, in full scales.

Left out, all measured small beside the circuits in `system.papers.checks.nef_chip`: what switches that are
off let through, the feedback of the neuron's threshold, and the time in which a spike resets its membrane.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from chips.model_law import check_capacitors, check_law
from chips.nef import circuit as nef_circuit
from circuits.arrays import F64
from circuits.blocks.nef.encoder import BITS
from circuits.blocks.nef.neuron import LEAK
from circuits.blocks.nef.synapse import LINE_UNITS
from circuits.circuit import Bias, Circuit
from circuits.devices.ekv import of_weak
from circuits.devices.pinch_off import pinch_off
from circuits.lowering.capacitance import capacitance_matrix
from circuits.lowering.on_die import DieDevices, array_of, mirror_of, standing
from circuits.silicon.die import Place
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon

Biases = tuple[Bias, ...]

PLACE: Place = ((nef_circuit.NAME, ()),)
_NEURON_DEVICES = ("mf1", "mc1", "mc2", "mk5", "mk6p", "mk6n")
_STAGE_DEVICES = (*(f"m{bank}{k}" for bank in "dr" for k in range(BITS)), "mm1", "mm2")


class NeuronLaw(NamedTuple):
    """Neurons on a die, float64[n] each.

    leak: current, thresholds; charge: of a spike, thresholds s; refractory: period, s; floor: of the
    membrane, 1.
    """

    leak: F64
    charge: F64
    refractory: F64
    floor: F64

    def rates(self, first: int, current: F64) -> F64:
        """Return the rates of neurons from `first` on, Hz; current: thresholds, float64[..., n]."""
        own = slice(first, first + current.shape[-1])
        above = current - self.leak[own]
        fires = above > 0.0
        period = self.refractory[own] + self.charge[own] / np.where(fires, above, 1.0)
        return np.where(fires, 1.0 / period, 0.0)

    def head(self, count: int) -> NeuronLaw:
        """Return the first `count` neurons."""
        return NeuronLaw(*(a[:count] for a in self))


class Column(NamedTuple):
    """Stages of a column: currents of the bits, thresholds, float64[n, bits], and the mirror's ratio."""

    signal: F64
    reference: F64
    mirror: F64


class Lines(NamedTuple):
    """Lines: where a sum is the reference, and slopes of what they give above and below, float64[n] each."""

    zero: F64
    above: F64
    below: F64


class Filters(NamedTuple):
    """Filters on a die.

    tau: time constant, s; gain: output at the middle, full scales; power: of the output; middle: how far
    v_syn is below the supply at the middle, V; fold: how much farther it is an e-fold of s above it, V.
    Arrays are float64[n].
    """

    tau: F64
    gain: F64
    power: float
    middle: F64
    fold: float


def neurons_on(silicon: Silicon, count: int, biases: Biases) -> NeuronLaw:
    """Return the chip's first `count` neurons on a silicon with these biases."""
    d = _on_chip("neuron", _neurons(count), silicon, biases, _NEURON_DEVICES)
    matrix = _neuron_capacitances()
    buffer = d.saturated("mc2", d.below("v_buf"))
    reset = float(np.ravel(d.gate["v_reset"])[0])
    swing = d.gate_for("mc1", buffer) - reset
    fall = d.v_dd - d.inverter_threshold("mk6")
    return NeuronLaw(
        d.saturated("mf1", d.gate["v_leak"]) / LEAK,
        matrix[0, 0] * swing / LEAK,
        matrix[1, 1] * fall / d.saturated("mk5", d.gate["v_rfr"]),
        -reset / swing,
    )


def neuron_charges(silicon: Silicon, count: int, biases: Biases) -> tuple[float, F64]:
    """Return a membrane's capacitance, F, and what a refractory period takes from C_ref, C, float64[n]."""
    d = _on_chip("neuron", _neurons(count), silicon, biases, _NEURON_DEVICES)
    matrix = _neuron_capacitances()
    return float(matrix[0, 0]), np.asarray(matrix[1, 1] * (d.v_dd - d.inverter_threshold("mk6")))


def filter_capacitance() -> float:
    """Return the capacitance of a filter's v_syn, F."""
    return float(_filter_capacitances()[0, 0])


def column_on(silicon: Silicon, column: int, count: int, biases: Biases) -> Column:
    """Return the first `count` stages of a column on a silicon with these biases."""
    d = _on_chip("stage", _column(count), silicon, biases, _STAGE_DEVICES, (("column", (column,)),))
    gate = d.below("v_pos")
    signal, reference = (
        np.stack([d.saturated(f"m{bank}{k}", gate) for k in range(BITS)], axis=1) / LEAK for bank in "dr"
    )
    return Column(signal, reference, d.mirror("mm1", "mm2").weak)


def filters_on(silicon: Silicon, taus: F64, biases: Biases) -> Filters:
    """Return the chip's first filters on a silicon; taus: nominal time constants at 27 degC, s."""
    count = len(taus)
    gain, tau, middle = np.empty((3, count))
    unit = _unit_current(silicon, biases)
    capacitance = float(_filter_capacitances()[0, 0])
    power = fold = 1.0
    for value in np.unique(taus):
        set_to = tuple(_set_tau(b, float(value)) for b in biases)
        d = _on_chip("filter", _filters(count), silicon, set_to)
        own = taus == value
        found = _filter(d, capacitance, unit)
        tau[own], gain[own], middle[own] = found.tau[own], found.gain[own], found.middle[own]
        power, fold = found.power, found.fold
    return Filters(tau, gain, power, middle, fold)


def lines_on(silicon: Silicon, count: int, biases: Biases) -> Lines:
    """Return the chip's first `count` lines on a silicon with these biases."""
    d = _on_chip("line", _lines(count), silicon, biases)
    scale = LINE_UNITS * _unit_current(silicon, biases)
    laws = _on_chip("line", _lines(count), _without_mismatch(silicon), biases)
    up, down = (mirror_of(d.fet[name], laws.fet["mu1"], d.u_t).weak for name in ("mu1", "mu2"))
    copied = d.mirror("ml1", "ml2").weak
    taken = d.saturated("mr1", d.below("v_ref")) / scale
    return Lines(taken / copied, copied * up, copied * d.mirror("mr2", "mr3").weak * down)


def unit_of(silicon: Silicon, biases: Biases) -> float:
    """Return the current of a stage's unit in a device without a deviation of its own, thresholds."""
    return _unit_current(silicon, biases) / LEAK


def _filter(d: DieDevices, capacitance: float, unit: float) -> Filters:
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
    d = _on_chip("stage", _column(1), _without_mismatch(silicon), biases, ("md0",), (("column", (0,)),))
    return float(d.saturated("md0", d.below("v_pos"))[0])


def _set_tau(bias: Bias, tau: float) -> Bias:
    """I_tau of a time constant, and the I_th that leaves the middle where it is."""
    share = design_tau() / tau
    if bias.name == "i_tau":
        return replace(bias, value=_number(bias.value) * share)
    if bias.name == "i_thr":
        return replace(bias, value=_number(bias.value) * share ** (ROLLS_180.p.kappa / ROLLS_180.n.kappa))
    return bias


@lru_cache(maxsize=1)
def design_tau() -> float:
    """Return the time constant of a filter with the block's own I_tau, nominal at 27 degC, s."""
    d = standing(_filters(1), Silicon(ROLLS_180, place=PLACE), "filter")
    leak = float(d.saturated("filter.md3", d.below("v_tau"))[0])
    return float(_filter_capacitances()[0, 0]) * d.u_t / (ROLLS_180.n.kappa * leak)


def _number(value: float | tuple[float, ...]) -> float:
    return float(np.ravel(value)[0])


def _on_chip(
    array: str, circuit: Circuit, silicon: Silicon, biases: Biases, wanted: Sequence[str] | None = None,
    inside: Place = (),
) -> DieDevices:  # fmt: skip
    """Devices of an array of a part of the chip, with the chip's biases on the ports that it has."""
    check_law(silicon.process)
    check_capacitors(nef_circuit.NAME, silicon.die)
    given = {b.name: b for b in biases}
    own = tuple(
        replace(b, kind=given[b.name].kind, value=given[b.name].value) if b.name in given else b
        for b in circuit.biases
    )
    return standing(replace(circuit, biases=own), replace(silicon, place=(*PLACE, *inside)), array, wanted)


def _without_mismatch(silicon: Silicon) -> Silicon:
    return replace(silicon, die=replace(silicon.die, mismatch=False))


_neurons = lru_cache(maxsize=8)(nef_circuit.neurons)
_column = lru_cache(maxsize=8)(nef_circuit.column)
_filters = lru_cache(maxsize=8)(nef_circuit.filters)
_lines = lru_cache(maxsize=8)(nef_circuit.lines)


@lru_cache(maxsize=1)
def _neuron_capacitances() -> F64:
    return capacitance_matrix(array_of(_neurons(1), "neuron").circuit, ROLLS_180, ["v_mem", "v_ref"])


@lru_cache(maxsize=1)
def _filter_capacitances() -> F64:
    return capacitance_matrix(array_of(_filters(1), "filter").circuit, ROLLS_180, ["v_syn"])
