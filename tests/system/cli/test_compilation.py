"""Kernels that a command compiles are told at a terminal: when they are begun, and when they are there."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest
from numba import njit

from system.cli.compilation import compilation_told
from tests.system.cli.test_command_line import ROOT

# `noctule list`, which here calls a kernel of two functions instead.
CODE = """
import sys
from circuits.compiled import compiled
from system.cli import verb
from system.cli.command_line import main

@compiled()
def inner(x):
    return x + 1

@compiled()
def outer(x):
    return inner(x) + 1

verb.loaded = lambda place, load=verb.loaded: (lambda _: outer(1) - 3) if "listing" in place else load(place)
sys.exit(main(["list"]))
"""
BEGUN = r"noctule: compiling the kernels of \S+ and what they need, once: half a minute or more\n"
DONE = r"noctule: compiled 2 kernels in \d+ s; later runs find them\n"


def _at_a_terminal(cache: Path) -> str:
    """What the command writes on a stderr that is a terminal."""
    path = cache / "kernels.py"
    path.write_text(CODE)
    ours, theirs = pty.openpty()
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(cache), "PYTHONPATH": str(ROOT)}
    status = subprocess.run(
        [sys.executable, str(path)], env=environment, stderr=theirs, check=False
    ).returncode
    os.close(theirs)
    with os.fdopen(ours, "rb", buffering=0) as terminal:
        told = b""
        try:
            while found := terminal.read(1024):
                told += found
        except OSError:  # the other side is closed
            pass
    assert status == 0
    return told.decode().replace("\r\n", "\n")


def test_the_first_run_at_a_terminal_tells_what_it_compiles(tmp_path: Path) -> None:
    assert re.fullmatch(BEGUN + DONE, _at_a_terminal(tmp_path))
    assert _at_a_terminal(tmp_path) == ""


def test_a_log_is_told_nothing(tmp_path: Path) -> None:
    path = tmp_path / "kernels.py"
    path.write_text(CODE)
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, str(path)], env=environment, capture_output=True, check=True)
    assert done.stderr == b""


def test_what_fails_while_it_compiles_is_told_as_well(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ZeroDivisionError), compilation_told():
        njit(lambda x: x + 1)(1)
        raise ZeroDivisionError
    assert capsys.readouterr().err.count("\n") == 2
    with compilation_told():
        pass
    assert capsys.readouterr().err == ""
