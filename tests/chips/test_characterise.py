"""What the characteriser measures at a point is what the shipped record holds; the command writes it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from chips import characterise as c
from chips.rebound_model import stimulated
from chips.record import Record, read_record, shipped_record
from circuits.blocks import rebound_neuron
from circuits.process import AMI_1500
from circuits.silicon import Silicon
from system.command_line import main
from system.commands import characterise as command


@pytest.mark.parametrize("task", c._TASKS, ids=lambda t: t.names[0])
def test_the_record_holds_what_is_measured(task: c._Task) -> None:
    record = shipped_record()
    i, j = 4, 2  # 100 pA, 27 degC
    silicon = Silicon(temperature_c=record.grid.temperature[j])
    found = task.measure(rebound_neuron.build(), silicon, record.grid.current[i], c.Perturb())
    for name, value in zip(task.names, found, strict=True):
        table = record.quantities[name].value
        # another machine's arithmetic may choose other steps: rtol of the solver times some
        assert value == pytest.approx(table[i if len(table) > 1 else 0, j], abs=1e-5)


def test_a_gradient_is_the_central_difference() -> None:
    record = shipped_record()
    q = record.quantities["threshold"]
    h = 10e-3
    values = [
        c._measure_firing(rebound_neuron.build(), Silicon(), 0.0, c.Perturb("comparator.mc1", s * h))[0]
        for s in (-1.0, 1.0)
    ]
    expected = q.gradient[0, 2, q.parameters.index("comparator.mc1.v_t0")]
    assert (values[1] - values[0]) / (2 * h) == pytest.approx(expected, abs=1e-3)
    assert expected == pytest.approx(-1.0, abs=1e-3)  # mc1 and mc2 see their gates against each other


def test_a_shared_deviation_moves_all_but_the_current_that_is_set() -> None:
    machine = stimulated(rebound_neuron.build(), Silicon())
    moved = c.Perturb("n", 10e-3).apply(machine).kernel.transistors
    before = machine.kernel.transistors
    shift = moved.v_t0 - before.v_t0
    assert np.count_nonzero(shift) == np.count_nonzero(before.sign > 0) - 1
    assert np.all(shift[before.sign < 0] == 0.0)


def test_the_errors_on_a_die_are_within_those_of_the_record() -> None:
    record = shipped_record()
    errors = c.held_out_errors(rebound_neuron.build(), AMI_1500, record, (500,))
    assert errors["margin_max_V"] <= record.errors["margin_max_V"] + 0.1e-3
    assert errors["release_relative_max"] <= record.errors["release_relative_max"] + 1e-5


def test_the_command_writes_a_record(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def quick(**_: object) -> Record:
        return shipped_record()

    monkeypatch.setattr(c, "characterise", quick)
    target = tmp_path / "record.nc"
    assert main(["characterise", "rebound-neuron", "-o", str(target), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["key"] == read_record(target).key
    assert main(["characterise", "rebound-neuron", "-o", str(target)]) == 0
    assert "margin_rms_V" in capsys.readouterr().out


def test_the_command_refuses_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["characterise", "dpi-synapse"]) == 2
    told = capsys.readouterr().err
    assert "characterised block dpi-synapse: unknown; known are axon-delay, centroid-board" in told
    assert all(name in told for name in ("hearing", "latency-chip", "rebound-neuron", "winner-take-all"))
    assert main(["characterise", "rebound-neuron", "--bias-set", "robust"]) == 2
    assert "the package's record has the errors at the block's own" in capsys.readouterr().err
    assert main(["characterise", "centroid-board", "--bias-set", "robust"]) == 2
    assert "has no named sets" in capsys.readouterr().err
    assert main(["characterise", "rebound-neuron", "-o", str(tmp_path)]) == 2
    assert "must be a file" in capsys.readouterr().err


def test_the_command_s_default_is_the_package_s_own() -> None:
    assert command.shipped_path("rebound-neuron").name == "rebound_neuron.nc"
    assert command.shipped_path("rebound-neuron").is_file()
