"""The wavefront chip: cells whose axons delay a spike by a programmed cost, so that a wave plans a path.

Each cell's axon holds a 5-bit code, 1 to 31 units of delay; 0 blocks the cell. A plan resets all latches,
fires the start cell and ends with the goal's first spike; every cell fires once, at t_i = min_j (t_j + D_ij),
and its latch keeps which input came first. Ideal cells delay by exactly code times `unit`, `ChipCells` as the
axons and inputs of their silicon do (`chips.wavefront.model`); `delays` given to a plan replace both.

Spikes leave by the address-event bus; the address of a cell is its number, row * columns + column on a
grid. Temperature may change from plan to plan and, given as a course, within one: delays under way go on at
the new one's pace. Ideal cells know no temperature.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from chips.aer import Bus, Events, send
from chips.noise import SiliconNoise
from chips.wavefront.axon_conditions import AxonModel
from chips.wavefront.axon_graph import AxonGraph, grid_graph
from chips.wavefront.cell_codes import CellCodes
from chips.wavefront.kernel import Wave, graph_wave, integer_wave
from chips.wavefront.model import chip_model, edge_delays, graph_shape
from chips.wavefront.noise import axon_jitter, in_line_time
from chips.wavefront.readout import Cell, pointer_nodes, pointer_path
from chips.wavefront.spiking_wavefront import round_delays
from chips.wavefront.temperature import course_of, wave_along
from circuits.arrays import F64, I8, I64, Bools
from circuits.blocks.wavefront.axon_delay import HIGHEST, UNIT
from circuits.circuit import BiasKind
from circuits.devices.source import Polyline
from circuits.errors import ParameterError
from circuits.silicon.silicon import Silicon

Place = Cell | int  # (row, column) on a grid, a cell's number on a graph


@dataclass(frozen=True, slots=True, eq=False)
class Program:
    """Codes that are written to a chip.

    Attributes
    ----------
    codes : array
        Code of each cell, int64[rows, columns] or int64[cells].
    rounded : int
        How many of them were rounded.
    """

    codes: I64
    rounded: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """One wave over a chip.

    Attributes
    ----------
    start, goal
        Numbers of the cells; the goal is None where there was none.
    arrivals
        When each cell fired, s, inf where it did not, float64 of the chip's shape.
    pointers
        Which input of each cell came first, -1 for none, int8 of that shape.
    ties
        How many cells several spikes reached first together.
    bus
        Bus by which spikes leave.
    graph
        Cells and axons; None on a grid.
    """

    start: int
    goal: int | None
    arrivals: F64
    pointers: I8
    ties: int
    bus: Bus
    graph: AxonGraph | None = None

    def path(self) -> I64:
        """Return the path from start to goal, int64[n, 2] on a grid, int64[n] on a graph, the start first.

        Raises `UnreachableError` where the goal did not fire, and `ParameterError` where the plan had none.
        """
        if self.goal is None:
            raise ParameterError("plan.goal: none, must be a cell; plan with a goal")
        if self.graph is not None:
            return pointer_nodes(self.graph, self.pointers, self.start, self.goal)
        columns = self.pointers.shape[1]
        return pointer_path(self.pointers, divmod(self.start, columns), divmod(self.goal, columns))

    def events(self) -> Events:
        """Return the spikes after the bus."""
        flat = self.arrivals.ravel()
        fired = np.flatnonzero(np.isfinite(flat))
        return send(self.bus, flat[fired], fired)


@dataclass(frozen=True, slots=True)
class ChipCells:
    """Cells that are made of transistors.

    silicon: process, temperature and die. bias_kind: kind of their biases. area: area of their devices over
    the usual, a ratio. noise: what makes one die's plans differ from each other; nothing unless given.
    calibrated: the axons of all cells as they were timed; costs are written as codes unless given.
    """

    silicon: Silicon = field(default_factory=Silicon)
    bias_kind: BiasKind = "generator"
    area: float = 1.0
    noise: SiliconNoise | None = None
    calibrated: CellCodes | None = None

    @property
    def current(self) -> float | None:
        """Current of the axons' sinks, A, where they have been calibrated, else that of the unit."""
        return None if self.calibrated is None else self.calibrated.current


