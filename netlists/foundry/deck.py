"""A block on a foundry's process: sizes and biases by a mapping's rules, and a deck that runs on its own.

Sizes are kept, or follow the rule of a user's mapping. Biases become voltages, computed at the mapping's
temperature:

- A current's gate voltage is the one at which the foundry's device, with source and bulk at its rail and the
  drain at the other, carries the current. It is read off a sweep of the gate in ngspice in steps of 1 mV,
  log I being straight in between (the law in weak inversion).
- A voltage at the gate of a device (`gate_of`, its path in the circuit or in an instance of it) is replaced
  likewise, by the gate voltage at which the foundry's device carries what our law gives for ours.
- Other voltages are multiplied by the ratio of the supplies, unless the mapping gives them in volts.

The deck has `M` elements for transistors (their capacitances are the card's), our text for everything else,
the cards it needs as literal text, and stimuli at the foundry's supply. On a die each transistor has its
deviations as `delvto` and `mulu0`, and the cards those that the die shares (`netlists.foundry.die`).
"""

from __future__ import annotations

import contextlib
import itertools
import math
from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.circuit import Bias, Circuit, Instance, InstanceArray
from circuits.devices import Transistor
from circuits.devices.device import Device
from circuits.devices.transistor import drain_current
from circuits.errors import ParameterError, TopologyError, UnknownNameError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import POLARITIES
from circuits.silicon.silicon import NO_DEVIATION, Change, Deviation, Silicon
from circuits.testbench import Testbench
from netlists.dialects.ngspice import PRINTED, format_device, node_name, run_name
from netlists.foundry.die import (
    check_die,
    expressions,
    has_process,
    own_deviation,
    shared_numbers,
    statistics_text,
    unit_silicon,
)
from netlists.foundry.process import TYPICAL, DeviceMapping, choose_cards, read_cards
from netlists.naming import element
from netlists.ngspice import run as ngspice
from netlists.registry import POINTS, Settings
from netlists.write.bsim3 import deviating
from netlists.write.deck import held_at_start
from netlists.write.traversal import Definition, as_made, to_design

_OPTIONS = "gmin=1e-15 abstol=1e-15 chgtol=1e-17"
_SETTINGS = Settings(reltol=1e-4)
_STEP = 1e-3  # V, of the gate's sweep


def map_circuit(circuit: Circuit, mapping: DeviceMapping, silicon: Silicon) -> Circuit:
    """Put a circuit on a foundry's process: its sizes by the rule, its biases as voltages; this runs ngspice.

    Parameters
    ----------
    circuit
        The circuit.
    mapping
        The foundry's process (`read_mapping`).
    silicon
        What the biases of `circuit` were chosen for; its supply and its nominal devices count.

    Raises
    ------
    ParameterError
        A current that the foundry's device cannot carry, or a size that no card has.
    SimulatorError
        ngspice is missing or fails.
    """
    at = Silicon(silicon.process, mapping.temperature_c)
    wanted = [(bias, *_wanted(circuit, bias, mapping, at)) for bias in circuit.biases]
    jobs = [(device, float(i)) for _, device, values in wanted if device for i in values.ravel()]
    gates = iter(gate_voltages(jobs, mapping))
    biases = []
    for bias, device, values in wanted:
        volts = [next(gates) for _ in range(values.size)] if device else values.ravel().tolist()
        value = tuple(volts) if values.ndim else volts[0]
        biases.append(replace(bias, kind="voltage", value=value, device=None, place=None))
    return replace(_resize(circuit, mapping), biases=tuple(biases))


