"""Claim: a damaged file or option gives a result or one line, within 10 s and 1 GB.

Each case is a seed of one kind of input (`_fuzz_input.INPUTS`) with one to three kinds of damage (`_damage`).
Case k of a kind is made by a generator with the key (seed, kind, k), so that any can be made again alone
(`--only KIND --first K --count 1`). A process of its own reads them; one that hangs or dies ends it, and
another goes on behind that case. `--command-line N` damages N commands and runs each as it is run by hand.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
import warnings
import zlib
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, field
from multiprocessing import Pipe, get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

from _damage import damaged
from _fuzz_input import INPUTS, SECONDS, Input, command_words
from _report import Row, parser_of, report
from circuits.errors import CircuitError

HANG = 2.0 * SECONDS  # s, after which a case is given up
QUICK = 20  # cases a kind of input
BY_HAND = "command line"  # the kind that has a process a case
SHOWN = 20  # broken cases of a kind that are printed


class Reading(NamedTuple):
    """What came of a case: its damage, seconds, peak memory (MB), and a refusal or what breaks the claim."""

    damage: tuple[str, ...]
    seconds: float
    megabytes: float
    refused: bool
    broken: str | None


@dataclass
class Tally:
    """What came of the cases of a kind: results, refusals, the slowest, and what broke the claim."""

    results: int = 0
    refusals: int = 0
    slowest: tuple[float, int] = (0.0, -1)
    megabytes: float = 0.0
    broken: list[tuple[int, str]] = field(default_factory=list)
    damage: Counter[str] = field(default_factory=Counter)

    def add(self, k: int, one: Reading) -> None:
        """Count a case."""
        self.damage.update(one.damage)
        self.slowest = max(self.slowest, (one.seconds, k))
        self.megabytes = max(self.megabytes, one.megabytes)
        if one.broken is not None:
            self.broken.append((k, one.broken))
        elif one.refused:
            self.refusals += 1
        else:
            self.results += 1

    @property
    def text(self) -> str:
        """In words."""
        return f"{self.results} results, {self.refusals} refusals, {len(self.broken)} broken"


def _resident() -> float:
    """Memory of this process, MB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 2**20


class Work(NamedTuple):
    """By which clock a reader is timed (s), and what its process holds that is not the reader's, MB."""

    clock: Callable[[], float]
    megabytes: Callable[[], float]


ALONE = Work(time.perf_counter, lambda: 0.0)
BESIDE_OTHERS = Work(time.thread_time, _resident)  # neither a busy machine nor earlier work is the reader's


class Reader:
    """Reads the cases of one kind in a folder of its own."""

    def __init__(self, kind: Input, seed: int, folder: Path, work: Work = ALONE) -> None:
        """Put there what the kind needs."""
        self.kind, self.key = kind, (seed, zlib.crc32(kind.name.encode()))
        self.seeds, self.clock = kind.begin(folder), work.clock
        self.begun = work.megabytes()
        self.path = folder / kind.file
        self.path.parent.mkdir(parents=True, exist_ok=True)

    def read(self, k: int) -> Reading:
        """Make case k and read it against the clock."""
        document, done = damaged((*self.key, k), self.seeds, self.kind.damage)
        self.path.write_bytes(document)
        refused, broken = False, None
        before, start = _megabytes(), self.clock()
        try:
            with warnings.catch_warnings(action="error"):  # a warning would be a second line
                self.kind.read(self.path)
        except CircuitError as error:
            refused = True
            broken = None if len(str(error).splitlines()) == 1 else f"not one line: {str(error)[:200]!r}"
        except Exception as error:  # noqa: BLE001 - any other exception at all breaks the claim
            broken = f"{type(error).__name__}: {' '.join(str(error)[:200].split())}"
        seconds, peak = self.clock() - start, _megabytes()
        if broken is None and seconds > self.kind.seconds:
            broken = f"took {seconds:.1f} s"
        if broken is None and peak > before and peak - self.begun > self.kind.megabytes:
            broken = f"took {peak:.0f} MB"
        return Reading(tuple(done), seconds, peak, refused, broken)


def _megabytes(who: int = resource.RUSAGE_SELF) -> float:
    """Peak memory so far, MB: of this process, or of the largest of those that it ran."""
    return resource.getrusage(who).ru_maxrss / 1024


class Apart:
    """A `Reader` in a process, so that its memory is the reader's; a case on which it hangs ends it."""

    def __init__(self, kind: str, seed: int) -> None:
        """Start it."""
        self.kind, self.seed = kind, seed
        self.begin()

    def begin(self) -> None:
        """Start the process, and wait until it is ready."""
        self.here, there = Pipe()
        self.folder = tempfile.TemporaryDirectory()  # a process that is killed leaves its files
        self.process = get_context("spawn").Process(
            target=_serve, args=(there, self.kind, self.seed, self.folder.name), daemon=True
        )
        self.process.start()
        there.close()
        self.here.recv()

    def read(self, k: int) -> Reading:
        """Read case k."""
        self.here.send(k)
        found = Reading((), HANG, 0.0, refused=False, broken=f"not read after {HANG:g} s")
        try:
            if self.here.poll(HANG):
                one: Reading = self.here.recv()
                return one
        except EOFError:
            found = found._replace(seconds=0.0, broken="the process that read it died")
        self.close()
        self.begin()
        return found

    def close(self) -> None:
        """Stop the process."""
        self.process.kill()
        self.process.join()
        self.folder.cleanup()


