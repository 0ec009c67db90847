"""Errors of the latency chip's model against the transistors of its parts, on dies that were not measured.

A part a die, at a place that follows from the die's number, at its chip's own biases; both kinds of bias and
0, 27 and 60 degC in turn. Relative errors of times, rms and largest: a tap's delay, an integrating neuron's
latency of two inputs, INH's first spike after a reset, its period, its silence after an event, a first-layer
cell's latency with a charge and an inhibition. Of a unit's detector, whether it spikes 8 % inside and outside
of its window: the model's answer against the circuit's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from chips.latency.chip import LatencyChip
from chips.latency.design import REACH, Design, gate_voltages
from chips.latency.kernel import Charge, Race, integrate, race, recall
from chips.latency.measure import EXCITATIONS, INHIBITIONS, RTOL, SYNAPSES, circuits, measure
from chips.latency.model import usual_biases
from chips.latency.place import (
    INHIBITION_WIRES,
    NEURON_WIRES,
    RACE_WIRES,
    TAP_WIRES,
    UNIT_WIRES,
    Wires,
    bench_at,
    line_volts,
    standing,
)
from chips.measured.held_out import of_dies, rms_and_max, silicon_in_turn
from chips.model import plain_model
from circuits.arrays import F64
from circuits.blocks.latency import neuron as latency_neuron
from circuits.blocks.latency import race as latency_race
from circuits.blocks.latency import tap as latency_tap
from circuits.blocks.latency import tonic as latency_tonic
from circuits.blocks.latency import unit as latency_unit
from circuits.circuit import Circuit, Port
from circuits.event import WIDTH
from circuits.silicon.process import AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate

Events = dict[str, Sequence[float]]
Parts = tuple[tuple[str, tuple[int, ...]], ...]

HELD_OUT = tuple(range(500, 530))  # dies; none is used to build
INSIDE, OUTSIDE = 0.92, 1.08  # of a window
START = 20e-6  # s, of the first event
FIRST, SECOND = 3e-3, 6e-3  # s, of a neuron's inputs
GROUPS = 5


def usual_design() -> Design:
    """Return the design that errors are measured with: 33 paths in five groups of like sizes."""
    group = tuple(min(k // 7, GROUPS - 1) for k in range(33))
    return Design(group, (1.0,) * 33, tuple(2e-3 + 2.8e-3 * k for k in range(GROUPS)))


def held_out_errors(process: Process = AMI_1500_IDEAL, dies: Sequence[int] = HELD_OUT) -> dict[str, float]:
    """Return the model's errors by name; it takes some 10 s on one core."""
    rows: dict[str, list[float]] = {}
    wrong = decisions = 0
    design = usual_design()
    for number, kind, silicon in silicon_in_turn(dies, process):
        chip = LatencyChip(design, usual_biases(design, kind, process), silicon)
        for name, ours, theirs in times_at(chip, number % 33, number % 15):
            rows.setdefault(name, []).append(ours / theirs - 1.0)
        for ours, theirs in decisions_at(chip, number % 33, number % 15):
            decisions += 1
            wrong += ours != theirs
    found = of_dies(dies)
    for name, errors in rows.items():
        found |= rms_and_max(name, errors, "relative")
    return found | {"detections": float(decisions), "detections_wrong": float(wrong)}


def times_at(chip: LatencyChip, p: int, u: int) -> list[tuple[str, float, float]]:
    """Return name, the model's and the circuit's time (s) of each quantity at memory p and its unit u."""
    return [
        ("tap", *tap_delays(chip, u + 1)),
        ("integrating", *neuron_latencies(chip, p)),
        *inhibition_times(chip, p, u),
        ("race", *race_latencies(chip, p)),
    ]


def tap_delays(chip: LatencyChip, k: int) -> tuple[float, float]:
    """Return the delay of tap k, s: the model's, and the circuit's."""
    ours = float(chip.lumped.tap[k])
    part = latency_tap.delay_tap(5e-12)
    result = _run(chip, part, (("tap", (k,)),), TAP_WIRES, {"tap": k}, {"event": [START]}, 1.5 * ours, "out")
    return ours, float(result.spikes["out"][0]) - START


def neuron_latencies(chip: LatencyChip, p: int) -> tuple[float, float]:
    """Return the latency of integrating neuron p after inputs at 3 and 6 ms, s: model, and circuit."""
    alone = float(chip.lumped.integrating[p] / chip.lumped.synapse[p, 0])
    if alone > float(chip.lumped.step[p, 0]):
        return 1.0, 1.0  # one input's step may be over before the spike
    return input_latencies(chip, p, np.array([FIRST, SECOND]))


def input_latencies(chip: LatencyChip, p: int, times: F64) -> tuple[float, float]:
    """Return the latency of integrating neuron p after inputs at these times (s), s: model, and circuit."""
    spike = np.empty(chip.design.paths)
    integrate(chip.lumped, chip.new_memory(), times, np.full(times.size, p), spike)
    ours = float(spike[p])
    part = latency_neuron.build(latency_neuron.Params(synapses=SYNAPSES))
    events: Events = {"reset": [START]}
    events |= {f"event[{k}]": [START + float(t)] for k, t in enumerate(times)}
    parts = (("memory", (p,)), ("neuron", ()))
    result = _run(chip, part, parts, NEURON_WIRES, {"integrating": p}, events, 1.5 * ours)
    return ours, float(result.spikes["spike"][0]) - START


