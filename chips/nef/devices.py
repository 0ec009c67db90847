"""Devices of the NEF chip on a die, with the chip's biases on the lines of each of its parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from chips.nef import circuit as nef_circuit
from chips.nef.whole.stage import ALONE
from circuits.arrays import F64
from circuits.circuit import Bias, Circuit
from circuits.lowering.capacitance import capacitance_matrix
from circuits.lowering.on_die import DieDevices, array_of, standing
from circuits.silicon.die import Place
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

Biases = tuple[Bias, ...]

POWER = ROLLS_180_IDEAL.p.kappa / ROLLS_180_IDEAL.n.kappa  # of a filter's output under the ideal law
TAUS = (0.5e-3, 1e-3, 2e-3, 5e-3, 10e-3, 20e-3, 50e-3, 0.1, 0.2, 0.5)  # s, for which filters have codes; ours
PLACE: Place = ((nef_circuit.NAME, ()),)


neurons = lru_cache(maxsize=8)(nef_circuit.neurons)
column = lru_cache(maxsize=8)(nef_circuit.column)
filters = lru_cache(maxsize=8)(nef_circuit.filters)
lines = lru_cache(maxsize=8)(nef_circuit.lines)


def plain_stage(silicon: Silicon, biases: Biases) -> DieDevices:
    """Return a stage without deviations of its own."""
    return on_chip("stage", column(1), without_mismatch(silicon), biases, ALONE, (("column", (0,)),))


def set_tau(biases: Biases, tau: float) -> Biases:
    """Return biases with the I_tau and the I_mid of a time constant, s; both leave the output where it is.

    They are in proportion to a single current, or between those for the nearest of `TAUS`.
    """
    return tuple(replace(b, value=_set(b, tau)) if b.name in ("i_tau", "i_mid") else b for b in biases)


def _set(bias: Bias, tau: float) -> float:
    if isinstance(bias.value, tuple) and len(bias.value) == len(TAUS):
        return float(np.exp(np.interp(np.log(tau), np.log(TAUS), np.log(bias.value))))
    return _number(bias.value) * design_tau() / tau


@lru_cache(maxsize=1)
def design_tau() -> float:
    """Return the time constant of a filter with the block's own I_tau, nominal at 27 degC, s."""
    d = standing(filters(1), Silicon(ROLLS_180_IDEAL, place=PLACE), "filter")
    leak = float(d.saturated("filter.md3", d.below("v_tau"))[0])
    return float(filter_capacitances()[0, 0]) * d.u_t / (ROLLS_180_IDEAL.n.kappa * leak)


def _number(value: float | tuple[float, ...]) -> float:
    return float(np.ravel(value)[0])


def on_chip(
    array: str, circuit: Circuit, silicon: Silicon, biases: Biases, wanted: Sequence[str] | None = None,
    inside: Place = (),
) -> DieDevices:  # fmt: skip
    """Return devices of an array of a part of the chip, with the chip's biases on the ports that it has."""
    return standing(biased(circuit, biases), replace(silicon, place=(*PLACE, *inside)), array, wanted)


def biased(circuit: Circuit, biases: Biases) -> Circuit:
    """Return a part of the chip with the chip's biases on the ports that it has."""
    given = {b.name: b for b in biases}
    own = tuple(
        replace(b, kind=given[b.name].kind, value=given[b.name].value) if b.name in given else b
        for b in circuit.biases
    )
    return replace(circuit, biases=own)


def without_mismatch(silicon: Silicon) -> Silicon:
    """Return the silicon whose devices have no deviations of their own."""
    return replace(silicon, die=silicon.die.without_mismatch())


def more_capacitance(silicon: Silicon, array: str, circuit: Circuit, name: str) -> F64 | float:
    """Return what the die makes of a capacitor in each part of an array more than was drawn, F, float64[n].

    name: of the capacitor in a part, behind those of the instances in it; 0 where the die's capacitors do not
    deviate.
    """
    part = array_of(circuit, array)
    *inside, own = name.split(".")
    inner = part.circuit
    for step in inside:
        inner = next(i for i in inner.instances if i.name == step).circuit
    drawn = np.full(part.shape, inner.device(own).parameters()["capacitance"])
    path = ((array, part.shape), *((step, ()) for step in inside), (own, ()))
    return drawn * replace(silicon, place=PLACE).change(circuit.name, (path,), "capacitor", drawn).value


@lru_cache(maxsize=1)
def neuron_capacitances() -> F64:
    """Return the capacitances of a neuron's v_mem and v_ref, F, float64[2, 2]."""
    return capacitance_matrix(array_of(neurons(1), "neuron").circuit, ROLLS_180_IDEAL, ["v_mem", "v_ref"])


@lru_cache(maxsize=1)
def filter_capacitances() -> F64:
    """Return the capacitance of a filter's v_syn, F, float64[1, 1]."""
    return capacitance_matrix(array_of(filters(1), "filter").circuit, ROLLS_180_IDEAL, ["v_syn"])
