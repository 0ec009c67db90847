"""Networks on ROLLS: what the mapping expects is what the nominal die does, and what cannot be is refused."""

from pathlib import Path

import nir
import numpy as np
import pytest

from chips.aer import Events
from chips.rolls.program.program import Program
from circuits.errors import DataError, ParameterError
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.mapping.chips import map_on
from system.mapping.dynamics import rates_of, usual_rates
from system.mapping.network import Connection, Input, Network, Population
from system.mapping.network_file import read_network
from system.mapping.nir.read import network_of_graph
from system.mapping.program_file import read_program_file, write_program
from system.mapping.rolls.calibrate import calibrated
from system.mapping.rolls.filters import NOTHING
from system.mapping.rolls.mapped import Mapped, Placed, virtual_inputs
from system.mapping.run import MappedRun, check_channels, run_mapped
from system.spikes.read import read_spikes

EXAMPLES = Path("examples")
NEAR, FEW = 0.10, 2.0  # of a rate, or Hz: the bar of issue 36


def poisson(rates: list[tuple[float, float, float]], seed: int) -> Events:
    """Events of channels, each with a rate (Hz) between two times (s)."""
    rng = np.random.default_rng(seed)
    trains = [np.sort(rng.uniform(a, b, rng.poisson(rate * (b - a)))) for rate, a, b in rates]
    times = np.concatenate(trains)
    order = np.argsort(times, kind="stable")
    return Events(times[order], np.repeat(np.arange(len(trains)), [t.size for t in trains])[order])


def check_rates(run: MappedRun) -> None:
    """Each population's rate on the die is that which the mapping expects."""
    for name, rate in run.rates["expected"].items():
        assert run.rates["chip"][name] == pytest.approx(rate, rel=NEAR, abs=FEW), name


@pytest.fixture(scope="module")
def memory() -> Mapped:
    """The working memory on ROLLS."""
    return map_on("rolls", read_network(EXAMPLES / "working-memory.toml"))


@pytest.fixture(scope="module")
def written() -> Events:
    """Events that write, and 0.5 s later erase."""
    return read_spikes(str(EXAMPLES / "write-and-erase.csv"))


def test_a_working_memory_holds_what_was_written_until_it_is_erased(memory: Mapped, written: Events) -> None:
    run = run_mapped(memory, written, Silicon(ROLLS_180), 1.2)
    check_rates(run)
    for trains in (run.asked, run.chip):
        held = trains.times[(trains.times > 0.4) & (trains.times < 0.75)].size / (48 * 0.35)
        assert held > 50.0
        assert not (trains.times > 1.0).any()
    assert (run.lost_in, run.lost_out, run.held) == (0, 0, 0)


def test_a_program_comes_back_from_its_file(memory: Mapped, tmp_path: Path) -> None:
    write_program(tmp_path / "p.toml", memory)
    found = read_program_file(tmp_path / "p.toml")
    assert found.network == memory.network
    assert (found.placed, found.filters, found.findings) == (memory.placed, memory.filters, memory.findings)
    for name in ("levels", "tau1", "inputs", "virtual"):
        assert np.array_equal(getattr(found.program, name), getattr(memory.program, name))
    assert found.program.biases.codes() == memory.program.biases.codes()
    assert np.array_equal(found.excite, memory.excite)
    assert np.array_equal(found.inhibit, memory.inhibit)


def test_a_run_tells_spikes_that_a_mapping_loses_and_what_brings_them_back() -> None:
    """At strong currents the filters fall short; with the rates of these events given they do by less."""
    network = Network(
        (Population("cells", 16, 20e-3),), (Input("in", 1),), (Connection("in", "cells", 0.9, tau=5e-3),)
    )
    events, silicon = poisson([(1500.0, 0.0, 0.6)], 1000), Silicon(ROLLS_180)
    run = run_mapped(map_on("rolls", network), events, silicon)
    lost = 1.0 - run.rates["expected"]["cells"] / run.rates["asked"]["cells"]
    assert lost > 0.15
    (told,) = (line for line in run.cautions if line.startswith("cells: "))
    assert f"({-lost:+.0%})" in told
    assert "give noctule map usual events as its input" in told
    again = run_mapped(map_on("rolls", network, usual_rates(network, events, 0.6)), events, silicon)
    assert 1.0 - again.rates["expected"]["cells"] / again.rates["asked"]["cells"] < 0.5 * lost
    assert not any("usual" in line for line in again.cautions)


