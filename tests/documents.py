"""Commands and code blocks of the documents, found in their text, and the short form in which they are run.

Documents are the README, CONTRIBUTING and every page of `docs/`, in folders of it too. A command is a line
of an indented block or of one of a shell's language, or `code` in a sentence, that begins with `noctule `,
`make ` or `.venv/bin/`, or the argument of a directive `{command}` that is to end well. Where a block has
lines with a prompt `$ `, all others are output; a line that ends with a backslash goes on in the next. Blocks
inside a page's notes, tabs and such are blocks of the page.
Code cells of an executed page are none: building the site runs them.
Words in capitals (`BLOCK`, `--bias-set NAME`) stand for the reader's own and make it a fragment.
"""

from __future__ import annotations

import hashlib
import re
import shlex
import subprocess
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import TypeVar

from markdown_it import MarkdownIt
from markdown_it.token import Token

from circuits.errors import ParameterError
from system.registry import load_experiment, load_system, system_names

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
README = ROOT / "README.md"
PAGES = sorted(page for page in (ROOT / "docs").rglob("*.md") if "_build" not in page.relative_to(ROOT).parts)
DOCUMENTS = (README, ROOT / "CONTRIBUTING.md", *PAGES)

T = TypeVar("T")

MARKDOWN = MarkdownIt("commonmark").enable("table")
SHELL = ("sh", "bash", "console")
PROMPT = "$ "
DIRECTIVE = re.compile(r"\{([\w:-]+)\}\s*(.*)")
CODE_DIRECTIVES = ("code-block", "code", "sourcecode")  # their argument is a language
RUN_DIRECTIVE = "command"  # `docs/_extension/command.py`: its argument is a command
FAILS = re.compile(r"^:status: *[1-9]", re.MULTILINE)
PROSE_DIRECTIVES = (  # whose content is Markdown
    *("note", "tip", "hint", "important", "warning", "caution", "admonition", "seealso", "dropdown"),
    *("tab-set", "tab-item", "grid", "grid-item", "grid-item-card", "card", "details", "div"),
)
OPTION_LINES = re.compile(r"\A(?::[\w-]+:.*\n)+")  # of a directive, before its content
SENTENCE_END = re.compile(r"(?<=[.!?])\s+(?=[A-Z(]|code\b)")
ROLE = re.compile(r"\{[\w:+-]+\}\Z")  # before `code`, which is then a reference
COMMAND = re.compile(r"(?:noctule|make|\.venv/bin/\S+) ")
PLACEHOLDER = re.compile(r"[A-Z][A-Z,]*")

# What makes a long command short: options that it has, whether it gives them or not.
SHORT = {
    "--samples": "1",
    "--tuning-dies": "4",
    "--fresh-dies": "4",
    "--generations": "1",
    "--duration": "0.2s",
    "--pings": "5",
}
GIVEN = {"--trips": "1"}  # and such as it gives
SHORT_STUDY = {
    "codes": "default"
}  # and options of a study's runs: a die's calibration is some 20 runs of its chip
FEWEST_RUNS = {"trials": "4"}  # of a campaign whose count cannot be 1
IN_NGSPICE = ("--stimulus", "duration=1ms")  # what a run there takes, which is slower than the solver
# Starting processes takes longer than what is left to do, and contributions are hundreds of runs whatever the
# samples: `system/study/search/test_breakdown.py` carries out studies with them.
DROPPED = ("--workers", "--contributions", "--pareto")
# What no option makes short enough; `system/cli/test_show_rolls.py` shows a chip.
LONG = (
    ("reproduce",),
    ("blame",),
    ("characterise",),
    ("extract",),
    ("identify",),
    ("predict",),
    ("show", "rolls"),
)
LETTERS = {"-n": "--samples", "-o": "--output"}
WRITTEN = ("--output", "--plot", "--csv", "--raw", "--events", "--animate")


@dataclass(frozen=True, slots=True)
class Command:
    """Words of a command as a document has it, and its comment."""

    words: tuple[str, ...]
    comment: str = field(default="", compare=False)

    def __str__(self) -> str:
        return shlex.join(self.words)

    @property
    def program(self) -> str:
        """What is run."""
        return self.words[0]

    @property
    def verb(self) -> tuple[str, ...]:
        """`montecarlo`, or `run approach`."""
        return self.words[1:3] if self.words[1] == "run" else self.words[1:2]

    @property
    def long(self) -> bool:
        """Whether it is begun only."""
        return any(self.words[1 : 1 + len(words)] == words for words in LONG)

    @property
    def placeholders(self) -> tuple[str, ...]:
        """Words that stand for the reader's own."""
        return tuple(word for word in self.words[1:] if PLACEHOLDER.fullmatch(word))

    @property
    def written(self) -> tuple[str, ...]:
        """Files and folders that it is asked for."""
        words = [LETTERS.get(word, word) for word in self.words]
        return tuple(value for option, value in pairwise(words) if option in WRITTEN and value != "-")


def fenced(text: str) -> list[tuple[str, str]]:
    """Language and text of fenced blocks, in order; of a directive `{name}` the language is `{name}`."""
    return [_language_and_text(token) for token in _tokens(text) if token.type == "fence"]


def indented(text: str) -> list[str]:
    """Lines of indented blocks."""
    found = [token.content for token in _tokens(text) if token.type == "code_block"]
    return [line.strip() for block in found for line in block.splitlines()]


def codes(text: str) -> list[str]:
    """Code in sentences, with spaces for its line breaks; no references such as {doc}`page`."""
    found = []
    for token in _tokens(text):
        before = ""
        for child in token.children or ():
            if child.type == "code_inline" and not ROLE.search(before):
                found.append(" ".join(child.content.split()))
            before = child.content
    return found


