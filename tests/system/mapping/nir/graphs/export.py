"""Makes the graphs of this folder: of NIR's own tests, and what Norse, snnTorch and sinabs export.

It needs torch and these libraries, which the project does not; so it is run by hand, in an environment of its
own, with the source of NIR (which has its tests) and of Norse unpacked beside it:

    pip install torch nir nirtorch norse snntorch sinabs matplotlib pytest
    pip download --no-deps --no-binary nir,norse nir norse
    python export.py NIR_SOURCE NORSE_SOURCE

Of NIR's tests each distinct graph is kept that a test makes, by its nodes; weights are those that the tests
draw, with a fixed seed. The licences of what the files are of stand beside them.
"""

import io
import shutil
import sys
import tempfile
import zipfile
from pathlib import Path

import nir
import numpy as np
import pytest
import sinabs.layers as sl
import snntorch as snn
import torch
from norse.torch import (
    IAFCell,
    IAFParameters,
    LIBoxCell,
    LIFBoxCell,
    LIFBoxParameters,
    LIFCell,
    LIFParameters,
    SequentialState,
)
from norse.torch.module.leaky_integrator_box import LIBoxParameters
from norse.torch.utils.export_nir import to_nir as norse_to_nir
from sinabs.nir import to_nir as sinabs_to_nir
from snntorch.export_nir import export_to_nir

HERE = Path(__file__).parent
STEP, STEPS, RATE = 1e-4, 5000, 400.0  # s of snnTorch's exporter; steps of a run; Hz of its inputs
WEIGHTS = {"leaky": (0.05, 0.11), "synaptic": (0.001, 0.0023)}  # between which neurons fire at some 100 Hz


class Recorder:
    """Keeps the graphs that a test makes, by its name."""

    def __init__(self):
        self.test, self.graphs = "", {}

    def pytest_runtest_setup(self, item):
        """Remember which test runs."""
        np.random.seed(0)  # noqa: NPY002 - what NIR's tests draw from
        self.test = item.name.removeprefix("test_")

    def keep(self, graph):
        """Keep a graph once for each test and kind of nodes."""
        kinds = tuple(sorted(type(node).__name__ for node in graph.nodes.values()))
        self.graphs.setdefault((self.test, kinds), graph)


def of_nir(source):
    """Graphs of NIR's own tests."""
    recorder, plain = Recorder(), nir.NIRGraph.__init__

    def made(graph, *args, **named):
        plain(graph, *args, **named)
        recorder.keep(graph)

    nir.NIRGraph.__init__ = made
    try:
        pytest.main(["-q", str(source / "tests"), "-p", "no:cacheprovider"], plugins=[recorder])
    finally:
        nir.NIRGraph.__init__ = plain
    counts = {}
    for (test, _), graph in recorder.graphs.items():
        counts[test] = counts.get(test, 0) + 1
        name = test if counts[test] == 1 else f"{test}-{counts[test]}"
        yield name, graph


def of_norse():
    """What Norse exports: its cells, with and without a bias; NIR cannot write its convolutions.

    With `dt=1` its time constants are in seconds.
    """
    ends = {"v_th": torch.ones(4), "v_leak": torch.zeros(4)}
    p = LIFParameters(tau_mem_inv=torch.full((4,), 50.0), tau_syn_inv=torch.full((4,), 200.0), **ends)
    box = LIFBoxParameters(tau_mem_inv=torch.full((4,), 50.0), **ends)
    iaf = IAFParameters(v_th=torch.ones(4))
    out = LIBoxParameters(tau_mem_inv=torch.full((2,), 20.0), v_leak=torch.zeros(2))
    linear = torch.nn.Linear
    yield (
        "lif",
        norse_to_nir(SequentialState(linear(3, 4, bias=False), LIFCell(p)), torch.randn(1, 3), dt=1.0),
    )
    yield (
        "lif-box",
        norse_to_nir(
            SequentialState(linear(3, 4), LIFBoxCell(box), linear(4, 2, bias=False), LIBoxCell(out)),
            torch.randn(1, 3),
            dt=1.0,
        ),
    )
    yield "iaf", norse_to_nir(SequentialState(linear(3, 4, bias=False), IAFCell(iaf)), torch.randn(1, 3))


