"""Populations of PyNN on the chip: neurons, or sources of events."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np
from pyNN import common
from pyNN.parameters import ParameterSpace, simplify

from chips.rolls.pynn.cells import RollsNeuron, SpikeSourceArray, SpikeSourcePoisson
from chips.rolls.pynn.recording import Recorder
from chips.rolls.pynn.simulator import ID, MS, WINDOW, simulator
from circuits.arrays import F64
from circuits.errors import ParameterError, UnknownNameError

_SOURCES = (SpikeSourceArray, SpikeSourcePoisson)


class Assembly(common.Assembly):  # type: ignore[misc]  # PyNN has no types
    """Several populations together."""

    _simulator = simulator

    @property
    def receptor_types(self) -> list[str]:
        """Those of all its populations, in the order of the first's; the first one is the usual one."""
        first, *others = (each.receptor_types for each in self.populations)
        return [name for name in first if all(name in each for each in others)]

    @property
    def position_generator(self) -> Any:
        """Positions of cells, in rows as those of a population; PyNN's are in columns."""
        return lambda places: self.positions.T[places]


class PopulationView(common.PopulationView):  # type: ignore[misc]  # PyNN has no types
    """Some cells of a population."""

    _simulator = simulator
    _assembly_class = Assembly

    def _get_parameters(self, *names: str) -> ParameterSpace:
        self.grandparent.check_names(names)
        values = {name: simplify(self.grandparent.parameters[name][self._places()]) for name in names}
        return ParameterSpace(values, shape=(self.size,))

    def _set_parameters(self, parameter_space: ParameterSpace) -> None:
        self.grandparent.change(parameter_space, self._places())

    def _set_initial_value_array(self, variable: str, initial_values: Any) -> None:
        self.grandparent.refuse_initial(variable)

    def _get_view(self, selector: Any, label: str | None = None) -> PopulationView:
        return PopulationView(self, selector, label)

    def _places(self) -> Any:
        return self.index_in_grandparent(np.arange(self.size))


