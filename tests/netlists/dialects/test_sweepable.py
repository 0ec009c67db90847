"""Sweepable transistors: ngspice's own temperature and sizes move them as the solver's do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from circuits.circuit import Circuit, Port
from circuits.devices import Resistor, Source, Transistor
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, ROLLS_180, Process
from circuits.silicon.silicon import Silicon
from circuits.silicon.size import SizeTerms
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench
from netlists.dialects.ngspice import DIALECT
from netlists.dialects.sweepable import Symbol
from netlists.ngspice.run import run
from netlists.registry import Settings, load_dialect

UM = 1e-6
TEMPERATURES = (-20.0, 27.0, 85.0)
OP = Settings("sweepable", "op")
WITHIN = 1e-7  # V: the next point of a sweep stops at reltol, 4e-8 V here


def bench(process: Process, width: float = 6 * UM) -> Testbench:
    """Two mirrors, one behind the other, into a resistor."""
    outputs = (Port(name, "analog", "out") for name in "yz")
    ports = (Port("vdd", "supply"), Port("i", "analog"), *outputs)
    devices = (
        Transistor("mn1", "n", "i", "i", "0", "0", width, 3 * UM),
        Transistor("mn2", "n", "y", "i", "0", "0", 12 * UM, 3 * UM, 2.0),
        Transistor("mp1", "p", "y", "y", "vdd", "vdd", 6 * UM, 3 * UM),
        Transistor("mp2", "p", "z", "y", "vdd", "vdd", 6 * UM, 6 * UM),
        Resistor("r", "z", "0", 1e9),
    )
    drive = (Source("vdd", "vdd", Constant(process.v_dd)), Source("k", "i", Constant(1e-10), "current"))
    return Testbench("mirrors", Circuit("mirrors", ports, devices), drive, 1e-3)


def with_card(text: str, card: str) -> str:
    assert text.count("\n.op\n") == 1
    return text.replace("\n.op\n", f"\n{card}\n")


@pytest.mark.usefixtures("ngspice_library")
@pytest.mark.parametrize("die", [NOMINAL, Die("A", 1003)], ids=str)
@pytest.mark.parametrize("process", [AMI_1500_IDEAL, AMI_1500, ROLLS_180], ids=["ideal", "ami", "rolls"])
def test_a_sweep_of_temperature_is_the_solver_s(process: Process, die: Die) -> None:
    """One text, written at 40 degC, by `.dc temp` and by `.temp`."""
    text = DIALECT.write(bench(process), Silicon(process, 40.0, die), OP)
    swept = run(with_card(text, ".dc temp -20 85 1"))
    assert swept.axis_name == "temp-sweep"
    moved = []
    for degrees in TEMPERATURES:
        own = operating_point(bench(process), Silicon(process, degrees, die)).voltages()
        point = run(with_card(text, f".temp {degrees}\n.op"))
        at = int(np.argmin(np.abs(swept.axis - degrees)))
        for node in ("i", "y", "z"):
            assert swept.values[node][at] == pytest.approx(own[node], abs=WITHIN)
            assert point.values[node][0] == pytest.approx(own[node], abs=WITHIN)
        moved.append(own["i"])
    assert np.ptp(moved) > 0.1  # what a text of one temperature would be off by


@pytest.mark.usefixtures("ngspice_library")
def test_a_size_may_be_a_parameter_of_the_deck() -> None:
    silicon = Silicon(AMI_1500)
    text = DIALECT.write(bench(AMI_1500), silicon, OP)
    card = next(line for line in text.splitlines() if line.startswith("xmn1 "))
    assert " w=6e-06 " in card
    wider = text.replace(card, card.replace("w=6e-06", "w={wide}") + f"\n.param wide={30 * UM!r}")
    found = run(wider)
    own = operating_point(bench(AMI_1500, 30 * UM), silicon).voltages()
    assert found.values["i"][0] == pytest.approx(own["i"], abs=WITHIN)
    assert abs(own["i"] - operating_point(bench(AMI_1500), silicon).voltages()["i"]) > 0.03


@pytest.mark.usefixtures("ngspice_library")
def test_capacitances_are_those_of_the_default_text() -> None:
    """A step of the current into gates of 0.1 pF: a transient, node by node."""
    still = bench(AMI_1500)
    step = Source("k", "i", PiecewiseLinear((0.0, 1e-5, 1.1e-5), (1e-9, 1e-9, 1e-7)), "current")
    moving = replace(still, sources=(still.sources[0], step), stop=1e-4)
    plain, swept = (run(DIALECT.write(moving, Silicon(AMI_1500), Settings(m))) for m in ("ekv", "sweepable"))
    for node in ("i", "y", "z"):
        again = np.interp(plain.axis, swept.axis, swept.values[node])
        assert np.ptp(again) > 0.1
        np.testing.assert_allclose(again, plain.values[node], atol=1e-4)


def test_the_text_says_what_stays_and_the_same_for_every_temperature() -> None:
    cold, warm = (DIALECT.write(bench(AMI_1500), Silicon(AMI_1500, t), OP) for t in (0.0, 60.0))
    assert "\n* all else stays: sources of biases are those of 60.0 degC\n" in warm
    cells = [text[text.index(".subckt") : text.index(".options")] for text in (cold, warm)]
    assert cells[0] == cells[1]


def test_what_cannot_be_swept_is_refused() -> None:
    terms = SizeTerms(UM, 10 * UM, UM, 10 * UM)
    sized = replace(AMI_1500, n=replace(AMI_1500.n, size=terms))
    with pytest.raises(ParameterError, match="sweepable transistors do not"):
        DIALECT.write(bench(sized), Silicon(sized), OP)
    with pytest.raises(ParameterError, match="models: sweepable, xyce has ekv, bsim3"):
        load_dialect("xyce").write(bench(AMI_1500), Silicon(AMI_1500), OP)


def test_symbols_are_joined_as_their_numbers_would_be() -> None:
    x = Symbol("x")
    texts = [-x, x + 1.0, -2.0 + x, x - 1.0, 1.0 - x, 2.0 * x, x * -2.0, 1.0 / x, x / 2.0, x**2, 2.0**x]
    for text, value in zip(texts, (-3, 4, 1, 2, -2, 6, -6, 1 / 3, 1.5, 9, 8), strict=True):
        assert eval(repr(text).replace("^", "**"), {"x": 3.0}) == value  # noqa: S307