def format_foundry(
    testbench: Testbench,
    mapping: DeviceMapping,
    silicon: Silicon,
    settings: Settings = _SETTINGS,
) -> str:
    """Write the complete ngspice deck of a testbench whose circuit has come from `map_circuit`.

    Parameters
    ----------
    testbench
        The testbench.
    mapping
        The foundry's process.
    silicon
        Temperature, die and place; its die's draws have the keys that they have on our process.
    settings
        Analysis, tolerance, method and largest step.

    Raises
    ------
    ParameterError
        A size that no card of the foundry holds for, or a die or corner that the foundry has not.
    """
    check_die(mapping, silicon.die)
    design = to_design(testbench, unit_silicon(silicon))
    top, step = design.top, testbench.stop / POINTS if settings.tmax is None else settings.tmax
    temperature_c = silicon.temperature_c
    printed = " ".join(f"v({run_name(path, top)})" for path in [*design.nodes][:PRINTED])
    card = ".op" if settings.analysis == "op" else f".tran {step!r} {testbench.stop!r} 0 {step!r}"
    name, ports = node_name(top.name), " ".join(map(node_name, top.ports))
    starts, held = (
        [f"+ v({run_name(path, top)})={v!r}" for path, v in sorted(given.items())]
        for given in (testbench.start, held_at_start(testbench, silicon))
    )
    uic = testbench.begin == "uic"
    devices = (device for definition in design.definitions for device, _ in definition.devices)
    where = f"on {mapping.name} at {temperature_c!r} degC, {silicon.die}"
    changed = "as drawn" if mapping.sizes.kept else f"not those of the circuit: {mapping.sizes}"
    lines = [
        f"* {' '.join(testbench.title.split())}: circuit {name}, {where}",
        f"* sizes of transistors are {changed}",
        *([] if silicon.die.number is None else [f"* statistics: {statistics_text(mapping)}"]),
        *header(mapping, (d for d in devices if isinstance(d, Transistor)), silicon.die),
        *(line for definition in design.definitions for line in _definition(definition, mapping, silicon)),
        f"x{name} {ports} {name}",
        *(line for source in design.sources for line in format_device(source, silicon)),
        *([".nodeset", *starts] if starts and not uic else []),
        *([".ic", *held] if held else []),
        f".options temp={temperature_c!r} {_OPTIONS} method={settings.method} reltol={settings.reltol!r}",
        ".save",
        *(f"+ v({run_name(path, top)})" for path in design.nodes),
        f".print {settings.analysis} {printed}",
        f"{card}{' uic' if uic and settings.analysis == 'tran' else ''}",
        ".end",
    ]
    return "\n".join(lines) + "\n"


def format_transistor(device: Transistor, mapping: DeviceMapping, deviation: Deviation = NO_DEVIATION) -> str:
    """`M` element of a device that has the foundry's size; areas by the mapping's diffusion.

    Parameters
    ----------
    device
        The device, with its nodes.
    mapping
        The foundry's process.
    deviation
        What its place on a die adds: to the magnitude of V_T, V, and to beta, relative.
    """
    fingers, d = _fingers(device, mapping), mapping.sizes.diffusion
    width, parallel = device.width / fingers, device.multiplicity * fingers
    area, perimeter = width * d, 2.0 * (width + d)
    nodes = " ".join(map(node_name, device.terminals()))
    return (
        f"m{device.name} {nodes} {mapping.models[device.polarity][0]} w={width!r} l={device.length!r}"
        f" m={parallel!r} ad={area!r} as={area!r} pd={perimeter!r} ps={perimeter!r}"
        + "".join(f" {name}={value!r}" for name, value in deviating(device.polarity, deviation).items())
    )


def resized(device: Transistor, mapping: DeviceMapping) -> Transistor:
    """The device with the foundry's size."""
    sizes = mapping.sizes
    return replace(device, width=sizes.width(device.width), length=sizes.length(device.length))


def sweep_gate(
    devices: Sequence[Transistor],
    mapping: DeviceMapping,
    voltage: tuple[float, float, float],
    temperature_c: float,
    source: float = 0.0,
    drain: float | None = None,
    die: Die = NOMINAL,
    deviations: Sequence[Deviation] = (),
) -> tuple[F64, F64]:
    """Drain currents of foundry devices over the gate's voltage, in ngspice.

    Parameters
    ----------
    devices
        With the foundry's sizes; their terminals are not looked at. Bulk at the rail.
    voltage
        First, last and step of the gate's voltage, V to the bulk, a pFET's mirrored.
    temperature_c
        In degC.
    source
        Voltage of the source to the bulk, V, a pFET's mirrored.
    drain
        Voltage of the drain to the bulk, V, a pFET's mirrored; the supply unless given.
    die
        What its devices share is that of all of these; its corner is theirs.
    deviations
        What each device's own place adds; nothing unless given.

    Returns
    -------
    Gate voltages, float64[T], V; magnitudes of the currents, float64[devices, T], A.
    """
    lines = ["* foundry's devices side by side", *header(mapping, devices, die), "vg g 0 dc 0"]
    lines += [f"vrail rail 0 dc {mapping.v_dd!r}", "ep rail gp g 0 1"]
    lines += [f"vsn sn 0 dc {source!r}", f"vsp rail sp dc {source!r}"]
    high = mapping.v_dd if drain is None else drain
    own = deviations or [NO_DEVIATION] * len(devices)
    for k, device in enumerate(devices):
        n = device.polarity == "n"
        gate, s, bulk = ("g", "sn", "0") if n else ("gp", "sp", "rail")
        placed = replace(device, name=f"m{k}", drain=f"d{k}", gate=gate, source=s, bulk=bulk)
        lines += [f"vd{k} d{k} 0 dc {high if n else mapping.v_dd - high!r}"]
        lines += [format_transistor(placed, mapping, own[k])]
    lines += [f".options temp={temperature_c!r} {_OPTIONS} reltol=1e-6"]
    lines += [f".dc vg {voltage[0]!r} {voltage[1]!r} {voltage[2]!r}", ".end"]
    found = ngspice.run("\n".join(lines) + "\n", vectors=tuple(f"vd{k}#branch" for k in range(len(devices))))
    return found.axis, np.abs(np.array([found.values[f"vd{k}#branch"] for k in range(len(devices))]))


