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
| `d.saturated(device, gate)` | current with the source at the bulk and the drain far: `I_S F(v_p / U_T)` |
| `d.channel(device, gate, drain)` | current with the source at the bulk and the drain at a voltage |
| `d.weak(device, gate)` | what weak inversion alone makes of the saturated current: `I_S e^(v_p / U_T)` |
| `d.pinch(device, gate)` | `v_p / U_T = kappa (v_g - V_T0) / U_T` |
| `d.gate_for(device, current)` | the gate that gives a saturated current: the inverse of `saturated` |
| `d.mirror(diode, copy)` | what a copy carries of its diode's current (`Mirror`) |
| `d.offset(*devices)` | local deviations, for a record's gradients: V_T0 and ln beta of each device in turn |
| `d.inverter_threshold(inverter)` | the input at which an inverter turns |
| `d.fet[device]` | specific current, threshold and kappa themselves |

Voltages of a pFET count from the supply down. The law is that with constant kappa; body effect, Early effect
and leakage stay with the transistor level.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64
from circuits.bias import bias_voltages
from circuits.circuit import Circuit, Instance, InstanceArray, Shape
from circuits.compiled import compiled
from circuits.devices import Transistor
from circuits.devices.ekv import argument, interpolation, law
from circuits.devices.pinch_off import pinch_off
from circuits.errors import ParameterError, unknown_name
from circuits.silicon.die import Path
from circuits.silicon.process import POLARITIES
from circuits.silicon.silicon import Silicon

_BISECTIONS = 60
_STEP = 1e-3  # V, of a derivative by the gate; ours


class Fet(NamedTuple):
    """A transistor at all its places on a die.

    current: specific current I_S, A. threshold: V_T0, V. v_t0, beta: local deviations from what the die
    shares, V of the magnitude and relative. kappa: that of its polarity.
    """

    current: F64
    threshold: F64
    kappa: float
    v_t0: F64
    beta: F64


class Mirror(NamedTuple):
    """A current mirror in saturation: the specific currents (A) of its input and output devices.

    shift: `(v_p,out - v_p,in) / 2 U_T` at one gate voltage.
    """

    given: F64 | float
    taken: F64 | float
    shift: F64 | float

    def copied(self, current: F64) -> F64:
        """What the copy carries of a current (A) above zero, A, in the shape to which both broadcast."""
        return np.asarray(self.taken * interpolation(argument(current / self.given) + 2.0 * self.shift))

    def needed(self, current: F64) -> F64:
        """The current into the diode, A, of which the copy makes `current` (A, above zero)."""
        return np.asarray(self.given * interpolation(argument(current / self.taken) - 2.0 * self.shift))

    @property
    def weak(self) -> F64:
        """Current out over current in where both devices are in weak inversion."""
        return np.asarray(self.taken / self.given * np.exp(2.0 * self.shift))


