"""Parameters of a testbench on its silicon, and what each moves measures by, from an adjoint run.

Each has the label that a study's draws have (`circuits.silicon.sampling`):

| label ends with | derivative by | what it moves |
|---|---|---|
| `v_t0` | the threshold's magnitude, V | channels |
| `beta` | the relative current factor | channels |
| `width`, `length` | m | channels, junctions, capacitances, and deviations by their area |
| `capacitance` | F | capacitors |
| `resistance` | Ohm | resistors |
| `saturation_current`, ... | a figure of `circuits.gradient.diode` | a diode's current and charge |
| `process.n.shared.v_t0`, ... | what a polarity shares | its channels, and biases that stand on the die |
| `process.diode.shared.saturation_current` | what diodes share, relative | all diodes |
| `bias.NAME` | the bias's current, A, or voltage, V | gates at its line |
| `bias copy. ...`, `bias generator. ...` | `v_t0`, `beta` of what a bias stands on | gates at its lines |
| `temperature` | degC | everything but capacitances |

Bias voltages stay as they are where a size moves. A die keeps its draws: a wider device deviates less.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, Bools
from circuits.circuit import Bias, Circuit
from circuits.devices import Capacitor, Diode, Resistor, Transistor
from circuits.devices.transistor import capacitances
from circuits.gradient.backwards import Adjoint, contracted
from circuits.gradient.diode import FIGURES, by_figures
from circuits.gradient.flow import flow_of, sloped
from circuits.gradient.sums import OVERLAPS, Sums, ends_of, groups_of
from circuits.gradient.tap import carried_by
from circuits.lowering.bias_moves import bias_moves, voltages_at
from circuits.lowering.flatten import DeviceGroup
from circuits.lowering.kernel import Machine, diode_figures, on_die
from circuits.lowering.made import made
from circuits.silicon.die import PARAMETERS, shared
from circuits.silicon.process import POLARITIES
from circuits.silicon.sampling import labels

KELVIN, VOLT, RELATIVE = 1e-2, 1e-5, 1e-4  # steps of what is moved as a whole; ours
FEW = 1000  # rows; ours

TEMPERATURE = "temperature"
BIAS = "bias."  # before the name of a bias


class Rows(NamedTuple):
    """Parameters of one kind: labels, unit, sigma and derivatives, float64[measures, n].

    varies: whether the silicon's dies differ in them.
    """

    labels: Sequence[str]
    unit: str
    sigma: F64
    by: F64
    varies: bool = True


def rows_of(machine: Machine, found: Adjoint) -> list[Rows]:
    """All parameters, and what each moves measures by, from an adjoint run of them."""
    sums, measures = found.sums, found.moved.shape[0]
    devices = _transistors(machine, groups_of(machine, Transistor), sums)
    lines = _lines(machine, found)
    first = (1 + len(OVERLAPS)) * machine.kernel.transistors.sign.size
    capacitors, charge = groups_of(machine, Capacitor), sums.charge[:, first:]
    kinds = [
        *devices, _passive(machine, capacitors, "capacitance", charge),
        _passive(machine, groups_of(machine, Resistor), "resistance", sums.conductance),
        *_diodes(machine, found), *_shared(machine, devices, lines),
        *_biases(machine, lines), *_behind_biases(machine, lines, measures), _temperature(machine, found),
    ]  # fmt: skip
    return [rows for rows in kinds if len(rows.labels)]


def _names(machine: Machine, groups: Sequence[DeviceGroup], parameter: str) -> list[str]:
    silicon = machine.silicon
    place = ((machine.flat.circuit.name, ()),) if silicon.place is None else silicon.place
    paths = [(*g.path, (g.device.name, ())) for g in groups]
    return labels(place, paths, parameter)


def _sizes(groups: Sequence[DeviceGroup], name: str) -> F64:
    return np.concatenate([np.zeros(0), *(g.parameters[name] for g in groups)])


def _transistors(machine: Machine, groups: Sequence[DeviceGroup], sums: Sums) -> list[Rows]:
    """Thresholds, current factors, widths and lengths."""
    silicon, arrays = machine.silicon, machine.kernel.transistors
    width, length, many = (_sizes(groups, name) for name in ("width", "length", "multiplicity"))
    root = np.sqrt(2.0 * width * length * many)
    paths = [(*g.path, (g.device.name, ())) for g in groups]
    polarities = [g.device.polarity for g in groups if isinstance(g.device, Transistor)]
    own = silicon.deviations(machine.flat.circuit.name, paths, width * length * many, polarities)
    v_t0, beta = (np.broadcast_to(np.asarray(x, np.float64), width.shape) for x in own)
    by_v, by_beta = -arrays.sign * sums.by_gate, sums.current / (1.0 + beta)
    # a die keeps its draws: what deviates goes with 1 / sqrt(W L)
    by_area = -0.5 * (by_v * v_t0 + by_beta * beta)
    channel, overlap = _capacitance(machine, groups)
    shares = sums.charge[:, : 5 * width.size].reshape(sums.charge.shape[0], 5, width.size)
    at_gate, around = shares[:, 0] * channel, (shares[:, 1:] * overlap).sum(axis=1)
    by_width = (sums.current + sums.junction + at_gate + around + by_area) / width
    by_length = (at_gate - sums.current - sums.early + by_area) / length
    process, none, varies = silicon.process, np.zeros(width.size), silicon.die.mismatch
    return [
        Rows(_names(machine, groups, "v_t0"), "V", process.pair_a_vt / root, by_v, varies),
        Rows(_names(machine, groups, "beta"), "", process.pair_a_beta / root, by_beta, varies),
        Rows(_names(machine, groups, "width"), "m", none, by_width),
        Rows(_names(machine, groups, "length"), "m", none, by_length),
    ]


def _capacitance(machine: Machine, groups: Sequence[DeviceGroup]) -> tuple[F64, F64]:
    """Capacitances of gates to the bulk, F, float64[devices], and of the other pairs, float64[4, devices]."""
    each = [
        capacitances(machine.silicon.process.model(g.device.polarity), *(g.parameters[n] for n in _SIZES))
        for g in groups
        if isinstance(g.device, Transistor)
    ]
    gate = np.concatenate([np.zeros(0), *(own[1, 3] for own in each)])
    others = [np.concatenate([np.zeros(0), *(own[pair] for own in each)]) for pair in OVERLAPS]
    return gate, np.stack(others)


_SIZES = ("width", "length", "multiplicity")


def _passive(machine: Machine, groups: Sequence[DeviceGroup], parameter: str, by: F64) -> Rows:
    """Capacitors, or resistors, whose conductance is what `by` is of."""
    silicon, circuit = machine.silicon, machine.flat.circuit.name
    value = np.concatenate([np.zeros(0), *(made(g, circuit, silicon) for g in groups)])
    sigma, components = np.zeros(value.size), silicon.process.components
    if parameter == "resistance":
        return Rows(_names(machine, groups, parameter), "Ohm", sigma, -by / value**2)
    if components is not None and silicon.die.variation == "full":
        drawn = _sizes(groups, parameter)
        sigma = value * components.pair_a_capacitance * np.sqrt(0.5 * components.capacitance_density / drawn)
    return Rows(_names(machine, groups, parameter), "F", sigma, by, silicon.die.mismatch)


def _diodes(machine: Machine, found: Adjoint) -> list[Rows]:
    """Figures of diodes, and what diodes share where the process says how far they differ."""
    groups, silicon = groups_of(machine, Diode), machine.silicon
    if not groups:
        return []
    values = diode_figures(machine.flat, silicon)
    by = by_figures(machine, found, values)
    drawn = {name: _sizes(groups, name) for name in ("area", "saturation_current")}
    common = 1.0 + np.asarray(_alone(machine, groups, drawn["area"]))
    own = values["saturation_current"] / (drawn["saturation_current"] * common)  # 1 and what is the diode's
    # a die keeps its draws: what deviates goes with 1 / sqrt(area)
    by["area"] -= 0.5 * (1.0 - 1.0 / own) * by["saturation_current"]
    figures = silicon.process.diodes
    sigma, kinds = {name: np.zeros(own.size) for name in FIGURES}, []
    if figures is not None:
        apart = figures.pair_a_saturation / np.sqrt(2.0 * drawn["area"])
        sigma["saturation_current"] = values["saturation_current"] * apart / own
    for name, unit in FIGURES.items():
        there = np.flatnonzero(values[name] != 0.0)
        names, value = _names(machine, groups, name), values[name][there]
        moves, labelled = by[name][:, there] / value, [names[k] for k in there]
        kinds.append(Rows(labelled, unit, sigma[name][there], moves, silicon.die.mismatch))
    if figures is not None:
        shared_by = (by["saturation_current"] / common).sum(axis=1)
        label = "process.diode.shared.saturation_current"
        over_dies = np.array([figures.sigma_saturation])
        kinds.append(Rows([label], "", over_dies, shared_by[:, None], _process_varies(machine)))
    return kinds


def _alone(machine: Machine, groups: Sequence[DeviceGroup], area: F64) -> F64 | float:
    """What diodes change by together, without what each has of its own."""
    silicon = replace(machine.silicon, die=machine.silicon.die.without_mismatch())
    paths = [(*g.path, (g.device.name, ())) for g in groups]
    return silicon.change(machine.flat.circuit.name, paths, "diode", area).value


def _lines(machine: Machine, found: Adjoint) -> dict[int, F64]:
    """What the voltage of each bias line moves the readings by, unit/V, by the number of its source."""
    given, lines, k, sums = len(machine.testbench.sources), {}, machine.kernel, found.sums
    ends = ends_of(machine)
    taken = [(m, tap.conducted.sum() * flow_of(machine, tap.name, ends).linear) for m, tap in found.taps]
    slopes: F64 | None = None
    total, row_of = found.moved.sum(axis=1), np.repeat(np.arange(k.unknowns), np.diff(k.conductance.start))
    for number in range(given, len(machine.source_names)):
        column = k.unknowns + number
        by = _at_terminals(k.transistors.terminal == column, sums)
        own = k.conductance.column == column
        by = by - total[:, row_of[own]] @ k.conductance.value[own]
        if (k.amplifier_terminal == column).any() or (k.diodes.terminal == column).any():
            if slopes is None:
                slopes = sloped(k, found.voltage, found.moved)
            by = slopes[:, column] + (found.given[:, :, number].sum(axis=1) if found.given.size else 0.0)
        else:
            for m, linear in taken:
                by[m] += linear[column]
            by = by + (found.beside[:, number] if found.beside.size else 0.0)
        lines[number] = by
    return lines


def _at_terminals(at: Bools, sums: Sums) -> F64:
    """What a voltage at some terminals of transistors does, float64[measures]; at: bool[4, transistors]."""
    drain, gate, source, bulk = at.astype(np.float64)
    channel = sums.by_drain * (drain - bulk) + sums.by_gate * (gate - bulk) + sums.by_source * (source - bulk)
    own = sums.junction_own * (np.stack([drain, source]) - bulk)
    by_gate = sums.junction_gate * (gate - bulk)
    return np.asarray(channel.sum(axis=1) + (own + by_gate).sum(axis=(1, 2)))


def _shared(machine: Machine, devices: Sequence[Rows], lines: dict[int, F64]) -> list[Rows]:
    """What a polarity shares."""
    silicon, sign = machine.silicon, machine.kernel.transistors.sign
    variation, found = silicon.process.variation, []
    for polarity in POLARITIES:
        own, shift = (sign > 0.0) == (polarity == "n"), shared(silicon.die, silicon.process, polarity)
        for name, rows, sigma in zip(
            PARAMETERS, devices, (variation.sigma_v_t0, variation.sigma_beta), strict=False
        ):
            by = rows.by[:, own].sum(axis=1)
            if name == "beta":
                # every current is in proportion to 1 + shift and to 1 + its own
                by = _by_shift(machine, rows.by, own, shift.beta)
            by = by + _by_lines(machine, lines, polarity, name, getattr(shift, name))
            label, unit = f"process.{polarity}.shared.{name}", "V" if name == "v_t0" else ""
            found.append(Rows([label], unit, np.array([sigma]), by[:, None], _process_varies(machine)))
    return found


def _process_varies(machine: Machine) -> bool:
    """Whether the process varies from die to die; a corner sets it."""
    die = machine.silicon.die
    return die.process and die.corner == "random"


def _by_shift(machine: Machine, by_beta: F64, own: Bools, shift: float) -> F64:
    groups = groups_of(machine, Transistor)
    paths = [(*g.path, (g.device.name, ())) for g in groups]
    area = _sizes(groups, "width") * _sizes(groups, "length") * _sizes(groups, "multiplicity")
    polarities = [g.device.polarity for g in groups if isinstance(g.device, Transistor)]
    beta = machine.silicon.deviations(machine.flat.circuit.name, paths, area, polarities).beta
    scale = np.broadcast_to((1.0 + np.asarray(beta)) / (1.0 + shift), own.shape)
    return np.asarray((by_beta * scale)[:, own].sum(axis=1))


def _by_lines(machine: Machine, lines: dict[int, F64], polarity: str, name: str, at: float) -> F64 | float:
    """What a shift does by biases that stand on the die."""
    if not any(bias.kind in {"ideal", "generator"} for bias in machine.testbench.circuit.biases):
        return 0.0
    step = VOLT if name == "v_t0" else RELATIVE
    ends = [
        _line_voltages(on_die(machine, machine.silicon.die.with_(f"process.{polarity}", name, at + s)))
        for s in (step, -step)
    ]
    return sum((by * (ends[0][n] - ends[1][n]) / (2.0 * step) for n, by in lines.items()), start=0.0)


def _line_voltages(machine: Machine) -> dict[int, float]:
    given = len(machine.testbench.sources)
    return {n: float(machine.polylines[n][1][0]) for n in range(given, len(machine.polylines))}


def _biases(machine: Machine, lines: dict[int, F64]) -> list[Rows]:
    """Biases by name, elements of an array one by one."""
    circuit, found = machine.testbench.circuit, []
    for bias in circuit.biases:
        shape = circuit.port(bias.port).shape
        value = np.broadcast_to(np.asarray(bias.value, np.float64), shape)
        by_value = np.ones(shape)
        if bias.kind != "voltage":
            ends = [voltages_at(circuit, bias, 1.0 + s, machine.silicon) for s in (RELATIVE, -RELATIVE)]
            by_value = (ends[0] - ends[1]) / (2.0 * RELATIVE * value)
        for name, by_one in zip(_elements(circuit, bias), by_value.ravel(), strict=True):
            number = machine.source_names.index(name) if name in machine.source_names else None
            if number in lines:
                by, tail = lines[number] * float(by_one), name.removeprefix(bias.port)
                unit = "V" if bias.kind == "voltage" else "A"
                found.append(Rows([f"{BIAS}{bias.name}{tail}"], unit, np.zeros(1), by[:, None]))
    return found


def _behind_biases(machine: Machine, lines: dict[int, F64], measures: int) -> list[Rows]:
    """Devices that biases stand on; what is behind several lines moves all of them."""
    circuit, process, none = machine.testbench.circuit, machine.silicon.process, np.zeros(measures)
    number = {name: k for k, name in enumerate(machine.source_names)}  # none of lines that sources drive
    found: dict[str, Rows] = {}
    for bias in circuit.biases:
        by_lines = np.array([lines.get(number.get(name, -1), none) for name in _elements(circuit, bias)])
        for moves in bias_moves(circuit, bias, machine.silicon):
            family, root = moves.family, np.sqrt(2.0 * moves.family.area)
            for name, unit, pair, by in (
                ("v_t0", "V", process.pair_a_vt, moves.by_v_t0),
                ("beta", "", process.pair_a_beta, moves.by_beta),
            ):
                names = labels(family.place, family.paths, name)
                rows = Rows(names, unit, pair / root, by_lines.T @ by, machine.silicon.die.mismatch)
                before = found.get(names[0])
                found[names[0]] = rows if before is None else rows._replace(by=rows.by + before.by)
    return list(found.values())


def _elements(circuit: Circuit, bias: Bias) -> list[str]:
    """Names of a bias's lines, in the order of its port."""
    shape = circuit.port(bias.port).shape
    return [bias.port + (f"[{','.join(map(str, i))}]" if shape else "") for i in np.ndindex(shape)]


