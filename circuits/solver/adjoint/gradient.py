"""Gradients of measures by all devices and parameters of a testbench on its silicon.

    found = gradients_of(machine, (SpikeTime("spike"), Voltage("v_mem", 5e-3)))

runs the testbench once, and once backwards (`circuits.solver.adjoint.backwards`). Parameters, each with the
label that a study's draws have (`circuits.silicon.sampling`):

| label ends with | derivative by | what it moves |
|---|---|---|
| `v_t0` | the threshold's magnitude, V | channels |
| `beta` | the relative current factor | channels |
| `width`, `length` | m | channels, junctions, capacitances, and deviations by their area |
| `capacitance` | F | capacitors |
| `resistance` | Ohm | resistors |
| `saturation_current`, ... | a figure of `circuits.solver.adjoint.diode` | a diode's current and charge |
| `process.n.shared.v_t0`, ... | what a polarity shares | its channels, and biases that stand on the die |
| `process.diode.shared.saturation_current` | what diodes share, relative | all diodes |
| `bias.NAME` | the bias's current, A, or voltage, V | gates at its line |
| `bias copy. ...`, `bias generator. ...` | `v_t0`, `beta` of what a bias stands on | gates at its lines |
| `temperature` | degC | everything but capacitances |

Bias voltages stay as they are where a size moves. A die keeps its draws: a wider device deviates less.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.circuit import Bias, Circuit
from circuits.devices import Capacitor, Diode, Resistor, Transistor
from circuits.devices.transistor import capacitances
from circuits.errors import ParameterError, SolverError
from circuits.lowering.bias_moves import bias_moves, voltages_at
from circuits.lowering.flatten import DeviceGroup
from circuits.lowering.kernel import Machine, diode_figures, on_die
from circuits.lowering.made import made
from circuits.silicon.die import PARAMETERS, shared
from circuits.silicon.process import POLARITIES
from circuits.silicon.sampling import labels
from circuits.solver.adjoint.backwards import Sums, backwards, contracted
from circuits.solver.adjoint.diode import FIGURES, by_figures
from circuits.solver.adjoint.measure import Measure, Reading, SpikeTime, Voltage
from circuits.solver.adjoint.way import Way, way_of
from circuits.solver.beginning import beginning, held_voltages
from circuits.solver.outcome import Outcome
from circuits.solver.transient import Result, Steps, simulate

GRADIENT_RTOL = 1e-8
"""Local error of a step, relative to the larger of |v| and 1 V, at which what edges move is resolved; ours.

