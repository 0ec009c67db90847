"""Gate voltages that set the bias currents of a circuit, and the currents that these voltages give.

A bias current I is reached in a device in saturation with its source at its bulk. There the EKV law of
`circuits.devices.transistor` is `I = I_S F(v_p / U_T) E M`, which is solved for the pinch-off voltage:

    v_p = 2 U_T ln(e^sqrt(I / (I_S E M)) - 1)

The Early effect E is that of a device whose drain is at its gate, as the diode that sets a bias has it
(ours). The gate voltage follows from v_p by the pinch-off law of the process, with constant kappa or with
body effect. The gate voltage of a pFET counts from the supply down.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.circuit import Bias, BiasKind, Circuit
from circuits.devices.channel import early, height_of, mobility, pinch_off_of
from circuits.devices.softplus import inverse_softplus
from circuits.devices.transistor import Transistor, drain_current
from circuits.errors import ParameterError, SolverError, TopologyError
from circuits.generator.code import REFERENCE_C
from circuits.generator.voltage import Line, line_voltages, lone_line_voltages
from circuits.place import bias_path, chip_and_line
from circuits.silicon.die import NOMINAL, Path, Place
from circuits.silicon.process import TransistorAtTemperature, at_temperature, kelvin
from circuits.silicon.silicon import Silicon


def gate_voltage(law: TransistorAtTemperature, device: Transistor, current: float) -> float:
    """Gate voltage (V, a magnitude above the bulk) at which a device in saturation carries `current` A.

    With an Early effect the drain is taken to be at the gate.

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
    law = law.of_size(device.width, device.length)
    specific = law.square_current * device.multiplicity * device.width / device.length
    without = current  # what the device would carry without Early effect and mobility reduction
    for _ in range(_ROUNDS):
        v_p = 2.0 * law.u_t * inverse_softplus(math.sqrt(without / specific))
        if law.gamma > 0.0 and v_p <= -law.surface_potential:
            least = specific * math.exp(-law.surface_potential / law.u_t)
            raise ParameterError(
                f"{device.name}: bias current {current:g} A, must be > {least:.3g} A, the current at flat"
                " band"
            )
        gate, before = float(height_of(law, v_p)) + law.v_t0, without
        effect = early(law, device.length, max(gate, 0.0), math.sqrt(without / specific))
        without = current / float(effect * mobility(law, v_p))
        if abs(without - before) <= _ROUNDING * before:
            return gate
    raise ParameterError(
        f"{device.name}: bias current {current:g} A, no gate voltage gives it; correct the process's figures"
    )


def deviating_gate_voltage(
    law: TransistorAtTemperature, device: Transistor, current: float, deviation: tuple[float, float]
) -> float:
    """Gate voltage (V, a magnitude above the bulk) of one device that deviates from its law.

    deviation: of V_T0, V, and of beta, relative. Everything else, and what is raised, as of `gate_voltage`.
    """
    v_t0, beta = deviation
    return (
        gate_voltage(replace(law, square_current=law.square_current * (1.0 + beta)), device, current) + v_t0
    )


# each round leaves less than half of the error, and its own rounding, some 1e-15; ours
_ROUNDS, _ROUNDING = 200, 1e-14


