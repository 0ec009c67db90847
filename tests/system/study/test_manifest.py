"""A study's manifest is data: it is checked, it loads no code, and what is wrong is told in a line."""

from __future__ import annotations

import json
import random
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from circuits.errors import CircuitError, DataError, ParameterError
from system.cli.command_line import main
from system.study.manifest import FILE, describe, read_study
from system.study.plan import Plan
from system.study.replay import die_of, replay
from system.study.table import MOST
from tests.refusals import refusals
from tests.system.study.test_engine import HERE, run, study

OWN = f"{HERE}:threshold_sum"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    wanted = study(2)
    run(replace(wanted, subject=replace(wanted.subject, metrics=("t_inh",))), tmp_path / "study")
    return tmp_path / "study"


def change(folder: Path, edit: Callable[[dict[str, Any]], object]) -> None:
    document = json.loads((folder / FILE).read_text())
    edit(document)
    (folder / FILE).write_text(json.dumps(document))


@pytest.mark.parametrize("command", ["show", "simulate", "replay"])
def test_no_file_has_a_module_loaded(
    folder: Path, command: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "pwn_of_a_study.py").write_text(
        "from pathlib import Path\nPath('pwned').write_text('')\ndef f(machine):\n    return 1.0\n"
    )
    change(folder, lambda d: d["subject"].update(metrics=["pwn_of_a_study:f"]))
    monkeypatch.chdir(folder)
    given = ["replay", "."] if command == "replay" else [command, "rebound-neuron", "--study", "."]
    status = main([*given, "--die", "1000"])
    assert not (folder / "pwned").exists()
    assert "pwn_of_a_study" not in sys.modules
    if command == "replay":  # the others need the study's dies alone
        assert status == 2
        assert "was measured with pwn_of_a_study:f, code that no file loads" in capsys.readouterr().err
        assert main(["replay", ".", "--die", "1000", "--metric", "pwn_of_a_study:f"]) == 0
        assert (folder / "pwned").exists()
    else:
        assert status == 0


@pytest.mark.parametrize("method", ["random", "lhs"])
def test_dies_of_a_study_of_an_own_function_need_no_function(tmp_path: Path, method: str) -> None:
    wanted = study(3, method=method)
    run(wanted, tmp_path)
    with pytest.raises(ParameterError, match=f"metric: .* was measured with {OWN}"):
        read_study(tmp_path)
    found = replay(tmp_path, 1001, own=(OWN,))
    assert found.identical
    assert repr(die_of(tmp_path, 1001)) == repr(found.die)


def test_the_folder_of_a_command_takes_no_library_s_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "mine_of_a_test.py").write_text("def f(machine):\n    return 1.0\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [p for p in sys.path if p])
    wanted = study(1)
    run(replace(wanted, subject=replace(wanted.subject, metrics=("mine_of_a_test:f",))))
    assert sys.path.index("") == len(sys.path) - 1


@pytest.mark.parametrize(
    "name", ["none_such:f", "json:none_such", ":f", "json:", "json:decoder", "..a:b", "broken_of_a_test:f"]
)
def test_an_own_function_that_is_none_is_told(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "broken_of_a_test.py").write_text("def f(:\n")
    monkeypatch.chdir(tmp_path)
    wanted = study(1)
    with pytest.raises(ParameterError, match=f"metric: {name}, .*give MODULE:FUNCTION"):
        run(replace(wanted, subject=replace(wanted.subject, metrics=(name,))))


@pytest.mark.parametrize(
    ("edit", "told"),
    [
        (lambda d: d.update(format=2), "format: Invalid enum value 2"),
        (lambda d: d.update(chunk=0), "chunk: 0"),
        (lambda d: d.update(chunk="3"), "chunk: Expected int, got str"),
        (lambda d: d.update(conditions=[]), "conditions: none"),
        (lambda d: d["conditions"][0].update(temperature_c=1e4), "temperature: 10000 degC"),
        (lambda d: d["conditions"][0].update(corner="xx"), "corner: xx"),
        (lambda d: d["plan"].update(count=10**9), f"at most {MOST} samples"),
        (lambda d: d["plan"].update(first=10**30), "first_die"),
        (lambda d: d["plan"].update(seed=-1), "seed: -1"),
        (lambda d: d["plan"].update(method="best"), "plan.method: Invalid enum value 'best'"),
        (lambda d: d["subject"].update(metrics="t_inh"), "subject.metrics: Expected array, got str"),
        (lambda d: d["subject"].update(system={"level": {"a": []}}), "subject.system"),
        (lambda d: d["subject"].update(colour="red"), "subject.colour: no study has that"),
        (lambda d: d["subject"]["silicon"].update(study=".", die=1000), "subject.silicon: names a die"),
        (lambda d: d.update(plan=None), "plan: Expected object, got null"),
        (lambda d: d.pop("subject"), "missing required field subject"),
    ],
)
def test_what_no_study_has_is_told_with_its_place(
    folder: Path, edit: Callable[[dict[str, Any]], object], told: str
) -> None:
    change(folder, edit)
    with pytest.raises(DataError) as raised:
        read_study(folder)
    assert str(raised.value).startswith(f"{folder / FILE}: broken: ")
    assert told in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    "text", ["[" * 50_000, '{"format":' * 50_000, '{"format": 1e999}', "", "\0", '{"format": 1}', "null"]
)
def test_a_file_that_is_no_manifest_is_told(folder: Path, text: str) -> None:
    (folder / FILE).write_text(text)
    with pytest.raises(DataError, match=r"study\.json: broken"):
        read_study(folder)


