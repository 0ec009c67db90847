"""Claim: a change that is not meant to change numbers changes none, over the commands of the whole project.

`--write FILE` runs the commands below and keeps what each printed and its exit status; `--compare FILE` runs
them again and says where they differ, `--with FILE` instead of running them. Times, versions, hashes and
paths are left out. `--checkout FOLDER` takes the packages from another checkout.
"""

from __future__ import annotations

import argparse
import gzip
import json
import math
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from _report import Row, report

ROOT = Path(__file__).parents[1]
DEADLINE = 600.0  # s of a command; ours
LEFT_OUT = {"seconds", "versions", "command", "circuit", "hash", "key", "record", "file", "output", "path"}
_NUMBER = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")

SILICON = (
    "",
    "--die 1003",
    "--die 1004 --bias-kind ideal",
    "--die 1003 --bias-kind gate --temperature 45",
)
RUNS = {
    "approach": "--level behavioural --duration 1s",
    "rover": "--map map1-road --start 2,10 --goal 19,10 --cells chip --posts --sonar",
    "forest": "--pings 60 --ranges chip --selection chip --silicon-noise all",
    "car": "--forest dense --pings 60 --ranges chip",
    "head": "--motion sine --duration 3s",
    "bug": "--agent bug2 --brain chip --design improved --duration 8s",
    "pushbot": "--scene single-block --duration 3s",
}
FORMER = {  # beginnings of commands, as they were
    "run car ": "run robot ",
    "run spiking-bat --brain network ": "run forest --model latency-network ",
    "run spiking-bat --brain chip ": "run forest --model latency-chip ",
}
KINDLESS = {"approach"}  # systems whose bias kind is no option
OTHER_RUNS = (
    "run approach --duration 100ms",
    "run approach --level behavioural --duration 500ms --noise 5mV --seed 3 --amplitude-law d4",
    "run spiking-bat --brain network --pings 30 --seed 1007",
    "run spiking-bat --brain chip --pings 30 --seed 1007 --die 1003 --codes calibrated",
    "run forest --ranges sonar --pings 60 --seed 1000 --multipath",
    "run rover --map map2 --learn 0.5 --prior 1 --trips 2",
    "run rover --planner a-star --need speed --map map1-road-obstacles",
    "run bug --agent bug0 --brain reference",
    "run bug --agent bug1 --brain reference --map bug-field",
    "run pushbot --scene clutter --modified --duration 2s --die 5",
    "run head --motion step --wiring excitation --duration 2s",
    "montecarlo rebound-neuron -n 6 --metric best_delay --threads 1",
    "montecarlo axon-delay -n 4 --metric unit_delay --contributions unit_delay --threads 1",
    "montecarlo approach -n 2 --metric range_error_mean_m --threads 1 --duration 500ms",
    "simulate rebound-neuron --engine ngspice",
    "simulate rebound-neuron --analysis noise --node v_mem",
    "simulate rebound-neuron --analysis ac --node v_mem",
    "show rolls --die 3",
    "export ranging-chip --level behavioural -o -",
    "export tonic-neuron --process gf180mcu -o -",
    "export ranging-chip --die 1003 --dialect spectre --models bsim3 -o -",
)
DIALECTS = ("ngspice", "spectre")
OTHER_DIALECTS = ("xyce", "hspice", "cdl", "verilog-a")  # of one block and one chip
REPRODUCTIONS = (
    "cheely2003-fig4", "cheely2003-fig5", "cheely2003-fig10", "cheely2003-power", "hwu2018-fig1",
    "hwu2018-fig2", "hwu2018-table1", "wen2022-fig5", "wen2022-fig11b", "wen2022-fig11c", "wen2022-fig11e",
    "wen2022-fig12", "stockel2017-fig5", "milde2017-fig5", "latency-equations",
)  # fmt: skip


Answer = subprocess.CompletedProcess[str]  # what a command left