class DieDevices(NamedTuple):
    """Transistors of a circuit on a die, and what a behavioural model asks of them; see the module.

    u_t: thermal voltage, V. v_dd: supply, V. copies: how many places the circuit has. fet: each transistor by
    its name. gate: voltages (V) of bias lines by port, where they were given.
    """

    u_t: float
    v_dd: float
    copies: int
    fet: Mapping[str, Fet]
    gate: Mapping[str, F64]

    def pinch(self, device: str, gate: F64 | float) -> F64:
        """`kappa (v_g - V_T0) / U_T`, gate: V above the bulk (below it for a pFET)."""
        fet = self.fet[device]
        return pinch_off(fet.kappa, gate, fet.threshold) / self.u_t

    def below(self, port: str) -> F64:
        """Bias voltage of a pFET's gate, counted from the supply down, V."""
        return self.v_dd - self.gate[port]

    def saturated(self, device: str, gate: F64 | float, source: F64 | float = 0.0) -> F64:
        """Current with the drain far, A: `I_S F((v_p - v_s) / U_T)`.

        gate, source: V above the bulk (below it for a pFET); the source is at the bulk unless given.
        """
        return np.asarray(
            self.fet[device].current * interpolation(self.pinch(device, gate) - source / self.u_t)
        )

    def channel(self, device: str, gate: F64 | float, drain: F64 | float) -> F64:
        """Current with the source at the bulk, A: `I_S [F(v_p / U_T) - F((v_p - v_d) / U_T)]`.

        gate, drain: V above the bulk (below it for a pFET).
        """
        pinch = self.pinch(device, gate)
        carried = interpolation(pinch) - interpolation(pinch - drain / self.u_t)
        return np.asarray(self.fet[device].current * carried)

    def weak(self, device: str, gate: F64 | float) -> F64:
        """Saturated current by weak inversion's law alone, A: `I_S e^(v_p / U_T)`, gate as in `pinch`."""
        return np.asarray(self.fet[device].current * np.exp(self.pinch(device, gate)))

    def gate_for(self, device: str, current: F64) -> F64:
        """Gate voltage at which a device, saturated, carries a current (A, above zero): V, as in `pinch`."""
        fet = self.fet[device]
        return np.asarray(fet.threshold + self.u_t * argument(current / fet.current) / fet.kappa)

    def mirror(self, diode: str, copy: str) -> Mirror:
        """The mirror of a diode-connected device and its copy."""
        return mirror_of(self.fet[diode], self.fet[copy], self.u_t)

    def offset(self, *devices: str) -> F64:
        """Local deviations of devices of one shape, V_T0 (V) and ln beta of each, [shape, 2 devices]."""
        each = [x for fet in map(self.fet.__getitem__, devices) for x in (fet.v_t0, np.log1p(fet.beta))]
        return np.stack(each, axis=-1)

    def inverter_threshold(self, inverter: str) -> F64:
        """Input (V) at which the devices `<inverter>p` and `<inverter>n`, both saturated, carry the same."""
        p, n = self.fet[f"{inverter}p"], self.fet[f"{inverter}n"]
        found = np.empty(np.shape(n.current))
        _inverter_threshold(
            n.current.ravel(), n.threshold.ravel() / self.u_t, n.kappa, p.current.ravel(),
            p.threshold.ravel() / self.u_t, p.kappa, self.v_dd / self.u_t, found.reshape(-1),
        )  # fmt: skip
        return found * self.u_t

    def inverter_lag(self, inverter: str, swing: F64, capacitance: float, speed: F64) -> F64:
        """Time (s) in which an inverter, driven past its threshold, moves its output by `swing`, V.

        capacitance: at its output, F. speed: of its input, V/s, which makes its current grow from nothing: `C
        swing = g speed t^2 / 2`.
        """
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
        return self._each(lambda x: x[index])._replace(copies=index.size)

    def columns(self) -> DieDevices:
        """Flat devices and gates as columns, [copies, 1], to be evaluated at several voltages, [points]."""
        gates = {port: x[:, None] if x.ndim else x for port, x in self.gate.items()}
        return self._each(lambda x: x[:, None])._replace(gate=gates)

    def _each(self, made: Callable[[F64], F64]) -> DieDevices:
        """Devices whose arrays are what `made` makes of these."""
        fets = {k: Fet(made(f.current), made(f.threshold), f.kappa, made(f.v_t0), made(f.beta))
                for k, f in self.fet.items()}  # fmt: skip
        return self._replace(fet=fets)

    def renamed(self, prefix: str, new: str = "") -> DieDevices:
        """The devices whose names begin with `prefix`, with `new` in the place of the prefix."""
        fets = {new + k.removeprefix(prefix): f for k, f in self.fet.items() if k.startswith(prefix)}
        return self._replace(fet=fets)


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
    sites = [_site(circuit, name) for name in names]
    chip, above = (place[0][0], place[1:]) if place else (circuit.name, ())
    paths = [(*above, *site.path, (site.device.name, ())) for site in sites]
    shapes = [tuple(n for _, shape in path for n in shape) for path in paths]
    areas = [_spread(s.size["width"] * s.size["length"] * s.size["multiplicity"], shape)
             for s, shape in zip(sites, shapes, strict=True)]  # fmt: skip
    every = np.concatenate([np.zeros(0), *areas])
    v_t0, beta = (np.broadcast_to(x, every.size) for x in silicon.deviations(chip, paths, every))
    laws = {polarity: silicon.law(polarity) for polarity in POLARITIES}
    fets, start = {}, 0
    for name, site, shape, area in zip(names, sites, shapes, areas, strict=True):
        own, start = slice(start, start + area.size), start + area.size
        own_v, own_beta = v_t0[own].reshape(shape), beta[own].reshape(shape)
        shared, size = laws[site.device.polarity], site.size
        square = shared.square_current * size["multiplicity"] * size["width"] / size["length"]
        current, threshold = np.asarray(square * (1.0 + own_beta)), np.asarray(shared.v_t0 + own_v)
        fets[name] = Fet(current, threshold, shared.kappa, own_v, own_beta)
    copies = math.prod(n for _, shape in above for n in shape)
    volts = {port: np.asarray(value, dtype=np.float64) for port, value in (gate or {}).items()}
    return DieDevices(silicon.thermal_voltage, silicon.process.v_dd, copies, fets, volts)


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
    return Mirror(diode.current, copy.current, 0.5 * apart)


def bias_lines(circuit: Circuit, silicon: Silicon) -> dict[str, F64]:
    """Voltages of a circuit's own bias ports on the silicon, V, each of its port's shape."""
    return {b.port: bias_voltages(circuit, b, silicon) for b in circuit.biases}


def transistor_names(circuit: Circuit) -> tuple[str, ...]:
    """Names of all transistors of a circuit, its own before those of its instances."""
    own = [d.name for d in circuit.devices if isinstance(d, Transistor)]
    return (*own, *(f"{i.name}.{n}" for i in circuit.instances for n in transistor_names(i.circuit)))


def transistor_of(circuit: Circuit, name: str) -> Transistor:
    """The transistor called `name`; raises `ParameterError` where that is another device."""
    device = circuit.device(name)
    if not isinstance(device, Transistor):
        raise ParameterError(f"{circuit.name}.{name}: must be a transistor; the model needs its deviations")
    return device


class _Site(NamedTuple):
    """A transistor, the instances in which it stands, and its sizes (m), one or of their arrays' shape."""

    device: Transistor
    path: Path
    size: Mapping[str, F64 | float]


def _spread(value: F64 | float, shape: Shape) -> F64:
    """A value at all places, row-major."""
    if isinstance(value, float):
        return np.full(math.prod(shape), value)
    return np.broadcast_to(value, shape).ravel()


def _site(circuit: Circuit, name: str) -> _Site:
    device = transistor_of(circuit, name)
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
    return _Site(device, path, size)


@compiled()
def _inverter_threshold(
    i_n: F64, t_n: F64, k_n: float, i_p: F64, t_p: F64, k_p: float, supply: float, out: F64
) -> None:
    """Input of inverters, U_T; i: specific currents, A, t: thresholds, U_T, k: kappa, of either device."""
    for k in range(out.size):
        low, high = 0.0, supply
        for _ in range(_BISECTIONS):
            v = 0.5 * (low + high)
            if i_n[k] * law(k_n * (v - t_n[k]))[0] > i_p[k] * law(k_p * (supply - v - t_p[k]))[0]:
                high = v
            else:
                low = v
        out[k] = 0.5 * (low + high)
