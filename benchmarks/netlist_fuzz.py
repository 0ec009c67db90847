"""Claim: a damaged netlist gives a result or one line with file and line, within 2 s and 500 MB.

Seeds are our own exports and hand-written decks. Each case is a seed with one to three kinds of damage:
flipped bytes, moved, doubled and missing lines, a cut, words of another seed, deep nesting, huge numbers,
tricks with `.include`, long lines, many lines. Case k is made by a generator with the key (seed, k), so that
any of them can be made again alone (`--first K --count 1`).
"""

from __future__ import annotations

import argparse
import json
import re
import resource
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from multiprocessing import Pipe, get_context
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

import numpy as np

from chips.registry import load_chip
from circuits.die import Die
from circuits.errors import DataError
from circuits.registry import load_block
from circuits.silicon import Silicon
from netlists.dialect import DIALECTS, Settings, load_dialect
from netlists.reader import read_netlist
from netlists.reader.summary import summarise

SECONDS, MEGABYTES = 2.0, 500.0
HANG = 20.0  # s, after which a deck is given up
ERROR = re.compile(r"[^\n:]+:\d+: [^\n]+")
HAND = (
    """inverter chain
.param w0=3u wp={2*w0}
.global vdd
.subckt inv in out params: w=3u l=1.5u
mn out in 0 0 nch w={w} l={l} ad=1p delvto=0.01
mp out in vdd vdd pch w={2*w} l={l} m=2 mulu0=1.02
.ends inv
.subckt pair a b
x1 a m inv
x2 m b inv w={w0}
.ends
.model nch nmos (level=8 vth0=0.6
+ tox=3e-8)
.model pch pmos (level=8)
vdd vdd 0 5
vin in 0 dc 0 pulse(0 5 1u 10n 10n 5u 20u)
x1 in mid pair
x2 mid out pair
.ic v(out)=0 v(x1.m)=5
.tran 10n 100u
.end
""",
    """filter
r1 in 1 10k
c1 1 0 1n ; first pole
r2 1 net-3 {10k*(1+0.5)}
c2 net-3 0 0.5n $ second pole
b1 net-3 0 i=1e-6*(v(net-3)-v(1))
g1 0 out net-3 0 2u
i1 out 1 pwl(0 0 1u 1n 2u 0)
vin in 0 sin(2.5 1 1meg)
.options reltol=1e-5 temp=27
.dc vin 0 5 0.1
.tran 1u 10u
.save all
.end
""",
    """library
.include inside.cir
.lib models.lib typical
.subckt top a b vdd
xa a b vdd part k=2
.ends
""",
)
INSIDE = ".subckt part a b vdd params: k=1\nm1 a b 0 0 nfet w={k*1u} l=1u\nr1 a vdd 1k\n.ends\n"
MODELS = ".lib typical\n.model nfet nmos level=8\n.endl\n.lib slow\n.model nfet nmos level=8 vth0=1\n.endl\n"
NUMBERS = (
    "1e999", "-1e999", "1e308", "1e-400", "0", "-0", "nan", "inf", "1e", "1e+", "9" * 400, "0x10", "1meg",
    "1mil", "--1", ".", "1e308k", "1000000000000", "-1", "{1/0}", "{9^9^9^9}", "{sqrt(-1)}", "3", "2.5u",
    "10k", "4", "1.5",
)  # fmt: skip
TRICKS = (
    ".include ../outside.cir", ".include /etc/passwd", ".include loop_a.cir", ".include deck.cir",
    ".include folder", ".include link.cir", ".include nothing.cir", '.include ""', ".include",
    ".lib models.lib", ".lib models.lib none", ".lib /etc/hosts x", ".include " + "a/" * 3000,
    ".include inside.cir", ".include folder/../inside.cir", ".include ~/x", ".include $HOME/x",
    ".include |ls", ".include http://localhost/x", ".include /dev/zero", ".include wide.cir",
)  # fmt: skip
LINES = (
    "+ more", "*%", "*% noctule", "*% array name=n shape=1000000,1000000 connections=( )", "*%+ x=1", ".ends",
    ".end", ".subckt inv a b", ".subckt loop a\nx1 a loop\n.ends\nxl 1 loop", "x9 in out inv w=", "m9 1 2 3",
    "q1 1 2 3 npn", ".param a={b} b={a}", ".control\nshell rm x\n.endc", ".control", "b2 1 0 i=v(1)^2",
    "v9 1 2 5", "r9 1 1", "r1 in 1 10k", ".model", ".if (1)", ".tran 1u", ".tran 0 0",
    "vz 1 0 pulse(0 1 0 1n 1n 1n 2n)", "vy 1 0 sin(0 1 1e30)", "vx 1 0 pwl(0 0 0 1)", ".ic v(nowhere)=1",
    "x1 x2 x3", "= = =", "{", "}", "'", '"', "()", "r99 in 0 1k", "c99 out 0 1p", "* a comment",
    "r=1k", "c=1p", "g=1", "i a=1", ".step param w0 1u 2u 1u", ".options scale=1u",
)  # fmt: skip


