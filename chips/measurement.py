"""Measurement of a board's or the hearing's record: what is measured, then its errors on other dies."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import xarray as xr

from chips.boards.centroid import measure as centroid_measurement
from chips.boards.isolation import measure as isolation_measurement
from chips.boards.vocalization import measure as vocalization_measurement
from chips.hearing import measure as hearing_measurement
from chips.latency import errors as latency_errors
from chips.latency import measure as latency_measurement
from chips.lso import errors as lso_errors
from chips.lso import measure as lso_measurement
from chips.selection import measure as selection_measurement
from chips.table_record import recorded, write_board_record


@dataclass(frozen=True, slots=True)
class Measurement:
    """`measure()` gives a record without errors; `held_out_errors()` judges the record that is in force."""

    measure: Callable[[], xr.Dataset]
    held_out_errors: Callable[[], dict[str, float]]


MEASUREMENTS: Mapping[str, Measurement] = {
    "centroid_board": Measurement(centroid_measurement.measure, centroid_measurement.held_out_errors),
    "vocalization_controller": Measurement(
        vocalization_measurement.measure, vocalization_measurement.held_out_errors
    ),
    "hearing": Measurement(hearing_measurement.measure, hearing_measurement.held_out_errors),
    "first_target_isolation": Measurement(
        isolation_measurement.measure, isolation_measurement.held_out_errors
    ),
    "winner_take_all": Measurement(selection_measurement.measure, selection_measurement.held_out_errors),
    "latency_chip": Measurement(latency_measurement.measure, latency_errors.held_out_errors),
    "lso_neuron": Measurement(lso_measurement.measure, lso_errors.held_out_errors),
}


def characterise_board(block: str, path: Path) -> dict[str, float]:
    """Measure the record of `block`, a key of `MEASUREMENTS`, and write it to `path`; returns its errors."""
    data = MEASUREMENTS[block].measure()
    with recorded(block, data):
        errors = MEASUREMENTS[block].held_out_errors()
    write_board_record(data, errors, path)
    return errors
