"""Behavioural model of the rebound neuron: the neuron's own equations with the devices of a die.

What decides (a spike or none) is integrated: v_mem, v_r and v_ex with the die's EKV currents and the
circuit's capacitances (`chips.ranging.law`). What is smooth comes from the record that
`chips.ranging.measure` makes with the transistor-level solver, by gradients over the devices' deviations x:

    q = q0(ln I_inh, T) + sum_d [g_d(ln I_inh, T) x_d + h_d(ln I_inh, T) x_d^2 / 2]

for ln(t_inh I_inh), the comparator's threshold, the charge that fires the axon, the width of a spike and the
step of v_ex at the end of an echo; I_inh is the current of this die's mi5. x: V_T0 (V) and ln beta of each
device, what all of a polarity share, and by how much the gate voltage of a bias differs from the record's.
What these neurons do is `chips.ranging.response`'s.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from chips.measured.interpolation import lagrange_weights
from chips.ranging.law import Effects, Neurons, Pull, pull_low
from chips.ranging.record import (
    CAPACITORS,
    ReboundRecord,
    capacitor_shares,
    rebound_key,
    record_of,
    with_capacitors,
)
from chips.record_file import stale
from chips.validity import require_inside
from circuits.arrays import F64
from circuits.bias import bias_voltages, rebias, saturation_current
from circuits.blocks.sonar import rebound_neuron
from circuits.catalogue import later
from circuits.circuit import Circuit, InstanceArray
from circuits.devices import Source, Transistor
from circuits.devices.channel import mobility
from circuits.devices.ekv import argument, interpolation
from circuits.devices.pinch_off import pinch_off
from circuits.devices.source import Constant
from circuits.lowering.capacitance import added_capacitances, capacitance_matrix
from circuits.lowering.capacitors_on_die import capacitor_changes, capacitors_deviate
from circuits.lowering.flatten import DeviceGroup, flatten
from circuits.lowering.kernel import Machine, to_kernel
from circuits.lowering.on_die import DieDevices, on_die, transistor_of
from circuits.place import circuit_at
from circuits.silicon.process import POLARITIES, Process, TransistorAtTemperature
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench

if TYPE_CHECKING:
    from scipy.interpolate import CubicSpline

interpolate = later("scipy.interpolate")  # slow to import

RESETS = ("inhibition.mi12", "axon.ma8")  # which pull v_mem low, and are off else
_HALVINGS = 40  # of v_rest: far below a nanovolt
NODES = ("v_mem", "membrane.v_r", "excitation.v_ex")
# Devices whose gate is a bias port: the port's difference from the record's counts as their threshold's.
GATED = {
    "inhibition.mi6": "i_lim",
    "inhibition.mi9": "i_lim",
    "axon.ma1": "i_lim",
    "comparator.mc3": "i_cmp",
    "axon.ma7": "i_pw",
}


@dataclass(frozen=True, slots=True)
class ReboundModel:
    """The model of a circuit: a rebound neuron, or an array of them, with its record.

    transistors: by path inside the neuron; reference: gate voltages (V) of the biases in the record;
    capacitance: matrix of `NODES` as drawn, F, float64[3, 3]; inverse_capacitance, follow: of that, as in
    `Neurons`; rebound_capacitance: C_r, F; shares: of `CAPACITORS`, in what they move; fixed: gate voltages,
    V, of the biases that neither temperature nor die moves; tables: value, gradient and curvature of the
    record's quantities side by side, float64[currents or 1, temperatures, 1 + 2 parameters].
    """

    circuit: Circuit
    process: Process
    record: ReboundRecord
    transistors: Mapping[str, DeviceGroup]
    reference: Mapping[str, float]
    capacitance: F64
    inverse_capacitance: F64
    follow: F64
    rebound_capacitance: float
    shares: Mapping[str, float]
    fixed: Mapping[str, F64]
    tables: Mapping[str, F64]


class Devices(NamedTuple):
    """Transistors of n neurons on a die, by path inside the neuron, and how they lie to the record's.

    on_die: the devices, flat, with the biases' voltages by name; shift: local deviation of the threshold, V,
    the bias's included; log_beta: local deviation of the current factor, float64[n] each. Under `n` and `p`
    what the die's devices of a polarity share.
    """

    on_die: DieDevices
    shift: dict[str, F64]
    log_beta: dict[str, F64]


def model_of(circuit: Circuit, process: Process, record: ReboundRecord | None = None) -> ReboundModel:
    """Prepare the model of a rebound neuron, or of an array of them.

    Raises `DataError` where there is no record of this circuit in this process.

    Parameters
    ----------
    circuit
        The circuit.
    process
        The process that it is made in.
    record
        Record of the model; the one in force unless given.
    """
    record = record or record_of(process)
    neuron = neuron_of(circuit)
    if rebound_key(neuron, process, record.grid) != record.key:
        raise stale("rebound_neuron", process=process)
    array = "" if neuron is circuit else circuit.instances[0].name
    groups = [g for g in flatten(circuit).groups if not array or g.path[0][0] == array]
    lone = rebound_neuron.build()
    nominal = Silicon(process)
    drawn = _capacitance(neuron, process)
    return ReboundModel(
        circuit,
        process,
        record,
        {
            ".".join([*(n for n, _ in g.path[1 if array else 0 :]), g.device.name]): g
            for g in groups
            if isinstance(g.device, Transistor)
        },
        {b.name: float(bias_voltages(lone, b, nominal)) for b in lone.biases},
        drawn,
        *_inverse_and_follow(drawn[None]),
        next(float(g.parameters["capacitance"][0]) for g in groups if g.device.name == "c_r"),
        capacitor_shares(neuron, process),
        _fixed(circuit, process),
        {
            name: np.concatenate([q.value[..., None], q.gradient, q.curvature], axis=-1)
            for name, q in record.quantities.items()
        },
    )


def with_biases(model: ReboundModel, values: Mapping[str, float | tuple[float, ...]]) -> ReboundModel:
    """Return the model with other values of its circuit's biases, A or V; raises as `rebias`."""
    circuit = rebias(model.circuit, values)
    return replace(model, circuit=circuit, fixed=_fixed(circuit, model.process))