At 5e-7 what a pulse's length does to a plastic synapse's weight is 23 % off, at 1e-8 1.3 %.
"""
KELVIN, VOLT, RELATIVE = 1e-3, 1e-5, 1e-4  # steps of what is moved as a whole; ours
SAFE = 3.0  # sigma: a spike whose peak is nearer to the threshold than that is told of; ours

RAIL = 0.02  # of the supply, within which a peak stands at it; ours
FEW, FLAT = 3, 0.1  # points of a spike, and the share of its height that its top may change by; ours

RESOLVED = 200.0  # times the tolerance in V, above which 1 % of what a voltage moves by is resolved; ours

TEMPERATURE = "temperature"
BIAS = "bias."  # before the name of a bias


@dataclass(frozen=True, slots=True, eq=False)
class Gradients:
    """Gradients of some measures of a testbench.

    Attributes
    ----------
    measures, units : tuple of str
        Name and SI unit of each measure.
    values : array
        Their values, float64[measures], in SI units; NaN where one is not defined.
    notes : tuple of str
        Why a measure has no value, or where it is not smooth; empty else.
    labels, of_units : tuple of str
        Label of each parameter, and its SI unit, empty for a relative one.
    sigma : array
        Standard deviation of each parameter over dies, float64[parameters]; 0 for what no die draws, and for
        mismatch or process where the silicon's dies have none of it.
    by : array
        Derivative of each measure by each parameter, float64[measures, parameters], in SI units.
    result : Result
        The run that was measured.
    """

    measures: tuple[str, ...]
    units: tuple[str, ...]
    values: F64
    notes: tuple[str, ...]
    labels: tuple[str, ...]
    of_units: tuple[str, ...]
    sigma: F64
    by: F64 = field(repr=False)
    result: Result = field(repr=False)

    @property
    def spread(self) -> F64:
        """Standard deviation of each measure over dies in the linear theory, float64[measures].

        Of components of variation it has those of single capacitors alone.
        """
        return np.asarray(np.sqrt(((self.by * self.sigma) ** 2).sum(axis=1)))


class _Rows(NamedTuple):
    """Parameters of one kind: labels, unit, sigma and derivatives, float64[measures, n].

    varies: whether the silicon's dies differ in them.
    """

    labels: Sequence[str]
    unit: str
    sigma: F64
    by: F64
    varies: bool = True


def gradients_of(machine: Machine, measures: Sequence[Measure], *, rtol: float = GRADIENT_RTOL) -> Gradients:
    """Return the gradients of some measures.

    Parameters
    ----------
    machine
        Lowered testbench on its silicon.
    measures
        What is measured.
    rtol
        Local error of a step of the transient, relative to the larger of |v| and 1 V.

    Raises
    ------
    ParameterError
        There is no measure.
    SolverError
        The solver gives up, or the way backwards is singular.
    """
    if not measures:
        raise ParameterError(f"{machine.testbench.title}: no measure, must be at least one")
    result = _run(machine, measures, rtol)
    way = way_of(result)
    read = [each.read(result, way) for each in measures]
    guards = [_guards(each, found, result, way) for each, found in zip(measures, read, strict=True)]
    every = [*read, *(guard.reading for own in guards for guard in own)]
    way = _until(way, every)
    asked = [k for k, each in enumerate(every) if each.slopes]
    solved = _parameters(machine, way, [every[k] for k in asked])
    by = np.full((len(every), sum(len(rows.labels) for rows in solved)), np.nan)
    by[asked] = np.concatenate([rows.by for rows in solved], axis=1)
    sigma = np.concatenate([rows.sigma for rows in solved])
    spread = np.sqrt(((by * sigma) ** 2).sum(axis=1))
    small = np.array([m.unit == "V" for m in measures]) & (spread[: len(read)] > 0.0)
    small &= spread[: len(read)] < RESOLVED * rtol
    kicked = _kicked(machine, way)
    notes = tuple(note or kicked for note in _notes(read, guards, spread, small, result))
    sigma = np.concatenate([rows.sigma * rows.varies for rows in solved])
    names = [(label, rows.unit) for rows in solved for label in rows.labels]
    return Gradients(
        tuple(m.name for m in measures), tuple(m.unit for m in measures),
        np.array([r.value for r in read]), notes, tuple(n for n, _ in names), tuple(u for _, u in names),
        sigma, by[: len(read)], result,
    )  # fmt: skip


def _run(machine: Machine, measures: Sequence[Measure], rtol: float) -> Result:
    """The testbench's run; of its beginning alone where nothing else is measured."""
    if any(not isinstance(m, Voltage) or m.at is not None for m in measures):
        return simulate(machine, rtol=rtol)
    begun = beginning(machine)
    first = begun.voltage[machine.column][None, :]
    return Result(
        machine,
        Outcome.DONE,
        np.zeros(1),
        first,
        machine.names,
        {},
        Steps(0, 0, 0),
        begun.point,
        begun.disturbance,
    )


class _Guard(NamedTuple):
    """A peak beside a spike: its reading, how far it is from the threshold, V, and what happens there."""

    reading: Reading
    margin: float
    what: str


