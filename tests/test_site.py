"""The site's own directives: rows of experiments with links to them, tables from the code."""

from __future__ import annotations

import base64
import importlib
import json
import re
import shlex
import shutil
import sys
from collections.abc import Iterator
from io import StringIO
from pathlib import Path
from types import ModuleType

import pytest
from sphinx.application import Sphinx
from sphinx.util.docutils import docutils_namespace

from circuits.errors import CircuitError
from system.cli.command_line import main
from tests.documents import PAGES, ROOT, sentences

REPORT = {
    "rows": [
        {
            "name": "best_delay_s",
            "paper": 0.02,
            "ours": 0.0201234,
            "rule": "within 5 %",
            "tolerance": 0.05,
            "fitted": True,
            "agrees": True,
        },
        {
            "name": "spikes",
            "paper": None,
            "ours": "none at all",
            "rule": "some",
            "tolerance": None,
            "fitted": False,
            "agrees": False,
        },
    ],
    "scores": [
        {"name": "ours", "held": 1, "judged": 2, "p": None},
        {"name": "never fires", "held": 0, "judged": 2, "p": 0.5},
    ],
    "notes": ["One of `two` notes."],
}
REFUSED = re.compile(r"^```\{command\} (.*)\n((?::.*\n)*?):status: (\d+)$", re.MULTILINE)
REFUSALS = [(page, *found) for page in PAGES for found in REFUSED.findall(page.read_text(encoding="utf-8"))]
# Modules with errors of their own that no other of these tests imports.
HAVE_ERRORS = ("system.study.search.worst_case", "chips.nef.nengo.errors", "system.study.blame.verdict")
ERROR_CLASS = re.compile(r"^class ([A-Za-z]\w+)\((\w+)", re.MULTILINE)
LONG_ROWS = re.compile(r"^```\{rows\} (\S+)\n(?::(?!kept|short).*\n)*:long:", re.MULTILINE)
ROW_CLAIM = re.compile(r"\{row\}`[^`]*?<?([\w-]+)/[^`]*`")
LONGEST_AVERAGE = 25  # words of a sentence
PAGE = """# A page

```{rows} cheely2003-fig4
```

Not so: {row}`its spikes <cheely2003-fig4/spikes>`, as {row}`cheely2003-fig4/best_delay_s`.
"""


