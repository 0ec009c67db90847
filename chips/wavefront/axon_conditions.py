"""The axons of a wavefront chip on one die at one temperature, and their record at the die's currents.

Coordinates are the die's currents of the sink and of the comparator's tail, by the law, from the gate
voltages of their biases: fixed ones, or those of the ideal biases' copies on the die. They are those of a
drain that is far, without the Early effect, which depends on the ramp and is in the record's charge. What
does not depend on the die is made ready once a temperature (`axon_tables`), so that a thousand dies cost a
thousand times little.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from chips.measured.interpolation import lagrange_weights
from chips.record import Record
from chips.validity import require_inside
from chips.wavefront.axon_record import (
    COMPARATOR_CURRENT,
    CURRENT,
    LOCAL_SHIFT,
    PARAMETER,
    SHARED_SHIFT,
    TEMPERATURE,
)
from circuits.arrays import F64
from circuits.bias import bias_voltages
from circuits.blocks.wavefront.axon_delay import BITS, HIGHEST, parasitic_capacitance
from circuits.catalogue import later
from circuits.circuit import Circuit
from circuits.compiled import compiled
from circuits.devices.channel import Terms, channel, terms_of
from circuits.devices.ekv import interpolation, steepness
from circuits.devices.ekv import law as ekv_law
from circuits.devices.pinch_off import pinch_off
from circuits.lowering.capacitors_on_die import capacitor_of
from circuits.lowering.on_die import transistor_of
from circuits.silicon.die import Shift, shared
from circuits.silicon.process import POLARITIES, Polarity, Process, TransistorAtTemperature
from circuits.silicon.silicon import Silicon

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

interpolate = later("scipy.interpolate")  # slow to import

Shifts = Mapping[Polarity, Shift]

LOCAL = ("mc1", "mc2", "mc3", "mc4")  # devices beside the sink whose thresholds count, pair by pair
SINK, TAIL = "ms", "mc0"
CURRENTS = ("i_delay", "i_cmp")  # biases of SINK and TAIL
CAPACITORS = (*(f"c{k}" for k in range(BITS)), "c_o")  # of the bits, then of the fixed charge
_FAR = 1e3  # V, of a drain: nothing comes back from it


@dataclass(frozen=True, slots=True)
class AxonModel:
    """Axons of one chip, or a lone one, with their record.

    circuit: what the axons stand in, by its name and biases; prefix: path of the axons in it, () or (axon,);
    shape: of their array, () for a lone axon; area: of the drawn devices over the circuit's own, at the same
    nominal delay; axon: the circuit of each.
    """

    circuit: Circuit
    process: Process
    record: Record
    prefix: tuple[str, ...]
    shape: tuple[int, ...]
    area: float
    axon: Circuit = field(repr=False)


@dataclass(frozen=True, slots=True)
class AxonTables:
    """A model at a temperature, without a die.

    gates: of the biases where they are the same on every die, V, else None; law: of nFETs; log_charge:
    float64[currents, comparator currents, 31]; gain, offset: float64[currents, parameters]; over_current,
    over_comparator: splines through the unit vectors of these grids, over the logarithm.
    """

    model: AxonModel
    silicon: Silicon
    gates: Mapping[str, float] | None
    law: TransistorAtTemperature
    log_charge: F64 = field(repr=False)
    gain: F64 = field(repr=False)
    offset: F64 = field(repr=False)
    over_current: CubicSpline = field(repr=False)
    over_comparator: CubicSpline = field(repr=False)


class Conditions(NamedTuple):
    """What the axons of a die share at a temperature.

    specific_current: of the sink without deviation, A; pinch, slope: kappa (v_delay - V_T0) and kappa, over 2
    U_T; log_current: ln I_0; log_charge: value and two derivatives by ln I, float64[3, 31]; tail: derivative
    by the threshold of `TAIL`, 1/V, float64[31]; unit_charge: C; gain, offset: 1/V, float64[4]; gate: of the
    sink, V; whole: the sink's law with a specific current of 1 A where it has second-order effects, without
    those of the drain, else None; capacitor: change of the charge by the relative change of each of
    `CAPACITORS`, over the charge a unit, where its bit is off and on, float64[6, 2].
    """

    specific_current: float
    pinch: float
    slope: float
    log_current: float
    log_charge: F64
    tail: F64
    unit_charge: float
    gain: F64
    offset: F64
    gate: float
    whole: Terms | None
    capacitor: F64


def axon_tables(model: AxonModel, silicon: Silicon) -> AxonTables:
    """Return everything about a model at the silicon's temperature that is the same on every die.

    Raises `ParameterError` outside the record's temperatures.
    """
    record = model.record
    typical = Silicon(silicon.process, silicon.temperature_c)
    _check(model, "temperature", silicon.temperature_c, record.limits(TEMPERATURE), "degC")
    weight = lagrange_weights(record.numbers(TEMPERATURE), silicon.temperature_c)
    log_charge, gain, offset = (
        np.tensordot(weight, record[table], (0, 0)) for table in ("log_charge", "gain", "offset")
    )
    fixed = all(model.circuit.bias(n).kind == "gate" for n in CURRENTS)
    return AxonTables(
        model,
        typical,
        _gates(model.circuit, typical) if fixed else None,
        typical.law("n"),
        log_charge,
        gain,
        offset,
        _basis(record.numbers(CURRENT)),
        _basis(record.numbers(COMPARATOR_CURRENT)),
    )


def process_shifts(silicon: Silicon) -> Shifts:
    """Return what the transistors of the silicon's die share, by polarity."""
    return {polarity: shared(silicon.die, silicon.process, polarity) for polarity in POLARITIES}


