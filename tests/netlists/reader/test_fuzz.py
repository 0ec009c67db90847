"""Damaged netlists: the cases of `benchmarks/netlist_fuzz.py`, some of them."""

import runpy
from pathlib import Path

FUZZ = runpy.run_path(str(Path(__file__).resolve().parents[3] / "benchmarks" / "netlist_fuzz.py"))
CASES = 500
FIRST = 1_000_000  # cases that the benchmark does not reach


def test_a_damaged_netlist_gives_a_result_or_one_line() -> None:
    tally = FUZZ["run"](range(FIRST, FIRST + CASES), seed=0)
    assert tally.broken == []
    assert tally.results + tally.refusals == CASES
    assert min(tally.results, tally.refusals) > 20  # both happen
    assert set(tally.damage) >= set(FUZZ["DAMAGE"]) - {"million lines"}


def test_every_seed_is_read_as_it_is(tmp_path: Path) -> None:
    FUZZ["make_root"](tmp_path)
    path = tmp_path / "root" / "deck.cir"
    for seed in FUZZ["seeds"]():
        path.write_bytes(seed)
        assert FUZZ["judge"](path) is None
