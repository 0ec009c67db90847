"""Warnings of the command line are one line each, without a line of source."""

import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from system.command_line import main
from system.commands import listing

ROOT = Path(__file__).resolve().parents[2]


def warn(*, as_json: bool) -> None:
    warnings.warn(f"deaf\n  neurons, {as_json}", UserWarning, stacklevel=1)


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


def test_deaf_neurons_are_told_in_a_line() -> None:
    options = ["run", "approach", "--die", "1072", "--level", "behavioural", "--duration", "1ms"]
    command = [sys.executable, "-m", "system.command_line", *options]
    child = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert child.stderr.startswith("noctule: warning: ")
    assert "rest margin -0.026 V" in child.stderr
    assert child.stderr.count("\n") == 1
