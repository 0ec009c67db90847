"""What the network asks of a Hodgkin-Huxley neuron, by the conductances of transistors."""

import pytest

from circuits.bias import rebias
from circuits.blocks.latency.conductance import BLOCK, REST, Params, build
from circuits.errors import ParameterError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate

NONE: dict[str, float | None] = {s.name: None for s in BLOCK.stimuli}


def run(biases: dict[str, float] | None = None, celsius: float = 27.0, **stimuli: float) -> Result:
    circuit = rebias(build(), biases or {}, "ideal")
    return simulate(
        BLOCK.testbench(circuit, NONE | stimuli, 5.0), Silicon(AMI_1500_IDEAL, temperature_c=celsius)
    )


def spikes(result: Result) -> int:
    return int(result.spikes["spike"].size)


def test_it_rests_at_the_leaks_reversal() -> None:
    result = run()
    assert spikes(result) == 0
    # the sodium's tail of 20 nA is open by e^-8 there, some 10 pA against the leak's 2.7 nS
    assert BLOCK.measures(result)["rest_V"] == pytest.approx(REST, abs=10e-3)


@pytest.mark.parametrize(
    ("gap", "count"), [(None, 0), (0.0, 1), (1.5e-3, 1), (2.5e-3, 1), (4e-3, 0), (8e-3, 0)]
)
def test_two_weak_inputs_that_coincide_spike_and_one_does_not(gap: float | None, count: int) -> None:
    given = {"first": 0.0} if gap is None else {"first": 0.0, "second": gap}
    assert spikes(run(**given)) == count


def test_a_spike_is_all_or_none_and_is_followed_by_hyperpolarisation() -> None:
    once, twice = (run({"i_exc": i}, first=0.0) for i in (3e-9, 6e-9))
    peaks = [float(r["v_mem"].max()) for r in (once, twice)]
    # twice the input, the same spike up to the rail that both come near
    assert peaks[0] == pytest.approx(peaks[1], rel=0.1)
    assert peaks[0] > 2.0 * REST
    assert float(once["v_mem"].min()) < REST - 0.3


def test_a_strong_input_within_the_refractory_time_is_lost() -> None:
    strong = {"i_exc": 3e-9}
    assert spikes(run(strong, first=0.0, second=5e-3)) == 1
    assert spikes(run(strong, first=0.0, second=20e-3)) == 2


def test_a_steady_current_makes_it_tonic_the_faster_the_more() -> None:
    # an inhibition at the start moves it from the balance that a simulator begins in
    rates = [
        BLOCK.measures(run({"i_tonic": i, "i_hold": 1e-9}, inhibit=0.0, duration=0.08))["rate_Hz"]
        for i in (0.25e-9, 0.5e-9)
    ]
    assert rates[0] is not None
    assert rates[1] is not None
    assert 40.0 < rates[0] < rates[1] < 200.0


def test_inhibition_silences_it() -> None:
    times = run({"i_tonic": 0.5e-9}, inhibit=0.0, duration=0.08).spikes["spike"]
    # silent from 5 to 25 ms, and for a rise of some ms
    assert times[0] > 25e-3
    assert times.size > 2


@pytest.mark.parametrize("celsius", [0.0, 60.0])
def test_coincidences_are_told_at_other_temperatures(celsius: float) -> None:
    assert [spikes(run(None, celsius, first=0.0)), spikes(run(None, celsius, first=0.0, second=0.0))] == [
        0,
        1,
    ]


def test_sizes_that_cannot_be_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"gate_capacitance: 0 F, must be > 0"):
        Params(gate_capacitance=0.0)