def bulk_current(device: Transistor, mapping: DeviceMapping, drain: float, temperature_c: float) -> float:
    """Current between drain and bulk of a foundry's device with gate and source at the bulk, A, in ngspice.

    Parameters
    ----------
    device
        With the foundry's size; its terminals are not looked at.
    mapping
        The foundry's process.
    drain
        Voltage of the drain to the bulk, V, a pFET's mirrored.
    temperature_c
        In degC.
    """
    placed = replace(device, name="m", drain="d", gate="0", source="0", bulk="b")
    high = drain if device.polarity == "n" else -drain
    lines = ["* a foundry's junction", *header(mapping, [device]), f"vd d 0 dc {high!r}", "vb b 0 dc 0"]
    lines += [format_transistor(placed, mapping), f".options temp={temperature_c!r} {_OPTIONS} reltol=1e-6"]
    found = ngspice.run("\n".join([*lines, ".op", ".end"]) + "\n", vectors=("vb#branch",))
    return abs(float(found.values["vb#branch"][0]))


def gate_voltages(jobs: Sequence[tuple[Transistor, float]], mapping: DeviceMapping) -> list[float]:
    """Gate voltages, V to ground, at which foundry devices saturate at the currents (A) beside them.

    Raises `ParameterError` for a current below what the device carries with no gate voltage, or beyond its
    most at the supply.
    """
    if not jobs:
        return []
    devices = [device for device, _ in jobs]
    axis, current = sweep_gate(devices, mapping, (0.0, mapping.v_dd, _STEP), mapping.temperature_c)
    found = []
    for (device, wanted), swept in zip(jobs, current, strict=True):
        k = int(np.argmax(swept >= wanted))
        if k == 0:
            raise ParameterError(
                f"{device.name}: {wanted:g} A, must be within {swept[0]:.3g} to {swept[-1]:.3g} A, which"
                f" {mapping.models[device.polarity][0]} carries; give another current"
            )
        low, high = np.log(swept[k - 1]), np.log(swept[k])
        gate = float(axis[k - 1] + (np.log(wanted) - low) / (high - low) * (axis[k] - axis[k - 1]))
        found.append(gate if device.polarity == "n" else mapping.v_dd - gate)
    return found


def _fingers(device: Transistor, mapping: DeviceMapping) -> int:
    """Equal parallel devices that a wide one becomes."""
    return max(1, math.ceil(device.width / mapping.sizes.most_width))


def _wanted(
    circuit: Circuit, bias: Bias, mapping: DeviceMapping, silicon: Silicon
) -> tuple[Transistor | None, F64]:
    """Foundry device whose gate a bias sets and its currents, A; or no device and voltages, V."""
    values = np.asarray(bias.value, dtype=np.float64)
    if bias.kind != "voltage":
        return resized(_transistor(circuit, bias.device or ""), mapping), values
    how, what = mapping.biases.get(bias.name, ("", 0.0))
    if how == "volts":
        return None, np.full_like(values, float(what))
    if how == "gate_of":
        device, v_dd = _inner_transistor(circuit, str(what)), silicon.process.v_dd
        rail, other = (0.0, v_dd) if device.polarity == "n" else (v_dd, 0.0)
        size = (device.width * device.multiplicity, device.length)
        law = silicon.law(device.polarity).of_size(device.width, device.length)
        current = drain_current(law, device.polarity, *size, other, values, rail, rail)
        return resized(device, mapping), np.abs(current).reshape(values.shape)
    return None, values * (mapping.v_dd / silicon.process.v_dd)


