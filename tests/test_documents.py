"""Every command and code block of the documents does what it is there for; `--help` names no other commands.

They are found in the texts by `tests.documents`, so that a new one is taken up without being listed. Each
command is parsed as it stands. Then it is run in its short form; one that has none is begun in a process of
its own and interrupted as by Ctrl-C. So are all commands of the README and those that `--help` names; of the
other pages it is a sample by a hash of the commit: the same commit has the same sample on every machine, and
the next has another. `pytest tests/test_documents.py --documents=all` runs those of every page.
"""

from __future__ import annotations

import json
import os
import pkgutil
import re
import shlex
import signal
import subprocess
import sys
import tomllib
import warnings
from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from types import FrameType

import pytest
import typer
from typer.testing import CliRunner

from chips.record_file import ENVIRONMENT
from circuits.extraction.coach.models import unknowns_of
from circuits.extraction.coach.posterior import posterior_table
from circuits.extraction.coach.table import read_folder
from circuits.extraction.coach.unknown import before
from circuits.silicon.die import NOMINAL
from circuits.silicon.process import ROLLS_180
from netlists.ngspice.library import find_library
from system.cli import run_command_line, shared_options, verb
from system.cli.command_line import INTERRUPTED, app, main
from system.cli.examples import EXAMPLES as SHOWN_BY_HELP
from system.cli.guide import TRIED
from system.options.die.file import write_die_file
from tests.documents import (
    COMMAND,
    DOCUMENTS,
    EXAMPLES,
    LETTERS,
    README,
    ROOT,
    SHELL,
    Command,
    chains,
    chosen,
    codes,
    commands,
    fenced,
    indented,
    shortened,
)
from tests.walks import without_walks

ENOUGH = 0.2  # s of processor time after which a long command is interrupted; ours
AGAIN = 5.0  # s of it after which it is once more: a callback may have swallowed the first; ours
TEXTS = {path: without_walks(path.read_text(encoding="utf-8")) for path in (*DOCUMENTS, *EXAMPLES)}
LANGUAGES = {path: [language for language, _ in fenced(TEXTS[path])] for path in DOCUMENTS}
# of an executed page the site's build runs the cells, which other blocks may go on from
PYTHON = [path for path, found in LANGUAGES.items() if "python" in found and "{code-cell}" not in found]
SHOWN = ("yaml", "spice", "verilog", "csv")  # languages of blocks that are not checked, besides directives
SAMPLED = 4  # of each kind of thing on pages other than the README; ours: all together take a minute
ASKING = {"--version", "--help"}  # options that are answered without a verb
PATH = re.compile(r"(?:[\w.*-]+/)+[\w.*-]*")
NAME = re.compile(r"(?:circuits|chips|netlists|system)(?:\.\w+)+")
OPTION = re.compile(r"--[a-z][a-z-]+")
COMPILER = re.compile(r"/(?:numba|llvmlite)/")
PIP = ".venv/bin/pip"
# Programs of others, and how they say what they would do.
DRY = {
    "make": ["make", "-n"],
    ".venv/bin/pytest": [sys.executable, "-m", "pytest", "-q", "--collect-only"],
    PIP: [sys.executable, "-m", "pip"],
}


@lru_cache
def verbs() -> tuple[tuple[str, ...], ...]:
    """Words by which commands are called, those of systems among them."""
    group = typer.main.get_command(app())
    groups = {name: command for name, command in group.commands.items() if hasattr(command, "list_commands")}  # type: ignore[attr-defined]
    inner = {name: each.list_commands(typer.Context(each)) for name, each in groups.items()}
    found = ((name, *rest) for name in group.commands for rest in [(), *((n,) for n in inner.get(name, ()))])  # type: ignore[attr-defined]
    return tuple(found)


@lru_cache
def help_of(verb: tuple[str, ...]) -> str:
    """Help of a command, without line breaks."""
    found = CliRunner().invoke(app(), [*verb, "--help"], terminal_width=200)
    assert found.exit_code == 0
    return " ".join(found.output.split())


@lru_cache
def options_of(verb: tuple[str, ...]) -> frozenset[str]:
    """Options of a command."""
    return frozenset(OPTION.findall(help_of(verb).partition("Options:")[2].partition("Example:")[0]))


