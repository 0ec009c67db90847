"""Devices of a neuron or of a circuit on a die, and what deviates in them, as a page shows them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.circuit import Circuit
from circuits.devices import Transistor
from circuits.lowering.graph import describe_device
from circuits.lowering.kernel import Machine
from circuits.lowering.made import change_of, kind_of
from circuits.lowering.on_die import Fet, on_die, transistor_of
from circuits.silicon.die import Path
from circuits.silicon.passive import QUANTITY
from circuits.silicon.silicon import Silicon
from circuits.units import format_quantity
from system.view.film import Device

_UNITS = {
    "capacitance": "F", "offset": "V", "output_resistance": "Ohm", "resistance": "Ohm",
    "transconductance": "S",
}  # fmt: skip


def devices_of(circuit: Circuit, silicon: Silicon, place: Path = (), at: int = 0) -> tuple[Device, ...]:
    """Return the transistors of a circuit at one of its places on a chip, those that deviate most first.

    Parameters
    ----------
    circuit
        The circuit, as a neuron.
    silicon
        Process, temperature and die.
    place
        Where its copies stand: the chip, then the array with its shape, as `on_die` takes it.
    at
        Which of the copies, counted in the order of their places.
    """
    d = on_die(circuit, replace(silicon, place=place[:1] or None), place=place)
    below = "".join(f"{name}." if not shape else f"{name}[{at}]." for name, shape in place[1:])
    found = [_device(f"{below}{name}", name, fet, at, circuit, silicon) for name, fet in d.fet.items()]
    return tuple(sorted(found, key=lambda one: (-one.sigma, one.path)))


def devices_in(machine: Machine) -> dict[str, Device]:
    """Return every device of a circuit on its silicon by its path, with what deviates in it."""
    nets = _nets(machine)
    found = (*_transistors(machine), *_passives(machine))
    return {one.path: replace(one, what=f"{one.what}; {nets[one.path]}") for one in found}


def _nets(machine: Machine) -> dict[str, str]:
    """What each terminal of each device is on, by the device's path."""
    return {
        group.label(k): ", ".join(
            f"{terminal} {machine.names[n]}"
            for terminal, n in zip(describe_device(group.device).terminals, group.nodes[:, k], strict=True)
        )
        for group in machine.flat.groups
        for k in range(group.nodes.shape[1])
    }


def _transistors(machine: Machine) -> Iterator[Device]:
    silicon, flat = machine.silicon, machine.flat
    groups = [(g, g.device) for g in flat.groups if isinstance(g.device, Transistor)]
    size = {
        name: np.concatenate([np.zeros(0), *(g.parameters[name] for g, _ in groups)])
        for name in ("width", "length", "multiplicity")
    }
    size["width"] *= size.pop("multiplicity")
    paths = [(*g.path, (d.name, ())) for g, d in groups]
    area = size["width"] * size["length"]
    local = silicon.deviations(flat.circuit.name, paths, area, [d.polarity for _, d in groups])
    v_t0, beta = (np.broadcast_to(x, area.shape) for x in local)
    named = [(g.label(k), d.polarity) for g, d in groups for k in range(g.nodes.shape[1])]
    for k, (path, polarity) in enumerate(named):
        numbers = (float(x[k]) for x in (size["width"], size["length"], v_t0, beta))
        yield _transistor(path, polarity, *numbers, silicon=silicon)


def _passives(machine: Machine) -> Iterator[Device]:
    for group in machine.flat.groups:
        if isinstance(group.device, Transistor):
            continue
        kind = kind_of(group.device)
        change: F64 | float = 0.0
        if kind is not None:
            change = change_of(group, kind, machine.flat.circuit.name, machine.silicon).value
        for k in range(group.nodes.shape[1]):
            numbers = {name: float(x[k]) for name, x in group.parameters.items()}
            sizes = [f"{name} {format_quantity(x, _UNITS.get(name, ''))}" for name, x in numbers.items()]
            own = 100.0 * float(np.broadcast_to(change, group.nodes.shape[1:])[k])
            told = "" if kind is None else f"{QUANTITY[kind]} {own:+.2f} %"
            what = ", ".join([describe_device(group.device).type, *sizes])
            yield Device(path=group.label(k), what=what, deviation=told, sigma=0.0)


def _device(path: str, name: str, fet: Fet, at: int, circuit: Circuit, silicon: Silicon) -> Device:
    numbers = (
        float(np.broadcast_to(x, fet.v_t0.shape).reshape(-1)[at])
        for x in (fet.width, fet.length, fet.v_t0, fet.beta)
    )
    return _transistor(path, transistor_of(circuit, name).polarity, *numbers, silicon=silicon)


def _transistor(
    path: str, polarity: str, width: float, length: float, volts: float, beta: float, *, silicon: Silicon
) -> Device:
    """A transistor of a width (of all its devices) and a length (m) with its own deviations (V, relative)."""
    root, process = math.sqrt(2.0 * width * length), silicon.process
    pairs = (volts, process.pair_a_vt), (beta, process.pair_a_beta)
    return Device(
        path=path,
        what=f"{polarity}FET {1e6 * width:.3g}/{1e6 * length:.3g} um",
        deviation=f"V_T0 {1e3 * volts:+.2f} mV, beta {100.0 * beta:+.2f} %",
        sigma=max((abs(value) * root / scale for value, scale in pairs if scale > 0.0), default=0.0),
    )
