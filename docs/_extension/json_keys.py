"""The directives `document-keys`, `run-keys`, `scenario-keys` and `every-run-keys`: keys of JSON documents.

They come from the code, which says what each key is (`system.meaning`). `document-keys COMMAND` has those of
a command, `run-keys SYSTEM` those of a system's own, `scenario-keys SYSTEM` those of its options, and
`every-run-keys` those of every run. A key without words fails the build.

    ```{document-keys} op
    ```
"""

from __future__ import annotations

from collections.abc import Mapping

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from _extension.table import table
from system.cli.keys.documents import DOCUMENTS, EVERY_RUN, scenario_keys
from system.meaning import SUMMARY, Meaning
from system.registry import load_system
from system.system import ENTRIES

HEAD = ("key", "type", "unit", "what it is")
PARTS = (("[]", "list of {}"), ("{}", "object of {} by name"), ("?", "{} or `null`"))


class KeysDirective(SphinxDirective):
    """Keys with their types, units and words."""

    required_arguments = 0
    has_content = False

    def keys(self) -> Mapping[str, Meaning]:
        """What the table has."""
        raise NotImplementedError

    def run(self) -> list[nodes.Node]:
        """Nodes of the page."""
        found = self.keys()
        missing = [key for key, each in found.items() if not each.words]
        if missing:
            raise self.error(f"{self.name}: {', '.join(missing)}: nothing says what it is")
        return [table(HEAD, [row(key, each) for key, each in found.items()])]


class DocumentKeysDirective(KeysDirective):
    """Keys of a command's document."""

    required_arguments = 1
    final_argument_whitespace = True

    def keys(self) -> Mapping[str, Meaning]:
        """Those of the command."""
        return DOCUMENTS[self.arguments[0]]


class RunKeysDirective(KeysDirective):
    """Keys that a system adds to those of every run."""

    required_arguments = 1

    def keys(self) -> Mapping[str, Meaning]:
        """Those of the system's own, its numbers after the rest."""
        own = load_system(self.arguments[0]).meanings
        return dict(sorted(own.items(), key=lambda item: item[0].startswith(f"{SUMMARY}.")))


class ScenarioKeysDirective(KeysDirective):
    """Keys of a system's scenario."""

    required_arguments = 1

    def keys(self) -> Mapping[str, Meaning]:
        """Those of its options."""
        return scenario_keys(load_system(self.arguments[0]))


class EveryRunKeysDirective(KeysDirective):
    """Keys that every run's document has."""

    def keys(self) -> Mapping[str, Meaning]:
        """Those of the document, and those with which its summary begins."""
        return {**EVERY_RUN, **{f"{SUMMARY}.{key}": each for key, each in ENTRIES.items()}}


def row(key: str, each: Meaning) -> tuple[str, str, str, str]:
    """Cells of a key."""
    words = each.words[:1].upper() + each.words[1:]
    return f"`{key}`", kind_in_words(each.kind), f"`{each.unit}`" if each.unit else "", words


def kind_in_words(kind: str) -> str:
    """A type as a reader has it: `number?[]` is a list of number or null."""
    if "|" in kind:
        return " or ".join(kind_in_words(each) for each in kind.split("|"))
    for mark, words in PARTS:
        if kind.endswith(mark):
            inner = kind_in_words(kind.removesuffix(mark))
            return words.format(f"({inner})" if " " in inner else inner)
    return kind


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directives."""
    app.add_directive("document-keys", DocumentKeysDirective)
    app.add_directive("run-keys", RunKeysDirective)
    app.add_directive("scenario-keys", ScenarioKeysDirective)
    app.add_directive("every-run-keys", EveryRunKeysDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
