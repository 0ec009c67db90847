"""Studies give the same samples however they are run, and lose none."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from chips import record as records
from chips.ranging.chip import shipped_model
from chips.record import kept_record
from circuits.errors import DataError, ParameterError
from circuits.lowering.kernel import Machine
from circuits.silicon.die import Die
from system.options.silicon import SiliconChoice
from system.study import folder as study_folder
from system.study.engine import Outcome, on_threads, run_study
from system.study.folder import CHUNKS, study_table
from system.study.manifest import FILE, Study, read_study
from system.study.plan import Plan
from system.study.table import FAILED, Condition, Table
from system.study.target import Subject, open_target
from tests.killed import kill_when

ROOT = Path(__file__).resolve().parents[3]
HERE = "tests.system.study.test_engine"
CONDITION = Condition("random", 27.0, 0)


def threshold_sum(machine: Machine) -> float:
    """A quick metric: the sum of all thresholds; refuses one die, is not defined on another."""
    number = machine.silicon.die.number
    if number == 1003:
        raise ZeroDivisionError("no slope")
    return math.nan if number == 1004 else float(machine.kernel.transistors.v_t0.sum())


def slow_sum(machine: Machine) -> float:
    time.sleep(0.2)
    return threshold_sum(machine)


def deadly(machine: Machine) -> float:
    os.kill(os.getpid(), signal.SIGKILL)
    return 0.0


def study(count: int = 10, chunk: int = 3, metric: str = "threshold_sum", **plan: Any) -> Study:
    subject = Subject("rebound-neuron", (f"{HERE}:{metric}",), silicon=SiliconChoice(process_variation=False))
    return Study(
        subject, Plan(plan.get("method", "random"), 0, plan.get("first", 1000), count), (CONDITION,), chunk
    )


def run(wanted: Study, folder: Path | None = None, workers: int = 1, **options: Any) -> Outcome:
    with on_threads(workers) as made:
        return run_study(wanted, folder, workers=made, **options)


def same(a: Table, b: Table) -> bool:
    return (
        np.array_equal(a.die, b.die)
        and a.outcome == b.outcome
        and a.reason == b.reason
        and np.array_equal(a.values, b.values, equal_nan=True)
    )


@pytest.mark.parametrize("method", ["random", "lhs", "sobol"])
def test_workers_chunks_and_resumes_change_nothing(tmp_path: Path, method: str) -> None:
    wanted = study(method=method)
    once = run(wanted).table
    assert once.die.tolist() == list(range(1000, 1010))
    assert same(once, run(wanted, workers=2).table)
    assert same(once, run(wanted, workers=8).table)
    assert same(once, run(replace(wanted, chunk=4)).table)
    assert same(once, run(wanted, tmp_path / "a").table)
    again = run(wanted, tmp_path / "a", resume=True)
    assert same(once, again.table)
    assert again.chunks_read == 4
    assert same(once, study_table(tmp_path / "a"))
    assert read_study(tmp_path / "a", wanted.subject.metrics) == wanted


@pytest.mark.parametrize("method", ["random", "sobol"])
@pytest.mark.parametrize("chunk", [9, 17, 40])
def test_threads_that_share_a_chunk_change_nothing(method: str, chunk: int) -> None:
    # more dies than pieces, pieces that do not come out even, and a chunk larger than the study
    wanted = study(count=20, chunk=chunk, method=method)
    once = run(wanted).table
    assert once.die.tolist() == list(range(1000, 1020))
    assert same(once, run(wanted, workers=3).table)


def test_runs_in_lanes_change_nothing_whatever_goes_with_them() -> None:
    # the testbench's own numbers, of runs that go together, beside a number of each machine by itself
    subject = Subject("high-threshold-neuron", ("latency_s", f"{HERE}:threshold_sum"))
    conditions = (CONDITION, Condition("ss", 60.0, 0))
    wanted = Study(subject, Plan("random", 0, 1000, 40), conditions, 40)
    once = run(wanted).table
    assert same(once, run(replace(wanted, chunk=7), workers=2).table)
    assert once.die.tolist() == [n for n in range(1000, 1040) for _ in conditions]
    assert [once.reason[k] for k in (6, 7)] == ["ZeroDivisionError: no slope"] * 2
    target = open_target(subject)
    assert target.together > 1
    for k, number in ((0, 1000), (79, 1039)):
        alone = target.measure(Die(number=number, corner=once.corner[k]), conditions[k % 2])  # type: ignore[arg-type]
        assert alone.outcome == once.outcome[k]
        np.testing.assert_allclose(once.values[k], alone.values, rtol=1e-6)


def test_a_subset_and_a_longer_study_have_the_same_dies(tmp_path: Path) -> None:
    once = run(study(10)).table
    part = run(study(4, first=1002)).table
    np.testing.assert_array_equal(part.values, once.values[2:6])
    run(study(5), tmp_path)
    longer = run(study(10), tmp_path, resume=True)
    assert same(longer.table, once)
    assert longer.chunks_read == 1  # the second held two of its three dies
    assert longer.chunks_redone == ()


def test_failed_and_undefined_samples_are_kept_with_their_cause() -> None:
    table = run(study(5)).table
    assert table.outcome == ("measured",) * 3 + (FAILED, "measured")
    assert table.reason[3] == "ZeroDivisionError: no slope"
    assert np.isnan(table.values[3:, 0]).all()
    assert np.isfinite(table.values[:3, 0]).all()


def test_none_and_one_sample() -> None:
    assert len(run(study(0)).table) == 0
    assert len(run(study(1)).table) == 1


def test_conditions_are_inner_to_dies() -> None:
    conditions = tuple(Condition(c, t, 0) for c in ("typical", "ss") for t in (0.0, 27.0))
    table = run(replace(study(2), conditions=conditions)).table
    assert table.die.tolist() == [1000] * 4 + [1001] * 4
    assert table.corner[:4] == ("typical", "typical", "ss", "ss")
    assert table.temperature_c[:4].tolist() == [0.0, 27.0, 0.0, 27.0]
    # 1 mV/K of every threshold, and 0.1 V at the corner
    assert table.values[0, 0] > table.values[1, 0]
    assert table.values[3, 0] > table.values[1, 0] + 1.0


def test_a_broken_chunk_is_measured_again_and_told(tmp_path: Path) -> None:
    once = run(study(), tmp_path).table
    files = sorted((tmp_path / CHUNKS).iterdir())
    files[1].write_bytes(files[1].read_bytes()[:300])
    files[2].write_bytes(files[0].read_bytes())
    again = run(study(), tmp_path, resume=True)
    assert same(again.table, once)
    assert again.chunks_read == 2
    assert len(again.chunks_redone) == 2
    assert "cannot be read" in again.chunks_redone[0]
    assert "other samples than its name says" in again.chunks_redone[1]


def test_another_study_is_refused_with_what_differs(tmp_path: Path) -> None:
    run(study(4), tmp_path)
    with pytest.raises(ParameterError, match="has a study; add `resume`"):
        run(study(4), tmp_path)
    lot = replace(study(4).subject, silicon=SiliconChoice(process_variation=False, lot="B"))
    for other, text in (
        (replace(study(4), subject=lot), "subject.silicon.lot A, asked for B"),
        (study(4, method="lhs"), "plan.method random, asked for lhs"),
        (study(3), "plan.count 4, asked for 3"),
        (study(4, chunk=2), "chunk 3, asked for 2"),
        (replace(study(4), subject=replace(study(4).subject, params=("initial_voltage=1",))), "parameter"),
    ):
        with pytest.raises((ParameterError, LookupError), match=text):
            run(other, tmp_path, resume=True)
    sized = replace(study(4), subject=replace(study(4).subject, biases=("i_lim=5uA",)))
    with pytest.raises(ParameterError, match="has circuit"):
        run(sized, tmp_path, resume=True)
    with pytest.raises(ParameterError, match="no study to go on with"):
        run(study(4), tmp_path / "new", resume=True)


def test_a_rule_stops_at_the_same_sample_for_any_workers() -> None:
    for workers in (1, 2, 8):
        found = run(study(), workers=workers, stop=lambda table: 1004 in table.die)
        assert found.table.die.tolist() == list(range(1000, 1006))
        assert found.stopped


def test_a_full_disk_ends_in_one_line_and_leaves_what_was_done(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written = study_folder.write_table

    def full(path: Path, table: Table, units: Any, key: str) -> None:
        if "1006" in path.name:
            raise DataError(f"{path}: cannot be written, no space is left on the disk; free some")
        written(path, table, units, key)

    monkeypatch.setattr(study_folder, "write_table", full)
    with pytest.raises(DataError, match="no space is left"):
        run(study(), tmp_path)
    monkeypatch.undo()
    again = run(study(), tmp_path, resume=True)
    assert again.chunks_read == 2
    assert same(again.table, run(study()).table)


@pytest.fixture
def killed(tmp_path: Path) -> Path:
    """A study killed with signal 9 while it measured."""
    code = (
        "from pathlib import Path; from tests.system.study import test_engine as t;"
        f"t.run(t.study(metric='slow_sum'), Path({str(tmp_path)!r}))"
    )
    child = subprocess.Popen([sys.executable, "-c", code], cwd=ROOT)
    kill_when(child, lambda: len(list(tmp_path.glob(f"{CHUNKS}/0*.nc"))) >= 2)
    return tmp_path


def test_a_killed_study_goes_on_where_it_was(killed: Path) -> None:
    again = run(study(metric="slow_sum"), killed, resume=True)
    assert again.chunks_read in {2, 3}
    assert again.chunks_redone == ()
    assert same(again.table, run(study()).table)


def test_the_manifest_says_what_was_asked(tmp_path: Path) -> None:
    run(study(1), tmp_path, command=("noctule", "montecarlo"))
    document = json.loads((tmp_path / FILE).read_text(encoding="utf-8"))
    assert document["command"] == ["noctule", "montecarlo"]
    assert document["circuit"] == open_target(study().subject).identity()
    assert set(document["versions"]) >= {"noctule", "numpy", "numba"}
    (tmp_path / FILE).write_text("{", encoding="utf-8")
    with pytest.raises(DataError, match="broken"):
        run(study(1), tmp_path, resume=True)


def test_a_stale_record_ends_a_study_before_its_first_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    stale = replace(kept_record("rebound_neuron"), key="of another circuit")
    monkeypatch.setattr(records, "kept_record", lambda *_: stale)
    shipped_model.cache_clear()  # the record is read anew
    system = {"level": "behavioural", "duration": 0.1}
    wanted = Study(
        Subject("approach", ("calls",), system=system), Plan("random", 0, 1000, 3), (CONDITION,), 1
    )
    with pytest.raises(DataError, match="rebound_neuron_full: its record is of another circuit or process"):
        run(wanted)


def test_a_system_is_measured_on_its_dies() -> None:
    subject = Subject(
        "approach", ("calls", "range_error_mean_m"), system={"level": "behavioural", "duration": 0.5}
    )
    wanted = Study(subject, Plan("random", 0, 1000, 2), (CONDITION,), 1)
    table = run(wanted).table
    assert table.values[:, 0].min() > 1.0
    assert np.isnan(table.values[:, 1]).all()  # half a second is before errors count
    with pytest.raises(LookupError, match="metric charm: unknown"):
        run(replace(wanted, subject=replace(subject, metrics=("charm",))))


@pytest.mark.parametrize("name", ["samples.nc", "report.html", "chunks", "chunks/notes.nc", "study.json"])
def test_a_new_study_replaces_no_file_of_its_folder(tmp_path: Path, name: str) -> None:
    note = tmp_path / name
    note.parent.mkdir(exist_ok=True)
    note.write_text("mine")
    with pytest.raises(ParameterError, match=f"output: .* has .*{name.partition('/')[0]}|has a study"):
        run(study(), tmp_path)
    assert note.read_text() == "mine"
    assert list(note.parent.iterdir()) == [note]
    if name != "study.json":
        note.rename(tmp_path / "notes.txt")
        assert run(study(), tmp_path).chunks_read == 0  # other files are no matter