def rate_of(drive: float) -> float:
    """Rate of a neuron of 20 ms under a constant current in units of what fires it, Hz."""
    return 0.0 if drive <= 1.0 else float(1.0 / (20e-3 * np.log(drive / (drive - 1.0))))


def test_a_bias_of_a_graph_is_on_the_chip_what_it_is_in_the_network() -> None:
    """Populations under constant currents; of Norse's kind, whose synapses have a time constant."""
    levels = [0.5, 1.5, 2.0, 3.0]
    ones, drives = np.ones(24), np.repeat(levels, 6)
    cells = nir.CubaLIF(5e-3 * ones, 20e-3 * ones, ones, 0.0 * ones, ones)
    network = network_of_graph(nir.NIRGraph.from_list(nir.Affine(0.01 * np.eye(24), drives), cells))
    mapped = map_on("rolls", network, usual_rates(network, NOTHING, 1.0))
    run = run_mapped(mapped, NOTHING, Silicon(ROLLS_180), 1.1)
    asked, got = (rates_of(t, 24, 0.1, 1.1).reshape(4, 6).mean(axis=1) for t in (run.asked, run.chip))
    assert got == pytest.approx(rates_of(run.expected, 24, 0.1, 1.1).reshape(4, 6).mean(axis=1), rel=NEAR)
    assert asked == pytest.approx([rate_of(x) for x in levels], rel=0.05)
    (one,), (placed,) = mapped.filters, mapped.placed
    pivot = one.pivot / placed.current  # what the report tells of the filter: a power of what comes in
    assert got == pytest.approx([rate_of(pivot * (x / pivot) ** one.power) for x in levels], rel=NEAR)
    assert (run.lost_in, run.lost_out, run.later) == (0, 0, 0)
    with pytest.raises(DataError, match="event 0 of address 24, must be of a channel of outside"):
        check_channels(network, Events(np.array([0.1]), np.array([24])), "e.csv")


def test_an_input_that_no_synapse_hears_is_told() -> None:
    weights = {"loud": 0.5, "faint": 1e-6}
    network = Network(
        (Population("a", 2),), tuple(Input(name, 1) for name in weights),
        tuple(Connection(name, "a", weight) for name, weight in weights.items()),
    )  # fmt: skip
    told = {f.where: f for f in map_on("rolls", network).findings if f.what == "events"}
    assert told["loud"].how == "exact"
    assert (told["faint"].how, told["faint"].note) == ("approximate", "none of them has a synapse")


def test_the_nominal_die_needs_no_calibration(memory: Mapped) -> None:
    found = calibrated(memory, Silicon(ROLLS_180))
    assert found.program.biases.codes() == memory.program.biases.codes()


def test_many_weights_and_two_membranes_are_drawn_together_and_still_as_expected() -> None:
    rng = np.random.default_rng(1000)
    inner = rng.normal(0.0, 0.08, (60, 60)) * (rng.random((60, 60)) < 0.3)
    outer = np.abs(rng.normal(0.3, 0.15, (60, 20))) * (rng.random((60, 20)) < 0.3)
    network = Network(
        (Population("a", 60), Population("b", 40, 10e-3)),
        (Input("in", 20),),
        (
            Connection("in", "a", rule="matrix", matrix=outer, tau=5e-3),  # type: ignore[arg-type]
            Connection("a", "a", rule="matrix", matrix=inner, tau=8e-3),  # type: ignore[arg-type]
            Connection("a", "b", 0.04, tau=12e-3),
            Connection("b", "a", -0.03),
        ),
    )
    mapped = map_on("rolls", network)
    assert [p.slow for p in mapped.placed] == [True, False]
    check_rates(run_mapped(mapped, poisson([(200.0, 0.0, 0.4)] * 20, 1000), Silicon(ROLLS_180)))
    told = {(f.where, f.what): f for f in mapped.findings}
    assert told["a -> a", "weights"].how == "approximate"
    assert told["a -> b", "tau"].how == "approximate"
    assert all(f.error for f in mapped.findings if f.how == "approximate")