def _fixed(circuit: Circuit, process: Process) -> dict[str, F64]:
    """Gate voltages of the biases that neither temperature nor die moves, V, by the neuron's names."""
    ports = {b.port: b.name for b in neuron_of(circuit).biases}
    return {
        ports[b.port]: bias_voltages(circuit, b, Silicon(process))
        for b in circuit.biases
        if b.port in ports and b.kind not in {"ideal", "generator"}
    }


def neuron_of(circuit: Circuit) -> Circuit:
    """Return the rebound neuron of a circuit that is one, or that is an array of them."""
    first = circuit.instances[0] if circuit.instances else None
    return first.circuit if isinstance(first, InstanceArray) else circuit


class Located(NamedTuple):
    """What neurons of a model are made of on a silicon: voltages of their bias ports, V, and devices."""

    gate: dict[str, F64]
    devices: Devices


def located(model: ReboundModel, silicon: Silicon) -> Located:
    """Find the bias voltages and the devices of all neurons of the model on a silicon."""
    gate = gates_on(model, silicon)
    return Located(gate, devices_on(model, silicon, gate))


def neurons_on(model: ReboundModel, silicon: Silicon, found: Located | None = None) -> Neurons:
    """Return all neurons of the model on a silicon, with the same devices as at transistor level.

    found: what `located` finds there, where that is known.
    """
    gate, d = located(model, silicon) if found is None else found
    u_t, v_dd = silicon.thermal_voltage, silicon.process.v_dd
    n, p = silicon.law("n"), silicon.law("p")
    fet = d.on_die.fet
    every = np.ones_like(fet["membrane.m1"].current)

    def saturated(device: str, bias: str) -> F64:
        return d.on_die.saturated(device, d.on_die.below(bias))

    off = sum(d.on_die.saturated(r, 0.0) for r in RESETS)
    i_rslope, i_rtau = saturated("membrane.mr1", "i_rslope"), saturated("membrane.mr2", "i_rtau")
    i_inh = inhibition_current(d, gate["i_inh_tau"])
    changes = _capacitor_changes(model, silicon)
    smooth = with_capacitors(model.shares, changes, evaluate(model, d, gate["v_th"], i_inh, silicon))
    inverse, follow = _coupled(model, changes, i_inh.size)
    nominal_rtau = saturation_current(model.circuit, model.circuit.bias("i_rtau"), silicon)
    neurons = Neurons(
        inverse_2ut=every / (2.0 * u_t),
        kappa_n=every * n.kappa,
        kappa_p=every * p.kappa,
        v_dd=every * v_dd,
        v_rest=every * gate["v_rest"],
        v_ex_max=every * gate["v_ex_max"],
        m1_current=fet["membrane.m1"].current,
        m1_threshold=fet["membrane.m1"].threshold,
        m2_current=fet["membrane.m2"].current,
        m2_threshold=fet["membrane.m2"].threshold,
        me4_current=fet["excitation.me4"].current,
        me4_pinch=pinch_off(every * p.kappa, v_dd - gate["i_ex_tau"], fet["excitation.me4"].threshold),
        me4_forward=saturated("excitation.me4", "i_ex_tau"),
        me5_current=fet["excitation.me5"].current,
        me5_threshold=fet["excitation.me5"].threshold,
        i_rslope=i_rslope - off,
        i_rtau=i_rtau,
        t_inh=np.exp(smooth["log_charge"]) / i_inh,
        v_threshold=smooth["threshold"],
        axon_charge=np.exp(smooth["log_axon_charge"]),
        pulse_width=np.exp(smooth["log_pulse_width"]),
        v_held=_held(d, every * gate["v_rest"], i_rslope, i_rtau, silicon),
        echo_step=smooth["echo_step"],
        margin=every * model.record.margin,
        rebound_bound=_rebound_capacitance(model, changes) * v_dd / np.minimum(i_rtau, nominal_rtau),
        inverse_capacitance=inverse,
        follow=follow,
    )
    if not d.on_die.full:
        return neurons
    return _with_effects(neurons._replace(i_rslope=i_rslope), d, silicon)


