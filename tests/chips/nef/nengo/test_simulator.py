"""Networks of nengo on an ideal die beside nengo, on a chip, and what is refused."""

from __future__ import annotations

import inspect
import pickle
from typing import Any

import nengo
import numpy as np
import pytest

from chips.nef.chip import NefChip
from chips.nef.nengo.simulator import Simulator
from circuits.errors import CircuitError, ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL, Process

pytestmark = pytest.mark.filterwarnings("ignore::nengo.exceptions.NengoWarning")


class World:
    """A body with a state of its own."""

    def __init__(self) -> None:
        self.place, self.calls = np.zeros(2), 0

    def __call__(self, t: float, x: Any) -> list[float]:
        self.calls += 1
        self.place = 0.9 * self.place + 0.1 * x
        return [float(np.sin(t)), float(self.place[0])]


def everything(world: World) -> tuple[nengo.Network, dict[str, nengo.Probe]]:
    """A network with all that the back-end knows."""
    with nengo.Network(seed=3) as net:
        stim = nengo.Node(lambda t: [0.5, -0.3 + 0.0 * t])
        body, passed, summed = (
            nengo.Node(world, size_in=2, size_out=2),
            nengo.Node(size_in=2),
            nengo.Node(size_in=1),
        )
        with nengo.Network():
            a = nengo.Ensemble(200, 2, radius=1.2, seed=5)
        b = nengo.Ensemble(100, 1, intercepts=nengo.dists.Uniform(0.0, 0.9), encoders=[[1]] * 100)
        memory = nengo.Ensemble(200, 2)
        array, ganglia = nengo.networks.EnsembleArray(50, 3), nengo.networks.BasalGanglia(3)
        nengo.Connection(stim, passed, synapse=None)
        nengo.Connection(passed, a)
        nengo.Connection(a, b, function=lambda x: x[0] * x[1] + 1.0 > 0.5, synapse=0.01)
        nengo.Connection(a[0], summed, function=lambda x: x**2)
        nengo.Connection(summed, array.input[1], synapse=None)
        nengo.Connection(stim[[1]], array.input[2], transform=-3.0)
        nengo.Connection(array.output, ganglia.input, synapse=0.02)
        nengo.Connection(memory[0], memory[1], synapse=0.1, transform=0.5)
        nengo.Connection(stim, memory, transform=[[0.5, 0.0], [0.0, 0.5]], synapse=0.1)
        nengo.Connection(b, memory.neurons, transform=[[-0.2]] * 200)
        nengo.Connection(a.neurons, body, transform=np.full((2, 200), 1.0 / 20_000.0), synapse=0.02)
        probes = {
            "a": nengo.Probe(a, synapse=0.05), "b": nengo.Probe(b, synapse=0.05),
            "memory": nengo.Probe(memory[1], synapse=0.05), "array": nengo.Probe(array.output, synapse=0.05),
            "ganglia": nengo.Probe(ganglia.output, synapse=0.05), "rates": nengo.Probe(a.neurons),
            "body": nengo.Probe(body, sample_every=0.01),
        }  # fmt: skip
    return net, probes


