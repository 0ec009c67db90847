"""The walks of CONTRIBUTING.md lead where they say: what stands there is installed, found and run."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from system.cli.command_line import main
from tests.walks import Walk, install, walks

TEXT = (Path(__file__).resolve().parents[1] / "CONTRIBUTING.md").read_text(encoding="utf-8")
WALKS = walks(TEXT)
KINDS = {  # what `noctule list` has of each group
    "noctule.blocks": "blocks",
    "noctule.metrics": "metrics",
    "noctule.chips": "chips",
    "noctule.experiments": "experiments",
    "noctule.dialects": "dialects",
    "noctule.systems": "systems",
}


@pytest.fixture
def installed(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[Walk]:
    """A walk whose files, and those of the walks before it, are on Python's path."""
    walk: Walk = request.param
    install(WALKS[: WALKS.index(walk) + 1], tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    before = set(sys.modules)
    yield walk
    written = {Path(file).stem for each in WALKS for file in each.files}
    for name in written & (set(sys.modules) - before):
        del sys.modules[name]


def test_every_walk_has_files_an_entry_point_and_commands() -> None:
    assert WALKS
    for walk in WALKS:
        assert walk.files, walk.title
        assert walk.entry_points, walk.title
        assert walk.commands, walk.title
    assert {group for walk in WALKS for group in walk.entry_points} == {*KINDS, "noctule.models"}


@pytest.mark.parametrize("installed", WALKS, ids=lambda walk: walk.title, indirect=True)
def test_every_command_of_a_walk_runs(installed: Walk, capfd: pytest.CaptureFixture[str]) -> None:
    names = [name for entries in installed.entry_points.values() for name in entries]
    said = []
    for program, *arguments in installed.commands:
        assert program == "noctule"
        assert main(arguments) == 0, capfd.readouterr().err
        out = capfd.readouterr().out
        if "--json" in arguments:
            json.loads(out, parse_constant=pytest.fail)
        said += [out, *arguments]
    assert all(any(name.replace("_", "-") in text.replace("_", "-") for text in said) for name in names)


def test_a_process_of_its_own_lists_all_that_the_walks_add(tmp_path: Path) -> None:
    install(WALKS, tmp_path)
    command = [sys.executable, "-c", "import sys; from system.cli.command_line import main; sys.exit(main())"]
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    done = subprocess.run(
        [*command, "list", "--json"], env=environment, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    found = json.loads(done.stdout)
    for walk in WALKS:
        for group in KINDS.keys() & walk.entry_points.keys():
            entries = walk.entry_points[group]
            listed = {each["name"]: each["summary"] for each in found[KINDS[group]]}
            assert set(entries) <= set(listed)
            assert all(listed[name] and "cannot be loaded" not in listed[name] for name in entries)


@pytest.mark.parametrize("installed", [WALKS[0]], ids=lambda walk: walk.title, indirect=True)
def test_what_is_broken_is_named_and_hides_nothing(
    installed: Walk, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (name,) = installed.entry_points["noctule.blocks"]
    for file in installed.files:
        (tmp_path / file).write_text("import nowhere_at_all\n", encoding="utf-8")
    assert main(["show", name]) == 2
    said = capfd.readouterr().err
    assert said.startswith(f"noctule: noctule.blocks.{name}: ")
    assert "nowhere_at_all" in said
    assert said.count("\n") == 1
    assert main(["list"]) == 1
    out, err = capfd.readouterr()
    assert name in err
    assert "rebound-neuron" in out
