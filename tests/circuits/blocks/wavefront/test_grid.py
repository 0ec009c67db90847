"""A wave passes through a small grid of cells and axons at transistor level; blocked cells stop it."""

import numpy as np
import pytest

from circuits.blocks.wavefront.grid import (
    CHIP,
    NEIGHBOURS,
    Params,
    build,
    firing_times,
    plan_testbench,
    pointers,
)
from circuits.errors import ParameterError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from tests.circuits.soundness import fault

UNIT = 100e-6
DEFAULTS = CHIP.defaults


def plan(codes: list[list[int]], start: tuple[int, int], stop: float) -> Result:
    grid = np.array(codes)
    bench = plan_testbench(build(Params(*grid.shape)), grid, start, stop, 5.0)
    return simulate(bench, Silicon(AMI_1500_IDEAL))


def test_the_grid_is_sound() -> None:
    assert fault(build(Params(2, 2))) == ""


def test_a_wave_passes_with_the_code_of_the_sending_cell() -> None:
    result = plan([[3, 1, 9]], (0, 0), 0.5e-3)
    times = firing_times(result)[0]
    # the cells add nanoseconds, code 1 is 0.9 us early
    assert np.diff(times) == pytest.approx([3 * UNIT, UNIT], abs=1e-6)
    assert pointers(result).tolist() == [[-1, 6, 6]]  # both from the west


def test_the_wave_takes_the_cheaper_way_around_and_points_back_to_it() -> None:
    # from (0, 0) to (0, 2): over (0, 1) it costs 1 + 5, around over (1, 1) it costs 1 + 2
    result = plan([[1, 5, 1], [9, 2, 9]], (0, 0), 0.5e-3)
    assert firing_times(result)[0, 2] - firing_times(result)[0, 0] == pytest.approx(3 * UNIT, abs=2e-6)
    down, right = NEIGHBOURS[pointers(result)[0, 2]]
    assert (down, right) == (1, -1)


def test_a_blocked_cell_never_fires_and_stops_the_wave() -> None:
    result = plan([[1, 0, 1]], (0, 0), 0.4e-3)
    assert np.isfinite(firing_times(result)).tolist() == [[True, False, False]]
    assert CHIP.outcome(result) == "partly"


def test_the_testbench_of_the_command_line_reaches_all_cells() -> None:
    bench = CHIP.testbench(build(Params(1, 2)), DEFAULTS | {"code": 1.0}, 5.0)
    result = simulate(bench, Silicon(AMI_1500_IDEAL))
    assert CHIP.outcome(result) == "reached"
    assert CHIP.measures(result)["fired_cells"] == 2.0
    assert CHIP.measures(result)["arrival_s"] == pytest.approx(UNIT, abs=1e-6)


def test_a_start_outside_is_refused() -> None:
    with pytest.raises(ParameterError, match="start: 2,0, must be inside 2 x 2 cells"):
        CHIP.testbench(build(Params(2, 2)), DEFAULTS | {"start_row": 2.0}, 5.0)
    with pytest.raises(ParameterError, match=r"start_row: 0\.5, must be a whole number"):
        CHIP.testbench(build(Params(2, 2)), DEFAULTS | {"start_row": 0.5}, 5.0)


def test_a_grid_without_cells_is_refused() -> None:
    with pytest.raises(ParameterError, match="rows: 0, must be a whole number from 1 to 64"):
        Params(0, 3)