@dataclass(frozen=True, slots=True)
class Difference:
    """Where two answers differ: the largest relative change of a number, and other changes as text."""

    command: str
    relative: float
    texts: tuple[str, ...]


def commands(checkout: Path) -> list[str]:
    """All commands, those on blocks, chips and systems from the registries of a checkout."""
    listed = json.loads(answer("list --json", checkout).stdout)
    found = ["list --json"]
    for entry in (*listed["blocks"], *listed["chips"]):
        name = entry["name"]
        found += [f"show {name} --json", f"op {name} --json", f"op {name} --die 1003 --temperature 45 --json"]
        found += [f"simulate {name} {silicon} --json" for silicon in SILICON]
        found += [f"export {name} --dialect {dialect} --die 1003 -o -" for dialect in DIALECTS]
    for name in ("rebound-neuron", "wavefront-chip"):
        found += [f"export {name} --dialect {dialect} --die 1003 -o -" for dialect in OTHER_DIALECTS]
    for name, options in RUNS.items():
        silicon = [s for s in SILICON if name not in KINDLESS or "--bias-kind" not in s]
        found += [f"run {name} {options} {s} --json" for s in silicon]
    found += [text if " -o -" in text else f"{text} --json" for text in OTHER_RUNS]
    found += [f"reproduce {name} --json" for name in REPRODUCTIONS]
    return [" ".join(text.split()) for text in found]


def answer(command: str, checkout: Path) -> Answer:
    """Run a command with the packages of a checkout, in a folder of its own."""
    folder = "system.cli" if (checkout / "system" / "cli").is_dir() else "system"
    code = f"import sys; from {folder}.command_line import main; sys.exit(main())"
    environment = {**os.environ, "PYTHONPATH": str(checkout), "MPLBACKEND": "Agg"}
    with tempfile.TemporaryDirectory() as place:
        try:
            return subprocess.run(
                [sys.executable, "-c", code, *command.split()], check=False, capture_output=True, text=True,
                env=environment, cwd=place, timeout=DEADLINE, stdin=subprocess.DEVNULL,
            )  # fmt: skip
        except subprocess.TimeoutExpired:
            return Answer(command, -1, "", f"not done after {DEADLINE:g} s")


def answers(checkout: Path, only: str, workers: int) -> dict[str, Answer]:
    """What each command leaves, the commands whose text has `only` in it."""
    chosen = [c for c in commands(checkout) if re.search(only, c)]
    former = "spiking-bat" not in answer("list --json", checkout).stdout
    with ThreadPoolExecutor(workers) as pool:
        found = pool.map(lambda c: answer(former_of(c) if former else c, checkout), chosen)
        return dict(zip(chosen, found, strict=True))


def former_of(command: str) -> str:
    """A command as checkouts had it before its system had its name."""
    for new, then in FORMER.items():
        command = command.replace(new, then)
    return command


def present_of(command: str) -> str:
    """A command as it is, of one that a checkout had before."""
    for new, then in FORMER.items():
        command = command.replace(then, new)
    return command


def write(found: dict[str, Answer], path: Path) -> None:
    """Keep answers in a compressed JSON file."""
    data = json.dumps({command: _kept(each) for command, each in found.items()}).encode()
    path.write_bytes(gzip.compress(data, mtime=0))


def read(path: Path) -> dict[str, Answer]:
    """What `write` kept."""
    document = json.loads(gzip.decompress(path.read_bytes()))
    return {
        present_of(command): Answer(command, each["status"], each["out"], each["err"])
        for command, each in document.items()
    }


def _kept(one: Answer) -> dict[str, int | str]:
    return {"status": one.returncode, "out": one.stdout, "err": one.stderr}