@pytest.fixture
def running(monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """The module that runs commands, found as the site's configuration finds it."""
    monkeypatch.syspath_prepend(str(ROOT / "docs"))
    yield importlib.import_module("_extension.running")
    for name in [name for name in sys.modules if name.partition(".")[0] == "_extension"]:
        del sys.modules[name]


def built(folder: Path, page: str, *, run: bool, reader: str = "myst_parser") -> tuple[str, str]:
    """Page of a site of one page, and the warnings of its build."""
    (folder / "index.md").write_text(page, encoding="utf-8")
    settings = {
        "extensions": [reader, "_extension.command", "_extension.rows", "_extension.places"],
        "source_suffix": {".md": "myst-nb" if reader == "myst_nb" else "markdown"},
        "noctule_run": run,
        "noctule_folder": str(folder / "commands"),
    }
    said = StringIO()
    with docutils_namespace():
        app = Sphinx(
            folder, None, folder / "out", folder / "read", "html", settings, status=None, warning=said
        )
        app.build()
    return (folder / "out" / "index.html").read_text(encoding="utf-8"), said.getvalue()


def navigation(folder: Path, *extensions: str) -> dict[str, str]:
    """The tree of pages beside each page of a small site, one page of which is below another's heading."""
    below = "# {}\n\n## A heading of {}\n\n```{{toctree}}\n{}\n```\n\n## The last\n"
    pages = {"index": ("Top", "one\ntwo"), "one": ("One", "deep"), "two": ("Two", ""), "deep": ("Deep", "")}
    for name, (title, inside) in pages.items():
        (folder / f"{name}.md").write_text(below.format(title, title, inside), encoding="utf-8")
    found: dict[str, str] = {}
    with docutils_namespace():
        read, settings = folder / "read", {"extensions": ["myst_parser", *extensions]}
        app = Sphinx(folder, None, folder / "out", read, "html", settings, status=None, freshenv=True)
        options = {"titles_only": True, "collapse": False, "maxdepth": -1, "includehidden": True}
        app.connect(
            "html-page-context",
            lambda _, name, __, context, ___: found.update({name: str(context["toctree"](**options))}),
            priority=600,
        )
        app.build()
    return found


@pytest.mark.usefixtures("running")
def test_the_tree_of_titles_is_the_one_that_sphinx_makes_of_all_headings(tmp_path: Path) -> None:
    of_titles = navigation(tmp_path, "_extension.navigation")
    assert of_titles == navigation(tmp_path)
    assert all(title in of_titles["two"] for title in (">One<", ">Deep<", ">Two<"))
    assert "heading" not in of_titles["two"]


def test_rows_of_an_experiment_are_a_table_to_whose_rows_claims_link(
    running: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = []

    def done(line: str, *_: object, **__: object) -> object:
        lines.append(line)
        return running.Done(1, json.dumps(REPORT), "", "")

    monkeypatch.setattr(running, "done", done)
    html, said = built(tmp_path, PAGE, run=True)
    assert lines == ["noctule reproduce cheely2003-fig4 --json --plot experiment-cheely2003-fig4.png"]
    assert said == ""
    for text in ("0.02012", "within 5 %", ">fitted<", ">predicted<", "none at all", ">two<"):
        assert text in html
    for anchor in ("rows-cheely2003-fig4-spikes", "rows-cheely2003-fig4-best-delay-s"):
        assert f'id="{anchor}"' in html
        assert html.count(f'href="#{anchor}"') == 2


def test_a_claim_about_a_row_that_is_none_is_told(
    running: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(running, "done", lambda *_, **__: running.Done(0, json.dumps(REPORT), "", ""))
    _, said = built(tmp_path, PAGE.replace("/spikes", "/sparks"), run=True)
    assert "undefined label: 'rows-cheely2003-fig4-sparks'" in said


def test_rows_and_picture_of_an_experiment_are_of_one_run(
    running: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines = []

    def run(line: str, folder: Path, kept: Path, names: list[str]) -> object:
        lines.append(line)
        kept.mkdir(parents=True)
        (kept / names[0]).write_bytes(base64.b64decode(PIXEL))
        return running.Done(1, json.dumps(REPORT), "one row disagrees", str(kept))

    monkeypatch.setattr(running, "_run", run)
    gallery = importlib.import_module("_extension.gallery")
    row = next(row for row in gallery.rows() if row.name == "cheely2003-fig4")
    picture = "\n".join(gallery.markdown(row))
    html, said = built(tmp_path, f"{PAGE}\n{picture}\n", run=True)
    assert said == ""
    assert len(lines) == 1
    assert re.findall(r"_images/([\w-]+)", html) == ["experiment-cheely2003-fig4"]
    assert "one row disagrees" in html
    monkeypatch.setattr(running, "_run", lambda *_: running.Done(2, "", "no such experiment", ""))
    refused = tmp_path / "refused"
    refused.mkdir()
    _, said = built(refused, picture, run=True)
    assert "cheely2003-fig4: status 2: no such experiment" in said


def test_without_a_run_claims_link_to_the_experiment(running: ModuleType, tmp_path: Path) -> None:
    assert running
    html, said = built(tmp_path, PAGE, run=False)
    assert said == ""
    assert html.count('href="#rows-cheely2003-fig4"') == 2
    assert 'id="rows-cheely2003-fig4"' in html


def test_a_claim_about_a_row_is_of_an_experiment_whose_rows_the_build_makes() -> None:
    texts = [page.read_text(encoding="utf-8") for page in PAGES]
    long = {name for text in texts for name in LONG_ROWS.findall(text)}
    rows = {name for text in texts for name in ROW_CLAIM.findall(text)}
    assert long
    assert rows
    assert not rows & long, "name the experiment alone, without the row"


def test_a_refused_command_shows_what_it_says(running: ModuleType, tmp_path: Path) -> None:
    assert running
    page = "# A page\n\n```{command} noctule op nothing\n:status: 2\n```\n"
    html, said = built(tmp_path, page, run=True)
    assert said == ""
    assert "unknown" in html
    assert "[status 2]" in html


def test_a_script_goes_on_from_those_before_it(running: ModuleType, tmp_path: Path) -> None:
    assert running
    page = "# A page\n\n```{script}\nx = 3\nprint('once')\n```\n\n```{script}\nprint(f'{x + 4} of it')\n```\n"
    html, said = built(tmp_path, page, run=True)
    assert said == ""
    shown = re.sub(r"<[^>]+>", "", html)
    assert shown.count("once\n") == 1
    assert "7 of it" in shown


def test_a_film_has_a_still_which_stands_alone_where_nothing_is_run(
    running: ModuleType, tmp_path: Path
) -> None:
    assert running
    line = "noctule simulate axon-delay --plot film.png"
    page = f"# A page\n\n```{{command}} {line}\n:hide:\n:still: still.png\n```\n"
    (tmp_path / "still.png").write_bytes(base64.b64decode(PIXEL))
    alone, said = built(tmp_path, page, run=False)
    assert said == ""
    assert re.findall(r"_images/(\w+)", alone) == ["still"]
    both, _ = built(tmp_path, page, run=True)
    film = both[both.index("noctule-film") :]
    assert re.findall(r"_images/(\w+)", film) == ["film", "still"]


def test_every_picture_that_a_command_draws_is_shown(running: ModuleType) -> None:
    words = shlex.split("noctule montecarlo x --plot a.png --contributions y --pareto b.png --animate c.gif")
    assert running.drawn(words) == ["a.png", "b.png", "c.gif"]


PIXEL = "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNgAAAAAgABSK+kcQAAAABJRU5ErkJggg=="
NOTEBOOK = """---
jupytext:
  text_representation:
    extension: .md
    format_name: myst
kernelspec:
  name: python3
  display_name: Python 3
---

# A notebook

```{code-cell}
import sys
import warnings

print(sys.prefix + "/bin/python")
warnings.warn("careful")
```
"""


def test_what_a_notebook_prints_names_no_folder_of_the_machine(running: ModuleType, tmp_path: Path) -> None:
    assert running
    html, _ = built(tmp_path, NOTEBOOK, run=False, reader="myst_nb")
    shown = re.sub("<[^>]+>", "", html[html.index("cell_output") :])
    assert "bin/python" in shown
    assert "a cell:5: UserWarning: careful" in shown
    for folder in (sys.prefix, str(ROOT), "ipykernel"):
        assert folder not in shown


@pytest.mark.parametrize(("page", "line", "options", "status"), REFUSALS, ids=[each[1] for each in REFUSALS])
def test_a_command_that_a_page_shows_as_refused_is(
    page: Path,
    line: str,
    options: str,
    status: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    for name in options.removeprefix(":needs: ").split():
        shutil.copy(page.parent / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    words = shlex.split(line)
    while words[0] != "noctule":
        name, _, value = words.pop(0).partition("=")
        if value:
            monkeypatch.setenv(name, value)
    assert main(words[1:]) == int(status)
    said = capfd.readouterr()
    assert said.out == ""
    assert len(said.err.splitlines()) == 1


def test_errors_that_a_page_shows_are_found() -> None:
    assert len(REFUSALS) > 15


def test_the_tree_of_errors_has_every_class(running: ModuleType) -> None:
    assert running
    for module in HAVE_ERRORS:
        importlib.import_module(module)
    listed = {each.__name__ for _, each in importlib.import_module("_extension.error_tree").tree()}
    packages = ("circuits", "chips", "netlists", "system")
    texts = [path.read_text(encoding="utf-8") for name in packages for path in (ROOT / name).rglob("*.py")]
    found = {name: base for text in texts for name, base in ERROR_CLASS.findall(text)}
    ours = {CircuitError.__name__}
    while more := {name for name, base in found.items() if base in ours} - ours:
        ours |= more
    assert listed == ours


def test_what_a_docstring_says_of_fields_is_found(running: ModuleType) -> None:
    assert running
    fields = importlib.import_module("_extension.file_fields")
    numpydoc = (
        "A study.\n\nAttributes\n----------\nname, kind : what it is: text.\nlot : of dies.\n\nRaises X."
    )
    assert fields.entries(numpydoc) == {
        "name": "what it is: text",
        "kind": "what it is: text",
        "lot": "of dies",
    }
    typed = "A study.\n\nAttributes\n----------\nname, kind : str\n    What it\n    is.\nlot\n    Of dies."
    assert fields.entries(typed) == {"name": "What it is", "kind": "What it is", "lot": "Of dies"}
    assert fields.entries("A run.\n\nkey: which one; found: what: it is.") == {
        "key": "which one",
        "found": "what: it is",
    }


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT / "docs")))
def test_sentences_of_a_page_are_short(page: Path) -> None:
    said = sentences(page.read_text(encoding="utf-8"))
    average = sum(len(each.split()) for each in said) / max(len(said), 1)
    assert average <= LONGEST_AVERAGE, f"{average:.1f} words a sentence"


def test_sentences_are_found() -> None:
    table = "| no | sentence |\n|---|---|\n| a | b. |"
    text = f"# A page\n\nOne of `two words`. Is it 3.5 V?\nIt is.\n\n{table}\n\n- An item"
    assert sentences(text) == ["A page", "One of code.", "Is it 3.5 V?", "It is.", "An item"]
