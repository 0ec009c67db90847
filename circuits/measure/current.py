"""Currents of devices and sources by name, over the points of a run or of a sweep.

    transistor         channel current into the drain; negative for a conducting pFET
    resistor           (v_a - v_b) / R, from a to b
    controlled source  g (v_cp - v_cn), from `positive` to `negative`
    capacitor          C d(v_a - v_b)/dt, from a to b
    diode              that of its junction and of its charge, from anode to cathode
    source             of voltage: out of the circuit into the source, so that a supply that gives has a
                       negative one, as in SPICE; of current: what it gives into its node

The derivative at a point is the solver's own (`circuits.solver.integrate`), so that Kirchhoff's law holds as
it does in the run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from circuits.arrays import F64, Bools
from circuits.devices import Capacitor, ControlledSource, Diode, Resistor, Transistor
from circuits.devices.device import Device
from circuits.devices.diode import diode_course
from circuits.errors import unknown_name
from circuits.lowering.flatten import DeviceGroup
from circuits.lowering.kernel import Machine
from circuits.lowering.made import made
from circuits.solver.power import conduction_and_channels, linear

_OTHERS: tuple[type[Device], ...] = (Resistor, ControlledSource, Capacitor, Diode)  # with a current by name


def current_in(text: str) -> str | None:
    """Return the name in `i(NAME)`, None of another text, as of a node."""
    return text[2:-1] if text.startswith("i(") and text.endswith(")") else None


def current_names(machine: Machine) -> tuple[str, ...]:
    """Names of devices and sources whose currents are known: devices by path, then sources by name.

    A source that is called as a device is not among them.
    """
    devices = [
        *machine.flat.labels(Transistor),
        *(name for kind in _OTHERS for name in machine.flat.labels(kind)),
    ]
    return tuple(dict.fromkeys((*devices, *machine.source_names)))


def device_current(
    machine: Machine,
    v: F64,
    time: F64,
    kink: Bools,
    name: str,
    conducted: Callable[[], tuple[F64, F64]] | None = None,
) -> F64:
    """Current of one device or source over a run, float64[T], A.

    Parameters
    ----------
    machine
        The circuit.
    v
        Its vector of voltages at each point, float64[T, columns], V.
    time
        The points, float64[T], s.
    kink
        Where the solver began anew, bool[T].
    name
        Path of a device, or name of a source.
    conducted
        Gives what `circuits.solver.power.conduction_and_channels` does, of a run of which more is asked.

    Raises
    ------
    UnknownNameError
        There is no such device or source.
    """
    conducted = conducted or (lambda: conduction_and_channels(machine, v))
    labels = machine.flat.labels(Transistor)
    if name in labels:
        return conducted()[0][:, labels.index(name)]
    for label, group, k in _devices(machine):
        if label == name:
            return _of_other(machine, group, k, v, time, kink)
    if name not in machine.source_names:
        raise unknown_name(f"{machine.flat.circuit.name} device or source", name, current_names(machine))
    own = machine.source_names.index(name)
    if machine.source_quantities[own] == "current":
        return _given(machine, own, time)
    column = machine.kernel.unknowns + own
    charge = linear(machine.source_charge, column, v, np.zeros(len(v)))
    return -(conducted()[1][:, column] + rate(time, charge, kink))


def static_currents(machine: Machine, v: F64) -> dict[str, F64]:
    """Current of every device and source at operating points, float64[N], A; those of capacitors are 0.

    v: the vector of voltages at each point, float64[N, columns], V, values of sources of current included.
    """
    return _every(machine, v, np.zeros(1), np.ones(1, np.bool_))


def course_currents(machine: Machine, v: F64, time: F64, kink: Bools) -> dict[str, F64]:
    """Current of every device and source over a run, float64[T], A; all at once, as `device_current` each.

    v: the vector of voltages at each point, float64[T, columns], V; time: the points, float64[T], s; kink:
    where the solver began anew, bool[T].
    """
    found = _every(machine, v, time, kink)
    devices = {label for label, _, _ in _devices(machine)} | set(machine.flat.labels(Transistor))
    for s, name in enumerate(machine.source_names):
        if name in devices:
            continue
        if machine.source_quantities[s] == "current":
            found[name] = _given(machine, s, time)
        else:
            column = machine.kernel.unknowns + s
            charge = linear(machine.source_charge, column, v, np.zeros(len(v)))
            found[name] = found[name] - rate(time, charge, kink)
    return found


def _every(machine: Machine, v: F64, time: F64, kink: Bools) -> dict[str, F64]:
    """Current of every device and source by name, without what charges the nodes of sources."""
    channels, at_sources = conduction_and_channels(machine, v)
    found = {name: channels[:, k] for k, name in enumerate(machine.flat.labels(Transistor))}
    for label, group, k in _devices(machine):
        found[label] = _of_other(machine, group, k, v, time, kink)
    for s, name in enumerate(machine.source_names):
        column = machine.kernel.unknowns + s
        voltage = machine.source_quantities[s] == "voltage"
        found.setdefault(name, -at_sources[:, column] if voltage else v[:, column].copy())
    return found


def rate(time: F64, value: F64, kink: Bools) -> F64:
    """Derivative of a waveform at its points as the solver has it: backward, by the parabola behind each."""
    step = np.diff(time)
    slope = np.divide(np.diff(value), step, out=np.zeros_like(step), where=step > 0.0)
    bend = np.zeros_like(slope)
    both = step[1:] + step[:-1]
    bend[1:] = np.divide(np.diff(slope), both, out=np.zeros_like(both), where=(both > 0.0) & ~kink[1:-1])
    backward = slope + step * bend
    return np.concatenate([slope[:1], backward]) if step.size else np.zeros_like(value)


def _devices(machine: Machine) -> Iterator[tuple[str, DeviceGroup, int]]:
    for group in machine.flat.groups:
        if isinstance(group.device, _OTHERS):
            for k in range(group.nodes.shape[1]):
                yield group.label(k), group, k


def _of_other(machine: Machine, group: DeviceGroup, k: int, v: F64, time: F64, kink: Bools) -> F64:
    """Current of copy k of a device that is no transistor; a single time stands for a circuit at rest."""
    nodes = machine.column[group.nodes[:, k]]
    if isinstance(group.device, ControlledSource):
        return np.asarray(group.parameters["transconductance"][k] * (v[:, nodes[2]] - v[:, nodes[3]]))
    if isinstance(group.device, Diode):
        return _of_diode(machine, group, k, v, time, kink)
    drop = v[:, nodes[0]] - v[:, nodes[1]]
    value = np.broadcast_to(made(group, machine.flat.circuit.name, machine.silicon), group.nodes.shape[1:])[k]
    if isinstance(group.device, Resistor):
        return np.asarray(drop / value)
    return np.asarray(value * rate(time, drop, kink)) if time.size > 1 else np.zeros(len(v))


def _of_diode(machine: Machine, group: DeviceGroup, k: int, v: F64, time: F64, kink: Bools) -> F64:
    own = machine.flat.labels(Diode).index(group.label(k))
    found = np.empty((2, len(v)))
    current, slope = np.empty((2, 2, machine.kernel.diodes.saturation.size))
    diode_course(machine.kernel.diodes, v, own, current, slope, found)
    return np.asarray(found[0] + rate(time, found[1], kink)) if time.size > 1 else found[0].copy()


def _given(machine: Machine, source: int, time: F64) -> F64:
    times, values = machine.polylines[source]
    return np.asarray(np.interp(time, times, values))