def test_a_caution_names_what_makes_rates_others() -> None:
    """Two populations share a refractory period: no usual events bring their rates back."""
    network = Network(
        (Population("quick", 4, refractory=0.0), Population("lazy", 4, refractory=20e-3)),
        (Input("in", 1),),
        tuple(Connection("in", name, 0.5, tau=5e-3) for name in ("quick", "lazy")),
    )
    run = run_mapped(map_on("rolls", network), poisson([(1500.0, 0.0, 0.6)], 1000), Silicon(ROLLS_180))
    (told,) = (line for line in run.cautions if "were asked for" in line)
    assert told.endswith("its neurons, time constants or weights are others, as noctule show tells")


def test_a_run_without_events_is_as_long_as_it_takes_to_settle_and_count(memory: Mapped) -> None:
    run = run_mapped(memory, NOTHING, Silicon(ROLLS_180))
    assert run.duration == pytest.approx(0.2, abs=1e-3)
    assert run.rates["chip"] == {"memory": 0.0}


def one_input(*connections: Connection) -> Network:
    """Four neurons and an input, with connections."""
    return Network((Population("a", 4),), (Input("in", 1),), connections)


def test_an_input_that_excites_and_then_inhibits_does_both() -> None:
    """The mean of both is 0 in the second network, whose synapses are there all the same."""
    for slow in (-0.05, -0.1):
        mapped = map_on(
            "rolls", one_input(Connection("in", "a", tau=5e-3), Connection("in", "a", slow, tau=50e-3))
        )
        by_name = {f.name: f.tau for f in mapped.filters}
        assert by_name == pytest.approx({"virtual_excitatory": 5e-3, "virtual_inhibitory": 50e-3}, rel=0.05)
        told = [f for f in mapped.findings if f.where == "in -> a"]
        assert [f.what for f in told] == ["tau", "weights"] * 2
        assert all(abs(f.error) < 0.05 for f in told)
        check_rates(run_mapped(mapped, poisson([(1000.0, 0.0, 0.6)], 1000), Silicon(ROLLS_180), 0.6))


def test_a_neuron_that_excites_and_inhibits_another_is_refused_unless_both_add_up() -> None:
    drive, fast = Connection("in", "a", tau=5e-3), Connection("a", "a", 0.3)
    slow = Connection("a", "a", -0.1, "one-to-one", tau=50e-3)
    with pytest.raises(ParameterError, match=r"^network\.pairs that excite and inhibit: 4, must be <= 0"):
        map_on("rolls", one_input(drive, fast, slow))
    less = [Connection("a", "a", -each) for each in (0.1, 0.2)]
    mapped = map_on("rolls", one_input(drive, fast, *less))  # 0.3 - 0.1 - 0.2 is not 0 in floating point
    assert [f.name for f in mapped.filters] == ["virtual_excitatory"]
    assert [f.note for f in mapped.findings if f.where == "a -> a"] == [
        "those between the same neurons add up to none"
    ] * 3


@pytest.mark.parametrize(("weight", "source"), [(1e-3, "in"), (3e-3, "a"), (-0.01, "a")])
def test_the_search_of_codes_finds_weights_that_the_chip_has(weight: float, source: str) -> None:
    mapped = map_on("rolls", one_input(Connection(source, "a", weight)))
    (found,) = (f.error for f in mapped.findings if f.what == "weights")
    assert found < 0.02


def test_weights_of_which_some_are_lost_are_not_told_as_exact() -> None:
    rows = ((1.0, 1e-3), *((1.0, 1.0),) * 3)
    network = Network(
        (Population("a", 4),), (Input("in", 2),), (Connection("in", "a", rule="matrix", matrix=rows),)
    )
    (told,) = (f for f in map_on("rolls", network).findings if f.what == "weights")
    assert told.how == "approximate"
    assert told.note.endswith("1 of 8 synapses are too weak to be there")


