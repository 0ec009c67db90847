"""How far ROLLS' neurons, filters and synapses differ on a die, and which transistor causes how much.

A quantity q of a part depends on the deviations of the part's own transistors, each drawn with
`sigma(V_T0) = A_VT / sqrt(2 m W L)` and alike for beta. To first order in them

    var(ln q) = sum over devices and parameters of s^2,   s = [ln q(+sigma) - ln q(-sigma)] / 2,

one deviation at a time in the behavioural model (of the same transistors), so that s^2 / var is a device's
share; two quantities of one part correlate by `sum s_a s_b / (sigma_a sigma_b)`. `sampled` has the same
quantities on the very neurons of a die, all deviations together.

Capacitors have no mismatch in this project, and an ideal bias's copy shifts all neurons alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from chips.rolls.circuit import Params, chip
from chips.rolls.lumped.filter import filter_of, line_voltage
from chips.rolls.lumped.whole_filter import output_at
from chips.rolls.neuron.model import neurons_of
from chips.rolls.parts import devices_at, gate_voltages, part_gates, row_place
from chips.rolls.portrait import DC, LONGEST, dc_currents, membrane_tau, rates, rheobase
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.program import level_current
from chips.rolls.synapse.charge import WEIGHT_DEVICES, draw_of, pulse_length
from chips.rolls.tables import Prepared, prepare
from circuits.arrays import F64
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.circuit import BiasKind, Circuit
from circuits.devices.ekv import of_weak
from circuits.lowering.on_die import DieDevices, transistor_names, transistor_of
from circuits.silicon.die import NOMINAL, Path
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

Quantities = Mapping[str, F64]

# Hz of the nominal neuron, at whose currents rates are compared; ours. Below, a neuron on two is silent, and
# ln q has no spread
RATES = (50.0, 100.0, 200.0, 500.0)
INPUT = 1e-9  # A, ours: mean input of a filter, at which its gain is taken
BISECTIONS = 24
PARAMETERS = ("v_t0", "beta")


@dataclass(frozen=True, slots=True)
class Spread:
    """Spread of one quantity: shares s of every device and parameter, by label, float64[2 devices]."""

    name: str
    labels: tuple[str, ...]
    shares: F64

    @property
    def cv(self) -> float:
        """Predicted standard deviation of the quantity's logarithm."""
        return float(np.sqrt((self.shares**2).sum()))

    def by_device(self) -> dict[str, float]:
        """Return each device's share of the variance, both parameters together, the largest first."""
        found: dict[str, float] = {}
        for label, s in zip(self.labels, self.shares, strict=True):
            device = label.rpartition(".")[0]
            found[device] = found.get(device, 0.0) + float(s) ** 2
        total = self.cv**2
        return {k: v / total for k, v in sorted(found.items(), key=lambda item: -item[1])}


@dataclass(frozen=True, slots=True)
class PartOfRow:
    """A part of a row, with what is measured of it.

    place: below a row, or of the chip; measure: of n copies of it, gives float64[n] by name.
    """

    name: str
    circuit: Circuit
    place: Path
    gates: Mapping[str, float]
    wanted: Sequence[str] | None
    prefix: str
    measure: Callable[[DieDevices], Quantities]


def correlation(a: Spread, b: Spread) -> float:
    """Return the predicted correlation of the logarithms of two quantities of one part."""
    return float((a.shares * b.shares).sum() / (a.cv * b.cv))


def parts_of(
    table: BiasTable, silicon: Silicon, kind: BiasKind = "gate", params: Params | None = None
) -> tuple[PartOfRow, ...]:
    """Return neuron, filters, pulse extender and synapse of a chip with the biases of `table`, I_dc apart."""
    params = Params() if params is None else params
    gates = gate_voltages(chip(params, table.with_code(DC, 7, 0), kind), replace(silicon, die=NOMINAL))
    ready = prepare(params, silicon.process)
    nominal = replace(silicon, die=NOMINAL)
    s = params.synapse
    found = [_neuron(params, ready, gates, nominal)]
    for k, (name, make) in enumerate((
        ("excitatory", dpi_synapse.excitatory_filter), ("inhibitory", dpi_synapse.inhibitory_filter),
    )):  # fmt: skip
        found.append(_filter(name, make(s), ready.filters[k], part_gates(name, gates)))
    extender = dpi_synapse.pulse_extender(s)
    lengths = lambda d: {"pulse length": pulse_length(ready.synapse, d)}  # noqa: E731
    where: Path = (("extender", (NEURONS,)),)
    found.append(
        PartOfRow("extender", extender, where, part_gates("extender", gates), None, "extender.", lengths)
    )
    found.append(_synapse(params, ready, table, gates, nominal))
    return tuple(found)


