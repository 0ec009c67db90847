"""Parasitic capacitances from a file: units, nodes by path, and errors with file and line."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from circuits.circuit import Circuit, InstanceArray, Port
from circuits.devices import Capacitor, Resistor, Source
from circuits.devices.source import PiecewiseLinear
from circuits.registry import load_block
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.ngspice import run as ngspice
from netlists.ngspice.engine import node_names
from netlists.parasitics import read_parasitics
from netlists.registry import Settings, load_dialect

BLOCK = load_block("rebound-neuron")
CIRCUIT = BLOCK.build()


def read(folder: Path, text: str) -> dict[str, float]:
    path = folder / "layout.csv"
    path.write_text(text)
    return read_parasitics(path, CIRCUIT)


def test_nodes_and_units(tmp_path: Path) -> None:
    text = "Node, Capacitance\n# extracted\n\nv_mem,12.5fF\n membrane.v_r , 3f\nspike,0\ncall,0.001p\n"
    found = read(tmp_path, text)
    assert found == {"v_mem": pytest.approx(12.5e-15), "membrane.v_r": 3e-15, "call": 1e-15}
    assert read(tmp_path, "v_mem,1fF") == {"v_mem": 1e-15}
    assert read(tmp_path, "") == {}


def test_an_element_of_an_array_stands_in_quotes_or_not(tmp_path: Path) -> None:
    chip = load_block("centroid-board")
    path = tmp_path / "layout.csv"
    path.write_text('"spike[3]",1f\nlookup[0],2f\n')
    assert read_parasitics(path, chip.build()) == {"spike[3]": 1e-15, "lookup[0]": 2e-15}


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("v_mem,1f\nv_men,1f", ":2: no node v_men in rebound_neuron"),
        ("membrane.v_mem,1f", ":1: no node membrane.v_mem"),
        ("v_mem[0],1f", ":1: no node"),
        ("odd name,1f", ":1: no node"),
        ("x" * 200 + ",1f", "xxx... in"),
        ("0,1f", ":1: 0 is ground itself"),
        ("v_mem", ":1: 1 columns"),
        ("v_mem,1f,2f", ":1: 3 columns"),
        ("v_mem,1F", ":1: v_mem: .*femto"),
        ("v_mem,1e-15", ":1: v_mem: .*write the unit too, as in 1fF"),
        ("v_mem,much", ':1: v_mem: "much", must be a capacitance'),
        ("v_mem,1pV", ":1: v_mem"),
        ("v_mem,-1f", ":1: v_mem: -1e-15 F, must be 0 to 1mF"),
        ("v_mem,1e999", ":1: v_mem"),
        ("v_mem,1f\n\nv_mem,2f", ":3: v_mem has a capacitance in line 1"),
    ],
)
def test_errors_have_file_and_line(text: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(Exception, match=words) as caught:
        read(tmp_path, text)
    assert type(caught.value).__name__ == "DataError"
    assert "layout.csv:" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    for path, words in ((tmp_path, "directory"), (tmp_path / "none.csv", "No such file")):
        with pytest.raises(Exception, match=words):
            read_parasitics(path, CIRCUIT)
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe")
    with pytest.raises(Exception, match="not UTF-8"):
        read_parasitics(binary, CIRCUIT)
    binary.write_bytes(b'"' + b"a" * 200_000)
    with pytest.raises(Exception, match="field larger"):
        read_parasitics(binary, CIRCUIT)


def test_a_capacitance_slows_its_node_in_ngspice() -> None:
    """1 nF beside 1 nF inside one of two equal instances doubles the time constant of that one."""
    part = Circuit(
        "low_pass",
        (Port("a", "analog"),),
        (Resistor("r", "a", "y", 1e3), Capacitor("c", "y", "0", 1e-9)),
    )
    pair = InstanceArray("stage", part, (2,), {"a": "a"})
    step = Source("a", "a", PiecewiseLinear((0.0, 1e-9), (0.0, 1.0)))
    bench = Testbench("pair", Circuit("pair", (Port("a", "analog"),), (), (pair,)), (step,), 1e-6)
    text = load_dialect("ngspice").write(
        bench, Silicon(AMI_1500_IDEAL), Settings(parasitics={"stage[1].y": 1e-9})
    )
    names = node_names(bench, Silicon(AMI_1500_IDEAL))
    values = ngspice.run(text).values
    ends = [float(values[names[f"stage[{k}].y"]][-1]) for k in (0, 1)]
    # 1 - e^-t/RC at t = RC and RC/2; the step's nanosecond and ngspice's own error are below 1e-3
    assert ends == pytest.approx([1.0 - math.exp(-1.0), 1.0 - math.exp(-0.5)], abs=1e-3)
