"""Campaigns: the same file from any interruption, and what is refused."""

import errno
import os
from collections.abc import Callable
from contextlib import nullcontext
from itertools import count
from pathlib import Path
from threading import Event, Timer

import pytest

from circuits.errors import DataError, ParameterError
from system.cli.command_line import main
from system.study import campaign_file, cluster
from system.study.campaign import Campaign
from system.study.campaign_file import CutLine, Found, Key

KEYS = [("a", 1), ("a", 2), ("b", 1)]


@pytest.fixture
def made() -> tuple[Callable[[Key], Found], list[Key]]:
    """A run that notes what it was asked for."""
    asked: list[Key] = []

    def one(key: Key) -> Found:
        asked.append(key)
        return {"value": f"{key[0]}{0.1 * key[1]}"}

    return one, asked


def runs(campaign: Campaign, one: Callable[[Key], Found], mark: object = 1) -> list[Found]:
    return list(campaign.runs("ours", (mark,), one, KEYS))


def test_a_campaign_goes_on_where_it_was_interrupted(
    made: tuple[Callable[[Key], Found], list[Key]], tmp_path: Path
) -> None:
    one, asked = made
    whole, part = tmp_path / "whole.jsonl", tmp_path / "part.jsonl"
    expected = runs(Campaign(whole), one)
    begun = Campaign(part).runs("ours", (1,), one, KEYS)
    next(begun)
    begun.close()
    with part.open("a") as file:
        file.write('{"key": ["a", 2], "fo')  # killed while it wrote
    asked.clear()
    with pytest.warns(CutLine, match=r"part.jsonl: half a line at its end, 21 bytes, was cut off"):
        assert runs(Campaign(part, resume=True), one) == expected
    assert asked == KEYS[1:]
    assert part.read_bytes() == whole.read_bytes()
    assert runs(Campaign(whole, resume=True), one) == expected
    assert asked == KEYS[1:]  # none was made again


def test_an_endless_campaign_is_asked_as_far_as_needed(
    made: tuple[Callable[[Key], Found], list[Key]],
) -> None:
    one, asked = made
    found = Campaign().runs("ours", (), one, (("a", k) for k in count()))
    assert [next(found)["value"] for _ in range(2)] == ["a0.0", "a0.1"]
    assert len(asked) == 2


def test_runs_handed_out_ahead_come_in_order(
    made: tuple[Callable[[Key], Found], list[Key]], tmp_path: Path
) -> None:
    one, asked = made

    class Late:
        def __init__(self, key: Key) -> None:
            self.key = key

        def add_done_callback(self, fn: Callable[[object], object], /) -> None:
            Timer(0.1 * KEYS[::-1].index(self.key), fn, (self,)).start()

        def result(self) -> Found:
            return one(self.key)

    hands = (lambda _, key: Late(key), 2, Event())
    file = tmp_path / "ahead.jsonl"
    assert runs(Campaign(file, hands=lambda: nullcontext(hands)), one) == runs(Campaign(), one)
    assert asked == KEYS + KEYS
    stopped = (hands[0], 2, Event())
    stopped[2].set()
    with pytest.raises(KeyboardInterrupt):
        runs(Campaign(hands=lambda: nullcontext(stopped)), one)