def sentences(text: str) -> list[str]:
    """Sentences of a page, headings and items among them, with a word for each code; none of its tables."""
    found, tables = [], 0
    for token in _tokens(text):
        tables += {"table_open": 1, "table_close": -1}.get(token.type, 0)
        if token.type == "inline" and not tables:
            words = "".join(_words(child) for child in token.children or ())
            found += [each for each in SENTENCE_END.split(words) if each.strip()]
    return found


def _words(token: Token) -> str:
    """Words of a part of a line."""
    return {"code_inline": "code", "softbreak": " ", "hardbreak": " "}.get(token.type, token.content)


def shell_lines(text: str) -> list[str]:
    """Command lines of a shell's block, without their prompts and with continued lines joined."""
    lines = text.replace("\\\n", " ").splitlines()
    prompted = [line.removeprefix(PROMPT) for line in lines if line.startswith(PROMPT)]
    return [line.strip() for line in prompted or lines]


def commands(text: str) -> list[Command]:
    """Commands of a text, each once: those of blocks in order, then those in sentences."""
    shell = [line for language, block in fenced(text) if language in SHELL for line in shell_lines(block)]
    lines = [line for line in (*indented(text), *shell, *codes(text)) if COMMAND.match(line)]
    found = {}
    for line in lines:
        words, _, comment = line.partition("  # ")
        first, *rest = shlex.split(words, comments=True)
        command = Command(("noctule" if first == ".venv/bin/noctule" else first, *rest), comment)
        found.setdefault(command.words, command)
    return list(found.values())


def chosen(found: Sequence[T], count: int, always: Callable[[T], bool]) -> list[T]:
    """Those that are always taken and `count` of the others, by a hash of them and of the commit.

    The same commit has the same ones on every machine, the next has others.
    """
    others = sorted((each for each in found if not always(each)), key=_rank)[:count]
    return [each for each in found if always(each) or each in others]


def chains(found: Iterable[Command]) -> list[tuple[Command, ...]]:
    """Commands in order, those together of which one reads what another writes."""
    together: list[list[Command]] = []
    for command in found:
        read = {*command.words, *(word.partition("/")[0] for word in command.words)}  # also within a folder
        makers = [c for c in together if any(set(each.written) & read for each in c)]
        together = [chain for chain in together if chain not in makers]
        together.append([*(each for chain in makers for each in chain), command])
    return [tuple(chain) for chain in together]


def shortened(command: Command, options: Iterable[str]) -> list[str]:
    """Arguments of the command's short form; options: all that it has."""
    words = [LETTERS.get(word, word) for word in command.words[1:]]
    short = {name: value for name, value in SHORT.items() if name in options}
    short |= {name: value for name, value in GIVEN.items() if name in words}
    params: dict[str, str] = {}
    if "--contributions" in words:
        short["--samples"] = "4"  # up to the die that is replayed
    if command.verb == ("montecarlo",):
        del short["--duration"]
        params = _of_study(words[1])
    elif command.verb == ("reproduce",):
        params = {name: FEWEST_RUNS.get(name, "1") for name in load_experiment(words[1]).counts or ()}
    if words[0] == "simulate" and "ngspice" in words and IN_NGSPICE[0] not in words:
        words += IN_NGSPICE
    left_out = {*short, *DROPPED, *(f"--{name}" for name in params)}
    pairs = [*short.items(), *(("--param", f"{name}={value}") for name, value in params.items())]
    return [*_without(words, left_out), *(word for pair in pairs for word in pair)]


def _of_study(target: str) -> dict[str, str]:
    """What a study of the system takes to make its runs short; of a block, nothing."""
    found = {}
    usual = {option.removeprefix("--"): value for option, value in SHORT.items()} | SHORT_STUDY
    for name, value in usual.items() if target in system_names() else ():
        with suppress(ParameterError):
            load_system(target).study_options("behavioural", None, {name: value})
            found[name] = value
    return found


def _without(words: list[str], options: set[str]) -> Iterator[str]:
    """Words that are none of these options nor their values; `--param name=1` is the option `--name`."""
    pairs = list(pairwise([*words, ""]))
    names = [f"--{value.partition('=')[0]}" if word == "--param" else word for word, value in pairs]
    for k, (word, _) in enumerate(pairs):
        if names[k] not in options and (k == 0 or names[k - 1] not in options):
            yield word


@cache
def _tokens(text: str) -> tuple[Token, ...]:
    """Tokens of a page, for a directive of prose those of its content."""
    return tuple(_parsed(text))


def _parsed(text: str) -> Iterator[Token]:
    for token in MARKDOWN.parse(text):
        directive = DIRECTIVE.match(token.info) if token.type == "fence" else None
        if directive is not None and directive[1] in PROSE_DIRECTIVES:
            yield from _tokens(OPTION_LINES.sub("", token.content))
        else:
            yield token


def _language_and_text(fence: Token) -> tuple[str, str]:
    directive = DIRECTIVE.match(fence.info)
    if directive is None:
        return fence.info.partition(" ")[0], fence.content
    if directive[1] == RUN_DIRECTIVE and not FAILS.search(fence.content):
        return SHELL[0], directive[2]
    if directive[1] in CODE_DIRECTIVES:
        return directive[2], OPTION_LINES.sub("", fence.content)
    return f"{{{directive[1]}}}", fence.content


def _rank(each: object) -> str:
    return hashlib.sha256(f"{_commit()} {each}".encode()).hexdigest()


@cache
def _commit() -> str:
    """Hash of the checkout's commit, empty where there is none."""
    with suppress(FileNotFoundError):  # git
        command = ["git", "rev-parse", "HEAD"]
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False).stdout
    return ""
