"""`--ic`, `--uic`, `--at-rest`, and what a run tells of its own accord."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

from circuits.blocks.block import Block, Stimulus, Values
from circuits.circuit import Circuit
from circuits.registry import BLOCKS
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from netlists.read import read_netlist
from system.cli.command_line import main
from system.options.begin import FREE, begin_choice
from system.options.begun import begun
from tests.circuits.solver.oscillators import OSCILLATORS

RING = OSCILLATORS["ring"](AMI_1500_IDEAL, 3, 30e-9)
HERE = "tests.system.options.test_begin"


@dataclass(frozen=True, slots=True)
class Params:
    """Nothing to choose."""


def _ring(params: Params = Params()) -> Circuit:
    return RING.circuit


def _testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    return replace(RING, circuit=circuit)


def _deaf(params: Params = Params()) -> Circuit:
    """The ring, its events counted where it never comes."""
    ports = tuple(replace(p, threshold=7.0) if p.name == "spike" else p for p in RING.circuit.ports)
    return replace(RING.circuit, ports=ports)


def _count(result: Result) -> dict[str, float | None]:
    return {"count": float(result.spikes["spike"].size)}


BLOCK = Block(
    "free-ring", "rings", _ring, tuple[Stimulus, ...](), _testbench, _count,
    lambda result: "rings" if result.spikes["spike"].size else "silent",
)  # fmt: skip
DEAF = replace(BLOCK, name="deaf-ring", build=_deaf)


@pytest.fixture(autouse=True)
def _blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(BLOCKS, "free-ring", f"{HERE}:BLOCK")
    monkeypatch.setitem(BLOCKS, "deaf-ring", f"{HERE}:DEAF")


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Callable[..., str]:
    def call(*arguments: str) -> str:
        assert main(arguments) == 0, capsys.readouterr().err
        return capsys.readouterr().out

    return call


def test_a_start_from_an_unstable_point_is_told(run: Callable[..., str]) -> None:
    text = run("simulate", "free-ring")
    told = "the operating point is not stable: the run begins with 10 mV added at spike; --at-rest keeps it"
    assert text.count(told) == 1
    found = json.loads(run("simulate", "free-ring", "--json"))
    assert found["disturbance"] == {"nodes": ["spike"], "voltage_V": 0.01}
    assert found["uncrossed"] == {}
    assert len(found["spikes_s"]) >= 6


def test_at_rest_keeps_it_there(run: Callable[..., str]) -> None:
    assert "--at-rest keeps the run there" in run("simulate", "free-ring", "--at-rest")
    found = json.loads(run("simulate", "free-ring", "--at-rest", "--json"))
    assert found["disturbance"] is None
    assert found["spikes_s"] == []
    assert found["outcome"] == "silent"


def test_what_is_stable_has_nothing_to_tell(run: Callable[..., str]) -> None:
    arguments = ("simulate", "rebound-neuron", "--stimulus", "duration=2ms")
    found = json.loads(run(*arguments, "--json"))
    assert found["disturbance"] is None
    assert found["uncrossed"] == {}
    assert "stable" not in run(*arguments)


def test_op_says_how_a_run_would_begin(run: Callable[..., str]) -> None:
    assert "leaves it, and a run begins with 10 mV added at spike" in run("op", "free-ring")
    assert json.loads(run("op", "free-ring", "--json"))["disturbance"]["nodes"] == ["spike"]


def test_a_study_starts_and_tells_it(run: Callable[..., str]) -> None:
    arguments = ("montecarlo", "free-ring", "--metric", "count", "-n", "2")
    assert "nominal die: the operating point is not stable: the run begins with 10 mV" in run(*arguments)
    found = json.loads(run(*arguments, "--json"))
    assert min(found["values"]["count"]) >= 6
    assert found["disturbance"]["nodes"] == ["spike"]
    kept = json.loads(run(*arguments, "--at-rest", "--json"))
    assert kept["values"]["count"] == [0.0, 0.0]


def test_a_study_holds_voltages_and_keeps_them(run: Callable[..., str], tmp_path: Path) -> None:
    folder = tmp_path / "study"
    arguments = ("montecarlo", "free-ring", "--metric", "count", "-n", "1", "-o", str(folder))
    run(*arguments, "--ic", "spike=5V")
    assert json.loads((folder / "study.json").read_text())["subject"]["held"] == ["spike=5V"]
    assert "identical to what was kept" in run("replay", str(folder), "--die", "1000")
    assert main((*arguments, "--resume")) == 2  # without it, it is another study
    run(*arguments, "--ic", "spike=5V", "--resume")


def test_a_study_without_it_says_nothing_of_it(run: Callable[..., str], tmp_path: Path) -> None:
    run("montecarlo", "free-ring", "--metric", "count", "-n", "1", "-o", str(tmp_path / "study"))
    subject = json.loads((tmp_path / "study" / "study.json").read_text())["subject"]
    assert not {"held", "begin"} & set(subject)


def test_noise_starts_it_and_is_told(run: Callable[..., str]) -> None:
    arguments = ("simulate", "free-ring", "--analysis", "tran-noise", "--step", "20ps")
    assert "not stable: the run begins with the noise of the first step" in run(*arguments)


def test_held_voltages_hold(run: Callable[..., str], tmp_path: Path) -> None:
    path = tmp_path / "waves.csv"
    run("simulate", "free-ring", "--ic", "spike=4.5V", "--ic", "v1=0V", "--csv", str(path))
    names, first = path.read_text().splitlines()[:2]
    row = dict(zip(names.split(","), map(float, first.split(",")), strict=True))
    assert (row["spike_V"], row["v1_V"]) == (4.5, 0.0)
    run("simulate", "free-ring", "--uic", "--ic", "v1=2V", "--csv", str(path))


def test_a_signal_that_never_counts_is_told(run: Callable[..., str]) -> None:
    text = run("simulate", "deaf-ring")
    assert "spike: swings between" in text
    assert "never crosses its threshold of 7 V" in text
    found = json.loads(run("simulate", "deaf-ring", "--json"))["uncrossed"]["spike"]
    assert found["threshold_V"] == 7.0
    assert found["high_V"] > 4.5
    study = json.loads(run("montecarlo", "deaf-ring", "--metric", "count", "-n", "1", "--json"))
    assert study["uncrossed"]["spike"]["threshold_V"] == 7.0


def test_an_export_begins_as_it_is_told(run: Callable[..., str]) -> None:
    deck = run("export", "free-ring", "-o", "-", "--ic", "v1=1V")
    assert ".ic v(xring_of_3.v1)=1.0\n" in deck
    assert read_netlist(deck).testbench.initial == {"v1": 1.0}
    assert " uic\n" in run("export", "free-ring", "-o", "-", "--ic", "v1=1V", "--uic")


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("simulate", "free-ring", "--ic", "v1=1V", "--at-rest"), "--at-rest: together with --ic"),
        (("simulate", "free-ring", "--uic", "--at-rest"), "--at-rest: together with --uic"),
        (("simulate", "free-ring", "--ic", "v9=1V"), "node v9: unknown"),
        (("simulate", "free-ring", "--ic", "v1"), "must be NAME=VALUE"),
        (("simulate", "free-ring", "--ic", "vdd=1V"), "vdd: initial 1 V, but a source holds it at 5 V"),
        (("simulate", "free-ring", "--at-rest", "--engine", "ngspice"), "--at-rest: ngspice leaves"),
        (("simulate", "free-ring", "--analysis", "ac", "--ic", "v1=1V"), "--ic: not of --analysis ac"),
        (("simulate", "free-ring", "--analysis", "tran-noise", "--at-rest"), "--at-rest: not of --analysis"),
        (("montecarlo", "approach", "--ic", "v1=1V", "-n", "1"), "--ic: of a block's testbench"),
        (("export", "rolls", "-o", "-", "--ic", "v1=1V"), "--ic: of a block's testbench, not of rolls"),
    ],
)
def test_what_makes_no_sense_is_refused(
    arguments: tuple[str, ...], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1


def test_what_is_not_said_leaves_the_testbench_alone() -> None:
    assert begun(RING, FREE) is RING
    own = replace(RING, initial={"v1": 1.0}, begin="uic")
    assert begun(own, begin_choice(["v2=2V"])).initial == {"v1": 1.0, "v2": 2.0}
    assert begun(own, begin_choice(["v2=2V"])).begin == "uic"
    wanted: Any = begun(RING, begin_choice([], at_rest=True))
    assert wanted.begin == "at_rest"
