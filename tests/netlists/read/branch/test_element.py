"""Inductors, controlled voltages and sources between two nodes: the laws that they stand for."""

import numpy as np
import pytest

from circuits.checks import implausible_allowed
from circuits.errors import DataError
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.small_signal import ac
from circuits.solver.transient import Result, simulate
from netlists.compare.circuits import compare
from netlists.read import read_netlist
from netlists.read.branch.element import RESISTANCE
from netlists.registry import Settings, dialect_names, load_dialect
from tests.refusals import refusals


def volts(text: str) -> dict[str, float]:
    return operating_point(read_netlist("t\n" + text).testbench).voltages()


def run(text: str) -> Result:
    return simulate(read_netlist("t\n" + text).testbench)


def test_a_source_between_two_nodes_holds_their_difference_and_has_a_current() -> None:
    found = volts("v1 a 0 3\nr1 a b 1k\nv2 b c 1\nr2 c 0 1k")
    assert found["b"] - found["c"] == pytest.approx(1.0 + 1e-3 * RESISTANCE, abs=1e-12)
    assert found["v2_x23_branch"] == pytest.approx(1e-3, rel=1e-6)


@pytest.mark.parametrize(("card", "volt"), [("e1 x 0 b 0 -2", -3.0), ("h1 x 0 v1 500", -0.75)])
def test_a_voltage_follows_a_voltage_or_a_current(card: str, volt: float) -> None:
    found = volts(f"v1 a 0 3\nr1 a b 1k\nl1 b c 1m\nr2 c 0 1k\n{card}")
    assert found["x"] == pytest.approx(volt, rel=1e-6)
    assert found["b"] == pytest.approx(1.5, rel=1e-6)


def test_a_current_follows_a_current_out_of_its_first_node() -> None:
    assert volts("v1 a 0 1\nr1 a 0 1k\nf1 g 0 v1 2\nr2 g 0 1k")["g"] == pytest.approx(2.0, rel=1e-6)


def test_an_ideal_amplifier_in_its_loop_has_its_virtual_ground() -> None:
    found = volts("v1 a 0 1\nr1 a n 1k\nr2 n o 10k\ne1 o 0 0 n 1e5")
    assert found["o"] == pytest.approx(-10.0 / (1.0 + 11.0e-5), rel=1e-7)


def test_a_series_resonance_rings_as_its_equation_says() -> None:
    found = run("v1 a 0 pwl(0 0 1u 0 1.001u 1)\nr1 a b 100\nl1 b c 1m\nc1 c 0 1n\n.tran 10n 40u")
    time, damping = found.time - 1.0005e-6, 5e4
    omega = np.sqrt(1e12 - damping**2)
    ringing = np.exp(-damping * time) * (np.cos(omega * time) + damping / omega * np.sin(omega * time))
    # 13 cycles of a method of second order; its phase is off by 1e-4 of a cycle
    assert np.abs(found["c"] - np.where(time > 0.0, 1.0 - ringing, 0.0)).max() < 2e-3


def test_sources_in_a_loop_with_capacitors_alone_run() -> None:
    found = run("v1 a 0 pwl(0 0 1u 1)\nv2 b a 0.5\nc1 b 0 1p\ne1 c 0 b 0 2\nc2 c 0 1p\n.tran 10n 1u")
    assert found["c"][-1] == pytest.approx(3.0, abs=1e-6)


def test_small_signals_pass_by_a_source_between_two_nodes() -> None:
    bench = read_netlist("t\nv1 a 0 1\nr1 a b 1k\nv2 b c 0.5 ac 1\nr2 c 0 1k").testbench
    found = ac(operating_point(bench), "v2", np.array([1e3]), ["c"])
    assert abs(found.transfer[0, 0]) == pytest.approx(0.5, rel=1e-6)


def test_a_resonance_in_small_signals() -> None:
    bench = read_netlist("t\nv1 a 0 1\nr1 a b 100\nl1 b c 1m\nc1 c 0 1n").testbench
    frequency = np.geomspace(1e4, 1e6, 21)
    found = ac(operating_point(bench), "v1", frequency, ["c"]).transfer[:, 0]
    s = 2j * np.pi * frequency
    assert found == pytest.approx(1.0 / (1.0 + s * 1e-7 + s**2 * 1e-12), rel=1e-9)


@pytest.mark.parametrize("value", ["100k", "1e-15"])
def test_an_implausible_inductance_is_told_in_henry(value: str) -> None:
    with pytest.raises(
        DataError, match=rf"netlist:3: l1\.inductance: {float(value.replace('k', 'e3')):g} H, must be"
    ):
        read_netlist(f"t\nv1 a 0 1\nl1 a b {value}\nr1 b 0 1k\n.end\n")
    with implausible_allowed():
        assert read_netlist(f"t\nv1 a 0 1\nl1 a b {value}\nr1 b 0 1k\n.end\n").circuit.devices


def test_a_deck_with_branches_is_exported_and_read_back_equal() -> None:
    text = "t\nv1 a 0 3\nv2 a b 1\nl1 b c 1m\nr1 c 0 1k\nf1 0 d v2 2\nr2 d 0 1k\nc1 c 0 1p\n.tran 1n 1u"
    bench = read_netlist(text).testbench
    for name in dialect_names():
        if name == "verilog-a":
            continue
        written = load_dialect(name).write(bench, Silicon(), Settings())
        assert compare(bench.circuit, read_netlist(written).circuit).equal, name


test_what_no_circuit_can_hold = refusals(
    DataError,
    lambda text: read_netlist("t\n" + text),
    [
        ("f1 a 0 vx 2\nr1 a 0 1", "netlist:2: f1: no source vx beside it; name a V of the same sub-circuit"),
        ("e1 a 0 poly(1) b 0 1 2\nr1 a b 1", "netlist:2: e1: a voltage source that another voltage controls"),
        ("l1 a 0 0\nr1 a 0 1", "netlist:2: l1.inductance: 0 H, must be > 0"),
        ("l1 a 0 1u ic=1\nr1 a 0 1\n.tran 1u 1m uic", "netlist:2: l1.ic: a current to begin with"),
    ],
)
