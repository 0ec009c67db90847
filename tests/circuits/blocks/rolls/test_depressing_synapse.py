"""Spikes weaken an excitatory weight by steps of its gate; it comes back as the closed forms say."""

from __future__ import annotations

import numpy as np
import pytest

from circuits.bias import gate_voltage, rebias
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls.bias import OFF_CURRENT, current_of
from circuits.blocks.rolls.depressing_synapse import BLOCK, RECOVERY, STEP, Params, build
from circuits.blocks.rolls.dpi_synapse import FIRST_EVENT
from circuits.circuit import BiasKind
from circuits.devices import Transistor
from circuits.devices.transistor import drain_current
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL, thermal_voltage
from circuits.silicon.silicon import Silicon
from circuits.solver.power import drain_current as drain_of
from circuits.solver.transient import Result, simulate

V_DD = ROLLS_180_IDEAL.v_dd
U_T = thermal_voltage(27.0)
DEFAULTS = BLOCK.defaults
PULSE = 22.88e-6  # s; the DPI synapse's tests have its closed form
OFF = {"i_std": OFF_CURRENT}


def run(
    silicon: Silicon | None = None, kind: BiasKind = "gate", biases: dict[str, float] | None = None,
    **values: float,
) -> Result:  # fmt: skip
    bench = BLOCK.testbench(rebias(build(), biases or {}, kind), DEFAULTS | values, V_DD)
    return simulate(bench, Silicon(ROLLS_180_IDEAL) if silicon is None else silicon, rtol=1e-5)


def number(result: Result, name: str) -> float:
    found = BLOCK.measures(result)[name]
    assert found is not None
    return found


def at_gate() -> float:
    """C_w and what me2, the step's drain and the recovery's source add, F."""
    p, params = ROLLS_180_IDEAL.p, Params()
    one = params.synapse
    widths = 2.0 * one.weight_width + params.mirror_width + params.recovery_width
    junctions = params.mirror_width + params.recovery_width
    gate = p.gate_bulk_fraction * p.oxide_capacitance * one.weight_width * one.weight_length * 1e-12
    edges = (p.overlap_capacitance * widths + p.junction_capacitance * junctions) * 1e-6
    return params.weight_capacitance + gate + edges


def step() -> float:
    return current_of(STEP) * PULSE / at_gate()


def time_constant() -> float:
    return at_gate() * U_T / (Params().ratio * current_of(RECOVERY))


def test_a_step_is_the_closed_form_and_goes_with_the_current() -> None:
    result = run(events=1.0)
    assert dpi_synapse.measures(result)["pulse_width_s"] == pytest.approx(PULSE, rel=1e-3)
    # 3 %: the source's edge lifts the mirror for 3 us; 0.2 mV of the weight's own nodes is left 0.1 ms later
    assert number(result, "step_V") == pytest.approx(step(), rel=0.03)
    twice = run(events=1.0, biases={"i_std": 2.0 * current_of(STEP)})
    assert number(twice, "step_V") == pytest.approx(2.0 * number(result, "step_V"), rel=0.03)


@pytest.mark.parametrize("events", [2.0, 6.0, 12.0])
def test_recovery_is_exponential_in_r_at_any_depth(events: float) -> None:
    result = run(events=events, duration=FIRST_EVENT + events * 5e-3 + 0.1)
    # 2 %: what is left of the weight's own nodes at the beginning
    assert number(result, "recovery_s") == pytest.approx(time_constant(), rel=0.02)
    last = FIRST_EVENT + (events - 1.0) * 5e-3
    times = last + np.array([5e-3, 20e-3, 60e-3])
    x = np.interp(times, result.time, result["w_exc"]) - float(result["w_exc"][0])
    spent = 1.0 - np.exp(-x / U_T)
    expected = spent[0] * np.exp(-(times - times[0]) / time_constant())
    assert spent == pytest.approx(expected, rel=0.02)


def weight(x: float) -> float:
    """Current of the constant weight's pFET, its gate x above the bias, A: the law of moderate inversion."""
    law, size = Silicon(ROLLS_180_IDEAL).law("p"), 1e-6
    device = Transistor("m", "p", "d", "g", "s", "b", size, size)
    bias = build().bias("i_exc").value
    assert isinstance(bias, float)
    gate = V_DD - gate_voltage(law, device, bias) + x
    return -float(drain_current(law, "p", size, size, 0.4, gate, V_DD, V_DD)[0])


