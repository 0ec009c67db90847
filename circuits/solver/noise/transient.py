"""Transient with noise: a run of a testbench from rest while its devices make noise, in many trials.

A noise current is a pure function of the seed, the trial, the device's instance path and the time on a grid.
So trials come out the same in any order and on any number of threads, a circuit at its place on a chip has
the chip's noise, and a die stays the same die whatever the seed. The noise is that of
`circuits.devices.noise`, taken at the state of the moment; `circuits.solver.noise.steps` says how it is
stepped. A run begins at rest without noise on its nodes, and with flicker in its stationary state.
"""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from circuits.arrays import F64, I64, U32
from circuits.circuit import Shape
from circuits.devices import Diode, Resistor, Transistor
from circuits.devices.noise import NoiseModel, gate_flicker, noise_model
from circuits.errors import ParameterError, SolverError
from circuits.lowering.kernel import Kernel, Machine, Rows
from circuits.lowering.supply import spike_levels
from circuits.silicon.process import BOLTZMANN, kelvin
from circuits.silicon.silicon import Silicon
from circuits.solver import integrate as core
from circuits.solver.beginning import NOISE, Beginning, beginning
from circuits.solver.integrate import source_values
from circuits.solver.noise.analysis import kernel_order, noise_sources, transistor_areas
from circuits.solver.noise.steps import (
    DEEPEST,
    ROOM,
    Draws,
    GridSteps,
    NoisePlan,
    NoiseState,
    advance_noisy,
    start_flicker,
)
from circuits.solver.operating_point import OperatingPoint
from circuits.solver.outcome import Outcome
from circuits.solver.transient import Result, Steps

T = TypeVar("T")

GRID_STEPS = 20_000  # of a run, unless the step is given; ours
TOLERANCE = 0.1e-3  # V, ours: error of a step beside what noise moves a node by
NOISE_TOLERANCE = 6.0  # ours: of sqrt(k T / C) of the node, which no shorter step would make smaller
LOWEST_FREQUENCY = 0.1  # Hz, ours: where the flicker of a run levels off
_RELAXATIONS = 2  # a decade: the sum of relaxations ripples by 0.1 % about 1/f
_CHUNK = 4 * ROOM
_MOST_GRID_STEPS = 1 << 31


@dataclass(frozen=True, slots=True)
class NoiseRun:
    """Settings of the noise of a run.

    Raises `ParameterError` for a negative seed or a step that is not above zero.

    Attributes
    ----------
    seed
        Seed of all noise; another one is another draw.
    step
        Time for which a noise current stands still, s; a 20,000th of the run unless given.
    flicker
        Flicker noise of the devices; that of the process unless given; `circuits.devices.noise.WHITE_ONLY` is
        none.
    """

    seed: int = 0
    step: float | None = None
    flicker: NoiseModel | None = None

    def __post_init__(self) -> None:
        """Refuse what is no seed or no step."""
        if self.seed < 0:
            raise ParameterError(f"seed: {self.seed}, must be at least 0; give a whole number")
        if self.step is not None and not 0.0 < self.step < math.inf:
            raise ParameterError(f"step: {self.step:g} s, must be > 0; a 20,000th of the run is usual")


def simulate_noisy(
    machine: Machine,
    run: NoiseRun,
    trial: int = 0,
    *,
    record: tuple[str, ...] | None = None,
    point: OperatingPoint | None = None,
) -> Result:
    """One trial of a testbench from its operating point to its stop time, with noise.

    Parameters
    ----------
    machine
        Lowered testbench.
    run
        Seed, grid step and flicker.
    trial
        Number of the trial; another trial is another draw of all noise.
    record
        Node paths to keep at every accepted step; all unless given.
    point
        Rest state to begin in, solved for unless given.

    Raises
    ------
    ParameterError
        The grid would have 2^31 steps or more, or a negative trial.
    SolverError
        A step fails; the text names the time.
    """
    if trial < 0:
        raise ParameterError(f"trial: {trial}, must be at least 0; give a whole number")
    begun = _begun(machine, point)
    stop, title = machine.testbench.stop, machine.testbench.title
    grid = grid_step(machine, run)
    model = run.flicker or noise_model(machine.silicon.process)
    kernel = _with_noise_columns(machine.kernel)
    plan = _plan(begun.point, model, grid, machine.kernel.columns)
    names = machine.names if record is None else record
    columns = np.array([machine.column_of(n) for n in names], dtype=np.int64)
    watched = [n for w in machine.testbench.watch for n in machine.flat.watched_nodes(w)]
    watch, levels = machine.column[watched].astype(np.int64), spike_levels(machine)
    state = _begin(kernel, plan, begun, grid, watch, levels)
    draws = _draws(machine, plan, run.seed, trial)
    if plan.keep.size:
        start_flicker(plan, state, draws)
    recorder = core.new_recorder(columns, watch, levels, _CHUNK, 2 * ROOM * max(1, watch.size))
    sources = machine.sources()
    scratch = core.new_scratch(kernel, sources)
    times, volts = [np.zeros(1)], [state.voltage[columns][None]]
    spikes: list[tuple[int, float]] = []
    code, last = core.BUFFER_FULL, round(stop / grid)
    while code == core.BUFFER_FULL:
        recorder.filled[:] = 0
        steps = GridSteps(grid, round(float(state.time[0]) / grid), last)
        code = advance_noisy(kernel, sources, plan, state, draws, steps, recorder, scratch)
        times.append(recorder.time[: recorder.filled[0]].copy())
        volts.append(recorder.voltage[: recorder.filled[0]].copy())
        found = range(int(recorder.filled[1]))
        spikes += [(int(recorder.spike_index[q]), float(recorder.spike_time[q])) for q in found]
    if code != core.DONE:
        raise SolverError(f"{title}: no step at {state.time[0]:.9g} s with noise; take a shorter grid step")
    labels = [machine.names[n] for n in watched]
    trains = {label: np.array([t for j, t in spikes if j == k]) for k, label in enumerate(labels)}
    return Result(
        machine, Outcome.DONE, np.concatenate(times), np.concatenate(volts), names, trains,
        Steps(*(int(c) for c in state.counts)), begun.point, begun.disturbance,
    )  # fmt: skip


