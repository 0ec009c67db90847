"""Transistors as they are on a die: the one way from silicon to a behavioural model.

    d = on_die(circuit, silicon, wanted, place)

gives the transistors of `circuit` called `wanted` (`membrane.m1`: names of instances, then the device's), as
the transistor level has the same devices at the same place: size and polarity are read from the circuit,
V_T0 and beta deviate as the die says (`circuits.silicon.die`). A model never draws and never adds up areas.

`place` is ((name, shape), ...) from the chip's name on: `(("sonar_head", ()), ("lso", (2,)))` are the two
circuits `lso` of that chip. A circuit without a place stands by itself under its own name, and a silicon that
has a place (`Silicon.place`) has it instead of the first name. Every array is float64 of the shapes of the
place and of the instance arrays inside the circuit, one after the other: () for a lone device, (2,) above.

What a model asks then:

| | |
|---|---|
| `d.saturated(device, gate)` | current with the drain far, no Early effect in it: `I_S F(v_p / U_T) M` |
| `d.channel(device, gate, drain)` | channel current with the source at the bulk and the drain at a voltage |
| `d.current(device, gate, drain, source)` | current into the drain between any voltages, its junction's too |
| `d.terms(device)` | the numbers that kernels call the law with (`circuits.devices.channel`) |
| `d.weak(device, gate)` | what weak inversion alone makes of the saturated current: `I_S e^(v_p / U_T)` |
| `d.pinch(device, gate)` | `v_p / U_T`, with constant kappa `kappa (v_g - V_T0) / U_T` |
| `d.gate_for(device, current)` | the gate that gives a saturated current: the inverse of `saturated` |
| `d.mirror(diode, copy)` | what a copy carries of its diode's current (`Mirror`) |
| `d.offset(*devices)` | local deviations, for a record's gradients: V_T0 and ln beta of each device in turn |
| `d.inverter_threshold(inverter)` | the input at which an inverter turns |
| `d.fet[device]` | specific current, threshold and kappa themselves |

Voltages of a pFET count from the supply down. The law is the process's, with the second-order effects that it
states. `d.full` says whether it states any: without them an answer is the closed form of constant kappa. What
is a ratio of weak inversion alone (`weak`, `Mirror.weak`) has no Early effect and no mobility reduction.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple, TypeVar

import numpy as np

from circuits.arrays import F64, I64
from circuits.bias import bias_voltages
from circuits.circuit import Circuit, Instance, InstanceArray, Shape
from circuits.compiled import compiled
from circuits.devices import Device, Transistor
from circuits.devices.channel import Terms, early, height_of, mobility, pinch_off_of, terms_of
from circuits.devices.ekv import argument, interpolation
from circuits.devices.packable import even_channel, even_interpolation, even_leaked, interpolation_of
from circuits.devices.pinch_off import pinch_off
from circuits.errors import ParameterError, unknown_name
from circuits.silicon.die import Path
from circuits.silicon.process import POLARITIES, TransistorAtTemperature
from circuits.silicon.silicon import Silicon

_BISECTIONS = 60
_TOGETHER = 256  # inverters whose bounds are halved together
_STEP = 1e-3  # V, of a derivative by the gate; ours
_ROUNDS, _ROUNDING = 200, 1e-14  # of a gate voltage: each round leaves less than half of the error; ours

V = TypeVar("V")  # what names stand for


class Fet(NamedTuple):
    """A transistor at all its places on a die.

    current: specific current I_S, A. threshold: V_T0, V. v_t0, beta: local deviations from what the die
    shares, V of the magnitude and relative. kappa: that of its polarity, at v_p = 0 where it follows v_p.
    width, length: its size, m, the width that of all its devices. law: what its polarity shares on the die.
    """

    current: F64
    threshold: F64
    kappa: float
    v_t0: F64
    beta: F64
    width: F64
    length: F64
    law: TransistorAtTemperature

    def each(self, made: Callable[[F64], F64]) -> Fet:
        """The transistor whose arrays are what `made` makes of these."""
        return Fet(
            made(self.current), made(self.threshold), self.kappa, made(self.v_t0), made(self.beta),
            made(self.width), made(self.length), self.law,
        )  # fmt: skip

    def gate_for(self, current: F64 | float, *, diode: bool = False) -> F64:
        """Gate voltage (V over the bulk) that makes its saturated channel carry `current`, A above zero.

        diode: whether the drain is at the gate, which decides the Early effect; there is none of it unless
        asked. A current below that of flat band is given the gate of flat band.
        """
        flat = np.asarray(current, dtype=np.float64)
        without, gate = np.broadcast_to(flat, np.broadcast(flat, self.current).shape), flat
        for _ in range(_ROUNDS):
            inversion, before = without / self.current, without
            v_p = self.law.u_t * argument(inversion)
            gate = self.threshold + height_of(self.law, v_p)
            effect = mobility(self.law, v_p)
            if diode:
                effect = effect * early(self.law, self.length, np.maximum(gate, 0.0), np.sqrt(inversion))
            without = flat / effect
            if np.all(np.abs(without - before) <= _ROUNDING * before):
                break
        return np.asarray(gate)


class Mirror(NamedTuple):
    """A current mirror in saturation: the specific currents (A) of its input and output devices.

    shift: `(v_p,out - v_p,in) / 2 U_T` at one gate voltage, of weak inversion where kappa follows v_p. pair:
    both devices, where their law has second-order effects.
    """

    given: F64 | float
    taken: F64 | float
    shift: F64 | float
    pair: tuple[Fet, Fet] | None = None

    def copied(self, current: F64) -> F64:
        """What the copy carries of a current (A) above zero, A, in the shape to which both broadcast.

        Of the Early effect there is that of the diode, whose drain is at its gate, and none in the copy: it
        follows where the copy's drain is (`DieDevices.current`).
        """
        if self.pair is not None:
            diode, copy = self.pair
            return _saturated(copy, diode.gate_for(current, diode=True))
        return np.asarray(self.taken * interpolation(argument(current / self.given) + 2.0 * self.shift))

    def needed(self, current: F64) -> F64:
        """The current into the diode, A, of which the copy makes `current` (A, above zero)."""
        if self.pair is not None:
            diode, copy = self.pair
            gate = copy.gate_for(current)
            carried = _saturated(diode, gate)
            root = np.sqrt(interpolation(pinch_off_of(diode.law, gate - diode.threshold) / diode.law.u_t))
            return np.asarray(carried * early(diode.law, diode.length, np.maximum(gate, 0.0), root))
        return np.asarray(self.given * interpolation(argument(current / self.taken) - 2.0 * self.shift))

    @property
    def weak(self) -> F64:
        """Current out over current in where both devices are in weak inversion."""
        return np.asarray(self.taken / self.given * np.exp(2.0 * self.shift))


class DieDevices(NamedTuple):
    """Transistors of a circuit on a die, and what a behavioural model asks of them; see the module.

    u_t: thermal voltage, V. v_dd: supply, V. copies: how many places the circuit has. fet: each transistor by
    its name. gate: voltages (V) of bias lines by port, where they were given. more: what each capacitor has
    beyond what is drawn, F, by its name, where the die's capacitors deviate
    (`circuits.lowering.capacitors_on_die.with_capacitors`).
    """

    u_t: float
    v_dd: float
    copies: int
    fet: Mapping[str, Fet]
    gate: Mapping[str, F64]
    more: Mapping[str, F64] | None = None

    def added(self, capacitor: str) -> F64 | float:
        """What a capacitor has beyond what is drawn, F: 0 where the die's capacitors do not deviate."""
        return 0.0 if self.more is None else self.more[capacitor]

    @property
    def full(self) -> bool:
        """Whether the law of any transistor has second-order effects."""
        laws = {id(fet.law): fet.law for fet in self.fet.values()}  # a polarity's devices share theirs
        return any(map(_has_effects, laws.values()))

    def terms(self, device: str) -> Terms:
        """Numbers of a device that stands alone, as kernels take them; those of arrays go by `current`."""
        fet = self.fet[device]
        width, length, current, threshold = (
            float(np.ravel(x)[0]) for x in (fet.width, fet.length, fet.current, fet.threshold)
        )
        return terms_of(fet.law, width, length, current, threshold)

    def pinch(self, device: str, gate: F64 | float) -> F64:
        """`v_p / U_T`, gate: V above the bulk (below it for a pFET)."""
        fet = self.fet[device]
        if fet.law.gamma == 0.0:
            return pinch_off(fet.kappa, gate, fet.threshold) / self.u_t
        return np.asarray(pinch_off_of(fet.law, np.asarray(gate) - fet.threshold) / self.u_t)

    def below(self, port: str) -> F64:
        """Bias voltage of a pFET's gate, counted from the supply down, V."""
        return self.v_dd - self.gate[port]

    def saturated(self, device: str, gate: F64 | float, source: F64 | float = 0.0) -> F64:
        """Current with the drain far, A: `I_S F((v_p - v_s) / U_T) M`; the Early effect is left out.

        gate, source: V above the bulk (below it for a pFET); the source is at the bulk unless given.
        """
        fet, pinch = self.fet[device], self.pinch(device, gate)
        carried = fet.current * interpolation_of(pinch - source / self.u_t)
        return np.asarray(
            carried * mobility(fet.law, pinch * self.u_t) if fet.law.mobility_reduction else carried
        )

    def current(self, device: str, gate: F64 | float, drain: F64 | float, source: F64 | float = 0.0) -> F64:
        """Current into the drain, A, of the channel and of the drain's junction, by the whole law.

        gate, drain, source: V above the bulk (below it for a pFET), of shapes that broadcast with the
        device's; the source is at the bulk unless given.
        """
        fet = self.fet[device]
        numbers = (fet.width, fet.length, fet.current, fet.threshold, drain, gate, source)
        found = np.empty(np.broadcast(*numbers).shape)
        devices = np.empty((len(numbers), *found.shape))
        for k, each in enumerate(numbers):
            devices[k] = each
        flat = devices.reshape(len(numbers), -1)
        _currents(terms_of(fet.law, 1.0, 1.0, 0.0, 0.0), flat, found.reshape(-1))
        return found

    def idle(self, *devices: str, drain: float) -> F64 | float:
        """What nFETs whose gates and sources are at ground take at a drain (V), A; none under the ideal law.

        Of the ideal law's, which is less, charges that are measured from transistors have a share.
        """
        return sum(self.current(name, 0.0, drain) for name in devices) if self.full else 0.0

    def channel(self, device: str, gate: F64 | float, drain: F64 | float) -> F64:
        """Channel current with the source at the bulk, A: `I_S [F(v_p / U_T) - F((v_p - v_d) / U_T)] E M`.

        gate, drain: V above the bulk (below it for a pFET).
        """
        fet = self.fet[device]
        if _has_effects(fet.law):
            silent = fet.law.without_leakage()
            return self._replace(fet={device: fet._replace(law=silent)}).current(device, gate, drain)
        pinch = self.pinch(device, gate)
        carried = interpolation_of(pinch) - interpolation_of(pinch - drain / self.u_t)
        return np.asarray(self.fet[device].current * carried)

    def weak(self, device: str, gate: F64 | float) -> F64:
        """Saturated current by weak inversion's law alone, A: `I_S e^(v_p / U_T)`, gate as in `pinch`."""
        return np.asarray(self.fet[device].current * np.exp(self.pinch(device, gate)))

    def gate_for(self, device: str, current: F64) -> F64:
        """Gate voltage at which `saturated` is a current (A, above zero): V, as in `pinch`."""
        fet = self.fet[device]
        if _has_effects(fet.law):
            return fet.gate_for(current)
        return np.asarray(fet.threshold + self.u_t * argument(current / fet.current) / fet.kappa)

    def mirror(self, diode: str, copy: str) -> Mirror:
        """The mirror of a diode-connected device and its copy."""
        return mirror_of(self.fet[diode], self.fet[copy], self.u_t)

    def offset(self, *devices: str) -> F64:
        """Local deviations of devices of one shape, V_T0 (V) and ln beta of each, [shape, 2 devices]."""
        each = [x for fet in map(self.fet.__getitem__, devices) for x in (fet.v_t0, np.log1p(fet.beta))]
        return np.stack(each, axis=-1)

    def inverter_threshold(self, inverter: str) -> F64:
        """Input (V) at which the devices `<inverter>p` and `<inverter>n`, both saturated, carry the same.

        With second-order effects the output is at half the supply.
        """
        p, n = self.fet[f"{inverter}p"], self.fet[f"{inverter}n"]
        found = np.empty(np.shape(n.current))
        if _has_effects(n.law) or _has_effects(p.law):
            shared = terms_of(n.law, 1.0, 1.0, 0.0, 0.0), terms_of(p.law, 1.0, 1.0, 0.0, 0.0)
            each = _numbers_of(n, found), _numbers_of(p, found)
            _whole_inverter_threshold(*shared, *each, self.v_dd, found.reshape(-1))
            return found
        _inverter_threshold(
            n.current.ravel(), n.threshold.ravel() / self.u_t, n.kappa, p.current.ravel(),
            p.threshold.ravel() / self.u_t, p.kappa, self.v_dd / self.u_t, found.reshape(-1),
        )  # fmt: skip
        return found * self.u_t

    def inverter_lag(
        self, inverter: str, swing: F64, capacitance: F64 | float, speed: F64, threshold: F64 | None = None
    ) -> F64:
        """Time (s) in which an inverter, driven past its threshold, moves its output by `swing`, V.

        capacitance: at its output, F. speed: of its input, V/s, which makes its current grow from nothing: `C
        swing = g speed t^2 / 2`. threshold: its own, V, found unless given.
        """
        if threshold is None:
            threshold = self.inverter_threshold(inverter)
        slope = np.zeros(threshold.shape)
        for device, gate in ((f"{inverter}p", self.v_dd - threshold), (f"{inverter}n", threshold)):
            more, less = self.saturated(device, gate + _STEP), self.saturated(device, gate - _STEP)
            slope += (more - less) / (2.0 * _STEP)
        return np.asarray(np.sqrt(2.0 * capacitance * np.maximum(swing, 0.0) / (slope * speed)))

    def flat(self) -> DieDevices:
        """The same with all arrays in one dimension, the last index running fastest."""
        return self._each(np.ravel)

    def taken(self, index: I64) -> DieDevices:
        """The copies numbered `index`, int64[n], of flat devices; a copy may be taken more than once."""
        return self._each(lambda x: x.take(index))._replace(copies=index.size)

    def columns(self) -> DieDevices:
        """Flat devices and gates as columns, [copies, 1], to be evaluated at several voltages, [points]."""
        gates = {port: x[:, None] if x.ndim else x for port, x in self.gate.items()}
        return self._each(lambda x: x[:, None])._replace(gate=gates)

    def _each(self, made: Callable[[F64], F64]) -> DieDevices:
        """Devices whose arrays are what `made` makes of these."""
        more = None if self.more is None else {name: made(x) for name, x in self.more.items()}
        return self._replace(fet={name: fet.each(made) for name, fet in self.fet.items()}, more=more)

    def renamed(self, prefix: str, new: str = "") -> DieDevices:
        """The devices whose names begin with `prefix`, with `new` in the place of the prefix."""
        more = None if self.more is None else _renamed(self.more, prefix, new)
        return self._replace(fet=_renamed(self.fet, prefix, new), more=more)


