"""The membrane jumps by the capacitors' ratio and moves at current over capacitance."""

import pytest

from circuits.blocks.bench.axon_hillock import BLOCK, Params
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

GATES = 0.5 * 8.4e-3 * (13.6 + 4.0) * 4.0e-12 + 0.3e-9 * 2.0 * 17.6e-6  # F, of the first inverter


def numbers(params: Params, current: float = 3e-12) -> dict[str, float | None]:
    bench = BLOCK.bench(BLOCK.build(params), current=current)
    return BLOCK.measures(simulate(bench, Silicon(ROLLS_180)))


def test_the_jump_is_the_capacitors_ratio() -> None:
    for line in (0.0, 0.5e-12):
        found, total = numbers(Params(line_capacitance=line)), (2.08 + 0.81) * 1e-12 + line + GATES
        # the inverter's output comes back through its overlap, the other way: 0.3 fF/um of 17.6 um, 4 mV
        assert found["jump_V"] == pytest.approx(1.8 * 0.81e-12 / total, rel=0.03)


def test_the_slopes_are_current_over_capacitance() -> None:
    total = (2.08 + 0.81) * 1e-12 + GATES
    slow, fast = numbers(Params()), numbers(Params(), 3.5e-12)
    assert fast["rise_V_per_s"] - slow["rise_V_per_s"] == pytest.approx(0.5e-12 / total, rel=0.03)
    assert fast["fall_V_per_s"] - slow["fall_V_per_s"] == pytest.approx(0.5e-12 / total, rel=0.1)


def test_too_small_a_current_never_spikes() -> None:
    result = simulate(BLOCK.bench(current=0.2e-12, duration=3.0), Silicon(ROLLS_180_IDEAL))
    assert BLOCK.outcome(result) == "none"
    assert BLOCK.measures(result)["period_s"] is None


def test_what_cannot_be() -> None:
    with pytest.raises(ParameterError, match=r"feedback_capacitance: 0 F, must be > 0"):
        Params(feedback_capacitance=0.0)
    with pytest.raises(ParameterError, match=r"line_capacitance: -1e-12 F, must be 0 F or more"):
        Params(line_capacitance=-1e-12)
