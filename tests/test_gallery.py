"""The gallery has a row for everything that the registries name, and its commands are ones that draw."""

from __future__ import annotations

import importlib.util
import json
import shlex
import sys
from pathlib import Path
from types import ModuleType

import pytest

from chips.registry import chip_names
from circuits import registry
from circuits.blocks.sonar.rebound_neuron import BLOCK
from circuits.registry import block_names
from system.registry import experiment_names, system_names

DOCS = Path(__file__).parents[1] / "docs"
NAMES = {
    "block": block_names(),
    "chip": chip_names(),
    "robot": system_names(),
    "experiment": experiment_names(),
}


@pytest.fixture(scope="module")
def gallery() -> ModuleType:
    found = importlib.util.spec_from_file_location("docs_gallery", DOCS / "_extension" / "gallery.py")
    assert found is not None
    assert found.loader is not None
    module = importlib.util.module_from_spec(found)
    sys.modules["docs_gallery"] = module  # its dataclass looks itself up
    found.loader.exec_module(module)
    return module


def test_all_that_is_registered_is_shown_or_left_out_by_name(gallery: ModuleType) -> None:
    rows = gallery.rows()
    for kind, names in NAMES.items():
        shown = [row.name for row in rows if row.kind == kind]
        out = gallery.left_out() if kind == "experiment" else ()
        assert sorted((*shown, *out)) == sorted(names)
    assert len({row.picture for row in rows}) == len(rows)
    assert all(shlex.split(row.command)[-2:] == ["--plot", row.picture] for row in rows)
    assert all("--animate" in row.command for row in rows if row.kind == "robot")
    assert set(gallery.FASTER) <= set(NAMES["robot"])


def test_names_of_exceptions_are_known(gallery: ModuleType) -> None:
    assert {name for _, name in gallery.COMMANDS} <= {name for names in NAMES.values() for name in names}


def test_a_new_block_has_a_row(gallery: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gallery, "block_names", lambda: (*registry.block_names(), "new-block"))
    load = gallery.load_block
    monkeypatch.setattr(gallery, "load_block", lambda name: BLOCK if name == "new-block" else load(name))
    row = next(row for row in gallery.rows() if row.name == "new-block")
    assert row.command == "noctule simulate new-block --plot block-new-block.png"
    assert f"```{{command}} {row.command}" in gallery.markdown(row)


def test_the_page_has_every_kind_and_the_list_is_printed(
    gallery: ModuleType, capsys: pytest.CaptureFixture[str]
) -> None:
    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    assert all(f"```{{gallery}} {kind}\n" in page for kind in gallery.HEADINGS)
    gallery.print_rows()
    assert len(json.loads(capsys.readouterr().out)) == len(gallery.rows())
