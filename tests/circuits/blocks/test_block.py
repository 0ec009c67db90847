"""A block's own bench: its defaults, the knobs that are given, and the power that every run has."""

import pytest

from circuits.blocks.sonar import rebound_neuron
from circuits.blocks.sonar.rebound_neuron import BLOCK, Params, build
from circuits.solver.power import supply_power
from circuits.solver.transient import simulate


def test_a_bench_has_the_defaults_but_for_what_is_given() -> None:
    assert BLOCK.defaults == {s.name: s.default for s in BLOCK.stimuli}
    given = BLOCK.defaults | {"echo": None, "duration": 3e-3}
    assert BLOCK.bench(echo=None, duration=3e-3) == rebound_neuron.testbench(build(), given, 5.0)
    larger = build(Params(membrane_capacitance=700e-15))
    assert BLOCK.bench(larger).circuit == larger


def test_the_power_of_the_sources_stands_beside_what_a_block_measures() -> None:
    result = simulate(BLOCK.bench(call=None, echo=None, duration=1e-3))
    found = BLOCK.measured(result)
    assert found == BLOCK.measures(result) | {"supply_power_W": supply_power(result)}
    assert found["supply_power_W"] == pytest.approx(2.5e-6, rel=0.2)