def _transistor(circuit: Circuit, path: str) -> Transistor:
    device = circuit.device(path)
    if not isinstance(device, Transistor):
        raise TopologyError(f"{circuit.name}.{path}: no transistor; a gate voltage needs one")
    return device


def _inner_transistor(circuit: Circuit, path: str) -> Transistor:
    """The transistor at `path` in the circuit, or in the first instance that has one there."""
    for place in (circuit, *(i.circuit for i in circuit.instances)):
        with contextlib.suppress(UnknownNameError):
            return _transistor(place, path)
    return _transistor(circuit, path)


def _resize(circuit: Circuit, mapping: DeviceMapping) -> Circuit:
    """The circuit with all its transistors, and the sizes that instances give, by the mapping's rule."""
    devices = tuple(resized(d, mapping) if isinstance(d, Transistor) else d for d in circuit.devices)
    instances = tuple(_resize_instance(i, mapping) for i in circuit.instances)
    return replace(circuit, devices=devices, instances=instances)


def _resize_instance(instance: Instance | InstanceArray, mapping: DeviceMapping) -> Instance | InstanceArray:
    sizes, parameters = mapping.sizes, dict(instance.parameters)
    rules = {
        "width": (sizes.width_factor, sizes.least_width),
        "length": (sizes.length_factor, sizes.least_length),
    }
    for key, value in parameters.items():
        path, _, attribute = key.rpartition(".")
        if attribute in rules and isinstance(instance.circuit.device(path), Transistor):
            factor, least = rules[attribute]
            scaled = np.maximum(factor * np.asarray(value, dtype=np.float64), least)
            parameters[key] = scaled if scaled.ndim else float(scaled)
    inner = _resize(instance.circuit, mapping)
    if isinstance(instance, Instance):
        numbers = {k: float(np.asarray(v, dtype=np.float64)) for k, v in parameters.items()}
        return replace(instance, circuit=inner, parameters=numbers)
    return replace(instance, circuit=inner, parameters=parameters)


def header(mapping: DeviceMapping, devices: Iterable[Transistor], die: Die = NOMINAL) -> list[str]:
    """Parameters and cards that devices of a mapping use on a die, as lines of a deck.

    Raises `ParameterError` for a size that no card holds for.
    """
    used = list(devices)
    lines = [f"* model cards: {mapping.notice}"]
    lines += [f".param {name}={value!r}" for name, value in mapping.parameters.items()]
    statistics = mapping.statistics if has_process(die) else None
    if statistics is not None:
        given = {**statistics.switches, **shared_numbers(mapping, die)}
        lines += [f".param {name}={value!r}" for name, value in given.items()]
        lines += [f".param {name}={text}" for name, text in expressions(mapping).items()]
    corner = TYPICAL if die.corner == "random" else die.corner
    for polarity in POLARITIES:
        sizes = {(d.width / _fingers(d, mapping), d.length) for d in used if d.polarity == polarity}
        if sizes:
            section = None if statistics is None else statistics.cards[polarity]
            cards = read_cards(mapping, polarity, corner, section)
            lines += choose_cards(cards, mapping, polarity, sizes).splitlines()
    return lines


def _definition(definition: Definition, mapping: DeviceMapping, silicon: Silicon) -> list[str]:
    name = node_name(definition.name)
    lines = [f".subckt {name} {' '.join(map(node_name, definition.ports))}"]
    for device, deviation in definition.devices:
        lines += _device(device, deviation, mapping, silicon)
    for call in itertools.chain.from_iterable(definition.calls):
        called = node_name(element(call.name, call.index))
        nodes = " ".join(map(node_name, call.nodes))
        lines.append(f"x{called} {nodes} {node_name(call.definition)}")
    return [*lines, f".ends {name}"]


def _device(
    device: Device, deviation: Deviation | Change, mapping: DeviceMapping, silicon: Silicon
) -> list[str]:
    if isinstance(device, Transistor) and isinstance(deviation, Deviation):
        if silicon.die.number is None:
            return [format_transistor(device, mapping)]
        return [format_transistor(device, mapping, own_deviation(mapping, silicon, device, deviation))]
    return format_device(as_made(device, deviation)[0], silicon)
