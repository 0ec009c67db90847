"""What PyNN has and ROLLS lacks, told in a line where it is asked for."""

from __future__ import annotations

from typing import Any

from pyNN import connectors
from pyNN.standardmodels import StandardCellType, StandardCurrentSource, StandardSynapseType, cells, synapses
from pyNN.standardmodels import electrodes as currents

from circuits.errors import UnknownNameError

_KINDS = {
    StandardCellType: "neurons of ROLLS share the biases of their chip; take RollsNeuron",
    StandardSynapseType: "synapses of ROLLS have one of eight levels; take StaticSynapse",
    StandardCurrentSource: "ROLLS has no current that a program drives; take a SpikeSource",
    connectors.CSAConnector: "it names cells by their ids; take an ArrayConnector of its mask",
    connectors.Connector: "PyNN has no code for it; take an ArrayConnector of its pairs",
}


class LackingError(UnknownNameError, AttributeError):
    """The chip does not have what was asked for."""


def why_lacking(kind: type) -> str | None:
    """Return why the chip lacks a class of PyNN's, None where nothing is known."""
    return next((text for base, text in _KINDS.items() if issubclass(kind, base)), None)


def __getattr__(name: str) -> Any:
    """Refuse a name of PyNN's that the chip lacks; raises `LackingError`."""
    found = next(
        (getattr(m, name) for m in (cells, synapses, currents, connectors) if hasattr(m, name)), None
    )
    why = why_lacking(found) if isinstance(found, type) else None
    raise LackingError(f"pynn.{name}: {why or 'not there on ROLLS; see dir(chips.rolls.pynn)'}")
