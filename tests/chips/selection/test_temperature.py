"""A selection at whose second decision the temperature is another, against its transistors."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.selection.model import decision, selection
from circuits.bias import rebias
from circuits.blocks.selection import winner_take_all as block
from circuits.circuit import BiasKind
from circuits.devices import Source
from circuits.devices.source import PiecewiseLinear
from circuits.silicon.course import Course
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon
from circuits.solver.temperature import simulate_course

SMALL = block.Params(cells=8)
SILICON = Silicon(AMI_1500, die=Die(number=1001))
EXCITE, RISK = np.linspace(40e-9, 50e-9, 8), np.full(8, block.STANDING)
DECIDED, AGAIN, STEP = 60e-6, 1e-3, 100e-6  # s: equalised anew, released anew, and of the temperature
STOP = AGAIN + 50e-6


@pytest.mark.parametrize(("kind", "to"), [("gate", 7.0), ("gate", 47.0), ("generator", 47.0)])
def test_a_decision_after_a_step_of_20_degrees_is_the_circuit_s(kind: BiasKind, to: float) -> None:
    circuit, v_dd = rebias(block.build(SMALL), kind=kind), AMI_1500.v_dd
    first, second = (
        decision(selection(replace(SILICON, temperature_c=t), SMALL, circuit), EXCITE, RISK)
        for t in (27.0, to)
    )
    bench = block.decision_testbench(circuit, EXCITE, RISK, STOP, v_dd)
    edges = [(0.0, v_dd)]
    for at, level in ((block.RELEASE, 0.0), (DECIDED, v_dd), (AGAIN, 0.0)):
        edges += [(at, edges[-1][1]), (at + block.EDGE, level)]
    times, volts = zip(*edges, strict=True)
    equalise = Source("equalise", "equalise", PiecewiseLinear(times, volts))
    sources = tuple(equalise if s.name == "equalise" else s for s in bench.sources)
    course = Course(((0.0, 27.0), (STEP - 1e-7, 27.0), (STEP, to)))
    found = simulate_course(replace(bench, sources=sources), SILICON, course)
    assert block.lines_high(found).tolist() == [second.winner] == [first.winner]
    rises = found.spikes[f"line[{second.winner}]"]
    theirs = [float(rises[rises < DECIDED][-1]) - block.RELEASE, float(rises[-1]) - AGAIN]
    assert second.time == pytest.approx(theirs[1], rel=0.03)
    assert first.time == pytest.approx(theirs[0], rel=0.03)
    if kind == "gate":
        assert theirs[1] != pytest.approx(theirs[0], rel=0.06)