def _guards(measure: Measure, found: Reading, result: Result, way: Way) -> list[_Guard]:
    """The peak of a spike, and the highest one before it that is none."""
    if not isinstance(measure, SpikeTime) or not np.isfinite(found.value):
        return []
    column = result.machine.column_of(measure.port)
    row = max(int(np.searchsorted(way.time, found.value)), 1)
    level = float(np.interp(found.value, way.time[row - 1 : row + 1], way.voltage[row - 1 : row + 1, column]))
    tops = [(_top(way, row, column, level), f"spike {measure.number} vanishes")]
    y = way.voltage[:row, column]
    low = np.flatnonzero((y[1:-1] > y[:-2]) & (y[1:-1] >= y[2:]) & (y[1:-1] < level)) + 1
    if low.size:
        best = int(low[np.argmax(y[low])])
        tops.append((best, f"another one appears before spike {measure.number}"))
    own = []
    for top, what in tops:
        if 0 < top < way.time.size - 1 and not _at_rail(result.machine, way, top, column):
            value = float(way.voltage[top, column])
            # in the frame of the steps, which moves with the spike
            own.append(_Guard(Reading(value, ((top, column, 1.0),)), abs(value - level), what))
    return own


def _at_rail(machine: Machine, way: Way, row: int, column: int) -> bool:
    """Whether a voltage stands at ground or at the highest source, which it does not leave gradually."""
    fixed = way.voltage[row, machine.kernel.unknowns :]
    high = float(fixed.max(initial=0.0))
    at = float(way.voltage[row, column])
    return min(abs(high - at), abs(at)) < RAIL * high


def _top(way: Way, row: int, column: int, level: float) -> int:
    """Row of a spike's peak, from that at which it begins; at its edges a voltage moves with time."""
    below = np.flatnonzero(way.voltage[row:, column] < level)
    end = row + int(below[0]) if below.size else way.time.size
    y, t = way.voltage[row:end, column], way.time[row:end]
    if y.size < FEW:
        return row + int(np.argmax(y))
    rate = np.abs(np.gradient(y, t)) * (t[-1] - t[0])
    flat = rate <= max(float(rate.min()), FLAT * float(y.max() - level))
    return row + int(np.argmax(np.where(flat, y, -np.inf)))


def _notes(
    read: Sequence[Reading],
    guards: Sequence[Sequence[_Guard]],
    spread: F64,
    small: Bools,
    result: Result,
) -> tuple[str, ...]:
    """What is to be said of each measure; spread: of the measures and of the guards."""
    at, notes = len(read), []
    for k, (found, own) in enumerate(zip(read, guards, strict=True)):
        told = [found.note] if found.note else []
        if small[k]:
            told.append(f"moves by {spread[k]:.2g} V over dies, which is less than the run resolves")
        if not told and result.disturbance is not None:
            told.append(f"{result.disturbance}, which is held")
        for guard in own:
            away = guard.margin / spread[at] if spread[at] > 0.0 else np.inf
            if away < SAFE:
                told.append(f"{guard.what} {away:.2g} sigma away, {guard.margin:.3g} V from the threshold")
            at += 1
        notes.append("; ".join(told))
    return tuple(notes)


def _kicked(machine: Machine, way: Way) -> str:
    """What is left out of a run with uic in which sources, by capacitances, move nodes before it begins."""
    if machine.testbench.begin != "uic":
        return ""
    before = np.zeros(machine.kernel.columns)
    for node, voltage in machine.testbench.initial.items():
        before[machine.column_of(node)] = voltage
    first, last = machine.kernel.charges, machine.kernel.unknowns
    apart = np.where(machine.kernel.dynamic, way.voltage[0, :last] - before[:last], 0.0)[first:]
    worst = int(np.argmax(np.abs(apart))) if apart.size else 0
    if not apart.size or abs(apart[worst]) <= VOLT:
        return ""
    node = machine.names[int(np.flatnonzero(machine.column == first + worst)[0])]
    return f"uic: sources move {node} by {apart[worst]:.3g} V as it begins, of which the gradient has nothing"


def _until(way: Way, read: Sequence[Reading]) -> Way:
    """The way up to the last point that is measured."""
    end = 1 + max((row for found in read for row, _, _ in found.slopes), default=0)
    return Way(
        way.time[:end], way.voltage[:end], way.share[:end], way.order[:end], way.drive[:end], way.free[:end]
    )


