"""Models in Verilog-A as a circuit's transistors: beside ngspice's own of the same equations, and ours."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, OperationalAmplifier, Resistor, Source, Transistor
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import CircuitError, ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, POLARITIES
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate as native
from circuits.testbench import Testbench
from netlists.ngspice.deck import run_deck
from netlists.ngspice.engine import upward_crossings
from netlists.verilog_a.host.engine import simulate
from netlists.verilog_a.host.models import read_models
from netlists.verilog_a.host.module import compile_module
from netlists.verilog_a.law import TRANSISTORS, module_text

pytest.importorskip("openvaf_py", reason="no Verilog-A compiler: pip install openvaf-py")

# The model of Shichman and Hodges (1968) as ngspice's level 1 has it, written from its published equations.
LEVEL_1 = """`include "disciplines.vams"
module level_1(d, g, s, b);
  inout d, g, s, b;
  electrical d, g, s, b;
  parameter real sign = 1.0;
  parameter real vto = 0.7;
  parameter real kp = 1e-4;
  parameter real lambda = 0.05;
  parameter real gamma = 0.4;
  parameter real phi = 0.7;
  parameter real w = 1e-6;
  parameter real l = 1e-6;
  real v_ds, v_gs, v_bs, v_on, v_th, beta, i, turned;
  analog begin
    v_ds = sign * V(d, s);
    turned = 1.0;
    v_gs = sign * V(g, s);
    v_bs = sign * V(b, s);
    if (v_ds < 0.0) begin
      turned = -1.0;
      v_ds = -v_ds;
      v_gs = sign * V(g, d);
      v_bs = sign * V(b, d);
    end
    if (v_bs <= 0.0)
      v_th = vto + gamma * (sqrt(phi - v_bs) - sqrt(phi));
    else
      v_th = vto + gamma * (max(0.0, sqrt(phi) - v_bs / (2.0 * sqrt(phi))) - sqrt(phi));
    v_on = v_gs - v_th;
    beta = kp * w / l * (1.0 + lambda * v_ds);
    if (v_on <= 0.0)
      i = 0.0;
    else if (v_on <= v_ds)
      i = 0.5 * beta * v_on * v_on;
    else
      i = beta * v_ds * (v_on - 0.5 * v_ds);
    I(d, s) <+ sign * turned * i;
  end
endmodule
"""
MODELS = """[n]
file = "level_1.va"
[n.parameters]
vto = 0.7
[p]
file = "level_1.va"
[p.parameters]
sign = -1
kp = 4e-5
"""
CARDS = "lambda=0.05 gamma=0.4 phi=0.7 is=1e-25"
RUN = 60e-9


@pytest.fixture
def models(tmp_path: Path) -> Path:
    (tmp_path / "level_1.va").write_text(LEVEL_1)
    (tmp_path / "models.toml").write_text(MODELS)
    return tmp_path / "models.toml"


def ring() -> Testbench:
    devices: list[Transistor | Capacitor] = []
    for k in range(3):
        into, out = f"n{k}", f"n{(k + 1) % 3}"
        devices += [
            Transistor(f"mn{k}", "n", out, into, "0", "0", 6e-6, 1.5e-6),
            Transistor(f"mp{k}", "p", out, into, "vdd", "vdd", 12e-6, 1.5e-6),
            Capacitor(f"c{k}", out, "0", 1e-12),
        ]
    circuit = Circuit("ring", (Port("vdd", "supply"),), tuple(devices))
    source = Source("vdd", "vdd", Constant(5.0))
    return Testbench("ring", circuit, (source,), RUN, initial={"n0": 0.0, "n1": 5.0})


def period(time: np.ndarray, wave: np.ndarray) -> float:
    return float(np.diff(upward_crossings(time, wave, 2.5))[-1])


@pytest.mark.usefixtures("ngspice_library")
def test_a_ring_of_three_has_the_period_of_ngspice_s_own_level_1(models: Path, tmp_path: Path) -> None:
    cards = [
        f".model {p}ch {p}mos level=1 vto={v} kp={k} {CARDS}"
        for p, v, k in (("n", 0.7, 1e-4), ("p", -0.7, 4e-5))
    ]
    lines = [
        line
        for k in range(3)
        for into, out in [(f"n{k}", f"n{(k + 1) % 3}")]
        for line in (
            f"mn{k} {out} {into} 0 0 nch w=6u l=1.5u",
            f"mp{k} {out} {into} vdd vdd pch w=12u l=1.5u",
            f"c{k} {out} 0 1p",
        )
    ]
    deck = tmp_path / "ring.cir"
    run = f".tran 20p {RUN} 0 20p\n.ic v(n0)=0 v(n1)=5\n.options reltol=1e-5 method=gear\n.end\n"
    deck.write_text("\n".join(["ring", *cards, "vdd vdd 0 5", *lines, run]))
    theirs = run_deck(deck, "tran", deadline_s=60.0)
    ours = simulate(ring(), read_models(models), rtol=3e-4)
    assert period(ours.time, ours["n0"]) == pytest.approx(period(theirs.axis, theirs.values["n0"]), rel=1e-3)


def test_our_own_law_in_verilog_a_runs_as_in_the_solver(tmp_path: Path) -> None:
    """An inverter's edges, within the tolerance of the looser of both runs."""
    for polarity in POLARITIES:
        text = '`include "disciplines.vams"\n' + module_text(TRANSISTORS[polarity], Silicon(AMI_1500))
        (tmp_path / f"{polarity}.va").write_text(text)
    table = "".join(f'[{p}]\nfile = "{p}.va"\nmultiplicity = "m"\n' for p in POLARITIES)
    (tmp_path / "own.toml").write_text(table)
    ports = (Port("vdd", "supply"), Port("a", "analog"))
    devices = (
        Transistor("mn", "n", "y", "a", "0", "0", 6e-6, 3e-6, 2.0),
        Transistor("mp", "p", "y", "a", "vdd", "vdd", 12e-6, 3e-6),
        Capacitor("c", "y", "0", 1e-12), Resistor("r", "y", "0", 1e7),
    )  # fmt: skip
    wave = PiecewiseLinear((0.0, 1e-8, 1.1e-8, 5e-8, 5.1e-8), (0.0, 0.0, 5.0, 5.0, 0.0))
    sources = (Source("vdd", "vdd", Constant(5.0)), Source("a", "a", wave))
    bench = Testbench("inverter", Circuit("inverter", ports, devices), sources, 1e-7, watch=("y",))
    ours, theirs = (
        native(bench, Silicon(AMI_1500)),
        simulate(bench, read_models(tmp_path / "own.toml"), rtol=1e-4),
    )
    at = np.interp(theirs.time, ours.time, ours["y"])
    assert np.abs(at - theirs["y"]).max() < 0.02  # V, on edges of 1 ns
    assert theirs.spikes["y"] == pytest.approx(ours.spikes["y"], abs=2e-11)