def on_die(
    circuit: Circuit, silicon: Silicon, wanted: Sequence[str] | None = None, place: Path = (),
    gate: Mapping[str, F64 | float] | None = None,
) -> DieDevices:  # fmt: skip
    """Transistors of a circuit on the silicon's die at the silicon's temperature.

    wanted: names of transistors, all of the circuit unless given; place: where the circuit stands, by itself
    unless given; gate: voltages (V) of its bias lines by port, which the result keeps. Raises
    `UnknownNameError` for a name that the circuit lacks, `ParameterError` for one of no transistor.
    """
    names = transistor_names(circuit) if wanted is None else tuple(dict.fromkeys(wanted))
    devices = [transistor_of(circuit, name) for name in names]
    sites = [site_of(circuit, name, device) for name, device in zip(names, devices, strict=True)]
    chip, paths = paths_of(circuit, sites, place)
    shapes = [shape_of(path) for path in paths]
    areas = [spread(s.size["width"] * s.size["length"] * s.size["multiplicity"], shape)
             for s, shape in zip(sites, shapes, strict=True)]  # fmt: skip
    every = np.concatenate([np.zeros(0), *areas])
    polarities = [device.polarity for device in devices]
    local = silicon.deviations(chip, paths, every, polarities)
    v_t0, beta = (np.broadcast_to(x, every.size) for x in local)
    laws = {polarity: silicon.law(polarity) for polarity in POLARITIES}
    fets, start = {}, 0
    for name, site, polarity, shape, area in zip(names, sites, polarities, shapes, areas, strict=True):
        own, start = slice(start, start + area.size), start + area.size
        own_v, own_beta = v_t0[own].reshape(shape), beta[own].reshape(shape)
        size = site.size
        shared = _of_one_size(laws[polarity], name, size)
        square = shared.square_current * size["multiplicity"] * size["width"] / size["length"]
        current, threshold = np.asarray(square * (1.0 + own_beta)), np.asarray(shared.v_t0 + own_v)
        width, length = (
            np.broadcast_to(np.asarray(x, dtype=np.float64), shape)
            for x in (size["multiplicity"] * size["width"], size["length"])
        )
        fets[name] = Fet(current, threshold, shared.kappa, own_v, own_beta, width, length, shared)
    copies = math.prod(shape_of(place[1:]))
    volts = {port: np.asarray(value, dtype=np.float64) for port, value in (gate or {}).items()}
    return DieDevices(silicon.thermal_voltage, silicon.process.v_dd, copies, fets, volts)


