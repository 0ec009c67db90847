"""Measures of a run against ngspice's own `.measure` of the same circuit in ngspice."""

import re

import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Source
from circuits.devices.source import Pulse
from circuits.measure.measure import measure
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from netlists.dialects.ngspice import format_testbench
from netlists.ngspice.deadline import DEADLINE
from netlists.ngspice.library import simulated
from tests.circuits.solver.examples import SUPPLY, inverter

pytestmark = pytest.mark.usefixtures("ngspice_library")

WAVE = Pulse(0.0, 5.0, (10e-6, 50e-6, 90e-6), 15e-6, 1e-6, 2e-6)
BENCH = Testbench(
    "inverter",
    Circuit(
        "inverter", (Port("vdd", "supply"), Port("a", "analog"), Port("y", "analog", "out")),
        (*inverter("i", "a", "y"), Capacitor("c", "y", "0", 500e-12)),
    ),
    (SUPPLY, Source("a", "a", WAVE)),
    120e-6,
)  # fmt: skip
# ours, ngspice's card, and how far they may be apart: ngspice joins its points, 20 ns apart, by lines
PAIRS = {
    "t1": ("cross(y, 2.5, fall, 2)", "when v(y)=2.5 fall=2", 2e-9),
    "t2": (
        "cross(y, 1, fall) - cross(a, 2.5, rise)", "trig v(a) val=2.5 rise=1 targ v(y) val=1 fall=1", 2e-9
    ),
    "t3": ("cross(y, 2.5, either, last)", "when v(y)=2.5 cross=last", 2e-9),
    "v1": ("mean(y, from=5us, to=60us)", "avg v(y) from=5u to=60u", 5e-3),
    "v2": ("rms(y, from=5us, to=60us)", "rms v(y) from=5u to=60u", 1e-3),
    "v3": ("max(y, from=20us, to=45us)", "max v(y) from=20u to=45u", 2e-4),
    "v4": ("min(y)", "min v(y)", 2e-4),
    "v5": ("swing(y, from=5us, to=45us)", "pp v(y) from=5u to=45u", 2e-4),
    "v6": ("value(y, at=cross(a, 2.5, fall))", "find v(y) when v(a)=2.5 fall=1", 2e-4),
    "v7": ("value(y, at=11.5us)", "find v(y) at=11.5u", 5e-4),
    "q1": ("integral(y, from=5us, to=60us)", "integ v(y) from=5u to=60u", 1e-8),
}  # fmt: skip


def test_measures_agree_with_those_of_ngspice() -> None:
    silicon = Silicon()
    cards = "".join(f"\n.meas tran {name} {card}" for name, (_, card, _) in PAIRS.items())
    head, _, _ = format_testbench(BENCH, silicon, reltol=1e-5, tmax=2e-8).rpartition("\n.end")
    with simulated(f"{head}{cards}\n.end\n", DEADLINE) as library:
        said = "\n".join(library.output)
    theirs = {m[1]: float(m[2]) for m in re.finditer(r"^(\w\d)\s+=\s+(\S+)", said, re.MULTILINE)}
    ours = measure(simulate(BENCH, silicon), *(f"{name} = {text}" for name, (text, _, _) in PAIRS.items()))
    assert theirs.keys() == ours.keys()
    apart = {name: abs(ours[name].value - theirs[name]) for name in theirs}
    assert {name: apart[name] for name in PAIRS if apart[name] > PAIRS[name][2]} == {}