def of_snntorch():
    """What snnTorch exports: each of its neurons that it can, recurrent ones as graphs in a graph."""
    linear, fall, size = torch.nn.Linear, torch.full((4,), 0.995), torch.randn(1, 3)
    spiking = {"init_hidden": True, "threshold": torch.ones(4), "reset_mechanism": "zero"}
    for name, layer in (
        ("leaky", snn.Leaky(beta=fall, **spiking)),
        ("synaptic", snn.Synaptic(alpha=torch.full((4,), 0.98), beta=fall, **spiking)),
        ("recurrent-leaky", snn.RLeaky(beta=fall, linear_features=4, **spiking)),
        ("one-to-one-leaky", snn.RLeaky(beta=fall, V=torch.ones(4), all_to_all=False, **spiking)),
        (
            "recurrent-synaptic",
            snn.RSynaptic(alpha=torch.full((4,), 0.98), beta=fall, linear_features=4, **spiking),
        ),
    ):
        net = torch.nn.Sequential(linear(3, 4, bias=False), layer)
        if name in WEIGHTS:
            net[0].weight.data.uniform_(*WEIGHTS[name])
        yield name, export_to_nir(net, size, ignore_dims=[0])
    biased = torch.nn.Sequential(linear(3, 4), snn.Leaky(beta=fall, **spiking))
    yield "with-bias", export_to_nir(biased, size, ignore_dims=[0])
    pooled = torch.nn.Sequential(
        torch.nn.Conv2d(1, 2, 3, bias=False),
        torch.nn.AvgPool2d(2),
        torch.nn.Flatten(),
        linear(8, 4, bias=False),
        snn.Leaky(beta=fall, **spiking),
    )
    yield "convolution", export_to_nir(pooled, torch.randn(1, 1, 6, 6), ignore_dims=[0])


def run_of_snntorch(graph):
    """Inputs of 0.5 s, a row each step, and how many spikes snnTorch itself makes of a graph's network."""
    weight = torch.tensor(np.asarray(graph.nodes["0"].weight))
    neurons = graph.nodes["1"]
    given = (torch.rand(STEPS, 3) < RATE * STEP).float()
    fall = 1.0 - STEP / torch.tensor(np.asarray(getattr(neurons, "tau", getattr(neurons, "tau_mem", None))))
    shared = {"threshold": torch.ones(4), "reset_mechanism": "zero", "init_hidden": True}
    if isinstance(neurons, nir.CubaLIF):
        layer = snn.Synaptic(
            alpha=1.0 - STEP / torch.tensor(np.asarray(neurons.tau_syn)), beta=fall, **shared
        )
    else:
        layer = snn.Leaky(beta=fall, **shared)
    counts = sum(layer(row[None] @ weight.T) for row in given)[0]
    return {"given": given.numpy().astype(bool), "counts": counts.detach().numpy(), "step": STEP}


def of_sinabs():
    """What sinabs exports, whose time constants are steps: its neurons behind weights."""
    linear, given = torch.nn.Linear, {"batch_size": 1}
    for name, layer in (
        ("iaf", sl.IAFSqueeze(**given)),
        ("lif", sl.LIFSqueeze(tau_mem=torch.full((4,), 20.0), spike_threshold=torch.ones(4), **given)),
        ("leak", sl.ExpLeakSqueeze(tau_mem=torch.full((4,), 50.0), **given)),
    ):
        net = torch.nn.Sequential(linear(3, 4, bias=False), layer)
        data = torch.randn(1, 3)
        net(data)
        yield name, sinabs_to_nir(net, data)
    pooled = torch.nn.Sequential(
        torch.nn.Conv2d(1, 2, 3, bias=False),
        sl.IAFSqueeze(**given),
        sl.SumPool2d(2),
        torch.nn.Flatten(),
        linear(8, 4, bias=False),
        sl.IAFSqueeze(**given),
    )
    data = torch.randn(1, 1, 6, 6)
    pooled(data)
    yield "convolution", sinabs_to_nir(pooled, data)


def written(library, name, graph):
    """Bytes of the file of a graph, none where NIR cannot write it."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "graph.nir"
        try:
            nir.write(path, graph)
        except (TypeError, ValueError) as error:
            sys.stderr.write(f"{library}/{name}: {type(error).__name__}: {error}\n")
            return b""
        return path.read_bytes()


def main():
    """Write all graphs."""
    nir_source, norse_source = (Path(each) for each in sys.argv[1:])
    torch.manual_seed(0)
    makers = {
        "nir": lambda: of_nir(nir_source), "norse": of_norse, "snntorch": of_snntorch, "sinabs": of_sinabs,
    }  # fmt: skip
    for library, make in makers.items():
        graphs = dict(make())
        files = {f"{name}.nir": written(library, name, graph) for name, graph in graphs.items()}
        for name in WEIGHTS if library == "snntorch" else ():
            buffer = io.BytesIO()
            np.savez_compressed(buffer, **run_of_snntorch(graphs[name]))
            files[f"{name}.npz"] = buffer.getvalue()
        if library == "norse":
            path = norse_source / "norse" / "torch" / "utils" / "test" / "braille.nir"
            files["braille.nir"] = path.read_bytes()
        with zipfile.ZipFile(HERE / f"{library}.zip", "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in files.items():
                if data:
                    archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)
    shutil.copy(nir_source / "LICENSE", HERE / "LICENSE.nir")
    shutil.copy(norse_source / "LICENSE", HERE / "LICENSE.norse")


if __name__ == "__main__":
    main()
