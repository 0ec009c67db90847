"""The wavefront chip at transistor level: a grid of cells, each with its axon and eight neighbours.

A cell that fires starts its axon, whose step arrives at all neighbours. Input k of a cell comes from the
neighbour in direction k (N, NE, E, SE, S, SW, W, NW); inputs from beyond the edge are at ground. Wires are
resistors. The devices of cell (r, c) and of its axon have the deviations of `cell[r,c]` and `axon[r,c]` on a
die, whatever the size of the grid.

On a small grid the simulator shows the whole wave: 16 cells with 2048 transistors take 7 s. The 400 cells of
the chip are here for their places, as in `--at wavefront-chip/axon[3,4]`.

Source: 20 x 20 cells with eight neighbours each, Hwu et al. 2018, section II. The chip is ours.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from circuits.arrays import F64, I64
from circuits.blocks.block import DURATION, Block, Stimulus, Values
from circuits.blocks.drive import Wave, powered, step
from circuits.blocks.ports import SUPPLY, event_in
from circuits.blocks.sizes import Sizes
from circuits.blocks.wavefront import axon_delay
from circuits.blocks.wavefront import cell as wavefront_cell
from circuits.blocks.wavefront.axon_delay import EDGE, UNIT, code_voltages
from circuits.blocks.wavefront.cell import INPUTS
from circuits.circuit import Circuit, Node, Port
from circuits.devices import Resistor
from circuits.errors import ParameterError
from circuits.event import pulse
from circuits.lowering.supply import half_supply
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

# (row, column) of the neighbour at input k, relative to the cell
NEIGHBOURS = ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Size of the grid, resistance of a wire (Ohm; ours), and the sizes of cells and axons."""

    rows: int = quantity(20, "")
    columns: int = quantity(20, "")
    wire_resistance: float = quantity(100.0, "Ohm")
    cell: wavefront_cell.Params = field(default_factory=wavefront_cell.Params)
    axon: axon_delay.Params = field(default_factory=axon_delay.Params)


def build(params: Params = Params()) -> Circuit:
    """The chip: for each cell ports start, acknowledge (events in), fired, request, first[8] (events out).

    Each cell also has v_code[5] and v_blocked; reset, the biases of the axons and the supply are shared.
    """
    shape = (params.rows, params.columns)
    cell, axon = wavefront_cell.build(params.cell), axon_delay.build(params.axon)
    own = {"arrive", "start", "acknowledge", "fired", "request", "first", "v_blocked"}
    ports = (
        SUPPLY,
        *event_in("reset"),
        *(replace(p, shape=shape + p.shape) for p in cell.ports if p.name in own - {"arrive"}),
        Port("v_code", "bias", "in", shape + axon.port("v_code").shape),
        *(axon.port(b.port) for b in axon.biases),
    )
    arrays = (cell.array("cell", shape), axon.array("axon", shape))
    nodes = (Node("arrive", (*shape, INPUTS)), Node("delayed", shape))
    biases = (*(replace(b, device=b.device and f"axon.{b.device}") for b in axon.biases), *cell.biases)
    return Circuit("wavefront_chip", ports, tuple(_wires(params)), arrays, nodes, biases)


def _wires(params: Params) -> Iterator[Resistor]:
    for row in range(params.rows):
        for column in range(params.columns):
            for k, (down, right) in enumerate(NEIGHBOURS):
                r, c = row + down, column + right
                inside = 0 <= r < params.rows and 0 <= c < params.columns
                source = f"delayed[{r},{c}]" if inside else "0"
                target = f"arrive[{row},{column},{k}]"
                yield Resistor(f"w{row}_{column}_{k}", target, source, params.wire_resistance)


RESET_END = 10e-6  # s, ours: a plan begins in the reset
START_TIME = 20e-6  # s, ours: when the start is pulsed
MARGIN = 1.5  # length of a run over the longest nominal way through the grid, ours

