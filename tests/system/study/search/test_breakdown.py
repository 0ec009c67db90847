"""A planted dominant device comes first in a study's contributions, and tables sum to 100.0 %."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from circuits.lowering.kernel import Machine
from system.cli.command_line import main
from system.study.search.breakdown import share_rows
from system.study.statistics.contribution import UNEXPLAINED, VarianceShare

BLOCK = "rebound-neuron"
HERE = "tests.system.study.search.test_breakdown"
DOMINANT = "rebound_neuron.inhibition.mi5"
_DEVICE = 4


def planted(machine: Machine) -> float:
    """A positive metric that one threshold decides, with a slope on temperature."""
    v_t0 = machine.kernel.transistors.v_t0
    return math.exp(30.0 * float(v_t0[_DEVICE]) + float(v_t0.sum()))


def warm(machine: Machine) -> float:
    """Temperature has most of it."""
    t = machine.silicon.temperature_c
    return planted(machine) * math.exp(0.1 * (t - 27.0) + 30.0 * 0.001 * (t - 27.0))


def seldom(machine: Machine) -> float:
    """Defined on few dies."""
    return planted(machine) if (machine.silicon.die.number or 0) % 4 == 0 else math.nan


def constant(machine: Machine) -> float:
    """The same on all dies."""
    return 3.0


def far(machine: Machine) -> float:
    """Infinite on one die of four, and defined."""
    return math.inf if (machine.silicon.die.number or 0) % 4 == 0 else 2.0


@pytest.fixture
def run_json(capsys: pytest.CaptureFixture[str]) -> Callable[..., Any]:
    def call(metric: str, *arguments: str) -> Any:
        asked = ("--metric", f"{HERE}:{metric}", "--contributions", metric)
        assert main(("montecarlo", BLOCK, *asked, *arguments, "--json")) == 0
        return json.loads(capsys.readouterr().out, parse_constant=pytest.fail)["contributions"]

    return call


def test_the_planted_device_comes_first(run_json: Callable[..., Any], tmp_path: Path) -> None:
    picture = tmp_path / "pareto.png"
    (found,) = run_json("planted", "-n", "40", "--no-process-variation", "--pareto", str(picture))
    assert next(iter(found["by_device"])) == DOMINANT
    assert found["by_device"][DOMINANT] > 0.5
    assert found["by_parameter"]["beta"] == 0.0
    assert found["model"] == "gradients"
    assert found["logarithm"]
    assert found["r2"] > 0.999  # ln of it is linear
    for by in ("device", "parameter", "block", "process"):
        assert sum(found[f"by_{by}"].values()) == pytest.approx(1.0, abs=1e-12)
    assert picture.stat().st_size > 1000


def test_mismatch_and_process_are_told_apart(run_json: Callable[..., Any]) -> None:
    both, corner = run_json("planted", "-n", "40", "--corner", "random", "--corner", "ss")
    # the shared draws move 38 thresholds of about 5 mV and 30 times one
    assert both["by_process"]["process"] > 0.05
    assert set(corner["by_process"]) == {"mismatch", UNEXPLAINED}
    assert corner["corner"] == "ss"


def test_temperature_is_a_contributor(run_json: Callable[..., Any]) -> None:
    options = ("-n", "30", "--temperature", "20", "--temperature", "34", "--no-process-variation")
    cold, hot, both = run_json("warm", *options)
    assert cold["temperatures_C"] == [20.0]
    assert hot["temperatures_C"] == [34.0]
    assert both["temperatures_C"] == [20.0, 34.0]
    assert next(iter(both["by_process"])) == "temperature"
    assert both["by_process"]["mismatch"] > 0.01
    assert both["r2"] > 0.99


def test_the_printed_tables_sum_to_100(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ("--metric", f"{HERE}:planted", "--contributions", "planted")
    assert main(("montecarlo", BLOCK, "-n", "30", *asked)) == 0
    out = capsys.readouterr().out
    assert "R^2 1.000, 30 samples" in out
    for by in ("device", "parameter", "block", "process"):
        body = out.split(f"by {by}\n")[1].split("\n\n")[0]
        shares = [float(x) for x in re.findall(r"([\d.]+) %", body)]
        assert sum(shares) == pytest.approx(100.0, abs=1e-9)
        assert "unexplained" in body


def test_many_names_are_one_row() -> None:
    shares = [*(VarianceShare(f"m{k}", 0.07) for k in range(14)), VarianceShare(UNEXPLAINED, 0.02)]
    rows = share_rows(shares, 3)
    assert [name for name, _ in rows] == ["m0", "m1", "m2", "11 others", UNEXPLAINED]
    assert sum(float(text.split()[0]) for _, text in rows) == pytest.approx(100.0)


def test_what_cannot_be_broken_down_is_one_line(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    def refused(*arguments: str) -> str:
        assert main(("montecarlo", *arguments)) != 0
        error = capsys.readouterr().err
        assert error.count("\n") == 1
        return error

    own = (BLOCK, "--metric", f"{HERE}:planted")
    assert "is a system" in refused("approach", "--contributions", "calls", "--metric", "calls")
    assert "19 samples, must be >= 20" in refused(*own, "-n", "19", "--contributions", "planted")
    assert "metric charm" in refused(*own, "--contributions", "charm")
    assert "must come with --contributions" in refused(*own, "--pareto", str(tmp_path / "a.png"))
    assert "--pareto" in refused(*own, "--contributions", "planted", "--pareto", "a.bmp")


def test_a_metric_that_does_not_vary_has_no_contributions(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ("--metric", f"{HERE}:constant", "--contributions", "constant")
    assert main(("montecarlo", BLOCK, "-n", "20", *asked)) != 0
    caught = capsys.readouterr()
    assert "all 20 defined samples are equal" in caught.err
    assert "constant       20          0     3" in caught.out


def test_infinite_samples_are_told_as_such(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ("--metric", f"{HERE}:far", "--metric", f"{HERE}:seldom", "--spec", "far in 1:")
    assert main(("montecarlo", BLOCK, "-n", "8", *asked)) == 0
    lines = {line.split()[0]: line.split() for line in capsys.readouterr().out.splitlines() if line.strip()}
    assert lines["metric"][1:4] == ["defined", "undefined", "infinite"]
    assert (lines["far"][1:4], lines["seldom"][1:4]) == (["6", "0", "2"], ["2", "6", "0"])
    assert lines["yield"][1] == "100.00"


def test_too_few_defined_samples_lose_no_statistics(capsys: pytest.CaptureFixture[str]) -> None:
    asked = ("--metric", f"{HERE}:seldom", "--contributions", "seldom")
    assert main(("montecarlo", BLOCK, "-n", "40", *asked)) != 0
    caught = capsys.readouterr()
    assert "10 defined samples of 40, must be >= 20" in caught.err
    assert caught.err.count("\n") == 1
    assert "seldom       10         30" in caught.out
