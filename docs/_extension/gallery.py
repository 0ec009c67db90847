"""The gallery: a picture of every block, chip, robot and paper figure, with the command that draws it.

The rows come from the registries, so that what is added to one of these is in the gallery. `python -m
_extension.gallery`, in `docs/`, prints them as JSON. A campaign, an experiment of more than two minutes, is
left out by name.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Literal

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from chips.registry import Chip, chip_names, load_chip
from circuits.registry import block_names, load_block
from system.registry import experiment_names, load_experiment, load_system, system_names

Kind = Literal["block", "chip", "robot", "experiment"]

SEED = 1000  # of robots: the first that no parameter was tuned on
# What a plain command does not draw: large arrays are shown in part, a model without a circuit by its robot.
COMMANDS = {
    ("chip", "wavefront-chip"): "show wavefront-chip",
    ("chip", "latency-chip"): "show latency-chip --param paths=2 --param taps=2",
    ("robot", "bug"): f"run bug --brain ideal --seed {SEED}",  # its program draws no neurons
    ("chip", "coach"): "run bench examples/pair.toml --die 7",
    ("chip", "nef-chip"): "run bug --agent bug2 --brain chip --design improved --die 4001 --map bug-field",
}
FASTER = {"bug": 5, "rover": 20, "spiking-bat": 10, "car": 5, "forest": 4, "head": 2}
"""How much faster than the run a robot's film goes, so that it takes some seconds; the others are short."""
HEADINGS: dict[Kind, str] = {
    "block": "Blocks", "chip": "Chips", "robot": "Robots", "experiment": "Figures of papers",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Row:
    """A picture of the gallery.

    Attributes
    ----------
    kind : what is drawn.
    name : its name in its registry.
    summary : what it is, in a line.
    command : the command that draws it, into `picture`.
    picture : name of the file.
    """

    kind: Kind
    name: str
    summary: str
    command: str
    picture: str


def rows() -> tuple[Row, ...]:
    """Rows of the gallery: blocks, chips, robots, experiments, each in the order of its registry."""
    return (*_blocks(), *_chips(), *_robots(), *_experiments())


def left_out() -> tuple[str, ...]:
    """Names of the experiments that take longer than two minutes."""
    return tuple(name for name in experiment_names() if load_experiment(name).counts is not None)


def _row(kind: Kind, name: str, summary: str, command: str, film: str = "") -> Row:
    picture = f"{kind}-{name}.png"
    said = COMMANDS.get((kind, name), command)
    return Row(kind, name, summary, f"noctule {said}{film} --plot {picture}", picture)


def _blocks() -> Iterator[Row]:
    for name in block_names():
        yield _row("block", name, load_block(name).summary, f"simulate {name}")


def _chips() -> Iterator[Row]:
    for name in chip_names():
        chip = load_chip(name)
        if isinstance(chip, Chip) and ("chip", name) not in COMMANDS and name not in system_names():
            raise ValueError(f"{name}: `show` draws no picture of it; name a command in `COMMANDS`")
        yield _row("chip", name, chip.summary, f"show {name}")


def _robots() -> Iterator[Row]:
    for name in system_names():
        system = load_system(name)
        speed = f"x{FASTER[name]}" if name in FASTER else ""
        film = f" --animate robot-{name}.gif --frames 480x360@10{speed}" if system.film else ""
        yield _row("robot", name, system.summary, f"run {name} --seed {SEED}", film=film)


def _experiments() -> Iterator[Row]:
    long = set(left_out())
    for name in experiment_names():
        if name not in long:
            summary = load_experiment(name).summary
            yield _row("experiment", name, summary, f"reproduce {name}")


class GalleryDirective(SphinxDirective):
    """Every row with its summary, its command and what that draws; `kind` names which."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Nodes of the page: for each row what it is, its command, and its picture."""
        kind = self.arguments[0]
        if kind not in HEADINGS:
            raise self.error(f"gallery: {kind}, must be one of {', '.join(HEADINGS)}")
        lines = [line for row in rows() if row.kind == kind for line in markdown(row)]
        if kind == "experiment":
            lines += ["", f"Left out, for each takes longer than two minutes: {', '.join(left_out())}."]
        box = nodes.container(classes=["noctule-gallery"])
        self.state.nested_parse(StringList(lines, source=self.env.docname), 0, box)
        return [box]


def markdown(row: Row) -> list[str]:
    """Lines of a page that show a row."""
    said = f"**{row.name}**: {row.summary}"
    options = [":lines: 0", f":alt: {row.name}, {row.summary}"]
    options += [f":experiment: {row.name}"] if row.kind == "experiment" else []
    return ["", said, "", f"```{{command}} {row.command}", *options, "```"]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("gallery", GalleryDirective)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def print_rows() -> None:
    """Print the rows as JSON, for what draws them without the site."""
    print(json.dumps([asdict(row) for row in rows()], indent=1))  # noqa: T201 - its output


if __name__ == "__main__":
    print_rows()