def differences(before: dict[str, Answer], after: dict[str, Answer]) -> Iterator[Difference]:
    """Commands whose answers are not the same to the bit."""
    for command in dict.fromkeys([*before, *after]):
        if command not in before or command not in after:
            yield Difference(command, 0.0, ("only before" if command in before else "only after",))
            continue
        old, new = before[command], after[command]
        largest, texts = (
            0.0,
            [] if old.returncode == new.returncode else [f"status {old.returncode}, now {new.returncode}"],
        )
        for place, was, now in [*_compared(_leaves(old), _leaves(new))]:
            if isinstance(was, float) and isinstance(now, float):
                largest = max(largest, abs(now - was) / max(abs(was), abs(now)))
            else:
                texts.append(f"{place}: {_short(was)}, now {_short(now)}")
        if largest or texts:
            yield Difference(command, largest, tuple(texts))


def _leaves(one: Answer) -> dict[str, float | str]:
    """Numbers and texts of an answer by place; of a document that is no JSON, by line."""
    try:
        document = json.loads(one.stdout)
    except ValueError:
        document = one.stdout.splitlines()
    return {**dict(_walk(document, "")), "stderr": one.stderr.strip()}


def _walk(value: Any, place: str) -> Iterator[tuple[str, float | str]]:
    if isinstance(value, dict):
        for key, inner in value.items():
            if key not in LEFT_OUT:
                yield from _walk(inner, f"{place}.{key}")
    elif isinstance(value, list):
        for k, inner in enumerate(value):
            yield from _walk(inner, f"{place}[{k}]")
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield place, float(value)
    elif isinstance(value, str):
        for k, number in enumerate(_NUMBER.findall(value)):
            yield f"{place}#{k}", float(number)
        yield place, _NUMBER.sub("#", value)
    else:
        yield place, str(value)


def _compared(
    old: dict[str, float | str], new: dict[str, float | str]
) -> Iterator[tuple[str, float | str | None, float | str | None]]:
    for place in dict.fromkeys([*old, *new]):
        was, now = old.get(place), new.get(place)
        both = isinstance(was, float) and isinstance(now, float)
        if was != now and not (both and math.isnan(was) and math.isnan(now)):  # type: ignore[arg-type]
            yield place, was, now


def _short(value: object) -> str:
    text = "absent" if value is None else str(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", action="store_true", help="rows as JSON")
    parser.add_argument("--quick", action="store_true", help="commands on two blocks, twice")
    parser.add_argument("--write", type=Path, metavar="FILE", help="keep the answers")
    parser.add_argument("--compare", type=Path, metavar="FILE", help="answers of before")
    parser.add_argument("--with", type=Path, metavar="FILE", dest="after", help="answers of after")
    parser.add_argument("--checkout", type=Path, default=ROOT, help="whose packages run; this one's")
    parser.add_argument("--only", default="", metavar="PATTERN", help="commands that match")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    return parser.parse_args()


def main() -> int:
    """Keep answers, or compare them with kept ones; without either, two runs with each other."""
    options = _options()
    only = options.only or (r"^(show|op|simulate) (axon-delay|lso-neuron) --json" if options.quick else "")
    after = read(options.after) if options.after else answers(options.checkout, only, options.workers)
    if options.write:
        write(after, options.write)
        print(f"{len(after)} commands, {sum(a.status != 0 for a in after.values())} of them refused")
        return 0
    before = read(options.compare) if options.compare else answers(options.checkout, only, options.workers)
    before = {command: each for command, each in before.items() if re.search(only, command)}
    found = list(differences(before, after))
    for each in [] if options.json else found:
        print(f"{each.command}\n    numbers within {each.relative:.3g} relative")
        for text in each.texts[:6]:
            print(f"    {text}")
        if len(each.texts) > 6:
            print(f"    and {len(each.texts) - 6} more")
    same = len(after) - len(found)
    share = same / len(after) if after else math.nan
    row = Row("commands whose answer is the same to the bit", same, len(after), share, "bits", 1, 1.0)
    return report([row], options, lambda r: f"{r.ours:g} of {r.peer:g}")


if __name__ == "__main__":
    sys.exit(main())