def _with_effects(m: Neurons, d: Devices, silicon: Silicon) -> Neurons:
    """Return neurons as they are under a law with second-order effects, which `m` leaves out.

    The mobility that the gate of mr1, mr2 and me4 leaves is in their currents. The junctions' leakage is that
    of a reverse bias, and of devices that are off it is taken with v_mem at v_rest.
    """
    fet, u_t, v_dd = d.on_die.fet, silicon.thermal_voltage, silicon.process.v_dd
    n, p = silicon.law("n"), silicon.law("p")
    every = np.ones_like(m.v_dd)

    def early(device: str) -> F64:
        own = fet[device]
        if own.law.early_field == 0.0:
            return 0.0 * every
        return 1.0 / (own.law.early_field * own.length)

    def source(device: str, bias: str) -> tuple[F64, F64, F64]:
        """sqrt(F) of a current source, its mobility, and its slope of the Early effect."""
        pinch = d.on_die.pinch(device, d.on_die.below(bias))
        root = np.sqrt(interpolation(pinch))
        return root, mobility(p, pinch * u_t), early(device) / (1.0 + p.early_rise * root)

    def leak(*devices: str) -> F64:
        return np.asarray(sum(fet[x].law.junction_leakage * fet[x].width for x in devices))

    root, moved, _ = source("excitation.me4", "i_ex_tau")
    off = sum(d.on_die.current(reset, 0.0, m.v_rest) for reset in RESETS)
    found: dict[str, F64 | float] = {"two": 2.0 * u_t**2, "v_dd": m.v_dd, "v_rest": m.v_rest}
    for name, law in (("n", n), ("p", p)):
        found |= {f"{name}_gamma": law.gamma, f"{name}_theta": law.mobility_reduction}
        found |= {f"{name}_rise": law.early_rise, f"{name}_scale": 1.0 if law.gamma > 0.0 else law.kappa}
        found[f"{name}_surface"] = law.surface_potential if law.gamma > 0.0 else 0.0
    found |= {
        "m1_offset": _height(n) - m.m1_threshold,
        "m2_offset": v_dd + _height(p) - m.m2_threshold,
        "me5_offset": v_dd + _height(p) - m.me5_threshold,
        "mr1_early": source("membrane.mr1", "i_rslope")[2],
        "mr2_early": source("membrane.mr2", "i_rtau")[2],
        "me4_root": root,
        "me4_leak": leak("excitation.me3", "excitation.me4") / root**2,
        "r_leak": leak("membrane.m2", "membrane.mr2"),
        "mem_leak": off + leak("membrane.m1") - leak("membrane.mr1", "excitation.me5"),
    }
    for device in ("membrane.m1", "membrane.m2", "excitation.me4", "excitation.me5"):
        found[f"{device.partition('.')[2]}_early"] = early(device)
    effects = np.stack([found[name] * every for name in Effects._fields], axis=-1)
    return m._replace(
        me4_current=m.me4_current * moved,
        me4_pinch=d.on_die.pinch("excitation.me4", d.on_die.below("i_ex_tau")) * u_t,
        v_held=_held_by_law(m, d, silicon),
        effects=effects,
    )


