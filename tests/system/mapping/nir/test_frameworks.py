"""Graphs that NIR's own tests, Norse, snnTorch and sinabs make: all are read, each node as the table says."""

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from chips.aer import Events
from circuits.errors import DataError, ParameterError
from system.mapping.dynamics import asked, run
from system.mapping.network import Network, matrix_of
from system.mapping.nir.nodes import NODES
from system.mapping.nir.read import Times, judged, read_graph, read_nir

GRAPHS = Path(__file__).parent / "graphs"
TABLE = {node.type: node.rolls for node in NODES}
NETWORKS = {
    "nir": {"type_check_recurrent"},
    "norse": {"lif", "iaf", "braille"},
    "snntorch": {
        "leaky",
        "synaptic",
        "one-to-one-leaky",
        "convolution",
        "recurrent-leaky",
        "recurrent-synaptic",
        "with-bias",
    },
    "sinabs": {"iaf", "lif"},
}  # that have neurons, and nothing that a network has not
MISFIT = {
    "read_without_type_check": "linear_1: takes 1 entries",
    "simple-2": "a: is in a loop without a neuron",
    "lif-box": "3: weights from 1 to the output output",
}  # that are no network, though each node is one's
CONDITIONS = ("v_leak", "split the node", "v_threshold")  # under which a node is refused
STEP = Times(1.0, 1e-4)  # of snnTorch: a spike is a 1 for a step of 0.1 ms


def files(library: str, folder: Path) -> dict[str, Path]:
    """Files of a library by name, in a folder."""
    with zipfile.ZipFile(GRAPHS / f"{library}.zip") as archive:
        archive.extractall(folder)
        return {Path(name).stem: folder / name for name in archive.namelist() if name.endswith(".nir")}


@pytest.mark.parametrize(("library", "count"), [("nir", 51), ("norse", 4), ("snntorch", 7), ("sinabs", 3)])
def test_all_are_read_and_each_node_is_as_the_table_says(library: str, count: int, tmp_path: Path) -> None:
    found = files(library, tmp_path)
    assert len(found) == count
    networks = set()
    for name, path in found.items():
        nodes = judged(read_graph(path))
        refused = [each for each in nodes if each.how == "refused"]
        for each in nodes:
            if each in refused:
                own = any(word in each.note for word in CONDITIONS)
                assert own or TABLE[each.type] == "refused", each
                assert each.note.startswith(each.where)
            else:
                biased = each.how == "approximate" and "a bias" in each.note
                assert each.how == TABLE[each.type] or biased, each
        if not refused and name not in MISFIT and {"LIF", "CubaLIF", "IF"} & {each.type for each in nodes}:
            networks.add(name)
            assert read_nir(path).neurons
            continue
        with pytest.raises(DataError) as error:
            read_nir(path)
        told = refused[0].where if refused else MISFIT.get(name, "graph: no neuron")
        assert str(error.value).startswith(f"{path}: {told}")
    assert networks == NETWORKS[library]


def spikes_of(network: Network, given: Any, step: float) -> Any:
    """Spikes of each neuron where events come as in the rows of `given`."""
    when, channel = np.nonzero(given)
    trains = run(asked(network), Events(when * step, channel), len(given) * step)
    return np.bincount(trains.neurons, minlength=network.neurons)


def test_networks_spike_as_often_as_in_the_framework_that_exported_them(tmp_path: Path) -> None:
    found = files("snntorch", tmp_path)
    for name in ("leaky", "synaptic"):  # approximate, by a synapse of 2 ms, and faithful
        told = np.load(tmp_path / f"{name}.npz")
        counts = spikes_of(read_nir(found[name], STEP), told["given"], float(told["step"]))
        assert told["counts"].min() > 15
        # one spike: snnTorch places them by its step, and in half a second that moves the last one
        assert counts == pytest.approx(told["counts"], abs=1.0)


def test_time_constants_in_steps_and_pulses_of_a_step(tmp_path: Path) -> None:
    found = files("sinabs", tmp_path)
    network = read_nir(found["lif"], Times(1e-3))
    assert network.populations[0].tau == pytest.approx(20e-3)
    (one,) = network.connections
    assert one.tau == pytest.approx(2e-3)
    weight = np.asarray(read_graph(found["lif"]).nodes["0"].weight)
    # an event lifts v by w / 20 of the threshold, and a weight of the network by w 2 ms / 20 ms
    assert matrix_of(network, one) * 2e-3 / 20e-3 == pytest.approx(weight / 20.0)
    with pytest.raises(ParameterError, match=r"graph.event: 0 s, must be above 0"):
        Times(1.0, 0.0)
