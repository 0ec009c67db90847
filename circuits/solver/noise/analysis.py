"""Noise about an operating point: density at a node, by device, referred to a source, and integrated.

Every noise current between two nodes reaches the output through the transfer of its own place; one solve of
the transposed circuit a frequency gives all of them. Devices' noises are independent:

    S_out(f) = sum_k |Z_k(f)|^2 S_k(f),   S_k(f) = white_k + flicker_k / f^AF,

and what a source would have to make for the same is S_out / |H|^2. Integrals take the density as a power of
frequency between two neighbouring points, as ngspice does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import singledispatch
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.circuit import GROUND
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.diode import Diode
from circuits.devices.noise import (
    NoiseModel,
    channel_noise,
    diode_noise,
    gate_flicker,
    junction_noise,
    noise_model,
    resistor_noise,
)
from circuits.errors import ParameterError
from circuits.lowering.flatten import DeviceGroup
from circuits.lowering.made import made
from circuits.silicon.process import kelvin
from circuits.solver.newton import allocate, evaluate
from circuits.solver.operating_point import OperatingPoint
from circuits.solver.small_signal import ac, linearise, transistors_at


class NoiseSources(NamedTuple):
    """Noise currents of a circuit at an operating point, n of them.

    device: instance paths. kind: `channel`, `junction`, `diode` or `resistor`. start, end: int64[n], columns
    of the vector of voltages between which a current flows. white: float64[n], A^2/Hz. flicker:
    float64[n], A^2/Hz at 1 Hz.
    """

    device: tuple[str, ...]
    kind: tuple[str, ...]
    start: I64
    end: I64
    white: F64
    flicker: F64


@dataclass(frozen=True, slots=True)
class Noise:
    """Noise at a node over frequency.

    Attributes
    ----------
    node : str
        Path of the node; `v(NODE,REFERENCE)` between two.
    source : str or None
        Name of the source that noise is referred to, if any.
    unit : str
        Unit of the noise that is referred to it: `V^2/Hz`, or `A^2/Hz` for a source of current.
    devices : tuple of str
        Paths of the devices that make noise.
    frequency : array
        Frequencies, float64[F], Hz.
    white, flicker : array
        Density at the node by device, float64[F, devices], V^2/Hz.
    gain : array or None
        Magnitude of the transfer from `source` to the node, float64[F], V/V or V/A; None without a source.
    """

    node: str
    source: str | None
    unit: str
    devices: tuple[str, ...]
    frequency: F64
    white: F64 = field(repr=False)
    flicker: F64 = field(repr=False)
    gain: F64 | None = field(repr=False)

    @property
    def output(self) -> F64:
        """Density of the noise at the node, float64[F], V^2/Hz."""
        return np.asarray((self.white + self.flicker).sum(axis=1))

    @property
    def referred(self) -> F64 | None:
        """Density that the source would have to make for the same noise, float64[F]; None without a source.

        In V^2/Hz for a source of voltage, and in A^2/Hz for one of current.
        """
        return None if self.gain is None else self.output / self.gain**2

    @property
    def variance(self) -> float:
        """Noise at the node integrated over the frequencies, V^2."""
        return integrate_power(self.frequency, self.output)

    def shares(self) -> dict[str, tuple[float, float]]:
        """Integrated white and flicker noise of each device, V^2, the noisiest device first."""
        parts = {
            name: (
                integrate_power(self.frequency, self.white[:, k]),
                integrate_power(self.frequency, self.flicker[:, k]),
            )
            for k, name in enumerate(self.devices)
        }
        return dict(sorted(parts.items(), key=lambda item: -sum(item[1])))


def noise(
    point: OperatingPoint,
    node: str,
    frequency: F64,
    source: str | None = None,
    model: NoiseModel | None = None,
    reference: str | None = None,
) -> Noise:
    """Noise at a node, or between two nodes, over frequency.

    Parameters
    ----------
    point
        Operating point.
    node
        Path of the output; one that no source fixes.
    frequency
        float64[F], Hz.
    source
        Source to which the noise is referred, if any.
    model
        Flicker; the process's own unless given.
    reference
        Path of the node that the output is taken against; ground unless given.

    Raises
    ------
    ParameterError
        A source fixes the node, or both nodes, or these are one.
    UnknownNameError
        No such node or source.
    """
    machine = point.machine
    k = machine.kernel
    ends = {machine.column_of(end): sign for end, sign in ((reference, -1.0), (node, 1.0)) if end is not None}
    free = {column: sign for column, sign in ends.items() if column < k.unknowns}
    if not free:
        raise ParameterError(f"{node}: fixed by a source, must be a node of its own; name another output")
    if reference is not None and len(ends) < 2:
        raise ParameterError(f"{node}: against {reference}, which is the same node; name another")
    model = model or noise_model(machine.silicon.process)
    found = noise_sources(point, model)
    pick = np.zeros(k.unknowns, dtype=complex)
    pick[list(free)] = list(free.values())
    power = np.zeros((frequency.size, found.start.size))
    paths = np.zeros(k.columns, dtype=complex)
    for row, factors in zip(power, linearise(point).admittances(frequency), strict=True):
        paths[: k.unknowns] = factors.solve(pick, trans="T")
        row[:] = np.abs(paths[found.start] - paths[found.end]) ** 2
    names, owner = owners(found.device)
    gain, unit = None, "V^2/Hz"
    if source is not None:
        response = ac(point, source, frequency, (node, reference or GROUND))
        gain = np.abs(response.transfer[:, 0] - response.transfer[:, 1])
        unit = "V^2/Hz" if response.unit == "V/V" else "A^2/Hz"
    per_hertz = frequency[:, None] ** -model.exponent
    label = node if reference is None else f"v({node},{reference})"
    return Noise(
        label, source, unit, names, frequency, summed(power * found.white, owner, len(names)),
        summed(power * found.flicker * per_hertz, owner, len(names)), gain,
    )  # fmt: skip


def noise_sources(point: OperatingPoint, model: NoiseModel | None = None) -> NoiseSources:
    """All noise currents of the circuit at `point`; flicker by `model`, the process's own unless given."""
    machine = point.machine
    model = model or noise_model(machine.silicon.process)
    parts = [_none()]
    parts += [noise_of(g.device, g, point) for g in machine.flat.groups]
    parts.append(_transistors(point, model))
    return NoiseSources(
        tuple(n for part in parts for n in part.device),
        tuple(n for part in parts for n in part.kind),
        *(np.concatenate([part[j] for part in parts]) for j in range(2, 6)),
    )