@lru_cache
def options_of_all() -> frozenset[str]:
    """Options of all commands."""
    return frozenset().union(*(options_of(verb) for verb in ((), *verbs())))


HELP = ROOT / "system" / "cli" / "examples.py"
FOUND = {path: commands(text) for path, text in TEXTS.items()}
FOUND[HELP] = commands("".join(f"\n\n    {line}\n" for lines in SHOWN_BY_HELP.values() for line in lines))
EACH = list({command.words: command for found in FOUND.values() for command in found}.values())
OURS = [command for command in EACH if command.program == "noctule"]
FRAGMENTS = [command for command in OURS if command.placeholders]
WHOLE = [command for command in OURS if not command.placeholders]
BEGUN = list({command.words[:3]: command for command in reversed(WHOLE) if command.long}.values())
OTHERS = [command for command in EACH if command.program in DRY]


def chains_of_pages() -> list[tuple[Command, ...]]:
    """Chains of each page, without those whose commands earlier pages have."""
    found, seen = [], set[Command]()
    for each in FOUND.values():
        short = [command for command in each if command in WHOLE and not command.long]
        found += [chain for chain in chains(short) if not seen.issuperset(chain)]
        seen.update(short)
    return found


CHAINS = chains_of_pages()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """What is run of the documents: all of it, or the README and a sample."""

    def give(name: str, found: Sequence[object], in_readme: Callable[..., bool]) -> None:
        if name in metafunc.fixturenames:
            everything = metafunc.config.getoption("documents") == "all"
            taken = found if everything else chosen(found, SAMPLED, in_readme)
            metafunc.parametrize(name, taken, ids=_name)

    tried = {line for words in TRIED for line in SHOWN_BY_HELP[words]}
    first = [*FOUND[README], *(command for command in FOUND[HELP] if str(command) in tried)]
    give("chain", CHAINS, lambda chain: chain[0] in first)
    give("begun", BEGUN, lambda command: command in first)
    give("other", OTHERS, lambda command: command in first)


def _name(each: object) -> str:
    if isinstance(each, Path):
        return str(each.relative_to(ROOT))
    return str(each) if isinstance(each, Command) else " + ".join(map(str, each))


PAGE = """
To see them, `noctule list` (that is `.venv/bin/noctule`); {doc}`noctule show` is a reference. Then:

```console
$ noctule simulate axon-delay \\
    --die 3
noctule: output, not a command
$ .venv/bin/noctule doctor  # what is missing
```

````{tip}
:class: wide

```{code-block} sh
:caption: all of it
noctule export axon-delay -o a.cir
```
````

```{command} noctule op axon-delay --csv devices.csv
:lines: 12
```

```{command} noctule op no-such-block
:status: 2
```

```{code-cell} ipython3
noctule = 1
```
"""


def test_commands_of_a_page_are_those_that_its_reader_types() -> None:
    assert [str(command) for command in commands(PAGE)] == [
        "noctule simulate axon-delay --die 3",
        "noctule doctor",
        "noctule export axon-delay -o a.cir",
        "noctule op axon-delay --csv devices.csv",
        "noctule list",
    ]
    assert [language for language, _ in fenced(PAGE)] == ["console", "sh", "sh", "{command}", "{code-cell}"]


def test_a_sample_has_what_is_always_taken_and_the_same_others_each_time() -> None:
    taken = chosen(range(1000), 10, lambda number: number < 5)
    assert taken == chosen(range(1000), 10, lambda number: number < 5)
    assert len(taken) == 15
    assert taken[:5] == [*range(5)]
    assert chosen(range(3), 10, lambda number: number < 0) == [0, 1, 2]


def test_a_command_that_reads_within_a_folder_goes_with_the_one_that_writes_it() -> None:
    found = commands("`noctule mission approach -o kept`\n\n`noctule replay kept/gate-27C --die 1001`\n")
    assert [len(chain) for chain in chains(found)] == [2]


def test_what_the_documents_have_is_found() -> None:
    assert len(OURS) > 50
    assert len(CHAINS) > len(FRAGMENTS) + len(BEGUN), f"{len(FRAGMENTS)} parsed, {len(BEGUN)} begun only"
    assert any(len(chain) > 1 for chain in CHAINS)
    lines = [line for path in DOCUMENTS for line in indented(TEXTS[path])]
    assert [line for line in lines if not COMMAND.match(line)] == []
    spans = [code for path in DOCUMENTS for code in codes(TEXTS[path])]
    first = {verb[0] for verb in verbs()}
    said = [code for code in spans if " " in code and code.split()[0] in first]
    # a command begins with noctule; an option of one may be named by the two alone, as `op --csv`
    assert [code for code in said if not names_an_option(code)] == []


