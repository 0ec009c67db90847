"""Behavioural neurons as Verilog-A: the text, and, with a compiler at hand, its spikes.

The compiled module is run under an integrator of the tests' own (`compiled_cell`); no simulator at hand takes
compiled modules (ngspice there is without OSDI).
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from chips.ranging import circuit as ranging_chip
from chips.ranging.law import Neurons
from chips.ranging.model import model_of, neurons_on
from chips.ranging.response import respond, tune
from chips.ranging.sheet import rebound_sheet
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from netlists.verilog_a.cell import FIGURES, MODULE, PORTS, CellArray, cell_module, format_cells
from tests.netlists.verilog_a.compiled_cell import CompiledCell, Drive

CALL = 1e-3  # s
# s: half of what an engine's edges may differ by. The chips' own integrator allows 0.1 mV a step, which moves
# a peak by up to 0.35 mV; spikes were found within 6 us, on 8 of 8 neurons of dies nominal, 1003 and 1010.
TOLERANCE = 10e-6


def cells(circuit: Circuit, silicon: Silicon) -> CellArray:
    sheet = rebound_sheet(circuit, silicon)
    return CellArray(circuit.name, sheet.shape, sheet.figures, sheet.remarks)


def test_the_sheet_has_the_figures_of_the_module_and_no_others() -> None:
    (figures,) = cells(rebound_neuron.build(), Silicon(AMI_1500_IDEAL)).figures
    assert set(figures) == set(FIGURES)


def test_the_module_is_whole_and_uses_what_it_declares() -> None:
    bare = re.sub(r"//.*", "", cell_module(dict.fromkeys(FIGURES, 1.0)))
    assert len(re.findall(r"\bbegin\b", bare)) == len(re.findall(r"\bend\b", bare))
    assert bare.count("(") == bare.count(")")
    for name in (*FIGURES, *PORTS, "v_r", "v_ex", "inhibit", "fill", "fire"):
        assert len(re.findall(rf"\b{name}\b", bare)) > 1, f"{name} is not used"
    (declared,) = re.findall(r"module \w+\((.*)\);", bare)
    assert tuple(declared.split(", ")) == PORTS


def test_a_chip_is_a_cell_a_neuron_with_its_own_figures() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1003), temperature_c=35.0)
    array = cells(ranging_chip.build(), silicon)
    text = format_cells(array, silicon, "ranging chip")
    first, *_ = text.splitlines()
    assert first.endswith("circuit ranging_chip, process ami-1500, die A/1003, temperature 35.0 degC")
    assert all(f"// {line}" in text for line in array.remarks)
    chip = re.sub(r"\s+", " ", text.partition("module ranging_chip(")[2])
    calls = re.findall(rf"{MODULE} #\((.*?)\) xneuron__(\d+)\((.*?)\);", chip)
    assert [int(k) for _, k, _ in calls] == list(range(13))
    for (given, k, nodes), figures in zip(calls, array.figures, strict=True):
        assert {n: float(v) for n, v in re.findall(r"\.(\w+)\(([^)]+)\)", given)} == figures
        assert nodes == f"call, echo, v_ex_max, v_mem__{k}, spike__{k}"
        assert chip.count(f"spike__{k},") + chip.count(f"spike__{k})") + chip.count(f"spike__{k};") == 4


def test_a_lone_neuron_is_a_module_around_one_cell() -> None:
    text = format_cells(
        cells(rebound_neuron.build(), Silicon(AMI_1500_IDEAL)), Silicon(AMI_1500_IDEAL), "neuron"
    )
    assert "module rebound_neuron(call, echo, v_ex_max, v_mem, spike);" in text
    assert "xneuron(call, echo, v_ex_max, v_mem, spike);" in text


def compiled(text: str, folder: Path) -> Any:
    compiler = pytest.importorskip("openvaf_py", reason="no Verilog-A compiler: pip install openvaf-py")
    path = folder / "cell.va"
    path.write_text(text)
    return next(module for module in compiler.compile_va(str(path)) if module.name == MODULE)


@pytest.mark.parametrize(("number", "k", "temperature"), [(None, 2, 27.0), (1010, 8, 50.0)])
def test_the_compiled_cell_spikes_when_the_behavioural_neuron_does(
    number: int | None, k: int, temperature: float, tmp_path: Path
) -> None:
    """An echo in the middle of the facilitating interval, one well before it, and no echo."""
    circuit, silicon = (
        ranging_chip.build(),
        Silicon(AMI_1500_IDEAL, die=Die(number=number), temperature_c=temperature),
    )
    array = cells(circuit, silicon)
    module = compiled(format_cells(array, silicon, "chip"), tmp_path)
    nodes = tuple(node["name"] for node in module.get_osdi_descriptor()["nodes"])
    cell = CompiledCell(module, array.figures[k], nodes)
    neuron = only(neurons_on(model_of(circuit, silicon.process), silicon), k)
    tuned = tune(neuron)
    assert tuned.classes == ["works"]
    until = CALL + float(neuron.t_inh[0] + neuron.rebound_bound[0])
    middle, before = float(0.5 * (tuned.first[0] + tuned.last[0])), float(tuned.first[0]) - 0.5e-3
    for echoes in ((CALL + middle,), (CALL + before,), ()):
        (expected,) = respond(neuron, (CALL,), echoes, until).spikes
        found = cell.spikes(Drive((CALL,), echoes, float(neuron.v_ex_max[0])), until)
        assert len(expected) == (1 if echoes == (CALL + middle,) else 0)
        np.testing.assert_allclose(found, expected, atol=TOLERANCE, rtol=0.0)


def only(neurons: Neurons, k: int) -> Neurons:
    """Neuron k alone."""
    return Neurons(**{n: None if n == "effects" else getattr(neurons, n)[k : k + 1] for n in Neurons._fields})