@singledispatch
def noise_of(device: Device, group: DeviceGroup, point: OperatingPoint) -> NoiseSources:
    """Noise currents of a group of devices; those of transistors come from one call for all of them."""
    raise TypeError(f"{type(device).__name__}: no noise")


@noise_of.register(Capacitor)
@noise_of.register(ControlledSource)
@noise_of.register(OperationalAmplifier)
@noise_of.register(Source)
@noise_of.register(Transistor)
def _(device: Device, group: DeviceGroup, point: OperatingPoint) -> NoiseSources:
    return _none()


@noise_of.register
def _(device: Resistor, group: DeviceGroup, point: OperatingPoint) -> NoiseSources:
    machine = point.machine
    start, end = machine.column[group.nodes]
    resistance = made(group, machine.flat.circuit.name, machine.silicon)
    white = resistor_noise(resistance, kelvin(machine.silicon.temperature_c))
    labels = tuple(group.label(k) for k in range(start.size))
    return NoiseSources(labels, ("resistor",) * start.size, start, end, white, np.zeros(start.size))


@noise_of.register
def _(device: Diode, group: DeviceGroup, point: OperatingPoint) -> NoiseSources:
    machine = point.machine
    groups = [g for g in machine.flat.groups if isinstance(g.device, Diode)]
    before = sum(g.nodes.shape[1] for g in groups[: next(i for i, g in enumerate(groups) if g is group)])
    start, end = machine.column[group.nodes]
    work = allocate(machine.kernel)
    evaluate(machine.kernel, point.voltage, work)
    white = np.empty(start.size)
    diode_noise(work.diode_current[0, before : before + start.size], white)
    labels = tuple(group.label(k) for k in range(start.size))
    return NoiseSources(labels, ("diode",) * start.size, start, end, white, np.zeros(start.size))


