"""Commands and code blocks of the documents, found in their text, and the short form in which they are run.

A command is a line of a block, or `code` in a sentence, that begins with `noctule`, `make` or `.venv/bin/`.
Words in capitals (`BLOCK`, `--bias-set NAME`) stand for the reader's own and make it a fragment.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from circuits.errors import ParameterError
from system.registry import load_experiment, load_system, system_names

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
DOCUMENTS = (
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted((ROOT / "docs").glob("evidence/*.md")),
    ROOT / "docs/reference/commands.md",
)

BLOCK = re.compile(r"^```(\w*)\n(.*?)^```", re.DOTALL | re.MULTILINE)
INDENTED = re.compile(r"(?<=\n\n)(?: {4}.*\n)+")
CODE = re.compile(r"`([^`]+)`")
COMMAND = re.compile(r"(?:noctule|make) |\.venv/bin/")
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
FEWEST_RUNS = {"trials": "4"}  # of a campaign whose count cannot be 1
# Starting processes takes longer than what is left to do, and contributions are hundreds of runs whatever the
# samples: `system/study/search/test_breakdown.py` carries out studies with them.
DROPPED = ("--workers", "--contributions")
# What no option makes short enough; `system/cli/test_show_rolls.py` shows a chip.
LONG = (("reproduce",), ("characterise",), ("show", "rolls"))
LETTERS = {"-n": "--samples", "-o": "--output"}
WRITTEN = ("--output", "--plot", "--csv", "--raw", "--events", "--animate", "--pareto")


@dataclass(frozen=True, slots=True)
class Command:
    """Words of a command as a document has it, and its comment."""

    words: tuple[str, ...]
    comment: str = ""

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
    """Language and text of fenced blocks, in order."""
    return BLOCK.findall(text)


def indented(text: str) -> list[str]:
    """Lines of indented blocks."""
    found = INDENTED.findall(BLOCK.sub("", text))
    return [line.strip() for block in found for line in block.splitlines()]


def codes(text: str) -> list[str]:
    """Code in sentences, with spaces for its line breaks."""
    found = CODE.findall(INDENTED.sub("\n", BLOCK.sub("", text)))
    return [" ".join(code.split()) for code in found]


def commands(text: str) -> list[Command]:
    """Commands of a text, each once: those of blocks in order, then those in sentences."""
    shell = [
        line.strip() for language, block in fenced(text) if language == "sh" for line in block.splitlines()
    ]
    lines = [line for line in (*indented(text), *shell, *codes(text)) if COMMAND.match(line)]
    found = {}
    for line in lines:
        words, _, comment = line.partition("  # ")
        command = Command(tuple(shlex.split(words, comments=True)), comment)
        found.setdefault(command.words, command)
    return list(found.values())


def chains(found: Iterable[Command]) -> list[tuple[Command, ...]]:
    """Commands in order, those together of which one reads what another writes."""
    together: list[list[Command]] = []
    for command in found:
        makers = [c for c in together if any(set(each.written) & set(command.words) for each in c)]
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
    left_out = {*short, *DROPPED, *(f"--{name}" for name in params)}
    pairs = [*short.items(), *(("--param", f"{name}={value}") for name, value in params.items())]
    return [*_without(words, left_out), *(word for pair in pairs for word in pair)]


def _of_study(target: str) -> dict[str, str]:
    """What a study of the system takes to make its runs short; of a block, nothing."""
    found = {}
    for option, value in SHORT.items() if target in system_names() else ():
        name = option.removeprefix("--")
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
