"""Quantities over temperature and shared shift, from the record that is in force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.boards.centroid.model import circuits
from chips.measured.table_record import all_on_silicon, check_box, on_silicon, tables_of
from chips.record import Record, Table, kept_record, recorded
from circuits.blocks.sonar import centroid_board
from circuits.circuit import Circuit
from circuits.errors import DataError, ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon


@pytest.fixture
def doubled() -> Record:
    """The centroid board's record with twice the time of its leak."""
    shipped = kept_record("centroid_board")
    leak = shipped.tables["leak_time_s"]
    return shipped.extended({"leak_time_s": Table(leak.axes, 2.0 * leak.values)})


def _other() -> tuple[Circuit, ...]:
    return (centroid_board.build(centroid_board.Params(gate_resistance=6e3)),)


def test_another_circuit_is_refused() -> None:
    with pytest.raises(DataError, match="noctule characterise"):
        tables_of("centroid_board", _other, AMI_1500_IDEAL)


def test_another_process_is_refused() -> None:
    with pytest.raises(DataError, match="is of another circuit or process"):
        tables_of("centroid_board", circuits, replace(AMI_1500_IDEAL, v_dd=4.9))


def test_the_record_in_force_takes_the_place_of_the_one_that_is_kept(doubled: Record) -> None:
    kept = tables_of("centroid_board", circuits, AMI_1500_IDEAL)
    assert kept is tables_of("centroid_board", circuits, AMI_1500_IDEAL)
    with recorded("centroid_board", doubled):
        found = tables_of("centroid_board", circuits, AMI_1500_IDEAL)
    names = ("leak_time_s", "log_share")
    leak, share = all_on_silicon(kept, names, Silicon(AMI_1500_IDEAL))
    other_leak, other_share = all_on_silicon(found, names, Silicon(AMI_1500_IDEAL))
    assert float(leak) == pytest.approx(2.06, rel=0.01)
    assert float(other_leak) == pytest.approx(2.0 * float(leak), rel=1e-12)
    np.testing.assert_array_equal(share, other_share)
    np.testing.assert_array_equal(share, on_silicon(kept, "log_share", Silicon(AMI_1500_IDEAL)))
    assert tables_of("centroid_board", circuits, AMI_1500_IDEAL) is kept


def test_a_quantity_between_the_grid_lies_between() -> None:
    record = kept_record("centroid_board")
    at = [
        float(on_silicon(record, "log_far_default", Silicon(AMI_1500_IDEAL, temperature_c=t)))
        for t in (8.0, 17.0, 27.0)
    ]
    assert at == sorted(at)
    assert np.isfinite(at).all()


def test_the_box_is_the_record_s() -> None:
    record = kept_record("centroid_board")
    check_box("board", Silicon(AMI_1500_IDEAL, temperature_c=65.0, die=Die(number=3)), record)
    with pytest.raises(ParameterError, match=r"board\.temperature: 66 degC, must be -10 to 65 degC"):
        check_box("board", Silicon(AMI_1500_IDEAL, temperature_c=66.0), record)
    near = replace(record, box={"shift": (-1e-6, 1e-6)})
    with pytest.raises(ParameterError, match=r"board\.n\.shared_v_t0_shift: .* V, must be -1e-06 to 1e-06 V"):
        check_box("board", Silicon(AMI_1500_IDEAL, die=Die(number=3)), near)
