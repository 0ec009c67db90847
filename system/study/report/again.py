"""A sample in a report: the command that measures it again, and the page that this makes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from system.study.report.page import Code, Link

Options = Sequence[tuple[str, str]]
Replay = Callable[[str, Options], str]  # folder, options: a command
AGAIN_SAID = {
    False: "the command measures it again",
    True: "the command measures it again and makes the page to which the die's number leads",
}
"""What a report says of its commands, by whether a run has a page."""
_NAMING = ("die", "corner", "temperature", "trial")  # options that tell a sample from others


def again_with_page(
    folder: Path, beside: Path, replay: Replay, options: Options, *, filmed: bool
) -> tuple[str | Link, Code]:
    """Give a sample's die, which leads to its page where it can have one, and the command that makes that.

    Parameters
    ----------
    folder : folder of the study, as the command is to name it.
    beside : the same folder, from that of the report.
    replay : gives the command, from the folder and the options.
    options : those that name the sample.
    filmed : whether a run has a page.
    """
    die = dict(options)["die"]
    if not filmed:
        return die, Code(replay(str(folder), options))
    where = [text.replace(".", "_") for name, text in options if name in _NAMING]
    page = f"die-{'-'.join(where)}.html"
    return Link(die, str(beside / page)), Code(replay(str(folder), [*options, ("view", str(folder / page))]))