def integrate_power(frequency: F64, density: F64) -> float:
    """Integral of a density over frequency, as a power of frequency between two points.

    frequency: float64[F], Hz. density: float64[F].
    """
    if frequency.size < 2:
        return 0.0
    low, high, ratio = frequency[:-1], frequency[1:], np.log(frequency[1:] / frequency[:-1])
    first, last = density[:-1], density[1:]
    whole = (first > 0.0) & (last > 0.0)
    slope = np.log(np.where(whole, last, 1.0) / np.where(whole, first, 1.0)) / ratio + 1.0
    # (e^x - 1) / x with x = slope * ratio, whose limit for a density like 1/f is 1
    x = slope * ratio
    grown = np.divide(np.expm1(x), x, out=np.ones_like(x), where=np.abs(x) > 1e-9)
    straight = 0.5 * (first + last) * (high - low)
    return float(np.where(whole, first * low * ratio * grown, straight).sum())


def kernel_order(found: NoiseSources) -> I64:
    """Order in which the noises that a state moves come first: channels, junctions, diodes; int64[n]."""
    rank = {"diode": 1, "resistor": 2}
    return np.argsort([rank.get(kind, 0) for kind in found.kind], kind="stable")


def transistor_areas(point: OperatingPoint) -> F64:
    """Gate area m W L of all transistors in the kernel's order, float64[n], m^2."""
    groups = [g.parameters for g in point.machine.flat.groups if isinstance(g.device, Transistor)]
    areas = [p["multiplicity"] * p["width"] * p["length"] for p in groups]
    return np.concatenate([np.zeros(0), *areas])


def _transistors(point: OperatingPoint, model: NoiseModel) -> NoiseSources:
    machine = point.machine
    a, w = machine.kernel.transistors, transistors_at(point)
    n = a.sign.size
    white = np.zeros(n)
    channel_noise(a, w, white)
    at_gate = gate_flicker(model, machine.silicon.process, a.sign > 0.0, transistor_areas(point))
    labels = tuple(machine.flat.labels(Transistor))
    drain, _, source, bulk = a.terminal.astype(np.int64)
    channels = NoiseSources(labels, ("channel",) * n, drain, source, white, at_gate * w.conductance[1] ** 2)
    if not a.leaks:
        return channels
    shot = np.zeros(2 * n)
    junction_noise(a, w, shot)
    return NoiseSources(
        labels * 3,
        (*channels.kind, *("junction",) * (2 * n)),
        np.concatenate([drain, drain, source]),
        np.concatenate([source, bulk, bulk]),
        np.concatenate([white, shot]),
        np.concatenate([channels.flicker, np.zeros(2 * n)]),
    )


def _none() -> NoiseSources:
    nothing = np.zeros(0, np.int64)
    return NoiseSources((), (), nothing, nothing, np.zeros(0), np.zeros(0))


def owners(device: Sequence[str]) -> tuple[tuple[str, ...], I64]:
    """Names of the devices once each, and whose each noise current is."""
    names = tuple(dict.fromkeys(device))
    index = {name: k for k, name in enumerate(names)}
    return names, np.array([index[d] for d in device], dtype=np.int64)


def summed(power: F64, owner: I64, count: int) -> F64:
    """Sum of the columns that belong to one device."""
    total = np.zeros((power.shape[0], count))
    np.add.at(total.T, owner, power.T)
    return total
