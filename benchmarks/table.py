"""Runs benchmarks and writes one table of their rows, as JSON and as Markdown, beside that of before.

    table.py                       every benchmark, hours
    table.py dvs rover --quick     some of them, in their short form
    table.py --compare FILE        does not run: what the last table has, against a kept one

Each benchmark is a process of its own, one after the other. `--output FOLDER` (`benchmarks/results`) gets
`table.json` and `table.md`, in which what was not measured this time stays, and `history.jsonl` a line. A row
is worse where its ratio has fallen by more than `WORSE` and the claim is a least, or has risen by more and
the claim is a most; rows without such a claim have no better side, and are counted. The table of before is
that of `--compare`, else the one in the folder. What another machine measured is told, and not judged.

Returns 1 where a benchmark ended without rows, a claim is missed, or a row is worse.
"""

from __future__ import annotations

import json
import os
import platform
import resource
import subprocess
import sys
import time
from argparse import ArgumentParser, Namespace
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from _report import Row, as_json
from netlists.ngspice import library

HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results"
WORSE = 0.2  # of a ratio
QUIET = 0.5  # of a core, load over the minute before; ours
PEERS = ("numpy", "numba", "scipy", "networkx", "nengo", "gymnasium")


@dataclass(frozen=True, slots=True)
class Measured:
    """What one benchmark found.

    cpu, wall : s of its process, kernels that it compiled included.
    load : of the machine in the minute before, in cores.
    """

    status: int
    quick: bool
    date: str
    version: str
    machine: str
    load: float
    cpu: float
    wall: float
    rows: tuple[Row, ...] = field(default=())

    @property
    def quiet(self) -> bool:
        """Whether nothing else ran."""
        return self.load < QUIET


Table = dict[str, Measured]


@dataclass(frozen=True, slots=True)
class Change:
    """A row before and now; share : by which its ratio is worse, below 0 where it is better."""

    script: str
    row: str
    before: float
    now: float
    share: float


def names(folder: Path = HERE) -> list[str]:
    """Benchmarks of a folder by name; those that begin with `_` are parts of others."""
    found = (path.stem for path in folder.glob("*.py"))
    return sorted(name for name in found if not name.startswith("_") and name != Path(__file__).stem)


def machine() -> str:
    """Processor and number of its cores."""
    told = Path("/proc/cpuinfo")
    lines = told.read_text(encoding="utf-8").splitlines() if told.exists() else []
    model = next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), "")
    return f"{model or platform.processor() or platform.machine()}, {os.cpu_count()} cores"


def versions() -> str:
    """Versions of Python, of ngspice and of the libraries that rows are compared with."""
    return ", ".join([f"Python {platform.python_version()}", f"ngspice {library.version()}", *_installed()])


def _installed() -> Iterator[str]:
    for name in PEERS:
        try:
            yield f"{name} {version(name)}"
        except PackageNotFoundError:
            yield f"no {name}"


def measure(path: Path, flags: Sequence[str]) -> Measured:
    """Run a benchmark; what it says beside its rows goes to the terminal."""
    load, start, before = os.getloadavg()[0], time.perf_counter(), _spent()
    done = subprocess.run([sys.executable, str(path), "--json", *flags], stdout=subprocess.PIPE, check=False)
    cpu, wall = _spent() - before, time.perf_counter() - start
    date, quick = datetime.now(UTC).isoformat(timespec="seconds"), "--quick" in flags
    try:
        rows = tuple(Row(**each) for each in json.loads(done.stdout))
    except (ValueError, TypeError):
        print(f"{path.stem}: no rows, it ended with {done.returncode}", file=sys.stderr)
        rows = ()
    return Measured(done.returncode, quick, date, version("noctule"), machine(), load, cpu, wall, rows)


def _spent() -> float:
    """Processor time of all processes that this one has waited for, s."""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def read_table(path: Path) -> Table:
    """The table that a file has, none where there is no file."""
    if not path.exists():
        return {}
    kept: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return {
        name: Measured(**{**each, "rows": tuple(Row(**row) for row in each["rows"])})
        for name, each in kept.items()
    }


def write_table(table: Table, folder: Path, now: Sequence[str]) -> None:
    """Write both forms of the table, and what is of now as a line of the history."""
    folder.mkdir(parents=True, exist_ok=True)
    plain = {
        name: {**asdict(each), "rows": [as_json(row) for row in each.rows]}
        for name, each in sorted(table.items())
    }
    (folder / "table.json").write_text(json.dumps(plain, indent=1) + "\n", encoding="utf-8")
    (folder / "table.md").write_text("\n".join(markdown(table)) + "\n", encoding="utf-8")
    with (folder / "history.jsonl").open("a", encoding="utf-8") as history:
        history.write(json.dumps({name: plain[name] for name in now}) + "\n")