def _height(law: TransistorAtTemperature) -> float:
    """What v_x is above the gate's height over the threshold, V."""
    return law.surface_potential + law.gamma * math.sqrt(law.surface_potential) if law.gamma > 0.0 else 0.0


def gates_on(model: ReboundModel, silicon: Silicon) -> dict[str, F64]:
    """Return the voltages of the neurons' bias ports by bias, V: one for all, or one a neuron.

    What no bias port of the circuit sets comes from its bias network, its other instances, solved on the die.
    """
    circuit = model.circuit
    needed = {b.port: b.name for b in neuron_of(circuit).biases}
    found = {
        needed[b.port]: bias_voltages(circuit, b, silicon)
        for b in circuit.biases
        if b.port in needed and needed[b.port] not in model.fixed
    }
    found.update(model.fixed)
    if len(found) == len(needed):
        return found
    for instance in circuit.instances[1:]:
        network, place = circuit_at(circuit, ((instance.name, ()),))
        supply = Source("vdd", "vdd", Constant(silicon.process.v_dd))
        bench = Testbench(network.name, network, (supply,), np.inf)
        point = operating_point(bench, replace(silicon, place=place))
        for port in network.ports:
            node = instance.connections[port.name]
            if node in needed and needed[node] not in found:
                found[needed[node]] = np.array([point[e] for e in port.elements()])
    return found


def devices_on(model: ReboundModel, silicon: Silicon, gate: Mapping[str, F64]) -> Devices:
    """Return the transistors of all neurons of the model on a silicon; gate: of the bias ports, V."""
    typical = Silicon(silicon.process, silicon.temperature_c)
    neuron = neuron_of(model.circuit)
    array = "" if neuron is model.circuit else f"{model.circuit.instances[0].name}."
    wanted = [f"{array}{name}" for name in model.transistors]
    found = on_die(model.circuit, silicon, wanted, gate=gate).renamed(array).flat()
    d = Devices(found, {}, {})
    for polarity in POLARITIES:
        law, nominal = silicon.law(polarity), typical.law(polarity)
        d.shift[polarity] = np.array(law.v_t0 - nominal.v_t0)
        d.log_beta[polarity] = np.log(law.square_current / nominal.square_current)
    for name in model.transistors:
        own = found.fet[name]
        d.log_beta[name] = np.log1p(own.beta)
        d.shift[name] = own.v_t0
        if name in GATED:
            sign = 1.0 if transistor_of(neuron, name).polarity == "p" else -1.0
            d.shift[name] = own.v_t0 + sign * (gate[GATED[name]] - model.reference[GATED[name]])
    return d


def inhibition_current(d: Devices, gate: F64) -> F64:
    """Return I_inh_tau of this die's mi5 in saturation, A, float64[n]; gate: V."""
    return d.on_die.saturated("inhibition.mi5", gate)


