import numpy as np
import pytest

from circuits.blocks.sonar import vocalization_controller as board
from circuits.event import falling_crossing, rising_crossing
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate

V_DD = 5.0
PROXIMITY = (0.2, 0.9, 1.6, 2.3, 3.0)  # V, the used range
LONGEST_BEST_DELAY = 28e-3  # s, neuron 12 of the array


def run(
    proximity: float, temperature_c: float, control: float | None = None, duration: float | None = None
) -> Result:
    stimuli = {"proximity": proximity, "amplitude_control": control, "duration": duration}
    return simulate(
        board.testbench(board.build(), stimuli, V_DD), Silicon(AMI_1500_IDEAL, temperature_c=temperature_c)
    )


@pytest.fixture(scope="module", params=[27.0, 85.0])
def sweep(request: pytest.FixtureRequest) -> list[Result]:
    return [run(v, request.param) for v in PROXIMITY]


def distance_from_line(y: np.ndarray) -> float:
    """Largest distance from the straight line through the ends, as a share of the span."""
    line = y[0] + (y[-1] - y[0]) * (np.array(PROXIMITY) - PROXIMITY[0]) / (PROXIMITY[-1] - PROXIMITY[0])
    return float(np.abs(y - line).max() / abs(y[-1] - y[0]))


# Figure 10: linear within 2 % of full scale.
@pytest.mark.parametrize(("name", "sign"), [("call_rate_Hz", 1.0), ("amplitude_V", -1.0)])
def test_rate_and_amplitude_are_linear_in_proximity(sweep: list[Result], name: str, sign: float) -> None:
    y = np.array([board.measures(r)[name] for r in sweep], dtype=np.float64)
    assert (sign * np.diff(y) > 0.0).all()
    assert distance_from_line(y) < 0.02


def test_rate_agrees_with_the_closed_form(sweep: list[Result]) -> None:
    # 0.5 %: the comparator trips half a millivolt early, the reset transistor has a resistance
    for proximity, result in zip(PROXIMITY, sweep, strict=True):
        rate = board.measures(result)["call_rate_Hz"]
        assert rate == pytest.approx(board.call_rate(board.Params(), proximity, V_DD), rel=5e-3)


def test_amplitude_agrees_with_the_closed_form(sweep: list[Result]) -> None:
    # 3 mV: gain 1e4, lower near the rails, and an output resistance of 10 kohm
    intercept, slope = board.amplitude_law(board.Params(), V_DD)
    for proximity, result in zip(PROXIMITY, sweep, strict=True):
        assert board.measures(result)["amplitude_V"] == pytest.approx(intercept + slope * proximity, abs=3e-3)


def test_first_call_comes_a_full_interval_after_the_enabling(sweep: list[Result]) -> None:
    # at most 5 % longer: the ramp starts from the ground, later ones from the lower threshold
    for result in sweep:
        measures = board.measures(result)
        assert measures["first_call_s"] is not None
        assert measures["call_rate_Hz"] is not None
        assert 1.0 <= measures["first_call_s"] * measures["call_rate_Hz"] < 1.05
        assert board.BLOCK.outcome(result) == "calling"


def test_call_width_agrees_with_the_closed_form(sweep: list[Result]) -> None:
    # 3 %: the reset transistor adds up to 0.1 kohm to 1.5 kohm at the start of the discharge
    result = sweep[2]
    up = rising_crossing(result.time, result["call"], 0.5 * V_DD)
    down = falling_crossing(result.time, result["call"], 0.5 * V_DD)
    assert up is not None
    assert down is not None
    assert down - up == pytest.approx(board.call_width(board.Params(), PROXIMITY[2], V_DD), rel=0.03)


def test_interval_leaves_time_for_the_farthest_echo() -> None:
    assert 1.0 / board.call_rate(board.Params(), PROXIMITY[-1], V_DD) > LONGEST_BEST_DELAY


def test_amplitude_has_its_own_control() -> None:
    result = run(1.5, 27.0, control=0.5, duration=5e-3)
    intercept, slope = board.amplitude_law(board.Params(), V_DD)
    assert board.measures(result)["amplitude_V"] == pytest.approx(intercept + 0.5 * slope, abs=3e-3)


def test_without_time_for_a_call_the_board_is_silent() -> None:
    result = run(3.0, 27.0, duration=20e-3)
    assert board.BLOCK.outcome(result) == "silent"
    assert board.measures(result)["call_rate_Hz"] is None


def test_tighter_tolerance_moves_the_rate_by_less_than_a_thousandth() -> None:
    testbench = board.testbench(
        board.build(), {"proximity": 3.0, "amplitude_control": None, "duration": None}, V_DD
    )
    rates = [board.measures(simulate(testbench, rtol=rtol))["call_rate_Hz"] for rtol in (1e-4, 1e-6)]
    assert rates[0] == pytest.approx(rates[1], rel=1e-3)
