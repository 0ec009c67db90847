"""A command that produced nothing, or has to say no, ends non-zero and says what in its last line."""

from collections.abc import Callable
from dataclasses import replace
from importlib.metadata import PackageNotFoundError
from pathlib import Path
from typing import Any

import pytest

from circuits.lowering.kernel import Machine
from system.cli import doctor, listing
from system.cli.command_line import main
from system.cli.exit_status import BAD_INPUT, DONE, NO
from system.experiment import Report
from system.study.table import FAILED
from system.study.target import BlockTarget, Measurement

HERE = "tests.system.cli.test_exit_status"
STUDY = ("montecarlo", "rebound-neuron", "--threads", "1", "-n", "2")
Ended = Callable[..., tuple[int, str]]


def broken(machine: Machine) -> float:
    raise ZeroDivisionError("no slope")


def broken_when_hot(machine: Machine) -> float:
    return 1.0 / (machine.silicon.temperature_c < 50.0)


def broken_on_even_dies(machine: Machine) -> float:
    return 1.0 / ((machine.silicon.die.number or 0) % 2)


@pytest.fixture
def ended(capsys: pytest.CaptureFixture[str]) -> Ended:
    """Status and last line on stderr of a command."""

    def call(*arguments: str) -> tuple[int, str]:
        status = main(arguments)
        lines = capsys.readouterr().err.splitlines()
        return status, lines[-1] if lines else ""

    return call


@pytest.mark.parametrize("options", [(), ("--json",)])
def test_a_study_in_which_every_die_failed(ended: Ended, options: tuple[str, ...]) -> None:
    line = "noctule: montecarlo: all 2 samples at 27 degC failed, the first: ZeroDivisionError: no slope"
    assert ended(*STUDY, "--metric", f"{HERE}:broken", *options) == (NO, line)
    line = (
        "noctule: montecarlo: all 2 samples at 80 degC failed, the first: ZeroDivisionError: division by zero"
    )
    hot = ("--metric", f"{HERE}:broken_when_hot", "--temperature", "80", "--temperature", "27")
    assert ended(*STUDY, *hot, *options)[0] == NO
    assert ended(*STUDY, *hot, *options)[1].startswith(line[:70])
    assert ended(*STUDY, "--metric", f"{HERE}:broken_on_even_dies", *options) == (DONE, "")


def test_a_study_of_no_dies(ended: Ended) -> None:
    refused = "noctule: --samples: 0 from die 1000, must be 1 or more from die 0 on"
    assert ended(*STUDY[:-1], "0", "--metric", "t_inh") == (BAD_INPUT, refused)


def test_a_study_of_one_condition_twice(ended: Ended) -> None:
    twice = ("--temperature", "27", "--temperature", "27.0")
    assert ended(*STUDY, *twice) == (
        BAD_INPUT,
        "noctule: --temperature: 27 degC is there twice, must be once",
    )
    twice = ("--corner", "ss", "--corner", "ss")
    assert ended(*STUDY, *twice) == (BAD_INPUT, "noctule: --corner: ss is there twice, must be once")


def test_a_report_without_rows_agrees_with_nothing() -> None:
    assert not Report((), lambda _: None).agrees