def _of_one_size(
    law: TransistorAtTemperature, name: str, size: Mapping[str, F64 | float]
) -> TransistorAtTemperature:
    """The law of a transistor's size; raises `ParameterError` where it follows the size and places differ."""
    if law.size is None:
        return law
    sides = [np.unique(size[side]) for side in ("width", "length")]
    if max(side.size for side in sides) > 1:
        raise ParameterError(
            f"{name}: places of several sizes, and its law follows the size, of which a model takes one;"
            " simulate transistors"
        )
    return law.of_size(float(sides[0][0]), float(sides[1][0]))


def standing(
    circuit: Circuit, silicon: Silicon, array: str = "", wanted: Sequence[str] | None = None
) -> DieDevices:
    """Flat devices of a circuit that stands by itself, or of the copies in its instance array called `array`.

    wanted: names of the transistors inside it, all of them unless given. The gates are the circuit's own
    biases, by the ports that they have inside. Raises as `on_die` and `array_of` do.
    """
    lines = bias_lines(circuit, silicon)
    if not array:
        return on_die(circuit, silicon, wanted, gate=lines).flat()
    copies = array_of(circuit, array)
    names = transistor_names(copies.circuit) if wanted is None else wanted
    gates = {port: lines[node] for port, node in copies.connections.items() if node in lines}
    d = on_die(circuit, silicon, [f"{array}.{name}" for name in names], gate=gates)
    return d.renamed(f"{array}.").flat()._replace(copies=math.prod(copies.shape))