def conditions(tables: AxonTables, silicon: Silicon, shifts: Shifts) -> Conditions:
    """Return the record at the currents of a die whose transistors share `shifts`.

    Raises `ParameterError` outside the record's currents and shared shifts.
    """
    model, law = tables.model, tables.law
    gates = _gates(model.circuit, silicon) if tables.gates is None else tables.gates
    law = replace(
        law, v_t0=law.v_t0 + shifts["n"].v_t0, square_current=law.square_current * (1.0 + shifts["n"].beta)
    )
    specific, current, _ = _saturated(law, model, SINK, gates["i_delay"])
    _, comparator, tail_slope = _saturated(law, model, TAIL, gates["i_cmp"])
    _check(model, "i_delay", current, model.record.limits(CURRENT), "A")
    _check(model, "i_cmp", comparator, model.record.limits(COMPARATOR_CURRENT), "A")
    for polarity, shift in shifts.items():
        _check(model, f"{polarity}.v_t0_shift", shift.v_t0, model.record.limits(SHARED_SHIFT), "V")
    x, y = np.log(current), np.log(comparator)
    at = np.array([tables.over_current(x, k) for k in range(3)])
    log_charge = at @ np.tensordot(tables.over_comparator(y), tables.log_charge, (0, 1))
    tail = at[0] @ np.tensordot(tables.over_comparator(y, 1), tables.log_charge, (0, 1))
    unit = float(np.exp(log_charge[0, -1]) - np.exp(log_charge[0, 0])) / (HIGHEST - 1)
    gain, offset = at[0] @ tables.gain, at[0] @ tables.offset
    log_charge[0] += np.log1p(unit * _shared_change(model, shifts, gain, offset) / np.exp(log_charge[0]))
    names = model.record.names(PARAMETER)
    own = [names.index(f"{name}.v_t0") for name in LOCAL]
    half = 0.5 * law.kappa / law.u_t
    return Conditions(
        specific, float(pinch_off(half, gates["i_delay"], law.v_t0)), half, float(x), log_charge,
        tail_slope * tail, unit, gain[own], offset[own], gates["i_delay"], _whole(law, model, SINK),
        _capacitor_charges(model.axon, silicon.process),
    )  # fmt: skip


@compiled(forceinline=True)
def carried_at(c: Conditions, whole: Terms | None, shift: float) -> float:
    """Current of a sink with the drain far over its specific current, a ratio.

    whole: that of the conditions, None known when this is compiled; shift: of the sink's threshold, V.
    """
    if whole is None:
        return ekv_law(2.0 * (c.pinch - c.slope * shift))[0]
    return channel(whole, _FAR, c.gate - shift, 0.0)[0]


