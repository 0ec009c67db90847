"""Warnings of the command line are one line each, without a line of source."""

import warnings

import pytest

from circuits.lowering.kernel import Machine
from system.cli import listing
from system.cli.command_line import main
from system.cli.verbs import List


def warn(asked: List) -> None:
    warnings.warn(f"deaf\n  neurons, {asked.as_json}", UserWarning, stacklevel=1)


def test_a_warning_is_one_line_on_stderr(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(listing, "list_command", warn)
    before = warnings.showwarning
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        main(["list"])
    assert capsys.readouterr() == ("", "noctule: warning: deaf neurons, False\n")
    assert warnings.showwarning is before


DEAF = ("run", "approach", "--die", "1072", "--codes", "default")  # which a trimmer of its calibration mends


def test_deaf_neurons_are_told_in_a_line(capsys: pytest.CaptureFixture[str]) -> None:
    # a process of a user's own is the study's below
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        assert main([*DEAF, "--level", "behavioural", "--duration", "1ms"]) == 0
    said = capsys.readouterr().err
    assert said.startswith("noctule: warning: ")
    assert "rest margin -0.006 V" in said
    assert said.count("\n") == 1


def deaf(machine: Machine) -> float:
    warnings.warn(f"deaf die {machine.silicon.die.number}", UserWarning, stacklevel=1)
    return 0.0


def test_processes_of_a_study_warn_in_a_line_too(capfd: pytest.CaptureFixture[str]) -> None:
    options = ["--metric", "tests.system.test_notice:deaf", "-n", "2", "--workers", "1", "--chunk", "1"]
    assert main(["montecarlo", "rebound-neuron", *options]) == 0
    err = capfd.readouterr().err  # of the processes too
    told = sorted(line for line in err.splitlines() if "deaf" in line)
    assert told == ["noctule: warning: deaf die 1000", "noctule: warning: deaf die 1001"]
    assert "warnings.warn" not in err
