"""Sections to circuits."""

import pytest

from circuits.circuit import Circuit, Instance, Port
from circuits.devices import Resistor, Source
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import DataError
from circuits.solver.operating_point import operating_point
from netlists.read import Imported, Limits, read_netlist
from netlists.read.limits import DEFAULT_LIMITS
from tests.refusals import refusals

DIVIDER = ".subckt half a b params: r=1k\nr1 a b {r}\nr2 b 0 r\n.ends\n"


def read(text: str, limits: Limits = DEFAULT_LIMITS) -> Imported:
    return read_netlist("title\n" + text, limits=limits)


def half(value: float) -> Circuit:
    ports = (Port("a", "analog"), Port("b", "analog"))
    return Circuit("half", ports, (Resistor("r1", "a", "b", value), Resistor("r2", "b", "0", value)))


def test_the_top_level_has_its_driven_nodes_as_ports() -> None:
    found = read(
        DIVIDER + "v1 in 0 5\nvp pulse 0 pwl(0 0 1u 5)\nx1 in m half\nx2 m out half r=2k\nrl pulse 0 1meg"
    )
    assert found.circuit == Circuit(
        "top",
        (Port("in", "supply"), Port("pulse", "analog")),
        (Resistor("rl", "pulse", "0", 1e6),),
        (
            Instance("x1", half(1e3), {"a": "in", "b": "m"}),
            Instance("x2", half(2e3), {"a": "m", "b": "out"}),
        ),
    )
    assert found.testbench.sources == (
        Source("v1", "in", Constant(5.0)),
        Source("vp", "pulse", PiecewiseLinear((0.0, 1e-6), (0.0, 5.0))),
    )


def test_equal_parameters_share_one_circuit() -> None:
    found = read(DIVIDER + "x1 in m half\nx2 m out half r={2*500}\nx3 m out half r=2\nr1 in 0 1")
    circuits = [instance.circuit for instance in found.circuit.instances]
    assert circuits[0] == circuits[1] == half(1e3)
    assert circuits[2] == half(2.0)


def test_a_lone_call_is_the_circuit() -> None:
    found = read(DIVIDER + "vdd n1 0 5\nx1 n1 n2 half\n.ic v(n2)=1\n.tran 1u 1m")
    assert found.circuit.name == "half"
    assert found.circuit.ports == (Port("a", "supply"), Port("b", "analog", "out"))
    assert found.testbench.sources == (Source("vdd", "a", Constant(5.0)),)
    assert found.testbench.initial == {"b": 1.0}
    assert found.testbench.start == {}
    assert found.testbench.begin == "disturbed"
    assert found.testbench.stop == 1e-3


def test_a_library_is_its_last_circuit_that_no_other_calls() -> None:
    found = read(
        ".subckt whole a\nx1 a m half\nr1 m 0 1\n.ends\n" + DIVIDER + ".subckt other a\nr1 a 0 1\n.ends"
    )
    assert found.circuit.name == "other"
    assert [note.what for note in found.notes] == [
        "sub-circuit whole, not called",
        "sub-circuit half, not called",
    ]
    assert found.testbench.stop == float("inf")


def test_ground_and_reversed_sources() -> None:
    found = read("v1 0 a 5\ni1 b 0 1n\ni2 a b 2n\nr1 a gnd 1\nr2 b GND 1")
    assert found.testbench.sources == (
        Source("v1", "a", Constant(-5.0)),
        Source("i1", "b", Constant(-1e-9), "current"),
        Source("i2[0]", "b", Constant(2e-9), "current"),
        Source("i2[1]", "a", Constant(-2e-9), "current"),
    )
    assert {d.terminals()[1] for d in found.circuit.devices} == {"0"}


def test_global_nodes_become_ports_all_the_way_up() -> None:
    found = read(
        ".global vdd\n.subckt in a\nr1 a vdd 1\n.ends\n.subckt out b\nx1 b in\n.ends\n"
        "v1 vdd 0 5\nx1 c out\nr1 c 0 1"
    )
    outer = found.circuit.instances[0]
    assert outer.connections == {"b": "c", "vdd": "vdd"}
    assert outer.circuit.instances[0].connections == {"a": "b", "vdd": "vdd"}


def test_start_voltages_reach_into_instances() -> None:
    found = read(".subckt s a\nr1 a m 1\nr2 m 0 1\n.ends\nx1 b s\nr1 b 0 1\n.nodeset v(x1.m)=1 v(b)=2")
    assert found.testbench.start == {"x1.m": 1.0, "b": 2.0}