def inhibition_times(chip: LatencyChip, p: int, u: int) -> list[tuple[str, float, float]]:
    """Return when a unit's tonic neuron spikes after a reset, its period, and how long an event silences it.

    The period is the circuit's second one. Each is a name with the model's and the circuit's time, s.
    """
    tonic, hold = float(chip.lumped.tonic[p, u]), float(chip.lumped.hold[p, u])
    at = START + 2.5 * tonic
    part = latency_tonic.build()
    parts = (("memory", (p,)), ("unit", (u,)), ("inh", ()))
    events: Events = {"end": [START], "event": [at]}
    result = _run(chip, part, parts, INHIBITION_WIRES, {}, events, 4.0 * tonic + 1.3 * hold)
    spikes = result.spikes["spike"]
    before, after = spikes[spikes < at], spikes[spikes > at]
    return [
        ("release", tonic, float(before[0]) - START - WIDTH),
        ("tonic", tonic, float(before[1] - before[0])),
        ("hold", hold + tonic, float(after[0]) - at - WIDTH),
    ]


def race_latencies(chip: LatencyChip, p: int) -> tuple[float, float]:
    """Return the latency of first-layer cell p with a charge and an inhibition, s: model, and circuit."""
    c = chip.lumped
    alone = float(c.race[p] / c.passive[p])
    return cell_latencies(chip, p, p, {p: 0.3 * alone}, 0.1 * alone)


def cell_latencies(
    chip: LatencyChip, p: int, goal: int | None, memories: Mapping[int, float], goal_at: float = 5e-3
) -> tuple[float, float]:
    """Return the latency of first-layer cell p, s: model, and circuit.

    goal: neuron whose charge begins at goal_at (s), or None; memories: when each inhibits, s.
    """
    n = chip.design.paths
    out = np.full(n, math.inf)
    for q, at in memories.items():
        out[q] = at
    layers = Race(np.empty(n), np.empty(n), np.empty(n))
    race(chip.lumped, chip.new_memory(), out, Charge(-1 if goal is None else goal, goal_at, -1, 0.0), layers)
    ours = float(layers.free[p])
    part = weighted_cell({q - p + REACH: abs(q - p) for q in memories})
    events: Events = {f"inhibit[{q - p + REACH}]": [START + at] for q, at in memories.items()}
    events |= {"reset": [START]} | ({} if goal is None else {"excite[0]": [START + goal_at]})
    element = {"passive": p, "goal": 0 if goal is None else abs(goal - p)}
    wires = dict(RACE_WIRES) | {f"v_inh_{k}": "inhibit" for k in range(REACH + 1)}
    del wires["v_inh"]
    volts = line_volts(chip.biases, chip.silicon, wires, element)
    gates = gate_voltages(chip.biases, chip.silicon)["inhibit"]
    volts |= {f"v_inh_{k}": float(gates[k]) for k in range(REACH + 1)}
    v_dd = chip.silicon.process.v_dd
    bench = bench_at(part.name, part, volts, events, 1.5 * ours + START, v_dd)
    result = simulate(bench, standing(chip.silicon, ("first", (p,))), rtol=RTOL, record=())
    return ours, float(result.spikes["spike"][0]) - START


def weighted_cell(distances: Mapping[int, int]) -> Circuit:
    """Return a first-layer cell whose inhibitions have a bias line for each distance of their memory."""
    cell = latency_race.build(latency_race.Params(excitations=EXCITATIONS, inhibitions=INHIBITIONS))
    lines = [f"v_inh_{k}" for k in range(REACH + 1)]
    ports = [port for port in cell.ports if port.name != "v_inh"]
    ports += [Port(name, "bias") for name in lines]
    instances = []
    for part in cell.instances:
        wires = dict(part.connections)
        if part.name.startswith("inhibit"):
            k = int(part.name.removeprefix("inhibit"))
            wires["v_inh"] = lines[distances.get(k, abs(k - REACH))]
        instances.append(replace(part, connections=wires))
    return replace(cell, ports=tuple(ports), instances=tuple(instances), biases=())


def decisions_at(chip: LatencyChip, p: int, u: int) -> list[tuple[bool, bool]]:
    """Return whether unit u of memory p spikes just inside and outside its window: model, and circuit."""
    return [
        unit_spikes(chip, p, u, share * float(chip.lumped.window[p, u, 0])) for share in (INSIDE, OUTSIDE)
    ]


def unit_spikes(chip: LatencyChip, p: int, u: int, lag: float) -> tuple[bool, bool]:
    """Return whether a unit spikes for a second input `lag` (s) after its tap: model, and circuit."""
    c, n = chip.lumped, chip.design.paths
    settle = 2.5 * float(c.tonic[p, u])
    tap = float(np.cumsum(c.tap)[u + 1])
    spike = np.full(n, math.inf)
    spike[p] = tap + lag
    detected, out = np.empty((n, chip.design.taps)), np.empty(n)
    given = np.full(detected.shape, np.nan)
    recall(c, chip.new_memory(), settle, spike, given, detected, out)
    at = START + settle + tap
    events: Events = {"reset": [START], "tap": [at], "integrating": [at + lag]}
    parts = (("memory", (p,)), ("unit", (u,)))
    result = _run(chip, latency_unit.build(), parts, UNIT_WIRES, {}, events, at + 2.0 * lag)
    return bool(detected[p, u] < math.inf), bool(result.spikes["spike"].size)


def _run(
    chip: LatencyChip, part: Circuit, parts: Parts, wires: Wires, element: dict[str, int], events: Events,
    stop: float, watch: str = "spike",
) -> Result:  # fmt: skip
    volts = line_volts(chip.biases, chip.silicon, wires, element)
    bench = bench_at(part.name, part, volts, events, stop + START, chip.silicon.process.v_dd, (watch,))
    return simulate(bench, standing(chip.silicon, *parts), rtol=RTOL, record=())


def _usual_chip(silicon: Silicon) -> LatencyChip:
    return LatencyChip(usual_design(), silicon=silicon)


MODEL = plain_model("latency-chip", circuits, measure, held_out_errors, _usual_chip)
