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
        """All spikes are kept as it is."""

    def _get_spiketimes(self, ids: Any, clear: bool = False) -> dict[int, F64]:  # noqa: FBT001, FBT002 - PyNN's
        cells = [int(cell) for cell in ids]
        if self.population.is_source:
            return {cell: self.population.events(cell, 0.0, state.t) for cell in cells}
        return state.times(cells)

    def _local_count(self, variable: Any, filter_ids: Any = None) -> dict[int, int]:
        cells = self.filter_recorded(variable, filter_ids)
        return {cell: times.size for cell, times in self._get_spiketimes(sorted(cells)).items()}

    def _clear_simulator(self) -> None:
        """Spikes stay until the chip begins again."""

    def _reset(self) -> None:
        """Nothing is to be undone."""
