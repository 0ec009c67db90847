"""Measurement of the wavefront chip's records, and of its models' errors on other dies.

Axonal delay element: delays at all codes over temperature, the sink's current and the comparator's, set by
their gate voltages; then central differences over every device's deviations at codes 1 and 31, from which
gain and offset follow. The devices `ms`, `mc0` and `mc6` do not move with their polarity: their currents are
coordinates.

Wavefront cell, over temperature and the threshold shift that a polarity shares:

| quantity | measured as |
|---|---|
| input_delay_s | from half the supply at arrive[0], an edge of 5 ns, to half at fired |
| start_delay_s | likewise from the start |
| window_s | largest lag of a second arrival that still sets its bit, bisected |
| input_delay_gradient | of the input delay, s a V of V_T0 or s a unit of ln beta, by device |

Then the models meet dies that were not used.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chips.measured.held_out import TEMPERATURES, of_dies, rms_and_max, silicon_in_turn
from chips.measured.perturbation import deviating, deviations_of, slopes
from chips.measured.search import narrowed
from chips.measured.table_record import Quantities, check_box, measure_over, on_silicon, shifts
from chips.model import Model
from chips.record import Axis, Record, Table
from chips.wavefront.axon_conditions import Conditions, axon_tables, conditions, process_shifts
from chips.wavefront.axon_record import (
    BOX,
    COMPARATOR_CURRENT,
    CURRENT,
    GRID,
    PARAMETER,
    SHARED,
    TEMPERATURE,
    VERSION,
    AxonGrid,
    axon_key,
)
from chips.wavefront.model import axon_delays, axon_model, cell_circuits, cell_record, input_delay
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.wavefront import axon_delay
from circuits.blocks.wavefront import cell as wavefront_cell
from circuits.blocks.wavefront.axon_linearity import CODES, delay_at, delay_machine, delays_at
from circuits.circuit import Circuit
from circuits.devices import Transistor
from circuits.devices.source import vertices
from circuits.lowering.kernel import Machine, to_kernel
from circuits.lowering.on_die import on_die
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

RTOL = 1e-6
STEPS = {"v_t0": 10e-3, "beta": 0.1}  # V, 1: of the central differences
COORDINATES = {"v_delay": "ms", "v_cmp": "mc0"}  # ports whose currents are coordinates, and their devices
HELD = ("ms", "mc0", "mc6")  # devices that do not move with their polarity
GRADIENT_COMPARATOR_CURRENT = 100e-9  # A, at which gradients are measured
HELD_OUT = tuple(range(500, 530))  # dies; none is used to build
HELD_OUT_CODES = 1, 3, 10, 31
SHIFTS = shifts(5)  # V
RESOLUTION = 1e-11  # s, of the window
LATEST = 20e-9  # s, lag of a second arrival that is surely too late; ours


def measure_axon(
    circuit: Circuit | None = None,
    process: Process = AMI_1500_IDEAL,
    grid: AxonGrid = GRID,
) -> Record:
    """Measure the record of an axonal delay element, without errors; it takes about a minute on one core."""
    circuit = circuit or axon_delay.build()
    names = tuple(d.name for d in circuit.devices if isinstance(d, Transistor) and d.name not in HELD)
    parameters = deviations_of((*names, "mc0", "mc6", *SHARED))
    charge: list[list[F64]] = []
    lines: list[tuple[F64, F64]] = []
    for temperature in grid.temperature:
        machine = delay_machine(circuit, Silicon(process, temperature))
        for i in grid.current:
            charge.append([
                np.log(delays_at(_biased(machine, i, j), CODES, RTOL) * i) for j in grid.comparator_current
            ])  # fmt: skip
            lines.append(_gain_and_offset(_biased(machine, i, GRADIENT_COMPARATOR_CURRENT), parameters))
    plane = (len(grid.temperature), len(grid.current))
    gain, offset = (np.array(x).reshape(*plane, -1) for x in zip(*lines, strict=True))
    log_charge = np.array(charge).reshape(*plane, len(grid.comparator_current), len(CODES))
    tables = {
        "log_charge": Table((TEMPERATURE, CURRENT, COMPARATOR_CURRENT, "code"), log_charge),
        "gain": Table((TEMPERATURE, CURRENT, PARAMETER), gain),
        "offset": Table((TEMPERATURE, CURRENT, PARAMETER), offset),
    }
    axes: dict[str, Axis] = {
        TEMPERATURE: grid.temperature,
        CURRENT: grid.current,
        COMPARATOR_CURRENT: grid.comparator_current,
        "code": tuple(map(float, CODES)),
        PARAMETER: parameters,
    }
    return Record(axon_key(circuit, process, grid), VERSION, axes, tables, box=BOX)


def _biased(machine: Machine, current: float, comparator_current: float) -> Machine:
    """The machine with the gate voltages of these currents, A, with the drain far, without deviations."""
    lines = list(machine.polylines)
    devices = on_die(machine.testbench.circuit, machine.silicon, tuple(COORDINATES.values()))
    for port, amperes in zip(COORDINATES, (current, comparator_current), strict=True):
        gate = float(devices.gate_for(COORDINATES[port], np.asarray(amperes)))
        lines[machine.source_names.index(port)] = vertices(port, (0.0,), (gate,))
    return replace(machine, polylines=tuple(lines))


def _gain_and_offset(machine: Machine, parameters: tuple[str, ...]) -> tuple[F64, F64]:
    """Gain and offset of every parameter, float64[parameters] each."""
    ends = (CODES[0], CODES[-1])
    low, high = delays_at(machine, ends, RTOL)
    unit = (high - low) / (ends[1] - ends[0])
    gain, offset = [], []
    for parameter in parameters:
        h = STEPS[parameter.rpartition(".")[2]]
        down, up = (delays_at(deviating(machine, parameter, s * h, HELD), ends, RTOL) for s in (-1.0, 1.0))
        first, last = (up - down) / (2.0 * h * unit)
        gain.append((last - first) / (ends[1] - ends[0]))
        offset.append(first - gain[-1] * ends[0])
    return np.array(gain), np.array(offset)


def axon_errors(
    record: Record,
    circuit: Circuit | None = None,
    process: Process = AMI_1500_IDEAL,
    dies: tuple[int, ...] = HELD_OUT,
) -> dict[str, float]:
    """Return relative errors of the model's delays on dies that were not measured, rms and largest.

    Both kinds of bias and 0, 27 and 60 degC take turns, at codes 1, 3, 10 and 31.
    """
    circuit = circuit or axon_delay.build()
    rows = []
    for _, kind, silicon in silicon_in_turn(dies, process):
        biased = rebias(circuit, kind=kind)
        machine = delay_machine(biased, silicon)
        model = axon_model(biased, process, record)
        for code in HELD_OUT_CODES:
            ours = float(axon_delays(model, silicon, np.array(code))[()])
            rows.append(ours / delay_at(machine, code, RTOL) - 1.0)
    return of_dies(dies) | rms_and_max("delay", rows, "relative")


def measure_cell(process: Process = AMI_1500_IDEAL) -> Record:
    """Measure the record of the wavefront cell, without errors; it takes half a minute on one core."""
    parameters, gradient = _cell_gradient(process)
    return measure_over(_cell_at, cell_circuits(), SHIFTS, {}, process).extended(
        {"input_delay_gradient": Table((PARAMETER,), gradient)}, {PARAMETER: parameters}
    )


def cell_errors(data: Record, process: Process = AMI_1500_IDEAL) -> dict[str, float]:
    """Return errors of the cell's input delay and window, s, known by temperature and shared shift alone."""
    late, wide = [], []
    for k, number in enumerate(HELD_OUT):
        silicon = Silicon(process, TEMPERATURES[k % len(TEMPERATURES)], Die(number=number))
        machine = _cell_machine(silicon)
        late.append(float(on_silicon(data, "input_delay_s", silicon)) - _input_delay(machine))
        wide.append(float(on_silicon(data, "window_s", silicon)) - _window(silicon))
    return of_dies(HELD_OUT) | rms_and_max("input_delay", late, "s") | rms_and_max("window", wide, "s")