MADE = ("--spikes", "--mended")  # options whose files a command writes, besides those of a run's output
READ = (".toml", ".csv", ".cir", ".npz", ".nir")  # suffixes of what a command may read


def test_files_that_commands_read_are_in_the_checkout_or_written_before() -> None:
    """Of all commands, since a sample of those with a reader's own file may miss that it is not there."""
    for chain in (*CHAINS, *((command,) for command in BEGUN)):
        there = {"die.toml"} if chain[0] in BEGUN else set()
        for command in chain:
            there |= {*command.written, *(word for option, word in pairwise(command.words) if option in MADE)}
            read = [word for word in command.words if word.partition(":")[0].endswith(READ)]
            mine = [word for word in read if not (ROOT / word.partition(":")[0]).is_file()]
            assert set(mine) <= there, str(command)


def names_an_option(code: str) -> bool:
    """Whether a verb's words and one of its options are all that is said, or the option's value beside."""
    before, _, after = code.partition(" --")
    words = tuple(before.split())
    found = next(words[:k] for k in (2, 1) if words[:k] in verbs())
    return f"--{after.split()[0]}" in options_of(found) if after else False


def test_commands_that_help_names_are_among_those_of_the_documents_and_run() -> None:
    """Help is not read before tests are collected, so those that the README has not are run here."""
    said = {text for verb in ((), *verbs()) for text in re.findall(r"see (noctule \w+)", help_of(verb))}
    assert said
    assert said <= {str(command) for command in OURS}
    for text in said - {str(command) for command in FOUND[README]}:
        assert main(shlex.split(text)[1:]) == 0


