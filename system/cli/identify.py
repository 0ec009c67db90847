"""The verb `noctule identify`: the die that a chip is, from its measurements."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from circuits.extraction.coach.chip import die_of, identify_chip
from circuits.extraction.coach.joint import Fit
from circuits.extraction.coach.posterior import posterior_table
from circuits.silicon.process_file import process_of
from system.cli.chip_fit import fitted_rows, measurements
from system.cli.output import print_json, print_line, print_table, working
from system.cli.verbs import Identify
from system.files.writing import check_folder
from system.options.die.file import write_die_file


def identify_command(asked: Identify) -> None:
    """Find how a chip deviates from its process, write the die's file and tell what was found."""
    check_folder(asked.output)
    data, known = measurements(asked.fit, "fit", asked.conditions, asked.only)
    process = process_of(asked.process)
    with working(f"fitting {len(data)} measurements of {asked.fit}"):
        found = identify_chip(data, known, process)
    die = die_of(found.posterior)
    table = posterior_table(found.posterior, found.factors, process.name, known)
    write_die_file(Path(asked.output), die, table)
    unknowns, free = list(_unknowns(found)), list(found.posterior.free())
    document = {
        "process": process.name, "source": asked.fit, "file": asked.output,
        "unknowns": unknowns, "measurements": list(fitted_rows(found)),
        "free": free,
    }  # fmt: skip
    if asked.as_json:
        print_json(document)
        return
    rows = [
        (u["name"], f"{u['mean']:.4g}", f"{u['sd']:.2g}", f"{u['sd_before']:.2g}", u["unit"])
        for u in unknowns
        if u["name"] not in free
    ]
    print_table("unknowns that the measurements fix", ("unknown", "mean:", "sd:", "before:", "unit"), rows)
    print_line(f"{len(free)} of {len(unknowns)} unknowns are free")
    print_line(f"{asked.output}: written, {len(die.edits)} devices deviate; take it by --die {asked.output}")


def _unknowns(found: Fit) -> Iterator[dict[str, Any]]:
    posterior = found.posterior
    for u, mean, sd in zip(posterior.unknowns, posterior.mean, posterior.sd, strict=True):
        yield {
            "name": u.name, "kind": u.kind, "unit": u.unit, "mean": float(mean), "sd": float(sd),
            "mean_before": u.mean, "sd_before": u.sd,
        }  # fmt: skip
