"""`noctule extract --fit`: a process from the measurements of a chip, through the solver."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from circuits.errors import DataError
from circuits.extraction.coach.chip import Chip, extract_chip
from circuits.extraction.coach.conditions import Condition, read_conditions
from circuits.extraction.coach.joint import Fit
from circuits.extraction.coach.table import Table, read_folder
from circuits.silicon.process_file import format_process, process_of
from system.cli.chip_fit_picture import draw_fit
from system.cli.output import print_json, print_line, print_table, working
from system.cli.verbs import Extract
from system.files.writing import write_text_atomic
from system.plot import save_picture

OWN = "coach"  # the package's own measurements

Data = Mapping[str, tuple[Condition, Table]]


def measurements(
    folder: str, split: str, conditions: str | None, only: tuple[str, ...]
) -> tuple[Data, Mapping[str, Condition]]:
    """Read the measurements of a folder that are asked for, and the conditions of all.

    Parameters
    ----------
    folder
        The folder, or `coach` for the package's own.
    split
        `fit` or `predict`.
    conditions
        File of what was set; the package's own unless given.
    only
        Patterns of names; all unless given.

    Raises
    ------
    DataError
        A file is no measurement, or no name matches.
    """
    known = read_conditions(None if conditions is None else Path(conditions))
    data = read_folder(None if folder == OWN else Path(folder), split, known)
    if only:
        data = {n: d for n, d in data.items() if any(fnmatchcase(n, pattern) for pattern in only)}
    if not data:
        raise DataError(f"{folder}: no measurement is called {', '.join(only)}; name some that are there")
    return data, known


def extract_chip_command(asked: Extract) -> None:
    """Fit a process to a chip's measurements, write its file and tell what it has and how well they fit."""
    folder = asked.fit or OWN
    data, known = measurements(folder, "fit", asked.conditions, asked.only)
    base = replace(process_of(asked.base or "rolls-180"), cards="")
    with working(f"fitting {len(data)} measurements of {folder}"):
        found = extract_chip(data, known, base, Path(asked.output).stem)
    write_text_atomic(asked.output, format_process(found.process, _head(found, folder)))
    save_picture(asked.plot, lambda figure: draw_fit(found.fit, data, figure))
    document = {
        "process": found.process.name, "source": folder, "file": asked.output,
        "numbers": list(_numbers(found)), "measurements": list(fitted_rows(found.fit)),
        "a_vt_Vm": None if found.a_vt is None else found.a_vt[0],
        "a_vt_error_Vm": None if found.a_vt is None else found.a_vt[1],
        "free": list(found.free), "correlation": _correlation(found),
    }  # fmt: skip
    if asked.as_json:
        print_json(document)
    else:
        _print(found, asked.output)


def fitted_rows(fit: Fit) -> Iterator[dict[str, Any]]:
    """How well each column of each measurement fits: points, and the factor of its noise."""
    for (name, column), block in fit.blocks.items():
        yield {
            "measurement": name, "column": column, "points": int(block.residual.size),
            "noise_factor": fit.factors[name, column],
        }  # fmt: skip


def _process_numbers(found: Chip) -> list[int]:
    return [k for k, u in enumerate(found.fit.posterior.unknowns) if u.kind == "process"]


def _numbers(found: Chip) -> Iterator[dict[str, Any]]:
    posterior = found.fit.posterior
    for k in _process_numbers(found):
        name, unit = posterior.names[k], posterior.unknowns[k].unit
        free = name in found.free
        yield {
            "polarity": name[0], "name": name[2:], "unit": unit,
            "value": None if free else float(posterior.mean[k]),
            "error": None if free else float(posterior.sd[k]),
        }  # fmt: skip


def _correlation(found: Chip) -> list[list[float]]:
    own = [k for k in _process_numbers(found) if found.fit.posterior.names[k] not in found.free]
    return [[round(float(x), 4) for x in row[own]] for row in found.fit.posterior.correlation[own]]


def _head(found: Chip, folder: str) -> str:
    """Comment of the file: what was fitted with its standard error, and what is free."""
    lines = [f"Our law fitted to the chip's measurements of {folder} by `noctule extract`."]
    for each in _numbers(found):
        if each["value"] is not None:
            of = "ln " if each["unit"] == "ln" else ""
            unit = f" {each['unit']}" if each["unit"] not in ("ln", "") else ""
            lines.append(
                f"{of}{each['polarity']}.{each['name']}: {each['value']:.5g} +- {each['error']:.2g}{unit}"
            )
    if found.a_vt is not None:
        lines.append(f"pair_a_vt: {1e9 * found.a_vt[0]:.3g} +- {1e9 * found.a_vt[1]:.2g} mV um")
    lines.append(f"Free, as in the base: {', '.join(found.free)}.")
    return "\n".join([*lines, "Lengths in m, all else in SI units."])


def _print(found: Chip, output: str) -> None:
    rows = [
        (each["polarity"], each["name"], f"{each['value']:.5g}", f"{each['error']:.2g}", each["unit"])
        for each in _numbers(found)
        if each["value"] is not None
    ]
    print_table(
        f"{found.process.name}: numbers that are fixed", ("FET", "number", "value:", "error:", "unit"), rows
    )
    if found.a_vt is not None:
        print_line(f"A_VT of a pair: {1e9 * found.a_vt[0]:.3g} +- {1e9 * found.a_vt[1]:.2g} mV um")
    print_line(f"free, as in the base: {', '.join(found.free)}")
    print_line(f"{output}: written; take it by --process {output}")