def evaluate(model: ReboundModel, d: Devices, v_th: F64, i_inh: F64, silicon: Silicon) -> dict[str, F64]:
    """Return the smooth quantities of n neurons by name; v_th: V; i_inh: A, float64[n]."""
    grid = model.record.grid
    weight = lagrange_weights(grid.temperature, silicon.temperature_c)
    share = _cardinal_splines(grid.current)(np.log(i_inh))
    result = {}
    for name, q in model.record.quantities.items():
        count = len(q.parameters)
        x = np.empty((i_inh.size, count))
        for k, parameter in enumerate(q.parameters):
            x[:, k] = _deviation(model, d, parameter, v_th)
        table = _over_current(np.tensordot(weight, model.tables[name], (0, 1)), share)
        gradient, curvature = table[:, 1 : count + 1], table[:, count + 1 :]
        result[name] = table[:, 0] + ((gradient + 0.5 * curvature * x) * x).sum(axis=-1)
    return result


def _over_current(table: F64, share: F64) -> F64:
    """Table at n currents; share: float64[n, currents]."""
    return table if table.shape[0] == 1 else np.asarray(share @ table)


@lru_cache(maxsize=16)
def _cardinal_splines(grid: tuple[float, ...]) -> CubicSpline:
    """Splines over ln(current), each one at one current of the grid and zero at the others."""
    return interpolate.CubicSpline(np.log(grid), np.eye(len(grid)))


def _deviation(model: ReboundModel, d: Devices, parameter: str, v_th: F64) -> F64:
    """Of n neurons, or of all of them."""
    if parameter == "v_th":
        return v_th - model.reference["v_th"]
    device, _, name = parameter.rpartition(".")
    return (d.shift if name == "v_t0" else d.log_beta)[device]


def _held(d: Devices, v_rest: F64, i_rslope: F64, i_rtau: F64, silicon: Silicon) -> F64:
    """v_mem while mi12, its gate at the supply, sinks what m1 brings from v_rest, V."""
    u_t, v_dd = silicon.thermal_voltage, silicon.process.v_dd
    n, p = silicon.law("n"), silicon.law("p")
    m1, m2, mi12 = "membrane.m1", "membrane.m2", "inhibition.mi12"
    # v_r where m2, its gate at v_mem, carries I_rtau: v_r = V_dd - v_p + U_T u(I / I_S)
    fet = d.on_die.fet
    drive = u_t * argument(i_rtau / fet[m2].current)
    full = pinch_off(n.kappa, v_dd, fet[mi12].threshold)
    v_r = v_dd - pinch_off(p.kappa, v_dd, fet[m2].threshold) + drive
    found = np.empty_like(v_rest)
    pull = Pull(v_rest, fet[m1].current, fet[m1].threshold, fet[mi12].current, full, v_r, i_rslope)
    pull_low(pull, u_t, n.kappa, p.kappa, found)
    return found


def _held_by_law(m: Neurons, d: Devices, silicon: Silicon) -> F64:
    """What `_held` finds, under a law with second-order effects."""
    v_dd, u_t, p = silicon.process.v_dd, silicon.thermal_voltage, silicon.law("p")
    low, high = np.zeros_like(m.v_rest), m.v_rest.copy()
    for _ in range(_HALVINGS):
        v = 0.5 * (low + high)
        pinch = d.on_die.pinch("membrane.m2", v_dd - v)
        carried = m.i_rtau / (m.m2_current * mobility(p, pinch * u_t))
        v_r = v_dd - u_t * (pinch - argument(carried))
        given = m.i_rslope + d.on_die.current("membrane.m1", v_r, m.v_rest, v)
        over = d.on_die.current("inhibition.mi12", v_dd, v) < given
        low, high = np.where(over, v, low), np.where(over, high, v)
    return 0.5 * (low + high)


def _capacitance(neuron: Circuit, process: Process) -> F64:
    """Capacitance matrix of `NODES` as drawn, F, float64[3, 3].

    The comparator's tail follows v_mem as a source follower by kappa_p while mc1 conducts, and takes that
    share off the overlap between them.
    """
    c = capacitance_matrix(neuron, process, NODES)
    mc1 = neuron.device("comparator.mc1")
    if isinstance(mc1, Transistor):
        c[0, 0] -= process.p.kappa * process.p.overlap_capacitance * mc1.width * mc1.multiplicity
    return c