def markdown(table: Mapping[str, Measured]) -> Iterator[str]:
    """Lines of a page: a table a benchmark."""
    yield from ("# Benchmarks", "", f"Versions: {versions()}.", "")
    yield "Ours and the peer's are in the row's unit; `of the limit` is 1 or more where a claim holds."
    for name, each in sorted(table.items()):
        form = "short form" if each.quick else "whole"
        quiet = "quiet" if each.quiet else f"not quiet, load {each.load:.1f}"
        yield from ("", f"## {name}", "")
        yield (
            f"{each.date}, noctule {each.version}, {form}; {each.machine}, {quiet};"
            f" {each.cpu:.0f} s of processor time, {each.wall:.0f} s; status {each.status}."
        )
        yield from ("", "| row | ours | peer | ratio | claim | of the limit | cores | with |")
        yield "|---|---|---|---|---|---|---|---|"
        for row in each.rows:
            figures = (_g(row.ours), _g(row.peer), _g(row.ratio), row.claim, _g(of_limit(row)))
            cells = (row.name, *figures, str(row.cores), row.accuracy)
            yield f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"


def _g(value: float | None) -> str:
    return "-" if value is None else f"{value:.4g}"


def of_limit(row: Row) -> float | None:
    """Ratio over what is claimed at least, or what is claimed at most over it: 1 or more where it holds."""
    if row.ratio is None or not row.claimed:
        return None
    over = [row.ratio / row.least] if row.least > 0.0 else []
    if row.most < float("inf"):
        over.append(row.most / row.ratio if row.ratio > 0.0 else float("inf"))
    return min(over)


def changes(before: Table, now: Table) -> Iterator[Change]:
    """Rows that both tables have, of the same form, whose claim has a better side."""
    for name in sorted(before.keys() & now.keys()):
        if before[name].quick != now[name].quick:
            continue
        old = {row.name: row for row in before[name].rows}
        for row in now[name].rows:
            then = old.get(row.name)
            if then is None or then.ratio is None or row.ratio is None or then.ratio <= 0.0:
                continue
            if row.least > 0.0 and row.most == float("inf"):
                yield Change(name, row.name, then.ratio, row.ratio, 1.0 - row.ratio / then.ratio)
            elif row.most < float("inf") and row.least <= 0.0:
                yield Change(name, row.name, then.ratio, row.ratio, row.ratio / then.ratio - 1.0)


def compare(before: Table, now: Table) -> int:
    """Tell what is worse than before, and what could not be compared; returns how many rows are."""
    found = list(changes(before, now))
    worse = [each for each in found if each.share > WORSE]
    judged = [each for each in worse if before[each.script].machine == now[each.script].machine]
    for each in worse:
        elsewhere = "" if each in judged else ", on another machine, which is not judged"
        print(f"worse: {each.script}, {each.row}: {each.before:.4g} to {each.now:.4g}{elsewhere}")
    rows = sum(len(each.rows) for each in now.values())
    measured = {(name, row.name) for name, each in now.items() for row in each.rows}
    for name in sorted(before.keys() & now.keys()):
        for row in before[name].rows:
            if (name, row.name) not in measured:
                print(f"gone: {name}, {row.name}")
    told = f"{len(found)} of {rows} rows have a better side and were compared"
    print(f"{told}, {len(judged)} are worse by {WORSE:.0%}")
    return len(judged)


def run(wanted: Sequence[str], options: Namespace, folder: Path = HERE) -> int:
    """Measure benchmarks, write the table, compare it; returns the exit status."""
    kept = read_table(options.output / "table.json")
    before = read_table(options.compare) if options.compare else kept
    now: Table = {}
    for name in wanted:
        print(f"== {name}", flush=True)
        now[name] = measure(folder / f"{name}.py", ["--quick"] if options.quick else [])
        for row in now[name].rows:
            missed = "" if row.holds else ", MISSED"
            claim = f", claim {row.claim}{missed}" if row.claim else ""
            print(f"{row.name}: {_g(row.ratio)}{claim}; {row.accuracy}", flush=True)
        write_table({**kept, **now}, options.output, [name])
    worse = compare(before, now) if before else 0
    failed = [name for name, each in now.items() if each.status]
    told = f"{len(now)} benchmarks, {len(failed)} missed a claim or failed"
    print(f"{options.output / 'table.md'}: {told}")
    return int(bool(failed or worse))


def main() -> int:
    """Read the options and run, or compare what there is."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="benchmarks; all unless given")
    parser.add_argument("--quick", action="store_true", help="their short forms")
    parser.add_argument("--output", type=Path, default=RESULTS, metavar="FOLDER", help="of the table")
    parser.add_argument("--compare", type=Path, metavar="FILE", help="a table of before")
    options = parser.parse_args()
    unknown = sorted(set(options.names) - set(names()))
    if unknown:
        parser.error(f"{unknown[0]}: no such benchmark; there are {', '.join(names())}")
    if options.compare and not options.compare.exists():
        parser.error(f"{options.compare}: no such file; name a table.json")
    if options.compare and not options.names:
        if not (options.output / "table.json").exists():
            parser.error(f"{options.output}: no table.json to compare; name benchmarks to run, or its folder")
        return int(compare(read_table(options.compare), read_table(options.output / "table.json")) > 0)
    return run(options.names or names(), options)


if __name__ == "__main__":
    sys.exit(main())
