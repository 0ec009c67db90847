"""Campaigns: the same file from any interruption, and what is refused."""

import errno
import os
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from threading import Event, Timer
from typing import Any

import numpy as np
import pytest

from circuits.arrays import F32, F64, I64, Bools
from circuits.errors import DataError, ParameterError
from system.cli.command_line import main
from system.study import campaign_file, cluster
from system.study.campaign import Campaign, Execution, Numbered, Workers
from system.study.campaign_file import CutLine

KEYS = [Numbered("a", 1), Numbered("a", 2), Numbered("b", 1)]
Found = dict[str, str]
One = Callable[[Numbered], Found]


@pytest.fixture
def made() -> tuple[One, list[Numbered]]:
    """A run that notes what it was asked for."""
    asked: list[Numbered] = []

    def one(key: Numbered) -> Found:
        asked.append(key)
        return {"value": f"{key[0]}{0.1 * key[1]}"}

    return one, asked


def ours(one: One, mark: object = 1) -> Campaign[Numbered, Found]:
    return Campaign("ours", one, Numbered, Found, (mark,))


def runs(execution: Execution, one: One, mark: object = 1) -> list[Found]:
    return list(execution.results(ours(one, mark), KEYS))


def test_a_campaign_goes_on_where_it_was_interrupted(
    made: tuple[One, list[Numbered]], tmp_path: Path
) -> None:
    one, asked = made
    whole, part = tmp_path / "whole.jsonl", tmp_path / "part.jsonl"
    expected = runs(Execution(whole), one)
    begun = Execution(part).results(ours(one), KEYS)
    next(begun)
    begun.close()
    with part.open("a") as file:
        file.write('{"key": ["a", 2], "fo')  # killed while it wrote
    asked.clear()
    with pytest.warns(CutLine, match=r"part.jsonl: half a line at its end, 21 bytes, was cut off"):
        assert runs(Execution(part, resume=True), one) == expected
    assert asked == KEYS[1:]
    assert part.read_bytes() == whole.read_bytes()
    assert runs(Execution(whole, resume=True), one) == expected
    assert asked == KEYS[1:]  # none was made again


def test_an_endless_campaign_is_asked_as_far_as_needed(
    made: tuple[One, list[Numbered]],
) -> None:
    one, asked = made
    found = Execution().results(ours(one), (Numbered("a", k) for k in count()))
    assert [next(found)["value"] for _ in range(2)] == ["a0.0", "a0.1"]
    assert len(asked) == 2


def test_runs_handed_out_ahead_come_in_order(made: tuple[One, list[Numbered]], tmp_path: Path) -> None:
    one, asked = made

    class Late:
        def __init__(self, key: Numbered) -> None:
            self.key = key

        def add_done_callback(self, fn: Callable[[object], object], /) -> None:
            Timer(0.1 * KEYS[::-1].index(self.key), fn, (self,)).start()

        def result(self) -> Found:
            return one(self.key)

    late = Workers(lambda _, key: Late(key), 2, Event())
    file = tmp_path / "ahead.jsonl"
    assert runs(Execution(file, workers=lambda: nullcontext(late)), one) == runs(Execution(), one)
    assert asked == KEYS + KEYS
    late.asked.set()
    with pytest.raises(KeyboardInterrupt):
        runs(Execution(workers=lambda: nullcontext(late)), one)


def test_processes_get_runs_by_their_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[tuple[object, ...]] = []

    class Client:
        def submit(self, *arguments: object, pure: bool, retries: int) -> None:
            given.append((*arguments, pure, retries))

    monkeypatch.setattr(cluster, "_clients", lambda _, workers: nullcontext((Client(), workers)))
    with cluster.on_cluster(None, 3) as workers:
        workers.submit(len, ("a", 1))
    assert given == [(len, ("a", 1), False, cluster.RETRIES)]
    assert workers.ahead >= 3
    assert not workers.asked.is_set()


def test_what_is_not_its_own_is_refused(made: tuple[One, list[Numbered]], tmp_path: Path) -> None:
    one, _ = made
    file = tmp_path / "runs.jsonl"
    with pytest.raises(ParameterError, match=r"resume: .* is not there"):
        runs(Execution(file, resume=True), one)
    runs(Execution(file), one)
    with pytest.raises(ParameterError, match=r"output: .* is there; add `resume`"):
        runs(Execution(file), one)
    with pytest.raises(ParameterError, match="other numbers; name another file"):
        runs(Execution(file, resume=True), one, mark=2)
    with pytest.raises(DataError, match="cannot be written"):
        runs(Execution(tmp_path / "none" / "runs.jsonl"), one)


