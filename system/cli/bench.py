"""The command `noctule run bench SCRIPT.toml`: a script of the teaching chip's bench, measured."""

from __future__ import annotations

import csv
import io
from functools import partial
from typing import Any

from chips.coach.generator import CHIP
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
from system.options.silicon import SiliconChoice
from system.plot import check_picture, save_picture

_SHOWN = 24  # rows that are printed; CSV and JSON have all


def bench_command(asked: Bench) -> None:
    """Run a script, print what was measured, and write the files that are asked for."""
    check_picture(asked.plot)
    if asked.csv is not None:
        check_folder(asked.csv)
    silicon = _silicon(asked.silicon)
    script = read_script(asked.script, silicon.process.v_dd)
    with progress_bar(f"{CHIP} {script.circuit}") as progress:
        table = run_script(script, silicon, asked.seed, progress)
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
        "set": list(table.set_columns),
        "columns": {name: column.tolist() for name, column in table.columns.items()},
    }


def _print(script: Script, silicon: Silicon, table: Table) -> None:
    rows = list(zip(*(map(_cell, column) for column in table.columns.values()), strict=True))
    title = f"{CHIP} {script.circuit} at {silicon_line(silicon)}"
    print_table(title, tuple(f"{name}:" for name in table.columns), rows[:_SHOWN])
    if len(rows) > _SHOWN:
        print_line(f"and {len(rows) - _SHOWN} rows more; the CSV and JSON have all")
