"""Measurement of the rebound neuron's record with the transistor-level solver, and of its model's errors.

| quantity | measured as |
|---|---|
| log_charge | ln(t_inh I): a call; the release is inhibition.b falling through half the supply |
| threshold, log_axon_charge | v_mem driven as a ramp of r V/s fires at `threshold + sqrt(2 axon_charge r)` |
| log_pulse_width | v_mem falls to 0 at the spike, as the reset makes it |
| echo_step | v_ex after an echo against v_ex_max, the ramp since then taken away |

The first over I_inh_tau and temperature, the others over temperature, each with central differences over the
deviations of the devices that can move it: gradient and curvature. Then the model meets dies that were not
used: errors of t_inh, of the threshold and of the peak of v_mem after a call; twice the rms of what decides,
peak minus threshold, is the margin.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from chips.measured.held_out import TEMPERATURES, of_dies, rms_and_max
from chips.measured.perturbation import POLARITIES, deviations_of, perturbed
from chips.model import Biases, Cells, Model, Progress, Proxy
from chips.ranging.chip import RangingChip
from chips.ranging.model import ReboundModel, model_of, neurons_on, stimulated
from chips.ranging.proxy import METRICS, tuned
from chips.ranging.record import (
    GRID,
    NAME,
    Box,
    Grid,
    Quantity,
    ReboundRecord,
    rebound_key,
    rebound_record,
    to_record,
)
from chips.ranging.response import tune
from chips.ranging.sheet import rebound_sheet
from chips.record import Record
from circuits.arrays import F64
from circuits.bias import gate_voltage, rebias
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit
from circuits.devices import Source, Transistor
from circuits.devices.source import Constant, Polyline, Waveform, vertices
from circuits.errors import SolverError
from circuits.event import pulse
from circuits.lowering.kernel import Machine
from circuits.lowering.supply import half_supply
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import Runner

RTOL = 1e-6
THRESHOLD_STEP = 20e-3  # V, of the central differences
BETA_STEP = 0.1
BOX = Box(threshold=0.2, log_beta=0.3, v_th=0.3, v_ex_max=1.2)  # ours: to where the errors were looked at
RATES = 200.0, 800.0  # V/s, of the ramps; a rebound rises at 760
RAMP_START, RAMP_STOP = -0.25, 0.25  # V about v_th
HELD_OUT = tuple(range(500, 540))  # dies; none is used to build
FAR_THRESHOLD = 3.3  # V, that no rebound reaches

INHIBITION = tuple(f"inhibition.mi{k}" for k in (1, 2, 3, 4, 6, 7, 8, 9, 10, 11, 12))
FIRING = tuple(f"comparator.mc{k}" for k in range(1, 6)) + tuple(f"axon.ma{k}" for k in range(1, 8))
HELD = ("inhibition.mi5",)  # sets the current over which the record is kept, and stays where it is
ECHO = ("excitation.me1", "excitation.me2", "excitation.me3")


@dataclass(frozen=True, slots=True)
class Perturb:
    """A deviation of the threshold (V) and of ln beta of a device, or of v_th (V).

    device: by its path, `n` or `p` for all of a polarity, `v_th` for the reference voltage, none if empty.
    """

    device: str = ""
    threshold: float = 0.0
    log_beta: float = 0.0

    def apply(self, machine: Machine) -> Machine:
        """Return the machine with the deviation of its devices."""
        if self.device in {"", "v_th"}:
            return machine
        return perturbed(machine, self.device, self.threshold, self.log_beta, HELD)

    @property
    def v_th(self) -> float:
        """Deviation of v_th, V."""
        return self.threshold if self.device == "v_th" else 0.0


@dataclass(frozen=True, slots=True)
class _Task:
    """Quantities measured together. `measure(neuron, silicon, current, perturb)` returns one value each."""

    names: tuple[str, ...]
    parameters: tuple[str, ...]
    measure: Callable[[Circuit, Silicon, float, Perturb], tuple[float, ...]]
    per_current: bool = False


def measure(
    progress: Progress,
    neuron: Circuit | None = None,
    process: Process = AMI_1500_IDEAL,
    grid: Grid = GRID,
) -> ReboundRecord:
    """Measure a rebound neuron in a process, without errors; it takes about a minute on one core.

    progress: is told the share that is done. Raises `SolverError` where the neuron does not do what is
    measured.
    """
    neuron = neuron or rebound_neuron.build()
    total = sum(len(t.parameters) * len(_currents(t, grid)) for t in _TASKS) * len(grid.temperature)
    done = 0
    quantities: dict[str, Quantity] = {}
    for task in _TASKS:
        points = []
        for current in _currents(task, grid):
            for temperature in grid.temperature:
                points.append(_derivatives(task, neuron, Silicon(process, temperature), current))
                done += len(task.parameters)
                progress(done / total)
        plane = (len(_currents(task, grid)), len(grid.temperature))
        tables = [np.array(table) for table in zip(*points, strict=True)]
        for k, name in enumerate(task.names):
            value, gradient, curvature = (x[:, k].reshape(*plane, *x.shape[2:]) for x in tables)
            quantities[name] = Quantity(task.parameters, value, gradient, curvature)
    return ReboundRecord(rebound_key(neuron, process, grid), grid, BOX, quantities, {})


def _currents(task: _Task, grid: Grid) -> tuple[float, ...]:
    return grid.current if task.per_current else grid.current[:1]


def _derivatives(task: _Task, neuron: Circuit, silicon: Silicon, current: float) -> tuple[F64, F64, F64]:
    """Value, gradient and second derivatives of a task's quantities at one point of the grid."""

    def at(perturb: Perturb) -> F64:
        return np.array(task.measure(neuron, silicon, current, perturb))

    middle = at(Perturb())
    first, second = [], []
    for parameter in task.parameters:
        device, _, kind = parameter.rpartition(".")
        h = BETA_STEP if kind == "beta" else THRESHOLD_STEP
        down, up = (
            at(Perturb(device, 0.0, s * h) if kind == "beta" else Perturb(device or "v_th", s * h))
            for s in (-1.0, 1.0)
        )
        first.append((up - down) / (2.0 * h))
        second.append((up - 2.0 * middle + down) / h**2)
    return middle, np.stack(first, axis=-1), np.stack(second, axis=-1)


