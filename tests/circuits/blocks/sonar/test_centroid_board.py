import math
from collections.abc import Sequence

import numpy as np
import pytest

from circuits.blocks.drive import elements, powered
from circuits.blocks.sonar import centroid_board as board
from circuits.blocks.sonar import vocalization_controller
from circuits.errors import ParameterError
from circuits.event import HALF_WIDTH
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench

V_DD = 5.0
PARAMS = board.Params()
LOOKUP = board.linear_lookup()
BEST_DELAYS = [2e-3 + k * 26e-3 / 12 for k in range(13)]  # s
# A gate has at most 0.5 kohm against 5 kohm: it slows one spike's move by 10 %, hence shortens it by 6 %,
# and shifts the weight of one of two neurons by 2.5 %.
GATE_SLOWS, GATE_SHIFTS = 0.06, 0.025


def run(
    neuron: float, rate: float | None, duration: float, second: float | None = None, celsius: float = 27.0
) -> Result:
    stimuli = {"neuron": neuron, "second": second, "rate": rate, "duration": duration}
    return simulate(
        board.testbench(board.build(), stimuli, V_DD), Silicon(AMI_1500_IDEAL, temperature_c=celsius)
    )


def at(result: Result, node: str, time: float) -> float:
    return float(np.interp(time, result.time, result[node]))


def static_centroid(voltages: Sequence[float]) -> float:
    """Voltage to which the common node tends while the gates at `voltages` (V) are on, V."""
    on, leak = 1.0 / PARAMS.gate_resistance, 1.0 / PARAMS.leak_resistance
    return sum(voltages) * on / (len(voltages) * on + leak)


def centroid_after(before: float, voltages: Sequence[float], duration: float) -> float:
    """Voltage of the common node, V, `duration` s after gates came on while it was at `before` V.

    voltages: what the gates that are on lead to, V; none leaves the leak alone.
    """
    conductance = len(voltages) / PARAMS.gate_resistance + 1.0 / PARAMS.leak_resistance
    target = static_centroid(voltages)
    return target + (before - target) * math.exp(-duration * conductance / PARAMS.hold_capacitance)


@pytest.mark.parametrize("temperature_c", [-20.0, 27.0])
@pytest.mark.parametrize("on", [(2,), (2, 3), (0, 12), (0, 5, 12)])
def test_static_centroid_agrees_with_the_circuit(on: tuple[int, ...], temperature_c: float) -> None:
    circuit = board.build()
    spikes = elements(circuit.port("spike"), dict.fromkeys(on, V_DD))
    testbench = Testbench("static", circuit, powered(V_DD, spikes), 1e-3)
    point = operating_point(testbench, Silicon(AMI_1500_IDEAL, temperature_c=temperature_c))
    voltages = [LOOKUP[k] for k in on]
    tolerance = GATE_SHIFTS * (max(voltages) - min(voltages)) + 1e-3
    assert point["common"] == pytest.approx(static_centroid(voltages), abs=tolerance)
    assert point["proximity"] == pytest.approx(
        point["common"], abs=3e-3
    )  # two followers of gain 1e4 near a rail


@pytest.mark.parametrize("temperature_c", [27.0, 60.0])
@pytest.mark.parametrize(("neuron", "second"), [(0, None), (2, None), (2, 3), (12, None)])
def test_one_event_moves_the_centroid_by_the_closed_form(
    neuron: int, second: int | None, temperature_c: float
) -> None:
    result = run(neuron, 20.0, 10e-3, second, temperature_c)
    before = at(result, "common", board.FIRST_SPIKE - 1e-6)
    voltages = [LOOKUP[k] for k in (neuron, second) if k is not None]
    expected = centroid_after(before, voltages, HALF_WIDTH)
    # 2 mV: charge of the gates' edges on the hold capacitor
    after = at(result, "common", board.FIRST_SPIKE + 20e-6)
    assert after == pytest.approx(expected, rel=GATE_SLOWS, abs=2e-3)
    assert after <= expected + 2e-3


def test_estimate_leaks_to_the_far_default() -> None:
    result = run(2, 1.0, 0.5)
    start = board.FIRST_SPIKE + 1e-3
    expected = centroid_after(at(result, "common", start), (), 0.5 - start)
    # 1 %: strays of 13 idle gates add 3.5 % to the hold capacitor, seen over a quarter of its time constant
    assert board.measures(result)["centroid_V"] == pytest.approx(expected, rel=1e-2)


