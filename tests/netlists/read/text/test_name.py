"""Names of a netlist in a circuit."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.circuit import Circuit
from circuits.devices import Resistor
from netlists.read.text.name import circuit_name, original_name

NAMES = st.text(alphabet="abx_0123f-#.[]é", min_size=1, max_size=12)


@pytest.mark.parametrize(
    ("name", "ours"),
    [
        ("out", "out"),
        ("V_Mem", "v_mem"),
        ("1", "_1"),
        ("_1", "__1"),
        ("net-3", "net_x2d_3"),
        ("v_mem#3", "v_mem_x23_3"),
        ("a_x2d_b", "a_x5f_x2d_b"),
        ("v_x", "v_x"),
        ("_", "_"),
    ],
)
def test_the_rule(name: str, ours: str) -> None:
    assert circuit_name(name) == ours
    assert original_name(ours) == name.lower()


@given(NAMES)
def test_every_name_comes_back(name: str) -> None:
    assert original_name(circuit_name(name)) == name.lower()


@given(NAMES, NAMES)
def test_two_names_never_become_one(a: str, b: str) -> None:
    assert (circuit_name(a) == circuit_name(b)) == (a.lower() == b.lower())


@given(NAMES)
def test_a_circuit_takes_every_name(name: str) -> None:
    ours = circuit_name(name)
    circuit = Circuit("c", devices=(Resistor(ours, ours, "0", 1.0),))
    assert circuit.device(ours).terminals() == (ours, "0")
