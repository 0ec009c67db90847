"""The chips that networks go on, each with what puts them there, and why the others do not take any."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Literal, NamedTuple, overload

from circuits.errors import DataError, ParameterError, TopologyError, unknown_name
from system.files.document import toml_file
from system.files.writing import checked_suffix
from system.mapping import network_file as toml
from system.mapping.dynamics import Usual
from system.mapping.nef.mapped import MappedValues, map_on_nef
from system.mapping.nef.network import ValueNetwork
from system.mapping.nef.program_file import read_value_program, write_value_program
from system.mapping.network import Network
from system.mapping.nir import read as nir
from system.mapping.program_file import read_program, write_program
from system.mapping.rolls.map import map_on_rolls
from system.mapping.rolls.mapped import Mapped
from system.table import read_table

AnyNetwork = Network | ValueNetwork
AnyMapped = Mapped | MappedValues


class Maker(NamedTuple):
    """What puts a network on a chip, and keeps it there.

    takes : kind of network; noun : what it consists of; place, write, read : put it there, write the program
    to a path, and make it of a TOML document and its path.
    """

    takes: type
    noun: str
    place: Callable[[Any, Usual | None], Any]
    write: Callable[[str | Path, Any], None]
    read: Callable[[dict[str, Any], Path], Any]


CHIPS: Mapping[str, Maker] = {
    "rolls": Maker(Network, "populations", map_on_rolls, write_program, read_program),
    "nef": Maker(ValueNetwork, "ensembles", map_on_nef, write_value_program, read_value_program),
}
READERS = (toml.SUFFIX, nir.SUFFIX)
ENSEMBLES = "ensemble"  # key by which a network is one of values
REFUSED = dict.fromkeys(("latency", "latency-chip"), "is one fixed network")


def _read_toml(path: str) -> AnyNetwork:
    """Network of a TOML file: of values where it has ensembles, of populations otherwise."""
    where = Path(path)
    tables = toml_file(where)
    try:
        return (
            read_table(ValueNetwork, tables) if ENSEMBLES in tables else toml.network_of(tables, where.parent)
        )
    except (ParameterError, LookupError, TopologyError) as error:
        raise DataError(f"{where}: {error}") from None


def read_any(path: str, times: nir.Times = nir.STANDARD) -> AnyNetwork:
    """Return the network of a file by the end of its name: `.toml`, or `.nir`; raises as their readers do.

    times: what the numbers of a graph mean, which raises `ParameterError` for another file.
    """
    if checked_suffix(path, READERS) == nir.SUFFIX:
        return nir.read_nir(path, times)
    if times != nir.STANDARD:
        raise ParameterError(f"{path}: unit and event are of a graph, {nir.SUFFIX}; leave them out")
    return _read_toml(path)


def read_any_program(path: str) -> AnyMapped:
    """Return the program of a file, on whichever chip it is; raises `DataError` where it is none."""
    tables = toml_file(Path(path))
    found: AnyMapped = CHIPS[_chip_in(tables, path)].read(tables, Path(path))
    return found


def chip_of_program(path: str) -> str:
    """Return the name of the chip that the program of a file is for; raises as `read_any_program`."""
    return _chip_in(toml_file(Path(path)), path)


def _chip_in(tables: Mapping[str, Any], path: str) -> str:
    chip = str(tables.get("chip", "none"))
    if chip not in CHIPS:
        raise DataError(f"{path}: chip {chip}, must be {', '.join(CHIPS)}; noctule map writes such a file")
    return chip


def chip_of(network: AnyNetwork) -> str:
    """Return the name of the chip that takes networks of this kind."""
    return next(name for name, each in CHIPS.items() if isinstance(network, each.takes))


def write_any_program(path: str, chip: str, mapped: AnyMapped) -> None:
    """Write a program on a chip to `path`; raises as `write_program`."""
    CHIPS[chip].write(path, mapped)


@overload
def map_on(chip: Literal["rolls"], network: Network, usual: Usual | None = None) -> Mapped: ...
@overload
def map_on(chip: str, network: AnyNetwork, usual: Usual | None = None) -> AnyMapped: ...
def map_on(chip: str, network: AnyNetwork, usual: Usual | None = None) -> AnyMapped:
    """Put a network on a chip.

    Parameters
    ----------
    chip
        Name of the chip: `rolls`, which takes populations of neurons, or `nef`, which takes ensembles.
    network
        The network.
    usual
        Rates at whose currents synapses are to be as asked for, those of its neurons and of its channels (Hz,
        float64[n] each); at twice the current that just fires a neuron unless given. For `rolls` alone.

    Raises
    ------
    ParameterError
        The chip takes no such networks, or something of it cannot be on the chip.
    UnknownNameError
        There is no such chip.
    """
    if chip in REFUSED:
        raise ParameterError(f"chip: {chip}, {REFUSED[chip]}; networks go on {', '.join(CHIPS)}")
    if chip not in CHIPS:
        raise unknown_name("chip of networks", chip, CHIPS)
    maker = CHIPS[chip]
    if not isinstance(network, maker.takes):
        other = chip_of(network)
        raise ParameterError(
            f"chip: {chip}, takes networks of {maker.noun}, this one is of {CHIPS[other].noun}; map it on"
            f" {other}, or write it anew"
        )
    found: AnyMapped = maker.place(network, usual)
    return found
