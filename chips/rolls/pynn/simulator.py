"""The chip behind PyNN's calls: where neurons and sources stand, what is written to it, and its run.

Neurons of populations are neurons of the chip from 0 on. A source takes the column of synapses of a neuron
that no population has, from 255 down: its event is one to each synapse of that column that has a level, as a
host sends them over the chip's bus. Times are ms here, as in PyNN, and s for the chip.
"""

from __future__ import annotations

import sys
import warnings
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pyNN import common

from chips.noise import SiliconNoise
from chips.rolls.chip import STEP, WHOLE, ChipState, Inputs, RollsChip
from chips.rolls.program.address import NEURONS, NONPLASTIC
from chips.rolls.program.bias_file import BiasTable, resting_biases
from chips.rolls.program.program import HIGHEST_LEVEL, Program
from circuits.arrays import F64, I8, I64
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon

simulator = sys.modules[__name__]  # PyNN's classes ask for the module itself

name = "ROLLS"
MS = 1e-3
WINDOW = 100.0  # ms, of which random events are drawn by a key of their own; ours


@dataclass(frozen=True, slots=True)
class Setting:
    """What `setup` says of the chip.

    die, temperature_c (degC), bias_kind, biases, noise : as in `RollsChip`; seed : of random events.
    """

    die: Die = NOMINAL
    temperature_c: float = 27.0
    bias_kind: BiasKind = "generator"
    biases: BiasTable = field(default_factory=resting_biases)
    noise: SiliconNoise | None = None
    seed: int = 0


class ID(int, common.IDMixin):  # type: ignore[misc]  # PyNN has no types
    """A cell, by its number in the order of their making."""


