"""The discrete model against equations (1) to (4) written out synapse by synapse, and its consequences."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from chips.wavefront.axon_graph import grid_graph
from chips.wavefront.spiking_wavefront import learn, round_delays, run_spikes
from circuits.arrays import I64, Bools
from circuits.errors import ParameterError


def _by_synapse(delays: I64, start: tuple[int, int], steps: int) -> list[tuple[int, int]]:
    """(step, neuron) of all spikes, with a d_ij for each pair, as printed."""
    graph, flat = grid_graph(*delays.shape), delays.ravel()
    j, i = graph.sources(), graph.targets
    n = flat.size
    v, u, received, d = (np.zeros(k, dtype=np.int64) for k in (n, n, n, graph.edges))
    found = []

    def fire(which: Bools, step: int) -> None:
        v[which], u[which] = 1, -5
        d[which[j]] = flat[j][which[j]]
        found.extend((step, int(k)) for k in np.flatnonzero(which))

    first = np.zeros(n, dtype=np.bool_)
    first[start[0] * delays.shape[1] + start[1]] = True
    fire(first & (flat > 0), 0)
    for t in range(steps):
        v[:], u_next = u + received, np.minimum(u + 1, 0)
        received[:] = np.bincount(i[d == 1], minlength=n)
        u[:], d[:] = u_next, np.maximum(d - 1, 0)
        fire((v > 0) & (flat > 0), t + 1)
    return found


@settings(max_examples=40, deadline=None)
@given(
    st.tuples(st.integers(1, 6), st.integers(1, 6)), st.integers(0, 2**32 - 1), st.sampled_from([1, 4, 12])
)
def test_run_is_the_equations(shape: tuple[int, int], seed: int, highest: int) -> None:
    draw = np.random.default_rng(seed)
    delays = draw.integers(1, highest + 1, shape) * (draw.random(shape) > 0.15)
    start = int(draw.integers(shape[0])), int(draw.integers(shape[1]))
    table = run_spikes(delays, start, limit=60)
    assert list(zip(table.steps.tolist(), table.neurons.tolist(), strict=True)) == _by_synapse(
        delays, start, 60
    )


@pytest.mark.parametrize("delay", [1, 2, 5, 9])
def test_a_hop_takes_one_step_more_than_the_delay(delay: int) -> None:
    table = run_spikes(np.full((1, 6), delay), (0, 0), (0, 5))
    assert table.first_spikes()[0].tolist() == [k * (delay + 1.0) for k in range(6)]
    assert table.last == 5 * (delay + 1)


def test_neurons_fire_again_from_a_delay_of_two_on() -> None:
    """A spike comes back 2 (D + 1) steps later, u is back at 0 after 5 and v reads it a step later."""
    assert run_spikes(np.full((1, 30), 1), (0, 0)).counts().max() == 1
    assert run_spikes(np.full((1, 30), 2), (0, 0)).counts().max() > 1


def test_a_long_delay_among_short_ones_is_never_passed() -> None:
    """Neurons of delay 3 fire again every 8 steps, and reset each time what a neuron of delay 9 has begun."""
    delays = np.full((3, 12), 3)
    delays[:, 6:] = 9
    table = run_spikes(delays, (1, 0), (1, 11))
    assert table.counts()[:, 6].min() > 2
    assert table.counts()[:, 7:].max() == 0
    assert table.last == int((delays + 1).sum())


def test_run_ends_where_nothing_is_under_way() -> None:
    table = run_spikes(np.full((1, 2), 1), (0, 0))
    assert (table.steps.tolist(), table.neurons.tolist()) == ([0, 2], [0, 1])
    assert table.last < 10
    assert run_spikes(np.array([[0, 1]]), (0, 0)).neurons.size == 0


def test_start_as_goal_ends_at_once() -> None:
    table = run_spikes(np.full((3, 3), 4), (1, 1), (1, 1))
    assert (table.neurons.tolist(), table.last) == ([4], 0)


def test_learning_moves_delays_by_its_rate() -> None:
    delays = np.full((1, 2), 5.0)
    learned = learn(delays, np.array([[1, 9]]), 0.25)
    assert learned.tolist() == [[4.0, 6.0]]
    assert learn(delays, np.array([[1, 9]])).tolist() == [[1.0, 9.0]]
    with pytest.raises(ParameterError, match=r"learn.rate: 1.5, must be 0 to 1"):
        learn(delays, np.array([[1, 9]]), 1.5)


def test_delays_are_whole_when_written() -> None:
    assert round_delays(np.array([0.0, 0.2, 1.5, 2.4, 2.5])).tolist() == [0, 1, 2, 2, 3]


def test_wrong_input_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"delays\[0, 1\]: -1 steps"):
        run_spikes(np.array([[1, -1]]), (0, 0))
    with pytest.raises(ParameterError, match=r"run.goal: \(0, 2\)"):
        run_spikes(np.array([[1, 1]]), (0, 0), (0, 2))