def test_a_source_inside_a_subcircuit_stands_at_the_top_once_a_call() -> None:
    found = read(
        ".subckt in a params: u=1\nv1 b 0 {u}\nr1 b a 1k\n.ends\n.subckt out a\nx1 a in u=2\n"
        "i1 0 a 1m\n.ends\n"
        "x1 p out\nx2 p in u=3\nr1 p 0 1k\n.ic v(x1.x1.b)=2"
    )
    driven = {(s.name, s.node, s.quantity, s.waveform) for s in found.testbench.sources}
    assert driven == {
        ("x1_x2e_x1_x2e_v1", "x1_x2e_x1_x2e_b", "voltage", Constant(2.0)),
        ("x1_x2e_i1", "p", "current", Constant(1e-3)),
        ("x2_x2e_v1", "x2_x2e_b", "voltage", Constant(3.0)),
    }
    assert found.names["x1_x2e_x1_x2e_b"] == "x1.x1.b"
    assert found.testbench.initial == {"x1_x2e_x1_x2e_b": 2.0}
    # (2 + 3) V through 1 kohm each and 1 mA, into 1 kohm
    assert operating_point(found.testbench)["p"] == pytest.approx((2.0 + 3.0 + 1.0) / 3.0)


def test_a_port_called_gnd_is_ground_inside_whatever_it_is_outside() -> None:
    found = read(".subckt s a gnd\nr1 a gnd 1k\n.ends\nx1 p q s\ni1 0 p 1m\nr1 q 0 1k\nr2 ground p 1k")
    assert found.circuit.instances[0].connections == {"a": "p"}
    assert found.circuit.device("r2").terminals()[0] == "_x67_round"
    assert found.names["_x67_round"] == "ground"


def test_a_sub_circuit_has_the_parameters_of_what_calls_it() -> None:
    inner = ".subckt inner p\nr1 p 0 {w}\n.ends\n"
    outer = ".subckt outer p w=3k\nr1 p q 1k\nx2 q inner\n.ends\n"
    found = read(f".param w=1k\n{inner}{outer}v1 a 0 1\nx1 a outer\nx2 a outer w=9k\nx3 b inner\nr3 a b 1k")
    point = operating_point(found.testbench)  # ngspice has the same three
    assert [point[n] for n in ("x1.q", "x2.q", "b")] == pytest.approx([0.75, 0.9, 0.5])


def test_a_model_has_the_parameters_of_where_it_stands() -> None:
    cell = "r1 p q 10k\nd1 q 0 {}\n.ends\n"
    outside = f".subckt out p q isx=1e-12\n{cell.format('dtop')}"
    inside = f".subckt in p q isx=1e-12\n.model dloc d is={{isx}}\n{cell.format('dloc')}"
    calls = "x1 a n1 out\nx2 a n2 out isx=1e-10\nx3 a n3 in\nx4 a n4 in isx=1e-10"
    found = read(f".param isx=1e-14\n.model dtop d is={{isx}}\n{outside}{inside}v1 a 0 1\n{calls}")
    point = operating_point(found.testbench)  # the numbers are ngspice's
    expected = [0.5735203, 0.5735203, 0.4604885, 0.3463402]
    assert [point[n] for n in ("n1", "n2", "n3", "n4")] == pytest.approx(expected, abs=1e-6)


def test_initial_voltages_in_a_sub_circuit_hold_for_each_call_with_its_parameters() -> None:
    cell = (
        ".subckt s p vs=0.5\nr1 p q 1k\nc1 q 0 1n\n.ic v(q)={vs} v(p)=0.9\n.nodeset v(q)=0.1 v(g)=2\n.ends\n"
    )
    around = ".subckt t p\nx1 p s vs=0.2\n.ends\n.global g\n"
    found = read(f"{cell}{around}r0 a 0 1k\nr9 g 0 1k\nc9 q 0 1n\nr8 q a 1k\nx1 a s\nx2 a s vs=0.3\nx3 a t")
    assert found.testbench.initial == {"a": 0.9, "x1.q": 0.5, "x2.q": 0.3, "x3.x1.q": 0.2}
    assert found.testbench.start == {"g": 2.0, "x1.q": 0.1, "x2.q": 0.1, "x3.x1.q": 0.1}


