"""What PyNN has and ROLLS lacks, told in a line where it is asked for."""

from __future__ import annotations

from typing import Any

from pyNN.standardmodels import StandardCellType, StandardCurrentSource, StandardSynapseType, cells, synapses
from pyNN.standardmodels import electrodes as currents

from circuits.errors import UnknownNameError

_KINDS = {
    StandardCellType: "neurons of ROLLS share the biases of their chip; take RollsNeuron",
    StandardSynapseType: "synapses of ROLLS have one of eight levels; take StaticSynapse",
    StandardCurrentSource: "ROLLS has no current that a program drives; take a SpikeSource",
}


class LackingError(UnknownNameError, AttributeError):
    """The chip does not have what was asked for."""


def __getattr__(name: str) -> Any:
    """Refuse a name of PyNN's that the chip lacks; raises `LackingError`."""
    found = next((getattr(m, name) for m in (cells, synapses, currents) if hasattr(m, name)), None)
    why = [text for kind, text in _KINDS.items() if isinstance(found, type) and issubclass(found, kind)]
    raise LackingError(f"pynn.{name}: {why[0] if why else 'not there on ROLLS; see dir(chips.rolls.pynn)'}")