STIMULI = (
    Stimulus("code", "", 2.0, "cost code of every cell, 0 to 31"),
    Stimulus("start_row", "", 0.0, "row of the start"),
    Stimulus("start_column", "", 0.0, "column of the start"),
    DURATION,
)


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """A reset until 10 us and the start's pulse at 20 us; every cell has the same code.

    Raises `ParameterError` for a start outside of the grid.
    """
    code = stimuli["code"] or 0.0
    start = tuple(_whole(stimuli, name) for name in ("start_row", "start_column"))
    rows, columns = circuit.port("start").shape
    if not (0 <= start[0] < rows and 0 <= start[1] < columns):
        raise ParameterError(f"start: {start[0]},{start[1]}, must be inside {rows} x {columns} cells")
    codes = np.full((rows, columns), code)
    stop = stimuli["duration"] or START_TIME + MARGIN * UNIT * code * max(rows, columns)
    return plan_testbench(circuit, codes, (start[0], start[1]), stop, v_dd)


def plan_testbench(
    circuit: Circuit, codes: F64 | I64, start: tuple[int, int], stop: float,
    v_dd: float,
) -> Testbench:  # fmt: skip
    """One plan from the cell `start`, (row, column), on a grid of codes, [rows, columns].

    A cell of code 0 is blocked. stop: length of the run, s. v_dd: supply, V.
    """
    waves: dict[str, Wave] = {"reset": step(RESET_END, RESET_END + EDGE, v_dd, 0.0)}
    for index in np.ndindex(codes.shape):
        at = ",".join(map(str, index))
        waves[f"start[{at}]"] = pulse((START_TIME,), v_dd) if index == tuple(start) else 0.0
        waves[f"acknowledge[{at}]"] = 0.0
        if codes[index] == 0:
            waves[f"v_blocked[{at}]"] = v_dd
        bits = code_voltages(float(codes[index]), v_dd)
        waves |= {f"v_code[{at},{k}]": v for k, v in enumerate(bits)}
    return Testbench("wavefront grid", circuit, powered(v_dd, waves), stop, watch=("fired", "first"))


def firing_times(result: Result) -> F64:
    """Time at which each cell fired, float64[rows, columns], s; infinite where it did not."""
    shape = result.machine.testbench.circuit.port("fired").shape
    found = np.full(shape, np.inf)
    for index in np.ndindex(shape):
        spikes = result.spikes[f"fired[{','.join(map(str, index))}]"]
        found[index] = spikes[0] if spikes.size else np.inf
    return found


def pointers(result: Result) -> I64:
    """Lowest bit of each cell's first arrivals at the end, int64[rows, columns]; -1 where none is set."""
    half = half_supply(result.machine)
    shape = result.machine.testbench.circuit.port("first").shape
    bits = np.zeros(shape, dtype=np.bool_)
    for index in np.ndindex(shape):
        bits[index] = result[f"first[{','.join(map(str, index))}]"][-1] > half
    return np.where(bits.any(axis=-1), bits.argmax(axis=-1), -1)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `fired_cells`, and `arrival_s` of the last cell after the first, None without any."""
    times = firing_times(result)
    fired = times[np.isfinite(times)]
    return {
        "fired_cells": float(fired.size),
        "arrival_s": float(fired.max() - fired.min()) if fired.size else None,
    }


def outcome(result: Result) -> str:
    """`reached` where every cell fired, `partly` or `none`."""
    reached = np.isfinite(firing_times(result))
    return "reached" if reached.all() else "partly" if reached.any() else "none"


def _whole(stimuli: Values, name: str) -> int:
    value = stimuli[name] or 0.0
    if value != int(value):
        raise ParameterError(f"{name}: {value:g}, must be a whole number")
    return int(value)


CHIP = Block(
    name="wavefront-chip",
    summary="20 x 20 wavefront cells with axons; simulate a part: rows=2, columns=3",
    build=build,
    stimuli=STIMULI,
    testbench=testbench,
    measures=measures,
    outcome=outcome,
    plotted=("fired[0,0]", "axon[0,0].ramp", "delayed[0,0]"),
)