def test_a_node_behind_a_source_of_0_v_may_be_given_a_voltage() -> None:
    cell = ".subckt s p\nr3 p q 1k\nv3 q t 0\nr4 t 0 1k\n.ic v(t)=0.2\n.ends\n"
    cards = ".nodeset v(b1)=0.5\n.noise v(c1) v1 dec 10 1 1k\n"
    found = read(f"{cell}v1 a 0 1\nr1 a b 1k\nvz b b1 0\nr2 b1 c 1k\nvy c c1 0\nr5 c1 0 1k\nx1 a s\n{cards}")
    assert found.testbench.start == {"b1": 0.5}
    assert found.testbench.initial == {"x1.t": 0.2}
    assert operating_point(found.testbench)["c1"] == pytest.approx(1.0 / 3.0, abs=1e-6)


def test_initial_voltages_of_the_one_call_are_those_of_its_circuit() -> None:
    found = read(".subckt s p\nr1 p q 1k\nc1 q 0 1n\n.ic v(q)=0.5\n.nodeset v(p)=1\n.ends\nv1 a 0 1\nx1 a s")
    assert found.testbench.initial == {"q": 0.5}
    assert found.testbench.start == {"p": 1.0}


def test_a_source_at_a_node_that_nothing_uses_is_left_out_and_told() -> None:
    found = read("v1 a 0 1\nv2 b 0 1\nr1 a 0 1k")
    assert [s.name for s in found.testbench.sources] == ["v1"]
    assert [note.what for note in found.notes] == ["source v2, at a node that nothing else uses"]
    assert operating_point(found.testbench)["a"] == 1.0


def test_elements_under_if_depend_on_the_parameters_of_each_call() -> None:
    text = (
        ".param k=2\n.subckt s a params: n=1\n.if (n=1)\nr1 a 0 1\n.elseif (n == k)\nr2 a 0 1\n.else\n"
        "r3 a 0 1\n.endif\n"
        ".ends\nx1 a s\nx2 a s n=2\nx3 a s n=3\n.if (k>1)\n.param z=7\n.else\n.param z=8\n.endif\nr9 a 0 {z}"
    )
    found = read(text)
    assert [i.circuit.devices[0].name for i in found.circuit.instances] == ["r1", "r2", "r3"]
    assert found.circuit.device("r9").parameters() == {"resistance": 7.0}


test_refused_with_its_place = refusals(
    DataError,
    read,
    [
        ("x1 a b none", "netlist:2: x1: sub-circuit none is not there"),
        (DIVIDER + "x1 a half", "netlist:6: x1: 1 nodes, half has 2 ports, see netlist:2"),
        (DIVIDER + "x1 a b half q=1", "netlist:6: x1.q: half has no such parameter"),
        ("x1", "x1: no sub-circuit"),
        ("r1 a 0 1\nR1 b 0 1", "netlist:3: r1: duplicate name, also at netlist:2"),
        (".subckt s a\nx1 a s\n.ends\nx1 b s", "netlist:3: s: a sub-circuit that calls itself"),
        (".subckt s a\nx1 a t\n.ends\n.subckt t a\nx1 a s\n.ends\nx1 b s", "calls itself"),
        (
            ".subckt s a\nv1 a 0 1\nr1 a 0 1\n.ends\nx1 0 s\nr1 b 0 1",
            "netlist:6: x1: its source v1 drives ground",
        ),
        ("v1 a a 1\nr1 a b 1", "v1: both ends at one node; remove it"),
        ("v1 0 0 1\nr1 a 0 1", "v1: both ends at one node; remove it"),
        ("i1 a a 1\nr1 a 0 1", "both ends at one node"),
        ("v1 a\nr1 a 0 1", "v1: 1 nodes, must be 2"),
        ("r1 a 0 -1", "netlist:2: r1.resistance: -1 Ohm, must be > 0"),
        ("r1 a 0 1\n.ic v(b)=1", "netlist:3: v.b.: unknown node"),
        (".tran 1u 1m", "no elements"),
        ("r" + "x" * 500 + " a 0 1", "netlist:2: a name of more than 400 characters, the limit"),
        ("r1 a 0 1\nr2 " + "%" * 500 + " 0 1", "netlist:3: a name of more than 400 characters, the limit"),
        (".subckt s a " + "%" * 500 + "\n.ends\nx1 a b s", "netlist:2: a name of more than 400"),
        ("r1 a 0 1\n.ic v(a." + "%" * 500 + ")=1", "netlist:3: a name of more than 400"),
    ],
)


def test_calls_have_a_depth() -> None:
    chain = "".join(f".subckt s{k} a\nx1 a s{k + 1}\n.ends\n" for k in range(100))
    with pytest.raises(DataError, match="calls deeper than 64, the limit"):
        read(chain + ".subckt s100 a\nr1 a 0 1\n.ends\nx1 b s0")


