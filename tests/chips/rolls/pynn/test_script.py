"""A script of PyNN runs on the chip as its program does; what the chip lacks is refused in a line."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pyNN.connectors
import pytest
from pyNN.core import IndexBasedExpression

import chips.rolls.pynn as sim
from chips.rolls.chip import Inputs
from chips.rolls.pynn.simulator import state
from circuits.errors import CircuitError
from circuits.silicon.die import Die

GIVEN = [5.0, 6.0, 6.5, 7.0, 8.0, 30.0, 31.0, 32.0, 33.0]


@pytest.fixture(autouse=True)
def _anew() -> Iterator[None]:
    sim.setup(die=Die("A", 1001), seed=3)
    yield
    sim.setup()


def network() -> tuple[Any, Any, Any]:
    """Given events drive four neurons, which drive four others, which inhibit them."""
    source = sim.Population(4, sim.SpikeSourceArray(spike_times=GIVEN), label="given")
    one = sim.Population(4, sim.RollsNeuron(), label="one")
    other = sim.Population(4, sim.RollsNeuron(slow_leak=True), label="other")
    sim.Projection(source, one, sim.OneToOneConnector(), sim.StaticSynapse(weight=4))
    sim.Projection(one, other, sim.AllToAllConnector(), sim.StaticSynapse(weight=3))
    sim.Projection(other, one[0:2], sim.FromListConnector([(0, 1, 1.0)], column_names=["weight"]),
                   sim.StaticSynapse(), receptor_type="inhibitory")  # fmt: skip
    return source, one, other


def test_a_script_runs_as_its_program_does_and_again_from_the_beginning() -> None:
    source, one, other = network()
    for each in (source, one, other):
        each.record("spikes")
    sim.run(20.0)
    sim.run(40.0)
    program = sim.program()
    assert (program.levels[0, 255], program.levels[4, 3], program.levels[1, 4]) == (4, 3, -1)
    assert (np.count_nonzero(program.levels), program.tau1) == (4 + 16 + 1, (4, 5, 6, 7))

    chip = state._chip
    assert chip is not None
    times, neurons = np.repeat(np.array(GIVEN) * 1e-3, 4), np.tile(np.arange(4), len(GIVEN))
    wanted, _ = chip.run(chip.at_rest(), 60e-3, Inputs(times, neurons, 256 + 255 - neurons))
    trains = [t for each in (one, other) for t in each.get_data().segments[0].spiketrains]
    # a piece counts its steps from its own beginning, which rounds otherwise
    for neuron, train in enumerate(trains):
        own = wanted.times[(wanted.neurons == neuron) & (wanted.times <= 60e-3)] * 1e3
        assert np.allclose(train.magnitude, own, rtol=0.0, atol=1e-6)
    assert sum(map(len, trains)) > 20
    assert source.get_data().segments[0].spiketrains[0].magnitude.tolist() == GIVEN
    count = one.mean_spike_count()

    sim.reset()
    sim.run(60.0)
    assert (one.mean_spike_count(), len(one.get_data().segments)) == (count, 2)
    for change in (lambda: one.set(slow_leak=True), lambda: sim.Population(1, sim.RollsNeuron())):
        with pytest.raises(CircuitError, match="changed after the first run, the chip is programmed"):
            change()


def test_random_events_do_not_depend_on_how_a_run_is_cut() -> None:
    source = sim.Population(2, sim.SpikeSourcePoisson(rate=200.0, start=30.0, duration=400.0))
    whole = source.events(source[1], 0.0, 500.0)
    pieces = [source.events(source[1], k, k + 50.0) for k in np.arange(0.0, 500.0, 50.0)]
    assert np.array_equal(np.concatenate(pieces), whole)
    assert 40 < whole.size < 130
    assert (whole >= 30.0).all()
    assert (whole < 430.0).all()
    assert not np.array_equal(source.events(source[0], 0.0, 500.0), whole)


def test_populations_projections_and_their_views_are_pynns() -> None:
    one = sim.Population(6, sim.RollsNeuron(slow_leak=[True, False] * 3))
    assert one.get("slow_leak").tolist() == [True, False] * 3
    one[0:2].set(slow_leak=False)
    assert one.get("slow_leak").tolist() == [False, False, True, False, True, False]
    assert one[2:4].get("slow_leak").tolist() == [True, False]
    chosen = sim.FixedProbabilityConnector(0.5, rng=sim.NumpyRNG(seed=1))
    some = sim.Projection(one, one, chosen, sim.StaticSynapse(weight=2))
    assert 5 < len(some) < 31
    some.set(weight=3)
    assert {weight for _, _, weight in some.get("weight", format="list")} == {3.0}
    both = one + sim.Population(2, sim.RollsNeuron())
    assert len(sim.Projection(both, both, sim.OneToOneConnector(), sim.StaticSynapse(weight=1))) == 8


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        (lambda _: sim.IF_curr_exp, r"^pynn\.IF_curr_exp: neurons of ROLLS share the biases"),
        (lambda _: sim.STDPMechanism, "have one of eight levels; take StaticSynapse"),
        (lambda _: sim.DCSource, "no current that a program drives"),
        (lambda _: sim.pause, r"^pynn\.pause: not there on ROLLS"),
        (lambda one: one.inject(None), r"^pynn\.one\.inject: ROLLS has no current"),
        (lambda one: one.record("v"), r"^pynn\.one\.record: v, must be spikes"),
        (lambda one: one.initialize(v=0.1), r"^pynn\.one\.v: neurons of ROLLS begin at rest"),
        (lambda _: sim.Population(256, sim.RollsNeuron(), label="b"), r"b: 256 cells, must be <= 253;"),
        (lambda one: joined(one, weight=0.3), "weight 0.3, must be 1, 2, 3 or 4"),
        (lambda one: joined(one, weight=5), "weight 5, must be 1, 2, 3 or 4"),
        (lambda one: joined(one, weight=1, delay=5.0), "delay 5 ms, must be 0.4 ms, the step"),
        (lambda one: sim.Projection(one, source(), sim.AllToAllConnector(), sim.StaticSynapse()),
         r"^pynn\.source: sources have no synapses; project to neurons"),
        (lambda _: source([1.0, -5.0]), r"^pynn\.source\.spike_times: -5 ms, must be 0 or more"),
        (lambda _: source().set(spike_times=[-1.0]), "spike_times: -1 ms, must be 0 or more"),
        (lambda _: sim.Population(2, sim.SpikeSourcePoisson(rate=-5.0)), "rate: -5 Hz, must be 0 or more"),
        (lambda one: [joined(one, weight=w) for w in (1, 2)] + [sim.program()], "2 of a pair that has"),
        (lambda _: sim.run(0.3), r"^pynn\.run: 0\.3 ms, must be whole steps of 0\.4 ms"),
        (lambda one: [joined(one, weight=2) for _ in range(2)] + [sim.program()],
         r"weight 2 of a pair that has 2 already, must be alone; .* with_replacement=False"),
        (lambda _: sim.Population(2, sim.SpikeSourcePoisson(start=float("nan"))), "start: nan ms, must be 0"),
        (lambda _: sim.run(float("nan")), r"^pynn\.run: nan ms, must be finite"),
        (lambda _: sim.setup(timestep=0.0), r"timestep: 0 ms, must be > 0"),
        (lambda _: sim.setup(min_delay=2.0), r"min_delay: 2\.0 ms, must be auto"),
        (lambda _: sim.setup(dye=3), "pynn.setup dye: unknown; did you mean die"),
    ],
)  # fmt: skip
def test_what_the_chip_lacks_is_refused(asked: Callable[[Any], object], told: str) -> None:
    one = sim.Population(3, sim.RollsNeuron(), label="one")
    with pytest.raises(CircuitError, match=told):
        asked(one)


def source(times: Any = ()) -> Any:
    return sim.Population(2, sim.SpikeSourceArray(spike_times=list(times)), label="source")


def joined(one: Any, **given: float) -> Any:
    return sim.Projection(one, one, sim.AllToAllConnector(), sim.StaticSynapse(**given))


def recorded(each: Any, *, clear: bool = False) -> list[float]:
    """Times of the first cell of a population in its last segment, ms."""
    found: list[float] = each.get_data(clear=clear).segments[-1].spiketrains[0].magnitude.tolist()
    return found


def test_what_a_source_gave_stays_recorded_when_its_parameters_change() -> None:
    given, noise = source([5.0, 10.0]), sim.Population(1, sim.SpikeSourcePoisson(rate=300.0))
    given.record("spikes")
    noise.record("spikes")
    sim.run(20.0)
    before = recorded(noise)
    assert before
    with pytest.warns(UserWarning, match=r"source\.spike_times: 1 events before now, 20 ms, which do not"):
        given[0:1].set(spike_times=[5.0, 15.0, 25.0])
    noise.set(rate=0.0)
    sim.run(20.0)
    assert (recorded(given), recorded(noise)) == ([5.0, 10.0, 25.0], before)
    sim.reset()
    sim.run(40.0)
    assert recorded(given) == [5.0, 15.0, 25.0]


def test_data_are_cleared_and_recording_begins_where_a_script_says_so() -> None:
    given, one = source(GIVEN), sim.Population(2, sim.RollsNeuron())
    sim.Projection(given, one, sim.OneToOneConnector(), sim.StaticSynapse(weight=4))
    one.record("spikes")
    sim.run(20.0)
    given.record("spikes")
    whole = recorded(one, clear=True)
    sim.run(40.0)
    assert recorded(given) == [30.0, 31.0, 32.0, 33.0]
    later = recorded(one)
    assert whole
    assert later
    assert (max(whole) < 20.0, min(later) >= 20.0) == (True, True)
    assert one.get_spike_counts()[one[0]] == len(later)


def test_weights_are_set_as_pynn_sets_them_and_not_after_the_first_run() -> None:
    one = sim.Population(3, sim.RollsNeuron(), structure=sim.Line(), label="one")
    some = joined(one, weight=1)
    wanted = np.arange(9.0).reshape(3, 3) % 4 + 1
    some.set(weight=wanted)
    assert np.array_equal(some.get("weight", format="array"), wanted)
    assert np.array_equal(sim.program().levels[:3, :3], wanted.T)
    some.set(weight="1 + (d > 1.5)")
    assert some.get("weight", format="array").tolist() == [[1, 1, 2], [1, 1, 1], [2, 1, 1]]
    with pytest.raises(CircuitError, match=r"weight 0\.5, must be 1, 2, 3 or 4"):
        some.set(weight=[4.0] * 8 + [0.5])
    some.set(weight=sim.RandomDistribution("uniform_int", low=3, high=5, rng=sim.NumpyRNG(seed=1)))
    assert set(some.get("weight", format="array").ravel()) == {3.0, 4.0}
    for each in some:
        each.weight = 2
    sim.run(0.4)
    with pytest.raises(CircuitError, match="changed after the first run"):
        some[0].weight = 3
    assert set(some.get("weight", format="array").ravel()) == {2.0}


@pytest.mark.parametrize(("before", "after"), [(1, 1), (1, 3), (3, 1), (3, 3)])
@pytest.mark.parametrize("made", [sim.OneToOneConnector, pyNN.connectors.OneToOneConnector])
def test_cells_connect_one_to_one_however_few_they_are(made: Any, before: int, after: int) -> None:
    source = sim.Population(before + 2, sim.SpikeSourcePoisson(rate=9.0))
    neurons = sim.Population(after + 2, sim.RollsNeuron())
    for pre, post in ((source[1 : 1 + before], neurons[1 : 1 + after]), (source[0:1], neurons[0:1])):
        weights = sim.RandomDistribution("uniform_int", (1, 4), rng=sim.NumpyRNG(seed=1))
        found = sim.Projection(pre, post, made(), sim.StaticSynapse(weight=weights))
        assert [each[:2] for each in found.get("weight", "list")] == [
            (k, k) for k in range(min(pre.size, post.size))
        ]


def test_synapses_onto_an_assembly_excite_unless_asked_whatever_the_order_of_a_set() -> None:
    source = sim.Population(1, sim.SpikeSourcePoisson(rate=300.0))
    both = sim.Population(2, sim.RollsNeuron()) + sim.Population(2, sim.RollsNeuron())
    assert both.receptor_types == ["excitatory", "inhibitory"]
    found = sim.Projection(source, both, sim.AllToAllConnector(), sim.StaticSynapse(weight=4))
    assert found.receptor_type == "excitatory"
    assert (sim.program().levels[:4, 255] == 4).all()


def test_cells_of_an_assembly_are_where_they_stand() -> None:
    line = sim.Population(3, sim.RollsNeuron(), structure=sim.Line(dx=10.0))
    near = sim.DistanceDependentProbabilityConnector("d < 5")
    found = [
        sim.Projection(line, post, near, sim.StaticSynapse()).get("weight", "list")
        for post in (line, sim.Assembly(line))
    ]
    assert [each[:2] for each in found[0]] == [each[:2] for each in found[1]] == [(k, k) for k in range(3)]
    one = sim.Assembly(line[0:1])
    weights = sim.Projection(line, one, sim.AllToAllConnector(), sim.StaticSynapse(weight="1 + (d > 5)"))
    assert weights.get("weight", "array").ravel().tolist() == [1.0, 2.0, 2.0]


@pytest.mark.parametrize("row", [(0, 2), (0, -1), (-1, 0), (0.5, 0)])
def test_a_list_with_a_cell_that_is_not_there_is_refused(row: tuple[float, float], tmp_path: Path) -> None:
    one = sim.Population(2, sim.RollsNeuron(), label="one")
    np.savetxt(tmp_path / "list.txt", [(1, 1, 2.0, 0.4), (*row, 2.0, 0.4)])
    for connector in (
        sim.FromListConnector([(1, 1), row]),
        sim.FromFileConnector(str(tmp_path / "list.txt")),
    ):
        with pytest.raises(
            CircuitError, match=r"pynn.one→one: listed from .*, must be from cells 0 to 1 to cells"
        ):
            sim.Projection(one, one, connector, sim.StaticSynapse())
    assert not sim.program().levels.any()


def test_a_kind_of_cells_may_be_given_for_its_usual_cell() -> None:
    with pytest.warns(DeprecationWarning, match="celltype class"):
        found = sim.Population(2, sim.RollsNeuron)
    assert not np.any(found.get("slow_leak"))


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        (lambda _: sim.Population(0, sim.RollsNeuron(), label="none"), "pynn.none: 0 cells, must be >= 1"),
        (
            lambda one: sim.Projection(
                one, one, sim.AllToAllConnector(), sim.StaticSynapse(weight=np.ones((3, 3)))
            ),
            "pynn.one→one.weight: an array of 3 x 3, must be 2 x 2",
        ),
        (
            lambda one: sim.Projection(
                one, one[0:1], sim.AllToAllConnector(), sim.StaticSynapse(weight=np.ones((1, 2))), label="p"
            ),
            "pynn.p.weight: an array of 1 x 2, must be 2 x 1",
        ),
        (lambda one: one.get("tau_m"), "pynn.one.tau_m: not a parameter, must be slow_leak"),
        (lambda one: one[0:1].get("tau_m"), "pynn.one.tau_m: not a parameter, must be slow_leak"),
    ],
)
def test_what_is_not_there_is_told_in_a_line(asked: Callable[[Any], object], told: str) -> None:
    one = sim.Population(2, sim.RollsNeuron(), label="one")
    with pytest.raises(CircuitError, match=told):
        asked(one)


class Later(IndexBasedExpression):  # type: ignore[misc]  # PyNN has no types
    """Whether the second cell's number is the higher one."""

    def __call__(self, i: Any, j: Any) -> Any:
        return 1.0 * (i < j)