def bias_voltages(circuit: Circuit, bias: Bias, silicon: Silicon) -> F64:
    """Voltages that a bias puts on its port at the silicon's temperature, V, float64 of the port's shape.

    A `gate` bias is computed on the nominal device at the bias's reference temperature, an `ideal` bias on
    the die's own copy of the device at the silicon's temperature, a `generator` bias that of its line of the
    chip's generator on the die (`circuits.generator`), and a `voltage` bias is its value.

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
        A current needs a gate beyond the supply, or the generator has no code for it.
    SolverError
        The generator does not work at the silicon's supply.
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
    if bias.kind == "generator":
        return _generated(circuit, bias, device, np.broadcast_to(values, shape), silicon)
    gates = _gates(circuit.name, bias, device, np.broadcast_to(values, shape), silicon)
    if gates.max(initial=0.0) > silicon.process.v_dd:
        k = int(np.argmax(gates))
        current, needed = np.broadcast_to(values, shape).ravel()[k], gates.ravel()[k]
        raise ParameterError(
            f"{circuit.name}.{bias.name}: {current:g} A needs {needed:.3g} V on the gate of {device.name},"
            f" beyond the supply of {silicon.process.v_dd:g} V; give a smaller current"
        )
    return silicon.process.v_dd - gates if device.polarity == "p" else gates


def lone_voltages(circuit: Circuit, biases: Sequence[Bias], silicon: Silicon) -> dict[str, float]:
    """What `bias_voltages` gives of biases of ports without a shape, by port, V.

    The generator's lines are found side by side. Raises as `bias_voltages` does.
    """
    lined = [b for b in biases if b.kind == "generator"]
    lines = [lines_of(circuit, b, silicon) for b in lined]
    try:
        volts = lone_line_voltages([line for line, _ in lines], [current for _, current in lines], silicon)
    except (ParameterError, SolverError):
        volts, lined = [], []  # what is wrong is said of the one that it is of
    known = dict(zip([b.port for b in lined], volts, strict=True))
    return {
        b.port: known[b.port] if b.port in known else float(bias_voltages(circuit, b, silicon))
        for b in biases
    }


def _generated(circuit: Circuit, bias: Bias, device: Transistor, current: F64, silicon: Silicon) -> F64:
    """Voltages of the lines of the generator on the chip that the circuit is, or is a part of, V."""
    line = _line_of(circuit, bias, device, current.shape, silicon)
    try:
        return line_voltages(line, _at_reference(bias, current), silicon)
    except ParameterError as error:
        raise ParameterError(f"{circuit.name}.{bias.name}: {error}") from None


def _line_of(
    circuit: Circuit, bias: Bias, device: Transistor, shape: tuple[int, ...], silicon: Silicon
) -> Line:
    if bias.place is None:
        return Line(silicon.place or ((circuit.name, ()),), bias.port, shape, None, device)
    chip, (port, index) = chip_and_line(bias.place)
    return Line(chip, port, (), index, device)


def _at_reference(bias: Bias, current: F64) -> F64:
    """Currents of a bias at the reference temperature of codes, A."""
    return current * kelvin(REFERENCE_C) / kelvin(bias.reference_temperature_c)


def lines_of(circuit: Circuit, bias: Bias, silicon: Silicon) -> tuple[Line, F64]:
    """Lines of the generator behind a bias of that kind, and their currents at the reference temperature, A.

    The currents have the shape of the bias's port. Raises `TopologyError` for a bias of kind `voltage`.
    """
    device, shape = _biased_device(circuit, bias), circuit.port(bias.port).shape
    current = np.broadcast_to(np.asarray(bias.value, dtype=np.float64), shape)
    return _line_of(circuit, bias, device, shape, silicon), _at_reference(bias, current)


def _gates(circuit: str, bias: Bias, device: Transistor, current: F64, silicon: Silicon) -> F64:
    """Gate voltages above the bulk, V. Only an ideal bias's copy of the device is on the die."""
    process, reference = silicon.process, bias.reference_temperature_c
    if bias.kind == "gate":
        law = at_temperature(process.model(device.polarity), process, reference)
        return _each(lambda i, _: gate_voltage(law, device, i), current)
    place, path = copies_of(circuit, bias, device, current.shape, silicon)
    there = replace(silicon, place=place)
    deviation = there.deviation(circuit, path, device.gate_area, device.polarity)
    v_t0, beta = (np.broadcast_to(d, current.size) for d in deviation)
    law = silicon.law(device.polarity)
    scale = kelvin(silicon.temperature_c) / kelvin(reference)

    def copy(amperes: float, k: int) -> float:
        return deviating_gate_voltage(law, device, amperes * scale, (float(v_t0[k]), float(beta[k])))

    return _each(copy, current)


def copies_of(
    circuit: str, bias: Bias, device: Transistor, shape: tuple[int, ...], silicon: Silicon
) -> tuple[Place, Path]:
    """Place from which deviations of an ideal bias's copies are drawn, and their path from there on.

    circuit: its name; device: what is biased; shape: of the bias's port.
    """
    if bias.place is not None:
        return bias.place, ((device.name, ()),)
    return silicon.place or ((circuit, ()),), (*bias_path(bias.port, shape), (device.name, ()))