class Population(common.Population):  # type: ignore[misc]  # PyNN has no types
    """Cells of one kind.

    parameters : array of each parameter by its name, one a cell; is_source : whether they are no neurons.
    """

    _simulator = simulator
    _recorder_class = Recorder
    _assembly_class = Assembly

    def __init__(self, size: Any, cellclass: Any, cellparams: Any = None, *given: Any, **named: Any) -> None:
        if isinstance(cellclass, type) and cellparams is None:
            cellparams = {}
        super().__init__(size, cellclass, cellparams, *given, **named)

    def events(self, cell: int, begin: float, stop: float) -> F64:
        """Return the events of a source from `begin` to before `stop`, ms, in their order."""
        at = self.id_to_index(cell)
        if isinstance(self.celltype, SpikeSourceArray):
            times = np.asarray(self.parameters["spike_times"][at].value, dtype=np.float64)
        else:
            rate, start, duration = (float(self.parameters[p][at]) for p in ("rate", "start", "duration"))
            begin, stop = max(begin, start), min(stop, start + duration)
            times = _poisson(int(cell), rate, begin, stop)
        return np.sort(times[(times >= begin) & (times < stop)])

    def change(self, parameter_space: ParameterSpace, places: Any = slice(None)) -> None:
        """Change parameters of cells at some places; those of neurons until the first run."""
        if not self.is_source:
            simulator.state.check_open(self.label)
        size = len(np.arange(self.size)[places])
        parameter_space.shape = (size,)
        parameter_space.evaluate(simplify=False)
        given = parameter_space.as_dict()
        _check(given, self.label)
        if "spike_times" in given:
            self._warn_of_past(self.all_cells[places], given["spike_times"])
        for name, values in given.items():
            self.parameters[name][places] = values

    def _warn_of_past(self, cells: Any, times: Any) -> None:
        """Warn of events before now that were not given then: only after a reset would they happen."""
        now = simulator.state.t
        sent = simulator.state.given([int(cell) for cell in cells])
        late = 0
        for cell, each in zip(cells, times, strict=True):
            asked = np.asarray(each.value, dtype=np.float64)
            late += int(np.count_nonzero(~np.isin(asked[asked < now], sent[int(cell)])))
        if late:
            warnings.warn(
                f"pynn.{self.label}.spike_times: {late} events before now, {now:g} ms, which do not happen;"
                " give later ones, or reset",
                stacklevel=5,
            )

    def inject(self, current_source: Any) -> None:
        """Raise `ParameterError`: nothing drives a current of one neuron."""
        raise ParameterError(
            f"pynn.{self.label}.inject: ROLLS has no current that a program drives; take a SpikeSource"
        )

    def refuse_initial(self, variable: str) -> None:
        """Raise `ParameterError`: neurons begin at rest."""
        raise ParameterError(f"pynn.{self.label}.{variable}: neurons of ROLLS begin at rest; leave it out")

    def _create_cells(self) -> None:
        if not isinstance(self.celltype, (RollsNeuron, *_SOURCES)):
            raise ParameterError(
                f"pynn.{self.label}: {type(self.celltype).__name__}, must be RollsNeuron, SpikeSourceArray or"
                " SpikeSourcePoisson; ROLLS has no other cells"
            )
        self.is_source = isinstance(self.celltype, _SOURCES)
        ids = simulator.state.place(self.size, source=self.is_source, label=self.label)
        self.all_cells = np.array([ID(k) for k in ids], dtype=ID)
        self._mask_local = np.ones(self.size, dtype=np.bool_)
        for cell in self.all_cells:
            cell.parent = self
        space = self.celltype.parameter_space
        space.shape = (self.size,)
        space.evaluate(simplify=False)
        self.parameters = space.as_dict()
        _check(self.parameters, self.label)
        simulator.state.populations.append(self)

    def check_names(self, names: Iterable[str]) -> None:
        """Raise `UnknownNameError` for a parameter that its cells do not have."""
        for name in names:
            if name not in self.parameters:
                raise UnknownNameError(
                    f"pynn.{self.label}.{name}: not a parameter, must be {', '.join(self.parameters)}"
                )

    def _get_parameters(self, *names: str) -> ParameterSpace:
        self.check_names(names)
        return ParameterSpace({name: simplify(self.parameters[name]) for name in names}, shape=(self.size,))

    def _set_parameters(self, parameter_space: ParameterSpace) -> None:
        self.change(parameter_space)

    def _set_initial_value_array(self, variable: str, initial_values: Any) -> None:
        self.refuse_initial(variable)

    def _get_view(self, selector: Any, label: str | None = None) -> PopulationView:
        return PopulationView(self, selector, label)


def _check(parameters: dict[str, Any], label: str) -> None:
    """Raise `ParameterError` for a rate or a time that no source can have."""
    for name, unit in (("rate", "Hz"), ("spike_times", "ms"), ("start", "ms"), ("duration", "ms")):
        for each in parameters.get(name, ()):
            values = np.asarray(getattr(each, "value", each), dtype=np.float64)
            wrong = values[~(np.isfinite(values) & (values >= 0.0))]
            if wrong.size:
                raise ParameterError(
                    f"pynn.{label}.{name}: {wrong.flat[0]:g} {unit}, must be 0 or more and finite"
                )


def _poisson(cell: int, rate: float, begin: float, stop: float) -> F64:
    """Random events from `begin` to `stop`, ms, by keys: those of a window do not depend on the others."""
    found = [np.empty(0)]
    for window in range(int(begin // WINDOW), int(np.ceil(stop / WINDOW))):
        key = (simulator.state.setting.seed, simulator.state.segment_counter, cell, window)
        draw = np.random.default_rng(key)
        found.append((window + draw.random(draw.poisson(rate * WINDOW * MS))) * WINDOW)
    return np.concatenate(found)
