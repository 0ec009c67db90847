"""All dialects write all blocks, the same text every time, in names that lead back to ours."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache

import pytest

from circuits.circuit import Circuit, InstanceArray, Port
from circuits.devices import Capacitor, Resistor, Source, Transistor
from circuits.devices.source import Constant, Pulse
from circuits.errors import ParameterError, TopologyError, UnknownNameError
from circuits.registry import block_names, load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.dialects.sweepable import CELLS
from netlists.registry import Dialect, Settings, dialect_names, load_dialect
from netlists.write.annotation import Header, parse_annotation

DIALECTS = [load_dialect(name) for name in dialect_names()]
CHOICES = [(d, m) for d in DIALECTS for m in d.devices]
IDS = [f"{d.name}-{m}" for d, m in CHOICES]
# Verilog-A is a language of its own, tested in test_verilog_a.py
CARDS = [(d, m) for d, m in CHOICES if d.name != "verilog-a"]
CARD_IDS = [f"{d.name}-{m}" for d, m in CARDS]
NETLISTS = [d for d in DIALECTS if d.name != "verilog-a"]
SIMULATED = [d for d in NETLISTS if d.name != "cdl"]
LONGEST = 1024  # characters in a line of HSPICE


@cache
def made_twice(name: str) -> tuple[Testbench, Testbench]:
    """The testbench of a block, made anew each time."""
    return load_block(name).bench(), load_block(name).bench()


def block_testbench(name: str) -> Testbench:
    return made_twice(name)[0]


def bank(count: int = 3) -> Testbench:
    part = Circuit(
        "follower",
        (Port("a", "analog"), Port("y", "analog", "out"), Port("vdd", "supply")),
        (Transistor("m", "n", "vdd", "a", "y", "0", 3e-6, 3e-6), Resistor("r", "y", "0", 1e6),
         Capacitor("c", "inner", "y", 1e-12), Resistor("ri", "inner", "0", 1e6)),
    )  # fmt: skip
    ports = (Port("a", "analog"), Port("vdd", "supply"), Port("y", "analog", "out", (count,)))
    cells = InstanceArray("cell", part, (count,), {"a": "a", "y": "y", "vdd": "vdd"})
    drives = (
        Source("a", "a", Pulse(0.0, 2.0, (1e-4,), 1e-4, 1e-6, 1e-6)),
        Source("vdd", "vdd", Constant(5.0)),
    )
    return Testbench("bank", Circuit("bank", ports, (), (cells,)), drives, 1e-3, start={"y[1]": 0.5})


def notes(dialect: Dialect, text: str) -> list[str]:
    mark = dialect.comment + "%"
    joined = re.sub(f"\n{re.escape(mark)}\\+ ", " ", text)
    return [line.removeprefix(mark).strip() for line in joined.splitlines() if line.startswith(mark)]


def statements(dialect: Dialect, text: str) -> list[str]:
    """Lines that are no comment, continuations folded in."""
    kept = [line for line in text.splitlines() if not line.startswith(dialect.comment)]
    return re.sub("\n\\+ ", " ", "\n".join(kept)).splitlines()


@pytest.mark.parametrize(("dialect", "models"), CHOICES, ids=IDS)
@pytest.mark.parametrize("name", block_names())
def test_every_block_is_written_the_same_every_time(name: str, dialect: Dialect, models: str) -> None:
    settings = Settings(models=models)
    first, again = made_twice(name)
    text = dialect.write(first, Silicon(AMI_1500_IDEAL), settings)
    assert text == dialect.write(again, Silicon(AMI_1500_IDEAL), settings)
    assert text.isascii()
    assert text.endswith("\n")
    assert parse_annotation(notes(dialect, text)[0]).value == Header(1, dialect.name, models)
    assert all(parse_annotation(note) for note in notes(dialect, text))
    if dialect.name == "hspice":
        assert max(map(len, text.splitlines())) <= LONGEST


@pytest.mark.parametrize(("dialect", "models"), CHOICES, ids=IDS)
def test_only_what_is_run_here_does_not_say_otherwise(dialect: Dialect, models: str) -> None:
    head = dialect.write(bank(), Silicon(AMI_1500_IDEAL), Settings(models=models)).splitlines()[:6]
    assert any("not run here" in line for line in head) is not dialect.runs
    assert dialect.runs is (dialect.name == "ngspice")
    assert ("not run here" in dialect.summary) is not dialect.runs


@pytest.mark.parametrize(("dialect", "models"), CARDS, ids=CARD_IDS)
def test_arrays_and_definitions_are_those_of_the_design(dialect: Dialect, models: str) -> None:
    text = dialect.write(bank(), Silicon(AMI_1500_IDEAL), Settings(models=models))
    lines = statements(dialect, text)
    opened = [line.split()[1] for line in lines if line.lstrip(".").startswith("subckt")]
    cells = [CELLS["n"]] if models == "sweepable" else []
    assert opened == [*cells, "follower", "bank"]
    calls = [line for line in lines if line.startswith("xcell")]
    node = dialect.naming.node
    assert len(calls) == 3
    for k, call in enumerate(calls):
        words = re.sub("[()]", " ", call).split()
        assert words == ["x" + node(f"cell[{k}]"), "a", node(f"y[{k}]"), "vdd", "follower"]


@pytest.mark.parametrize("dialect", SIMULATED, ids=lambda d: d.name)
def test_start_voltages_are_a_nodeset_at_the_node_s_own_name(dialect: Dialect) -> None:
    text = dialect.write(bank(), Silicon(AMI_1500_IDEAL), Settings())
    (line,) = [line for line in statements(dialect, text) if "nodeset" in line]
    assert dialect.naming.node("y[1]") in line
    assert "0.5" in line
    saved = " ".join(line for line in statements(dialect, text) if re.match(r"\.?(save|print|probe)", line))
    inner = "xbank" + (":" if dialect.name == "xyce" else ".") + "x" + dialect.naming.node("cell[2]")
    assert inner + (":" if dialect.name == "xyce" else ".") + "inner" in saved


@pytest.mark.parametrize("dialect", NETLISTS, ids=lambda d: d.name)
def test_a_die_has_its_own_transistors_but_is_drawn_like_all(dialect: Dialect) -> None:
    nominal, die = (
        dialect.write(bank(), Silicon(AMI_1500_IDEAL, die=d), Settings()) for d in (Die(), Die("A", 3))
    )
    if dialect.name == "cdl":
        assert die == nominal
    else:
        opened = [line for line in statements(dialect, die) if line.lstrip(".").startswith("subckt")]
        assert len(opened) == 4
        assert sum(note.startswith("deviation ") for note in notes(dialect, die)) == 3


@pytest.mark.parametrize("dialect", SIMULATED, ids=lambda d: d.name)
def test_expressions_are_the_dialect_s(dialect: Dialect) -> None:
    silicon = Silicon(
        replace(
            AMI_1500_IDEAL,
            n=replace(AMI_1500_IDEAL.n, law="ekv-gamma", early_field=2.5e6, junction_leakage=1e-9),
        )
    )
    device = Transistor("m_", "n", "d[1]", "gnd", "s__t", "0", 3e-6, 3e-6)
    both = (silicon, Silicon(AMI_1500_IDEAL))  # a simple law stands in one expression, with powers
    text = "\n".join(line for each in both for line in dialect.devices["ekv"](device, each))
    power, logarithm = {
        "ngspice": ("^2", "ln("),
        "hspice": ("**2", "log("),
    }.get(dialect.name, ("**2", "ln("))
    assert power in text
    assert logarithm in text
    assert ("^" in text) is (dialect.name == "ngspice")
    assert ("#" in text) is (dialect.name == "ngspice")
    assert f"v({dialect.naming.node('gnd')})" in text


@pytest.mark.parametrize(("dialect", "models"), CARDS, ids=CARD_IDS)
def test_a_parasitic_capacitance_is_where_its_node_is(dialect: Dialect, models: str) -> None:
    settings = Settings(models=models, parasitics={"cell[1].inner": 3e-15, "y[2]": 4e-15, "a": 5e-15})
    text = dialect.write(bank(), Silicon(AMI_1500_IDEAL), settings)
    lines = statements(dialect, text)
    found = [line for line in lines if line.startswith("cparasitic")]
    assert [line.split("=")[-1].split()[-1] for line in found] == ["3e-15", "4e-15", "5e-15"]
    called = [re.sub("[()]", " ", line).split()[-1] for line in lines if line.startswith("xcell")]
    assert called == ["follower", "follower_2", "follower"]
    assert sum(note == f"parasitic name=parasitic{k}" for note in notes(dialect, text) for k in (0, 1)) == 3
    with pytest.raises(UnknownNameError, match=r"cell\[1\]\.other: unknown"):
        dialect.write(
            bank(), Silicon(AMI_1500_IDEAL), Settings(models=models, parasitics={"cell[1].other": 1e-15})
        )


def test_parasitics_of_a_die_and_of_taken_names() -> None:
    ports = (Port("a", "analog"),)
    circuit = Circuit("c", ports, (Capacitor("Parasitic0", "a", "0", 1e-12),))
    testbench = Testbench("t", circuit, (Source("a", "a", Constant(0.0)),), 1e-3)
    text = load_dialect("ngspice").write(
        testbench, Silicon(AMI_1500_IDEAL), Settings(parasitics={"a": 1e-15})
    )
    assert "\ncparasitic_0 a 0 1e-15\n" in text
    die = load_dialect("ngspice").write(
        bank(), Silicon(AMI_1500_IDEAL, die=Die("A", 3)), Settings(parasitics={"cell[1].inner": 1e-15})
    )
    assert die.count("parasitic0 inner") == 1
    assert die.count(".subckt") == 4


@pytest.mark.parametrize("dialect", DIALECTS, ids=lambda d: d.name)
def test_models_that_a_dialect_lacks_are_refused(dialect: Dialect) -> None:
    with pytest.raises(ParameterError, match=f"models: psp, {dialect.name} has ekv"):
        dialect.write(bank(), Silicon(AMI_1500_IDEAL), Settings(models="psp"))


def test_an_unknown_dialect_is_named() -> None:
    with pytest.raises(UnknownNameError, match="dialect edif: unknown; known are"):
        load_dialect("edif")


@pytest.mark.parametrize("dialect", DIALECTS, ids=lambda d: d.name)
def test_a_name_that_no_dialect_can_write_is_refused(dialect: Dialect) -> None:
    testbench = bank()
    odd = replace(testbench, circuit=replace(testbench.circuit, name="odd name"))
    with pytest.raises(TopologyError, match="not a node name"):
        dialect.write(odd, Silicon(AMI_1500_IDEAL), Settings())
