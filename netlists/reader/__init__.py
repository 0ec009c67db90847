"""Reading netlists: text -> circuit and testbench; no code of a netlist is ever run."""

from netlists.reader.limits import Limits
from netlists.reader.netlist import Imported, read_netlist
from netlists.reader.note import Note

__all__ = ["Imported", "Limits", "Note", "read_netlist"]