@pytest.mark.parametrize(("temperature_c", "highest"), [(27.0, 0.02), (85.0, 0.1)])
def test_without_spikes_the_estimate_is_far(temperature_c: float, highest: float) -> None:
    # the gates' off current through the leak resistor stays below half of the lowest look-up voltage
    result = run(2, None, 0.1, celsius=temperature_c)
    assert board.outcome(result) == "far"
    assert result["proximity"].max() < highest


def test_proximity_follows_with_the_low_pass() -> None:
    result = run(0, 1.0, 0.2)
    tau = PARAMS.filter_resistance * PARAMS.filter_capacitance
    leak = PARAMS.leak_resistance * PARAMS.hold_capacitance
    t = 2.0 * tau
    peak = at(result, "common", board.FIRST_SPIKE + 1e-3)
    shape = (math.exp(-t / leak) - math.exp(-t / tau)) / (1.0 - tau / leak)
    # 1 %: the follower slews for 0.3 ms, and the start is a few millivolts above ground
    assert at(result, "proximity", board.FIRST_SPIKE + t) == pytest.approx(peak * shape, rel=0.01)


@pytest.mark.parametrize("neuron", [0, 6, 11])
def test_a_train_of_spikes_brings_the_proximity_to_the_look_up_voltage(neuron: int) -> None:
    result = run(neuron, 20.0, 0.35)
    # 5 %: between spikes the hold capacitor loses 2.5 %, of which a spike makes good 63 %
    assert board.measures(result)["proximity_V"] == pytest.approx(LOOKUP[neuron], rel=0.05)
    assert board.outcome(result) == "target"


def test_linear_lookup_has_equal_steps_from_near_to_far() -> None:
    assert LOOKUP[0] == board.NEAREST
    assert LOOKUP[-1] == board.FARTHEST
    assert np.diff(LOOKUP) == pytest.approx(np.full(12, (board.FARTHEST - board.NEAREST) / 12))


def test_fourth_power_lookup_makes_the_amplitude_follow_the_fourth_power() -> None:
    intercept, slope = vocalization_controller.amplitude_law(vocalization_controller.Params(), V_DD)
    lookup = board.fourth_power_lookup(BEST_DELAYS, (intercept, slope))
    amplitude = intercept + slope * np.array(lookup.voltages)
    wanted = amplitude[-1] * (np.array(BEST_DELAYS) / BEST_DELAYS[-1]) ** 4
    clipped = np.array(lookup.clipped)
    assert amplitude[~clipped] == pytest.approx(wanted[~clipped])
    assert (amplitude[clipped] > wanted[clipped]).all()
    assert all(v == board.NEAREST for v, c in zip(lookup.voltages, clipped, strict=True) if c)
    # the stage spans 4.7 to 1: ranges below 4.7^(-1/4) = 0.68 of the farthest are out of its reach
    assert clipped.sum() == sum(d < 0.68 * BEST_DELAYS[-1] for d in BEST_DELAYS)
    assert lookup.summary.startswith(f"{clipped.sum()} of 13")


@pytest.mark.parametrize("ranges", [(), (1.0, 0.0), (1.0, float("nan"))])
def test_fourth_power_lookup_refuses_ranges_that_are_not_positive(ranges: tuple[float, ...]) -> None:
    with pytest.raises(ParameterError, match="ranges"):
        board.fourth_power_lookup(ranges, (4.5, -1.2))


def test_fourth_power_lookup_refuses_an_amplitude_that_rises() -> None:
    with pytest.raises(ParameterError, match=r"slope 1\.2"):
        board.fourth_power_lookup(BEST_DELAYS, (0.9, 1.2))


@pytest.mark.parametrize("neuron", [-1.0, 13.0, 2.5])
def test_a_neuron_that_does_not_exist_is_refused(neuron: float) -> None:
    with pytest.raises(ParameterError, match="whole number from 0 to 12"):
        run(neuron, 20.0, 0.1)


def test_a_table_that_is_trimmed_to_delays_stays_on_the_line_and_within_the_range() -> None:
    trimmed = board.lookup_at(BEST_DELAYS, BEST_DELAYS[0], BEST_DELAYS[-1])
    assert trimmed == pytest.approx(LOOKUP)
    low, middle, high = board.lookup_at([1e-3, 15e-3, 31e-3], BEST_DELAYS[0], BEST_DELAYS[-1])
    assert (low, high) == (board.NEAREST, board.FARTHEST)
    assert middle == pytest.approx(LOOKUP[6])