def _parameters(machine: Machine, way: Way, read: Sequence[Reading]) -> list[_Rows]:
    """All parameters with what each moves the readings by."""
    k = machine.kernel
    slopes, timing = np.zeros((len(read), way.time.size, k.unknowns)), np.zeros((len(read), way.time.size))
    for m, each in enumerate(read):
        for row, slope in each.timing:
            timing[m, row] += slope
        for row, column, slope in each.slopes:
            if column < k.unknowns:
                slopes[m, row, column] += slope
            elif column < k.columns - 1:  # a source, which moves with the time alone
                timing[m, row] += slope * way.drive[row, column - k.unknowns]
    fets, capacitors, resistors = (_groups(machine, kind) for kind in (Transistor, Capacitor, Resistor))
    pairs = [_ends(machine, fets, (1, 3)), *(_ends(machine, fets, p) for p in _OVERLAPS)]
    charged = np.concatenate([*pairs, _ends(machine, capacitors, (0, 1))], axis=1)
    solved = backwards(k, way, slopes, timing, _held(machine), charged, _ends(machine, resistors, (0, 1)))
    if solved is None:
        title = machine.testbench.title
        raise SolverError(f"{title}: singular at its beginning; look for a node that floats")
    moved, sums = solved
    devices = _transistors(machine, fets, sums)
    lines = _lines(machine, way, moved, sums)
    first = len(pairs) * k.transistors.sign.size
    found = [
        *devices, _passive(machine, capacitors, "capacitance", sums.charge[:, first:]),
        _passive(machine, resistors, "resistance", sums.conductance), *_diodes(machine, way, moved),
        *_shared(machine, devices, lines),
        *_biases(machine, lines), *_behind_biases(machine, lines, len(read)),
        _temperature(machine, way, moved, sums),
    ]  # fmt: skip
    return [rows for rows in found if len(rows.labels)]


_OVERLAPS = ((1, 0), (1, 2), (0, 3), (2, 3))  # of a transistor's terminals, as `capacitances` has them


def _held(machine: Machine) -> Bools:
    """Which unknowns are held at the beginning."""
    held = np.zeros(machine.kernel.unknowns, dtype=np.bool_)
    bench = machine.testbench
    if bench.begin == "uic":
        held[machine.kernel.charges :] = True  # charges follow the voltages that are held
        return held
    for node in held_voltages(bench, machine.flat, machine.silicon):
        held[machine.column_of(node)] = True
    return held


def _groups(machine: Machine, kind: type) -> list[DeviceGroup]:
    return [g for g in machine.flat.groups if isinstance(g.device, kind)]


def _ends(machine: Machine, groups: Sequence[DeviceGroup], pair: tuple[int, int]) -> I64:
    """Columns of two terminals of all devices of some groups, int64[2, devices]."""
    found = [machine.column[group.nodes[list(pair)]] for group in groups]
    return np.concatenate([np.zeros((2, 0), np.int64), *found], axis=1)


def _names(machine: Machine, groups: Sequence[DeviceGroup], parameter: str) -> list[str]:
    silicon = machine.silicon
    place = ((machine.flat.circuit.name, ()),) if silicon.place is None else silicon.place
    paths = [(*g.path, (g.device.name, ())) for g in groups]
    return labels(place, paths, parameter)


def _sizes(groups: Sequence[DeviceGroup], name: str) -> F64:
    return np.concatenate([np.zeros(0), *(g.parameters[name] for g in groups)])


def _transistors(machine: Machine, groups: Sequence[DeviceGroup], sums: Sums) -> list[_Rows]:
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
        _Rows(_names(machine, groups, "v_t0"), "V", process.pair_a_vt / root, by_v, varies),
        _Rows(_names(machine, groups, "beta"), "", process.pair_a_beta / root, by_beta, varies),
        _Rows(_names(machine, groups, "width"), "m", none, by_width),
        _Rows(_names(machine, groups, "length"), "m", none, by_length),
    ]


