"""Dialects by name, loaded on use, and what each of them offers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any, Literal, Protocol

from circuits.devices.device import Device
from circuits.errors import ParameterError, unknown_name
from circuits.silicon.silicon import Deviation, Silicon
from circuits.testbench import Testbench
from netlists.naming import Naming

DIALECTS: dict[str, str] = {
    "ngspice": "netlists.dialects.ngspice:DIALECT",
    "xyce": "netlists.dialects.xyce:DIALECT",
    "hspice": "netlists.dialects.hspice:DIALECT",
    "spectre": "netlists.dialects.spectre:DIALECT",
    "cdl": "netlists.dialects.cdl:DIALECT",
}
# Written as modules, and not read back
MODULE_LANGUAGES: dict[str, str] = {
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
    the formatter of devices by the models of transistors.
    """

    name: str
    summary: str
    runs: bool
    comment: str
    naming: Naming
    devices: Mapping[str, DeviceFormatter]
    write: Writing

    def formatter(self, models: str) -> DeviceFormatter:
        """Formatter of devices with these models; raises `ParameterError` where the dialect lacks them."""
        if models not in self.devices:
            known = ", ".join(self.devices)
            raise ParameterError(f"models: {models}, {self.name} has {known}; choose one of these")
        return self.devices[models]


def dialect_names() -> list[str]:
    """Names of all dialects, ngspice first."""
    return [*DIALECTS, *MODULE_LANGUAGES]


def load_dialect(name: str) -> Dialect:
    """Load a dialect by name; raises `UnknownNameError` for a name that is none."""
    if name not in dialect_names():
        raise unknown_name("dialect", name, dialect_names())
    module, attribute = (DIALECTS | MODULE_LANGUAGES)[name].split(":")
    dialect: Dialect = getattr(import_module(module), attribute)
    return dialect
