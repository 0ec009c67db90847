"""The chips that networks go on, each with what puts them there, and why the others do not take any."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from circuits.errors import ParameterError, unknown_name
from system.files.writing import checked_suffix
from system.mapping import network_file as toml
from system.mapping.dynamics import Usual
from system.mapping.network import Network
from system.mapping.nir import read as nir
from system.mapping.rolls.map import map_on_rolls
from system.mapping.rolls.mapped import Mapped

CHIPS: Mapping[str, Callable[[Network, Usual | None], Mapped]] = {"rolls": map_on_rolls}
READERS: Mapping[str, Callable[[str], Network]] = {toml.SUFFIX: toml.read_network, nir.SUFFIX: nir.read_nir}
REFUSED = {
    **dict.fromkeys(("latency", "latency-chip"), "is one fixed network"),
    **dict.fromkeys(("nef", "nef-chip"), "takes ensembles that stand for values; write it for Nengo"),
}


def read_any(path: str) -> Network:
    """Return the network of a file by the end of its name: `.toml`, or `.nir`; raises as their readers do."""
    return READERS[checked_suffix(path, tuple(READERS))](path)


def map_on(chip: str, network: Network, usual: Usual | None = None) -> Mapped:
    """Put a network on a chip.

    Parameters
    ----------
    chip
        Name of the chip, `rolls`.
    network
        The network.
    usual
        Rates at whose currents synapses are to be as asked for, those of its neurons and of its channels (Hz,
        float64[n] each); at twice the current that just fires a neuron unless given.

    Raises
    ------
    ParameterError
        The chip takes no such networks, or something of it cannot be on the chip.
    UnknownNameError
        There is no such chip.
    """
    if chip in REFUSED:
        raise ParameterError(f"chip: {chip}, {REFUSED[chip]}; populations go on {', '.join(CHIPS)}")
    if chip not in CHIPS:
        raise unknown_name("chip of networks", chip, CHIPS)
    return CHIPS[chip](network, usual)
