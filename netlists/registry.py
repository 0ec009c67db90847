"""The dialects by name, and what each of them offers; a dialect is loaded when it is first used.

A package outside this repository adds dialects under the entry point `noctule.dialects`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal, Protocol

from circuits.catalogue import Catalogue
from circuits.errors import ParameterError

if TYPE_CHECKING:  # names can be listed without numerical libraries
    from circuits.devices.device import Device
    from circuits.silicon.silicon import Deviation, Silicon
    from circuits.testbench import Testbench
    from netlists.naming import Naming

DIALECTS: dict[str, str] = {
    "ngspice": "netlists.dialects.ngspice:DIALECT",
    "xyce": "netlists.dialects.xyce:DIALECT",
    "hspice": "netlists.dialects.hspice:DIALECT",
    "spectre": "netlists.dialects.spectre:DIALECT",
    "cdl": "netlists.dialects.cdl:DIALECT",
    "verilog-a": "netlists.verilog_a.text:DIALECT",
}

# What each is, as its own summary says: `noctule list` and a shell's completion load none of them.
DIALECT_LINES: dict[str, str] = {
    "ngspice": "B sources or BSIM3; run here",
    "xyce": "B sources, or BSIM3; not run here",
    "hspice": "G elements with cur='...', or BSIM3; not run here",
    "spectre": "bsource elements, or BSIM3; not run here",
    "cdl": "for LVS: M, C, R and D as drawn; not run here",
    "verilog-a": "the laws as modules, circuits structural; not run here",
}

SUFFIXES = (".cir", ".ckt", ".sp", ".spi", ".spice", ".net", ".scs", ".cdl")  # of files that are netlists

Method = Literal["gear", "trap"]
Analysis = Literal["tran", "op"]

DEFAULT_RELTOL = 1e-5
POINTS = 2000  # steps at least in a run, unless tmax is given


class DeviceFormatter(Protocol):
    """A generic function of a device's type; what is registered for `object` is the refusal."""

    def __call__(self, device: Device, silicon: Silicon, deviation: Deviation = ..., /) -> list[str]:
        """Lines of one device, deviating by what its place on the die adds to it."""

    def dispatch(self, cls: Any, /) -> Callable[..., list[str]]:
        """What is registered for a type."""


@dataclass(frozen=True, slots=True)
class Settings:
    """What a caller chooses about a netlist.

    Attributes
    ----------
    models
        What transistors are: `ekv` writes our equations as behavioural currents, `bsim3` M elements that
        name BSIM3 cards, `sweepable` our equations in sub-circuits of temperature and size (ngspice alone).
    analysis
        `tran` is a transient up to the testbench's stop time; `op` is the operating point with the sources
        as they are at time 0.
    reltol, method
        The simulator's relative tolerance and its integration method.
    tmax
        Largest time step, s; a 2000th of the stop time unless given.
    nodes
        Paths of the nodes to save; all nodes unless given.
    parasitics
        Capacitances to ground, F, by the path of their node.
    """

    models: str = "ekv"
    analysis: Analysis = "tran"
    reltol: float = DEFAULT_RELTOL
    tmax: float | None = None
    method: Method = "gear"
    nodes: Iterable[str] | None = None
    parasitics: Mapping[str, float] = field(default_factory=dict)


class Writing(Protocol):
    """Writes a complete netlist, the same text for the same input; the first line begins with the title."""

    def __call__(
        self, testbench: Testbench, silicon: Silicon, settings: Settings, title: str | None = None, /
    ) -> str:
        """Text of a testbench on a silicon."""


@dataclass(frozen=True, slots=True)
class Dialect:
    """The text of a simulator.

    Attributes
    ----------
    name, summary
        Its name on the command line, and what the list of dialects says about it.
    runs
        Whether netlists are run here in that simulator; the others are written to its manual alone.
    comment
        What begins a comment.
    naming
        How names of nodes and devices are written.
    devices
        Formatter of devices by what transistors are (`ekv`, `bsim3`).
    write
        Writes a complete netlist.
    drawing
        Whether the text is what a layout draws, the same at every temperature and on every die.
    syntax
        Makes the `Syntax` of `netlists.read.notes.syntax` by which a netlist is read back by its notes; None
        reads it as one of the SPICE family.
    """

    name: str
    summary: str
    runs: bool
    comment: str
    naming: Naming
    devices: Mapping[str, DeviceFormatter]
    write: Writing
    drawing: bool = False
    syntax: Callable[[Dialect], Any] | None = None  # a Syntax of netlists.read.notes.syntax

    def formatter(self, models: str) -> DeviceFormatter:
        """Give the formatter of devices with the transistor models `models`.

        Raises
        ------
        ParameterError
            The dialect lacks these models.
        """
        if models not in self.devices:
            known = ", ".join(self.devices)
            raise ParameterError(f"models: {models}, {self.name} has {known}; choose one of these")
        return self.devices[models]


_dialects: Catalogue[Dialect] = Catalogue(
    "dialect", DIALECTS, "noctule.dialects", ("netlists.registry:Dialect",), DIALECT_LINES
)

dialect_names, load_dialect, dialect_line = _dialects.names, _dialects.load, _dialects.line
