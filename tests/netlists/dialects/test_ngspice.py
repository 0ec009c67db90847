"""ngspice text: the same text for the same input, hierarchy, arrays, names, every device type."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import Circuit, Instance, InstanceArray, Node, Port
from circuits.devices import DEVICE_TYPES, Capacitor, ControlledSource, Resistor, Source, Transistor
from circuits.devices.device import Device
from circuits.devices.source import Constant, Driven, PiecewiseLinear, Pulse, Sampled
from circuits.errors import ParameterError, TopologyError, UnknownNameError
from circuits.lowering.flatten import flatten
from circuits.registry import block_names, load_block
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.testbench import Testbench
from netlists.dialects.ngspice import DIALECT, format_device, format_testbench, node_name, run_name
from netlists.write.traversal import to_design
from tests.circuits.devices.examples import EXAMPLES

SILICON = Silicon(AMI_1500_IDEAL)


def low_pass(resistance: float = 1e3) -> Circuit:
    devices = (Resistor("r", "a", "y", resistance), Capacitor("c", "y", "0", 1e-9))
    return Circuit("low_pass", (Port("a", "analog"), Port("y", "analog", "out")), devices)


def lines(text: str, *beginnings: str) -> list[str]:
    """Cards of a deck that begin so, continuation lines folded in."""
    cards = text.replace("\n+ ", " ").splitlines()
    return [card for card in cards if card.startswith(beginnings)]


def deck(circuit: Circuit, *sources: Source, stop: float = 1e-3, **options: object) -> str:
    return format_testbench(Testbench("test", circuit, sources, stop), SILICON, **options)  # type: ignore[arg-type]


def block_testbench(name: str) -> Testbench:
    block = load_block(name)
    return block.bench()


@pytest.mark.parametrize("kind", DEVICE_TYPES)
def test_every_device_type_is_written(kind: type[Device]) -> None:
    written = format_device(EXAMPLES[kind], SILICON)
    assert written
    assert all(line[0] in "bcdrgvi" or line.startswith((".model", "+ ")) for line in written)


def test_a_device_type_without_a_lowering_is_named() -> None:
    class Memristor(Resistor):
        pass

    assert format_device(Memristor("r", "a", "b", 1.0), SILICON) == ["rr a b 1.0"]
    with pytest.raises(TypeError, match="object: no lowering to ngspice text"):
        format_device(object(), SILICON)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("device", "text"),
    [
        (Capacitor("c1", "a", "0", 1e-12), "cc1 a 0 1e-12"),
        (Resistor("r1", "a", "b[2]", 1e3), "rr1 a b#2 1000.0"),
        (ControlledSource("g1", "a", "0", "x", "y", -2e-3), "gg1 a 0 x y -0.002"),
        (Source("drive", "a", Constant(5.0)), "vdrive a 0 dc 5.0"),
        (Source("k", "a", Constant(1e-9), "current"), "ik 0 a dc 1e-09"),
        (Source("w[2,1]", "w[2,1]", Driven(1.5)), "vw#2#1 w#2#1 0 dc 1.5"),
        (Source("odd name!", "a", Constant(1.0)), "vodd#x20name#x21 a 0 dc 1.0"),
    ],
)
def test_linear_elements_are_plain_cards(device: Device, text: str) -> None:
    assert format_device(device, SILICON) == [text]


@pytest.mark.parametrize(
    ("waveform", "text"),
    [
        (Pulse(0.0, 5.0, (1e-3,), 1e-5, 1e-7, 1e-7), "0.0 0.0 0.001 0.0 0.0010001 5.0"),
        (PiecewiseLinear((-1.0, 1.0), (0.0, 4.0)), "dc 2.0 pwl(0.0 2.0 1.0 4.0)"),
        (Sampled(0.0, 1e3, np.array([1.0, 2.0, 3.0])), "pwl(0.0 1.0 0.001 2.0 0.002 3.0)"),
        (PiecewiseLinear((-2.0, -1.0), (0.0, 4.0)), "dc 4.0"),
    ],
)
def test_waveforms_are_polylines_from_time_zero(waveform: Pulse, text: str) -> None:
    card = " ".join(format_device(Source("s", "a", waveform), SILICON)).replace(" + ", " ")
    assert text in card


def test_a_long_waveform_is_continued() -> None:
    samples = Sampled(0.0, 1e5, np.linspace(0.0, 1.0, 1000))
    written = format_device(Source("s", "a", samples), SILICON)
    assert len(written) > 100
    assert all(line.startswith("+ ") and len(line) < 120 for line in written[1:])
    numbers = " ".join(written).replace("+ ", "").split("pwl(")[1].rstrip(")").split()
    np.testing.assert_array_equal(np.array(numbers[1::2], dtype=float), samples.value)


def test_a_transistor_has_its_capacitances_and_skips_those_between_one_node() -> None:
    diode = Transistor("m", "n", "g", "g", "0", "0", 3e-6, 1.5e-6)
    names = [line.split()[0] for line in format_device(diode, SILICON)]
    assert names == ["bm", "cm#gb", "cm#gs", "cm#db"]
    leaky = Silicon(replace(AMI_1500_IDEAL, n=replace(AMI_1500_IDEAL.n, junction_leakage=1e-9)))
    lifted = replace(diode, source="s")
    currents = [
        [n for n in (line.split()[0] for line in format_device(device, leaky)) if n[0] == "b"]
        for device in (lifted, diode)
    ]
    assert currents == [["bm", "bm#db", "bm#sb"], ["bm", "bm#db"]]


def test_constants_are_folded_at_the_temperature() -> None:
    device = Transistor("m1", "p", "d", "g", "s", "vdd", 6e-6, 1.5e-6)
    cold, hot = (format_device(device, Silicon(AMI_1500_IDEAL, temperature_c=t))[0] for t in (-20.0, 85.0))
    assert cold != hot
    assert "temper" not in cold + hot


@pytest.mark.parametrize("name", block_names())
def test_the_text_is_the_same_every_time_and_complete(name: str) -> None:
    text = format_testbench(block_testbench(name), SILICON)
    assert text == format_testbench(block_testbench(name), SILICON)
    assert text.endswith("\n.end\n")
    assert text.isascii()
    assert "die nominal" in text.splitlines()[0]
    assert "temperature 27.0 degC" in text.splitlines()[0]


def test_a_deck_prints_some_nodes_so_that_ngspice_runs_it_by_itself() -> None:
    block = load_block("rebound-neuron")
    bench = block.testbench(block.build(), block.defaults, 5.0)
    for analysis in ("tran", "op"):
        text = format_testbench(bench, Silicon(AMI_1500_IDEAL), analysis=analysis)  # type: ignore[arg-type]
        (printed,) = [line for line in text.splitlines() if line.startswith(".print")]
        assert printed.split()[1] == analysis
        assert 1 <= printed.count("v(") <= 6


def test_the_title_is_one_line_and_can_be_chosen() -> None:
    testbench = Testbench("t", low_pass(), (Source("a", "a", Constant(1.0)),), 1e-3)
    assert (
        format_testbench(testbench, SILICON, "a\n.op  b")
        .splitlines()[0]
        .startswith("* a .op b: circuit low_pass")
    )


def test_a_circuit_used_twice_is_defined_once() -> None:
    part = low_pass()
    stages = (Instance("one", part, {"a": "x", "y": "y"}), Instance("two", low_pass(), {"a": "y", "y": "z"}))
    top = Circuit("chain", (Port("x", "analog"), Port("z", "analog", "out")), (), stages)
    text = deck(top, Source("x", "x", Constant(1.0)))
    assert lines(text, ".subckt") == [".subckt low_pass a y", ".subckt chain x z"]
    assert lines(text, "x") == ["xone x y low_pass", "xtwo y z low_pass", "xchain x z chain"]


def test_other_parameters_make_another_definition_with_a_free_name() -> None:
    taken = replace(low_pass(5e3), name="Low_Pass_2")
    connections = {"a": "x", "y": "y"}
    stages = (
        Instance("one", low_pass(), connections),
        Instance("two", taken, connections),
        Instance("three", low_pass(2e3), connections),
        Instance("four", low_pass(), connections, {"r.resistance": 2e3}),
        Instance("five", low_pass(), connections, {"r.resistance": 3e3}),
    )
    top = Circuit("top", (Port("x", "analog"), Port("y", "analog", "out")), (), stages)
    text = deck(top, Source("x", "x", Constant(1.0)))
    used = [line.split()[-1] for line in lines(text, "x")]
    assert used == ["low_pass", "Low_Pass_2", "low_pass_3", "low_pass_3", "low_pass_4", "top"]
    assert lines(text, "rr") == ["rr a y 1000.0", "rr a y 5000.0", "rr a y 2000.0", "rr a y 3000.0"]


def array(**parameters: object) -> Circuit:
    ports = (Port("x", "analog"), Port("out", "analog", "out", (2, 2)))
    rows = InstanceArray("row", low_pass(), (2, 2), {"a": "mid", "y": "out"}, parameters)
    devices = (Resistor("r0", "x", "mid[0]", 1.0), Resistor("r1", "x", "mid[1]", 1.0))
    return Circuit("bank", ports, devices, (rows,), (Node("mid", (2,)),))


def test_an_array_is_one_call_an_element_with_broadcast_nodes() -> None:
    text = deck(array(), Source("x", "x", Constant(1.0)))
    assert ".subckt bank x out#0#0 out#0#1 out#1#0 out#1#1" in text
    assert lines(text, "xrow") == [
        "xrow#0#0 mid#0 out#0#0 low_pass",
        "xrow#0#1 mid#1 out#0#1 low_pass",
        "xrow#1#0 mid#0 out#1#0 low_pass",
        "xrow#1#1 mid#1 out#1#1 low_pass",
    ]


def test_parameters_of_an_array_are_literal() -> None:
    values = np.array([[1e3, 2e3], [1e3, 4e3]])
    text = deck(array(**{"r.resistance": values}), Source("x", "x", Constant(1.0)))
    assert [line.split()[-1] for line in lines(text, "xrow")] == [
        "low_pass", "low_pass_2", "low_pass", "low_pass_3",
    ]  # fmt: skip
    assert lines(text, "rr ") == ["rr a y 1000.0", "rr a y 2000.0", "rr a y 4000.0"]


def test_a_die_has_its_own_transistors_and_says_so() -> None:
    part = Circuit(
        "follower",
        (Port("a", "analog"), Port("y", "analog", "out"), Port("vdd", "supply")),
        (Transistor("m", "n", "vdd", "a", "y", "0", 3e-6, 3e-6), Resistor("r", "y", "0", 1e6)),
    )
    bank = InstanceArray("cell", part, (2,), {"a": "a", "y": "y", "vdd": "vdd"})
    ports = (Port("a", "analog"), Port("vdd", "supply"), Port("y", "analog", "out", (2,)))
    circuit = Circuit("bank", ports, (), (bank,))
    drives = (Source("a", "a", Constant(2.0)), Source("vdd", "vdd", Constant(5.0)))
    testbench = Testbench("t", circuit, drives, 1e-3)
    nominal = format_testbench(testbench, SILICON)
    assert lines(nominal, ".subckt") == [".subckt follower a y vdd", ".subckt bank a vdd y#0 y#1"]
    die = Silicon(AMI_1500_IDEAL, die=Die("A", 3))
    text = format_testbench(testbench, die)
    assert "die A/3" in text.splitlines()[0]
    assert len(lines(text, ".subckt")) == 3
    laws = [*lines(text, "bm "), *lines(nominal, "bm ")]
    assert len(set(laws)) == 3
    alone = format_testbench(testbench, replace(die, place=(("chip", ()), ("bank", (1,)))))
    assert "circuit bank at chip/bank[1]," in alone.splitlines()[0]
    assert not set(lines(alone, "bm ")) & set(laws)
    calm = format_testbench(testbench, replace(die, die=Die("A", 3, mismatch=False)))
    assert len(lines(calm, ".subckt")) == 2


def test_wrong_parameters_of_an_array_are_named() -> None:
    with pytest.raises(ParameterError, match=r"r.resistance: -1 Ohm, must be > 0"):
        to_design(Testbench("t", array(**{"r.resistance": -1.0}), (), 1.0), SILICON)
    with pytest.raises(UnknownNameError, match=r"low_pass parameter r.length: unknown"):
        to_design(Testbench("t", array(**{"r.length": 1.0}), (), 1.0), SILICON)


def node_path(name: str) -> str:
    """Our path of a node by its name in a run, in lower case."""
    *instances, node = name.split(".")
    parts = (*(i.removeprefix("x") for i in instances[1:]), node)
    return ".".join(map(DIALECT.naming.reference, parts))


@pytest.mark.parametrize("name", block_names())
def test_names_in_a_run_lead_back_to_paths(name: str) -> None:
    testbench = block_testbench(name)
    design = to_design(testbench, SILICON)
    names = [run_name(path, design.top) for path in design.nodes]
    assert len(set(names)) == len(names)
    assert [node_path(n) for n in names] == [path.lower() for path in design.nodes]
    assert list(design.nodes) == flatten(testbench.circuit).node_names()[1:]


@pytest.mark.parametrize("reference", ["v_mem[3]", "w[1,2]", "gnd", "Time", "limit[2]", "a_3_", "_"])
def test_references_and_names_do_not_collide(reference: str) -> None:
    circuit = Circuit("c", (Port("x", "analog"),), (Resistor("r", "x", "0", 1.0),))
    top = to_design(Testbench("t", circuit, (), 1.0), SILICON).top
    assert node_path(run_name(f"part[2].{reference}", top)) == f"part[2].{reference}".lower()
    assert node_name(reference) not in {"gnd", "time", "Time", "limit"}


def test_names_that_differ_in_case_only_are_refused() -> None:
    circuit = Circuit(
        "c", (Port("x", "analog"),), (Resistor("r", "x", "A", 1.0), Resistor("s", "a", "0", 1.0))
    )
    with pytest.raises(TopologyError, match=r"c.a: node A has that name too \(case does not count\)"):
        deck(circuit, Source("x", "x", Constant(1.0)))
    circuit = Circuit("c", (Port("x", "analog"), Port("y", "analog")), (Resistor("r", "x", "y", 1.0),))
    with pytest.raises(TopologyError, match=r"test.V: source v has that name too"):
        deck(circuit, Source("v", "x", Constant(1.0)), Source("V", "y", Constant(1.0)))


def test_biases_are_sources_unless_the_testbench_drives_them() -> None:
    testbench = block_testbench("rebound-neuron")
    assert lines(format_testbench(testbench, SILICON), "vv_rest ") == ["vv_rest v_rest 0 dc 1.8"]
    driven = replace(testbench, sources=(*testbench.sources, Source("mine", "v_rest", Constant(1.7))))
    text = format_testbench(driven, SILICON)
    assert not lines(text, "vv_rest ")
    assert lines(text, "vmine ") == ["vmine v_rest 0 dc 1.7"]


def test_a_source_of_an_array_port_drives_every_element() -> None:
    ports = (Port("x", "analog", "in", (2,)),)
    circuit = Circuit("c", ports, (Resistor("r", "x[0]", "0", 1.0), Resistor("s", "x[1]", "0", 1.0)))
    assert lines(deck(circuit, Source("x", "x", Constant(1.0))), "vx") == [
        "vx#0 x#0 0 dc 1.0",
        "vx#1 x#1 0 dc 1.0",
    ]


def test_analysis_and_options_are_the_caller_s() -> None:
    drive = Source("a", "a", Constant(1.0))
    plain = deck(low_pass(), drive)
    assert lines(plain, ".tran") == [".tran 5e-07 0.001 0 5e-07"]
    assert "reltol=1e-05 method=gear" in plain
    text = deck(low_pass(), drive, tmax=1e-6, reltol=1e-3, method="trap", nodes=("y",))
    assert lines(text, ".tran", ".save") == [".save v(y)", ".tran 1e-06 0.001 0 1e-06"]
    assert "reltol=0.001 method=trap" in text
    assert lines(deck(low_pass(), drive, analysis="op"), ".tran", ".op")[2:] == [".op"]


def test_start_voltages_are_a_nodeset() -> None:
    circuit = Circuit(
        "c", (Port("x", "analog"),), (Resistor("r", "x", "y", 1.0), Capacitor("k", "y", "0", 1e-9))
    )
    drive = (Source("x", "x", Constant(1.0)),)
    text = format_testbench(Testbench("t", circuit, drive, 1e-3, start={"y": 0.5, "x": 1.0}), SILICON)
    assert lines(text, ".nodeset") == [".nodeset v(x)=1.0 v(xc.y)=0.5"]
