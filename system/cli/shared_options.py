"""Options that several verbs share; nothing here is slow to import."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Literal

from circuits.catalogue import loaded
from circuits.errors import ParameterError
from netlists.ngspice.deadline import DEADLINE
from system.cli.verb import argument, part
from system.option import option
from system.options.begin import BeginChoice, begin_choice
from system.options.silicon import SiliconChoice

_SpokenKind = Literal["gate", "ideal", "generator"]  # kinds of bias that a user can ask for
Engine = Literal["native", "ngspice"]
Device = Literal["cpu", "gpu"]
Level = Literal["transistor", "behavioural"]


@dataclass(frozen=True, slots=True, kw_only=True)
class OnBlock:
    """What every verb on a block is asked for first."""

    block: str = argument(
        "BLOCK", "A block or chip: see noctule list; or FILE.py:NAME, or a netlist",
        names="system.registry:block_and_chip_names",
    )  # fmt: skip


class ManyDies:
    """A verb on many dies, whose silicon is its `variation` but for what a field of its own says, `OWN`."""

    __slots__ = ()
    OWN: ClassVar[str]
    variation: SiliconChoice

    @property
    def silicon(self) -> SiliconChoice:
        """The silicon that all dies share."""
        return replace(self.variation, **{self.OWN: getattr(self, self.OWN)})


@dataclass(frozen=True, slots=True, kw_only=True)
class BlockValues:
    """Sizes and biases of a block, as texts of the command line."""

    param: tuple[str, ...] = option((), "Size, capacitor, or a system's option", metavar="NAME=VALUE")
    bias: tuple[str, ...] = option(
        (), "Bias, as i_lim=6.3uA or the code i_lim=1:200, repeatable", metavar="NAME=VALUE"
    )
    bias_set: str | None = option(None, "Named set of the block's biases; --bias goes on top", metavar="NAME")
    bias_file: str | None = option(None, "Of rolls: rolls_default, rolls_parallella or a CSV", metavar="FILE")
    coupling: Literal["none", "bus"] = option("none", "Capacitances between wires, by a rule of layout")
    testbench: str | None = option(
        None, "Of deck.cir:SUBCIRCUIT: a TOML file of what drives its ports", metavar="FILE"
    )
    bias_kind: _SpokenKind | None = option(None, "Fixed gates, ideal PTAT currents, or the bias generator")


@dataclass(frozen=True, slots=True, kw_only=True)
class _BeginOptions:
    """Where runs begin, as the command line has it."""

    ic: tuple[str, ...] = option(
        (), "Voltage that a node is held at until time 0, repeatable", metavar="NODE=V"
    )
    uic: bool = option(default=False, about="Begin with --ic and 0 V elsewhere, without an operating point")
    at_rest: bool = option(default=False, about="Stay in an operating point that is not stable")


def values_part(*without: str) -> Any:
    """Make the field for the sizes and biases of a block (`BlockValues`), but those `without`."""
    return part(BlockValues, *without)


def measure_option() -> Any:
    """Make the field for measures of a run of a block's testbench."""
    return option((), 'As "t_rise = cross(v_out, 0.9, rise)", repeatable', metavar="TEXT")


def stimulus_option() -> Any:
    """Make the field for the stimuli of a block's testbench."""
    return option((), "As delay=6.4ms or call=off, repeatable", metavar="NAME=VALUE")


def silicon_part(*without: str) -> Any:
    """Make the field for the silicon that a verb runs on (`SiliconChoice`), but the options `without`."""
    return part(SiliconChoice, *without, made=of_study)


def begin_part(*without: str) -> Any:
    """Make the field for the state in which runs begin (`BeginChoice`), but the options `without`."""
    return part(_BeginOptions, *without, made=_beginning)


def deadline_option() -> Any:
    """Make the field for the time that a run in ngspice may take."""
    about = f"Wall-clock time for a run in ngspice, as 90s; {DEADLINE:g}s unless given"
    return option(None, about, metavar="TIME")


def file_option(about: str, **stated: Any) -> Any:
    """Make the field for a file that is written where one is named; `about` is its help."""
    return option(None, about, metavar="FILE", **stated)


def spikes_option() -> Any:
    """Make the field for the file of spikes at the watched nodes."""
    return file_option("Write spikes at watched nodes: .csv, .npz, .aedat4, .nwb or .nix")


def plot_option() -> Any:
    """Make the field for the file of a picture."""
    return file_option("Draw into a .png, .svg or .pdf file")


def threads_option() -> Any:
    """Make the field for the number of threads that measure dies."""
    return option(None, "All cores unless given")


def workers_option() -> Any:
    """Make the field for the number of processes of a cluster on this machine."""
    return option(None, "Processes of a local Dask cluster")


def scheduler_option() -> Any:
    """Make the field for the address of a cluster."""
    return option(None, "Dask cluster, as tcp://host:8786", metavar="ADDRESS")


def json_option() -> Any:
    """Make the field that asks for JSON instead of text."""
    return option(default=False, about="Print one JSON document and nothing else", name="json")


def of_study(chosen: SiliconChoice) -> SiliconChoice:
    """With the die that a file states, or the one under the plan of a study's folder, where one was named."""
    if isinstance(chosen.die, str) and chosen.die.isdecimal():
        chosen = replace(chosen, die=int(chosen.die))
    elif isinstance(chosen.die, str):
        chosen = loaded("system.options.die.file:with_die")(chosen)  # which numerical libraries come with
    if chosen.study is None:
        return chosen
    if chosen.die is None:
        raise ParameterError("--study: which die, must come with --die")
    die_of = loaded("system.study.replay:die_of")  # which takes a second to import
    return replace(chosen, study=die_of(Path(chosen.study), chosen.die))


def _beginning(chosen: _BeginOptions) -> BeginChoice:
    return begin_choice(chosen.ic, uic=chosen.uic, at_rest=chosen.at_rest)
