"""Reading netlists: text -> circuit and testbench; no code of a netlist is ever run."""

from netlists.read.limits import Limits
from netlists.read.netlist import Imported, read_netlist
from netlists.read.note import Foreign, Note

__all__ = ["Foreign", "Imported", "Limits", "Note", "read_netlist"]
