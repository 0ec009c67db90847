"""Damaged inputs: some cases of `benchmarks/fuzz.py`, and seeds that once ended in a traceback or never."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from system.cli.command_line import BAD_INPUT, main
from tests.benchmark import benchmark

ROOT = Path(__file__).resolve().parents[1]
CASES = {"netlist": 300}
FEW = 40  # cases of another kind
FIRST = 1_000_000  # cases that the benchmark does not reach
BRACKETS = "[" * 50_000
MAPPING = (ROOT / "tests" / "netlists" / "foundry" / "data" / "half.toml").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def fuzz() -> Any:
    with benchmark("fuzz") as found:
        yield found


def test_damaged_netlists_give_results_and_refusals(fuzz: Any) -> None:
    tally = fuzz.run("netlist", range(FIRST, FIRST + 300), seed=0)
    assert tally.broken == []
    assert min(tally.results, tally.refusals) > 10
    assert set(tally.damage) >= set(fuzz.INPUTS["netlist"].damage) - {"million lines"}


def test_whatever_is_damaged_gives_a_result_or_one_line(fuzz: Any) -> None:
    for kind in fuzz.INPUTS:
        if kind not in {"netlist", "command line", "command"}:
            tally = fuzz.run(kind, range(FIRST, FIRST + FEW), seed=0)
            assert tally.broken == [], kind
            assert tally.results + tally.refusals == FEW


@pytest.mark.parametrize(
    ("kind", "cases"),
    [
        ("scene", (93, 3408)),
        ("ROLLS biases", (114,)),
        ("ROLLS program", (435,)),
        ("process", (63, 138)),
        ("record", (3161,)),
        ("columns", (57, 281)),
    ],
)
def test_cases_that_once_were_a_traceback(fuzz: Any, kind: str, cases: tuple[int, ...]) -> None:
    tally = fuzz.run(kind, cases, seed=0)
    assert (tally.broken, tally.refusals) == ([], len(cases))


def test_no_damage_makes_a_document_longer_than_the_longest(fuzz: Any) -> None:
    damage = sys.modules["_damage"]
    for k in range(40):
        found = damage.lengthen(b"x" * 2**20, np.random.default_rng(k), ())  # once: times 100,000
        assert 2**20 < len(found) <= damage.LONGEST


def test_commands_by_hand_are_as_many_as_asked(
    fuzz: Any, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ran: list[object] = []
    fine = fuzz.Reading((), 1.0, 1.0, refused=False, broken=None)
    monkeypatch.setattr(fuzz, "_by_hand", lambda *words: ran.append(words) or fine)
    monkeypatch.setattr(fuzz, "run_apart", lambda *_: pytest.fail("read in a process of its own"))
    only = ["fuzz.py", "--only", "command line"]
    monkeypatch.setattr(sys, "argv", [*only, "--command-line", "3", "--workers", "2"])
    assert fuzz.main() == 0
    assert len(ran) - len(fuzz.INPUTS["command line"].begin(Path())) == 3  # after each seed once
    assert "3 results, 0 refusals, 0 broken" in capsys.readouterr().out
    monkeypatch.setattr(sys, "argv", only)
    with pytest.raises(SystemExit):
        fuzz.main()
    assert "needs --command-line N" in capsys.readouterr().err


def test_every_deck_is_read_as_it_is(fuzz: Any, tmp_path: Path) -> None:
    reader = fuzz.Reader(fuzz.INPUTS["netlist"], 0, tmp_path)
    assert len(reader.seeds) > 1
    for seed in reader.seeds:
        reader.path.write_bytes(seed)
        reader.kind.read(reader.path)  # raises what is wrong


FILES = {
    "r.cir": "title\nr=1k\n.end\n",
    "c.cir": "title\nc=1p\n.end\n",
    "g.cir": "title\ng=1\n.end\n",
    "deep/study.json": BRACKETS,
    "wrong/study.json": '{"format": 1, "subject": 3, "plan": [], "conditions": {"a": 1}, "chunk": "many"}',
    "brackets.jsonl": f'{{"campaign": "latency-dies", "mark": "x"}}\n{BRACKETS}\n',
    "key.jsonl": '{"campaign": "latency-dies", "mark": "x"}\n{"key": ["a", 1e999], "found": {}}\n',
    "deep.toml": f"summary = {BRACKETS}",
    "long.toml": f"duration = {'9' * 5000}",
    "infinite.toml": MAPPING.replace("v_dd = 3.3", "v_dd = 1e999"),
    "huge.toml": MAPPING.replace("v_dd = 3.3", f"v_dd = {'9' * 400}"),
}
RESUMED = ("reproduce", "latency-dies", "--param", "dies=1", "--resume", "-o")
HUGE = str(2**65)


@pytest.mark.parametrize(
    "arguments",
    [
        ("import", "r.cir"),
        ("import", "c.cir"),
        ("import", "g.cir"),
        ("replay", "deep", "--die", "1000"),
        ("replay", "wrong", "--die", "1000"),
        ("show", "rebound-neuron", "--study", "deep", "--die", "1000"),
        (*RESUMED, "brackets.jsonl"),
        (*RESUMED, "key.jsonl"),
        ("simulate", "rebound-neuron", "--at", f"ranging-chip/neuron[{'9' * 5000}]"),
        ("export", "latency-chip", "-o", "x.cir", "--param", f"synapses={HUGE}"),
        ("run", "pushbot", "--scene", "deep.toml"),
        ("run", "pushbot", "--scene", "long.toml"),
        ("export", "rebound-neuron", "-o", "x.cir", "--mapping", "deep.toml"),
        ("export", "rebound-neuron", "-o", "x.cir", "--mapping", "long.toml"),
        ("export", "rebound-neuron", "-o", "x.cir", "--mapping", "infinite.toml"),
        ("export", "rebound-neuron", "-o", "x.cir", "--mapping", "huge.toml"),
        ("show", "rebound" * 5000),
        ("montecarlo", "rebound-neuron", "--spec", "best_delay\nin\n1ms"),
    ],
    ids=lambda arguments: " ".join(arguments)[:60],
)
def test_once_a_traceback_now_a_line(
    arguments: tuple[str, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    assert main(arguments) == BAD_INPUT
    said = capsys.readouterr()
    assert len(said.err.splitlines()) == 1
    assert said.out == ""