@pytest.mark.parametrize(("membrane", "tau"), [(20e-3, 0.5e-3), (20e-3, 10e-6), (0.1, 0.1e-3), (0.3, 5e-3)])
def test_a_filter_that_is_no_low_pass_at_the_currents_of_its_neurons_is_refused(
    membrane: float, tau: float
) -> None:
    def network(tau: float) -> Network:
        one = Connection("in", "a", 2.0 / (2000.0 * tau), tau=tau)
        return Network((Population("a", 8, membrane),), (Input("in", 10),), (one,))

    with pytest.raises(ParameterError, match=r"^virtual excitatory synapses\.tau: .* no low-pass") as e:
        map_on("rolls", network(tau))
    least = float(str(e.value).split(">= ")[1].split()[0])
    mapped = map_on("rolls", network(least))  # the remedy is one
    check_rates(run_mapped(mapped, poisson([(300.0, 0.0, 1.0)] * 10, 1000), Silicon(ROLLS_180), 1.0))
    (told,) = (f for f in mapped.findings if f.what == "current")
    assert "this within" in told.note


@pytest.mark.parametrize(
    ("chip", "size", "weight", "told"),
    [
        ("rolls", 300, 0.1, "network.neurons: 300, must be <= 256; make populations smaller"),
        ("rolls", 2, 5e4, r"excitatory synapses.weight: 5e\+04, must be <= .*; lower it"),
        (
            "rolls",
            2,
            1e-6,
            r"excitatory synapses.weight: 1e-06, must be >= 0.000\d+; no code of the chip is nearer",
        ),
        ("latency", 2, 0.1, "latency, is one fixed network"),
        ("nef", 2, 0.1, "nef, takes networks of ensembles, this one is of populations; map it on rolls"),
    ],
)
def test_what_cannot_be_is_refused_with_its_limit(chip: str, size: int, weight: float, told: str) -> None:
    network = Network((Population("a", size),), connections=(Connection("a", "a", weight),))
    with pytest.raises(ParameterError, match=told):
        map_on(chip, network)


def test_events_outside_of_the_inputs_and_edited_programs_are_refused(memory: Mapped, tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"in.npz: event 0 of address 5, must be 0 to 4"):
        check_channels(memory.network, Events(np.array([0.1]), np.array([5])), "in.npz")
    write_program(tmp_path / "p.toml", memory)
    text = (tmp_path / "p.toml").read_text()
    (tmp_path / "p.toml").write_text(text.replace('"1111', '"x111', 1))
    with pytest.raises(DataError, match=r'levels\[0\]: "x", must be 48 of'):
        read_program_file(tmp_path / "p.toml")
    with pytest.raises(ParameterError, match=r"duration: 0.05 s, must be > 0.1 s"):
        run_mapped(memory, Events(np.empty(0), np.empty(0, np.int64)), Silicon(ROLLS_180), 0.05)


def test_events_of_the_chip_are_in_order_and_those_of_one_time_in_the_order_of_what_they_come_from() -> None:
    rng = np.random.default_rng(1)
    excite, inhibit = (np.where(rng.random((6, 40)) < 0.6, rng.integers(1, 9, (6, 40)), 0) for _ in range(2))
    excite[5] = inhibit[5] = 0  # a channel that reaches nothing
    network = Network((Population("cells", 40),), (Input("in", 6),))
    placed = (Placed("cells", 0, False, 20e-3, 0.1, 1e-12, 2e-3, 1e-12),)
    program = Program(np.zeros((256, 256), dtype=np.int8), inputs=virtual_inputs(40, excite, inhibit))
    mapped = Mapped(network, placed, (), program, excite, inhibit, ())
    times = np.sort(np.round(rng.uniform(0.0, 5e-3, 300), 5))  # many at one time, more that overlap
    channels = rng.integers(0, 6, times.size)
    one = [mapped.events(Events(times[k : k + 1], channels[k : k + 1])) for k in range(times.size)]
    together = [np.concatenate([getattr(each, n) for each in one]) for n in ("times", "neurons", "columns")]
    order = np.argsort(together[0], kind="stable")
    found = mapped.events(Events(times, channels))
    assert found.times.size > 10_000
    for n, whole in zip(("times", "neurons", "columns"), together, strict=True):
        assert np.array_equal(getattr(found, n), whole[order])
