"""Schematics of xschem's, netlisted by its rules: of a reader here, and of xschem itself where it is."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, ControlledSource, OperationalAmplifier, Resistor, Transistor
from circuits.errors import ParameterError
from circuits.registry import load_block
from netlists.compare.circuits import compare
from netlists.read import read_netlist
from system.cli.command_line import main
from system.schematic.xschem import to_xschem

# pins of xschem's own symbols (its folder `devices`) in the order in which it lists them
MOS = {"nmos4": -1.0, "pmos4": 1.0}
PINS = {
    **{kind: ((20.0, 30.0 * d), (-20.0, 0.0), (20.0, -30.0 * d), (20.0, 0.0)) for kind, d in MOS.items()},
    "capa": ((0.0, -30.0), (0.0, 30.0)),
    "res": ((0.0, -30.0), (0.0, 30.0)),
    "vccs": ((0.0, -30.0), (0.0, 30.0), (-40.0, -20.0), (-40.0, 20.0)),
    **dict.fromkeys(("lab_pin", "gnd", "ipin", "opin", "iopin"), ((0.0, 0.0),)),
}
LABELS = ("lab_pin", "gnd", "ipin", "opin", "iopin")
SYMBOL = re.compile(r"C \{devices/(\w+)\.sym\} (\S+) (\S+) (\d) (\d) \{(.*)\}")
WIRE = re.compile(r"N (\S+) (\S+) (\S+) (\S+) \{.*\}")
BLOCKS = ("nef-neuron", "tonic-neuron", "rebound-neuron", "rolls-neuron", "axon-delay", "wavefront-cell")
Point = tuple[float, float]


def turned(at: Point, offset: Point, rot: str, flip: str) -> Point:
    """A pin's place: mirrored about the symbol's own axis, then turned by quarters."""
    x, y = (-offset[0] if flip == "1" else offset[0]), offset[1]
    for _ in range(int(rot)):
        x, y = -y, x
    return at[0] + x, at[1] + y


def netlist(text: str) -> str:
    """The SPICE text of a schematic: what touches is one net, and a label is its name."""
    wires = [tuple(map(float, found)) for found in WIRE.findall(text)]
    symbols = [
        (kind, dict(pair.split("=") for pair in rest.split()),
         [turned((float(x), float(y)), pin, rot, flip) for pin in PINS[kind]])
        for kind, x, y, rot, flip, rest in SYMBOL.findall(text)
    ]  # fmt: skip
    points = {p for *_, pins in symbols for p in pins} | {e for w in wires for e in (w[:2], w[2:])}
    parent = {p: p for p in points}

    def root(p: Point) -> Point:
        while parent[p] != p:
            p = parent[p]
        return p

    for x0, y0, x1, y1 in wires:
        for p in points:
            if min(x0, x1) <= p[0] <= max(x0, x1) and min(y0, y1) <= p[1] <= max(y0, y1):
                parent[root(p)] = root((x0, y0))
    names: dict[Point, str] = {}
    for kind, given, pins in symbols:
        if kind in LABELS:
            assert names.setdefault(root(pins[0]), given["lab"]) == given["lab"]
    ports = [given["lab"] for kind, given, _ in symbols if kind.endswith("pin") and kind != "lab_pin"]
    lines = [f".subckt top {' '.join(ports)}"]
    for kind, given, pins in symbols:
        if kind not in LABELS:
            nets = " ".join(names[root(p)] for p in pins)
            rest = {k: v for k, v in given.items() if k not in {"name", "model", "value"}}
            size = " ".join(f"{k}={v}" for k, v in rest.items())
            lines.append(f"{given['name']} {nets} {given.get('model', given.get('value'))} {size}")
    return "* of xschem\n" + "\n".join([*lines, ".ends"]) + "\n"


def read_back(text: str) -> Circuit:
    return read_netlist(text, dialect="cdl").circuit


def parts() -> Circuit:
    return Circuit(
        "parts", (Port("vdd", "supply"), Port("v_in", "analog"), Port("out", "analog", "out")),
        (
            Transistor("m1", "n", "out", "v_in", "0", "0", 6e-6, 3e-6, 2.0),
            Transistor("m2", "p", "out", "v_in", "vdd", "vdd", 9e-6, 3e-6),
            Transistor("m3", "n", "vdd", "out", "tail", "0", 6e-6, 3e-6),
            Resistor("r1", "tail", "0", 1e6),
            Capacitor("c1", "out", "tail", 1e-13),
            ControlledSource("g1", "tail", "0", "out", "v_in", 1e-9),
        ),
    )  # fmt: skip


def test_each_device_is_netlisted_back() -> None:
    found = compare(parts(), read_back(netlist(to_xschem(parts()))))
    assert [str(d) for d in found.differences] == []


def test_a_net_that_is_moved_is_seen() -> None:
    """The reader can tell a wrong schematic."""
    text, count = re.subn(r"(lab_pin\.sym\}.*)lab=v_in\}", r"\1lab=other}", to_xschem(parts()), count=1)
    assert count == 1
    assert not compare(parts(), read_back(netlist(text))).equal


@pytest.mark.parametrize("name", BLOCKS)
def test_a_block_is_netlisted_back(name: str) -> None:
    circuit = load_block(name).build()
    found = compare(circuit, read_back(netlist(to_xschem(circuit))))
    assert [str(d) for d in found.differences] == []
    assert found.devices[0] == found.devices[1] > 10


def test_what_xschem_has_no_symbol_for_is_refused() -> None:
    devices = (OperationalAmplifier("x1", "a", "o", "o", "vdd"), Resistor("r", "o", "0", 1e3))
    circuit = Circuit("follower", (Port("vdd", "supply"), Port("a", "analog")), devices)
    with pytest.raises(ParameterError, match=r"^x1: operational amplifier, which xschem has no symbol for"):
        to_xschem(circuit)


def test_the_command_writes_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "neuron.sch"
    assert main(["export", "nef-neuron", "--dialect", "xschem", "-o", str(path)]) == 0
    assert path.read_text().startswith("v {xschem version=")
    for refused in (("--die", "1000"), ("--models", "bsim3")):
        assert main(["export", "nef-neuron", "--dialect", "xschem", *refused, "-o", "-"]) == 2
        assert refused[0] in capsys.readouterr().err


@pytest.mark.skipif(shutil.which("xschem") is None, reason="no xschem; install Debian's package xschem")
@pytest.mark.parametrize("name", ["nef-neuron", "tonic-neuron"])
def test_xschem_netlists_it_back(name: str, tmp_path: Path) -> None:
    circuit = load_block(name).build()
    (tmp_path / "a.sch").write_text(to_xschem(circuit))
    (tmp_path / "rc").write_text(f"set netlist_dir {tmp_path}\n")
    words = ["xschem", "-n", "-s", "-q", "-x", "--rcfile", str(tmp_path / "rc"), str(tmp_path / "a.sch")]
    subprocess.run(words, check=True, capture_output=True, timeout=60)
    text = (tmp_path / "a.spice").read_text().replace("**.", ".").replace("\n*+", "\n+")
    assert compare(circuit, read_back(text)).equal