@pytest.mark.parametrize("rate", [20.0, 50.0, 200.0])
def test_a_train_settles_where_the_closed_form_does(rate: float) -> None:
    events = 12  # at 200 Hz R comes nearer by 0.56 an event
    result = run(rate=rate, events=float(events), duration=events / rate + 2e-3)
    kept, spent = np.exp(-step() / U_T), np.exp(-1.0 / (rate * time_constant()))
    settled = (1.0 - spent) / (1.0 - spent * kept)
    again = 1.0 - (1.0 - kept) * spent
    first, second, last = (weight(-U_T * float(np.log(r))) for r in (1.0, again, settled))
    # 4 %: a step is 2 % short, and the later pulses' mirror begins where the last one left it
    assert number(result, "paired_pulse") == pytest.approx(second / first, rel=0.04)
    assert number(result, "last_to_first") == pytest.approx(last / first, rel=0.04)


@pytest.mark.parametrize("level", [1.0, 2.0, 4.0])
def test_every_level_is_depressed(level: float) -> None:
    result = run(level=level)
    assert BLOCK.outcome(result) == "depresses"
    # the larger weights are in moderate inversion, where a step takes less
    assert 0.4 < number(result, "last_to_first") < 0.65
    gates = [float(result[f"w_{n}"][-1] - result[f"w_{n}"][0]) for n in ("exc", "exc0", "exc1")]
    assert gates == pytest.approx([gates[0]] * 3, rel=0.02)


def test_without_the_bias_it_is_the_undepressed_synapse() -> None:
    result = run(biases=OFF)
    assert BLOCK.outcome(result) == "steady"
    # 0.07 pA of step and off current over six pulses, and what the gate's neighbours leave
    assert number(result, "last_to_first") == pytest.approx(1.0, abs=2e-3)
    bench = dpi_synapse.BLOCK.testbench(
        dpi_synapse.build(), {"level": 1.0, "events": 6.0, "rate": 200.0, "duration": 51e-3}, V_DD
    )
    plain = simulate(bench, Silicon(ROLLS_180_IDEAL), rtol=1e-5)
    # 3 %: es and em lift the gate by 0.7 mV in a pulse
    assert drawn(result) == pytest.approx(drawn(plain), rel=0.03)
    assert dpi_synapse.measures(result)["decay_s"] == pytest.approx(
        dpi_synapse.measures(plain)["decay_s"], rel=0.02
    )


def drawn(result: Result) -> float:
    """Charge that the synapse takes from its line in a run, C."""
    return float(np.trapezoid(np.abs(drain_of(result, "synapse.me9")), result.time))


@pytest.mark.parametrize("level", [-4.0, 0.0])
def test_only_excitatory_pulses_take_steps(level: float) -> None:
    result = run(level=level)
    assert BLOCK.outcome(result) == "silent"
    assert BLOCK.measures(result)["step_V"] is None
    assert float(np.ptp(result["w_exc"])) < 1e-3


def test_a_generator_holds_step_and_recovery_over_temperature() -> None:
    cold, hot = (run(Silicon(ROLLS_180_IDEAL, t), "ideal") for t in (0.0, 60.0))
    # I_std t is constant where both go with temperature; 8 %: the inverter's threshold, edges
    assert number(hot, "step_V") == pytest.approx(number(cold, "step_V"), rel=0.08)
    assert number(hot, "recovery_s") == pytest.approx(number(cold, "recovery_s"), rel=0.02)


def test_fixed_gates_do_not() -> None:
    cold, hot = (run(Silicon(ROLLS_180_IDEAL, t)) for t in (0.0, 60.0))
    # 4 to 7 %/K in I_std and I_rec; the pulse shortens too, so that the step grows less
    assert number(hot, "step_V") > 3.0 * number(cold, "step_V")
    assert number(cold, "recovery_s") > 10.0 * number(hot, "recovery_s")


def test_dies_differ_and_a_die_is_itself() -> None:
    a, b, again = (run(Silicon(ROLLS_180_IDEAL, die=Die(number=n))) for n in (1, 2, 1))
    for name in ("step_V", "recovery_s", "last_to_first"):
        assert abs(number(a, name) / number(b, name) - 1.0) > 1e-3
        assert number(a, name) == number(again, name)


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"weight_capacitance: 0 F, must be > 0"):
        Params(weight_capacitance=0.0)
    with pytest.raises(ParameterError, match="whole number from -4 to 4"):
        run(level=5.0)
    with pytest.raises(ParameterError, match="events: 0, must be a whole number from 1"):
        run(events=0.0)


def test_a_step_that_has_not_settled_is_not_told() -> None:
    # pulses of 23 us every 50 us
    fast = BLOCK.measures(run(events=3.0, rate=20e3))
    assert fast["step_V"] is None
    assert fast["depression_V"] == pytest.approx(3.0 * step(), rel=0.03)
