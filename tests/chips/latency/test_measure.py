"""What is measured of a block is what its circuit does; a quantity that is missing is named."""

import numpy as np
import pytest

from chips.latency.measure import Found
from chips.measured.timer import PARAMETERS
from chips.record import kept_record
from circuits.errors import SolverError
from circuits.silicon.process import AMI_1500


def test_a_comparators_pair_moves_the_reference_by_its_own_offset() -> None:
    data = kept_record("latency_chip")
    slopes = dict(zip(PARAMETERS, np.asarray(data["comparator"])[2], strict=True))
    # ln Q moves by dV / V_ref, 1/2 a volt, with the sign of the input that the device is at
    assert slopes["mc1.v_t0"] == pytest.approx(0.5, rel=0.05)
    assert slopes["mc2.v_t0"] == pytest.approx(-0.5, rel=0.05)
    assert abs(slopes["mc5.v_t0"]) < 0.05


def test_errors_on_other_dies_are_in_the_record() -> None:
    found = kept_record("latency_chip").errors
    assert found["first_die"] == 500.0
    # stated: half a percent; a detector on the wrong side of its window was not seen
    assert all(v < 0.005 for k, v in found.items() if k.endswith("rms_relative"))
    assert found["detections_wrong"] == 0.0


def test_under_the_full_law_charges_are_those_of_any_temperature_and_threshold() -> None:
    record = kept_record("latency_chip", AMI_1500)
    for name in ("timer", "tap", "tonic", "integrating", "race", "second", "recurrent"):
        table = np.asarray(record[name])
        # what leaks is a current; the rest is the comparator's, the reset's and the drain's place
        assert np.ptp(table) < 0.005 * table.mean(), name
    found = record.errors
    within = {k: v for k, v in found.items() if k.endswith("rms_relative") and not k.startswith("tonic")}
    assert set(within) == {f"{k}_rms_relative" for k in ("tap", "integrating", "release", "hold", "race")}
    assert all(v < 0.005 for v in within.values())
    # INH's later periods: its spike leaves part of the charge on some dies
    assert found["tonic_rms_relative"] > 0.1
    assert found["detections_wrong"] == 0.0


def test_a_quantity_that_is_not_in_the_run_is_named() -> None:
    with pytest.raises(SolverError, match=r"latency_chip\.step_s: not in the run"):
        Found({})["step_s"]
