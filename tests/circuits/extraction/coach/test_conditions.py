"""The typed table says what the free text says, and refuses what is no condition."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import pytest

from circuits.errors import DataError
from circuits.extraction.coach.conditions import CIRCUITS, DATA, MASTERS, read_conditions
from tests.refusals import file_refusals

with (DATA / "conditions.csv").open(encoding="utf-8", newline="") as stream:
    ROWS = {Path(row["file"]).stem: row for row in csv.DictReader(stream)}
TABLE = read_conditions()


def test_each_measurement_has_one_condition_and_is_there() -> None:
    assert set(TABLE) == set(ROWS)
    for name, condition in TABLE.items():
        row = ROWS[name]
        assert (condition.file, condition.split) == (row["file"], row["split"])
        assert condition.points == int(row["n_points"])
        assert (DATA / condition.file).is_file()
    assert {each.circuit for each in TABLE.values()} == set(CIRCUITS)


@pytest.mark.parametrize("name", sorted(TABLE))
def test_numbers_are_those_of_the_text(name: str) -> None:
    condition, text = TABLE[name], told(name)
    text = text.replace("treat as fine 84-85", "")
    fines = {int(x) for x in re.findall(r"fine (?:unknown [(][0-9]+-)?([0-9]+)", text)}
    stated = {b.fine for b in condition.biases if b.fine is not None}
    assert stated == fines or not condition.biases or None in {b.fine for b in condition.biases}
    assert {b.master for b in condition.biases} <= {master for master in MASTERS if master in text}
    written = [float(x) for x in re.findall(r"[0-9]+(?:[.][0-9]+)?", text)]
    for key, voltage in condition.voltages.items():
        assert any(abs(x - voltage) < 1e-9 for x in written), (key, voltage, text)


def told(name: str) -> str:
    """The free text of a measurement, with that of the one that it repeats."""
    row = ROWS[name]
    text = " ".join(row[key] for key in ("circuit", "swept", "fixed_conditions", "conversion", "quality"))
    again = re.search(r"as in (foi_step_small)", text)
    return f"{text} {told(again.group(1))}" if again else text


def test_every_type_is_that_of_the_text() -> None:
    for name, condition in TABLE.items():
        text = ROWS[name]["fixed_conditions"]
        for bias in condition.biases:
            found = re.search(rf"{bias.name}[ :]+(?:type )?([NP])\b", text)
            if found:
                assert bias.type == found.group(1), (name, bias)


test_what_is_no_condition_is_refused = file_refusals(
    DataError,
    "conditions.toml",
    lambda path: read_conditions(Path(path)),
    [
        ('[[measurement]]\nfile = "fit/x.csv"\nsplit = "fit"\ncircuit = "bumb"\npoints = 3', "circuit bumb"),
        ('[[measurement]]\nfile = "fit/x.csv"\nsplit = "fit"\npoints = 3', "lacks circuit"),
        (
            (
                '[[measurement]]\nfile = "fit/x.csv"\nsplit = "fit"\ncircuit = "nfet"\npoints = 3\n'
                'biases = [{ name = "B", type = "N", master = "30 nA", fine = 256 }]'
            ),
            "B.fine: 256, must be a whole number from 0 to 255",
        ),
        ("[[measurement", "no TOML"),
        ("", "no \\[\\[measurement\\]\\]"),
    ],
    start=r".*conditions\.toml.*",
)