@dataclass
class Tally:
    """What came of some cases: results and refusals, the slowest, and what broke the claim."""

    results: int = 0
    refusals: int = 0
    slowest: tuple[float, int] = (0.0, -1)
    broken: list[tuple[int, str]] = field(default_factory=list)
    damage: Counter[str] = field(default_factory=Counter)
    megabytes: float = 0.0


def seeds() -> list[bytes]:
    """Decks to damage: hand-written ones, and our own with notes, in every dialect and on a die."""
    texts = [*HAND]
    written = [
        *(("vocalization-controller", None, dialect) for dialect in DIALECTS),
        ("rebound-neuron", 1003, "ngspice"),
        ("bias-generator", None, "ngspice"),
        ("ranging-chip", None, "ngspice"),
    ]
    for name, number, dialect in written:
        block = load_chip(name) if name == "ranging-chip" else load_block(name)
        circuit = block.build(block.params())
        bench = block.testbench(circuit, {s.name: s.default for s in block.stimuli}, 5.0)
        texts.append(load_dialect(dialect).write(bench, Silicon(die=Die(number=number)), Settings()))
    return [text.encode() for text in texts]


def make_root(folder: Path) -> None:
    """Files around a deck: what it may include, and what it must not."""
    root = folder / "root"
    (root / "folder").mkdir(parents=True)
    files = {"inside.cir": INSIDE, "models.lib": MODELS, "loop_a.cir": ".include loop_b.cir\n",
             "loop_b.cir": ".include loop_a.cir\n", "wide.cir": ".include wide_b.cir\n" * 300,
             "wide_b.cir": "* nothing\n"}  # fmt: skip
    for name, text in files.items():
        (root / name).write_text(text)
    (folder / "outside.cir").write_text("r_outside 1 0 1k\n")
    (root / "link.cir").symlink_to(folder / "outside.cir")


def damaged(seed: int, k: int, decks: list[bytes]) -> tuple[bytes, list[str]]:
    """Case k: a deck with damage, and the names of the damage."""
    random = np.random.default_rng([seed, k])
    deck = decks[int(random.integers(len(decks)))]
    done = []
    for _ in range(int(random.choice([1, 1, 1, 2, 3]))):
        name = str(random.choice(list(DAMAGE), p=WEIGHTS))
        deck = DAMAGE[name](deck, random, decks)
        done.append(name)
    return deck, done


Damage = Callable[[bytes, np.random.Generator, list[bytes]], bytes]


def flip_bytes(deck: bytes, random: np.random.Generator, decks: list[bytes]) -> bytes:
    """Other bytes at some places, of any value or printable."""
    data = bytearray(deck)
    top = 256 if random.random() < 0.3 else 127
    for _ in range(int(random.integers(1, 12))):
        if data:
            data[int(random.integers(len(data)))] = int(random.integers(9 if top == 256 else 32, top))
    return bytes(data)


def move_lines(deck: bytes, random: np.random.Generator, decks: list[bytes]) -> bytes:
    """Lines swapped, doubled or left out."""
    lines = deck.split(b"\n")
    for _ in range(int(random.integers(1, 6))):
        i, j = (int(n) for n in random.integers(len(lines), size=2))
        match int(random.integers(3)):
            case 0:
                lines[i], lines[j] = lines[j], lines[i]
            case 1:
                lines.insert(i, lines[j])
            case _ if len(lines) > 1:
                del lines[i]
    return b"\n".join(lines)


def cut(deck: bytes, random: np.random.Generator, decks: list[bytes]) -> bytes:
    """The beginning or the end only."""
    at = int(random.integers(len(deck) + 1))
    return deck[:at] if random.random() < 0.7 else deck[at:]


def splice(deck: bytes, random: np.random.Generator, decks: list[bytes]) -> bytes:
    """A word, or a piece of another deck, in place of a word."""
    other = decks[int(random.integers(len(decks)))]
    words, theirs = deck.split(b" "), other.split(b" ")
    for _ in range(int(random.integers(1, 5))):
        at = int(random.integers(len(words)))
        start, count = int(random.integers(len(theirs))), int(random.integers(1, 4))
        words[at : at + 1] = theirs[start : start + count]
    return b" ".join(words)