def _capacitance(machine: Machine, groups: Sequence[DeviceGroup]) -> tuple[F64, F64]:
    """Capacitances of gates to the bulk, F, float64[devices], and of the other pairs, float64[4, devices]."""
    each = [
        capacitances(machine.silicon.process.model(g.device.polarity), *(g.parameters[n] for n in _SIZES))
        for g in groups
        if isinstance(g.device, Transistor)
    ]
    gate = np.concatenate([np.zeros(0), *(own[1, 3] for own in each)])
    others = [np.concatenate([np.zeros(0), *(own[pair] for own in each)]) for pair in _OVERLAPS]
    return gate, np.stack(others)


_SIZES = ("width", "length", "multiplicity")


def _passive(machine: Machine, groups: Sequence[DeviceGroup], parameter: str, by: F64) -> _Rows:
    """Capacitors, or resistors, whose conductance is what `by` is of."""
    silicon, circuit = machine.silicon, machine.flat.circuit.name
    value = np.concatenate([np.zeros(0), *(made(g, circuit, silicon) for g in groups)])
    sigma, components = np.zeros(value.size), silicon.process.components
    if parameter == "resistance":
        return _Rows(_names(machine, groups, parameter), "Ohm", sigma, -by / value**2)
    if components is not None and silicon.die.variation == "full":
        drawn = _sizes(groups, parameter)
        sigma = value * components.pair_a_capacitance * np.sqrt(0.5 * components.capacitance_density / drawn)
    return _Rows(_names(machine, groups, parameter), "F", sigma, by, silicon.die.mismatch)


def _diodes(machine: Machine, way: Way, moved: F64) -> list[_Rows]:
    """Figures of diodes, and what diodes share where the process says how far they differ."""
    groups, silicon = _groups(machine, Diode), machine.silicon
    if not groups:
        return []
    values = diode_figures(machine.flat, silicon)
    by = by_figures(machine, way, moved, values)
    drawn = {name: _sizes(groups, name) for name in ("area", "saturation_current")}
    common = 1.0 + np.asarray(_alone(machine, groups, drawn["area"]))
    own = values["saturation_current"] / (drawn["saturation_current"] * common)  # 1 and what is the diode's
    # a die keeps its draws: what deviates goes with 1 / sqrt(area)
    by["area"] -= 0.5 * (1.0 - 1.0 / own) * by["saturation_current"]
    figures = silicon.process.diodes
    sigma, found = {name: np.zeros(own.size) for name in FIGURES}, []
    if figures is not None:
        apart = figures.pair_a_saturation / np.sqrt(2.0 * drawn["area"])
        sigma["saturation_current"] = values["saturation_current"] * apart / own
    for name, unit in FIGURES.items():
        there = np.flatnonzero(values[name] != 0.0)
        names, value = _names(machine, groups, name), values[name][there]
        moves, labelled = by[name][:, there] / value, [names[k] for k in there]
        found.append(_Rows(labelled, unit, sigma[name][there], moves, silicon.die.mismatch))
    if figures is not None:
        shared_by = (by["saturation_current"] / common).sum(axis=1)
        label = "process.diode.shared.saturation_current"
        over_dies = np.array([figures.sigma_saturation])
        found.append(_Rows([label], "", over_dies, shared_by[:, None], _process_varies(machine)))
    return found


def _alone(machine: Machine, groups: Sequence[DeviceGroup], area: F64) -> F64 | float:
    """What diodes change by together, without what each has of its own."""
    silicon = replace(machine.silicon, die=machine.silicon.die.without_mismatch())
    paths = [(*g.path, (g.device.name, ())) for g in groups]
    return silicon.change(machine.flat.circuit.name, paths, "diode", area).value