def _begun(machine: Machine, point: OperatingPoint | None) -> Beginning:
    """Where a noisy run begins: a rest state that is not stable is left by the noise itself."""
    found = beginning(machine, point=point)
    return found if found.disturbance is None else Beginning(found.point, found.point.voltage, NOISE)


def map_trials(
    function: Callable[[Result], T],
    machine: Machine,
    run: NoiseRun,
    trials: Sequence[int],
    workers: int | None = None,
    *,
    record: tuple[str, ...] | None = None,
) -> list[T]:
    """What `function` returns for the result of each trial, in their order.

    workers: number of threads, one for each core unless given. record: nodes to keep, by path, all unless
    given. Raises `ParameterError` for fewer than one worker.
    """
    count = os.cpu_count() or 1 if workers is None else workers
    if count < 1:
        raise ParameterError(f"workers: {count}, must be at least 1")
    point = _begun(machine, None).point

    def one(trial: int) -> T:
        return function(simulate_noisy(machine, run, trial, record=record, point=point))

    with ThreadPoolExecutor(count) as executor:
        return list(executor.map(one, trials))


def grid_step(machine: Machine, run: NoiseRun) -> float:
    """The grid step, s: the largest that divides the run and is not above the one that was asked for.

    Raises `ParameterError` where the run would have 2^31 steps or more.
    """
    stop = machine.testbench.stop
    wanted = stop / GRID_STEPS if run.step is None else run.step
    count = math.ceil(stop / wanted * (1.0 - 1e-9)) if stop < math.inf else math.inf
    if not count < _MOST_GRID_STEPS:
        raise ParameterError(f"step: {wanted:g} s in {stop:g} s, must be fewer than 2^31; take a longer one")
    return stop / max(count, 1)


def noise_place(silicon: Silicon, circuit: str) -> str:
    """Path of a circuit on its chip, such as `ranging_chip.neuron[2]`; its own name where it has no place."""
    place = ((circuit, ()),) if silicon.place is None else silicon.place
    return ".".join(_element(*part) for part in place)


def noise_keys(seed: int, trial: int, paths: Sequence[str]) -> U32:
    """Philox keys of the noise currents at instance paths, uint32[2, n]."""
    digests = [
        hashlib.blake2b(repr((seed, trial, p)).encode(), digest_size=8, person=b"noctule-noise").digest()
        for p in paths
    ]
    return np.frombuffer(b"".join(digests), dtype="<u4").astype(np.uint32).reshape(-1, 2).T.copy()


def _with_noise_columns(k: Kernel) -> Kernel:
    """A copy of a kernel with one more column for each unknown node, behind ground, that brings it a current.

    Its thresholds are a copy too, since flicker moves them.
    """
    g, n = k.conductance, k.unknowns
    start = (g.start + np.arange(n + 1)).astype(np.int32)
    rows = np.repeat(np.arange(n), np.diff(g.start))
    order = np.argsort(np.concatenate([rows, np.arange(n)]), kind="stable")
    column = np.concatenate([g.column, k.columns + np.arange(n)]).astype(np.int32)[order]
    value = np.concatenate([g.value, np.full(n, -1.0)])[order]
    entry = np.concatenate([g.entry, np.full(n, -1)]).astype(np.int32)[order]
    transistors = k.transistors._replace(v_t0=k.transistors.v_t0.copy())
    return k._replace(
        columns=k.columns + n, conductance=Rows(start, column, value, entry), transistors=transistors
    )


