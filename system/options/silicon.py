"""Which silicon a user asked for, as the command line's texts; nothing here waits for numerical libraries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

from system.option import option

USUAL_CELSIUS = "27"


@dataclass(frozen=True, slots=True)
class SiliconChoice:
    """What silicon a command is about.

    temperature : a text, degC; None is that which a netlist states, else the usual one.
    lot, die : key of the die; None is the nominal die. A text is a number, or a file (`die_file`).
    study : that die under the plan of a study, where it is a study's.
    corner : of the process.
    mismatch, process_variation : whether a die has local and shared deviations.
    variation : components of variation that it has beside.
    process : its name or a file; None is the block's own.
    law : without second-order effects, or with all that the process states.
    at : place of a block on a chip, as `ranging-chip/neuron[2]`.
    heal, only, deviate : what is changed of the die by hand (`circuits.silicon.edit`).
    allow_implausible : whether sizes pass that no silicon has.
    """

    temperature: str | None = option(
        None, "Degrees Celsius, -40 to 125; 27, or a netlist's own, unless given", metavar="DEGC"
    )
    lot: str = option("A", "Lot of dies")
    die: Any = option(
        None, "Die of the lot, or a file that states one; the nominal die unless given", metavar="NUMBER|FILE"
    )
    study: Any = option(None, "Take `die` from the plan of a study", metavar="FOLDER")
    corner: Literal["random", "typical", "ss", "ff", "sf", "fs"] = option(
        "random", "Process corner; n first, then p"
    )
    mismatch: bool = option(default=True, about="Deviations of each device on the die")
    process_variation: bool = option(default=True, about="Deviations that a die's devices share")
    variation: Literal["plain", "transistors", "full"] = option(
        "plain", "Lot, wafer, gradients and n with p beside; full: capacitors and resistors too"
    )
    process: str | None = option(
        None, "ami-1500, rolls-180, gf180mcu, sky130, coach-180 or a .toml", metavar="NAME|FILE"
    )
    law: Literal["ideal", "full"] = option(
        "full", "Without second-order effects, or with all that the process states"
    )
    at: str | None = option(None, "Place on a chip, as ranging-chip/neuron[2]", metavar="CHIP/INSTANCE")
    heal: tuple[str, ...] = option(
        (), "Devices that do not deviate, as 'rolls/row[12].*', repeatable", metavar="PATH"
    )
    only: tuple[str, ...] = option((), "Devices that alone deviate, repeatable", metavar="PATH")
    deviate: tuple[str, ...] = option(
        (), "Deviation of a device, as PATH.v_t0=12mV, repeatable", metavar="PATH=VALUE"
    )
    allow_implausible: bool = option(
        default=False, about="Take sizes and currents that are far from any silicon's"
    )

    @property
    def celsius(self) -> str:
        """The temperature as a text, degC: the one that is asked for, or the usual one."""
        return USUAL_CELSIUS if self.temperature is None else self.temperature
