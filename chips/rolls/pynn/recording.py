"""What PyNN records on the chip: spikes."""

from __future__ import annotations

from typing import Any

from pyNN import recording

from chips.rolls.pynn.simulator import simulator, state
from circuits.arrays import F64
from circuits.errors import ParameterError


class Recorder(recording.Recorder):  # type: ignore[misc]  # PyNN has no types
    """Spikes of a population."""

    _simulator = simulator

    def __init__(self, population: Any, file: Any = None) -> None:
        super().__init__(population, file)
        self._since: dict[int, float] = {}  # ms, when the recording of each cell began

    def record(self, variables: Any, ids: Any, *given: Any, **named: Any) -> None:
        """Record spikes of some cells; raises `ParameterError` for anything else."""
        asked = [variables] if isinstance(variables, str) else list(variables)
        if asked != ["spikes"]:
            raise ParameterError(
                f"pynn.{self.population.label}.record: {', '.join(map(str, asked))}, must be spikes; they are"
                " all that leaves the chip"
            )
        super().record(asked, ids, *given, **named)

    def _record(self, variable: Any, new_ids: Any, sampling_interval: float | None = None) -> None:
        self._since |= {int(cell): state.t for cell in new_ids}

    def _get_spiketimes(self, ids: Any, clear: bool = False) -> dict[int, F64]:  # noqa: FBT001, FBT002 - PyNN's
        cells = [int(cell) for cell in ids]
        found = state.given(cells) if self.population.is_source else state.times(cells)
        return {cell: times[times >= self._since[cell]] for cell, times in found.items()}

    def store_to_cache(self, annotations: Any = None) -> None:
        """Keep what this segment has recorded; the next one begins at 0 ms."""
        super().store_to_cache(annotations)
        self._since = dict.fromkeys(self._since, 0.0)

    def _local_count(self, variable: Any, filter_ids: Any = None) -> dict[int, int]:
        cells = self.filter_recorded(variable, filter_ids)
        return {cell: times.size for cell, times in self._get_spiketimes(sorted(cells)).items()}

    def _clear_simulator(self) -> None:
        self._since = dict.fromkeys(self._since, state.t)

    def _reset(self) -> None:
        self._since = {}