def _cell_at(silicon: Silicon) -> Quantities:
    return {
        "input_delay_s": _input_delay(_cell_machine(silicon)),
        "start_delay_s": _input_delay(_cell_machine(silicon, first=None, start=1.0)),
        "window_s": _window(silicon),
    }


def _cell_machine(silicon: Silicon, **stimuli: float | None) -> Machine:
    values = wavefront_cell.BLOCK.defaults
    values |= {"first": 0.0, "second": None} | stimuli
    bench = wavefront_cell.testbench(wavefront_cell.build(), values, silicon.process.v_dd)
    return to_kernel(replace(bench, stop=wavefront_cell.ARRIVAL + 1e-6), silicon)


def _input_delay(machine: Machine) -> float:
    result = simulate(machine, rtol=RTOL, record=())
    return float(result.spikes["fired"][0]) - wavefront_cell.ARRIVAL


def _window(silicon: Silicon) -> float:
    """Largest lag of a second arrival that sets its bit, s."""

    def too_late(lag: float) -> bool:
        result = simulate(_cell_machine(silicon, second=1.0, lag=lag), rtol=RTOL, record=("first[1]",))
        return not result["first[1]"][-1] > 0.5 * silicon.process.v_dd

    return 0.5 * sum(narrowed(too_late, 0.0, LATEST, RESOLUTION))


def _cell_gradient(process: Process) -> tuple[tuple[str, ...], F64]:
    """Deviations of each device, and what they do to the input delay of the nominal cell at 27 degC."""
    machine = _cell_machine(Silicon(process))
    parameters = deviations_of(machine.flat.labels(Transistor))
    return parameters, slopes(lambda name, x: _input_delay(deviating(machine, name, x)), parameters, STEPS)


def _load_axon(silicon: Silicon) -> Conditions:
    tables = axon_tables(axon_model(axon_delay.build(), silicon.process), silicon)
    return conditions(tables, silicon, process_shifts(silicon))


def _load_cell(silicon: Silicon) -> float:
    check_box("wavefront_cell", silicon, cell_record(silicon.process))
    return input_delay(silicon)


AXON_MODEL = Model(
    "axon-delay",
    lambda: (axon_delay.build(),),
    lambda _, process: measure_axon(process=process),
    lambda record, _, process: axon_errors(record, process=process),
    _load_axon,
)
CELL_MODEL = Model(
    "wavefront-cell",
    cell_circuits,
    lambda _, process: measure_cell(process),
    lambda record, _, process: cell_errors(record, process),
    _load_cell,
)