BESIDE = {
    (0, 1),
    (1, 2),
    (2, 3),
}  # of four cells in a line, 10 um apart, those of which one is right of the other
PAIRS = {(i, j) for i in range(4) for j in range(4)}
CONNECTORS: dict[str, tuple[Callable[[Any], Any], set[tuple[int, int]] | int | None]] = {
    "AllToAllConnector": (lambda c: c(), PAIRS),
    "ArrayConnector": (lambda c: c(np.eye(4, k=1, dtype=np.bool_)), BESIDE),
    "CloneConnector": (lambda c: c(state.projections[0]), {(0, 3)}),
    "DisplacementDependentProbabilityConnector": (
        lambda c: c(lambda d: 1.0 * (abs(d[0] - 10.0) < 1.0)),
        BESIDE,
    ),
    "DistanceDependentProbabilityConnector": (lambda c: c("d < 5"), {(k, k) for k in range(4)}),
    "FixedNumberPostConnector": (lambda c: c(2, with_replacement=False), 8),
    "FixedNumberPreConnector": (lambda c: c(2, with_replacement=False), 8),
    "FixedProbabilityConnector": (lambda c: c(1.0), PAIRS),
    "FixedTotalNumberConnector": (lambda c: c(12, with_replacement=False, allow_self_connections=False), 12),
    "FromFileConnector": (lambda c: c("list.txt"), {(1, 2)}),
    "FromListConnector": (lambda c: c([(1, 2)]), {(1, 2)}),
    "IndexBasedProbabilityConnector": (lambda c: c(Later()), {(i, j) for i, j in PAIRS if i < j}),
    "OneToOneConnector": (lambda c: c(), {(k, k) for k in range(4)}),
    "SmallWorldConnector": (lambda c: c(2.0, 0.1), None),
    "CSAConnector": (lambda c: c.__new__(c), None),
    "FixedNumberConnector": (lambda c: c(2), None),
    "MapConnector": (lambda c: c(), None),
    "Connector": (lambda c: c(), None),
}


