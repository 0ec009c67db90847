"""Part of a chip as it is at its place there, so that it can be simulated by itself.

A circuit that is taken out of its chip has to know three things to behave as it does inside: its place, which
decides the deviations of its devices on a die; the chip's biases at the nodes that its own bias ports are
connected to, including where the copies of ideal biases stand; and the parameters that its instance sets.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from circuits.circuit import Bias, Circuit, Instance, InstanceArray, Shape, split_reference
from circuits.errors import UnknownNameError, unknown_name
from circuits.silicon.die import Place


def circuit_at(chip: Circuit, path: Sequence[tuple[str, Shape]]) -> tuple[Circuit, Place]:
    """The circuit at `path` below `chip`, with its biases there, and its place on the chip.

    Raises `UnknownNameError` for an instance or an index that the chip does not have.

    Parameters
    ----------
    path
        Where the circuit stands, ((instance, index), ...). A bias port that the chip's own circuits drive
        keeps the bias of the lone circuit.
    """
    circuit = chip
    place: Place = ((chip.name, ()),)
    for name, index in path:
        instance = _instance(circuit, name, index)
        part = instance.circuit
        for key, values in instance.parameters.items():
            value = np.broadcast_to(np.asarray(values, dtype=np.float64), instance.shape)[index]
            part = _with_parameter(part, key, float(value))
        biases = tuple(_bias_there(bias, circuit, place, instance, index) for bias in part.biases)
        circuit, place = replace(part, biases=biases), (*place, (name, index))
    return circuit, place


def instance_names(circuit: Circuit) -> list[str]:
    """Names of a circuit's instances with the range of their indices, such as `neuron[0:13]`."""
    return [
        i.name + (f"[{','.join(f'0:{n}' for n in i.shape)}]" if i.shape else "") for i in circuit.instances
    ]


def _instance(circuit: Circuit, name: str, index: Shape) -> Instance | InstanceArray:
    for instance in circuit.instances:
        fits = len(index) == len(instance.shape) and all(
            i < n for i, n in zip(index, instance.shape, strict=False)
        )
        if instance.name == name and fits:
            return instance
    label = name + (f"[{','.join(map(str, index))}]" if index else "")
    known = instance_names(circuit)
    if not known:
        raise UnknownNameError(f"{circuit.name} instance {label}: unknown; it has no instances")
    raise unknown_name(f"{circuit.name} instance", label, known)


def _bias_there(
    bias: Bias, outer: Circuit, place: Place, instance: Instance | InstanceArray, index: Shape
) -> Bias:
    """The outer circuit's bias at the node that the port is connected to, for the inner device."""
    name, element = _node(outer, instance, bias.port, index)
    for above in outer.biases:
        if above.port == name:
            value = np.broadcast_to(np.asarray(above.value, dtype=np.float64), outer.port(name).shape)
            return replace(
                above,
                name=bias.name,
                port=bias.port,
                value=float(value[element]),
                device=bias.device,
                place=above.place or (*place, *bias_path(above.port, element)),
            )
    return bias


def bias_path(port: str, index: Shape) -> Place:
    """Path of an ideal bias's copy for an element of a port.

    Its name contains a space, so that it cannot be the name of an instance.
    """
    return ("bias copy", ()), (port, index)


def chip_and_line(place: Place) -> tuple[Place, tuple[str, Shape]]:
    """The chip on which a bias's copy stands, and the port and the element that it is for."""
    return place[: -len(bias_path("", ()))], place[-1]


def _node(outer: Circuit, instance: Instance | InstanceArray, port: str, index: Shape) -> tuple[str, Shape]:
    """Name and index of the outer node that a scalar port of one element of an instance is connected to."""
    name, element = split_reference(instance.connections[port])
    shape = outer.shapes().get(name, ())
    if element or not shape:
        return name, element
    numbers = np.arange(np.prod(shape)).reshape(shape)
    chosen = np.broadcast_to(numbers, instance.shape)[index]
    return name, tuple(int(i) for i in np.unravel_index(int(chosen), shape))


def _with_parameter(circuit: Circuit, key: str, value: float) -> Circuit:
    """Set `device.attribute`, dotted through instances."""
    head, _, rest = key.partition(".")
    known = [*(d.name for d in circuit.devices), *(i.name for i in circuit.instances)]
    if head not in known:
        raise unknown_name(f"{circuit.name} parameter of", head, known)
    devices = tuple(_changed(d, rest, value) if d.name == head else d for d in circuit.devices)
    instances = tuple(
        replace(i, parameters=_without(i.parameters, rest), circuit=_with_parameter(i.circuit, rest, value))
        if i.name == head
        else i
        for i in circuit.instances
    )
    return replace(circuit, devices=devices, instances=instances)


def _changed(device: Any, attribute: str, value: float) -> Any:
    return replace(device, **{attribute: value})


def _without(parameters: Mapping[str, Any], key: str) -> dict[str, Any]:
    """An outer value replaces an inner one."""
    return {k: v for k, v in parameters.items() if k != key}