def _renamed(named: Mapping[str, V], prefix: str, new: str) -> dict[str, V]:
    """What names that begin with `prefix` stand for, by names with `new` in its place."""
    return {new + k.removeprefix(prefix): x for k, x in named.items() if k.startswith(prefix)}


def array_of(circuit: Circuit, name: str) -> InstanceArray:
    """The instance array called `name`; raises `UnknownNameError` where there is none."""
    found = [i for i in circuit.instances if isinstance(i, InstanceArray)]
    for each in found:
        if each.name == name:
            return each
    raise unknown_name(f"{circuit.name} array", name, [i.name for i in found])


def mirror_of(diode: Fet, copy: Fet, u_t: float) -> Mirror:
    """The mirror of a diode-connected device and its copy, of one polarity, at U_T = `u_t` V."""
    apart = diode.kappa * (diode.threshold - copy.threshold) / u_t
    pair = (diode, copy) if _has_effects(diode.law) else None
    return Mirror(diode.current, copy.current, 0.5 * apart, pair)


def _has_effects(law: TransistorAtTemperature) -> bool:
    """Whether a law has second-order effects."""
    return law != law.ideal()


def _saturated(fet: Fet, gate: F64) -> F64:
    """What `DieDevices.saturated` gives of a device with its source at the bulk."""
    v_p = pinch_off_of(fet.law, gate - fet.threshold)
    return np.asarray(fet.current * interpolation(v_p / fet.law.u_t) * mobility(fet.law, v_p))