def _lines(machine: Machine, way: Way, moved: F64, sums: Sums) -> dict[int, F64]:
    """What the voltage of each bias line moves the readings by, unit/V, by the number of its source."""
    given, found, k = len(machine.testbench.sources), {}, machine.kernel
    total, row_of = moved.sum(axis=1), np.repeat(np.arange(k.unknowns), np.diff(k.conductance.start))
    for number in range(given, len(machine.source_names)):
        column = k.unknowns + number
        by = _at_terminals(k.transistors.terminal == column, sums)
        linear = k.conductance.column == column
        by = by - total[:, row_of[linear]] @ k.conductance.value[linear]
        if (k.amplifier_terminal == column).any() or (k.diodes.terminal == column).any():
            voltage = way.voltage.copy()
            voltage[:, column] += VOLT
            by = (contracted(k, voltage, moved) - sums.direct) / VOLT
        found[number] = by
    return found


def _at_terminals(at: Bools, sums: Sums) -> F64:
    """What a voltage at some terminals of transistors does, float64[measures]; at: bool[4, transistors]."""
    drain, gate, source, bulk = at.astype(np.float64)
    channel = sums.by_drain * (drain - bulk) + sums.by_gate * (gate - bulk) + sums.by_source * (source - bulk)
    own = sums.junction_own * (np.stack([drain, source]) - bulk)
    by_gate = sums.junction_gate * (gate - bulk)
    return np.asarray(channel.sum(axis=1) + (own + by_gate).sum(axis=(1, 2)))


def _shared(machine: Machine, devices: Sequence[_Rows], lines: dict[int, F64]) -> list[_Rows]:
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
            found.append(_Rows([label], unit, np.array([sigma]), by[:, None], _process_varies(machine)))
    return found


def _process_varies(machine: Machine) -> bool:
    """Whether the process varies from die to die; a corner sets it."""
    die = machine.silicon.die
    return die.process and die.corner == "random"


def _by_shift(machine: Machine, by_beta: F64, own: Bools, shift: float) -> F64:
    groups = _groups(machine, Transistor)
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


def _biases(machine: Machine, lines: dict[int, F64]) -> list[_Rows]:
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
                found.append(_Rows([f"{BIAS}{bias.name}{tail}"], unit, np.zeros(1), by[:, None]))
    return found


def _behind_biases(machine: Machine, lines: dict[int, F64], measures: int) -> list[_Rows]:
    """Devices that biases stand on; what is behind several lines moves all of them."""
    circuit, process, none = machine.testbench.circuit, machine.silicon.process, np.zeros(measures)
    number = {name: k for k, name in enumerate(machine.source_names)}  # none of lines that sources drive
    found: dict[str, _Rows] = {}
    for bias in circuit.biases:
        by_lines = np.array([lines.get(number.get(name, -1), none) for name in _elements(circuit, bias)])
        for moves in bias_moves(circuit, bias, machine.silicon):
            family, root = moves.family, np.sqrt(2.0 * moves.family.area)
            for name, unit, pair, by in (
                ("v_t0", "V", process.pair_a_vt, moves.by_v_t0),
                ("beta", "", process.pair_a_beta, moves.by_beta),
            ):
                names = labels(family.place, family.paths, name)
                rows = _Rows(names, unit, pair / root, by_lines.T @ by, machine.silicon.die.mismatch)
                before = found.get(names[0])
                found[names[0]] = rows if before is None else rows._replace(by=rows.by + before.by)
    return list(found.values())


def _elements(circuit: Circuit, bias: Bias) -> list[str]:
    """Names of a bias's lines, in the order of its port."""
    shape = circuit.port(bias.port).shape
    return [bias.port + (f"[{','.join(map(str, i))}]" if shape else "") for i in np.ndindex(shape)]


def _temperature(machine: Machine, way: Way, moved: F64, sums: Sums) -> _Rows:
    """The temperature of everything; biases that are fixed gate voltages stay."""
    silicon = machine.silicon
    warm = replace(silicon, temperature_c=silicon.temperature_c + KELVIN)
    there = on_die(replace(machine, silicon=warm), silicon.die)
    voltage = way.voltage.copy()
    for number, value in _line_voltages(there).items():
        voltage[:, machine.kernel.unknowns + number] = value
    by = (contracted(there.kernel, voltage, moved) - sums.direct) / KELVIN
    return _Rows([TEMPERATURE], "degC", np.zeros(1), by[:, None])