def nest(deck: bytes, random: np.random.Generator, decks: list[bytes]) -> bytes:
    """Brackets, powers, parameters, definitions or calls in one another."""
    depth = int(10 ** random.uniform(0.5, 4.5))
    match int(random.integers(6)):
        case 0:
            line = f"rn 1 0 {{{'(' * depth}1{')' * depth}}}"
        case 1:
            line = f"rn 1 0 {{{'2^' * depth}1}}"
        case 2:
            line = "\n".join(f".param p{k}={{p{k + 1}}}" for k in range(depth)) + f"\n.param p{depth}=1"
        case 3:
            line = "\n".join(f".subckt s{k} a" for k in range(depth)) + "\n.ends" * depth
        case 4:
            calls = (f".subckt d{k} a\nx1 a d{k + 1}\nx2 a d{k + 1}\n.ends" for k in range(min(depth, 3000)))
            line = "\n".join(calls) + f"\n.subckt d{min(depth, 3000)} a\nr1 a 0 1\n.ends\nxn 1 d0"
        case _:
            few = min(depth, 40)
            calls = (
                f".subckt e{k} a p=1\nx1 a e{k + 1} p={{p*2}}\nx2 a e{k + 1} p={{p+1}}\n.ends"
                for k in range(few)
            )
            line = "\n".join(calls) + f"\n.subckt e{few} a p=1\nr1 a 0 {{p}}\n.ends\nxe 1 e0"
    return insert_line(deck, random, line.encode())


def change_numbers(deck: bytes, random: np.random.Generator, decks: list[bytes]) -> bytes:
    """Numbers that are huge, tiny or none."""
    found = list(re.finditer(rb"[0-9][0-9.e+-]*", deck))
    for _ in range(int(random.integers(1, 4))):
        if found:
            match = found[int(random.integers(len(found)))]
            number = NUMBERS[int(random.integers(len(NUMBERS)))].encode()
            deck = deck[: match.start()] + number + deck[match.end() :]
            found = found[:1]
    return deck


def include(deck: bytes, random: np.random.Generator, decks: list[bytes]) -> bytes:
    """A trick with files."""
    return insert_line(deck, random, TRICKS[int(random.integers(len(TRICKS)))].encode())


def add_line(deck: bytes, random: np.random.Generator, decks: list[bytes]) -> bytes:
    """A line that is wrong, or wrong where it stands."""
    return insert_line(deck, random, LINES[int(random.integers(len(LINES)))].encode())


def lengthen(deck: bytes, random: np.random.Generator, decks: list[bytes]) -> bytes:
    """A word, or the words of a line, many times over."""
    words = deck.split(b" ")
    at = int(random.integers(len(words)))
    times = int(10 ** random.uniform(1, 5))
    words[at] = words[at] * times if random.random() < 0.5 else b" ".join([words[at]] * times)
    return b" ".join(words)[: 3 * 2**20]


def multiply(deck: bytes, random: np.random.Generator, decks: list[bytes]) -> bytes:
    """A million lines and more."""
    lines = deck.split(b"\n")
    own = lines[int(random.integers(len(lines)))][:60]
    numbered = (b"r%d %d 0 1k" % (n, n) for n in range(1_000_000))
    body = b"\n".join(numbered) if random.random() < 0.5 else (own + b"\n") * 1_000_000
    return insert_line(deck, random, body)


def insert_line(deck: bytes, random: np.random.Generator, line: bytes) -> bytes:
    """The deck with a line more, anywhere."""
    lines = deck.split(b"\n")
    lines.insert(int(random.integers(min(1, len(lines) - 1), len(lines))), line)
    return b"\n".join(lines)


DAMAGE: dict[str, Damage] = {
    "flipped bytes": flip_bytes, "moved lines": move_lines, "cut": cut, "spliced words": splice,
    "nesting": nest, "numbers": change_numbers, "includes": include, "wrong line": add_line,
    "long line": lengthen, "million lines": multiply,
}  # fmt: skip
WEIGHTS = np.array([3, 3, 1, 3, 1, 3, 2, 3, 1, 0.02])
WEIGHTS = WEIGHTS / WEIGHTS.sum()


class Reading(NamedTuple):
    """What came of reading one deck: seconds, refusal, what broke the claim, peak memory (MB)."""

    seconds: float
    refusal: str | None
    broken: str | None
    megabytes: float


def judge(path: Path) -> str | None:
    """Read a deck; None for a result, the text of a proper refusal, else raises."""
    try:
        summarise(read_netlist(path, drop=[".model"]).circuit)
    except DataError as error:
        if not ERROR.fullmatch(str(error)):
            raise RuntimeError(f"not one line with file and line: {str(error)[:300]!r}") from error
        return str(error)
    return None


