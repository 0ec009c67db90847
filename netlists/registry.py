"""Dialects by name, loaded on use, and what each of them offers.

Users add theirs under the entry point `noctule.dialects`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from circuits.catalogue import Catalogue
from circuits.devices.device import Device
from circuits.errors import ParameterError
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

Method = Literal["gear", "trap"]
Analysis = Literal["tran", "op"]

DEFAULT_RELTOL = 1e-5
POINTS = 2000  # steps at least in a run, unless tmax is given
NO_DEVIATION = Deviation(0.0, 0.0)


class DeviceFormatter(Protocol):
    """A generic function of a device's type; what is registered for `object` is the refusal."""

    def __call__(self, device: Device, silicon: Silicon, deviation: Deviation = NO_DEVIATION, /) -> list[str]:
        """Lines of one device, deviating by what its place on the die adds to it."""

    def dispatch(self, cls: Any, /) -> Callable[..., list[str]]:
        """What is registered for a type."""


@dataclass(frozen=True, slots=True)
class Settings:
    """Choices of a caller.

    `models` of transistors: `ekv` our equations, `bsim3` M elements and cards. `analysis`: up to the stop
    time, or the operating point with the sources as they are at time 0. `reltol`, `method`: the simulator's
    options; `tmax`: largest step, s, by default a 2000th of the stop time; `nodes`: paths of the nodes to
    save, all by default. `parasitics`: capacitances to ground (F) by node path.
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
    """A simulator's text.

    `runs`: whether it is run here, or written to its manual alone. `comment` begins a comment. `devices` has
    the formatter of devices by the models of transistors. `drawing`: what it says is the same at every
    temperature and on every die. `syntax`: how a netlist is read back by its notes, as one of the SPICE
    family unless given.
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
        """Formatter of devices with these models; raises `ParameterError` where the dialect lacks them."""
        if models not in self.devices:
            known = ", ".join(self.devices)
            raise ParameterError(f"models: {models}, {self.name} has {known}; choose one of these")
        return self.devices[models]


_dialects: Catalogue[Dialect] = Catalogue(
    "dialect", DIALECTS, "noctule.dialects", ("netlists.registry:Dialect",)
)

dialect_names, load_dialect = _dialects.names, _dialects.load