def _source(port: str, waveform: Waveform) -> Source:
    return Source(port, port, waveform)


def _event(port: str, silicon: Silicon) -> Source:
    return _source(port, pulse((0.0,), silicon.process.v_dd))


def _line(time: tuple[float, ...], value: tuple[float, ...]) -> Polyline:
    return vertices("v_mem", time, value)


def inhibition_time(machine: Machine, longest: float) -> float:
    """Return the time from a call at 0 s to the release of inhibition, s.

    Raises `SolverError` where there is none after `longest` s.
    """
    runner = Runner(machine, ("inhibition.b",), RTOL)
    half = half_supply(machine)
    state = runner.begin(operating_point(machine))
    state, _ = runner.advance(state, 20e-6, stop_at_event=False)
    until, before = 0.2 * longest, (state.now, 2.0 * half)
    while state.now < longest:
        state, segment = runner.advance(state, until, stop_at_event=False)
        low = np.flatnonzero(segment.voltage[:, 0] < half)
        if low.size:
            k = int(low[0])
            t0, v0 = (segment.time[k - 1], segment.voltage[k - 1, 0]) if k else before
            share = (v0 - half) / (v0 - segment.voltage[k, 0])
            return float(t0 + share * (segment.time[k] - t0))
        before = float(segment.time[-1]), float(segment.voltage[-1, 0])
        until = min(until + 0.2 * longest, longest)
    raise SolverError(f"{machine.testbench.title}: no release within {longest:g} s; raise i_inh_tau")


def _measure_inhibition(
    neuron: Circuit, silicon: Silicon, current: float, perturb: Perturb
) -> tuple[float, ...]:
    mi5 = neuron.device("inhibition.mi5")
    if not isinstance(mi5, Transistor):
        raise TypeError(f"{neuron.name}.inhibition.mi5: no transistor")
    # the current that the record is over has no Early effect in it (`inhibition_current`)
    gate = gate_voltage(replace(silicon.law("n"), early_field=0.0), mi5, current)
    sources = (_event("call", silicon), _source("v_inh_tau", Constant(gate)))
    machine = perturb.apply(stimulated(neuron, silicon, sources))
    return (math.log(inhibition_time(machine, 5e-12 / current) * current),)


def _spike(machine: Machine, line: Polyline) -> tuple[float, float]:
    """When the spike port rises and falls through half the supply while v_mem follows a line, s."""
    runner = Runner(machine, ("spike",), RTOL)
    state = runner.begin(operating_point(machine))
    state, segment = runner.advance(state, float(line[0][-1]), {"v_mem": line})
    if not segment.spikes:
        raise SolverError(f"{machine.testbench.title}: no spike on a ramp of v_mem; check v_th")
    spike = segment.spikes[0][1]
    reset = _line((spike, spike + 20e-9), (float(np.interp(spike, *line)), 0.0))
    half = half_supply(machine)
    _, segment = runner.advance(state, spike + 50e-6, {"v_mem": reset}, stop_at_event=False)
    wave = segment.voltage[:, 0]
    k = int(np.flatnonzero(wave < half)[0])
    share = (wave[k - 1] - half) / (wave[k - 1] - wave[k]) if k else 0.0
    return spike, float(segment.time[k - 1] + share * (segment.time[k] - segment.time[k - 1]))


def _ramp(
    neuron: Circuit, silicon: Silicon, v_th: float, rate: float, perturb: Perturb
) -> tuple[float, float]:
    """v_mem at which the axon fires on a ramp of `rate` V/s, and the spike's width, s."""
    start = v_th + RAMP_START
    line = _line((0.0, (RAMP_STOP - RAMP_START) / rate), (start, v_th + RAMP_STOP))
    sources = (_source("v_mem", Constant(start)), _source("v_th", Constant(v_th)))
    spike, end = _spike(perturb.apply(stimulated(neuron, silicon, sources)), line)
    return start + rate * spike, end - spike


