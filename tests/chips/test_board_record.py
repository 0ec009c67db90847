"""Every shipped record of a board belongs to today's circuit, and states its errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from chips.board_measurement import MEASUREMENTS
from chips.board_record import (
    board_record,
    matching_record,
    on_silicon,
    record_errors,
    recorded,
    write_board_record,
)
from chips.hearing_model import circuits
from circuits.blocks import centroid_board, first_target_isolation, vocalization_controller
from circuits.circuit import Circuit
from circuits.errors import DataError
from circuits.process import AMI_1500
from circuits.silicon import Silicon

CIRCUITS: dict[str, tuple[Circuit, ...]] = {
    "centroid_board": (centroid_board.build(),),
    "vocalization_controller": (vocalization_controller.build(),),
    "hearing": circuits(),
    "first_target_isolation": (first_target_isolation.build(),),
}


@pytest.mark.parametrize("block", MEASUREMENTS)
def test_no_record_is_stale(block: str) -> None:
    data = matching_record(block, CIRCUITS[block], AMI_1500)
    assert record_errors(data)


def test_another_circuit_is_refused() -> None:
    other = centroid_board.build(centroid_board.Params(gate_resistance=6e3))
    with pytest.raises(DataError, match="noctule characterise"):
        matching_record("centroid_board", (other,), AMI_1500)


def test_a_record_in_force_takes_the_place_of_the_shipped_one(tmp_path: Path) -> None:
    data = board_record("centroid_board").copy(deep=True)
    data["leak_time_s"] *= 2.0
    with recorded("centroid_board", data):
        found = matching_record("centroid_board", CIRCUITS["centroid_board"], AMI_1500)
        assert on_silicon(found, "leak_time_s", Silicon()) == pytest.approx(4.12, rel=0.01)
    write_board_record(data, {"some_V": 1.0}, tmp_path / "a.nc")
    assert (tmp_path / "a.nc").stat().st_size > 0


def test_a_quantity_between_the_grid_lies_between() -> None:
    data = board_record("centroid_board")
    at = [float(on_silicon(data, "log_far_default", Silicon(temperature_c=t))) for t in (8.0, 17.0, 27.0)]
    assert at == sorted(at)
    assert np.isfinite(at).all()
