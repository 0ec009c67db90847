"""Statistical corners of metrics whose gradient is known, and the files of their dies."""

from pathlib import Path

import numpy as np
import pytest

from circuits.arrays import F64
from circuits.errors import ParameterError, SolverError
from system.options.die.file import read_die_file
from system.study.search.corner import corners, die_at, write_dies
from tests.system.study.search.planned import planned

SLOPE = np.array([3.0, 0.0, 0.0, 4.0])


def exponential(z: F64) -> F64:
    return np.asarray(np.exp(0.1 * z @ SLOPE))


def test_a_corner_lies_along_the_gradient_at_its_distance() -> None:
    low, high = corners(planned(exponential), 3.0)
    assert high.point == pytest.approx(3.0 * SLOPE / 5.0)
    assert low.point == pytest.approx(-3.0 * SLOPE / 5.0)
    assert (low.value, high.value) == (pytest.approx(np.exp(-1.5)), pytest.approx(np.exp(1.5)))


def test_a_die_is_the_nominal_one_with_each_deviation_set(tmp_path: Path) -> None:
    slopes = planned(exponential)
    _, high = corners(slopes, 3.0)
    (path,) = write_dies(tmp_path / "new", slopes, [("high", high.point)])
    die = read_die_file(path)
    assert die == die_at(slopes, high.point)
    assert die.number is None
    told = {(e.paths[0], e.parameter): e.value for e in die.edits}
    assert told["process.n", "v_t0"] == pytest.approx(0.01 * 2.4)
    assert told["cell.m1", "v_t0"] == pytest.approx(0.01 * 1.8)
    assert told["cell.m1", "beta"] == 0.0


def test_what_is_no_corner_is_refused() -> None:
    with pytest.raises(ParameterError, match="sigma: 9, must be above 0 and at most 8"):
        corners(planned(exponential), 9.0)
    with pytest.raises(SolverError, match="delay: nothing that varies on these dies moves it"):
        corners(planned(lambda z: 0.0 * z[:, 0]), 3.0)
    with pytest.raises(SolverError, match="delay: has no gradient on the way"):
        corners(planned(lambda z: np.clip(z[:, 0], -1.0, 1.0)), 3.0)
    # highest at equal draws of both, by gradients that lead from one draw to the other and back
    with pytest.raises(SolverError, match="another direction on each die at -3 sigma"):
        corners(planned(lambda z: z[:, 0] * z[:, 1] + 0.01 * z[:, 0]), 3.0)
    slopes = planned(exponential)
    slopes.sigma[0] = np.nan
    with pytest.raises(ParameterError, match=r"cell\.m1\.v_t0 is a component of variation"):
        die_at(slopes, np.ones(4))
