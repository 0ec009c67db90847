"""The verb `noctule calibrate CHIP`: codes of a chip on a die, found as on a bench."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable
from pathlib import Path

import msgspec

from chips.codes import Codes, Measured
from circuits.errors import ParameterError
from circuits.silicon.process_file import process_under
from circuits.silicon.silicon import Silicon
from circuits.units import format_quantity, parse_quantity
from system.cli.exit_status import DONE, NO
from system.cli.mend import require_checkout
from system.cli.output import print_json, print_line, print_table, working
from system.cli.verbs import Calibrate
from system.codes.file import write_codes
from system.codes.find import calibrated_anew, codes_found, kept_anew, shipped_file
from system.files.writing import check_folder
from system.options.block import describe_silicon, read_die, silicon_line
from system.options.die.edited import check_drawn
from system.registry import load_calibration


def calibrate_command(asked: Calibrate) -> int:
    """Calibrate a chip on a die, write its codes, and print what the bench measured.

    Returns the exit status: 1 where the chip could not be calibrated.
    """
    calibration = load_calibration(asked.chip)
    silicon = Silicon(
        process_under(calibration.process, asked.silicon.process, asked.silicon.law),
        parse_quantity(asked.silicon.celsius, "degC", "temperature"),
        read_die(asked.silicon),
    )
    path = _path(asked, silicon)
    start = time.perf_counter()
    with working(f"calibrate {asked.chip}"):
        anew = kept_anew if asked.anew else codes_found
        made = calibrated_anew if asked.update_package else anew
        codes = made(asked.chip, silicon, asked.bias_kind)
    seconds = time.perf_counter() - start
    check_drawn(silicon.die)
    if path is not None:
        write_codes(path, codes)
    if asked.as_json:
        print_json(_document(codes, silicon, path, seconds))
    else:
        _print(codes, silicon, path, seconds)
    return NO if codes.failed else DONE


def _path(asked: Calibrate, silicon: Silicon) -> Path | None:
    """Where the codes go, which is found out to be possible before a calibration; None for nowhere."""
    if not asked.update_package:
        if asked.output is not None:
            check_folder(asked.output)
        return None if asked.output is None else Path(asked.output)
    if asked.output is not None:
        raise ParameterError(
            f"--update-package: writes the package's codes, not {asked.output}; leave one out"
        )
    path = shipped_file(asked.chip, silicon)
    require_checkout(path)
    return path


def _document(codes: Codes, silicon: Silicon, path: Path | None, seconds: float) -> dict[str, object]:
    document = msgspec.to_builtins(codes)
    del document["key"], document["calibrated_c"], document["law"]
    document["measured"] = [{n: _number(v) for n, v in each.items()} for each in document["measured"]]
    return {
        **document,
        "bias_kind": codes.key.bias_kind,
        "silicon": describe_silicon(silicon),
        "file": None if path is None else str(path),
        "seconds": seconds,
    }


def _number(value: object) -> object:
    """A number as JSON has it: null for what could not be measured."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _print(codes: Codes, silicon: Silicon, path: Path | None, seconds: float) -> None:
    title = f"{codes.chip}, {silicon_line(silicon)}, biases {codes.key.bias_kind}"
    rows = [_row(name, each) for name, each in _families(codes.measured).items()]
    print_table(title, ["measured", "of them", "worst before:", "worst after:"], rows)
    for name, numbers in codes.off.items():
        if numbers:
            print_line(f"switched off: {name} {', '.join(map(str, numbers))}")
    for sentence in codes.unmended:
        print_line(f"stays: {sentence}")
    if codes.failed:
        print_line(f"failed: {codes.failed}")
    print_line(
        f"{sum(map(len, codes.biases.values()))} codes, {format_quantity(codes.bench_s, 's')} on the bench,"
        f" found in {seconds:.1f} s"
    )
    if path is not None:
        print_line(f"written to {path}")


def _families(measured: Iterable[Measured]) -> dict[str, list[Measured]]:
    """What was measured of the elements of an array together."""
    found: dict[str, list[Measured]] = {}
    for each in measured:
        found.setdefault(each.name.partition("[")[0], []).append(each)
    return found


def _row(name: str, family: list[Measured]) -> list[str]:
    return [name, str(len(family)), _worst(family, "before"), _worst(family, "after")]


def _worst(family: list[Measured], when: str) -> str:
    """The value that is farthest from what is wanted, in its unit, and what is wanted."""

    def off(each: Measured) -> float:
        value: float = getattr(each, when)
        return abs(value - each.wanted) if math.isfinite(value) else math.inf

    worst = max(family, key=off)
    value, unit = getattr(worst, when), worst.unit
    told = format_quantity(value, unit) if math.isfinite(value) else "nothing"
    return f"{told} for {format_quantity(worst.wanted, unit)}"
