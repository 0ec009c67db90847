"""A plastic weight is moved by spikes, drifts to its nearer rail, stays there, and gates a current."""

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.blocks.rest import started_at_rest
from circuits.blocks.rolls.bias import current_of
from circuits.blocks.rolls.plastic_synapse import BIASES, BLOCK, DRIFT_DOWN, DRIFT_UP, Params, build
from circuits.circuit import BiasKind
from circuits.devices import Source
from circuits.devices.source import Constant
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.power import supply_power
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench

C_W = Params().weight_capacitance
COMPARATOR = float(np.ravel(next(b.value for b in BIASES if b.name == "i_cmp"))[0])  # A


def run(
    up: float, events: float, silicon: Silicon | None = None, kind: BiasKind = "gate",
    biases: dict[str, float] | None = None, duration: float | None = None,
) -> Result:  # fmt: skip
    values = {"up": up, "events": events, "rate": 200.0, "duration": duration}
    circuit = rebias(build(), biases or {}, kind)
    on = Silicon(ROLLS_180_IDEAL) if silicon is None else silicon
    return simulate(BLOCK.testbench(circuit, values, 1.8), on)


def test_jumps_go_with_the_current_and_either_way() -> None:
    once, down = (BLOCK.measures(run(up, 1.0))["jump_V"] for up in (1.0, -1.0))
    twice = BLOCK.measures(run(1.0, 1.0, biases={"i_up": 2.0 * current_of((4, 30))}))["jump_V"]
    assert once is not None
    assert once == pytest.approx(0.163, rel=0.02)
    # as far either way, but for the capacitances of the junctions, which are the rails'
    assert down == pytest.approx(-once, rel=0.02)
    assert twice == pytest.approx(2.0 * once, rel=0.03)


def test_an_allowed_event_is_needed() -> None:
    jump = BLOCK.measures(run(0.0, 1.0))["jump_V"]
    assert jump is not None
    assert abs(jump) < 1e-3


def test_enough_events_flip_the_weight_and_it_drifts_to_the_nearer_rail() -> None:
    few, many = run(1.0, 3.0), run(1.0, 7.0)
    assert (BLOCK.outcome(few), BLOCK.outcome(many)) == ("low", "high")
    back, on = (BLOCK.measures(r)["drift_V_per_s"] for r in (few, many))
    # off currents of the other stacks take 15 and 9 % of 0.41 and 0.47 pA, and w's own devices add 6 % to C_w
    assert back == pytest.approx(-current_of(DRIFT_DOWN) / C_W, rel=0.25)
    assert on == pytest.approx(current_of(DRIFT_UP) / C_W, rel=0.25)


@pytest.mark.parametrize("start", [1.0, -1.0])
def test_a_rail_is_kept(start: float) -> None:
    # up 1 begins at ground: nothing is allowed, so the weight stays where it is
    result = run(start, 1.0, biases={"i_up": 1e-15, "i_dn": 1e-15}, duration=1.0)
    rail = 0.0 if start > 0 else 1.8
    assert result["w"][-1] == pytest.approx(rail, abs=0.03)


def still(weight: float, temperature: float = 27.0) -> Result:
    """A weight held at `weight` V, without events, from its state of rest."""
    volts = {"vdd": 1.8, "event": 0.0, "up_b": 1.8, "dn": 0.0, "line": 0.9, "w": weight}
    sources = tuple(Source(name, name, Constant(v)) for name, v in volts.items())
    bench = Testbench("still", rebias(build(), {}, "ideal"), sources, 2e-3)
    return simulate(started_at_rest(bench, ROLLS_180_IDEAL), Silicon(ROLLS_180_IDEAL, temperature))


@pytest.mark.parametrize(("weight", "branches"), [(0.0, 1), (0.85, 2), (0.95, 1), (1.8, 1)])
def test_a_weight_at_rest_takes_its_comparators_current(weight: float, branches: int) -> None:
    result = still(weight)
    # the branches of I_cmp that are on; extender and switches leak 31 to 36 pW
    held = branches * 1.8 * COMPARATOR
    assert held < supply_power(result) < held + 45e-12
    # leaks against I_cmp: 0.8 mV seen
    assert result["low"][-1] == pytest.approx(1.8 if weight < 0.9 else 0.0, abs=3e-3)


def test_a_warm_weight_leaks_and_keeps_its_bit() -> None:
    result = still(1.8, 60.0)
    # 81 pW are the comparator's, 0.32 nW leaks
    assert supply_power(result) < 0.5e-9
    assert result["low"][-1] < 0.02


def test_only_a_high_weight_draws_a_current() -> None:
    low, high = (BLOCK.measures(run(up, 1.0))["charge_C"] for up in (1.0, -1.0))
    assert low is not None
    assert high is not None
    assert high > 20.0 * abs(low)


def test_a_generator_holds_the_drift_and_dies_differ() -> None:
    warm = Silicon(ROLLS_180_IDEAL, 50.0)
    gate, generator = (BLOCK.measures(run(1.0, 1.0, warm, k))["drift_V_per_s"] for k in ("gate", "ideal"))
    usual = BLOCK.measures(run(1.0, 1.0))["drift_V_per_s"]
    assert gate is not None
    assert generator is not None
    assert usual is not None
    assert abs(gate / usual) > 2.0
    # the off currents grow with temperature and take a part
    assert 0.6 < generator / usual < 1.1
    a, b = (
        BLOCK.measures(run(1.0, 1.0, Silicon(ROLLS_180_IDEAL, die=Die(number=n))))["jump_V"] for n in (1, 2)
    )
    assert a != b


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"weight_capacitance: 0 F, must be > 0"):
        Params(weight_capacitance=0.0)
    with pytest.raises(ParameterError, match=r"up: 2, must be 1, 0 or -1"):
        run(2.0, 1.0)
    with pytest.raises(ParameterError, match=r"events: 0, must be a whole number from 1"):
        run(1.0, 0.0)
