"""Every name of the package `netlists` that users call, in one place.

Netlists are written in a dialect, read back, and compared; a circuit is put on a foundry's process. Runs in
ngspice are in `netlists.api.ngspice`, and PySpice, which is slow to import, in `netlists.api.pyspice`.
"""

from netlists.compare.circuits import Comparison, Difference, compare
from netlists.dialects.spice import Syntax, analysis_card, spice_dialect
from netlists.foundry.deck import map_circuit
from netlists.foundry.process import DeviceMapping, read_mapping
from netlists.naming import make_naming
from netlists.parasitics import read_parasitics
from netlists.read.analysis import OperatingPoint, Sweep, Transient
from netlists.read.limits import Limits
from netlists.read.netlist import Imported, read_netlist
from netlists.read.note import Note
from netlists.read.summary import Summary, summarise
from netlists.registry import Dialect, Settings, dialect_names, load_dialect
from netlists.write.deck import Control

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # Dialects and writing
    "dialect_names",
    "load_dialect",
    "Dialect",
    "Settings",
    "read_parasitics",
    # Dialects of one's own
    "make_naming",
    "Syntax",
    "spice_dialect",
    "analysis_card",
    "Control",
    # Reading
    "read_netlist",
    "Imported",
    "Limits",
    "Note",
    "Transient",
    "OperatingPoint",
    "Sweep",
    "summarise",
    "Summary",
    # Comparing
    "compare",
    "Comparison",
    "Difference",
    # A foundry's process
    "read_mapping",
    "DeviceMapping",
    "map_circuit",
]
