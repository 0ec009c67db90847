"""The command `noctule run bench SCRIPT.toml`: a script of the teaching chip's bench, measured."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from chips.coach.generator import CHIP
from chips.coach.identified import Found
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180
from circuits.silicon.process_file import process_under
from circuits.silicon.silicon import Silicon
from circuits.units import parse_quantity
from system.bench.picture import draw_table
from system.bench.run import Table, run_script
from system.bench.script import Script, read_script
from system.cli.bench_verb import Bench
from system.cli.output import print_json, print_line, print_table, progress_bar
from system.files.writing import check_folder, write_text_atomic
from system.options.block import describe_silicon, read_die, silicon_line
from system.options.die.file import identified_file
from system.options.silicon import SiliconChoice
from system.plot import check_picture, save_picture

_SHOWN = 24  # rows that are printed; CSV and JSON have all


def bench_command(asked: Bench) -> None:
    """Run a script, print what was measured, and write the files that are asked for."""
    check_picture(asked.plot)
    if asked.csv is not None:
        check_folder(asked.csv)
    silicon, identified = _silicon(asked.silicon), _identified(asked)
    script = read_script(asked.script, silicon.process.v_dd)
    with progress_bar(f"{CHIP} {script.circuit}") as progress:
        table = run_script(script, silicon, asked.seed, progress, identified)
    if asked.csv is not None:
        write_text_atomic(asked.csv, _csv(table))
    title = f"{CHIP} {script.circuit}, {silicon_line(silicon)}".replace("degC", "°C")
    save_picture(asked.plot, partial(draw_table, table, title))
    if asked.as_json:
        print_json(_document(script, silicon, asked.seed, table))
    else:
        _print(script, silicon, table)


def _silicon(asked: SiliconChoice) -> Silicon:
    celsius = parse_quantity(asked.celsius, "degC", "temperature")
    return Silicon(process_under(ROLLS_180, asked.process, asked.law), celsius, read_die(asked))


def _identified(asked: Bench) -> Path | None:
    """The file of the identified die whose board is taken; None of a nominal board."""
    if asked.board == "nominal":
        return None
    found = None if asked.die is None else identified_file(str(asked.die))
    if found is None and asked.board == "identified":
        die = "a nominal die" if asked.die is None else f"die {asked.die}"
        raise ParameterError(f"--board: identified, {die} was not; give the --die of noctule identify")
    return found


def _csv(table: Table) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(table.columns)
    writer.writerows(zip(*(map(_cell, column) for column in table.columns.values()), strict=True))
    return text.getvalue()


def _cell(value: float) -> str:
    return f"{value:.9g}"


def _document(script: Script, silicon: Silicon, seed: int, table: Table) -> dict[str, Any]:
    described = describe_silicon(silicon)
    described.pop("at")
    return {
        "chip": CHIP,
        "circuit": script.circuit,
        **described,
        "seed": seed,
        "board": None if table.found is None else _board(table.found),
        "set": list(table.set_columns),
        "columns": {name: column.tolist() for name, column in table.columns.items()},
    }


def _board(found: Found) -> dict[str, Any]:
    return {
        "file": found.file,
        "temperature_C": found.temperature_c,
        "identified": list(found.identified),
        "nominal": list(found.nominal),
    }


def _print(script: Script, silicon: Silicon, table: Table) -> None:
    rows = list(zip(*(map(_cell, column) for column in table.columns.values()), strict=True))
    title = f"{CHIP} {script.circuit} at {silicon_line(silicon)}"
    print_table(title, tuple(f"{name}:" for name in table.columns), rows[:_SHOWN])
    if len(rows) > _SHOWN:
        print_line(f"and {len(rows) - _SHOWN} rows more; the CSV and JSON have all")
    if table.found is None:
        print_line("board: nominal")
    else:
        found = table.found
        print_line(f"board: as {found.file} was identified at {found.temperature_c:.1f} degC")
        print_line(f"identified: {_listed(found.identified)}")
        print_line(f"nominal: {_listed(found.nominal)}")


def _listed(names: Sequence[str]) -> str:
    return ", ".join(names) or "nothing"