def relaxations(model: NoiseModel, grid: float) -> tuple[F64, F64]:
    """Rates (1/s) of relaxations and their variances for a density of `1 / f^AF` V^2/Hz, float64[r] each.

    With a variance `c lambda^(1-AF) dln(lambda)` the density `4 lambda / (lambda^2 + w^2)` of unit variance
    sums to `c 4 w^-AF pi / (2 cos(pi (1-AF) / 2))`, w = 2 pi f.
    """
    if model.flicker_n == 0.0 and model.flicker_p == 0.0:
        return np.zeros(0), np.zeros(0)
    low, high = 2.0 * math.pi * LOWEST_FREQUENCY, math.pi / grid
    count = max(2, 1 + math.ceil(_RELAXATIONS * math.log10(high / low)))
    rate = np.geomspace(low, high, count)
    spacing = math.log(high / low) / (count - 1)
    slope = 1.0 - model.exponent
    scale = math.cos(0.5 * math.pi * slope) / (2.0 * math.pi) * (2.0 * math.pi) ** model.exponent
    return rate, scale * rate**slope * spacing


def _plan(point: OperatingPoint, model: NoiseModel, grid: float, first: int) -> NoisePlan:
    """Channels in the kernel's order, then junctions and diodes, then what no state moves."""
    machine = point.machine
    a = machine.kernel.transistors
    found = noise_sources(point, model)
    order = kernel_order(found)
    rate, variance = relaxations(model, grid)
    at_gate = gate_flicker(model, machine.silicon.process, a.sign > 0.0, transistor_areas(point))
    return NoisePlan(
        found.start[order], found.end[order], found.white[order],
        np.sqrt(at_gate[:, None] * variance), np.exp(-rate * grid), first,
        _tolerance(machine),
    )  # fmt: skip


def _tolerance(machine: Machine) -> F64:
    """Error of a step that each node may have, V."""
    c = machine.kernel.charge
    rows = np.repeat(np.arange(machine.kernel.unknowns), np.diff(c.start))
    own = c.column == rows
    total = np.zeros(machine.kernel.unknowns)
    total[rows[own]] = c.value[own]
    thermal = BOLTZMANN * kelvin(machine.silicon.temperature_c)
    wander = np.sqrt(np.divide(thermal, total, out=np.zeros_like(total), where=total > 0.0))
    return np.asarray(TOLERANCE + NOISE_TOLERANCE * wander)


def _begin(k: Kernel, plan: NoisePlan, begun: Beginning, grid: float, watch: I64, levels: F64) -> NoiseState:
    voltage = np.zeros(k.columns)
    voltage[: plan.first] = begun.voltage
    sources = begun.point.machine.sources()
    source_values(sources, sources.start[:-1].copy(), 0.0, voltage, k.unknowns)
    m = k.transistors.sign.size
    return NoiseState(
        np.zeros(1), voltage, np.zeros(k.columns), np.array([grid]), np.zeros((m, plan.keep.size)),
        k.transistors.v_t0.copy(), voltage[watch] < levels[0], np.zeros(3, np.int64),
    )  # fmt: skip


def _draws(machine: Machine, plan: NoisePlan, seed: int, trial: int) -> Draws:
    """Block 0 of every noise current, then the flicker's blocks of every transistor."""
    flat = machine.flat
    root = noise_place(machine.silicon, flat.circuit.name)
    m, blocks = plan.amplitude.shape[0], -(-plan.keep.size // 4)
    transistors = flat.labels(Transistor)
    ends = ("drain", "source") if machine.kernel.transistors.leaks else ()
    junctions = [f"{label}.{end}" for end in ends for label in transistors]
    labels = [*transistors, *junctions, *flat.labels(Diode), *flat.labels(Resistor)]
    keys = noise_keys(seed, trial, [f"{root}.{label}" for label in labels])
    keys = np.concatenate([keys, np.repeat(keys[:, :m], blocks, axis=1)], axis=1)
    counters = np.zeros((4, keys.shape[1]), dtype=np.uint32)
    counters[1, len(labels) :] = np.tile(np.arange(1, blocks + 1), m)
    words = np.zeros((4, keys.shape[1]), dtype=np.uint32)
    levels = np.zeros((2, DEEPEST + 1, len(labels)))
    return Draws(np.ascontiguousarray(keys), counters, words, levels[0], levels[1])


def _element(name: str, index: Shape) -> str:
    return f"{name}[{','.join(map(str, index))}]" if index else name
