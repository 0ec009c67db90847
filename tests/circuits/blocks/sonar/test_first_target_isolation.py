import math
from collections.abc import Sequence

import numpy as np
import pytest

from circuits.blocks.drive import elements, powered
from circuits.blocks.sonar import first_target_isolation as board
from circuits.errors import ParameterError
from circuits.event import pulse
from circuits.lowering.check import check_circuit
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench

V_DD = 5.0
MILLIVOLT = 1e-3  # V: off currents through the gates' resistance are far below it
SOON = 1e-6  # s: an event's edge is 0.1 us, the logic takes tens of nanoseconds; a few us are asked for

pytestmark = pytest.mark.parametrize("temperature_c", [27.0, -20.0])


def run(
    temperature_c: float, neuron: float = 2, spike: float | None = 0.1e-3, call: float | None = 0.3e-3
) -> Result:
    stimuli = {"neuron": neuron, "spike": spike, "call": call, "duration": 0.4e-3}
    return simulate(
        board.testbench(board.build(), stimuli, V_DD), Silicon(AMI_1500_IDEAL, temperature_c=temperature_c)
    )


def at(result: Result, node: str, time: float) -> float:
    return float(np.interp(time, result.time, result[node]))


def isolated_intervals(spikes: Sequence[float], calls: Sequence[float]) -> list[tuple[float, float]]:
    """Ideal behaviour: (start, end), s, of every isolation of the array; inf where no call ends it.

    spikes, calls: times of rising edges, s, in any order.
    """
    intervals: list[tuple[float, float]] = []
    for spike in sorted(spikes):
        if not intervals or spike >= intervals[-1][1]:
            intervals.append((spike, min((c for c in calls if c > spike), default=math.inf)))
    return intervals


def test_circuit_checks_and_rests_open(temperature_c: float) -> None:
    circuit = board.build()
    check_circuit(circuit)
    stimuli = {"neuron": 0.0, "spike": None, "call": None, "duration": 1e-3}
    point = operating_point(
        board.testbench(circuit, stimuli, V_DD), Silicon(AMI_1500_IDEAL, temperature_c=temperature_c)
    )
    assert point.stable
    assert point["v_ex_max"] == pytest.approx(board.V_EX_MAX, abs=MILLIVOLT)


@pytest.mark.parametrize("neuron", [0, 6, 12])
def test_any_spike_isolates_until_the_call(neuron: int, temperature_c: float) -> None:
    result = run(temperature_c, neuron)
    measures = board.measures(result)
    assert measures["set_delay_s"] is not None
    assert measures["reset_delay_s"] is not None
    assert 0.0 < measures["set_delay_s"] < SOON
    assert 0.0 < measures["reset_delay_s"] < SOON
    for time, level in (
        (0.09e-3, board.V_EX_MAX),
        (0.15e-3, V_DD),
        (0.29e-3, V_DD),
        (0.4e-3, board.V_EX_MAX),
    ):
        assert at(result, "v_ex_max", time) == pytest.approx(level, abs=MILLIVOLT)
    assert board.outcome(result) == "open"


def test_without_a_call_it_stays_isolated(temperature_c: float) -> None:
    result = run(temperature_c, call=None)
    assert board.measures(result)["v_ex_max_V"] == pytest.approx(V_DD, abs=MILLIVOLT)
    assert board.measures(result)["reset_delay_s"] is None
    assert board.outcome(result) == "isolated"


def test_a_call_without_a_spike_changes_nothing(temperature_c: float) -> None:
    result = run(temperature_c, spike=None)
    assert board.measures(result)["set_delay_s"] is None
    assert result["v_ex_max"] == pytest.approx(
        board.V_EX_MAX, abs=0.05
    )  # the call's edges couple by millivolts


def test_a_sequence_agrees_with_the_ideal_latch(temperature_c: float) -> None:
    calls = (0.1e-3, 0.4e-3, 0.6e-3, 0.8e-3)
    spikes = {3: (0.2e-3, 0.5e-3), 4: (0.21e-3, 0.3e-3), 12: (0.9e-3,)}
    circuit = board.build()
    array = elements(circuit.port("spike"), {k: pulse(times, V_DD) for k, times in spikes.items()})
    sources = powered(V_DD, {"call": pulse(calls, V_DD), **array})
    testbench = Testbench("sequence", circuit, sources, 1e-3, start=board.rest(V_DD))
    result = simulate(testbench, Silicon(AMI_1500_IDEAL, temperature_c=temperature_c))
    intervals = isolated_intervals([t for times in spikes.values() for t in times], calls)
    assert intervals == [(0.2e-3, 0.4e-3), (0.5e-3, 0.6e-3), (0.9e-3, math.inf)]
    time = np.arange(0.0, 1e-3, 1e-6)
    ideal = np.zeros(time.size, dtype=np.bool_)
    for start, end in intervals:
        ideal |= (time > start) & (time <= end)
    found = np.interp(time, result.time, result["v_ex_max"]) > 0.5 * (V_DD + board.V_EX_MAX)
    edges = np.array([t for interval in intervals for t in interval if math.isfinite(t)])
    settled = (np.abs(time[:, None] - edges) > SOON).all(axis=1)
    assert (found == ideal)[settled].all()


def test_a_neuron_that_does_not_exist_is_refused(temperature_c: float) -> None:
    with pytest.raises(ParameterError, match="whole number from 0 to 12"):
        run(temperature_c, neuron=13)
