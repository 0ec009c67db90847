"""The verb `noctule extract`: our law from a foundry's cards, or from measurements."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from circuits.errors import ParameterError
from circuits.extraction.extraction import Extraction, extract_from
from circuits.extraction.fit import Distance
from circuits.extraction.measured import read_points
from circuits.silicon.process import POLARITIES
from circuits.silicon.process_file import format_process, process_of
from netlists.foundry.extract import RANGE, extract
from netlists.foundry.process import read_foundry
from system.cli.chip_fit import extract_chip_command
from system.cli.extract_picture import draw_extraction
from system.cli.output import print_json, print_line, print_table, working
from system.cli.verbs import Extract
from system.files.writing import check_folder, write_text_atomic
from system.notice import say
from system.plot import check_picture, save_picture


def extract_command(asked: Extract) -> None:
    """Fit a process, write its file and tell how far it is off, by size."""
    _check(asked)
    check_picture(asked.plot)
    check_folder(asked.output)
    if asked.fit is not None:
        extract_chip_command(asked)
        return
    source = asked.process or asked.points or ""
    with working(f"fitting our law to {source}"):
        found = _of_foundry(asked.process) if asked.process is not None else _of_points(asked)
    write_text_atomic(asked.output, format_process(found.process, _head(found, source)))
    save_picture(asked.plot, lambda figure: draw_extraction(found, figure))
    document = {
        "process": found.process.name, "source": source, "file": asked.output,
        "from_A": RANGE[0], "to_A": RANGE[1], "distances": [*_distances(found)],
        "numbers": [*_numbers(found)], "notes": list(found.notes),
    }  # fmt: skip
    if asked.as_json:
        print_json(document)
    else:
        _print(found, asked.output)


def _check(asked: Extract) -> None:
    given = [source for source in (asked.process, asked.points, asked.fit) if source is not None]
    if len(given) != 1:
        raise ParameterError(
            "--process: or --points or --fit, one of them; name a foundry's process, a CSV file or a folder"
        )
    if asked.process is not None and asked.base is not None:
        raise ParameterError("--base: only with --points or --fit, a foundry's cards need none; leave it out")
    if asked.fit is None and (asked.only or asked.conditions):
        raise ParameterError("--only, --conditions: only with --fit; leave them out")


def _of_foundry(name: str) -> Extraction:
    return extract(read_foundry(name), f"{name}-ekv")


def _of_points(asked: Extract) -> Extraction:
    points, dropped = read_points(Path(asked.points or ""))
    if dropped:
        say(f"{asked.points}: {dropped} rows left out, their current is not above zero")
    base = process_of(asked.base or "rolls-180")
    return extract_from(points, replace(base, name=Path(asked.output).stem, cards=""))


def _head(found: Extraction, source: str) -> str:
    """Comment of the file: where the numbers come from, and how good they are."""
    lines = [f"Our law fitted to the drain currents of {source} by `noctule extract`."]
    for polarity in found.fitted:
        away, role = found.judged(polarity), "not fitted" if found.held_out else "fitted"
        lines.append(
            f"{polarity}FETs, sizes that were {role}: off by {100 * away.median:.1f} % in the median,"
            f" {100 * away.worst:+.0f} % at the worst."
        )
        free = found.fitted[polarity].free
        lines += [f"{polarity}FETs, free, as in the base: {', '.join(free)}."] if free else []
    return "\n".join([*lines, *found.notes, "Lengths in m, all else in SI units."])


def _distances(found: Extraction) -> Iterator[dict[str, Any]]:
    um = 1e6
    for polarity in found.fitted:
        for role, size, away in found.distances(polarity):
            yield {
                "polarity": polarity, "role": role, "width_um": um * size[0], "length_um": um * size[1],
                **_distance(away),
            }  # fmt: skip
        yield {"polarity": polarity, "role": "judged", "width_um": None, "length_um": None,
               **_distance(found.judged(polarity))}  # fmt: skip


def _distance(away: Distance) -> dict[str, Any]:
    return {
        "points": away.points, "median": away.median, "worst": away.worst,
        "worst_temperature_C": away.where["temperature_c"], "worst_drain_V": away.where["v_d"],
        "worst_gate_V": away.where["v_g"], "worst_source_V": away.where["v_s"],
        "worst_A": away.where["current"],
    }  # fmt: skip


def _numbers(found: Extraction) -> Iterator[dict[str, Any]]:
    for polarity, fitted in found.fitted.items():
        for name, value, error in zip(fitted.names, fitted.values, fitted.errors, strict=True):
            yield {"polarity": polarity, "name": name, "value": float(value), "error": float(error)}
        for name in fitted.free:
            yield {"polarity": polarity, "name": name, "value": None, "error": None}


def _print(found: Extraction, output: str) -> None:
    header = ("device", "size (um)", "sizes", "median:", "worst:", "where", "drain:")
    rows = []
    for each in _distances(found):
        size = "all" if each["width_um"] is None else f"{each['width_um']:.3g} by {each['length_um']:.3g}"
        rows.append((
            f"{each['polarity']}FET", size, each["role"], f"{100 * each['median']:.1f} %",
            f"{100 * each['worst']:+.0f} %",
            f"{each['worst_A']:.2g} A at {each['worst_temperature_C']:g} degC",
            f"{each['worst_drain_V']:.3g} V",
        ))  # fmt: skip
    print_table(f"{found.process.name}: drain current off, {RANGE[0]:g} to {RANGE[1]:g} A", header, rows)
    for polarity in POLARITIES:
        for name in found.fitted[polarity].free if polarity in found.fitted else ():
            print_line(f"{polarity}FET {name}: free, the points do not fix it; as in the base")
    for note in found.notes:
        print_line(note)
    print_line(f"{output}: written; take it by --process {output}")
