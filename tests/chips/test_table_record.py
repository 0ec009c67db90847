"""Every shipped record of a board belongs to today's circuit, and states its errors."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from chips.hearing.model import circuits
from chips.interpolation import monotone_cubic
from chips.latency import measure as latency_measurement
from chips.lso import measure as lso_measurement
from chips.measurement import MEASUREMENTS
from chips.selection import model as selection_model
from chips.table_record import (
    all_on_silicon,
    board_record,
    matching_record,
    matching_tables,
    on_silicon,
    record_errors,
    recorded,
    write_board_record,
)
from circuits.blocks.sonar import centroid_board, first_target_isolation, vocalization_controller
from circuits.circuit import Circuit
from circuits.errors import DataError
from circuits.silicon.process import AMI_1500
from circuits.silicon.silicon import Silicon

CIRCUITS: dict[str, tuple[Circuit, ...]] = {
    "centroid_board": (centroid_board.build(),),
    "vocalization_controller": (vocalization_controller.build(),),
    "hearing": circuits(),
    "first_target_isolation": (first_target_isolation.build(),),
    "winner_take_all": selection_model.circuits(),
    "latency_chip": latency_measurement.circuits(),
    "lso_neuron": lso_measurement.circuits(),
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


@pytest.mark.parametrize("points", [3, 5, 7])
def test_the_monotone_cubic_is_scipy_s(points: int) -> None:
    draw = np.random.Generator(np.random.Philox(points))
    for _ in range(30):
        knots = np.sort(draw.normal(size=points))
        table = draw.normal(size=(points, 3))
        table[:, 1] = np.sort(table[:, 1])  # monotone
        table[:, 2] = np.round(table[:, 2])  # flat in places
        peer = PchipInterpolator(knots, table)
        for x in (*knots, *draw.uniform(knots[0] - 0.1, knots[-1] + 0.1, 10)):
            found = np.empty(3)
            monotone_cubic(knots, table, float(x), found)
            # a few dozen roundings, beyond the ends of numbers that grow
            np.testing.assert_allclose(found, peer(x), rtol=1e-11, atol=1e-12)


def test_tables_are_those_of_the_record_in_force() -> None:
    def built() -> tuple[Circuit, ...]:
        return CIRCUITS["centroid_board"]

    shipped = matching_tables("centroid_board", built, AMI_1500)
    assert shipped is matching_tables("centroid_board", built, AMI_1500)
    data = board_record("centroid_board").copy(deep=True)
    assert shipped.errors == record_errors(data)
    data["leak_time_s"] *= 2.0
    with recorded("centroid_board", data):
        doubled = matching_tables("centroid_board", built, AMI_1500)
    names = ("leak_time_s", "log_share")
    leak, share = all_on_silicon(shipped.values, names, Silicon())
    other_leak, other_share = all_on_silicon(doubled.values, names, Silicon())
    assert float(other_leak) == pytest.approx(2.0 * float(leak), rel=1e-12)
    np.testing.assert_array_equal(share, other_share)
    assert share == pytest.approx(
        on_silicon(board_record("centroid_board"), "log_share", Silicon()), rel=1e-12
    )


def test_a_quantity_between_the_grid_lies_between() -> None:
    data = board_record("centroid_board")
    at = [float(on_silicon(data, "log_far_default", Silicon(temperature_c=t))) for t in (8.0, 17.0, 27.0)]
    assert at == sorted(at)
    assert np.isfinite(at).all()
