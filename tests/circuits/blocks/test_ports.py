"""Ports of a block: their kind, their direction, their order."""

from circuits.blocks.ports import (
    SUPPLY,
    analog_in,
    analog_out,
    bias_in,
    bias_ports,
    biased,
    event_in,
    event_out,
)
from circuits.circuit import Bias, Port


def test_ports_have_their_kind_and_direction_in_the_order_of_the_names() -> None:
    assert Port("vdd", "supply", "in") == SUPPLY
    assert event_in("b", "a") == (Port("b", "event", "in"), Port("a", "event", "in"))
    assert event_out("spike") == (Port("spike", "event", "out"),)
    assert analog_in("i_in") == (Port("i_in", "analog", "in"),)
    assert analog_out("v_mem") == (Port("v_mem", "analog", "out"),)
    assert bias_in("v_tau") == (Port("v_tau", "bias", "in"),)


def test_a_bias_has_its_port() -> None:
    biases = (Bias("i_tau", "v_tau", "gate", 1e-12, "m1"), Bias("v_ref", "v_ref", "voltage", 2.0))
    assert bias_ports(biases) == bias_in("v_tau", "v_ref")


def test_ports_of_biases_stand_behind_the_others() -> None:
    biases = (Bias("v_ref", "v_ref", "voltage", 2.0), Bias("v_cas", "v_cas", "voltage", 0.7))
    circuit = biased("reference", (SUPPLY,), biases)
    assert circuit.ports == (SUPPLY, *bias_in("v_ref", "v_cas"))
    assert circuit.biases == biases
