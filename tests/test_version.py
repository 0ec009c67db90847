"""One version: of the project, the installed distribution, the command, manifests, and the citation."""

from __future__ import annotations

import json
import re
import tomllib
from importlib.metadata import version

import pytest
import yaml

from system.cli.command_line import main
from system.study.manifest import Study, describe
from system.study.plan import Plan
from system.study.table import Condition
from system.study.target import Subject
from tests.documents import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def test_all_say_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    stated = PROJECT["version"]
    assert version("noctule") == stated
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"noctule {stated}\n"
    assert main(["doctor", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["noctule"] == stated
    study = Study(
        Subject("axon-delay", ("delay",)), Plan("random", 0, 1000, 1), (Condition("random", 27.0, 0),), 1
    )
    assert describe(study)["versions"]["noctule"] == stated


def test_the_citation_is_of_this_version() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    for field in ("version", "license", "keywords"):
        assert cited[field] == PROJECT[field]
    papers = {f"{each['authors'][0]['family-names'].lower()}{each['year']}" for each in cited["references"]}
    folders = (ROOT / "system" / "papers").iterdir()
    made_again = {path.name for path in folders if re.search(r"\d{4}$", path.name)}
    assert {name.replace("ö", "o") for name in papers} == made_again


def test_the_changelog_has_this_version() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"\n## {PROJECT['version']}" in text
    assert re.findall(r"^### (\w+)$", text, re.MULTILINE)[:3] == ["Added", "Changed", "Fixed"]