VALUES = (None, True, -1, 0, 10**30, 1e308, "", "x", [], {}, [[]], {"a": 1}, "os:getcwd", 2.5, "\ud800")


def spoiled(node: Any, rng: random.Random) -> Any:
    """A document with one value of it, somewhere, replaced or gone."""
    if isinstance(node, dict | list) and node and rng.random() < 0.85:
        keys = list(node) if isinstance(node, dict) else list(range(len(node)))
        key = rng.choice(keys)
        if rng.random() < 0.1:
            del node[key]
        else:
            node[key] = spoiled(node[key], rng)
        return node
    return rng.choice(VALUES)


def test_spoiled_manifests_raise_errors_of_ours_alone(folder: Path) -> None:
    text = (folder / FILE).read_text()
    refused = 0
    for seed in range(150):
        document = spoiled(json.loads(text), random.Random(seed))  # noqa: S311 - a test's own draws
        (folder / FILE).write_text(json.dumps(document))
        try:
            die_of(folder, 1000)
        except CircuitError as error:
            refused += 1
            assert "\n" not in str(error)  # noqa: PT017 - whatever is raised is one line
    assert refused > 75


test_a_plan_of_no_dies_that_there_are_is_refused = refusals(
    ParameterError,
    lambda change_of: replace(Plan("random", 0, 0, 1), **change_of),
    [
        ({"count": -1}, "samples: -1"),
        ({"first": -1}, "samples: 1 from die -1"),
        ({"seed": -1}, "seed: -1"),
        ({"method": "best"}, "plan: best"),
        ({"first": 10**12}, "first_die: "),
    ],
)


@pytest.mark.parametrize(
    "options",
    [
        ["-n", "99999999999999999999"],
        ["-n", "1", "--trials", "99999999999"],
        ["-n", "1", "--threads", "99999999"],
        ["-n", "1", "--workers", "99999999"],
        ["-n", "1", "first_die", "9" * 40],
        ["-n", "1", "seed", "9" * 40],
        ["-n", "1", "seed", "-1"],
        ["-n", "1", "--at", f"ranging-chip/neuron[{'9' * 5000}]"],
        ["-n", "1", "--at", f"ranging-chip/neuron[{'9' * 40}]"],
    ],
)
def test_counts_have_limits(options: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["montecarlo", "rebound-neuron", "--metric", "t_inh", *options]) == 2
    err = capsys.readouterr().err
    assert len(err.splitlines()) == 1
    assert len(err) < 400


def test_the_document_is_what_is_read_back(folder: Path) -> None:
    found = read_study(folder)
    document = json.loads((folder / FILE).read_text())
    assert {k: v for k, v in describe(found).items() if k != "command"} == {
        k: v for k, v in document.items() if k != "command"
    }
