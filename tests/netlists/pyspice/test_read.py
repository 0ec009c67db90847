"""PySpice circuits taken over: a mirror in a sub-circuit, sources, names, and all that is refused."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from PySpice.Spice.Netlist import Circuit as PySpiceCircuit
from PySpice.Spice.Netlist import SubCircuit
from PySpice.Unit import u_kOhm, u_ms, u_pF, u_um, u_V

from circuits.circuit import Circuit, Instance, Port
from circuits.devices import Capacitor, Diode, Resistor, Source, Transistor
from circuits.devices.source import Constant, PiecewiseLinear, Pulse
from circuits.errors import CircuitError, DataError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from netlists.pyspice.read import from_pyspice
from netlists.pyspice.write import pyspice_simulator, to_pyspice


def mirror() -> SubCircuit:
    sub = SubCircuit("Mirror", "in", "out")
    sub.M(1, "in", "in", sub.gnd, sub.gnd, model="nch", width=3 @ u_um, length=6e-6)
    sub.M(2, "OUT", "IN", sub.gnd, sub.gnd, model="NCH", w=6e-6, l=6e-6, m=2, ad=1e-12)
    return sub


def circuit() -> PySpiceCircuit:
    """A low-pass of 10 kOhm and 3 pF into the diode of a mirror, whose output has a load."""
    c = PySpiceCircuit("a mirror's test")
    c.model("nch", "NMOS")
    c.subcircuit(mirror())
    c.V("dd", "VDD", c.gnd, 5.0)
    c.R("feed", "vdd", 1, 10 @ u_kOhm)
    c.C("1", 1, c.gnd, 3 @ u_pF)
    c.R("series", 1, "diode", "10MEG")
    c.R("load", "vdd", "out+", 1e6)
    c.X("m", "mirror", "diode", "out+")
    return c


EXPECTED_MIRROR = Circuit(
    "Mirror",
    (Port("in", "analog"), Port("out", "analog")),
    (
        Transistor("M1", "n", "in", "in", "0", "0", 3e-6, 6e-6),
        Transistor("M2", "n", "out", "in", "0", "0", 6e-6, 6e-6, 2.0),
    ),
)


def test_a_mirror_in_a_sub_circuit_comes_back_as_ours() -> None:
    found = from_pyspice(circuit(), stop=1e-3)
    expected = Circuit(
        "a_mirror_s_test",
        (Port("VDD", "supply"),),
        (
            Resistor("Rfeed", "VDD", "n1", 1e4), Capacitor("C1", "n1", "0", 3e-12),
            Resistor("Rseries", "n1", "diode", 1e7), Resistor("Rload", "VDD", "out_", 1e6),
        ),
        (Instance("Xm", EXPECTED_MIRROR, {"in": "diode", "out": "out_"}),),
    )  # fmt: skip
    assert found == Testbench("a mirror's test", expected, (Source("Vdd", "VDD", Constant(5.0)),), 1e-3)


@pytest.mark.usefixtures("ngspice_library")
def test_what_comes_back_works_in_the_solver_and_again_in_pyspice() -> None:
    bench = from_pyspice(circuit(), stop=1e-6)
    point = operating_point(bench, Silicon(AMI_1500_IDEAL))
    # drawn by a diode of W/L 1/2 through 10 MOhm; the output's devices are 4 times as wide together
    drawn, copied = (5.0 - point["diode"]) / 10.01e6, (5.0 - point["out_"]) / 1e6
    assert copied == pytest.approx(4.0 * drawn, rel=1e-3)
    theirs = pyspice_simulator(to_pyspice(bench, Silicon(AMI_1500_IDEAL))).operating_point()
    assert float(np.asarray(theirs["xa_mirror_s_test.diode"])[0]) == pytest.approx(point["diode"], abs=1e-4)


def sources() -> PySpiceCircuit:
    c = PySpiceCircuit("sources")
    for node in "abcdef":
        c.R(node, node, c.gnd, 1e3)
    pulse = {"initial_value": 0 @ u_V, "pulsed_value": 5.0, "pulse_width": 1 @ u_ms, "rise_time": 1e-6,
             "fall_time": 1e-6, "delay_time": 1e-3}  # fmt: skip
    c.PulseVoltageSource("train", "a", c.gnd, period=4 @ u_ms, **pulse)
    c.PieceWiseLinearVoltageSource("ramp", c.gnd, "b", values=[(0, 0), (1 @ u_ms, 5 @ u_V)])
    c.V("text", "c", c.gnd, 0.0, raw_spice="pwl(0 0 1m 5)")
    c.I("out", "d", c.gnd, 1e-3)
    c.I("in", c.gnd, "e", 1e-3)
    c.PulseCurrentSource("once", "0", "f", period=0, **{**pulse, "initial_value": 1e-3, "pulsed_value": 2e-3})
    return c


def test_sources_become_stimuli_with_their_signs() -> None:
    bench = from_pyspice(sources(), stop=10e-3)
    waves = {s.name: s.waveform for s in bench.sources}
    assert waves["Vtrain"] == Pulse(0.0, 5.0, (1e-3, 5e-3, 1e-3 + 2 * 4e-3), 1e-3, 1e-6, 1e-6)
    assert waves["Vramp"] == PiecewiseLinear((0.0, 1e-3), (-0.0, -5.0))
    assert waves["Vtext"] == PiecewiseLinear((0.0, 1e-3), (0.0, 5.0))
    assert waves["Iout"] == Constant(-1e-3)
    assert waves["Iin"] == Constant(1e-3)
    assert waves["Ionce"] == Pulse(1e-3, 2e-3, (1e-3,), 1e-3, 1e-6, 1e-6)
    assert {p.kind for p in bench.circuit.ports} == {"analog"}


@pytest.mark.usefixtures("ngspice_library")
def test_stimuli_are_what_ngspice_makes_of_them() -> None:
    ours = simulate(from_pyspice(sources(), stop=10e-3), Silicon(AMI_1500_IDEAL))
    theirs = pyspice_simulator(sources()).transient(step_time=1e-5, end_time=10e-3, max_time=1e-5)
    time = np.asarray(theirs.time)
    # both begin the ramp of a pulse a moment apart in rounding, so that its edges are left out
    flat = np.ones(time.size, dtype=bool)
    for edge in (1e-3, 2e-3, 5e-3, 6e-3, 9e-3, 10e-3):
        flat &= np.abs(time - edge) > 5e-6
    for node in "abcdef":
        found = np.interp(time, ours.time, ours[node])
        np.testing.assert_allclose(found[flat], np.asarray(theirs[node])[flat], atol=1e-6)


def test_a_dc_value_beside_a_waveform_goes_both_ways() -> None:
    theirs = PySpiceCircuit("divider")
    theirs.V("in", "a", theirs.gnd, 1.0, raw_spice="pwl(0 0 1m 5)")
    theirs.R(1, "a", "b", 1e3)
    theirs.R(2, "b", theirs.gnd, 1e3)
    bench = from_pyspice(theirs, stop=2e-3)
    assert operating_point(bench)["b"] == pytest.approx(0.5, rel=1e-9)
    again = from_pyspice(to_pyspice(bench, Silicon(AMI_1500_IDEAL)), stop=2e-3)
    assert operating_point(again)["Xdivider.b"] == pytest.approx(0.5, rel=1e-9)
    assert simulate(again)["Xdivider.b"][0] == pytest.approx(0.0, abs=1e-9)


def test_names_that_collide_get_numbers() -> None:
    c = PySpiceCircuit("2 things")
    c.V("1", "a+", c.gnd, 1.0)
    c.R("1", "a+", "a-", 1e3)
    c.R("2", "a-", "a_", 1e3)
    c.R("3", "A_", "GND", 1e3)
    bench = from_pyspice(c)
    assert bench.circuit.name == "n2_things"
    assert [d.terminals() for d in bench.circuit.devices] == [("a_", "a__2"), ("a__2", "a__3"), ("a__3", "0")]


def test_a_model_from_outside_is_told() -> None:
    c = PySpiceCircuit("t")
    c.M(1, "d", "d", c.gnd, c.gnd, model="nfet_03v3", w=1e-6, l=1e-6)
    found = from_pyspice(c, polarities={"NFET_03V3": "n"}).circuit.devices
    assert found == (Transistor("M1", "n", "d", "d", "0", "0", 1e-6, 1e-6),)


@pytest.mark.parametrize("outside", [True, False])
def test_a_model_with_figures_of_its_own_is_refused_unless_it_may_go(outside: bool) -> None:
    sub = SubCircuit("sub", "a")
    c = PySpiceCircuit("t")
    (c if outside else sub).model("NCH", "nmos", level=1, kp=20e-6)
    sub.M(1, "a", "a", sub.gnd, sub.gnd, model="nch", w=1e-6, l=1e-6)
    c.subcircuit(sub)
    c.X("1", "sub", "a")
    with pytest.raises(DataError, match=r"sub\.M1: \.model nch: parameters level, kp: not honoured; .*drop="):
        from_pyspice(c)
    for drop in (["NCH"], [".model"], ["other,nch"]):
        inner = from_pyspice(c, drop=drop).circuit.instances[0].circuit
        assert inner.devices == (Transistor("M1", "n", "a", "a", "0", "0", 1e-6, 1e-6),)


def with_sub(change: Callable[[Any], object]) -> Callable[[Any], object]:
    def build(c: Any) -> None:
        sub = SubCircuit("sub", "a")
        change(sub)
        c.subcircuit(sub)
        c.X("1", "sub", "a")

    return build


def parameters(sub: Any) -> None:
    sub.parameters["r"] = 1


@pytest.mark.parametrize(
    ("build", "words"),
    [
        (lambda c: c.Q(1, "a", "b", c.gnd, model="q"), r"t\.Q1: Bipolar\w+, must be one of R C D V I M X"),
        (lambda c: c.B(1, "a", "0", v="1"), r"t\.B1: BehavioralSource, must"),
        (lambda c: c.SinusoidalVoltageSource("s", "a", "0"), r"t\.Vs: SinusoidalVoltageSource, must"),
        (lambda c: c.R(1, "a", "0", 1e3, raw_spice="tc=1"), r"t\.R1: raw text 'tc=1'"),
        (lambda c: c.R(1, "a", "0", "{r}"), r"t\.R1\.resistance: '\{r\}', must be a number"),
        (lambda c: c.R(1, "a", "0", -1.0), r"R1\.resistance: -1 Ohm|R1\.resistance: -1 ohm"),
        (lambda c: c.M(1, "a", "a", "0", "0", model="n", w=1e-6), r"t\.M1: model n: unknown"),
        (lambda c: (c.model("n", "nmos"), c.M(1, "a", "a", "0", "0", model="n", w=1e-6)),
         r"M1\.length: missing"),
        (lambda c: c.V(1, "a", "b", 1.0), r"t\.V1: from a to b, must have one end at ground"),
        (lambda c: c.V(1, "a", "0", 1.0, raw_spice="sin(0 1 1k)"), r"t\.V1: raw text"),
        (lambda c: c.V(1, "a", "0", 1.0, raw_spice="pwl(0 0 1)"), r"t\.V1: 3 numbers, must be pairs"),
        (lambda c: c.PulseVoltageSource(
            1, "a", "0", initial_value=0, pulsed_value=1, pulse_width=1, period=2
        ), r"inf pulses until inf s"),
        (lambda c: c.X(1, "none", "a"), r"t\.X1: sub-circuit none: unknown"),
        (lambda c: c.include("models.lib"), r"t: include models\.lib"),
        (lambda c: c.parameter("r", 1), r"t: parameter r"),
        (lambda c: setattr(c, "raw_spice", "R1 a 0 1"), r"t: raw text in the netlist"),
        (with_sub(lambda s: s.V(1, "a", "0", 1.0)), r"t\.sub\.V1: a source in a sub-circuit"),
        (with_sub(lambda s: s.X(1, "sub", "a")), r"sub-circuit sub contains itself"),
        (with_sub(parameters), r"sub: parameters \['r'\]"),
        (lambda c: (c.subcircuit(mirror()), c.model("nch", "nmos"), c.X(1, "mirror", "a")),
         r"t\.X1: 1 nodes, must be 2"),
        (lambda c: (c.subcircuit(mirror()), c.model("nch", "nmos"), c.X(1, "mirror", "a", "b", k=1)),
         r"t\.X1: parameters \['k'\]"),
    ],
)  # fmt: skip
def test_what_would_be_lost_is_refused_by_name(build: Callable[[Any], object], words: str) -> None:
    c = PySpiceCircuit("t")
    build(c)
    with pytest.raises(CircuitError, match=words) as refused:
        from_pyspice(c)
    assert "\n" not in str(refused.value)


def test_a_diode_comes_by_its_model_and_goes_back() -> None:
    c = PySpiceCircuit("a clamp")
    c.V("in", "in", c.gnd, 5.0)
    c.R("1", "in", "out", 1e3)
    c.D("1", "out", c.gnd, model="Fast", area=2)
    c.model("Fast", "D", IS=1e-12, N=1.5, RS="10", CJO=2 @ u_pF)
    found = from_pyspice(c, stop=1e-6)
    diode = Diode("D1", "d1_x23_internal", "0", 2.0, 1e-12, 1.5, 2e-12, breakdown_emission=1.5)
    series = Resistor("d1_x23_rs", "out", "d1_x23_internal", 5.0)
    assert found.circuit.devices == (Resistor("R1", "in", "out", 1e3), diode, series)
    again = to_pyspice(found, Silicon(AMI_1500_IDEAL))
    analysis = again.simulator(gmin=1e-18).operating_point()
    ours = operating_point(found, Silicon(AMI_1500_IDEAL))["out"]
    assert float(np.asarray(analysis[again.run_names["out"]])[0]) == pytest.approx(ours, abs=1e-5)
    c.model("Bad", "D", IKF=1.0)
    c.D("2", "out", c.gnd, model="Bad")
    with pytest.raises(DataError, match=r"^a clamp.D2: model Bad.ikf: 1, not covered but for 0"):
        from_pyspice(c)