class WavefrontChip:
    """A wavefront chip: a grid of cells, or the cells and axons of a graph.

    Weights of single axons, as of a networkx graph, have no code: a plan takes them as `delays`.

    Parameters
    ----------
    rows, columns
        Size of the grid.
    graph
        Cells and axons, in the place of a grid.
    cells
        What the cells are made of; None for ideal ones.
    unit
        Delay of a unit of code, s.
    bus
        Bus by which spikes leave.

    Raises
    ------
    ParameterError
        The chip has no cells, or the unit is not above 0.
    """

    def __init__(
        self,
        rows: int = 20,
        columns: int = 20,
        *,
        graph: AxonGraph | None = None,
        cells: ChipCells | None = None,
        unit: float = UNIT,
        bus: Bus | None = None,
    ) -> None:
        """Raise `ParameterError` for a chip without cells, or a unit that is not above 0."""
        if graph is None and (rows < 1 or columns < 1):
            raise ParameterError(
                f"wavefront_chip.shape: {rows} x {columns}, must be at least 1 x 1; add cells"
            )
        if not (0.0 < unit < np.inf):
            raise ParameterError(f"wavefront_chip.unit: {unit:g} s, must be > 0; the usual one is {UNIT:g} s")
        self.shape: tuple[int, ...] = (rows, columns) if graph is None else (graph.cells,)
        self.graph, self.cells, self.unit, self.bus = graph, cells, unit, bus or Bus()

    @cached_property
    def axons(self) -> AxonGraph:
        """The chip's axons, in whose order edges have their delays."""
        return grid_graph(*self.shape) if self.graph is None else self.graph

    def program(self, costs: NDArray[np.integer] | F64) -> Program:
        """Return the codes of whole costs; a map smaller than the grid stands at its first row and column.

        Raises `ParameterError` for a map larger than the chip, and for a cost that is no whole number of 0 to
        31.

        Parameters
        ----------
        costs
            Number of 0 (blocked) to 31 for each cell, [rows, columns] or [cells].
        """
        costs = np.asarray(costs)
        self._check_size(costs.shape)
        if costs.dtype.kind not in "iub":
            self._check(costs, costs == np.floor(costs), "must be a whole number; round it, or learn it")
        inside = (costs >= 0) & (costs <= HIGHEST)
        self._check(costs, inside, f"must be 0 (blocked) to {HIGHEST}; scale the map")
        return Program(self._written(costs))

    def write(self, learned: F64) -> Program:
        """Return the codes of real-valued delays, rounded to the nearest from 1, halves up; 0 is blocked.

        Raises `ParameterError` for a map larger than the chip, and for delays below 0 or above 31 when
        rounded.

        Parameters
        ----------
        learned
            Delays in units of code, float64[rows, columns] or float64[cells].
        """
        learned = np.asarray(learned, dtype=np.float64)
        self._check_size(learned.shape)
        inside = (learned >= 0.0) & (learned < HIGHEST + 0.5)
        self._check(learned, inside, f"must be 0 (blocked) to {HIGHEST} when rounded; scale the map")
        codes = round_delays(learned)
        return Program(self._written(learned), int((codes != learned).sum()))

    def plan(
        self,
        program: Program,
        start: Place,
        goal: Place | None = None,
        *,
        delays: F64 | None = None,
        temperature: float | Polyline | None = None,
        time: float = 0.0,
        number: int = 0,
    ) -> Plan:
        """Reset the chip, fire one cell, and run to the first spike of another, or over the whole chip.

        Parameters
        ----------
        program
            Codes of the cells.
        start
            Cell that fires first: row and column, or its number.
        goal
            Cell at which the wave ends; None for the whole chip.
        delays
            Delays of the edges instead of the cells' own, s, float64[edges].
        temperature
            Temperature, degC, or times (s) and temperatures, float64[T] each, which the wave follows; the
            silicon's unless given.
        time
            When the plan begins, s of those times.
        number
            Number of the plan, which draws its noise.

        Raises
        ------
        ParameterError
            Start or goal is off the chip or blocked, the silicon is outside its record, or the temperatures
            are no course.
        """
        codes = program.codes
        first = self._number(start, "start", codes)
        last = None if goal is None else self._number(goal, "goal", codes)
        run = partial(self._wave, codes, first, last)
        if delays is not None or self.cells is None:
            wave = run(delays)
        else:
            own = partial(self._own_delays, self.cells, codes, number)
            if isinstance(temperature, tuple):
                course = course_of(temperature)
                begun, wave = course.at(time), wave_along(self.axons, run, own, course, time)
            else:
                begun = self.cells.silicon.temperature_c if temperature is None else temperature
                wave = run(own(begun))
            wave = self._noisy(self.cells, wave, number, begun, time)
        pointers, arrivals = wave.pointers.reshape(self.shape), wave.arrivals.reshape(self.shape)
        return Plan(first, last, arrivals, pointers, wave.ties, self.bus, self.graph)

    def _wave(self, codes: I64, first: int, last: int | None, delays: F64 | None) -> Wave:
        if delays is None and self.graph is None:
            columns = self.shape[1]
            goal = None if last is None else divmod(last, columns)
            wave = integer_wave(codes, divmod(first, columns), goal)
            return wave._replace(arrivals=wave.arrivals * self.unit)
        flat, scale = codes.ravel(), 1.0
        if delays is None:
            delays, scale = flat[self.axons.sources()].astype(np.float64), self.unit
            delays[delays == 0.0] = np.inf
        wave = graph_wave(self.axons, delays, first, last, flat == 0)
        return wave._replace(arrivals=wave.arrivals * scale)

    def _own_delays(self, cells: ChipCells, codes: I64, number: int, temperature_c: float) -> F64:
        silicon = replace(cells.silicon, temperature_c=temperature_c)
        kind, flat = cells.bias_kind, codes.ravel()
        delays = edge_delays(
            self.axons, flat, silicon, bias_kind=kind, unit=self.unit, area=cells.area, current=cells.current
        )
        if cells.noise is None:
            return delays
        sources = self.axons.sources()
        own = np.full(flat.size, np.inf)
        own[sources] = delays
        return delays + axon_jitter(self._model(cells), silicon, own, cells.noise, number)[sources]

    def _model(self, cells: ChipCells) -> AxonModel:
        return chip_model(
            graph_shape(self.axons), cells.silicon.process, bias_kind=cells.bias_kind, unit=self.unit,
            area=cells.area, current=cells.current,
        )  # fmt: skip

    def _noisy(self, cells: ChipCells, wave: Wave, number: int, temperature_c: float, time: float) -> Wave:
        """The wave at the times that the wandering line of all axons makes of it."""
        if cells.noise is None:
            return wave
        silicon = replace(cells.silicon, temperature_c=temperature_c)
        plan = number, time
        return wave._replace(
            arrivals=in_line_time(self._model(cells), silicon, wave.arrivals, cells.noise, plan)
        )

    def _number(self, place: Place, name: str, codes: I64) -> int:
        where = place if isinstance(place, tuple) else (place,)
        if len(where) != len(self.shape) or not all(
            0 <= k < n for k, n in zip(where, self.shape, strict=True)
        ):
            raise ParameterError(
                f"plan.{name}: {place}, must be a cell of the chip of {self._size()}; cells count from 0"
            )
        if codes[where] == 0:
            raise ParameterError(
                f"plan.{name}: {place} is blocked, must have a code from 1; choose another cell"
            )
        return int(np.ravel_multi_index(where, self.shape))

    def _check_size(self, shape: tuple[int, ...]) -> None:
        smaller = len(shape) == len(self.shape) and all(
            a <= b for a, b in zip(shape, self.shape, strict=True)
        )
        if not smaller or 0 in shape or (len(shape) == 1 and shape != self.shape):
            raise ParameterError(
                f"wavefront_chip.map: {' x '.join(map(str, shape))}, must fit {self._size()};"
                " cut the map, or take a larger chip"
            )

    def _check(self, values: NDArray[np.integer] | F64, right: Bools, rule: str) -> None:
        if not right.all():
            where = tuple(int(k) for k in np.argwhere(~right)[0])
            raise ParameterError(f"wavefront_chip.map[{', '.join(map(str, where))}]: {values[where]}, {rule}")

    def _written(self, costs: NDArray[np.integer] | F64) -> I64:
        """Codes of all cells for the costs of a map, which is right and fits."""
        whole = np.zeros(self.shape, dtype=np.float64)
        whole[tuple(slice(n) for n in costs.shape)] = costs
        if self.cells is None or self.cells.calibrated is None:
            return round_delays(whole)
        return self.cells.calibrated.written(whole)

    def _size(self) -> str:
        return " x ".join(map(str, self.shape)) + " cells"