@pytest.mark.parametrize("command", OURS, ids=str)
def test_the_command_is_parsed_as_it_stands(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    called: list[str] = []

    def noted(place: str) -> object:
        def function(*_: object, **__: object) -> int:
            called.append(place)
            return 0

        return function

    for module in (verb, run_command_line):
        monkeypatch.setattr(module, "loaded", noted)
    monkeypatch.setattr(shared_options, "loaded", lambda _: lambda *_: None)  # a die of a study
    assert main(command.words[1:]) == 0
    assert len(called) == (0 if ASKING & set(command.words) else 1)
    said = help_of(command.verb)
    for word in command.placeholders:  # as the help names it: `--bias-set NAME`, `{BLOCK}`
        before = command.words[command.words.index(word) - 1]
        assert f"{LETTERS.get(before, before)} {word}" in said or f"{{{word}}}" in said
    assert set(OPTION.findall(command.comment)) <= options_of(command.verb)


def test_the_command_runs(
    chain: Sequence[Command],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(ENVIRONMENT, str(tmp_path / "records"))
    (tmp_path / "examples").symlink_to(ROOT / "examples")  # as in the checkout, where a reader gives commands
    for command in chain:
        if "ngspice" in command.words:
            _need_ngspice()
        arguments = shortened(command, options_of(command.verb))
        assert main(arguments) == 0, capfd.readouterr().err
        said = capfd.readouterr()
        assert "Traceback" not in said.err
        _check_output(command, said.out)


def test_the_long_command_begins(begun: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv(ENVIRONMENT, str(tmp_path / "records"))  # one that ends keeps its record to itself
    _unmeasured_chip(tmp_path / "die.toml")
    arguments = shortened(begun, options_of(begun.verb))
    status, out, err = _begun(arguments)
    if status == INTERRUPTED:
        assert err == "noctule: interrupted\n"
        return
    # few runs of a campaign may well disagree with the paper
    assert status == 0 or (status == 1 and "--param" in arguments), err
    _check_output(begun, out)


def _unmeasured_chip(path: Path) -> None:
    """The die that a long command before would identify, of which no measurement has told anything."""
    conditions = {name: condition for name, (condition, _) in read_folder(None, "predict").items()}
    known = before(unknowns_of(conditions, ROLLS_180))
    write_die_file(path, NOMINAL, posterior_table(known, {}))


def _interrupt(number: int, frame: FrameType | None) -> None:
    """Interrupt as by Ctrl-C, but no compilation: what a broken one leaves can end the process."""
    at = frame
    while at is not None:
        if COMPILER.search(at.f_code.co_filename):
            signal.setitimer(signal.ITIMER_PROF, 0.1, AGAIN)
            return
        at = at.f_back
    signal.default_int_handler(number, frame)


def _begun(arguments: Sequence[str]) -> tuple[int, str, str]:
    """Status, stdout and stderr of a command that is interrupted when it has had enough time."""
    with warnings.catch_warnings(action="ignore"):  # from Python 3.12 on of threads, which are idle here
        child = os.fork()
    if child == 0:
        signal.signal(signal.SIGPROF, _interrupt)
        signal.setitimer(signal.ITIMER_PROF, ENOUGH, AGAIN)
        with Path("out").open("w") as sys.stdout, Path("err").open("w") as sys.stderr:
            status = main(arguments)
        os._exit(status)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    return status, Path("out").read_text(encoding="utf-8"), Path("err").read_text(encoding="utf-8")


def _check_output(command: Command, out: str) -> None:
    if "--json" in command.words:
        assert json.loads(out, parse_constant=pytest.fail)
    assert out.strip() or command.written
    for name in command.written:
        path = Path(name)
        assert any(path.iterdir()) if path.is_dir() else path.stat().st_size > 100, name


def _need_ngspice() -> None:
    if find_library() is None:
        if os.environ.get("CI") == "true":
            pytest.fail("no ngspice library in CI")
        pytest.skip("no ngspice library; install Debian's libngspice0 or set NGSPICE_LIBRARY_PATH")


def test_what_is_not_known_here_is_installed_on_its_page() -> None:
    for found in FOUND.values():
        programs = [command.program for command in found]
        unknown = [k for k, program in enumerate(programs) if program not in {"noctule", *DRY}]
        assert all(PIP in programs[:k] for k in unknown)


def test_the_command_of_another_program_is_known_to_it(other: Command) -> None:
    words = (other.words[1], "--help") if other.program == PIP else other.words[1:]
    dry = [*DRY[other.program], *words]
    done = subprocess.run(dry, cwd=ROOT, capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


def test_python_of_a_page_is_run_by_the_build() -> None:
    """It stands in cells or in the directive `script`; beside cells a plain block may go on from them."""
    assert PYTHON == []


@pytest.mark.parametrize("path", DOCUMENTS, ids=_name)
def test_blocks_are_of_a_language_that_is_checked(path: Path) -> None:
    for language, block in fenced(TEXTS[path]):
        match language:
            case "toml":
                tomllib.loads(block)
            case "json":
                json.loads(block, parse_constant=pytest.fail)
            case "python":
                compile(block, str(path), "exec")
            case _:
                assert language.startswith("{") or language in {"text", *SHELL, *SHOWN}, block


def test_the_help_of_every_command_ends_with_an_example_of_it() -> None:
    assert set(SHOWN_BY_HELP) == set(verbs())
    for words, lines in SHOWN_BY_HELP.items():
        assert help_of(words).endswith(f" Example: {' '.join(lines)}")
        assert lines[-1].split()[1:][: len(words)] == [*words]
        assert max(map(len, lines)) <= 76  # what help of 80 columns has room for


@pytest.mark.parametrize("verb", verbs(), ids=" ".join)
def test_every_command_has_help_and_json(verb: tuple[str, ...]) -> None:
    assert help_of(verb).startswith(f"Usage: noctule {' '.join(verb)} ")
    assert verb in {("run",), ("blame",)} or "--json" in options_of(verb)


@pytest.mark.parametrize("path", DOCUMENTS, ids=_name)
def test_options_files_and_names_in_sentences_exist(path: Path) -> None:
    spans = codes(TEXTS[path])
    used = {option for code in spans if code.startswith("--") for option in OPTION.findall(code)}
    assert used <= options_of_all()
    made = (".", "build/")  # by make
    files = [code for code in spans if PATH.fullmatch(code) and not code.startswith(made)]
    assert [name for name in files if not list(ROOT.glob(name))] == []
    for name in filter(NAME.fullmatch, spans):
        pkgutil.resolve_name(name)
