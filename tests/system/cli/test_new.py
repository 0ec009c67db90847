"""`noctule new`: what it writes runs from its file, passes its own test and the checks of the house."""

from __future__ import annotations

import json
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from system.cli.command_line import main
from system.cli.new import package_of
from tests.documents import ROOT
from tests.refusals import command_refusals

KINDS = ("block", "chip", "robot", "experiment")
LINES = 20  # of a package's words on itself
FROM_THE_FILE = {
    "block": ("simulate my_own.py:BLOCK --die 3", "montecarlo my_own.py:BLOCK --samples 2 --threads 1"),
    "chip": ("op my_own.py:CHIP --die 3", "simulate my_own.py:cell --die 3 --at my_own.py:CHIP/cell[2]"),
    "robot": ("run my_own.py:SYSTEM --pace 2m/s --die 7",),
    "experiment": ("reproduce my_own.py:EXPERIMENT",),
}


@pytest.fixture
def folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[[str], Path]:
    def written(kind: str) -> Path:
        monkeypatch.chdir(tmp_path)
        assert main(["new", kind, "my-own"]) == 0
        assert "my_own.py" in capsys.readouterr().out
        return tmp_path / "my-own"

    return written


@pytest.mark.parametrize("kind", KINDS)
def test_its_own_test_passes_and_its_files_are_in_order(kind: str, folder: Callable[[str], Path]) -> None:
    made = folder(kind)
    assert sorted(p.name for p in made.iterdir()) == [
        "README.md",
        "my_own.py",
        "pyproject.toml",
        "test_my_own.py",
    ]
    assert "@" not in "".join(p.read_text() for p in made.glob("*.md"))
    words = [line for line in (made / "README.md").read_text().splitlines() if line]
    assert len(words) <= LINES
    ran = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"],
        cwd=made,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ran.returncode == 0, ran.stdout
    checked = [
        sys.executable,
        "-m",
        "ruff",
        "check",
        "--isolated",
        "--select",
        "E,F,I,B,UP",
        "--line-length",
        "110",
    ]
    assert (
        subprocess.run(
            [*checked, "--config", 'lint.isort.known-first-party=["circuits","system"]', made], check=False
        ).returncode
        == 0
    )


@pytest.mark.parametrize("kind", KINDS)
def test_it_runs_from_its_file(
    kind: str,
    folder: Callable[[str], Path],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(folder(kind))
    for line in FROM_THE_FILE[kind]:
        assert main([*shlex.split(line), "--json"]) == 0, capsys.readouterr().err
        json.loads(capsys.readouterr().out)


def test_its_entry_point_is_of_its_kind() -> None:
    groups = {
        k: tomllib.loads(package_of(k, "my-own")["pyproject.toml"])["project"]["entry-points"] for k in KINDS
    }
    names = {"block": "blocks", "chip": "chips", "robot": "systems", "experiment": "experiments"}
    assert {k: list(g) for k, g in groups.items()} == {k: [f"noctule.{n}"] for k, n in names.items()}
    assert (ROOT / "system" / "cli" / "templates").is_dir()


test_a_name_that_cannot_be_is_refused = command_refusals(
    "new",
    rows=[
        ("block My_Sink", "My_Sink: is no name, must be small letters, digits and hyphens"),
        ("block rebound-neuron", "rebound-neuron: is the name of a block already; give another"),
        ("block json", "json: is the name of a module of Python already"),
        ("robot car", "car: is the name of a robot already"),
        ("board my-own", "'board' is not one of"),
        ("block my-own --output none", "my-own: cannot be written, No such file or directory"),
    ],
)


def test_a_folder_that_is_there_is_left_alone(
    folder: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    before = {p: p.read_text() for p in folder("block").iterdir()}
    assert main(["new", "chip", "my-own"]) == 2
    assert "is there already" in capsys.readouterr().err
    assert {p: p.read_text() for p in before} == before
