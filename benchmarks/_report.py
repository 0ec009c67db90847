"""What the benchmarks share: a measured figure with its claim, the options, and how figures are printed."""

from __future__ import annotations

import json
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass


@dataclass(frozen=True, slots=True)
class Row:
    """One measured figure beside its peer's, and what is claimed of their ratio.

    ours, peer: in the unit that the row's script says. peer, ratio: None where nothing is compared.
    least, most: what is claimed of `ratio`, both included; as they are by default, nothing is claimed.
    """

    name: str
    ours: float
    peer: float | None
    ratio: float | None
    accuracy: str
    cores: int = 1
    least: float = 0.0
    most: float = float("inf")

    @property
    def claimed(self) -> bool:
        """Whether anything is claimed."""
        return self.least > 0.0 or self.most < float("inf")

    @property
    def holds(self) -> bool:
        """Whether the claim holds; a figure that is missing or not a number misses it."""
        return not self.claimed or (self.ratio is not None and self.least <= self.ratio <= self.most)

    @property
    def claim(self) -> str:
        """The claim in words, empty where there is none."""
        ends = [f"at least {self.least:g}"] if self.least > 0.0 else []
        ends += [f"at most {self.most:g}"] if self.most < float("inf") else []
        return " and ".join(ends)


def parser_of(description: str | None, quick: str) -> ArgumentParser:
    """Options that every script has; description: its docstring, quick: what `--quick` leaves out."""
    parser = ArgumentParser(description=description)
    parser.add_argument("--json", action="store_true", help="rows as JSON")
    parser.add_argument("--quick", action="store_true", help=quick)
    return parser


def best_of(work: Callable[[], object]) -> float:
    """CPU time of some work, s, least of three."""
    taken = []
    for _ in range(3):
        start = time.process_time()
        work()
        taken.append(time.process_time() - start)
    return min(taken)


def ratio_alone(row: Row) -> str:
    """The ratio, whose unit the row's name says, or a dash."""
    return f"{'-' if row.ratio is None else f'{row.ratio:.4g}':>8}"


def report(rows: Iterable[Row], options: Namespace, figures: Callable[[Row], str] = ratio_alone) -> int:
    """Print the rows as `options.json` says, as lines with what `figures` says of each; the exit status.

    Returns
    -------
    int
        1 where a claim is missed, else 0.
    """
    rows = list(rows)
    if options.json:
        print(json.dumps([as_json(row) for row in rows], indent=2))
    else:
        width = max((len(row.name) for row in rows), default=0)
        for row in rows:
            claim = f", claim {row.claim}" if row.claim else ""
            print(f"{row.name:{width}} {figures(row)}{claim}; {row.accuracy}")
    return int(not all(row.holds for row in rows))


def as_json(row: Row) -> dict[str, object]:
    """The row's fields; without an end of a claim that claims nothing."""
    ends = {"least": row.least > 0.0, "most": row.most < float("inf")}
    return {name: value for name, value in asdict(row).items() if ends.get(name, True)}