class State(common.control.BaseState):  # type: ignore[misc]  # PyNN has no types
    """The one chip that a script has.

    t, dt : time and step, ms; populations, projections : all that were made.
    neurons : number on the chip of each cell, by its id; of a source, its column's.
    """

    mpi_rank, num_processes = 0, 1

    def __init__(self) -> None:
        super().__init__()
        self.setting, self.dt = Setting(), STEP / MS
        self.clear()

    @property
    def min_delay(self) -> float:
        """The step, ms: synapses of the chip have no delay."""
        return self.dt

    max_delay = min_delay

    def clear(self) -> None:
        """Forget all populations."""
        self.recorders: set[Any] = set()
        self.write_on_end: list[Any] = []
        self.populations: list[Any] = []
        self.projections: list[Any] = []
        self.neurons: list[int] = []
        self.sources = 0
        self.segment_counter = -1
        self._chip: RollsChip | None = None
        self.reset()

    def reset(self) -> None:
        """Begin again at 0 ms with a chip at rest."""
        self.running = False
        self.t = self.t_start = 0.0
        self.segment_counter += 1
        self._at: ChipState | None = None
        self._spikes: list[tuple[F64, I64]] = []
        self._given: list[tuple[F64, I64]] = []
        self.lost = {"lost_in": 0, "lost_out": 0, "held": 0}

    def place(self, count: int, *, source: bool, label: str) -> I64:
        """Take so many places, and return the ids of their cells, int64[count]."""
        self.check_open(label)
        used = len(self.neurons)
        if count < 1:
            raise ParameterError(f"pynn.{label}: {count} cells, must be >= 1; leave the population out")
        if used + count > NEURONS:
            raise ParameterError(
                f"pynn.{label}: {count} cells, must be <= {NEURONS - used}; neurons and sources share the"
                f" chip's {NEURONS} columns, make populations smaller"
            )
        first = NEURONS - self.sources - 1 if source else used - self.sources
        self.neurons += [first - k if source else first + k for k in range(count)]
        self.sources += count if source else 0
        return np.arange(used, used + count)

    def check_open(self, what: str) -> None:
        """Raise `ParameterError` where the chip runs already, with its program written."""
        if self._chip is not None:
            raise ParameterError(
                f"pynn.{what}: changed after the first run, the chip is programmed; call setup again"
            )

    def program(self) -> Program:
        """Return what is written to the chip."""
        slow = [
            self.neurons[cell]
            for each in self.populations if not each.is_source
            for cell, chosen in zip(each.all_cells, each.parameters["slow_leak"], strict=True) if chosen
        ]  # fmt: skip
        return Program(self._levels(), self.setting.biases, tuple(slow))

    def run(self, duration: float) -> None:
        """Go on for `duration`, ms."""
        self.run_until(self.t + duration)

    def run_until(self, stop: float) -> None:
        """Go on to `stop`, ms; raises `ParameterError` where that is not a whole number of steps."""
        steps = (stop - self.t) / self.dt
        if not np.isfinite(steps):
            raise ParameterError(f"pynn.run: {stop - self.t:g} ms, must be finite")
        if not abs(steps - round(steps)) < WHOLE:
            raise ParameterError(
                f"pynn.run: {stop - self.t:g} ms, must be whole steps of {self.dt:g} ms; round it, or give"
                " setup another timestep"
            )
        chip = self._opened()
        at = chip.at_rest() if self._at is None else self._at
        spikes, self._at = chip.run(at, (stop - self.t) * MS, self._inputs(chip, self.t, stop))
        self._spikes.append((spikes.times / MS, spikes.neurons))
        for each in self.lost:
            self.lost[each] += getattr(spikes, each)
        lost = spikes.lost_in + spikes.lost_out
        if lost:
            warnings.warn(f"pynn.run: the chip's bus lost {lost} events; see counts()", stacklevel=4)
        self.t, self.running = stop, True

    def given(self, cells: list[int]) -> dict[int, F64]:
        """Return the events that some sources gave so far by their ids, ms, in their order."""
        if not self._given:
            return {cell: np.empty(0) for cell in cells}
        found, origins = (np.concatenate(each) for each in zip(*self._given, strict=True))
        return {cell: found[origins == self.neurons[cell]] for cell in cells}

    def times(self, cells: list[int]) -> dict[int, F64]:
        """Return the times of the spikes of some cells so far by their ids, ms, in their order."""
        if not self._spikes:
            return {cell: np.empty(0) for cell in cells}
        found, neurons = (np.concatenate(each) for each in zip(*self._spikes, strict=True))
        done = found <= self.t  # a spike may be on the bus still
        found, neurons = found[done], neurons[done]
        return {cell: np.sort(found[neurons == self.neurons[cell]]) for cell in cells}

    def _opened(self) -> RollsChip:
        if self._chip is None:
            setting = self.setting
            silicon = Silicon(ROLLS_180, setting.temperature_c, setting.die)
            self._chip = RollsChip(
                self.program(), silicon, setting.bias_kind, step=self.dt * MS, noise=setting.noise
            )
        return self._chip

    def _levels(self) -> I8:
        levels = np.zeros((NEURONS, NEURONS), dtype=np.int8)
        for projection in self.projections:
            sign = -1 if projection.receptor_type == "inhibitory" else 1
            for synapse in projection.connections:
                level = sign * synapse.level
                pair = self.neurons[synapse.target], self.neurons[synapse.origin]
                if levels[pair]:
                    raise ParameterError(
                        f"pynn.{projection.label}: weight {level} of a pair that has {levels[pair]} already,"
                        " must be alone; two cells have one synapse with one level: drop one of them, or give"
                        " the connector with_replacement=False"
                    )
                levels[pair] = level
        return levels

    def _inputs(self, chip: RollsChip, begin: float, stop: float) -> Inputs:
        """Events of all sources from `begin` to before `stop`, ms, which are remembered as given."""
        times, origins = [np.empty(0)], [np.empty(0, dtype=np.int64)]
        for population in self.populations:
            if population.is_source:
                for cell in population.all_cells:
                    some = population.events(cell, begin, stop)
                    times.append(some)
                    origins.append(np.full(some.size, self.neurons[cell]))
        when, column = np.concatenate(times), np.concatenate(origins)
        order = np.argsort(when, kind="stable")
        when, column = when[order], column[order]
        self._given.append((when, column))
        event, target = np.nonzero(chip.program.levels.T[column])
        return Inputs(when[event] * MS, target, NONPLASTIC + column[event])


def level_of(weight: float, label: str) -> int:
    """Return the level that a weight is; raises `ParameterError` for one that is none; label: whose it is."""
    if not (1 <= weight <= HIGHEST_LEVEL and weight == int(weight)):
        raise ParameterError(
            f"pynn.{label}: weight {weight:g}, must be 1, 2, 3 or 4, a level of the chip, whose currents its"
            " biases are; receptor_type says inhibitory"
        )
    return int(weight)


state = State()