def test_every_connector_of_pynns_is_known() -> None:
    found = {
        name
        for name, each in vars(pyNN.connectors).items()
        if isinstance(each, type) and issubclass(each, pyNN.connectors.Connector)
    }
    assert found == set(CONNECTORS)


@pytest.mark.parametrize("name", CONNECTORS)
def test_a_connector_of_pynns_works_or_is_refused_in_a_line(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    np.savetxt("list.txt", [(1, 2, 2.0, 0.4)])
    make, wanted = CONNECTORS[name]
    line = sim.Population(4, sim.RollsNeuron(), structure=sim.Line(dx=10.0), label="line")
    if name == "CloneConnector":
        sim.Projection(
            line, line, sim.FromListConnector([(0, 3)]), sim.StaticSynapse(), receptor_type="inhibitory"
        )
    made = make(getattr(pyNN.connectors, name))
    if wanted is None:
        with pytest.raises(
            CircuitError, match=rf"^pynn.line→line: {name}, .*; take an ArrayConnector of its [a-z]+$"
        ):
            sim.Projection(line, line, made, sim.StaticSynapse())
        with pytest.raises(AttributeError, match=rf"^pynn.{name}: .*; take an ArrayConnector of its [a-z]+$"):
            getattr(sim, name)
        return
    assert getattr(sim, name) is getattr(pyNN.connectors, name)
    found = sim.Projection(line, line, made, sim.StaticSynapse())
    pairs = [(each.presynaptic_index, each.postsynaptic_index) for each in found]
    assert (len(pairs) if isinstance(wanted, int) else set(pairs)) == wanted
    assert len(set(pairs)) == len(pairs)
    if name == "FixedTotalNumberConnector":
        assert set(pairs) == {(i, j) for i, j in PAIRS if i != j}


def test_pairs_that_are_to_differ_are_no_more_than_there_are() -> None:
    line = sim.Population(4, sim.RollsNeuron(), label="line")
    many = sim.FixedTotalNumberConnector(17, with_replacement=False)
    with pytest.raises(CircuitError, match=r"^pynn.line→line: 17 pairs, must be at most 16; take fewer$"):
        sim.Projection(line, line, many, sim.StaticSynapse())
    once = sim.FixedTotalNumberConnector(3, allow_self_connections="NoMutual", with_replacement=False)
    with pytest.raises(CircuitError, match=r"allow_self_connections: NoMutual, must be True or False; draw"):
        sim.Projection(line, line, once, sim.StaticSynapse())
    drawn = sim.FixedTotalNumberConnector(
        sim.RandomDistribution("uniform_int", (5, 6), rng=sim.NumpyRNG(seed=3)), with_replacement=False
    )
    assert len(sim.Projection(line, line, drawn, sim.StaticSynapse())) == 5