def bias_lines(circuit: Circuit, silicon: Silicon) -> dict[str, F64]:
    """Voltages of a circuit's own bias ports on the silicon, V, each of its port's shape."""
    return {b.port: bias_voltages(circuit, b, silicon) for b in circuit.biases}


def transistor_names(circuit: Circuit) -> tuple[str, ...]:
    """Names of all transistors of a circuit, its own before those of its instances."""
    return device_names(circuit, Transistor)


def device_names(circuit: Circuit, kind: type[Device]) -> tuple[str, ...]:
    """Names of all devices of a type in a circuit, its own before those of its instances."""
    own = [d.name for d in circuit.devices if isinstance(d, kind)]
    return (*own, *(f"{i.name}.{n}" for i in circuit.instances for n in device_names(i.circuit, kind)))


def transistor_of(circuit: Circuit, name: str) -> Transistor:
    """The transistor called `name`; raises `ParameterError` where that is another device."""
    device = circuit.device(name)
    if not isinstance(device, Transistor):
        raise ParameterError(f"{circuit.name}.{name}: must be a transistor; the model needs its deviations")
    return device


class Site(NamedTuple):
    """A device, the instances in which it stands, and its parameters (SI), one or of their arrays' shape."""

    device: Device
    path: Path
    size: Mapping[str, F64 | float]


