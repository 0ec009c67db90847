"""Behavioural models that stand for circuits in a chip: what a model consists of, and the table of all.

A model is measured from its circuits by the transistor-level solver, and judged on dies that were not used to
build it. Both are in its record (`chips.record`), named after the model, from which it is loaded. The models
are loaded on use; users add theirs under the entry point `noctule.models`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

from chips.law_lattice import law_of
from chips.record import Record, recorded
from circuits.catalogue import Catalogue
from circuits.circuit import Circuit
from circuits.silicon.process import AMI_1500_IDEAL, Process
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
    """A data sheet: the cells of a circuit on one die as equations with numbers, for other simulators.

    shape: of the array of cells, () for a lone one; figures: the numbers of each cell's equations by name, in
    SI units; remarks: lines of text on validity and measured error.
    """

    shape: tuple[int, ...]
    figures: tuple[dict[str, float], ...]
    remarks: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Cells:
    """How a model is written down for other simulators.

    blocks: names of the blocks and chips whose circuits consist of such cells; sheet: makes the data sheet of
    one of these circuits on a given silicon.
    """

    blocks: tuple[str, ...]
    sheet: Callable[[Circuit, Silicon], Sheet]


@dataclass(frozen=True, slots=True)
class Proxy:
    """What a search may ask of a model instead of simulating its circuit.

    metrics: names of the metrics that the model knows; tuned: for a circuit in a process, gives a function of
    the silicon that returns the outcome's word and the metrics by name, `nan` where one is not defined.
    """

    metrics: tuple[str, ...]
    tuned: Callable[[Circuit, Process], Tuned]


def nothing(record: Record) -> Mapping[str, float]:
    """Return no figures, for a model that has none."""
    return {}


@dataclass(frozen=True, slots=True)
class Model:
    """A behavioural model of a chip's circuits.

    Attributes
    ----------
    name : str
        Name on the command line, and with underscores that of its record.
    circuits : function
        Builds the circuits that the record is measured from.
    measure : function
        Makes the record without its errors in a process, and reports the share that is done to the function
        that it is given. It raises `ParameterError` for a law that the model does not carry.
    held_out : function
        Errors of the model on dies of a process that were not used to build it, by name with the unit at its
        end. They are taken while this record is in force, biased as given, or as the circuits are.
    load : function
        Makes the model on a silicon with its circuits' own biases. It raises `ParameterError` outside its box
        and `DataError` where the record is of other circuits.
    figures : function
        What else follows from the record, by name with the unit at its end.
    cells, proxy : Cells, Proxy or None
        How the model is written for other simulators, and what a search may ask of it, where it has them.
    """

    name: str
    circuits: Callable[[], Sequence[Circuit]]
    measure: Callable[[Progress, Process], Record]
    held_out: Callable[[Record, Biases | None, Process], Mapping[str, float]]
    load: Callable[[Silicon], object]
    figures: Callable[[Record], Mapping[str, float]] = nothing
    cells: Cells | None = None
    proxy: Proxy | None = None

    @property
    def record_name(self) -> str:
        """Name of the model's record in its own process under the ideal law."""
        return self.name.replace("-", "_")


def plain_model(
    name: str,
    circuits: Callable[[], Sequence[Circuit]],
    measure: Callable[[Process], Record],
    errors: Callable[[Process], Mapping[str, float]],
    load: Callable[[Silicon], object],
) -> Model:
    """Return a model whose measurement reports no progress, judged at its circuits' own biases alone.

    measure, errors: of a process, give the record, and the errors of the model by the record that is in
    force; the other arguments are the fields of `Model`.
    """
    return Model(name, circuits, lambda _, process: measure(process), lambda *given: errors(given[-1]), load)


_models: Catalogue[Model] = Catalogue("model", MODELS, "noctule.models", ("chips.model:Model",))

model_names, load_model = _models.names, _models.load


def characterise(
    model: Model, progress: Progress, biases: Biases | None = None, process: Process = AMI_1500_IDEAL
) -> Record:
    """Measure a model's record with its errors and its law, and return it without writing any file.

    Raises `SolverError` where the circuits cannot be measured, and `ParameterError` for a process whose law
    the model does not carry.

    Parameters
    ----------
    model
        The model.
    progress
        Function that is told the share that is done, 0 to 1.
    biases
        Biases of the circuits on the dies of the errors, A or V by name; their own unless given.
    process
        The process, with the law that the record is measured by.
    """
    record = model.measure(lambda share: progress(0.95 * share), process)
    with recorded(model.record_name, record, process):
        errors = model.held_out(record, biases, process)
    progress(1.0)
    return replace(record, errors=errors, law=law_of(process))
