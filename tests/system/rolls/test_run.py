"""Rates of ROLLS' neurons on dies, as a study measures them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from chips.rolls.chip import RollsChip, Spikes
from chips.rolls.power import Activity, chip_power, energies_of
from chips.rolls.program.bias_file import OFF, default_biases, write_biases
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.cli.command_line import main
from system.files import kept
from system.options.rolls import power as options_power
from system.rolls import run as rolls_run
from system.rolls.drive import program_of, regular_events
from system.rolls.run import SYSTEM, Trace, run, summarise
from system.rolls.scenario import Scenario
from tests.refusals import command_refusals

SHORT = Scenario(
    die=Die(number=1005), duration=0.15, bias_file="rolls_parallella", bias_kind="ideal", codes="default"
)


@pytest.fixture(scope="module")
def trace() -> Trace:
    return run(SHORT)


def test_every_neuron_gets_the_same_number_of_events() -> None:
    found = regular_events(40.0, SHORT.duration, 0)
    assert (np.bincount(found.neurons, minlength=256) == 6).all()
    assert (np.diff(found.times) >= 0.0).all()
    assert regular_events(0.0, SHORT.duration, 0).times.size == 0
    assert not np.array_equal(found.times, regular_events(40.0, SHORT.duration, 1).times)
    left = regular_events(40.0, SHORT.duration, 0, (3, 7)).neurons
    assert not {3, 7} & {*left.tolist()}
    assert left.size == 6 * 254


def test_a_driven_population_fires_and_its_neurons_differ(trace: Trace) -> None:
    found = summarise(trace)
    assert found["population_rate"] == pytest.approx(trace.rates.mean())
    assert (found["population_rate"] or 0.0) > 50.0
    assert 0.02 < (found["rate_cv"] or 0.0) < 0.5
    assert found["silent"] == 0.0
    SYSTEM.draw(trace, Figure())


def test_silent_and_hot_neurons_are_counted(trace: Trace) -> None:
    rates = np.full(256, 10.0)
    rates[:3], rates[3:5] = 0.0, 25.0
    none = Spikes(np.empty(0), np.empty(0, np.int64))
    found = summarise(Trace(SHORT, none, rates, np.arange(256) < 7, trace.chip))
    assert (found["silent"], found["hot"], found["restless"]) == (3.0, 2.0, 7.0)
    quiet = summarise(Trace(SHORT, none, np.zeros(256), np.zeros(256, np.bool_), trace.chip))
    assert (quiet["silent"], quiet["hot"], quiet["rate_cv"]) == (256.0, 0.0, None)


def test_power_of_a_run_is_at_least_that_at_rest_and_its_parts_add_up(trace: Trace) -> None:
    found = summarise(trace)
    power = {name: found[f"{name}_power_mW"] or 0.0 for name in ("static", "bias", "dynamic", "total")}
    assert power["total"] == pytest.approx(power["static"] + power["bias"] + power["dynamic"], rel=1e-12)
    still = chip_power(energies_of(trace.chip), Activity(np.zeros(256)))
    assert power["static"] == pytest.approx(1e3 * still.parts["static"], rel=1e-12)
    assert power["bias"] == pytest.approx(1e3 * still.parts["bias"], rel=1e-12)
    assert power["dynamic"] > 0.0
    silent = replace(trace, spikes=Spikes(np.empty(0), np.empty(0, np.int64)), given=0)
    assert summarise(silent)["total_power_mW"] == pytest.approx(1e3 * still.total, rel=1e-12)


def test_energies_are_measured_once_for_all_dies_that_share_them(
    trace: Trace, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kept, "answers_folder", lambda: tmp_path)
    first = options_power.kept_energies(trace.chip)
    monkeypatch.setattr(options_power, "energies_of", lambda *_: pytest.fail("measured again"))
    again = options_power.kept_energies(trace.chip)
    assert (again.rates.tolist(), again.spike.tolist()) == (first.rates.tolist(), first.spike.tolist())
    assert (again.event, again.still, again.column) == (first.event, first.still, first.column)


def test_power_is_not_told_where_a_neuron_alone_never_fires(trace: Trace) -> None:
    leaky = trace.chip.program.biases.with_code("IF_TAU2_N", 0, 255)
    program = replace(trace.chip.program, biases=leaky)
    found = summarise(replace(trace, chip=RollsChip(program, trace.chip.silicon)))
    assert found["total_power_mW"] is None
    assert found["population_rate"] == summarise(trace)["population_rate"]


@pytest.fixture
def without_power(monkeypatch: pytest.MonkeyPatch) -> None:
    """Runs whose power is not measured, for what is not about it."""
    monkeypatch.setattr(rolls_run, "power_numbers", lambda *_: {})


@pytest.mark.usefixtures("without_power")
def test_a_study_streams_and_resumes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study = ["montecarlo", "rolls", "--metric", "population-rate", "--duration", "0.12s", "--chunk", "1"]
    study += ["--param", "codes=default", "--threads", "1", "--json", "--output", str(tmp_path / "study")]
    assert main([*study, "-n", "1"]) == 0
    first = json.loads(capsys.readouterr().out)
    assert main([*study, "-n", "2", "--resume"]) == 0
    both = json.loads(capsys.readouterr().out)
    assert both["chunks_read"] == 1
    assert both["values"]["population_rate"][0] == first["values"]["population_rate"][0]
    assert both["dies"] == [1000, 1001]


test_bad_options_are_one_line = command_refusals(
    "montecarlo",
    "rolls",
    "-n",
    "1",
    rows=[
        ("--param map=x", "map: not an option of rolls"),
        ("--level transistor", "--level: transistor, is no choice of rolls"),
        ("--duration 0.05s", "--duration: 0.05 s, must be > 0.1 s"),
        ("--param bias-file=none.csv", "none.csv: No such file"),
        ("--param input-rate=3A", "--param input-rate"),
        ("--metric spikes", "metric spikes: unknown"),
    ],
)


@pytest.mark.parametrize("field", [{"input_rate": -1.0}, {"seed": -1}])
def test_a_scenario_refuses_what_makes_no_run(field: dict[str, float]) -> None:
    with pytest.raises(ParameterError, match="must be >= 0"):
        replace(SHORT, **field)


@pytest.mark.usefixtures("without_power")
@pytest.mark.parametrize("kind", ["gate", "generator"])
def test_a_summary_says_that_a_chip_does_not_rest(kind: BiasKind, tmp_path: Path) -> None:
    quiet = Scenario(duration=0.12, die=Die(number=3), bias_kind=kind, codes="default")
    told = SYSTEM.summarise(run(quiet))["cautions"]
    assert not told
    path = tmp_path / "leaky.csv"
    write_biases(path, default_biases().with_code("IF_TAU2_N", *OFF))
    found = SYSTEM.summarise(run(replace(quiet, bias_file=str(path))))
    assert "of 256 fire without any input" in found["cautions"][0]
    assert not found["succeeded"]


def test_bursts_of_the_default_drive_are_those_of_short_steps() -> None:
    program, events = program_of(default_biases()), regular_events(100.0, 0.04, 3)
    found = []
    for step in (0.4e-3, 0.02e-3):
        chip = RollsChip(program, Silicon(ROLLS_180, die=Die(number=1000)), step=step)
        spikes, _ = chip.run(chip.at_rest(), 0.04, events)
        first = [spikes.times[spikes.neurons == k].min() for k in range(256)]
        found.append((spikes.times.size, np.array(first)))
    (ours, first), (fine, their_first) = found
    # bursts in which a spike follows on the other within a step
    assert fine > 20 * 256
    assert ours == pytest.approx(fine, rel=0.01)
    assert np.median(np.abs(first - their_first)) < 0.03e-3
