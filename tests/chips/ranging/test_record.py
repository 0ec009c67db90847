"""The shipped record is of today's circuit, and a record survives its file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.ranging.record import GRID, Grid, rebound_key, rebound_record, record_of, to_record
from chips.record import kept_record
from chips.record_file import measured_by, shipped_file
from circuits.blocks.sonar import rebound_neuron
from circuits.errors import DataError
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL, Process

BOTH = pytest.mark.parametrize("process", [AMI_1500_IDEAL, AMI_1500], ids=lambda p: p.effects)


@BOTH
def test_the_record_of_is_not_stale(process: Process) -> None:
    key = rebound_key(rebound_neuron.build(), process, GRID)
    assert record_of(process).key == key, f"run: {measured_by('rebound-neuron', process)} --update-package"
    assert record_of(process).grid == GRID


@BOTH
def test_the_record_of_is_small_and_names_its_errors(process: Process) -> None:
    record = record_of(process)
    assert shipped_file("rebound-neuron", process).stat().st_size < 1e6
    assert record.errors["dies"] >= 30
    assert record.errors["first_die"] < 1000  # dies from 1000 on are for reports
    assert 0.0 < record.margin == 2.0 * record.errors["margin_rms_V"] < 2e-3


def test_what_is_measured_anew_changes_the_key() -> None:
    neuron = rebound_neuron.build()
    keys = {
        rebound_key(neuron, AMI_1500_IDEAL, GRID),
        rebound_key(neuron, AMI_1500_IDEAL, Grid(GRID.current, (0.0, 27.0))),
        rebound_key(neuron, replace(AMI_1500_IDEAL, v_dd=3.3), GRID),
        rebound_key(
            rebound_neuron.build(rebound_neuron.Params(rebound_capacitance=500e-15)), AMI_1500_IDEAL, GRID
        ),
    }
    assert len(keys) == 4
    rebiased = replace(neuron, biases=neuron.biases[:1])
    assert rebound_key(rebiased, AMI_1500_IDEAL, GRID) in keys


def test_the_model_s_record_is_the_file_s() -> None:
    rebound = record_of()
    kept, again = kept_record("rebound_neuron"), to_record(rebound)
    assert (again.key, again.axes, again.errors, again.box) == (kept.key, kept.axes, kept.errors, kept.box)
    assert set(again.tables) == set(kept.tables)
    for name, table in kept.tables.items():
        assert table.axes == again.tables[name].axes
        assert np.array_equal(table.values, again.tables[name].values)


def test_another_record_is_refused() -> None:
    with pytest.raises(DataError, match="i_inh_tau: no axis of numbers"):
        rebound_record(kept_record("centroid_board"))