def _capacitor_changes(model: ReboundModel, silicon: Silicon) -> dict[str, F64]:
    """Relative changes of `CAPACITORS` on a die by name, float64[n]; none where they do not deviate."""
    neuron = neuron_of(model.circuit)
    if not capacitors_deviate(model.circuit, silicon):
        return {}
    array = "" if neuron is model.circuit else f"{model.circuit.instances[0].name}."
    found = capacitor_changes(model.circuit, silicon, [f"{array}{name}" for name in CAPACITORS])
    return {name.removeprefix(array): np.ravel(x) for name, x in found.items()}


def _coupled(model: ReboundModel, changes: Mapping[str, F64], count: int) -> tuple[F64, F64]:
    """Inverse capacitance and follow of `count` neurons on a die, as in `Neurons`."""
    if not changes:
        return np.tile(model.inverse_capacitance, (count, 1, 1, 1)), np.tile(model.follow, (count, 1, 1))
    added = added_capacitances(neuron_of(model.circuit), changes, NODES)
    return _inverse_and_follow(model.capacitance + added)


def _inverse_and_follow(c: F64) -> tuple[F64, F64]:
    """Inverse capacitance for each set of held nodes, and how free nodes follow a step of a held one."""
    inverse = np.zeros((len(c), 4, 3, 3))
    for held in range(4):
        free = [i for i in range(3) if not (i == 0 and held & 1) and not (i == 2 and held & 2)]
        rows = np.ix_(range(len(c)), free, free)
        inverse[:, held][rows] = np.linalg.inv(c[rows])
    follow = -c / np.diagonal(c, axis1=1, axis2=2)[:, :, None]
    follow[:, range(3), range(3)] = 0.0
    return inverse, follow


def _rebound_capacitance(model: ReboundModel, changes: Mapping[str, F64]) -> F64 | float:
    """C_r on a die, or as drawn where that is larger, F: a bound is no shorter for it."""
    if not changes:
        return model.rebound_capacitance
    return model.rebound_capacitance * np.maximum(1.0 + changes["membrane.c_r"], 1.0)


def stimulated(neuron: Circuit, silicon: Silicon, extra: Sequence[Source] = ()) -> Machine:
    """Return the neuron lowered with its supply and `extra` sources.

    Call and echo are silent unless given.
    """
    taken = {s.node for s in extra}
    rest = (("vdd", silicon.process.v_dd), ("call", 0.0), ("echo", 0.0))
    sources = (*(Source(n, n, Constant(v)) for n, v in rest if n not in taken), *extra)
    return to_kernel(Testbench("rebound neuron", neuron, sources, np.inf, watch=("spike",)), silicon)


def check_box(model: ReboundModel, silicon: Silicon, path: str = "") -> Located:
    """Ask of `chips.validity` that a silicon is inside the record's validity box; returns what is there.

    path: instance path that an error names; the circuit's own name unless given. Raises `ParameterError`
    outside, as there.
    """
    grid, box = model.record.grid, model.record.box
    name = path or model.circuit.name
    require_inside(f"{name}.temperature", silicon.temperature_c, grid.temperature, "degC")
    found = located(model, silicon)
    gate, d = found
    for k, i in enumerate(inhibition_current(d, gate["i_inh_tau"])):
        require_inside(f"{_element(model, name, k)}.i_inh_tau", float(i), grid.current, "A")
    used = {p.rpartition(".")[0] for q in model.record.quantities.values() for p in q.parameters} - {""}
    for device in sorted(used):
        for label, values, largest, unit in (
            ("v_t0_shift", d.shift[device], box.threshold, "V"),
            ("ln_beta_shift", d.log_beta[device], box.log_beta, ""),
        ):
            for k, each in enumerate(np.atleast_1d(values)):
                side = f"{_element(model, name, k)}.{device}.{label}"
                require_inside(side, float(each), (-largest, largest), unit)
    shift = np.ravel(gate["v_th"] - model.reference["v_th"])
    furthest = float(shift[np.argmax(np.abs(shift))])
    require_inside(f"{name}.v_th_shift", furthest, (-box.v_th, box.v_th), "V")
    return found


def _element(model: ReboundModel, name: str, k: int) -> str:
    if neuron_of(model.circuit) is model.circuit:
        return name
    return f"{name}.{model.circuit.instances[0].name}[{k}]"