@dataclass(frozen=True)
class Side:
    """Of a coin."""

    heads: bool
    height: float
    marks: tuple[int, ...]


def side(key: Numbered) -> Side:
    heads: Any = np.bool_(key.number == 2)
    return Side(heads, np.float64(0.1) * key.number, (key.number, key.number + 1))


def test_a_result_is_of_its_type_from_the_file_too_and_numpys_numbers_are_kept(tmp_path: Path) -> None:
    file = tmp_path / "runs.jsonl"
    campaign = Campaign("ours", side, Numbered, Side)
    fresh = list(Execution(file).results(campaign, KEYS))
    assert list(Execution(file, resume=True).results(campaign, KEYS)) == fresh
    assert fresh[1] == Side(heads=True, height=0.2, marks=(2, 3))
    assert file.read_text().splitlines()[2] == (
        '{"key": ["a", 2], "found": {"heads": true, "height": 0.2, "marks": [2, 3]}}'
    )


@dataclass(frozen=True, eq=False)
class Course:
    """Arrays of several kinds."""

    volts: F64
    weights: F32 | None
    spikes: tuple[I64, Bools]


def course(key: Numbered) -> Course:
    volts = np.random.default_rng(key.number).normal(size=(2, 3))
    volts[0, 1] = np.nan
    weights = None if key.number == 1 else volts.astype(np.float32)
    return Course(volts, weights, (np.array([1, 2**62 + 1]), np.array([True, False])))


def test_arrays_come_from_the_file_as_they_were_to_the_bit(tmp_path: Path) -> None:
    file = tmp_path / "runs.jsonl"
    campaign = Campaign("ours", course, Numbered, Course)
    fresh = list(Execution(file).results(campaign, KEYS))
    for a, b in zip(fresh, Execution(file, resume=True).results(campaign, KEYS), strict=True):
        for one, other in zip((a.volts, a.weights, *a.spikes), (b.volts, b.weights, *b.spikes), strict=True):
            np.testing.assert_array_equal(one, other, strict=True)
    file.write_text(file.read_text().replace("[true, false]", "[true, [false, true]]"))
    with pytest.raises(DataError, match=r"runs.jsonl: line 2: found.spikes\[1\]: .*delete it"):
        list(Execution(file, resume=True).results(campaign, KEYS))


def test_earlier_runs_may_decide_which_come_next_and_more_keys_lengthen_a_file(
    made: tuple[One, list[Numbered]], tmp_path: Path
) -> None:
    one, asked = made
    file = tmp_path / "runs.jsonl"
    with Execution(file).open(ours(one)) as opened:
        assert list(opened.of(KEYS[:1])) == [{"value": "a0.1"}]
        assert list(opened.of(KEYS[:2])) == [{"value": "a0.1"}, {"value": "a0.2"}]
    assert asked == KEYS[:2]  # a run of this process is found as one of the file is
    with Execution(file, resume=True).open(ours(one)) as opened:
        longer = list(opened.of(KEYS))
    assert asked == KEYS
    assert longer == runs(Execution(), one)


OURS = '{"campaign": "ours", "mark": "1"}'


