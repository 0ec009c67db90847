"""Depression from event to event against the transistors of the same die."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.rolls.depression.model import Depression, charges, depression_model, depression_on, resources
from circuits.bias import rebias
from circuits.blocks.rolls.bias import OFF_CURRENT
from circuits.blocks.rolls.depressing_synapse import BLOCK, Params, build
from circuits.blocks.rolls.dpi_synapse import FIRST_EVENT
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.power import drain_current
from circuits.solver.transient import simulate


def model_on(silicon: Silicon, kind: BiasKind = "gate", level: int = 1, **biases: float) -> Depression:
    changed = rebias(build(), biases, kind)
    return depression_on(depression_model(Params(), changed.biases, silicon.process), silicon, level)


@pytest.mark.parametrize(
    ("process", "kind", "temperature", "die", "level"),
    [
        (ROLLS_180_IDEAL, "ideal", 0.0, 1000, 1),
        (ROLLS_180_IDEAL, "ideal", 60.0, 1001, 3),
        (ROLLS_180_IDEAL, "gate", 27.0, 1001, 4),
        (ROLLS_180, "ideal", 0.0, 1000, 1),
        (ROLLS_180, "gate", 27.0, 1001, 4),
        (ROLLS_180, "gate", 27.0, Die(number=1004, variation="full"), 2),
    ],
)
def test_pulses_of_a_train_are_the_transistors(
    process: Process, kind: BiasKind, temperature: float, die: int | Die, level: int
) -> None:
    silicon = Silicon(process, temperature, Die(number=die) if isinstance(die, int) else die)
    events, rate = 8, 100.0
    values = {"level": float(level), "events": float(events), "rate": rate, "duration": None}
    result = simulate(BLOCK.testbench(rebias(build(), {}, kind), values, 1.8), silicon, rtol=1e-5)
    on, found = model_on(silicon, kind, level), BLOCK.measures(result)
    # 1.3 % seen: what the weight's nodes leave at its gate 0.1 ms after the pulse
    assert found["step_V"] == pytest.approx(on.branches.step[0, 0], rel=0.025)
    # 0.9 % seen, of the same
    assert found["recovery_s"] == pytest.approx(on.branches.tau[0, 0], rel=0.02)
    times = FIRST_EVENT + np.arange(events) / rate
    current = drain_current(result, "synapse.me9")
    windows = [(result.time > t) & (result.time < t + 1e-3) for t in times]
    drawn = np.array([np.trapezoid(current[w], result.time[w]) for w in windows])
    modelled = charges(on, resources(on.branches, tuple(times)))[0]
    # 0.6 % seen, the most at 60 degC; under the full law 2.9 %, since the mirror's copy feels where the line
    # is, which is higher while the filter is nearly empty: 5 % is what a charge may be off
    off, relative = (0.01, 0.004) if process is ROLLS_180_IDEAL else (0.035, 0.01)
    assert modelled == pytest.approx(drawn, rel=off)
    # 0.002 and 0.006 seen
    assert modelled / modelled[0] == pytest.approx(drawn / drawn[0], abs=relative)


def test_a_long_train_settles_at_the_closed_form() -> None:
    on = model_on(Silicon(ROLLS_180_IDEAL)).branches
    interval = 10e-3
    found = resources(on, tuple(interval * np.arange(80)))[0, 0]
    spent, kept = np.exp(-interval / on.tau[0, 0]), np.exp(-on.step[0, 0] / on.u_t)
    assert found[0] == 1.0
    assert np.all(np.diff(found[:12]) < 0.0)
    # 80 events are 14 time constants: e^-14
    assert found[-1] == pytest.approx((1.0 - spent) / (1.0 - spent * kept), rel=1e-5)


def test_a_pause_brings_the_weight_back() -> None:
    on = model_on(Silicon(ROLLS_180_IDEAL)).branches
    found = resources(on, (0.0, 5e-3, 10e-3, 10e-3 + 20.0 * float(on.tau[0, 0])))[0, 0]
    assert found[2] < found[1] < 1.0
    assert found[3] == pytest.approx(1.0, abs=1e-8)


def test_without_the_bias_nothing_is_spent() -> None:
    on = model_on(Silicon(ROLLS_180_IDEAL), i_std=OFF_CURRENT)
    found = charges(on, resources(on.branches, tuple(5e-3 * np.arange(20))))[0]
    # a step of 7 uV: 20 of them are 0.5 % of U_T
    assert found / found[0] == pytest.approx(np.ones(20), abs=5e-3)


@pytest.mark.parametrize(
    ("process", "level", "temperature"),
    [(ROLLS_180_IDEAL, 1, 0.0), (ROLLS_180_IDEAL, 4, 27.0), (ROLLS_180, 1, 27.0)],
)
def test_the_gates_are_lifted_as_the_transistors_are(
    process: Process, level: int, temperature: float
) -> None:
    silicon = Silicon(process, temperature, Die(number=1000))
    off = {"i_std": OFF_CURRENT}
    values = {"level": float(level), "events": 1.0, "rate": 100.0, "duration": 3e-3}
    result = simulate(BLOCK.testbench(rebias(build(), off, "ideal"), values, 1.8), silicon, rtol=1e-5)
    gate, begin = result["w_exc"], FIRST_EVENT
    lifted = float(np.interp(begin + 18e-6, result.time, gate) - np.interp(begin, result.time, gate))
    found = model_on(silicon, "ideal", level, **off).branches
    # 0.7 and 1.1 mV; 1.2 % seen: what the mirror of a step that is off leaks
    # under the full law 5 %, of the same
    assert lifted == pytest.approx(found.path[-1, 0, 0], rel=0.025 if process is ROLLS_180_IDEAL else 0.06)


def test_every_weight_device_of_a_level_has_its_own_cell() -> None:
    on = model_on(Silicon(ROLLS_180_IDEAL, die=Die(number=1003)), level=4).branches
    assert on.step.shape == (3, 1)
    # 14 % is what its mirrors make of a step
    assert np.ptp(on.step) > 0.01 * on.step.mean()
    assert np.ptp(on.tau) > 0.01 * on.tau.mean()
    assert model_on(Silicon(ROLLS_180_IDEAL), level=3).branches.step.shape == (2, 1)


@pytest.mark.parametrize("level", [0, -1, 5])
def test_levels_that_do_not_excite_are_refused(level: int) -> None:
    with pytest.raises(ParameterError, match=rf"level: {level}, must be 1 to 4; inhibitory"):
        model_on(Silicon(ROLLS_180_IDEAL), level=level)


def test_leaks_let_a_gate_rest_above_its_bias_as_the_transistors_do() -> None:
    """With a recovery of a quarter of a femtoampere the junctions leak a twentieth of it."""
    silicon = Silicon(ROLLS_180, 60.0, Die(number=1000))
    weak = {"i_rec": 40e-16}
    values = {"level": 1.0, "events": 1.0, "rate": 100.0, "duration": 1e-3}
    point = operating_point(BLOCK.testbench(rebias(build(), weak, "ideal"), values, 1.8), silicon)
    volts = point.voltages()
    found = model_on(silicon, "ideal", **weak).branches.rest[0, 0]
    assert 5e-4 < found == pytest.approx(volts["w_exc"] - volts["v_exc"], rel=0.02)
    assert model_on(replace(silicon, process=ROLLS_180_IDEAL), "ideal").branches.rest.max() == 0.0