def predicted(part: PartOfRow, process: Process, silicon: Silicon) -> dict[str, Spread]:
    """Return the spread of each quantity of a part to first order, by one deviation at a time."""
    names, sigmas = _sigmas(part, process)
    count = len(names)
    base = _devices(part, (("copy", (4 * count,)),), replace(silicon, die=NOMINAL))
    fets = dict(base.fet)
    # copies: V_T0 up, V_T0 down, beta up, beta down, each of all devices in turn
    for j, name in enumerate(names):
        fet = fets[name]
        current, threshold = fet.current.copy(), fet.threshold.copy()
        for k, sign in enumerate((1.0, -1.0)):
            threshold[k * count + j] += sign * sigmas[j, 0]
            current[(2 + k) * count + j] *= 1.0 + sign * sigmas[j, 1]
        fets[name] = fet._replace(current=current, threshold=threshold)
    labels = tuple(f"{name}.{parameter}" for parameter in PARAMETERS for name in names)
    found = {}
    for quantity, values in part.measure(base._replace(fet=fets)).items():
        up_v, down_v, up_b, down_b = np.log(values).reshape(4, count)
        found[quantity] = Spread(quantity, labels, np.concatenate((up_v - down_v, up_b - down_b)) / 2.0)
    return found


def sampled(part: PartOfRow, silicon: Silicon) -> Quantities:
    """Return the quantities on all neurons (or columns, or synapses) of a die, by mismatch alone."""
    own = replace(silicon, die=replace(silicon.die, process=False))
    return part.measure(_devices(part, part.place, own))


def _devices(part: PartOfRow, place: Path, silicon: Silicon) -> DieDevices:
    return devices_at(part.circuit, place, silicon, part.gates, part.wanted, part.prefix)


def _sigmas(part: PartOfRow, process: Process) -> tuple[list[str], F64]:
    """Names of a part's transistors, and sigma of V_T0 (V) and of beta of each, float64[devices, 2]."""
    names = [n for n in transistor_names(part.circuit) if part.wanted is None or n in part.wanted]
    root = np.sqrt([2.0 * transistor_of(part.circuit, name).gate_area for name in names])
    sigmas = np.stack((process.pair_a_vt / root, process.pair_a_beta / root), axis=-1)
    return [part.prefix + name for name in names], sigmas


def _neuron(params: Params, ready: Prepared, gates: Mapping[str, float], nominal: Silicon) -> PartOfRow:
    own, circuit = part_gates("neuron", gates), rolls_neuron.build(params.neuron)
    reference = devices_at(circuit, (("copy", (1,)),), nominal, own)
    currents = currents_at(reference, ready, RATES)

    def measure(d: DieDevices) -> Quantities:
        m = neurons_of(d, ready.neuron)
        drives = dc_currents(d, reference, currents)
        lengths = np.minimum(20.0 / np.array(RATES), LONGEST)
        found = rates(m, drives, lengths)
        return {f"rate at {rate:g} Hz": f for rate, f in zip(RATES, found, strict=True)} | {
            "membrane time constant": membrane_tau(d, ready, np.zeros(d.copies, np.bool_)),
            "threshold current": rheobase(m),
            "refractory period": m.refractory,
        }

    return PartOfRow("neuron", circuit, row_place(NEURONS, ("neuron", ())), own, None, "", measure)


def currents_at(reference: DieDevices, ready: Prepared, wanted: Sequence[float]) -> F64:
    """Return the currents at which the nominal neuron fires at rates (Hz), A."""
    one = neurons_of(reference, ready.neuron)
    low = np.full(len(wanted), float(rheobase(one)[0]))
    high = 1e3 * low
    rate = np.array(wanted)
    for _ in range(BISECTIONS):
        middle = np.sqrt(low * high)
        above = rates(one, middle[:, None], np.minimum(4.0 / rate, LONGEST))[:, 0] > rate
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(high)


def _filter(
    name: str, circuit: Circuit, capacitance: tuple[float, float], gates: Mapping[str, float]
) -> PartOfRow:
    inhibitory = name == "inhibitory"

    def measure(d: DieDevices) -> Quantities:
        f = filter_of(d, *capacitance, inhibitory=inhibitory)
        leak = f.unit / f.tau  # A: what a mean input has to bring for v to stay at 1
        v = INPUT / leak
        strength = v**f.power if f.whole is None else output_at(f.whole, INPUT, v - 1.0)
        out = f.specific * of_weak(f.scale * strength)
        return {f"{name} time constant": f.tau, f"{name} gain": out / INPUT}

    return PartOfRow(name, circuit, row_place(NEURONS, (name, ())), gates, None, "", measure)


def _synapse(
    params: Params, ready: Prepared, table: BiasTable, gates: Mapping[str, float], nominal: Silicon
) -> PartOfRow:
    lines = {}
    for k, (name, make) in enumerate((
        ("excitatory", dpi_synapse.excitatory_filter), ("inhibitory", dpi_synapse.inhibitory_filter),
    )):  # fmt: skip
        d = devices_at(make(params.synapse), (("copy", (1,)),), nominal, part_gates(name, gates))
        lines[1 - 2 * k] = filter_of(d, *ready.filters[k], inhibitory=bool(k))

    def measure(d: DieDevices) -> Quantities:
        found = {}
        for level in (1, 4, -1, -4):
            line = line_voltage(lines[1 if level > 0 else -1], level_current(table, level), d.u_t)
            found[f"weight {level:+d}"] = draw_of(ready.synapse, d, level, line).current
        return found

    circuit = dpi_synapse.synapse(params.synapse)
    # a thousand synapses of a row's 65,536 tell the spread
    place = row_place(4, ("synapse", (NEURONS,)))
    return PartOfRow(
        "synapse", circuit, place, part_gates("synapse", gates), WEIGHT_DEVICES, "synapse.", measure
    )