def means(simulator: Any, probes: dict[str, nengo.Probe]) -> dict[str, Any]:
    """Means over the second half."""
    found = {
        name: simulator.data[p][len(simulator.data[p]) // 2 :].mean(axis=0) for name, p in probes.items()
    }
    return found | {"rates": found["rates"].mean()}


def test_an_ideal_die_is_nengo() -> None:
    net, probes = everything(World())
    with nengo.Simulator(net, progress_bar=False, optimize=False) as peer:
        peer.run(0.4)
        theirs = {name: peer.data[p] for name, p in probes.items()}
    world = World()
    net, probes = everything(world)
    with Simulator(net, dt=0.001, seed=None, progress_bar=False, chip=None) as own:
        own.run(0.2)
        own.run_steps(199)
        own.step()
        ours = {name: own.data[p] for name, p in probes.items()}
        assert own.data[probes["a"]].shape == (400, 2)
        assert own.data[probes["body"]].shape == (40, 2)
        assert own.trange(sample_every=0.01).shape == (40,)
    assert own.time == pytest.approx(0.4)
    assert world.calls == 400
    for name, value in theirs.items():
        assert np.abs(ours[name] - value).max() < 1e-10, name  # sums in another order


@pytest.mark.parametrize("process", [ROLLS_180_IDEAL, ROLLS_180])
def test_a_chip_does_the_same_sums(process: Process) -> None:
    net, probes = everything(World())
    with Simulator(net, chip=NefChip(Die(number=7), process=process)) as run:
        assert (run._built.bends is None) == (process is ROLLS_180_IDEAL)
        run.run(0.3)
        found = means(run, probes)
    assert found["a"] == pytest.approx([0.5, -0.3], abs=0.05)
    assert found["b"] == pytest.approx([1.0], abs=0.06)  # true, as a number
    assert found["array"] == pytest.approx([0.0, 0.25, 0.9], abs=0.1)  # the square of 0.5, of 50 neurons
    assert int(np.argmax(found["ganglia"])) == 2
    assert run.counters["dropped"] == 0


def test_probes_are_cleared_and_a_closed_one_is_refused() -> None:
    with nengo.Network(seed=1) as net:
        probe = nengo.Probe(nengo.Node(lambda t: t))
    run = Simulator(net)
    run.run_steps(5)
    assert run.data[probe][:, 0] == pytest.approx([0.001, 0.002, 0.003, 0.004, 0.005])
    run.clear_probes()
    run.step()
    assert run.data[probe].shape == (1, 1)
    run.reset()
    assert run.time == 0.0
    run.step()
    run.close()
    assert run.closed
    for again in (run.step, run.reset, run.__enter__, lambda: run.run(0.01), lambda: run.run_steps(3)):
        with pytest.raises(nengo.exceptions.SimulatorClosed, match="the simulator is closed") as refusal:
            again()
        assert isinstance(refusal.value, CircuitError)
    assert run.data[probe].shape == (1, 1)
    run.clear_probes()
    assert run.data[probe].shape == (0, 1)


def test_probes_that_come_later_are_none_of_a_run() -> None:
    with nengo.Network(seed=1) as net:
        node = nengo.Node(1.0)
        first = nengo.Probe(node)
    run = Simulator(net)
    with net:
        later = nengo.Probe(node)
    run.clear_probes()
    run.step()
    assert run.data[first].shape == (1, 1)
    with pytest.raises(CircuitError, match="not a probe"):
        _ = run.data[later]


def test_times_of_samples_are_nengos() -> None:
    with nengo.Network() as net:
        node = nengo.Node(lambda t: t)
        probes = {every: nengo.Probe(node, sample_every=every) for every in (0.001, 0.0005, 0.002, 0.0015)}
    ours = Simulator(net, chip=None)
    ours.run(0.01)
    with nengo.Simulator(net, progress_bar=False) as theirs:
        theirs.run(0.01)
    assert (ours.trange() == theirs.trange()).all()
    for every, probe in probes.items():
        times = ours.trange(sample_every=every)
        assert (times == theirs.trange(sample_every=every)).all()
        assert (ours.data[probe][:, 0] == times).all()
        with pytest.warns(DeprecationWarning, match="Use `sample_every` instead"):
            assert (ours.trange(dt=every) == times).all()
    with pytest.raises(nengo.exceptions.ValidationError, match=r"dt: 0\.01 s beside sample_every"):
        ours.trange(dt=0.01, sample_every=0.01)
    with pytest.raises(ParameterError, match="sample_every: 0 s, must be > 0"):
        ours.trange(sample_every=0.0)


def test_the_interface_is_nengos_or_refused_in_a_line() -> None:
    with nengo.Network(seed=4) as net:
        nengo.Node(1.0)
    theirs = inspect.signature(nengo.Simulator).parameters
    ours = inspect.signature(Simulator).parameters
    assert list(ours)[: len(theirs)] == list(theirs)
    shown = Shown()
    run = Simulator(net, 0.001, None, None, shown, False)
    assert run.seed == 5
    run.run_steps(3)
    assert shown.steps == 3
    run.run_steps(2, progress_bar=False)
    assert shown.steps == 3
    with pytest.warns(UserWarning, match="running for 0 timesteps"):
        run.run(0.0)
    for name in ("dt", "n_steps", "time", "closed"):
        with pytest.raises(AttributeError):
            setattr(run, name, 1)
    for name in ("step_order", "signals", "dg", "rng"):
        with pytest.raises(AttributeError, match=rf"Simulator\.{name}: a chip has no signals"):
            getattr(run, name)
    with pytest.raises(AttributeError, match=r"Simulator\.other: unknown"):
        _ = run.other
    for held in (run, run.model):
        with pytest.raises(TypeError, match="cannot be pickled"):
            pickle.dumps(held)
    for wrong, says in (
        ({"model": nengo.builder.Model()}, "a chip takes no model"),
        ({"dt": None}, "dt: None s, must be 0.001 s"),
        ({"network": None}, "network: None, must be a nengo.Network"),
    ):
        with pytest.raises(nengo.exceptions.ValidationError, match=says):
            Simulator(**{"network": net, **wrong})


class Shown(nengo.utils.progress.ProgressBar):  # type: ignore[misc]  # nengo has no types
    """A bar that keeps what it is shown."""

    steps = 0

    def update(self, progress: Any) -> None:
        if progress.name_after == "Simulation":
            self.steps = progress.n_steps


def test_gains_solvers_and_points_are_told_as_nengo_tells_them() -> None:
    with nengo.Network(seed=4) as net:
        a = nengo.Ensemble(20, 1, gain=nengo.dists.Uniform(1.0, 4.0), bias=nengo.dists.Uniform(1.2, 2.0))
        none = nengo.Connection(a, nengo.Node(size_in=1), solver=nengo.solvers.NoSolver(np.ones((20, 1))))
        few = nengo.Connection(a, nengo.Node(size_in=1), solver=nengo.solvers.LstsqL2(reg=0.0))
        seen = nengo.Probe(a, solver=nengo.solvers.LstsqL2nz(reg=0.02))
    ours = Simulator(net, chip=None)
    ours.run_steps(50)
    with nengo.Simulator(net, progress_bar=False) as theirs:
        theirs.run_steps(50)
    assert (ours.data[a].gain == theirs.data[a].gain).all()
    assert (ours.data[a].bias == theirs.data[a].bias).all()
    assert ours.data[none].eval_points is None
    assert (ours.data[none].weights == theirs.data[none].weights).all()
    assert ours.data[few].weights == pytest.approx(theirs.data[few].weights)
    assert np.allclose(ours.data[seen], theirs.data[seen], rtol=0.0, atol=1e-10)


def test_a_seed_repeats_a_run() -> None:
    found = []
    for _ in range(2):
        net, probes = everything(World())
        with Simulator(net, seed=9, chip=NefChip(Die(number=7))) as run:
            run.run(0.05)
            found.append(run.data[probes["rates"]])
    assert (found[0] == found[1]).all()


def test_parts_are_told_as_nengo_tells_them() -> None:
    net, probes = everything(World())
    with nengo.Simulator(net, progress_bar=False, optimize=False) as peer:
        theirs = dict(peer.data)
    run = Simulator(net, chip=None)
    assert set(run.data) == {*net.all_probes, *net.all_ensembles, *net.all_connections, *net.all_nodes} | {
        net,
        *net.all_networks,
    }
    for e in net.all_ensembles:
        for ours, own in zip(run.data[e], theirs[e], strict=True):
            assert ours == pytest.approx(own)
    for c in net.all_connections:
        found = run.data[c]
        assert found.transform == theirs[c].transform
        if theirs[c].weights is None:
            assert found.weights is None
        else:
            assert found.weights.shape == theirs[c].weights.shape
            assert found.weights == pytest.approx(theirs[c].weights, abs=1e-2 * np.abs(found.weights).max())
    curves = nengo.utils.ensemble.tuning_curves(net.all_ensembles[1], run)
    assert run.rates(net.all_ensembles[1], curves[0]) == pytest.approx(curves[1])
    assert run.data[net.all_nodes[0]] is None
    assert run.model.params[probes["a"]].shape == (0, 2)
    with pytest.raises(CircuitError, match="not a probe, ensemble"):
        run.data[nengo.Ensemble(3, 1, add_to_container=False)]
    with pytest.raises(AttributeError, match=r"Simulator\.model\.sig: a chip has no signals"):
        _ = run.model.sig


def test_samples_are_a_view_that_grows_and_cannot_be_written() -> None:
    with nengo.Network(seed=1) as net:
        probe = nengo.Probe(nengo.Node(lambda t: t))
    run = Simulator(net)
    run.run_steps(1)
    first = run.data[probe]
    run.run_steps(600)
    assert run.data[probe].shape == (601, 1)
    assert run.data[probe][:, 0] == pytest.approx(0.001 * np.arange(1, 602))
    assert np.shares_memory(run.data[probe], run.data[probe])
    assert first.tolist() == [[0.001]]
    with pytest.raises(ValueError, match="read-only"):
        run.data[probe][0] = 1.0


@pytest.mark.parametrize("tau_ref", [0.002, 0.004])
def test_a_chip_saturates_as_the_neurons_that_were_asked_for(tau_ref: float) -> None:
    with nengo.Network(seed=2) as net:
        net.config[nengo.Ensemble].neuron_type = nengo.LIF(tau_ref=tau_ref)
        net.config[nengo.Ensemble].max_rates = nengo.dists.Uniform(100.0, 200.0)
        e = nengo.Ensemble(200, 1)
        read = nengo.Connection(e, nengo.Node(size_in=1))
    ideal, chip = Simulator(net, chip=None), Simulator(net)
    points = np.array([[0.5], [1.0], [1.5]])
    ours, asked = ((s.rates(e, points) @ s.data[read].weights.T)[:, 0] for s in (chip, ideal))
    assert ours == pytest.approx(asked, rel=0.05)


def test_a_refractory_period_beyond_the_chip_is_refused() -> None:
    with nengo.Network(seed=2) as net:
        nengo.Ensemble(20, 1, neuron_type=nengo.LIF(tau_ref=1e-5))
    with pytest.raises(CircuitError, match=r"tau_ref: 1e-05 s, the chip's .* from 0\.0002 to 0\.02 s"):
        Simulator(net)


def test_a_synapse_slower_than_the_chips_is_refused_there_and_runs_without_it() -> None:
    with nengo.Network(seed=2) as net:
        a, b = (nengo.Ensemble(10, 1, label=name) for name in "ab")
        nengo.Connection(a, b, synapse=5.0)
        nengo.Probe(b, synapse=5.0)  # which a computer filters
    with pytest.raises(CircuitError, match=r"connection 0\.a to 1\.b\.synapse: 5 s, must be at most 0\.5 s"):
        Simulator(net)
    with Simulator(net, chip=None) as simulator:
        simulator.run(5e-3)


SPARSE = nengo.Sparse((1, 1), indices=[[0, 0]], init=[1.0])


def elsewhere() -> Any:
    return nengo.Ensemble(5, 1, add_to_container=False)


def silent() -> Any:
    return nengo.Ensemble(5, 1, intercepts=nengo.dists.Choice([0.5]), encoders=nengo.dists.Choice([[1.0]]))


def dense() -> None:
    a, b = nengo.Ensemble(50, 1), nengo.Ensemble(50, 1)
    nengo.Connection(a.neurons, b.neurons, transform=np.random.default_rng(0).normal(size=(50, 50)))


def learns(a: Any) -> None:
    nengo.Connection(a, a, learning_rule_type=nengo.PES())


def circle(_: Any) -> None:
    one, two = nengo.Node(size_in=1), nengo.Node(size_in=1)
    nengo.Connection(one, two, synapse=None)
    nengo.Connection(two, one, synapse=None)


def slow(a: nengo.Ensemble) -> None:
    nengo.Connection(a, a, synapse=2.0)


@pytest.mark.parametrize(
    ("add", "says"),
    [
        (lambda _: nengo.Ensemble(9000, 1), "the chip has 8192"),
        (lambda _: nengo.Ensemble(100, 64), "64 dimensions and 0 currents .* the chip has 64; split it"),
        (lambda _: dense(), "50 currents into its neurons"),
        (slow, "synapse: 2 s, must be at most"),
    ],
)
def test_what_has_no_room_is_refused_before_the_chip_is_calibrated(
    add: Any, says: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object) -> None:
        raise AssertionError("calibrated")

    monkeypatch.setattr(NefChip, "at", never)
    with nengo.Network(seed=1) as net:
        add(nengo.Ensemble(10, 1))
    with pytest.raises(nengo.exceptions.BuildError, match=says):
        Simulator(net)
    with nengo.Network(seed=1) as net:
        nengo.Ensemble(10, 1)
    with pytest.raises(AssertionError, match="calibrated"):
        Simulator(net)


@pytest.mark.parametrize(
    ("add", "says"),
    [
        (learns, "learning_rule"),
        (circle, "circle of nodes"),
        (lambda a: nengo.Connection(a, a, synapse=nengo.Alpha(0.1)), "must be a low-pass or None"),
        (lambda a: nengo.Connection(a, a, solver=nengo.solvers.LstsqL2(weights=True)), "weights"),
        (lambda a: nengo.Connection(a, a, transform=SPARSE), "must be dense"),
        (lambda _: nengo.Ensemble(5, 1, neuron_type=nengo.AdaptiveLIF()), "must be LIF"),
        (lambda _: nengo.Ensemble(5, 1, neuron_type=nengo.LIF(tau_rc=0.1)), "must all be alike"),
        (lambda _: nengo.Ensemble(5, 1, noise=nengo.processes.WhiteNoise()), "no injected noise"),
        (lambda _: nengo.Ensemble(9000, 1), "the chip has 8192"),
        (lambda _: nengo.Ensemble(100, 64), "64 dimensions and 0 currents"),
        (lambda _: dense(), "1 dimensions and 50 currents into its neurons take 202 encoder columns"),
        (lambda a: nengo.Probe(a, solver=nengo.solvers.Lstsq(weights=True)), "must not solve for weights"),
        (lambda a: nengo.Connection(elsewhere(), a), "is not of this network"),
        (lambda a: nengo.Connection(a, elsewhere()), "is not of this network"),
        (lambda _: nengo.Probe(elsewhere()), "is not of this network"),
        (
            lambda a: nengo.Connection(silent(), a, eval_points=[[-1.0]]),
            "no neuron of .* fires at the points",
        ),
        (lambda _: nengo.Ensemble(5, 1, gain=[1.0] * 5, bias=[0.0] * 5), r"intercepts: 1, by gain and bias"),
        (lambda a: nengo.Probe(a.neurons, "voltage"), "must be an output, or spikes"),
        (lambda a: nengo.Connection(a, a, function=lambda x: x * np.nan), "not finite"),
    ],
)
def test_what_it_cannot_do_is_refused_by_name(add: Any, says: str) -> None:
    with nengo.Network(seed=1) as net:
        a = nengo.Ensemble(10, 1)
        add(a)
    with pytest.raises(ParameterError, match=says) as refusal:
        Simulator(net)
    assert isinstance(refusal.value, nengo.exceptions.BuildError)
    with pytest.raises(CircuitError, match=r"dt: 0\.002 s"):
        Simulator(net, dt=0.002)


def test_times_and_steps_that_are_none_are_refused() -> None:
    with nengo.Network() as network:
        nengo.Node(1.0)
    ours = Simulator(network, chip=None)
    for steps in (-1, 2.5):
        with pytest.raises(ParameterError, match=f"steps: {steps}, must be a whole number >= 0"):
            ours.run_steps(steps)  # type: ignore[arg-type]  # what a script may give
    with pytest.raises(ParameterError, match="time_in_seconds: nan s, must be >= 0 and finite"):
        ours.run(float("nan"))
    ours.run_steps(np.int64(3))
    assert ours.n_steps == 3


def test_what_a_solver_tells_is_there_as_nengo_tells_it() -> None:
    solvers = nengo.solvers
    with nengo.Network(seed=3) as net:
        node, out = nengo.Node([0.3, 0.1]), nengo.Node(size_in=1)
        a, b = nengo.Ensemble(60, 2), nengo.Ensemble(40, 1)
        decoded = [
            nengo.Connection(a, b, function=lambda x: x[0] * x[1]),
            nengo.Connection(a[0], out),
            nengo.Connection(a[1], b, solver=solvers.LstsqL2(reg=0.01)),
            nengo.Connection(a[0], b, solver=solvers.Lstsq()),
            nengo.Connection(a[0], b, solver=solvers.LstsqDrop()),
            nengo.Connection(a[0], b, solver=solvers.NoSolver(np.zeros((60, 1)))),
        ]
        others = [
            nengo.Connection(node, a),
            nengo.Connection(a.neurons, b, transform=np.zeros((1, 60))),
            nengo.Connection(node[0], out),
        ]
    with nengo.Simulator(net, progress_bar=None) as theirs:
        told = theirs.data
    ours, on_chip = Simulator(net, chip=None), Simulator(net)
    for c in others:
        assert told[c].solver_info is None
        assert ours.data[c].solver_info is None
    for c in decoded:
        asked, found = told[c].solver_info, ours.data[c].solver_info
        assert found.keys() == asked.keys() == on_chip.data[c].solver_info.keys()
        if "rmses" in asked:
            assert found["rmses"] == pytest.approx(asked["rmses"], rel=1e-6)
            assert 0.5 < float(on_chip.data[c].solver_info["rmses"][0] / asked["rmses"][0]) < 2.0
            assert found["time"] > 0.0
