"""A page that grows is written now and then, and never takes more than its share of the time."""

from __future__ import annotations

from pathlib import Path

import pytest

from system.cli import montecarlo
from system.cli.command_line import main
from system.study.report.growing import EVERY, Growing


class Clock:
    """A time that goes on when it is told to."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def test_slow_pages_are_written_seldom_and_the_last_one_waits_for_nothing() -> None:
    clock, pages, took = Clock(), [], [0.01, 1.0, 0.01, 0.01]

    def write(found: int, refresh: int) -> None:
        pages.append((found, refresh))
        clock.now += took[len(pages) - 1]

    growing = Growing(write, clock=clock)
    for k in range(1, 36):
        clock.now = max(clock.now, float(k))
        growing(k)
    # the second takes 1 s, so that the third has to wait for 20: a twentieth of the time
    assert pages == [(EVERY, EVERY), (11, EVERY), (32, EVERY)]
    growing.leave()
    assert pages[-1] == (35, 0)


def test_a_study_that_runs_has_a_page_of_what_it_has(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[str] = []
    write = montecarlo.write_so_far

    def watched(folder: Path, *rest: object) -> None:
        write(folder, *rest)  # type: ignore[arg-type]
        seen.append((folder / "report.html").read_text("utf-8"))

    monkeypatch.setattr(montecarlo, "write_so_far", watched)
    monkeypatch.setattr(montecarlo, "Growing", lambda write: Growing(write, first=0.0))
    folder = tmp_path / "study"
    words = ("-n", "12", "--chunk", "4", "--threads", "1", "--spec", "best_delay in 5ms:9ms")
    assert main(["montecarlo", "rebound-neuron", *words, "-o", str(folder)]) == 0
    first = seen[0]
    assert 'http-equiv="refresh" content="5"' in first
    assert "Not finished yet: 4 of 12 samples. Waveforms and contributions come with the last" in first
    assert "of 4 samples pass" in first
    assert "A/1000 to 1003" in first
    assert "die-100" in first
    assert "Waveforms of" not in first
    last = (folder / "report.html").read_text("utf-8")
    assert "refresh" not in last
    assert "Not finished" not in last
    assert "Waveforms of" in last
