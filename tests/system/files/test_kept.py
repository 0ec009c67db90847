"""Answers that are kept: once a machine, to the bit, and never older than what they follow from."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest

from circuits.arrays import F64
from system.files import kept as keeping
from system.files.kept import kept


@dataclass(frozen=True)
class Answer:
    rates: F64
    fires: np.ndarray[tuple[int, ...], np.dtype[np.bool_]]
    events: Mapping[int, float]
    words: tuple[str, ...] = ()


@dataclass
class Bench:
    """What is asked, and how often it computed."""

    folder: Path
    asked: list[tuple[object, ...]] = field(default_factory=list)

    def __call__(self, *asked: object) -> Answer:
        def compute() -> Answer:
            self.asked.append(asked)
            return ANSWER

        return kept("mine", asked, Answer, compute)

    @property
    def file(self) -> Path:
        (found,) = self.folder.iterdir()
        return found


NUMBERS = np.array([[0.1, np.nan], [-0.0, np.inf], [1e-310, 1 / 3]])
ANSWER = Answer(NUMBERS, np.array([True, False]), {-1: 0.1, 2: 3.0}, ("a",))


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Bench:
    monkeypatch.setattr(keeping, "answers_folder", lambda: tmp_path / "answers")
    return Bench(tmp_path / "answers")


def test_an_answer_is_computed_once_and_read_to_the_bit(bench: Bench) -> None:
    for found in (bench(1, "a"), bench(1, "a")):
        assert (found.rates.tobytes(), found.rates.shape) == (ANSWER.rates.tobytes(), (3, 2))
        assert (found.fires.tolist(), found.events, found.words) == ([True, False], {-1: 0.1, 2: 3.0}, ("a",))
    assert bench.asked == [(1, "a")]
    found.rates[0] = 0.0  # what is read is the caller's own
    assert bench(1, "a").rates[0, 0] == 0.1


def test_another_question_is_computed_by_itself(bench: Bench) -> None:
    many = np.arange(5000.0)  # numpy abbreviates what it shows of as many
    other = many.copy()
    other[2500] += 1e-9
    for each in (1, 2, "1", many, other, many):
        bench(each)
    assert [np.size(asked[0]) for asked in bench.asked] == [1, 1, 1, 5000, 5000]  # type: ignore[call-overload]


@pytest.mark.parametrize("changed", ["sources_of", "_computed_by"])
def test_after_a_change_of_what_it_follows_from_it_is_computed_anew(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, changed: str
) -> None:
    bench(1)
    monkeypatch.setattr(keeping, changed, lambda: "another")
    bench(1)
    assert len(bench.asked) == len(list(bench.folder.iterdir())) == 2


def cut(data: bytes) -> bytes:
    return data[:40]


def edited(data: bytes) -> bytes:
    return data.replace(b"\xa1a", b"\xa1b")


@pytest.mark.parametrize("damaged", [cut, edited])
def test_a_damaged_file_is_computed_and_written_again(
    bench: Bench, damaged: Callable[[bytes], bytes]
) -> None:
    bench(1)
    whole = bench.file.read_bytes()
    assert damaged(whole) != whole
    bench.file.write_bytes(damaged(whole))
    assert bench(1).words == ("a",)
    assert len(bench.asked) == 2
    assert bench.file.read_bytes() == whole


def test_where_nothing_can_be_written_nothing_is_kept(
    bench: Bench, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(keeping, "answers_folder", lambda: tmp_path / "file" / "answers")
    assert bench(1).words == bench(1).words == ("a",)
    assert len(bench.asked) == 2


def test_a_source_that_changes_is_another_digest(tmp_path: Path) -> None:
    own = tmp_path / "own.py"
    own.write_text("A = 1\n")
    first = keeping.sources_of.__wrapped__(tmp_path)
    own.write_text("A = 2\n")
    assert keeping.sources_of.__wrapped__(tmp_path) != first != keeping.sources_of()
