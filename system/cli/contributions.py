"""Output of `noctule montecarlo --contributions`: shares of the variance as tables, JSON and picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from circuits.errors import ParameterError
from system.cli.output import print_line, print_table
from system.plot import SUFFIXES, check_picture, save_picture
from system.study.search.breakdown import BY, Breakdown, share_rows
from system.study.statistics.contribution import grouped, pareto

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LISTED = 12  # devices of the printed table; the smaller ones are one row


def check_pareto(path: str | None, metric: str | None) -> None:
    """Check before the work that the Pareto picture can be drawn.

    Raises `ParameterError` where no metric is named, and for a file name that is not of a picture.
    """
    if path is None:
        return
    if metric is None:
        raise ParameterError("--pareto: of which metric, must come with --contributions METRIC")
    if Path(path).suffix.removeprefix(".").lower() not in SUFFIXES:
        raise ParameterError(f"--pareto: {path}, must end with .{', .'.join(SUFFIXES)}; choose one of them")
    check_picture(path)


def save_pareto(path: str, found: Sequence[Breakdown]) -> None:
    """Draw the shares of the devices into the file `path`, with a panel for each condition."""

    def draw(figure: Figure) -> None:
        figure.set_size_inches(7.0, 3.8 * max(len(found), 1))
        for each, ax in zip(found, figure.subplots(len(found), 1, squeeze=False)[:, 0], strict=True):
            pareto(grouped(each.found, BY["device"]), ax)
            ax.set_title(f"{each.metric} at {each.where}", fontsize=9)

    save_picture(path, draw)


def print_breakdown(one: Breakdown) -> None:
    """Print tables of the shares by device, parameter, block and process; each sums to 100.0 %."""
    found = one.found
    what = f"ln {one.metric}" if one.logarithm else one.metric
    left = one.samples - found.samples
    print_line(
        f"contributions to the variance of {what} at {one.where}: {found.model}, R^2 {found.r2:.3f}, "
        f"{found.samples} samples" + (f", {left} not defined and left out" if left else "")
    )
    if found.check is not None:
        print_line(f"largest difference to a linear regression: {100.0 * found.check:.1f} points of a share")
    for note in (*one.notes, found.note):
        if note:
            print_line(note)
    for by, key in BY.items():
        rows = share_rows(grouped(found, key), LISTED)
        print_table(f"by {by}", (by, "share:"), rows)


def breakdown_document(one: Breakdown) -> dict[str, Any]:
    """Give contributions as members of a JSON document.

    Shares are fractions that sum to 1 with the one called `unexplained`.
    """
    found = one.found
    return {
        "metric": one.metric,
        "corner": one.corner,
        "temperatures_C": one.temperatures_c,
        "logarithm": one.logarithm,
        "model": found.model,
        "samples": one.samples,
        "defined": found.samples,
        "r2": found.r2,
        "unexplained": found.unexplained,
        "check": found.check,
        "notes": [note for note in (*one.notes, found.note) if note],
        **{f"by_{by}": {s.name: s.value for s in grouped(found, key)} for by, key in BY.items()},
    }
