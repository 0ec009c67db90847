"""Studies of a netlist: by its own `.measure` cards, and of a sub-circuit under a testbench's file."""

import json
from pathlib import Path

import pytest

from system.cli.command_line import main
from tests.written import written

DECK = """an inverter
.model nch nmos
.model pch pmos
.subckt inv in out vdd
mn out in 0 0 nch w=6u l=3u
mp out in vdd vdd pch w=12u l=3u
c1 out 0 1p
.ends
vdd vdd 0 5
vin in 0 pulse(0 5 1u 10n 10n 5u 20u)
x1 in out vdd inv
.tran 10n 10u
.measure tran t_fall trig v(in) val=2.5 rise=1 targ v(out) val=2.5 fall=1
.measure tran lost max v(nowhere)
"""
BENCH = 'stop = "10us"\n[voltages]\nvdd = 5\nin = "pulse(0 5 1u 10n 10n 4u 20u)"\n'
FALL = "t_fall = cross(out, 2.5, fall) - cross(in, 2.5)"


@pytest.fixture
def deck(tmp_path: Path) -> Path:
    (tmp_path / "bench.toml").write_text(BENCH)
    return written(tmp_path / "inv.cir", DECK)


def test_a_study_measures_a_deck_s_own_cards(deck: Path, capsys: pytest.CaptureFixture[str]) -> None:
    metric = ["--metric", "t_fall", "--spec", "t_fall in 0s:1us"]
    command = ["montecarlo", str(deck), "-n", "4", *metric, "--json"]
    assert main(command) == 0
    said = capsys.readouterr()
    found = json.loads(said.out)
    assert len(found["values"]["t_fall"]) == 4
    assert all(0.0 < each < 1e-6 for each in found["values"]["t_fall"])
    assert "nowhere" in said.err
    assert "this .measure card is left out" in said.err


def test_a_gradient_takes_a_deck_s_own_cards(deck: Path, capsys: pytest.CaptureFixture[str]) -> None:
    written(deck, DECK + ".measure tran twice param='2*t_fall'\n")
    names = ["--metric", "t_fall", "--metric", "twice", "--metric", "fall(out,2.5V)"]
    assert main(["gradient", str(deck), *names, "--json"]) == 0
    said = capsys.readouterr()
    assert "nowhere" in said.err
    own, twice, form = json.loads(said.out)["metrics"]
    assert own["metric"] == "t_fall"
    assert own["unit"] == "s"
    # the input is the testbench's, which no device moves; voltages of a run are told apart by a millionth
    slopes = [{g["parameter"]: g["gradient"] for g in each["gradients"]} for each in (own, twice, form)]
    largest = max(map(abs, slopes[2].values()))
    # a fall counts from the beginning, and the card from the input, which comes later with its source
    (later,) = (name for name, slope in slopes[2].items() if slope == pytest.approx(1.0, abs=1e-6))
    assert later.startswith("source.")
    assert slopes[0].pop(later) == pytest.approx(0.0, abs=1e-6)
    del slopes[2][later]
    for name, slope in slopes[2].items():
        assert slopes[0][name] == pytest.approx(slope, rel=1e-4, abs=1e-6 * largest)
        assert slopes[1][name] == pytest.approx(2.0 * slope, rel=1e-4, abs=1e-6 * largest)


def test_a_study_is_at_the_temperature_that_the_deck_states(
    deck: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    written(deck, DECK + ".temp 85\n")
    for options, degrees in (([], 85.0), (["--temperature", "27"], 27.0)):
        assert main(["montecarlo", str(deck), "-n", "1", "--json", *options]) == 0
        assert json.loads(capsys.readouterr().out)["temperature_C"] == degrees


def test_a_subcircuit_is_studied_under_its_testbench_and_replayed_from_copies(
    deck: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    bench, folder = tmp_path / "bench.toml", tmp_path / "study"
    given = [f"{deck}:inv", "--testbench", str(bench), "--measure", FALL]
    assert main(["montecarlo", *given, "-n", "3", "-o", str(folder), "--json"]) == 0
    kept = json.loads(capsys.readouterr().out)["values"]["t_fall"]
    assert {path.name for path in (folder / "source").iterdir()} == {"inv.cir", "bench.toml"}
    bench.write_text(BENCH.replace("vdd = 5", "vdd = 4"))
    assert main(["replay", str(folder), "--die", "1001", "--json"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["identical"]
    assert again["again"]["t_fall"] == kept[1]
    other = [*given, "-n", "5", "-o", str(folder), "--resume"]
    assert main(["montecarlo", *other]) == 2  # another testbench is another study
    assert "begin another study" in capsys.readouterr().err


def test_a_study_that_was_lengthened_and_not_ended_replays_what_it_has(
    deck: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "study"
    words = ["montecarlo", str(deck), "--chunk", "2", "-o", str(folder), "--json"]
    assert main([*words, "-n", "2"]) == 0
    ended = (folder / "samples.nc").read_bytes()
    assert main([*words, "-n", "4", "--resume"]) == 0
    (folder / "samples.nc").write_bytes(ended)  # as where the second run was stopped before its end
    capsys.readouterr()
    for die in ("1001", "1003"):
        assert main(["replay", str(folder), "--die", die, "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["identical"]


def test_biases_and_sizes_of_a_deck_are_none_to_move(
    deck: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [f"{deck}:inv", "--testbench", str(tmp_path / "bench.toml"), "--measure", FALL]
    assert main(["centre", *given, "--spec", "t_fall in 0s:1us", "--tuning-dies", "2"]) == 2
    assert "inv has no bias that is a current; name a bias or size" in capsys.readouterr().err
    assert main(["montecarlo", str(deck), "--testbench", "bench.toml", "-n", "2"]) == 2
    assert "is for deck.cir:SUBCIRCUIT" in capsys.readouterr().err


def test_searches_over_dies_take_a_deck_s_cards_and_several_measures(
    deck: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    written(deck, DECK + ".measure tran t_half param='t_fall/2'\n")
    beside = ["--measure", "v_end = value(out, at=4us)", "--measure", "v_most = max(out)"]
    assert main(["match", str(deck), "--metric", "t_half", *beside, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["metric"], found["unit"]) == ("t_half", "s")
    assert 0.0 < found["spread"] < found["value"] < 1e-6