def test_a_module_s_derivatives_are_those_of_its_currents(models: Path) -> None:
    module = compile_module(models.parent / "level_1.va")
    given, v = module.given({"w": 6e-6}, 27.0), np.array([1.0, 2.0, 0.3, -0.5])
    found = module.evaluate(given, v)
    for k in range(4):
        moved = [module.evaluate(given, v + sign * 1e-6 * np.eye(4)[k]).current for sign in (1.0, -1.0)]
        assert (moved[0] - moved[1]) / 2e-6 == pytest.approx(found.conductance[:, k], rel=1e-6, abs=1e-12)
    assert found.current.sum() == pytest.approx(0.0, abs=1e-18)


@pytest.mark.parametrize("turned", [1.0, -1.0])
def test_a_parameter_of_the_type_integer_is_one(turned: float, tmp_path: Path) -> None:
    text = LEVEL_1.replace("parameter real sign = 1.0;", "parameter integer sign = 1 from [-1:1] exclude 0;")
    (tmp_path / "a.va").write_text(text)
    module = compile_module(tmp_path / "a.va")
    found = module.evaluate(module.given({"sign": turned}, 27.0), turned * np.array([2.0, 1.7, 0.0, 0.0]))
    assert found.current[0] == pytest.approx(turned * 0.5e-4 * (1.0 + 0.05 * 2.0))
    with pytest.raises(ParameterError, match=r"^level_1.sign: 0.5, must be a whole number"):
        module.given({"sign": 0.5}, 27.0)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("level_1.va", "none.va", r"none.va: no such file; name one of Verilog-A"),
        ("vto = 0.7", "vt0 = 0.7", r"level_1 parameter vt0: unknown"),
        ("[p]\nfile", "[p]\nfiles", r"no \[p\] with a file"),
        ("kp = 4e-5", 'kp = "4e-5"', r"kp: '4e-5', must be a number"),
    ],
)
def test_models_that_are_none_are_refused(models: Path, old: str, new: str, says: str) -> None:
    models.write_text(models.read_text().replace(old, new))
    with pytest.raises(CircuitError, match=says) as caught:
        read_models(models)
    assert "\n" not in str(caught.value)


def test_what_cannot_stand_beside_models_is_refused(models: Path) -> None:
    found = read_models(models)
    with pytest.raises(ParameterError, match=r"models in Verilog-A have no dies here"):
        simulate(ring(), found, Silicon(die=Die(number=1000)))
    amplifier = OperationalAmplifier("x1", "n0", "o", "o", "vdd")
    load = Resistor("r", "o", "0", 1e4)
    circuit = ring().circuit
    mixed = replace(circuit, devices=(*circuit.devices, amplifier, load))
    with pytest.raises(ParameterError, match=r"^x1: an amplifier"):
        simulate(replace(ring(), circuit=mixed), found)