def timed(path: Path) -> Reading:
    """Read a deck against the clock."""
    start = time.perf_counter()
    refusal = broken = None
    try:
        with warnings.catch_warnings(action="error"):  # a warning would be a second line
            refusal = judge(path)
    except Exception as error:  # noqa: BLE001 - any exception at all breaks the claim
        broken = f"{type(error).__name__}: {str(error)[:200]}"
    if refusal is not None and "r_outside" in refusal:
        broken = "a file outside the root was read"
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return Reading(time.perf_counter() - start, refusal, broken, peak)


def run(cases: Iterable[int], seed: int, read: Callable[[Path], Reading] = timed) -> Tally:
    """Run some cases in a folder of their own."""
    tally, decks = Tally(), seeds()
    with tempfile.TemporaryDirectory() as folder:
        make_root(Path(folder))
        path = Path(folder) / "root" / "deck.cir"
        for k in cases:
            data, done = damaged(seed, k, decks)
            path.write_bytes(data)
            tally.damage.update(done)
            found = read(path)
            tally.slowest = max(tally.slowest, (found.seconds, k))
            tally.megabytes = max(tally.megabytes, found.megabytes)
            if found.broken is not None:
                tally.broken.append((k, found.broken))
            elif found.refusal is None:
                tally.results += 1
            else:
                tally.refusals += 1
    return tally


class Reader:
    """A process that reads decks, so that its memory is the reader's; a deck on which it hangs ends it."""

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Start the process."""
        self.here, there = Pipe()
        self.process = get_context("spawn").Process(target=read_paths, args=(there,), daemon=True)
        self.process.start()

    def __call__(self, path: Path) -> Reading:
        """Read a deck in the process."""
        self.here.send(path)
        if self.here.poll(HANG):
            found: Reading = self.here.recv()
            return found
        self.end()
        self.begin()
        return Reading(HANG, None, f"not read after {HANG:g} s", 0.0)

    def end(self) -> None:
        """Stop the process."""
        self.process.kill()
        self.process.join()


def read_paths(paths: Connection) -> None:
    """Read decks until the process is stopped."""
    while True:
        paths.send(timed(paths.recv()))


def run_apart(cases: Iterable[int], seed: int) -> Tally:
    """Run cases whose decks a process of its own reads."""
    reader = Reader()
    try:
        return run(cases, seed, reader)
    finally:
        reader.end()


def run_all(first: int, count: int, seed: int, workers: int) -> Tally:
    """Run cases first to first + count - 1 on some worker processes."""
    if workers == 1:
        return run_apart(range(first, first + count), seed)
    parts = [range(first + w, first + count, workers) for w in range(workers)]
    total = Tally()
    with ProcessPoolExecutor(workers) as pool:
        for part in pool.map(partial(run_apart, seed=seed), parts):
            total.results += part.results
            total.refusals += part.refusals
            total.slowest = max(total.slowest, part.slowest)
            total.broken += part.broken
            total.damage += part.damage
            total.megabytes = max(total.megabytes, part.megabytes)
    return total


def main() -> None:
    """Run the cases and print what came of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100_000)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--json", action="store_true")
    parser.add_argument("--quick", action="store_true", help="1,000 cases")
    options = parser.parse_args()
    count = min(options.count, 1000) if options.quick else options.count
    start = time.perf_counter()
    tally = run_all(options.first, count, options.seed, options.workers)
    seconds, case = tally.slowest
    told = f"{tally.results} results, {tally.refusals} refusals, {len(tally.broken)} broken of {count}"
    rows = [
        {"name": "slowest deck (s)", "ours": seconds, "peer": SECONDS, "ratio": SECONDS / seconds,
         "accuracy": f"case {case}; {told}", "cores": options.workers},
        {"name": "peak memory (MB)", "ours": tally.megabytes, "peer": MEGABYTES,
         "ratio": MEGABYTES / tally.megabytes, "accuracy": told, "cores": options.workers},
    ]  # fmt: skip
    if options.json:
        print(json.dumps(rows, indent=2))
    else:
        print(f"{told}, in {time.perf_counter() - start:.0f} s; damage: {dict(tally.damage)}")
        for row in rows:
            print(f"{row['name']:20} {row['ours']:8.3f} of {row['peer']:g} allowed; {row['accuracy']}")
        for case, text in tally.broken[:20]:
            print(f"case {case}: {text}")
    if tally.broken or seconds > SECONDS or tally.megabytes > MEGABYTES:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