@pytest.mark.parametrize("resume", [False, True])
@pytest.mark.parametrize(
    "contents",
    [
        "",
        "\n",
        "a note",
        "notes\nof mine, and half a li",
        OURS,
        f"{OURS}\n",
        f"{OURS} and more\n",
        "[1]\n" * 3,
    ],
)
def test_a_foreign_file_is_refused_unchanged(
    made: tuple[One, list[Numbered]], tmp_path: Path, contents: str, *, resume: bool
) -> None:
    one, asked = made
    file = tmp_path / "notes.txt"
    file.write_text(contents)
    os.utime(file, ns=(10**18, 10**18))
    with pytest.raises(ParameterError, match=r"notes\.txt"):
        runs(Execution(file, resume=resume), one)
    assert (file.read_text(), file.stat().st_mtime_ns, asked) == (contents, 10**18, [])
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("resume", [False, True])
@pytest.mark.parametrize("kind", ["a folder", "a link", "a link to nothing", "a device or a pipe"])
def test_what_is_no_file_is_refused_unchanged(
    made: tuple[One, list[Numbered]], tmp_path: Path, kind: str, *, resume: bool
) -> None:
    one, asked = made
    own, path = tmp_path / "own.jsonl", tmp_path / "runs"
    runs(Execution(own), one)
    asked.clear()
    before = own.read_bytes(), own.stat().st_mtime_ns
    make: dict[str, Callable[[], object]] = {
        "a folder": path.mkdir,
        "a link": lambda: path.symlink_to(own),
        "a link to nothing": lambda: path.symlink_to(tmp_path / "none"),
        "a device or a pipe": lambda: os.mkfifo(path),
    }
    make[kind]()
    with pytest.raises(ParameterError, match=f"runs is {kind.removesuffix(' to nothing')}, must be a file"):
        runs(Execution(path, resume=resume), one)
    assert (own.read_bytes(), own.stat().st_mtime_ns) == before
    assert (sorted(tmp_path.iterdir()), asked) == ([own, path], [])
    with pytest.raises(ParameterError, match="/dev/null is a device"):
        runs(Execution(Path("/dev/null"), resume=resume), one)


def test_two_processes_do_not_write_into_one_file(made: tuple[One, list[Numbered]], tmp_path: Path) -> None:
    one, asked = made
    file = tmp_path / "runs.jsonl"
    first = Execution(file).results(ours(one), KEYS)
    next(first)
    second = Execution(file, resume=True).results(ours(one), KEYS)
    next(second)  # what the file has can be read
    asked.clear()
    with pytest.raises(ParameterError, match="another process is writing it"):
        next(second)
    third = Execution(file, resume=True).results(ours(one), KEYS)
    next(third)
    assert list(first) == runs(Execution(), one)[1:]
    with pytest.raises(ParameterError, match="another process wrote to it just now"):
        next(third)
    assert len(file.read_text().splitlines()) == 1 + len(KEYS)


def test_a_full_disk_leaves_no_file_without_a_first_line(
    made: tuple[One, list[Numbered]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, _ = made
    file = tmp_path / "runs.jsonl"

    def full(descriptor: int, data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(campaign_file.os, "write", full)
        with pytest.raises(DataError, match=r"runs.jsonl: cannot be written, No space left"):
            runs(Execution(file), one)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "line",
    [
        "[" * 50_000,
        '{"key": ["a", 1e999], "found": {}}',
        "[1]",
        '{"key": ["a", 1]}',
        '{"key": ["a", 1], "found": {"value": 1}}',
        '{"key": ["a"], "found": {"value": "1"}}',
    ],
)
def test_a_line_that_is_no_run_is_refused_by_its_number(
    made: tuple[One, list[Numbered]], tmp_path: Path, line: str
) -> None:
    one, _ = made
    file = tmp_path / "runs.jsonl"
    runs(Execution(file), one)
    with file.open("a") as opened:
        opened.write(f"{line}\n")
    before = file.read_bytes()
    with pytest.raises(DataError, match=r"runs.jsonl: line 5"):
        runs(Execution(file, resume=True), one)
    assert file.read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("wen2022-fig5 --resume", "resume: wen2022-fig5 is no campaign, it has none"),
        ("wen2022-fig5 --scheduler a:1", "scheduler: wen2022-fig5 is no campaign, it has none"),
        ("latency-dies --param forests=3", "param: forests, unknown to latency-dies; known are dies=100"),
        (
            "latency-forests --param forests=0",
            'param: forests "0", must be a whole number from 1 to 100000',
        ),
        ("latency-dies --param dies=100001", 'dies "100001", must be a whole number from 1 to 100000'),
        (f"latency-dies --param dies={'9' * 5000}", f'dies "{"9" * 20}", must be a whole number from 1 to'),
        ("agreement --param dies=1", "param: dies, unknown to agreement; it has none, leave it out"),
        ("latency-forests --param forests=2 --param network=3", "network: 3 forests, must be at most the 2"),
        ("latency-agreement --resume", "resume: needs the file of --output; add it"),
        ("latency-agreement --workers 0", "workers: 0, must be at least 1"),
    ],
)
def test_the_command_refuses_in_a_line(
    arguments: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["reproduce", *arguments.split()]) != 0
    found = capsys.readouterr().err
    assert words in found
    assert found.count("\n") == 1
