"""Damage to a document of bytes: what a fuzz case does to a seed, by a generator with the case's own key."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence

import numpy as np

NUMBERS = (
    "1e999", "-1e999", "1e308", "1e-400", "0", "-0", "nan", "inf", "1e", "1e+", "9" * 400, "9" * 5000, "0x10",
    "1meg", "1mil", "--1", ".", "1e308k", "1000000000000", "-1", "{1/0}", "{9^9^9^9}", "{sqrt(-1)}", "3",
    "2.5u", "10k", "4", "1.5", "42949672964294967296", "1_0", "true", "null", '"1"', "[]",
)  # fmt: skip
LONGEST = 3 * 2**20  # bytes

Damage = Callable[[bytes, np.random.Generator, Sequence[bytes]], bytes]


def damaged(
    key: Sequence[int], seeds: Sequence[bytes], table: Mapping[str, tuple[Damage, float]]
) -> tuple[bytes, list[str]]:
    """A seed with one to three kinds of damage, and their names; `table` has each with its weight."""
    random = np.random.default_rng(key)
    document = seeds[int(random.integers(len(seeds)))]
    weights = np.array([weight for _, weight in table.values()])
    done = []
    for _ in range(int(random.choice([1, 1, 1, 2, 3]))):
        name = str(random.choice(list(table), p=weights / weights.sum()))
        document = table[name][0](document, random, seeds)
        done.append(name)
    return document, done


def flip_bytes(document: bytes, random: np.random.Generator, seeds: Sequence[bytes]) -> bytes:
    """Other bytes at some places, of any value or printable."""
    data = bytearray(document)
    top = 256 if random.random() < 0.3 else 127
    for _ in range(int(random.integers(1, 12))):
        if data:
            data[int(random.integers(len(data)))] = int(random.integers(9 if top == 256 else 32, top))
    return bytes(data)


def move_lines(document: bytes, random: np.random.Generator, seeds: Sequence[bytes]) -> bytes:
    """Lines swapped, doubled or left out."""
    lines = document.split(b"\n")
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


def cut(document: bytes, random: np.random.Generator, seeds: Sequence[bytes]) -> bytes:
    """The beginning or the end only."""
    at = int(random.integers(len(document) + 1))
    return document[:at] if random.random() < 0.7 else document[at:]


def splice(document: bytes, random: np.random.Generator, seeds: Sequence[bytes]) -> bytes:
    """A word, or a piece of another document, in place of a word."""
    other = seeds[int(random.integers(len(seeds)))]
    words, theirs = document.split(b" "), other.split(b" ")
    for _ in range(int(random.integers(1, 5))):
        at = int(random.integers(len(words)))
        start, count = int(random.integers(len(theirs))), int(random.integers(1, 4))
        words[at : at + 1] = theirs[start : start + count]
    return b" ".join(words)


def change_numbers(document: bytes, random: np.random.Generator, seeds: Sequence[bytes]) -> bytes:
    """Numbers that are huge, tiny or none."""
    found = list(re.finditer(rb"[0-9][0-9.e+-]*", document))
    for _ in range(int(random.integers(1, 4))):
        if found:
            match = found[int(random.integers(len(found)))]
            number = NUMBERS[int(random.integers(len(NUMBERS)))].encode()
            document = document[: match.start()] + number + document[match.end() :]
            found = found[:1]
    return document


def lengthen(document: bytes, random: np.random.Generator, seeds: Sequence[bytes]) -> bytes:
    """A word, or the words of a line, many times over."""
    words = document.split(b" ")
    at = int(random.integers(len(words)))
    times = min(int(10 ** random.uniform(1, 5)), 1 + LONGEST // max(len(words[at]), 1))
    words[at] = words[at] * times if random.random() < 0.5 else b" ".join([words[at]] * times)
    return b" ".join(words)[:LONGEST]


def nest(document: bytes, random: np.random.Generator, seeds: Sequence[bytes]) -> bytes:
    """A word in brackets of brackets."""
    words = document.split(b" ")
    at, depth = int(random.integers(len(words))), int(10 ** random.uniform(0.5, 4.8))
    opened, closed = ((b"[", b"]"), (b"(", b")"), (b'{"a":', b"}"))[int(random.integers(3))]
    words[at] = opened * depth + words[at] + closed * depth * int(random.integers(2))
    return b" ".join(words)[:LONGEST]


def swap_words(document: bytes, random: np.random.Generator, seeds: Sequence[bytes]) -> bytes:
    """Quoted words, names and values of the document in each other's places."""
    found = list(re.finditer(rb'"[^"\n]*"|[\w.+-]+', document))
    for _ in range(int(random.integers(1, 4))):
        if len(found) > 1:
            i, j = (int(n) for n in random.integers(len(found), size=2))
            document = document[: found[i].start()] + found[j][0] + document[found[i].end() :]
            found = found[: min(i, j)]
    return document


def insert_line(document: bytes, random: np.random.Generator, line: bytes) -> bytes:
    """The document with a line more, anywhere."""
    lines = document.split(b"\n")
    lines.insert(int(random.integers(min(1, len(lines) - 1), len(lines))), line)
    return b"\n".join(lines)


COMMON: Mapping[str, tuple[Damage, float]] = {
    "flipped bytes": (flip_bytes, 3.0),
    "moved lines": (move_lines, 3.0),
    "cut": (cut, 1.0),
    "spliced words": (splice, 3.0),
    "swapped words": (swap_words, 3.0),
    "nesting": (nest, 1.0),
    "numbers": (change_numbers, 3.0),
    "long line": (lengthen, 0.5),
}