@compiled()
def carried(c: Conditions, shifts: F64, found: F64) -> None:
    """Current of every sink with the drain far over its specific current into `found`, float64[n].

    shifts: of the sinks' thresholds, V, float64[n].
    """
    for i in range(shifts.size):
        found[i] = carried_at(c, c.whole, shifts[i])


def check_local(model: AxonModel, thresholds: F64) -> None:
    """Raise `ParameterError` for comparators whose devices are outside the record's box.

    What the two devices of a pair share, as of a gradient across the chip, has the room that a polarity has;
    how far each is from it has that of local deviations. thresholds: of `LOCAL`, V, float64[n, 4].
    """
    pairs = thresholds.reshape(-1, 2, 2)
    common = pairs.mean(axis=-1, keepdims=True)
    for name, shift, side in (("pair", common, SHARED_SHIFT), ("mc", pairs - common, LOCAL_SHIFT)):
        worst = float(np.abs(shift).max(initial=0.0))
        _check(model, f"axon.{name}.v_t0_shift", worst, model.record.limits(side), "V")


def _shared_change(model: AxonModel, shifts: Shifts, gain: F64, offset: F64) -> F64:
    """Change of the charge by what a die shares, in units of the charge a unit, float64[31]."""
    codes = np.arange(1, HIGHEST + 1)
    change, names = np.zeros(codes.size), model.record.names(PARAMETER)
    for polarity, shift in shifts.items():
        for name, value in (("v_t0", shift.v_t0), ("beta", float(np.log1p(shift.beta)))):
            k = names.index(f"{polarity}.{name}")
            change += value * (offset[k] + gain[k] * codes)
    return change


@lru_cache(maxsize=16)
def _capacitor_charges(axon: Circuit, process: Process) -> F64:
    """What `Conditions.capacitor` is, by the charge on each plate between both ends of the ramp.

    The ramp falls by V_dd - v_ref: a bit that is on adds that over C_k, one that is off over C_k C_p / (C_k +
    C_p), and C_o takes V_dd away and gives V_dd - v_ref. A unit is C_u (V_dd - v_ref), C_u the weight of the
    least bit.
    """
    parasitic = parasitic_capacitance()
    drawn = np.array([capacitor_of(axon, name).capacitance for name in CAPACITORS])
    found = np.stack([drawn * (parasitic / (drawn + parasitic)) ** 2, drawn], axis=1)
    reference = float(np.asarray(axon.bias("v_ref").value))
    found[-1] = -drawn[-1] * reference / (process.v_dd - reference)
    return np.asarray(found * (drawn[0] + parasitic) / drawn[0] ** 2)


def _gates(circuit: Circuit, silicon: Silicon) -> dict[str, float]:
    return {n: float(bias_voltages(circuit, circuit.bias(n), silicon)) for n in CURRENTS}


def _basis(grid: Sequence[float]) -> CubicSpline:
    x = np.log(np.array(grid))
    return interpolate.CubicSpline(x, np.eye(x.size))


def _saturated(
    law: TransistorAtTemperature, model: AxonModel, name: str, gate: float
) -> tuple[float, float, float]:
    """Specific current and current in saturation, A, of an nFET without deviations; d ln I / d V_T0, 1/V."""
    specific = law.square_current * transistor_of(model.axon, name).square
    whole = _whole(law, model, name)
    if whole is not None:
        share, _, by_gate, _ = channel(whole, _FAR, gate, 0.0)
        return specific, specific * share, -by_gate / share
    share = float(interpolation(pinch_off(law.kappa, gate, law.v_t0) / law.u_t))
    return specific, specific * share, -law.kappa / law.u_t * float(steepness(share))


def _whole(law: TransistorAtTemperature, model: AxonModel, name: str) -> Terms | None:
    """The law of a device per ampere of specific current, drain far; None without second-order effects."""
    if law == law.ideal():
        return None
    device = transistor_of(model.axon, name)
    flat = replace(law.without_leakage(), early_field=0.0)
    return terms_of(flat, device.width * device.multiplicity, device.length, 1.0, law.v_t0)


def _check(model: AxonModel, label: str, value: float, limits: Sequence[float], unit: str) -> None:
    require_inside(f"{model.circuit.name}.{label}", value, limits, unit)