def paths_of(circuit: Circuit, sites: Sequence[Site], place: Path) -> tuple[str, list[Path]]:
    """Name of the chip on which a circuit stands at `place`, and paths of the devices of `sites` on it."""
    chip, above = (place[0][0], place[1:]) if place else (circuit.name, ())
    return chip, [(*above, *site.path, (site.device.name, ())) for site in sites]


def shape_of(path: Path) -> Shape:
    """Shape of an array of all places of a path."""
    return tuple(n for _, shape in path for n in shape)


def spread(value: F64 | float, shape: Shape) -> F64:
    """A value at all places, row-major."""
    if isinstance(value, float):
        return np.full(math.prod(shape), value)
    return np.broadcast_to(value, shape).ravel()


def site_of(circuit: Circuit, name: str, device: Device) -> Site:
    """Where the device of a circuit called `name` stands, with the parameters that it has there."""
    *above, _ = name.split(".")
    instances: list[Instance | InstanceArray] = []
    for part in above:
        inside = instances[-1].circuit if instances else circuit
        instances.append(next(i for i in inside.instances if i.name == part))
    path = tuple((i.name, i.shape) for i in instances)
    size: dict[str, F64 | float] = dict(device.parameters())
    # what an outer instance sets is put last, in the place of what an inner one does
    for depth in reversed(range(len(instances))):
        inner: Shape = tuple(n for i in instances[depth + 1 :] for n in i.shape)
        tail = ".".join((*above[depth + 1 :], device.name))
        for key in size:
            given = instances[depth].parameters.get(f"{tail}.{key}")
            if given is not None:
                values = np.broadcast_to(np.asarray(given, dtype=np.float64), instances[depth].shape)
                size[key] = values.reshape(values.shape + (1,) * len(inner))
    return Site(device, path, size)


