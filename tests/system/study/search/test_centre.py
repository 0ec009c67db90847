"""A search for biases finds a known optimum, keeps the start where nothing beats it, and says what it did."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.sampling import labels
from system.cli.command_line import main
from system.study.search.centre import Budget, Centred, Problem, centre, objective
from system.study.specification import Classes, Limits, Specification
from system.study.table import Condition
from system.study.target import BlockTarget, Measurement, Quantity, Subject, Target
from tests.refusals import command_refusals

HERE = Condition("random", 27.0, 0)
BEST = np.array([0.5, -0.4])
SMALL = Budget(tuning=500, screening=100, population=10, generations=6, refinements=30)
PLACE = (("planted", ()),)
LIMITS = tuple(Limits(f"y{k}", -2.0, 2.0, "") for k in range(2))


class Planted(Target):
    """y_k = 4 (u_k - BEST_k) + z_k, and the word `works` where both are within 2 of zero."""

    def __init__(self, coordinates: F64) -> None:
        self._mean = 4.0 * (coordinates - BEST)

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        return Quantity("y0", ""), Quantity("y1", "")

    def labels(self) -> tuple[str, ...]:
        return tuple(labels(PLACE, [((f"m{k}", ()),) for k in range(2)], "v_t0"))

    def draws(self, die: Die) -> F64:
        return np.random.Generator(np.random.Philox(key=die.number)).standard_normal(2)

    def measure(self, die: Die, condition: Condition) -> Measurement:
        assert die.sampling is not None
        assert die.number is not None
        paths = [((f"m{k}", ()),) for k in range(2)]
        y = self._mean + die.sampling.draws(die.number, PLACE, paths, "v_t0", np.full(2, np.nan))
        return Measurement("works" if np.all(np.abs(y) < 2.0) else "off", tuple(y.tolist()))

    def identity(self) -> str:
        return "planted"


def search(specifications: tuple[Specification, ...], seed: int = 0) -> Centred:
    problem = Problem(Planted, 2, specifications, Die(), HERE)
    return centre(problem, budget=SMALL, seed=seed, workers=1)


def test_finds_the_planted_optimum_by_limits() -> None:
    found = search(LIMITS)
    # of 500 dies 5 % gain and 5 % lose by a shift of half a sigma, so that it is known to 0.3 sigma in y,
    # 0.07 in a coordinate; twice that
    assert found.coordinates == pytest.approx(BEST, abs=0.14)
    assert found.yield_before < 0.5
    # at the optimum erf(sqrt 2)^2 = 91 % pass, with a standard error of 1.3 % on 500 dies
    assert found.yield_after == pytest.approx(math.erf(math.sqrt(2.0)) ** 2, abs=0.04)
    assert found.measurements > 0
    assert found.impossible == 0


def test_finds_the_planted_optimum_by_words_alone() -> None:
    found = search((Classes(("works",)),))
    # a staircase, and 100 of the dies decide where its first stage ends
    assert found.coordinates == pytest.approx(BEST, abs=0.2)
    assert found.scale > 1.0


def test_the_same_for_any_number_of_workers_and_another_for_another_seed() -> None:
    few = replace(SMALL, tuning=60, screening=30, generations=2)
    problem = Problem(Planted, 2, LIMITS, Die(), HERE)
    one, two = (centre(problem, budget=few, workers=n) for n in (1, 2))
    other = centre(problem, budget=few, seed=1, workers=1)
    assert one.coordinates.tolist() == two.coordinates.tolist()
    assert one.measurements == two.measurements
    assert one.coordinates.tolist() != other.coordinates.tolist()


def test_keeps_the_start_where_nothing_beats_it() -> None:
    everything = (Limits("y0", -1e9, 1e9, ""),)
    found = centre(Problem(lambda _: Planted(BEST), 2, everything, Die(), HERE), budget=SMALL, workers=1)
    assert not found.coordinates.any()
    assert found.yield_before == found.yield_after == 1.0


def test_a_set_of_biases_that_cannot_be_counts_as_failing() -> None:
    def open_at(u: F64) -> Target:
        if u[0] > 0.3:
            raise ParameterError("i: too large, must be smaller; give less")
        return Planted(u)

    found = centre(Problem(open_at, 2, LIMITS, Die(), HERE), budget=SMALL, workers=1)
    assert found.impossible > 0
    assert found.coordinates[0] <= 0.3
    assert found.yield_after > found.yield_before


def test_nothing_to_move_and_nothing_to_fulfil_are_refused() -> None:
    for dimensions, specifications in ((0, LIMITS), (2, ())):
        with pytest.raises(ParameterError, match="`move` and `spec`"):
            centre(Problem(Planted, dimensions, specifications, Die(), HERE), budget=SMALL)


def test_margins_rank_what_all_dies_pass_and_what_none_does() -> None:
    spread, words = {"y0": 1.0}, ["works"]

    def value(x: float) -> float:
        return objective(LIMITS[:1], words, {"y0": np.array([x])}, spread)

    assert value(0.0) > value(1.0) > value(1.9) > value(2.5) > value(30.0) > value(90.0)
    assert value(math.nan) <= value(1e6)
    assert objective(LIMITS[:1], ["failed"], {"y0": np.array([0.0])}, spread) < 0.1
    assert objective((Classes(("works",)),), ["works", "off"], {}, {}) == 0.5


def test_the_command_improves_the_neuron_and_says_how(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, picture = tmp_path / "centred.json", tmp_path / "centred.png"
    arguments = [
        "centre", "rebound-neuron", "--spec", "class is works", "--tuning-dies", "6", "--fresh-dies", "6",
        "--generations", "0", "--no-process-variation", "--json", "-o", str(path), "--plot", str(picture),
    ]  # fmt: skip
    assert main(arguments) == 0
    document = json.loads(capsys.readouterr().out)
    assert document == json.loads(path.read_text())
    assert picture.stat().st_size > 1000
    assert document["search_level"] == "behavioural"
    assert document["search"]["share_after"] > document["search"]["share_before"]
    (fresh,) = document["fresh"]
    assert fresh["varied"] == "mismatch"
    for side in ("before", "after"):
        assert fresh[side]["samples"] == 6
        assert fresh[side]["interval"]["low"] <= fresh[side]["value"] <= fresh[side]["interval"]["high"]
    gained = fresh["difference"]["only_second_passes"] - fresh["difference"]["only_first_passes"]
    assert fresh["after"]["passed"] - fresh["before"]["passed"] == gained
    values = {m["name"]: m["after"] for m in document["moved"]}
    again = BlockTarget(Subject("rebound-neuron", ("best_delay",), biases=tuple(document["options"][1::2])))
    assert values == {n: again.choice.circuit.bias(n).value for n in values}


test_refused_in_one_line_before_any_work = command_refusals(
    "centre",
    "rebound-neuron",
    rows=[
        ("", "--spec"),
        ("--spec 'class is works' --tuning-dies 1001", "later dies are for the report"),
        ("--spec 'class is works' --first-fresh-die 999", "earlier dies are for the search"),
        ("--spec 'class is works' --move nothing", "bias nothing: unknown"),
        ("--spec 'class is works' --range 1", "--range"),
        ("--spec 'class is works' --no-mismatch --no-process-variation", "all dies are one"),
        ("--spec 'class is works' --plot x.txt", "--plot"),
    ],
)


def test_a_class_without_a_metric_to_tell_it_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["centre", "high-threshold-neuron", "--spec", "class is one-spike"]) != 0
    assert "--metric: whose run" in capsys.readouterr().err


def test_biases_move_by_the_gradient_and_few_runs(capsys: pytest.CaptureFixture[str]) -> None:
    """A pair's tail current is brought to where its limits are, with what varies about it."""
    asked = ["centre", "differential-pair", "--metric", "tail_A", "--spec", "tail_A in 25nA:45nA"]
    asked += ["--by", "gradient", "--move", "i_tail", "--tuning-dies", "20", "--fresh-dies", "20", "--json"]
    assert main([*asked, "--no-process-variation"]) == 0
    found = json.loads(capsys.readouterr().out)
    (moved,) = found["moved"]
    assert moved["change"] > 1.3  # from 17.8 nA
    assert found["search"]["yield_before"] == 0.0
    assert found["search"]["yield_after"] == 1.0
    assert found["fresh"][0]["after"]["passed"] >= 18
