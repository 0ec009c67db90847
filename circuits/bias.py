"""Gate voltages that set the bias currents of a circuit, and the currents that these voltages give.

A bias current I is reached in a device in saturation with its source at its bulk. There the EKV law of
`circuits.devices.transistor` is `I = I_S F(v_p / U_T)`, which is solved for the pinch-off voltage:

    v_p = 2 U_T ln(e^sqrt(I / I_S) - 1)

The gate voltage follows from v_p by the pinch-off law of the process, with constant kappa or with body
effect. The gate voltage of a pFET counts from the supply down.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.circuit import Bias, BiasKind, Circuit
from circuits.devices.softplus import inverse_softplus
from circuits.devices.transistor import Transistor, drain_current
from circuits.errors import ParameterError, TopologyError
from circuits.place import bias_path
from circuits.silicon.die import NOMINAL
from circuits.silicon.process import TransistorAtTemperature, at_temperature, kelvin
from circuits.silicon.silicon import Silicon


def gate_voltage(law: TransistorAtTemperature, device: Transistor, current: float) -> float:
    """Gate voltage (V, a magnitude above the bulk) at which a device in saturation carries `current` A.

    Raises `ParameterError` for a current that is not finite and above zero, and for one below what the law
    with body effect gives at flat band.

    Parameters
    ----------
    law
        Parameters of the device's polarity at the temperature of interest.
    device
        The device: its width, length and multiplicity count; its source is taken to be at its bulk.
    current
        Current that it carries, A.
    """
    if not (math.isfinite(current) and current > 0.0):
        raise ParameterError(
            f"{device.name}: bias current {current:g} A, must be > 0; give a positive current"
        )
    specific = law.square_current * device.multiplicity * device.width / device.length
    v_p = 2.0 * law.u_t * inverse_softplus(math.sqrt(current / specific))
    if law.gamma == 0.0:
        return law.v_t0 + v_p / law.kappa
    # the pinch-off law inverted: with r = sqrt(v_x + gamma^2/4), v_p + phi = r^2 - gamma r + gamma^2/4
    half = 0.5 * law.gamma
    above_flat_band = v_p + law.surface_potential
    if above_flat_band <= 0.0:
        least = specific * math.exp(-law.surface_potential / law.u_t)
        raise ParameterError(
            f"{device.name}: bias current {current:g} A, must be > {least:.3g} A, the current at flat band"
        )
    v_x = (half + math.sqrt(above_flat_band)) ** 2 - half**2
    return v_x + law.v_t0 - law.surface_potential - law.gamma * math.sqrt(law.surface_potential)


def bias_voltages(circuit: Circuit, bias: Bias, silicon: Silicon) -> F64:
    """Voltages that a bias puts on its port at the silicon's temperature, V, float64 of the port's shape.

    A `gate` bias is computed on the nominal device at the bias's reference temperature, a `generator` bias on
    the die's own copy of the device at the silicon's temperature, and a `voltage` bias is its value.

    Parameters
    ----------
    circuit
        The circuit that has the bias.
    bias
        The bias.
    silicon
        Process, temperature and die.

    Raises
    ------
    TopologyError
        The values do not fit the port's shape, or the device is no transistor.
    ParameterError
        A current needs a gate beyond the supply.
    """
    values = np.asarray(bias.value, dtype=np.float64)
    shape = circuit.port(bias.port).shape
    if values.shape not in ((), shape):
        raise TopologyError(
            f"{circuit.name}.{bias.port}: values of shape {values.shape} for a port of shape {shape};"
            " give one number, or one an element"
        )
    if bias.kind == "voltage":
        return np.broadcast_to(values, shape).copy()
    device = circuit.device(bias.device or "")
    if not isinstance(device, Transistor):
        raise TopologyError(
            f"{circuit.name}.{bias.port}: {device.name} is no transistor; a current bias needs one"
        )
    gates = _gates(circuit.name, bias, device, np.broadcast_to(values, shape), silicon)
    if gates.max(initial=0.0) > silicon.process.v_dd:
        k = int(np.argmax(gates))
        current, needed = np.broadcast_to(values, shape).ravel()[k], gates.ravel()[k]
        raise ParameterError(
            f"{circuit.name}.{bias.name}: {current:g} A needs {needed:.3g} V on the gate of {device.name},"
            f" beyond the supply of {silicon.process.v_dd:g} V; give a smaller current"
        )
    return silicon.process.v_dd - gates if device.polarity == "p" else gates


def _gates(circuit: str, bias: Bias, device: Transistor, current: F64, silicon: Silicon) -> F64:
    """Gate voltages above the bulk, V. Only a generator's copy of the device is on the die."""
    process, reference = silicon.process, bias.reference_temperature_c
    if bias.kind == "gate":
        law = at_temperature(process.model(device.polarity), process, reference)
        return _each(lambda i, _: gate_voltage(law, device, i), current)
    area = device.width * device.length * device.multiplicity
    if bias.place is None:
        path = (*bias_path(bias.port, current.shape), (device.name, ()))
        deviation = silicon.deviation(circuit, path, area)
    else:
        deviation = replace(silicon, place=bias.place).deviation(circuit, ((device.name, ()),), area)
    v_t0, beta = (np.broadcast_to(d, current.size) for d in deviation)
    law = silicon.law(device.polarity)
    scale = kelvin(silicon.temperature_c) / kelvin(reference)

    def copy(amperes: float, k: int) -> float:
        own = replace(law, square_current=law.square_current * (1.0 + float(beta[k])))
        return gate_voltage(own, device, amperes * scale) + float(v_t0[k])

    return _each(copy, current)