def _measure_firing(neuron: Circuit, silicon: Silicon, current: float, perturb: Perturb) -> tuple[float, ...]:
    v_th = float(np.asarray(neuron.bias("v_th").value)) + perturb.v_th
    (slow, _), (fast, width) = (_ramp(neuron, silicon, v_th, r, perturb) for r in RATES)
    root = (fast - slow) / (math.sqrt(RATES[1]) - math.sqrt(RATES[0]))
    return slow - root * math.sqrt(RATES[0]), math.log(0.5 * root**2), math.log(width)


def _measure_echo(neuron: Circuit, silicon: Silicon, current: float, perturb: Perturb) -> tuple[float, ...]:
    machine = perturb.apply(stimulated(neuron, silicon, (_event("echo", silicon),)))
    runner = Runner(machine, ("excitation.v_ex",), RTOL)
    times = 10.15e-6 + np.array([2e-6, 4e-6])
    state, levels = runner.begin(operating_point(machine)), []
    for until in times:
        state, segment = runner.advance(state, float(until), stop_at_event=False)
        levels.append(float(segment.voltage[-1, 0]))
    v_ex_max = float(np.asarray(neuron.bias("v_ex_max").value))
    return (2.0 * levels[0] - levels[1] - v_ex_max,)


def _deviations(devices: tuple[str, ...]) -> tuple[str, ...]:
    return deviations_of((*devices, *POLARITIES))


_TASKS = (
    _Task(("log_charge",), _deviations(INHIBITION), _measure_inhibition, per_current=True),
    _Task(
        ("threshold", "log_axon_charge", "log_pulse_width"),
        (*_deviations(FIRING), "v_th"),
        _measure_firing,
    ),
    _Task(("echo_step",), _deviations(ECHO), _measure_echo),
)


def held_out_errors(
    neuron: Circuit, process: Process, record: ReboundRecord, dies: tuple[int, ...]
) -> dict[str, float]:
    """Return errors of the model on dies, with mismatch and process variation, that were not measured.

    They are of the release (relative), the threshold on a ramp of 800 V/s, the peak of v_mem after a call
    alone, and the peak minus the threshold, each rms and largest, over 0, 27 and 60 degC in turn.
    """
    model = model_of(neuron, process, record)
    rows = []
    for k, number in enumerate(dies):
        temperature = TEMPERATURES[k % len(TEMPERATURES)]
        rows += list(_compare(model, Silicon(process, temperature, Die(number=number))))
    if not rows:
        raise SolverError(f"{neuron.name}: none of dies {dies} could be measured; look at its biases")
    t, v, p = np.array(rows).T
    errors = of_dies(dies) | {"dies": float(len(rows))}
    for name, values in (("release_relative", t), ("threshold", v), ("peak", p), ("margin", p - v)):
        errors |= rms_and_max(name, values, "" if name.endswith("relative") else "V")
    return errors


def _compare(model: ReboundModel, silicon: Silicon) -> Iterator[tuple[float, float, float]]:
    """Errors of release, threshold and peak on one die; nothing where the solver gives up."""
    neuron, neurons = model.circuit, neurons_on(model, silicon)
    far = (_event("call", silicon), _source("v_th", Constant(FAR_THRESHOLD)))
    try:
        machine = stimulated(neuron, silicon, far)
        release = inhibition_time(machine, 3.0 * float(neurons.t_inh[0]))
        runner = Runner(machine, ("v_mem",), RTOL)
        state, _ = runner.advance(runner.begin(operating_point(machine)), release + 2e-6, stop_at_event=False)
        until = release + float(neurons.rebound_bound[0])
        _, segment = runner.advance(state, until, stop_at_event=False)
        v_th = float(np.asarray(neuron.bias("v_th").value))
        fired = _ramp(neuron, silicon, v_th, RATES[1], Perturb())[0]
    except SolverError:
        return
    far_off = neurons._replace(v_threshold=neurons.v_threshold + 5.0, t_inh=np.array([release]))
    level = neurons.v_threshold[0] + math.sqrt(2.0 * neurons.axon_charge[0] * RATES[1])
    yield (
        float(neurons.t_inh[0] / release - 1.0),
        float(level - fired),
        float(tune(far_off).peak[0] - segment.voltage[:, 0].max()),
    )


def _judged(record: Record, biases: Biases | None, process: Process) -> dict[str, float]:
    neuron = rebias(rebound_neuron.build(), biases)
    return held_out_errors(neuron, process, rebound_record(record), HELD_OUT)


MODEL = Model(
    NAME.replace("_", "-"),
    lambda: (rebound_neuron.build(),),
    lambda progress, process: to_record(measure(progress, process=process)),
    _judged,
    lambda silicon: RangingChip(silicon, rebound_neuron.build(), NAME),
    figures=lambda record: {"margin_V": rebound_record(record).margin},
    cells=Cells(("rebound-neuron", "ranging-chip", "ranging-chip-biased"), rebound_sheet),
    proxy=Proxy(METRICS, tuned),
)