def _serve(cases: Connection, kind: str, seed: int, folder: str) -> None:
    reader = Reader(INPUTS[kind], seed, Path(folder))
    cases.send(None)
    while True:
        cases.send(reader.read(cases.recv()))


def run(kind: str, cases: Iterable[int], seed: int) -> Tally:
    """Read cases of a kind in this process, whatever else it does."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as folder:
        reader = Reader(INPUTS[kind], seed, Path(folder), BESIDE_OTHERS)
        for k in cases:
            tally.add(k, reader.read(k))
    return tally


def run_apart(kind: str, cases: Iterable[int], seed: int) -> Tally:
    """Read cases of a kind in a process of its own."""
    tally = Tally()
    with closing(Apart(kind, seed)) as reader:
        for k in cases:
            tally.add(k, reader.read(k))
    return tally


def run_commands(cases: Sequence[int], seed: int, workers: int) -> Tally:
    """Damage commands and run each as it is run by hand; status 0 to 2, and one line where it is not 0."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(workers) as pool:
        reader = Reader(INPUTS[BY_HAND], seed, Path(folder))
        for command in reader.seeds:  # as they are: kernels are compiled once, before the clock
            _by_hand(command_words(command), (), folder)

        def one(k: int) -> Reading:
            document, done = damaged((*reader.key, k), reader.seeds, reader.kind.damage)
            return _by_hand(command_words(document), tuple(done), folder)

        for k, found in zip(cases, pool.map(one, cases), strict=True):
            tally.add(k, found)
    return tally


def _by_hand(words: Sequence[str], done: tuple[str, ...], folder: str) -> Reading:
    start = time.perf_counter()
    command = [sys.executable, "-m", "system.cli.command_line", *words]
    try:
        found = subprocess.run(
            command, cwd=folder, capture_output=True, timeout=6.0 * SECONDS, check=False, errors="replace"
        )
    except subprocess.TimeoutExpired:
        return Reading(done, 6.0 * SECONDS, 0.0, refused=False, broken=f"endless: {words}")
    except (ValueError, OSError):  # no command at all: the system takes no such words
        return Reading(done, 0.0, 0.0, refused=True, broken=None)
    lines = found.stderr.splitlines()
    fine = found.returncode == 0 or (found.returncode in {1, 2} and len(lines) == 1)
    broken = (
        None if fine and "Traceback" not in found.stderr else f"{words}: {found.returncode}, {lines[-1:]}"
    )
    seconds, peak = time.perf_counter() - start, _megabytes(resource.RUSAGE_CHILDREN)
    return Reading(done, seconds, peak, refused=found.returncode != 0, broken=broken)


def rows_of(kind: str, tally: Tally, cores: int) -> Iterator[Row]:
    """Broken cases, which there must be none of, and what the slowest took of what is allowed."""
    limits = INPUTS[kind]
    yield Row(f"{kind}: broken", len(tally.broken), 0.0, float(not tally.broken), tally.text, cores, 1.0)
    seconds, case = tally.slowest
    for name, ours, peer, told in (
        ("slowest (s)", seconds, limits.seconds, f"case {case}"),
        ("peak memory (MB)", tally.megabytes, limits.megabytes, "of the process"),
    ):
        yield Row(f"{kind}: {name}", ours, peer, ours / peer, told, cores, most=1.0)


def main() -> int:
    """Run the cases and print what came of them."""
    parser = parser_of(__doc__, f"{QUICK} cases a kind of input")
    parser.add_argument("--count", type=int, default=100_000, help="cases, shared by the kinds of input")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--only", choices=list(INPUTS), help="a kind of input")
    parser.add_argument("--command-line", type=int, default=0, metavar="N", help="commands as by hand")
    options = parser.parse_args()
    kinds = [name for name in ([options.only] if options.only else INPUTS) if name != BY_HAND]
    if not kinds and not options.command_line:
        parser.error(f"--only: {BY_HAND!r} needs --command-line N, how many")
    each = QUICK if options.quick else -(-options.count // max(len(kinds), 1))
    cases = range(options.first, options.first + each)
    if options.quick:  # here: a process takes seconds to begin
        tallies = {kind: run(kind, cases, options.seed) for kind in kinds}
    else:
        with ThreadPoolExecutor(options.workers) as pool:
            found = pool.map(lambda kind: run_apart(kind, cases, options.seed), kinds)
            tallies = dict(zip(kinds, found, strict=True))
    if options.command_line:
        commands = range(options.first, options.first + options.command_line)
        tallies[BY_HAND] = run_commands(commands, options.seed, options.workers)
    for kind, tally in tallies.items():
        for case, text in tally.broken[:SHOWN]:
            print(f"{kind}, case {case}: {text}", file=sys.stderr)
    return report((row for kind in tallies for row in rows_of(kind, tallies[kind], options.workers)), options)


if __name__ == "__main__":
    raise SystemExit(main())