def test_doubling_calls_are_counted_not_listed() -> None:
    chain = "".join(f".subckt s{k} a\nx1 a s{k + 1}\nx2 a s{k + 1}\n.ends\n" for k in range(60))
    with pytest.raises(DataError, match="elements, the limit is 1000000"):
        read(chain + ".subckt s60 a\nr1 a 0 1\n.ends\nx1 b s0")


def doubling(levels: int) -> str:
    """Sub-circuits that call the next one twice, each time with a parameter value of its own."""
    chain = "".join(
        f".subckt s{k} a p=1\nx1 a s{k + 1} p={{p*2}}\nx2 a s{k + 1} p={{p+1}}\n.ends\n"
        for k in range(levels)
    )
    return chain + f".subckt s{levels} a p=1\nr1 a 0 {{p}}\n.ends\nx1 b s0\n"


@pytest.mark.parametrize("others", [0, 2000])
def test_parameters_that_multiply_from_level_to_level_have_a_limit(others: int) -> None:
    """However many other cards there are, which have no part in it."""
    filler = "".join(f"rz{k} b 0 1\n" for k in range(others))
    with pytest.raises(DataError, match="more than 1000 cards of sub-circuits called with other parameters"):
        read(doubling(20) + filler, Limits(expansion=1000))


def test_the_netlist_s_own_calls_may_have_parameters_of_their_own() -> None:
    cell = ".subckt s a w=1\nr1 a 0 {w}\nr2 a 0 {2*w}\n.ends\n"
    calls = "".join(f"x{k} a{k} s w={k + 1}\n" for k in range(100))
    found = read(cell + calls, Limits(expansion=10, calls=400))
    values = [i.circuit.devices[1].parameters()["resistance"] for i in found.circuit.instances]
    assert values == [2.0 * (k + 1) for k in range(100)]
    with pytest.raises(DataError, match="more than 300 cards of sub-circuits called with other parameters"):
        read(cell + calls, Limits(expansion=10, calls=300))


def test_the_corners_of_all_sources_have_a_limit() -> None:
    sources = "".join(f"v{k} a{k} 0 pulse(0 1 0 1n 1n 1u 10u)\nr{k} a{k} 0 1\n" for k in range(9))
    with pytest.raises(DataError, match=r"netlist:\d+: pulse: 100 of them, the limit is"):
        read(sources + ".tran 1n 1m\n", Limits(vertices=3000))
    read(sources + ".tran 1n 1m\n", Limits(vertices=4000))


def test_defaults_of_a_sub_circuit_count_in_every_call() -> None:
    defaults = " ".join(f"p{k}=1" for k in range(3000))
    calls = "".join(f"x{k} a{k} s p1={k + 1}\n" for k in range(300))
    with pytest.raises(DataError, match="cards of sub-circuits called with other parameters, the limit"):
        read(f".subckt s a {defaults}\nr1 a 0 {{p1}}\n.ends\n{calls}")


@pytest.mark.parametrize("letter", "rcgbmxvi")
@pytest.mark.parametrize("rest", ["=1k", " = 1", "=", "(=1", " =1 =2", "1=0 a=b", " a=1", ""])
@pytest.mark.parametrize(
    "frame", ["{}", ".subckt s a\n{}\n.ends\n", "{}\n.subckt s a\nr1 a 0 1\n.ends\nx1 b s\n"]
)
def test_a_card_without_nodes_is_refused_with_its_place(letter: str, rest: str, frame: str) -> None:
    with pytest.raises(DataError, match=r"^netlist:[23]: "):
        read(frame.format(letter + rest))


def test_a_parameter_without_its_card_is_told_as_one() -> None:
    with pytest.raises(DataError, match=r"^netlist:2: r=: no element; write its nodes first"):
        read("r=1k")


def test_a_reference_with_two_states_is_at_the_one_that_nodeset_names() -> None:
    mirrors = "g1 vdd a x 0 -1m\ng2 vdd b1 x 0 -1m\ng3 vdd r x 0 -1m\nex x 0 b1 a 1e3\n"
    parts = "d1 a 0 dm\nr1 b1 b2 5.4k\nd2 b2 0 dm area=8\nr2 r r3 54k\nd3 r3 0 dm\n.model dm d is=1e-16\n"
    found = read(f"v1 vdd 0 2\n{mirrors}{parts}.nodeset v(a)=0.7 v(b1)=0.7")
    point = operating_point(found.testbench)
    assert point["r"] == pytest.approx(1.1928, abs=1e-3)  # ngspice has 1.19287 V
    assert point["a"] == pytest.approx(0.655, abs=1e-3)
