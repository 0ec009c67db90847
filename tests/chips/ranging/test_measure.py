"""What the characteriser measures at a point is what the shipped record holds; the command writes it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from chips.ranging import measure as c
from chips.ranging.model import model_of, stimulated
from chips.ranging.record import ReboundRecord, record_of
from chips.record import kept_record, read_record, write_record
from chips.record_file import ENVIRONMENT, cache_folder, record_file, shipped_file
from circuits.blocks.sonar import rebound_neuron
from circuits.errors import DataError, SolverError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from system.cli import characterise as command
from system.cli.command_line import main


@pytest.mark.parametrize("task", c._TASKS, ids=lambda t: t.names[0])
def test_the_record_holds_what_is_measured(task: c._Task) -> None:
    record = record_of()
    i, j = 4, 2  # 100 pA, 27 degC
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=record.grid.temperature[j])
    found = task.measure(rebound_neuron.build(), silicon, record.grid.current[i], c.Perturb())
    for name, value in zip(task.names, found, strict=True):
        table = record.quantities[name].value
        # another machine's arithmetic may choose other steps: rtol of the solver times some
        assert value == pytest.approx(table[i if len(table) > 1 else 0, j], abs=1e-5)


def test_a_gradient_is_the_central_difference() -> None:
    record = record_of()
    q = record.quantities["threshold"]
    h = 10e-3
    values = [
        c._measure_firing(
            rebound_neuron.build(), Silicon(AMI_1500_IDEAL), 0.0, c.Perturb("comparator.mc1", s * h)
        )[0]
        for s in (-1.0, 1.0)
    ]
    expected = q.gradient[0, 2, q.parameters.index("comparator.mc1.v_t0")]
    assert (values[1] - values[0]) / (2 * h) == pytest.approx(expected, abs=1e-3)
    assert expected == pytest.approx(-1.0, abs=1e-3)  # mc1 and mc2 see their gates against each other


def test_a_shared_deviation_moves_all_but_the_current_that_is_set() -> None:
    machine = stimulated(rebound_neuron.build(), Silicon(AMI_1500_IDEAL))
    moved = c.Perturb("n", 10e-3).apply(machine).kernel.transistors
    before = machine.kernel.transistors
    shift = moved.v_t0 - before.v_t0
    assert np.count_nonzero(shift) == np.count_nonzero(before.sign > 0) - 1
    assert np.all(shift[before.sign < 0] == 0.0)


def test_the_errors_on_a_die_are_within_those_of_the_record() -> None:
    record = record_of()
    errors = c.held_out_errors(rebound_neuron.build(), AMI_1500_IDEAL, record, (500,))
    assert errors["margin_max_V"] <= record.errors["margin_max_V"] + 0.1e-3
    assert errors["release_relative_max"] <= record.errors["release_relative_max"] + 1e-5


def test_the_command_writes_a_record(
    quick: ReboundRecord, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    target = tmp_path / "record.nc"
    assert main(["characterise", "rebound-neuron", "--law", "ideal", "-o", str(target), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["key"] == read_record(target).key
    assert printed["margin_V"] == 2.0 * printed["errors"]["margin_rms_V"] == quick.margin
    assert main(["characterise", "rebound-neuron", "--law", "ideal", "-o", str(target)]) == 0
    assert "margin_rms_V" in capsys.readouterr().out


def test_the_command_refuses_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["characterise", "dpi-synapse"]) == 2
    told = capsys.readouterr().err
    assert "model dpi-synapse: unknown; known are axon-delay, centroid-board" in told
    assert all(name in told for name in ("hearing", "latency-chip", "rebound-neuron", "winner-take-all"))
    assert main(["characterise", "rebound-neuron", "--law", "ideal", "--bias-set", "robust"]) == 2
    assert "a record that is read by itself has the errors at the block's own" in capsys.readouterr().err
    assert main(["characterise", "centroid-board", "--bias-set", "robust"]) == 2
    assert "has no named sets" in capsys.readouterr().err
    assert main(["characterise", "rebound-neuron", "--law", "ideal", "-o", str(tmp_path)]) == 2
    assert "must be a file" in capsys.readouterr().err


def test_a_block_without_any_die_that_can_be_measured_has_no_record(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def silent(*_: object) -> float:
        raise SolverError("rebound neuron: no release within 1 s; raise i_inh_tau")

    monkeypatch.setattr(c, "inhibition_time", silent)
    monkeypatch.setattr(c, "HELD_OUT", (500, 501))
    monkeypatch.setattr(c, "measure", lambda *_, **__: record_of())
    target = tmp_path / "record.nc"
    assert main(["characterise", "rebound-neuron", "--law", "ideal", "-o", str(target)]) != 0
    said = capsys.readouterr()
    assert said.err.splitlines() == [
        "noctule: rebound_neuron: none of dies (500, 501) could be measured; look at its biases"
    ]
    assert said.out == ""
    assert not target.exists()


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> ReboundRecord:
    """What is measured at once."""
    record = record_of()
    monkeypatch.setattr(c, "measure", lambda *_, **__: record)
    monkeypatch.setattr(c, "held_out_errors", lambda *_: dict(record.errors))
    return record


@pytest.fixture
def caches(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv(ENVIRONMENT, str(tmp_path / "caches"))
    kept_record.cache_clear()
    yield tmp_path / "caches" / "records" / "rebound_neuron.nc"
    kept_record.cache_clear()


def test_the_command_writes_into_the_caches_which_are_read_first(quick: ReboundRecord, caches: Path) -> None:
    shipped = shipped_file("rebound-neuron")
    before = shipped.read_bytes(), shipped.stat().st_mtime_ns
    assert record_file("rebound_neuron") == shipped
    assert main(["characterise", "rebound-neuron", "--law", "ideal"]) == 0
    assert record_file("rebound_neuron") == caches
    assert (shipped.read_bytes(), shipped.stat().st_mtime_ns) == before
    assert record_of().key == quick.key
    assert list(caches.parent.iterdir()) == [caches]


def test_a_stale_or_broken_record_of_the_caches_is_told(caches: Path) -> None:
    caches.parent.mkdir(parents=True)
    shipped = read_record(shipped_file("rebound_neuron"))
    write_record(replace(shipped, key="of another circuit"), caches)
    with pytest.raises(DataError, match=r"caches/records/rebound_neuron\.nc.*another circuit.*or delete it"):
        model_of(rebound_neuron.build(), AMI_1500_IDEAL)
    caches.write_bytes(b"no netCDF")
    kept_record.cache_clear()
    with pytest.raises(DataError, match=r"caches/records/rebound_neuron\.nc: no record, .*delete it"):
        model_of(rebound_neuron.build(), AMI_1500_IDEAL)


def test_the_packages_record_is_written_in_a_checkout_only(
    quick: ReboundRecord, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    installed = tmp_path / "chips" / "records" / "rebound_neuron.nc"
    installed.parent.mkdir(parents=True)
    monkeypatch.setattr(command, "shipped_file", lambda *_: installed)
    assert main(["characterise", "rebound-neuron", "--law", "ideal", "--update-package"]) == 2
    assert "is an installed package, must be a checkout" in capsys.readouterr().err
    assert not installed.exists()
    (tmp_path / "pyproject.toml").touch()
    assert main(["characterise", "rebound-neuron", "--law", "ideal", "--update-package", "-o", "a.nc"]) == 2
    assert "leave one out" in capsys.readouterr().err
    assert main(["characterise", "rebound-neuron", "--law", "ideal", "--update-package"]) == 0
    assert read_record(installed).key == quick.key


def test_caches_that_cannot_be_written_are_told_before_the_work(
    quick: ReboundRecord, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv(ENVIRONMENT, str(tmp_path / "file"))
    assert main(["characterise", "rebound-neuron", "--law", "ideal"]) == 2
    assert "cannot be made, Not a directory; give a file with -o" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("caches", "home", "folder"),
    [("/a", "/b", "/a/noctule"), ("a", "/b", "/b/.cache/noctule"), ("", "/b", "/b/.cache/noctule")],
)
def test_the_caches_are_where_the_platform_has_them(
    caches: str, home: str, folder: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(ENVIRONMENT)
    monkeypatch.setenv("XDG_CACHE_HOME", caches)
    monkeypatch.setenv("HOME", home)
    assert cache_folder() == Path(folder)
