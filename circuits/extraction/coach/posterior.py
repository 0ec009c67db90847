"""What measurements left of a die, as the table `posterior` of its file.

    [[posterior.unknown]]
    name = "differential_pair.m1.v_t0"
    unit = "V"
    kind = "device"
    before = [0.0, 4.9e-3]         # mean and standard deviation before the fit
    after = [2.9e-3, 3.4e-3]       # and after it

    [[posterior.converter]]
    channel = 0                    # and how it was calibrated

    [posterior]
    process = "coach-180"          # that was fitted about
    correlation = [[1.0], [0.2, 1.0]]          # lower triangle, a row an unknown
    noise = { "ndp_run1 n1_counts" = 1.2 }     # factor of the noise of readings that were fitted

Commands take the die's deviations from `deviation`; `noctule predict` takes all of this, and so does the
bench of the chip.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from circuits.errors import DataError
from circuits.extraction.coach.bench import process_unknowns
from circuits.extraction.coach.conditions import Condition
from circuits.extraction.coach.readings.converter import calibrations
from circuits.extraction.coach.unknown import Kind, Posterior, Unknown
from circuits.silicon.process import Process
from circuits.silicon.toml_file import read_toml

_DIGITS = 10  # of a mean or a standard deviation; correlations have five
_SAME = 1e-9  # of a number of a process


class UnknownRow(msgspec.Struct, forbid_unknown_fields=True):
    """An unknown before and after the fit.

    Attributes
    ----------
    name, unit, kind : str
        Its name, unit, and whether it is of the process, a device or the bench.
    before, after : list of float
        Mean and standard deviation, in its unit.
    """

    name: str
    unit: str
    kind: Kind
    before: tuple[float, float]
    after: tuple[float, float]


class ConverterRow(msgspec.Struct, forbid_unknown_fields=True):
    """How a converter was calibrated, whose charge is in the scale of the nominal current then.

    Attributes
    ----------
    channel : int
        Its number.
    circuit, bias : str
        The circuit whose current it took, as NDP, and the line that was swept, as `NDP_VB_N`.
    master : float
        The coarse current of that line, A.
    fine : int
        A fine code in the middle of the sweep.
    w : float
        The nominal current over `master fine / 256`.
    counts : float
        Counts an event.
    voltages : list of float
        Of both inputs, V.
    """

    channel: int
    circuit: str
    bias: str
    master: float
    fine: int
    w: float
    counts: float
    voltages: tuple[float, float]


class PosteriorTable(msgspec.Struct, forbid_unknown_fields=True):
    """What measurements left of a die.

    Attributes
    ----------
    unknown : list
        The unknowns.
    correlation : list of list of float
        Lower triangle of the correlation of all.
    noise : dict
        Factor of the readings' noise, by measurement and column.
    process : str
        Name of the process about which its numbers were fitted.
    converter : list
        How converters were calibrated.
    """

    unknown: list[UnknownRow]
    correlation: list[list[float]]
    noise: dict[str, float] = {}
    process: str = ""
    converter: list[ConverterRow] = []


def posterior_table(
    posterior: Posterior,
    noise: Mapping[tuple[str, str], float],
    process: str = "",
    conditions: Mapping[str, Condition] | None = None,
) -> PosteriorTable:
    """The table of a posterior.

    Parameters
    ----------
    posterior
        What is known after a fit.
    noise
        Factors of the noise, by measurement and column.
    process
        Name of the process about which its numbers were fitted.
    conditions
        What was set at all measurements, calibrations of converters among them.
    """
    rows = [
        UnknownRow(u.name, u.unit, u.kind, (u.mean, u.sd), (_short(mean), _short(sd)))
        for u, mean, sd in zip(posterior.unknowns, posterior.mean, posterior.sd, strict=True)
    ]
    correlation = [
        [round(float(x), 5) + 0.0 for x in row[: k + 1]] for k, row in enumerate(posterior.correlation)
    ]
    factors = {" ".join(key): round(f, 4) for key, f in noise.items()}
    return PosteriorTable(rows, correlation, factors, process, _converters(calibrations(conditions or {})))


def _converters(calibrated: Iterable[Condition]) -> list[ConverterRow]:
    """How each channel was calibrated, by the first condition that says so in full."""
    found: dict[int, ConverterRow] = {}
    for each in calibrated:
        s, channel = each.settings, int(each.settings["channel"])
        if "block" not in s or not {"v1", "v2"} <= set(each.voltages):
            continue
        row = ConverterRow(
            channel, s["block"], s["bias"], s["master"], int(s["most_code"]) // 2, s["w"],
            s["counts_per_event"], (each.voltages["v1"], each.voltages["v2"]),
        )  # fmt: skip
        found.setdefault(channel, row)
    return [found[channel] for channel in sorted(found)]


def read_table(path: Path) -> PosteriorTable:
    """Read what measurements left of the die that a file states.

    Raises `DataError` for a file that cannot be read, or has no posterior.
    """
    given = read_toml(path, "a die of noctule identify").get("posterior")
    if given is None:
        raise DataError(f"{path}: no posterior, must be a die of noctule identify; identify it first")
    try:
        return msgspec.convert(given, PosteriorTable)
    except msgspec.ValidationError as error:
        raise DataError(f"{path}: posterior: {error}; identify the die again") from None


def check_process(posterior: Posterior, process: Process, told: str, where: str, remedy: str) -> None:
    """Refuse a process that is another than the one about which a posterior's numbers were fitted.

    Parameters
    ----------
    posterior
        The posterior.
    process
        The process.
    told
        Name of the process that was fitted about; empty where it is not known.
    where
        File of the posterior.
    remedy
        What one can do instead of giving the other process.

    Raises
    ------
    DataError
        A number of the process that was fitted is another.
    """
    before = {u.name: u for u in posterior.unknowns}
    for now in process_unknowns(process):
        then = before.get(now.name)
        if then is not None and abs(now.mean - then.mean) > _SAME * max(abs(then.mean), then.sd):
            name = f"ln {now.name}" if then.unit == "ln" else now.name
            unit = f" {then.unit}" if then.unit not in ("", "ln") else ""
            raise DataError(
                f"{where}: identified on {told or 'a process'} with {name} {then.mean:.6g}{unit},"
                f" {process.name} has {now.mean:.6g}{unit}; give the process and law that it was identified"
                f" on, or {remedy}"
            )


def posterior_of(table: PosteriorTable, where: str) -> tuple[Posterior, dict[tuple[str, str], float]]:
    """The posterior of a table, and factors of the noise.

    Parameters
    ----------
    table
        The table.
    where
        Its file.

    Raises
    ------
    DataError
        The correlation is no lower triangle of the unknowns.
    """
    count = len(table.unknown)
    if [len(row) for row in table.correlation] != list(range(1, count + 1)):
        raise DataError(f"{where}: posterior.correlation: must be a lower triangle of {count} rows")
    correlation = np.zeros((count, count))
    for k, row in enumerate(table.correlation):
        correlation[k, : k + 1] = row
    correlation += np.tril(correlation, -1).T
    mean, sd = np.array([row.after for row in table.unknown]).T
    unknowns = tuple(Unknown(row.name, *row.before, row.unit, row.kind) for row in table.unknown)
    noise: dict[tuple[str, str], float] = {}
    for key, factor in table.noise.items():
        name, _, column = key.partition(" ")
        noise[name, column] = factor
    return Posterior(unknowns, mean, correlation * np.outer(sd, sd)), noise


def _short(value: Any) -> float:
    return float(f"{float(value):.{_DIGITS}g}")
