"""A run that is kept is the run that was made, and any other deck or library is run anew."""

from __future__ import annotations

import os
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from circuits.errors import SimulatorError
from netlists.ngspice import library
from netlists.ngspice.run import Waveforms, run
from tests.agreement.kept import UNUSED, KeptRuns, key_of

pytestmark = pytest.mark.usefixtures("ngspice_library")

DECK = "rc\nv1 a 0 pulse(0 1 1u 1n 1n 5u 20u)\nr1 a b 1k\nc1 b 0 1n\n{}\n.end\n"
TRANSIENT, POINT = DECK.format(".tran 10n 10u"), DECK.format(".op")


def counted(folder: Path) -> tuple[KeptRuns, list[str]]:
    made: list[str] = []

    def make(deck: str, **options: Any) -> Waveforms:
        made.append(deck)
        return run(deck, **options)

    return KeptRuns(folder, make), made


def test_a_deck_is_run_once(tmp_path: Path) -> None:
    runs, made = counted(tmp_path)
    for deck in (TRANSIENT, POINT):
        first, again = runs(deck), runs(deck)
        for field in fields(Waveforms):
            one, other = getattr(first, field.name), getattr(again, field.name)
            if field.name == "values":
                assert list(one) == list(other)
                assert all(np.array_equal(one[name], other[name]) for name in one)
            else:
                assert np.array_equal(one, other)
    assert made == [TRANSIENT, POINT]
    runs(TRANSIENT.replace("1k", "2k"))
    runs(TRANSIENT, vectors=("b",))
    assert len(made) == 4


def test_another_library_runs_anew(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own, other = key_of(POINT, None), tmp_path / "libngspice.so"
    assert key_of(POINT, None) == own
    monkeypatch.setattr(library, "find_library", lambda: other)
    found = {own}
    for content in (b"another", b"and a newer one"):
        other.write_bytes(content)
        found.add(key_of(POINT, None))
    assert len(found) == 3


def test_a_run_that_fails_is_made_again_and_what_nobody_asks_for_goes(tmp_path: Path) -> None:
    runs, made = counted(tmp_path)
    for _ in range(2):
        with pytest.raises(SimulatorError):
            runs("t\nx1 a 0 missing\n.op\n.end\n")
    assert len(made) == 2
    runs(POINT)
    (path,) = tmp_path.iterdir()
    runs.drop_unused()
    assert path.exists()
    os.utime(path, (0.0, path.stat().st_mtime - 1.1 * UNUSED))
    runs.drop_unused()
    assert not path.exists()