def test_a_sample_that_is_another_one(ended: Ended, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = str(tmp_path / "study")
    assert ended(*STUDY, "--metric", "t_inh", "-o", folder) == (DONE, "")
    again = ("replay", folder, "--die", "1001")
    assert ended(*again) == (DONE, "")
    exact = BlockTarget.measure_each

    def doubled(*given: Any) -> list[Measurement]:
        (found,) = exact(*given)
        return [replace(found, values=(2.0 * found.values[0],))]

    monkeypatch.setattr(BlockTarget, "measure_each", doubled)
    assert ended(*again)[0] == NO
    assert ended(*again)[1].startswith("noctule: replay: die 1001 is not what")
    monkeypatch.setattr(BlockTarget, "measure_each", lambda *_: [Measurement(FAILED, (0.0,), "no spike")])
    assert ended(*again) == (NO, "noctule: replay: die 1001 could not be measured: no spike")


def test_a_search_after_which_no_die_passes(ended: Ended) -> None:
    options = ("--tuning-dies", "2", "--fresh-dies", "2", "--generations", "0", "--no-process-variation")
    status, line = ended("centre", "rebound-neuron", "--spec", "best_delay in 20ms:21ms", *options)
    assert status == NO
    assert line.startswith("noctule: centre: no fresh die passes with mismatch varying; ")


def test_a_search_after_which_no_die_passes_says_it_in_one_line(ended: Ended) -> None:
    options = ("--tuning-dies", "2", "--fresh-dies", "2", "--generations", "0", "--threads", "1")
    told = (
        "noctule: centre: no fresh die passes with mismatch alone, or mismatch and process varying; give it"
        " more to move, or other limits"
    )
    asked = ("centre", "differential-pair", "--spec", "offset_V in 1V:2V", *options)
    assert ended(*asked) == (NO, told)
    assert ended(*asked, "--json") == (NO, told)


@pytest.mark.parametrize("verb", ["size", "centre"])
@pytest.mark.parametrize(
    ("block", "spec", "told"),
    [
        (
            "differential-pair",
            "offset_V",
            '--spec: "offset_V", must be METRIC in LOW:HIGH or class is WORD; ',
        ),
        ("differential-pair", "offset_V<5mV", '--spec: "offset_V<5mV", must be METRIC in LOW:HIGH or class '),
    ],
)
def test_a_search_of_a_specification_of_no_form(
    verb: str, block: str, spec: str, told: str, ended: Ended
) -> None:
    status, line = ended(verb, block, "--spec", spec)
    assert status == BAD_INPUT
    assert line.startswith(f"noctule: {told}")


def test_a_search_with_nothing_to_move(ended: Ended, tmp_path: Path) -> None:
    deck = tmp_path / "rc.cir"
    deck.write_text(
        "* rc\nv1 in 0 pulse(0 1 1m 1u 1u 5m 20m)\nr1 in out 10k\nc1 out 0 100n\n.tran 10u 10m\n.end\n"
    )
    spec = ("--spec", "out_max_V in 0V:2V")
    sizes = f"noctule: --move-param: none, and {deck} has no length that moves; name a size"
    assert ended("size", str(deck), *spec) == (BAD_INPUT, sizes)
    biases = f"noctule: --move: none, and {deck} has no bias that is a current; name a bias or size"
    assert ended("centre", str(deck), *spec) == (BAD_INPUT, biases)


def test_what_is_missing_or_broken(ended: Ended, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(_: str) -> str:
        raise PackageNotFoundError

    def fails(_: str) -> None:
        raise ImportError("no module")

    kinds = [replace(kind, line=fails) if kind.title == "chips" else kind for kind in listing.KINDS]
    monkeypatch.setattr(listing, "KINDS", kinds)
    status, line = ended("list")
    assert status == NO
    assert line.startswith("noctule: list: ranging-chip, ranging-chip-biased")
    monkeypatch.setattr(doctor, "version", missing)
    status, line = ended("doctor")
    assert status == NO
    assert line.startswith("noctule: doctor: required, but missing: numpy, scipy")


def test_a_word_that_is_nearly_a_class_is_told(ended: Ended) -> None:
    told = "noctule: spec: no sample's class is workz; did you mean works?"
    assert ended(*STUDY, "--spec", "class is workz") == (DONE, told)


def test_netlists_that_differ(ended: Ended, tmp_path: Path) -> None:
    for name, ohm in (("a", "1k"), ("b", "2k")):
        (tmp_path / f"{name}.cir").write_text(f"* one\nr1 in 0 {ohm}\nv1 in 0 1\n.end\n")
    a, b = (str(tmp_path / f"{name}.cir") for name in "ab")
    assert ended("compare", a, a) == (DONE, "")
    status, line = ended("compare", a, b)
    assert status == NO
    assert line.startswith("noctule: compare: different")