def _temperature(machine: Machine, found: Adjoint) -> Rows:
    """The temperature of everything; biases that are fixed gate voltages stay."""
    silicon, before, ends = machine.silicon, _line_voltages(machine), []
    # the many rows of a run are gone through once, by a step of which one side alone is within 1e-4
    both = len(found.voltage) < FEW
    size = KELVIN if both else 0.1 * KELVIN
    for step in (size, -size) if both else (size,):
        other = replace(silicon, temperature_c=silicon.temperature_c + step)
        there = on_die(replace(machine, silicon=other), silicon.die)
        voltage = found.voltage.copy()
        beside = np.zeros(found.moved.shape[0])
        for number, value in _line_voltages(there).items():
            voltage[:, machine.kernel.unknowns + number] += value - before[number]
            if found.beside.size:
                beside += (value - before[number]) * found.beside[:, number]
        ends.append(_direct(there, voltage, found) + beside)
    by = (ends[0] - ends[1]) / (2.0 * size) if both else (ends[0] - found.sums.direct) / size
    return Rows([TEMPERATURE], "degC", np.zeros(1), by[:, None])


def _direct(machine: Machine, voltage: F64, found: Adjoint) -> F64:
    """What flows without charge gives the measures on a silicon at some voltages, float64[measures]."""
    own = contracted(machine.kernel, voltage, found.moved)
    return own + carried_by(machine, voltage, found.taps, ends_of(machine), own.size) if found.taps else own
