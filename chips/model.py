"""Behavioural models that stand for circuits: what one is, and all of them by command-line name.

A model is measured from its circuits by the transistor-level solver, and judged on dies that were not used to
build it. Both are in its record (`chips.record`), named after the model, from which it is loaded. The models
are loaded on use; users add theirs under the entry point `noctule.models`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from chips.record import Record, recorded
from circuits.catalogue import Catalogue
from circuits.circuit import Circuit
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon

MODELS: dict[str, str] = {
    "rebound-neuron": "chips.ranging.measure:MODEL",
    "centroid-board": "chips.boards.centroid.measure:MODEL",
    "vocalization-controller": "chips.boards.vocalization.measure:MODEL",
    "hearing": "chips.hearing.measure:MODEL",
    "first-target-isolation": "chips.boards.isolation.measure:MODEL",
    "winner-take-all": "chips.selection.measure:MODEL",
    "latency-chip": "chips.latency.errors:MODEL",
    "lso-neuron": "chips.lso.errors:MODEL",
    "axon-delay": "chips.wavefront.measure:AXON_MODEL",
    "wavefront-cell": "chips.wavefront.measure:CELL_MODEL",
}

Progress = Callable[[float], None]  # is told the share that is done
Biases = Mapping[str, float]  # A or V by name
Tuned = Callable[[Silicon], tuple[str, Mapping[str, float]]]


@dataclass(frozen=True, slots=True)
class Sheet:
    """Behavioural cells of a circuit on one die.

    shape: of the array of cells, () for a lone one; figures: numbers of each cell's equations by name, SI
    units; remarks: lines about validity and measured error.
    """

    shape: tuple[int, ...]
    figures: tuple[dict[str, float], ...]
    remarks: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Cells:
    """How a model is written down for other simulators.

    blocks: names of the blocks and chips whose circuits are such cells; sheet: of one of these circuits on
    the silicon.
    """

    blocks: tuple[str, ...]
    sheet: Callable[[Circuit, Silicon], Sheet]


@dataclass(frozen=True, slots=True)
class Proxy:
    """What a search may ask of a model in the place of its circuit's own runs.

    metrics: that the model knows; tuned: of a circuit in a process, gives the outcome's word and values of
    the metrics by name on a silicon, `nan` where one is not defined.
    """

    metrics: tuple[str, ...]
    tuned: Callable[[Circuit, Process], Tuned]


def nothing(record: Record) -> Mapping[str, float]:
    """No figures."""
    return {}


@dataclass(frozen=True, slots=True)
class Model:
    """A behavioural model.

    name: on the command line, and of the record with underscores; circuits: builds what the record is of;
    measure: makes the record without its errors, and is told where to report its progress; held_out: errors
    of the model with this record, which is in force, on dies that were not used to build it, biased as given
    (the circuits' own biases unless given); load: the model with its circuits' own biases on a silicon,
    `ParameterError` outside its box, `DataError` where the record is of something else. figures: what else
    follows from the record, by name with the unit at its end; cells, proxy: where the model has them.
    """

    name: str
    circuits: Callable[[], Sequence[Circuit]]
    measure: Callable[[Progress], Record]
    held_out: Callable[[Record, Biases | None], Mapping[str, float]]
    load: Callable[[Silicon], object]
    figures: Callable[[Record], Mapping[str, float]] = nothing
    cells: Cells | None = None
    proxy: Proxy | None = None

    @property
    def record_name(self) -> str:
        """Name of the model's record."""
        return self.name.replace("-", "_")


def plain_model(
    name: str,
    circuits: Callable[[], Sequence[Circuit]],
    measure: Callable[[], Record],
    errors: Callable[[], Mapping[str, float]],
    load: Callable[[Silicon], object],
) -> Model:
    """A model that tells no progress, whose errors are always those of its circuits' own biases.

    errors: of the record in force; the others as in `Model`.
    """
    return Model(name, circuits, lambda _: measure(), lambda *_: errors(), load)


_models: Catalogue[Model] = Catalogue("model", MODELS, "noctule.models", ("chips.model:Model",))

model_names, load_model = _models.names, _models.load


def characterise(model: Model, progress: Progress, biases: Biases | None = None) -> Record:
    """Measure a model's record, errors included, and write it nowhere; `SolverError` where it cannot be.

    progress: is told the share that is done; biases: of the circuits on the dies of the errors, their own
    unless given.
    """
    record = model.measure(lambda share: progress(0.95 * share))
    with recorded(model.record_name, record):
        errors = model.held_out(record, biases)
    progress(1.0)
    return replace(record, errors=errors)