def _each(gate: Callable[[float, int], float], current: F64) -> F64:
    return np.array([gate(float(i), k) for k, i in enumerate(current.ravel())]).reshape(current.shape)


def saturation_current(circuit: Circuit, bias: Bias, silicon: Silicon) -> F64:
    """Current that a bias gives in the nominal device at the silicon's temperature, A, of the port's shape.

    Raises `TopologyError` for a bias of kind `voltage`, which sets no current.
    """
    device = _biased_device(circuit, bias)
    nominal = replace(silicon, die=NOMINAL)
    return _saturated(nominal.law(device.polarity), device, bias_voltages(circuit, bias, nominal), silicon)


def die_current(circuit: Circuit, bias: Bias, silicon: Silicon) -> float:
    """Current that a bias of one value gives in its device on the silicon's die, A.

    Both the device's own deviations and those that the die shares are included. Raises `TopologyError` for a
    bias of kind `voltage`, which sets no current.
    """
    device = _biased_device(circuit, bias)
    path = tuple((name, ()) for name in (bias.device or "").split("."))
    area = device.width * device.length * device.multiplicity
    v_t0, beta = (float(np.ravel(d)[0]) for d in silicon.deviation(circuit.name, path, area))
    law = silicon.law(device.polarity)
    own = replace(law, v_t0=law.v_t0 + v_t0, square_current=law.square_current * (1.0 + beta))
    return float(_saturated(own, device, bias_voltages(circuit, bias, silicon), silicon))


def _biased_device(circuit: Circuit, bias: Bias) -> Transistor:
    device = None if bias.device is None else circuit.device(bias.device)
    if bias.kind == "voltage" or not isinstance(device, Transistor):
        raise TopologyError(f"{circuit.name}.{bias.name}: no current bias; name a gate or generator")
    return device


def _saturated(law: TransistorAtTemperature, device: Transistor, gates: F64, silicon: Silicon) -> F64:
    v_dd = silicon.process.v_dd if device.polarity == "p" else 0.0
    high = 0.0 if device.polarity == "p" else silicon.process.v_dd
    size = device.width * device.multiplicity, device.length
    return np.abs(drain_current(law, device.polarity, *size, high, gates, v_dd, v_dd)).reshape(gates.shape)


def rebias(
    circuit: Circuit,
    values: Mapping[str, float | tuple[float, ...]] | None = None,
    kind: BiasKind | None = None,
) -> Circuit:
    """Give the same circuit with other biases.

    Raises `UnknownNameError` for a name that is no bias of the circuit.

    Parameters
    ----------
    circuit
        The circuit.
    values
        The new value of a bias by its name, A or V.
    kind
        What all biases but voltages become, `gate` or `generator`; each keeps its kind unless given.
    """
    biases = {b.name: b for b in circuit.biases}
    for name, value in (values or {}).items():
        biases[name] = replace(circuit.bias(name), value=value)
    if kind is not None:
        biases = {n: b if b.kind == "voltage" else replace(b, kind=kind) for n, b in biases.items()}
    return replace(circuit, biases=tuple(biases.values()))