def test_processes_get_runs_by_their_keys(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[tuple[object, ...]] = []

    class Client:
        def submit(self, *arguments: object, pure: bool, retries: int) -> None:
            given.append((*arguments, pure, retries))

    monkeypatch.setattr(cluster, "_clients", lambda _, workers: nullcontext((Client(), workers)))
    with cluster.workers_of(3) as (submit, ahead, asked):
        submit(len, ("a", 1))  # type: ignore[arg-type]
    assert given == [(len, ("a", 1), False, cluster.RETRIES)]
    assert ahead >= 3
    assert not asked.is_set()


def test_what_is_not_its_own_is_refused(
    made: tuple[Callable[[Key], Found], list[Key]], tmp_path: Path
) -> None:
    one, _ = made
    file = tmp_path / "runs.jsonl"
    with pytest.raises(ParameterError, match=r"--resume: .* is not there"):
        runs(Campaign(file, resume=True), one)
    runs(Campaign(file), one)
    with pytest.raises(ParameterError, match=r"--output: .* is there; add --resume"):
        runs(Campaign(file), one)
    with pytest.raises(ParameterError, match="other numbers; name another file"):
        runs(Campaign(file, resume=True), one, mark=2)
    with pytest.raises(DataError, match="cannot be written"):
        runs(Campaign(tmp_path / "none" / "runs.jsonl"), one)


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
    made: tuple[Callable[[Key], Found], list[Key]], tmp_path: Path, contents: str, *, resume: bool
) -> None:
    one, asked = made
    file = tmp_path / "notes.txt"
    file.write_text(contents)
    os.utime(file, ns=(10**18, 10**18))
    with pytest.raises(ParameterError, match=r"notes\.txt"):
        runs(Campaign(file, resume=resume), one)
    assert (file.read_text(), file.stat().st_mtime_ns, asked) == (contents, 10**18, [])
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("resume", [False, True])
@pytest.mark.parametrize("kind", ["a folder", "a link", "a link to nothing", "a device or a pipe"])
def test_what_is_no_file_is_refused_unchanged(
    made: tuple[Callable[[Key], Found], list[Key]], tmp_path: Path, kind: str, *, resume: bool
) -> None:
    one, asked = made
    own, path = tmp_path / "own.jsonl", tmp_path / "runs"
    runs(Campaign(own), one)
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
        runs(Campaign(path, resume=resume), one)
    assert (own.read_bytes(), own.stat().st_mtime_ns) == before
    assert (sorted(tmp_path.iterdir()), asked) == ([own, path], [])
    with pytest.raises(ParameterError, match="/dev/null is a device"):
        runs(Campaign(Path("/dev/null"), resume=resume), one)


def test_two_processes_do_not_write_into_one_file(
    made: tuple[Callable[[Key], Found], list[Key]], tmp_path: Path
) -> None:
    one, asked = made
    file = tmp_path / "runs.jsonl"
    first = Campaign(file).runs("ours", (1,), one, KEYS)
    next(first)
    second = Campaign(file, resume=True).runs("ours", (1,), one, KEYS)
    next(second)  # what the file has can be read
    asked.clear()
    with pytest.raises(ParameterError, match="another process is writing it"):
        next(second)
    third = Campaign(file, resume=True).runs("ours", (1,), one, KEYS)
    next(third)
    assert list(first) == runs(Campaign(), one)[1:]
    with pytest.raises(ParameterError, match="another process wrote to it just now"):
        next(third)
    assert len(file.read_text().splitlines()) == 1 + len(KEYS)


def test_a_full_disk_leaves_no_file_without_a_first_line(
    made: tuple[Callable[[Key], Found], list[Key]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one, _ = made
    file = tmp_path / "runs.jsonl"

    def full(descriptor: int, data: bytes) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr(campaign_file.os, "write", full)
        with pytest.raises(DataError, match=r"runs.jsonl: cannot be written, No space left"):
            runs(Campaign(file), one)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    "line", ["[" * 50_000, '{"key": ["a", 1e999], "found": {}}', "[1]", '{"key": ["a", 1]}']
)
def test_a_line_that_is_no_run_is_refused_by_its_number(
    made: tuple[Callable[[Key], Found], list[Key]], tmp_path: Path, line: str
) -> None:
    one, _ = made
    file = tmp_path / "runs.jsonl"
    runs(Campaign(file), one)
    with file.open("a") as opened:
        opened.write(f"{line}\n")
    before = file.read_bytes()
    with pytest.raises(DataError, match=r"runs.jsonl: line 5"):
        runs(Campaign(file, resume=True), one)
    assert file.read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("wen2022-fig5 --resume", "--resume: wen2022-fig5 is no campaign, it has none"),
        ("latency-dies --param forests=3", "--param: forests, unknown to latency-dies; known are dies=100"),
        (
            "latency-forests --param forests=0",
            '--param: forests "0", must be a whole number from 1 to 100000',
        ),
        ("latency-dies --param dies=100001", 'dies "100001", must be a whole number from 1 to 100000'),
        (f"latency-dies --param dies={'9' * 5000}", f'dies "{"9" * 20}", must be a whole number from 1 to'),
        ("latency-forests --param forests=2 --param network=3", "network: 3 forests, must be at most the 2"),
        ("latency-agreement --resume", "--resume: needs the file of --output; add it"),
        ("latency-agreement --workers 0", "--workers: 0, must be at least 1"),
    ],
)
def test_the_command_refuses_in_a_line(
    arguments: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["reproduce", *arguments.split()]) != 0
    found = capsys.readouterr().err
    assert words in found
    assert found.count("\n") == 1
