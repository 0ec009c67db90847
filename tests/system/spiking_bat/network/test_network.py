"""Networks against what their docstrings say: delays, boxes, latches, release, exact integration."""

import math

import numpy as np
import pytest

from chips.latency.law import evaluation_latency
from circuits.errors import ParameterError
from system.spiking_bat.network import network as spiking

DELAY = 3e-3


def network(**changes: object) -> spiking.Network:
    populations: dict[str, spiking.Population] = {
        "relay": spiking.Conductors((2,)),
        "sum": spiking.Integrators((1,), refractory=math.inf, released=True),
        "given": spiking.Inputs((3,)),
    }
    projections = [
        spiking.Projection("in", "given", "sum", (np.array([0, 1]), 0), 125.3, np.array([0.0, DELAY]), 20e-3),
        spiking.Projection("on", "sum", "relay", (0, np.array([0, 1])), 8.0, np.array([0.0, DELAY])),
    ]
    return spiking.wire(populations, projections, **{"release": None, **changes})  # type: ignore[arg-type]


def steps(spikes: spiking.Spikes, name: str) -> list[int]:
    return [round(t / spiking.STEP) for t in spikes.of(name)[0]]


def played(net: spiking.Network, given: list[tuple[int, int]], duration: float = 0.05) -> spiking.Spikes:
    inputs = np.array([(k, net.number("given", n)) for k, n in given], dtype=np.int64)
    return spiking.run(net, spiking.new_state(net), duration, inputs)[0]


def test_a_box_charges_from_the_step_after_its_spike() -> None:
    spikes = played(network(), [(100, 0)])
    assert steps(spikes, "given") == [101]
    # 8 ms are 400 steps: on from step 101, over the threshold in step 500, which ends at 501
    assert steps(spikes, "sum") == [501]


def test_a_delay_puts_a_spike_off_by_its_steps() -> None:
    assert steps(played(network(), [(100, 1)]), "sum") == [501 + round(DELAY / spiking.STEP)]
    times, numbers = played(network(), [(100, 0)]).of("relay")
    assert numbers.tolist() == [0, 1]
    assert round((times[1] - times[0]) / spiking.STEP) == round(DELAY / spiking.STEP)


def test_two_inputs_spike_by_equation_9() -> None:
    spikes = played(network(), [(100, 0), (200, 0), (150, 0)])
    inputs = [t * spiking.STEP for t in steps(spikes, "given")]
    # a spike counts at the end of its step
    expected = evaluation_latency(inputs, 125.3)
    assert steps(spikes, "sum")[0] * spiking.STEP == pytest.approx(expected, abs=spiking.STEP)


def test_a_neuron_that_waits_spikes_once_until_released() -> None:
    assert len(steps(played(network(), [(0, 0), (10, 0), (1500, 0)], 0.1), "sum")) == 1
    populations: dict[str, spiking.Population] = {
        "sum": spiking.Integrators((1,), refractory=math.inf, released=True),
        "given": spiking.Inputs((1,)),
        "onset": spiking.Inputs((1,)),
    }
    net = spiking.wire(
        populations, [spiking.Projection("in", "given", "sum", (0, 0), 125.3, hold=20e-3)], "onset"
    )
    inputs = np.array([(0, 1), (2000, 2), (3000, 1)], dtype=np.int64)
    assert steps(spiking.run(net, spiking.new_state(net), 0.1, inputs)[0], "sum") == [401, 3401]


def test_a_latched_current_counts_once_and_ends_with_the_release() -> None:
    populations: dict[str, spiking.Population] = {
        "race": spiking.Integrators((1,), drive=20.0, refractory=math.inf, released=True),
        "given": spiking.Inputs((1,)),
        "onset": spiking.Inputs((1,)),
    }
    net = spiking.wire(
        populations, [spiking.Projection("slow", "given", "race", (0, 0), -10.0, hold=math.inf)], "onset"
    )
    inputs = np.array([(0, 2), (1000, 1), (1500, 1), (5000, 2)], dtype=np.int64)
    found = steps(spiking.run(net, spiking.new_state(net), 0.2, inputs)[0], "race")
    # 20 ms at 20/s leave 0.6, for which 10/s take 60 ms; after the release 50 ms. A step of either may go to
    # the rounding of the sum.
    assert found == pytest.approx([1 + 4000, 5001 + 2500], abs=1)


def test_a_leak_is_integrated_exactly() -> None:
    populations: dict[str, spiking.Population] = {"leaky": spiking.Integrators((1,), leak=100.0, drive=150.0)}
    nothing = (np.array([], int), np.array([], int))
    net = spiking.wire(populations, [spiking.Projection("none", "leaky", "leaky", nothing, 1.0, hold=1.0)])
    expected = -math.log(1.0 - 100.0 / 150.0) / 100.0
    spikes, _ = spiking.run(net, spiking.new_state(net), 0.02, np.empty((0, 2), np.int64))
    assert steps(spikes, "leaky")[0] == math.ceil(expected / spiking.STEP)


def test_a_run_in_two_parts_is_the_run() -> None:
    net = network()
    inputs = np.array([(100, net.number("given", 0)), (900, net.number("given", 1))], dtype=np.int64)
    whole = spiking.run(net, spiking.new_state(net), 0.05, inputs)[0]
    state = spiking.new_state(net)
    first = spiking.run(net, state, 0.01, inputs[:1])[0]
    second = spiking.run(net, state, 0.04, inputs[1:])[0]
    assert np.array_equal(whole.step, np.concatenate([first.step, second.step]))
    assert np.array_equal(whole.source, np.concatenate([first.source, second.source]))


def test_probes_are_voltages() -> None:
    net = network()
    inputs = np.array([(0, net.number("given", 0))], dtype=np.int64)
    probes = (net.number("relay", 0), net.number("sum", 0))
    _, traces = spiking.run(net, spiking.new_state(net), 4e-3, inputs, probes)
    assert traces[:, 0] == pytest.approx(-65e-3, abs=1e-3)
    assert traces[-1, 1] == pytest.approx(125.3 * (4e-3 - spiking.STEP), rel=1e-9)  # on from the second step


def test_what_does_not_fit_is_refused() -> None:
    net = network()
    with pytest.raises(ParameterError, match="must be within the run"):
        spiking.run(
            net, spiking.new_state(net), 1e-3, np.array([(100, net.number("given", 0))], dtype=np.int64)
        )
    populations: dict[str, spiking.Population] = {
        "a": spiking.Conductors((2,)),
        "given": spiking.Inputs((1,)),
        "b": spiking.Integrators((1,)),
    }
    with pytest.raises(ParameterError, match=r"far: 2, must be a neuron of a, 0 to 1"):
        spiking.wire(populations, [spiking.Projection("far", "given", "a", (0, 2), 1.0)])
    with pytest.raises(ParameterError, match=r"back\.delay: -1 s, must be >= 0"):
        spiking.wire(populations, [spiking.Projection("back", "given", "a", (0, 0), 1.0, -1.0)])
    with pytest.raises(ParameterError, match=r"short\.hold: 0 s, must be > 0"):
        spiking.wire(populations, [spiking.Projection("short", "given", "b", (0, 0), 1.0)])