def _numbers_of(fet: Fet, shape: F64) -> F64:
    """Width, length, I_S and V_T0 of a device at each place of `shape`, float64[4, count]."""
    own = (fet.width, fet.length, fet.current, fet.threshold)
    return np.stack([np.broadcast_to(x, shape.shape).ravel() for x in own])


@compiled(forceinline=True)
def _sized(shared: Terms, own: F64, k: int) -> Terms:
    """The numbers of device k; shared: of one a metre long and wide; own: as of `_numbers_of`."""
    width, length = own[0, k], own[1, k]
    return Terms(
        own[2, k], own[3, k], shared.half, shared.kappa, shared.gamma, shared.surface, shared.early / length,
        shared.early_rise, shared.reduction, shared.leakage * width, shared.induced * width,
        shared.induced_from, shared.induced_slope,
    )  # fmt: skip


@compiled(forceinline=True)
def _into(t: Terms, drain: float, gate: float, source: float) -> float:
    """Current into a drain, with its junction's, A."""
    return even_channel(t, drain, gate, source)[0] + even_leaked(t, drain, gate)[0]


@compiled()
def _currents(shared: Terms, devices: F64, out: F64) -> None:
    """Current into the drain of devices of one polarity, A; shared: of one a metre long and wide.

    devices: width, length, I_S, V_T0, and the voltages of drain, gate and source of each, [7, count].
    """
    for k in range(out.size):
        t = _sized(shared, devices, k)
        out[k] = _into(t, devices[4, k], devices[5, k], devices[6, k])


@compiled(_nrt=True)
def _whole_inverter_threshold(
    shared_n: Terms, shared_p: Terms, n: F64, p: F64, supply: float, out: F64
) -> None:
    """Input of inverters whose output is at half the supply, V; n, p: as of `_numbers_of`."""
    low, high = np.zeros(out.size), np.full(out.size, supply)
    for _ in range(_BISECTIONS):
        _halve_whole(shared_n, shared_p, n, p, supply, low, high, out)


@compiled()
def _halve_whole(
    shared_n: Terms, shared_p: Terms, n: F64, p: F64, supply: float, low: F64, high: F64, middle: F64
) -> None:
    """Halve the bounds of inverters' inputs, V, and fill their middles as they were."""
    half = 0.5 * supply
    for k in range(low.size):
        v = 0.5 * (low[k] + high[k])
        down, up = _sized(shared_n, n, k), _sized(shared_p, p, k)
        above = _into(down, half, v, 0.0) > _into(up, half, supply - v, 0.0)
        low[k], high[k], middle[k] = low[k] if above else v, v if above else high[k], v


@compiled(_nrt=True)
def _inverter_threshold(
    i_n: F64, t_n: F64, k_n: float, i_p: F64, t_p: F64, k_p: float, supply: float, out: F64
) -> None:
    """Input of inverters, U_T; i: specific currents, A, t: thresholds, U_T, k: kappa, of either device."""
    for first in range(0, out.size, _TOGETHER):
        part = slice(first, min(first + _TOGETHER, out.size))
        bounds = np.zeros((2, out[part].size))
        bounds[1] = supply
        for _ in range(_BISECTIONS):
            _halve(i_n[part], t_n[part], k_n, i_p[part], t_p[part], k_p, supply, bounds)
        for k in range(bounds.shape[1]):
            out[first + k] = 0.5 * (bounds[0, k] + bounds[1, k])


@compiled()
def _halve(
    i_n: F64, t_n: F64, k_n: float, i_p: F64, t_p: F64, k_p: float, supply: float, bounds: F64
) -> None:
    """Halve the bounds of inverters' inputs, U_T, float64[2, inverters]."""
    low, high = bounds[0], bounds[1]
    for k in range(low.size):
        v = 0.5 * (low[k] + high[k])
        pulled = i_n[k] * even_interpolation(k_n * (v - t_n[k]))
        held = i_p[k] * even_interpolation(k_p * (supply - v - t_p[k]))
        low[k], high[k] = low[k] if pulled > held else v, v if pulled > held else high[k]
