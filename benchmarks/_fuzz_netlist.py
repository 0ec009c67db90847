"""Damaged netlists: our own exports and hand-written decks, and damage that only netlists know.

Tricks with `.include`, wrong lines, parts in one another, a million lines. A refusal names file and
line, and nothing outside the deck's folder is read.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from _damage import COMMON, Damage, insert_line
from circuits.errors import DataError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from netlists.read import read_netlist
from netlists.read.summary import summarise
from netlists.registry import DIALECTS, Settings, load_dialect
from system.options.block import block_of_target

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
.model nch
+ nmos
.model pch pmos
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
MODELS = ".lib typical\n.model nfet nmos\n.endl\n.lib slow\n.model nfet nmos level=8 vth0=1\n.endl\n"
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
    "v9 1 2 5", "r9 1 1", "r1 in 1 10k", ".model", ".if (1)", ".tran 1u",
    ".model nch nmos (level=8)", ".tran 0 0",
    "vz 1 0 pulse(0 1 0 1n 1n 1n 2n)", "vy 1 0 sin(0 1 1e30)", "vx 1 0 pwl(0 0 0 1)", ".ic v(nowhere)=1",
    "x1 x2 x3", "= = =", "{", "}", "'", '"', "()", "r99 in 0 1k", "c99 out 0 1p", "* a comment",
    "r=1k", "c=1p", "g=1", "i a=1", ".func f(x) {f(x)}", ".func g(x) {g2(x)+g2(x)}", ".elseif (1)", ".else",
    ".lib typical", ".endl", "vw 2 3 0", "e1 1 0 2 0 2", "d1 1 2 nch", ".param a(x)={x}",
    ".step param w0 1u 2u 1u", ".options scale=1u",
)  # fmt: skip


def netlist_seeds() -> list[bytes]:
    """Decks to damage: hand-written ones, and our own with notes, in every dialect and on a die."""
    texts = [*HAND]
    written = [
        *(("vocalization-controller", None, dialect) for dialect in DIALECTS if dialect != "verilog-a"),
        ("rebound-neuron", 1003, "ngspice"),
        ("bias-generator", None, "ngspice"),
        ("ranging-chip", None, "ngspice"),
    ]
    for name, number, dialect in written:
        block = block_of_target(name)
        circuit = block.build()
        bench = block.testbench(circuit, block.defaults, 5.0)
        texts.append(
            load_dialect(dialect).write(bench, Silicon(AMI_1500_IDEAL, die=Die(number=number)), Settings())
        )
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


def nest_parts(deck: bytes, random: np.random.Generator, decks: Sequence[bytes]) -> bytes:
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


def include(deck: bytes, random: np.random.Generator, decks: Sequence[bytes]) -> bytes:
    """A trick with files."""
    return insert_line(deck, random, TRICKS[int(random.integers(len(TRICKS)))].encode())


def add_line(deck: bytes, random: np.random.Generator, decks: Sequence[bytes]) -> bytes:
    """A line that is wrong, or wrong where it stands."""
    return insert_line(deck, random, LINES[int(random.integers(len(LINES)))].encode())


def multiply(deck: bytes, random: np.random.Generator, decks: Sequence[bytes]) -> bytes:
    """A million lines and more."""
    lines = deck.split(b"\n")
    own = lines[int(random.integers(len(lines)))][:60]
    numbered = (b"r%d %d 0 1k" % (n, n) for n in range(1_000_000))
    body = b"\n".join(numbered) if random.random() < 0.5 else (own + b"\n") * 1_000_000
    return insert_line(deck, random, body)


def read_deck(path: Path) -> None:
    """Read a deck; a refusal that has no place, or speaks of what is outside, breaks the claim."""
    try:
        summarise(read_netlist(path).circuit)
    except DataError as error:
        if not ERROR.fullmatch(str(error)) or "r_outside" in str(error):
            raise RuntimeError(f"not one line with file and line: {str(error)[:300]!r}") from error
        raise


DAMAGE: Mapping[str, tuple[Damage, float]] = {
    **{name: COMMON[name] for name in COMMON if name not in {"swapped words", "nesting"}},
    "parts in parts": (nest_parts, 1.0),
    "includes": (include, 2.0),
    "wrong line": (add_line, 3.0),
    "million lines": (multiply, 0.02),
}