def _each(gate: Callable[[float, int], float], current: F64) -> F64:
    return np.array([gate(float(i), k) for k, i in enumerate(current.ravel())]).reshape(current.shape)


def saturation_current(circuit: Circuit, bias: Bias, silicon: Silicon) -> F64:
    """Current that a bias gives in the nominal device at the silicon's temperature, A, of the port's shape.

    Raises `TopologyError` for a bias of kind `voltage`, which sets no current.
    """
    device = _biased_device(circuit, bias)
    nominal = replace(silicon, die=NOMINAL)
    return _saturated(nominal.law(device.polarity), device, bias_voltages(circuit, bias, nominal), silicon)


def closed_current(circuit: Circuit, bias: Bias, silicon: Silicon) -> float:
    """Current of `saturation_current` for a bias of one value, by functions of arrays.

    It is the same within 1e-13, and needs no kernel, whose compiler is slow to load.
    """
    device = _biased_device(circuit, bias)
    nominal = replace(silicon, die=NOMINAL)
    law = nominal.law(device.polarity).of_size(device.width, device.length)
    v_dd = silicon.process.v_dd
    voltage = float(bias_voltages(circuit, bias, nominal))
    gate = v_dd - voltage if device.polarity == "p" else voltage
    v_p = pinch_off_of(law, gate - law.v_t0)
    forward, reverse = (np.logaddexp(0.0, 0.5 * (v_p - v) / law.u_t) for v in (0.0, v_dd))
    coefficient = (forward - reverse) * (forward + reverse)
    effects = mobility(law, v_p) * early(law, device.length, abs(gate), np.sqrt(coefficient))
    return float(law.square_current * device.square * coefficient * effects)


def die_current(circuit: Circuit, bias: Bias, silicon: Silicon) -> float:
    """Current that a bias of one value gives in its device on the silicon's die, A.

    Both the device's own deviations and those that the die shares are included. Raises `TopologyError` for a
    bias of kind `voltage`, which sets no current.
    """
    device = _biased_device(circuit, bias)
    path = tuple((name, ()) for name in (bias.device or "").split("."))
    area = device.width * device.length * device.multiplicity
    deviation = silicon.deviation(circuit.name, path, area, device.polarity)
    v_t0, beta = (float(np.ravel(d)[0]) for d in deviation)
    law = silicon.law(device.polarity)
    own = replace(law, v_t0=law.v_t0 + v_t0, square_current=law.square_current * (1.0 + beta))
    return float(_saturated(own, device, bias_voltages(circuit, bias, silicon), silicon))


def _biased_device(circuit: Circuit, bias: Bias) -> Transistor:
    device = None if bias.device is None else circuit.device(bias.device)
    if bias.kind == "voltage" or not isinstance(device, Transistor):
        raise TopologyError(f"{circuit.name}.{bias.name}: no current bias; name one that sets a current")
    return device


def _saturated(law: TransistorAtTemperature, device: Transistor, gates: F64, silicon: Silicon) -> F64:
    """Channel current with the drain far, but for the Early effect, which is that of a drain at the gate."""
    law = law.of_size(device.width, device.length)
    v_dd = silicon.process.v_dd if device.polarity == "p" else 0.0
    high = 0.0 if device.polarity == "p" else silicon.process.v_dd
    size = device.width * device.multiplicity, device.length
    flat = replace(law, early_field=0.0, junction_leakage=0.0, gate_induced_leakage=0.0)

    def carried(at: TransistorAtTemperature) -> F64:
        return np.abs(drain_current(at, device.polarity, *size, high, gates, v_dd, v_dd)).reshape(gates.shape)

    coefficient = carried(replace(flat, mobility_reduction=0.0)) / (law.square_current * device.square)
    return np.asarray(carried(flat) * early(law, device.length, np.abs(gates - v_dd), np.sqrt(coefficient)))


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
        What all biases but voltages become, `gate`, `ideal` or `generator`; each keeps its kind unless given.
    """
    biases = {b.name: b for b in circuit.biases}
    for name, value in (values or {}).items():
        biases[name] = replace(circuit.bias(name), value=value)
    if kind is not None:
        biases = {n: b if b.kind == "voltage" else replace(b, kind=kind) for n, b in biases.items()}
    return replace(circuit, biases=tuple(biases.values()))
