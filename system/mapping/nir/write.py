"""A network of populations as a graph of NIR, which `system.mapping.nir.read` reads back.

A connection is `Linear` and `LI` before its target's `LIF`, with R = tau of the LI so that weights stand in
the file as they are. `LOST` says what NIR has no word for; it is in the graph's metadata.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from chips.rolls.program.nir import nir_package
from circuits.errors import ParameterError
from system.files.writing import checked_suffix, temporary_folder, write_bytes_atomic
from system.mapping.network import Network, matrix_of
from system.mapping.nir.read import ORDER, SUFFIX

LOST = (
    "refractory periods: a graph has none",
    "rules of connections: each is the matrix that it makes",
)


def write_nir_network(path: str | Path, network: Network) -> None:
    """Write `network` to the file of NIR at `path`, which ends with `.nir`.

    Raises `ParameterError` where it ends otherwise, or where a population has a constant leak or an input
    sends by itself, which no node of NIR does, and `DataError` without the package nir, or where the file
    cannot be written.
    """
    checked_suffix(path, (SUFFIX,))
    nir, graph = nir_package(), graph_of_network(network)
    with temporary_folder() as folder:  # HDF5 locks the file that it writes
        made = folder / f"network{SUFFIX}"
        nir.write(made, graph)
        write_bytes_atomic(path, made.read_bytes())


def graph_of_network(network: Network) -> Any:
    """Return the `nir.NIRGraph` of `network`; raises as `write_nir_network`, which writes it."""
    nir = nir_package()
    nodes: dict[str, Any] = {}
    edges: list[tuple[str, str]] = []
    for each in network.inputs:
        if each.rate:
            text = f"{each.name}.rate: {each.rate:g} Hz, must be 0 in a graph of NIR, which has no clock"
            raise ParameterError(f"{text}; keep the network as TOML")
        nodes[each.name] = nir.Input(input_type={"input": np.array([each.size])})
    for p in network.populations:
        if p.leak != "membrane":
            raise ParameterError(f"{p.name}.leak: {p.leak}, must be membrane in a graph of NIR; change it")
        ones = np.ones(p.size)
        nodes[p.name] = nir.LIF(
            tau=p.tau * ones, r=ones, v_leak=0.0 * ones, v_threshold=ones, v_reset=0.0 * ones
        )
    sizes = {p.name: p.size for p in network.populations}
    for k, one in enumerate(network.connections):
        name, tau = f"connection{k}", one.tau * np.ones(sizes[one.target])
        nodes[name] = nir.Linear(weight=matrix_of(network, one))
        nodes[f"{name}_synapse"] = nir.LI(tau=tau, r=tau, v_leak=0.0 * tau)
        edges += [(one.source, name), (name, f"{name}_synapse"), (f"{name}_synapse", one.target)]
    for probe in network.probes:
        tau = probe.tau * np.ones(sizes[probe.population])
        nodes[f"{probe.name}_filter"] = nir.LI(tau=tau, r=tau, v_leak=0.0 * tau)
        nodes[probe.name] = nir.Output(output_type={"output": np.array([sizes[probe.population]])})
        edges += [(probe.population, f"{probe.name}_filter"), (f"{probe.name}_filter", probe.name)]
    groups = [p.name for p in network.populations] + [each.name for each in network.inputs]
    order = "\n".join(groups)
    metadata = {"source": "noctule", "lost": "\n".join(LOST), ORDER: order}
    return nir.NIRGraph(nodes, edges, metadata=metadata)
