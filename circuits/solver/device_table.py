"""Table of an operating point by device, as designers of circuits read it.

With the law's own currents and slopes (`circuits.devices.transistor`; nothing is differenced here), forward
meaning the end of the channel that acts as the source, so that the table reads the same when drain and source
change places:

    IC = I_F / I_S = ln^2(1 + e^(u_f / 2))      I_S of the device, its deviation on the die included
    g_m = |dI/dv_g|,  g_ds = |dI/dv_end| of the end that acts as the drain
    V_DSsat = U_T (2 sqrt(IC + 1/4) + 3),  headroom = |V_DS| - V_DSsat

In saturation, without Early effect, IC is I_D / I_S. V_DSsat is the usual design rule for EKV: 4 U_T in weak
inversion, where the reverse current is e^-4 (1.8 %) of the forward one, and 2 U_T sqrt(IC) in strong; to draw
the line there is a convention, no law. Weak inversion is IC < 0.1, strong is IC > 10, as usual. A transistor
is off where V_GS is below U_T: it carries less than e times its off current (ours).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, Bools
from circuits.devices import Resistor, Transistor
from circuits.devices.transistor import TransistorWork, drain_currents, transistor_work
from circuits.lowering.made import made
from circuits.solver.operating_point import OperatingPoint

WEAK, STRONG = 0.1, 10.0  # inversion coefficients that bound moderate inversion


@dataclass(frozen=True, slots=True)
class TransistorTable:
    """Transistors of an operating point, an element of every column a device; arrays element by element.

    Attributes
    ----------
    name : tuple of str
        Instance paths, as `neuron[2].membrane.m1`.
    polarity : tuple of str
        `n` or `p`.
    drain_current : float64[n]
        Channel current into the drain, A; negative for a conducting pFET, as in SPICE.
    inversion_coefficient : float64[n]
        Inversion coefficient, dimensionless.
    transconductance : float64[n]
        g_m, S.
    efficiency : float64[n]
        g_m / |I_D|, 1/V; nan without a current.
    output_conductance : float64[n]
        g_ds, S.
    drain_source : float64[n]
        |V_DS|, V.
    saturation : float64[n]
        V_DSsat, V.
    leakage : float64[2, n]
        Junction currents into drain and source, out of the bulk, A.
    inversion : tuple of str
        `off`, `weak`, `moderate` or `strong`.
    region : tuple of str
        `linear` or `saturated`: headroom below 0, or not.
    """

    name: tuple[str, ...]
    polarity: tuple[str, ...]
    drain_current: F64
    inversion_coefficient: F64
    transconductance: F64
    efficiency: F64
    output_conductance: F64
    drain_source: F64
    saturation: F64
    leakage: F64
    inversion: tuple[str, ...]
    region: tuple[str, ...]

    @property
    def headroom(self) -> F64:
        """By how much |V_DS| is above V_DSsat, V, float64[n]; below zero in the linear region."""
        return self.drain_source - self.saturation


class ResistorTable(NamedTuple):
    """Resistors of an operating point; `current`: float64[n], A, from `a` to `b`."""

    name: tuple[str, ...]
    current: F64


def transistor_table_at(point: OperatingPoint) -> TransistorTable:
    """Make the table of every transistor at an operating point, in the order of the circuit.

    point: the operating point.
    """
    a, v = point.machine.kernel.transistors, point.voltage
    n = a.sign.size
    w = transistor_work(n)
    drain_currents(a, v, w)
    drain, gate, source, _ = (a.sign * v[t] for t in a.terminal)
    swapped = drain < source
    coefficient = np.where(swapped, w.value[n:], w.value[:n]) ** 2
    u_t = 0.5 / a.inverse_2ut
    saturation = u_t * (2.0 * np.sqrt(coefficient + 0.25) + 3.0)
    headroom = np.abs(drain - source) - saturation
    off, weak, strong = gate - np.minimum(drain, source) < u_t, coefficient < WEAK, coefficient > STRONG
    transconductance = np.abs(w.conductance[1])
    return TransistorTable(
        name=tuple(point.machine.flat.labels(Transistor)),
        polarity=tuple("n" if s > 0.0 else "p" for s in a.sign),
        drain_current=w.current,
        inversion_coefficient=coefficient,
        transconductance=transconductance,
        efficiency=_ratio(transconductance, np.abs(w.current)),
        output_conductance=_output_conductance(w, swapped),
        drain_source=np.abs(drain - source),
        saturation=saturation,
        leakage=w.junction,
        inversion=tuple(np.select([off, weak, strong], ["off", "weak", "strong"], "moderate").tolist()),
        region=tuple(np.where(headroom < 0.0, "linear", "saturated").tolist()),
    )


def resistor_table_at(point: OperatingPoint) -> ResistorTable:
    """Table of every resistor at an operating point, in the order of the circuit."""
    flat, silicon = point.machine.flat, point.machine.silicon
    groups = [g for g in flat.groups if isinstance(g.device, Resistor)]
    voltage = point.voltage[point.machine.column]
    values = [made(g, flat.circuit.name, silicon) for g in groups]
    drops = [(voltage[g.nodes[0]] - voltage[g.nodes[1]]) / r for g, r in zip(groups, values, strict=True)]
    return ResistorTable(tuple(flat.labels(Resistor)), np.concatenate([np.zeros(0), *drops]))


def _output_conductance(w: TransistorWork, swapped: Bools) -> F64:
    """dI/dv of the end that acts as the drain, I the current into that end; S."""
    return np.asarray(np.where(swapped, -w.conductance[2], w.conductance[0]))


def _ratio(above: F64, below: F64) -> F64:
    """Quotient of two columns, nan where both vanish or the lower does."""
    return np.divide(above, below, out=np.full_like(above, np.nan), where=below > 0.0)
