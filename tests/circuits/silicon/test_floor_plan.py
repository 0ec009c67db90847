"""Floor plans: where cells stand, and what is outside of them."""

import numpy as np
import pytest

from circuits.errors import ParameterError
from circuits.silicon.floor_plan import FLOOR_PLANS, Block, positions

CELL = (("m", ()),)


def test_rows_go_down_and_columns_to_the_right() -> None:
    x, y = Block(2, 3, (2.0, 5.0), (10.0, 20.0)).offsets(np.array([0, 1]), np.array([0, 2]))
    np.testing.assert_allclose(x, [8.0, 12.0])
    np.testing.assert_allclose(y, [22.5, 17.5])


def test_an_array_s_middle_is_its_centre() -> None:
    for chip, plan in FLOOR_PLANS.items():
        for name, block in plan.items():
            x, y = positions(((chip, ()),), [((name, (block.rows, block.columns)), *CELL)])
            np.testing.assert_allclose(
                (x.mean(), y.mean()), block.centre, atol=1e-12, err_msg=f"{chip}.{name}"
            )


def test_a_place_and_a_path_are_one() -> None:
    whole = positions((("rolls_chip", ()),), [(("row", (256,)), ("synapse", (256,)), *CELL)])
    one = positions((("rolls_chip", ()), ("row", (3,)), ("synapse", (7,))), [CELL])
    for all_of, own in zip(whole, one, strict=True):
        assert all_of.reshape(256, 256)[3, 7] == pytest.approx(own[0], abs=1e-15)


def test_one_index_and_two_count_the_same_cells() -> None:
    flat = positions((("wavefront_chip", ()),), [(("axon", (400,)), *CELL)])
    square = positions((("wavefront_chip", ()),), [(("axon", (20, 20)), *CELL)])
    np.testing.assert_array_equal(flat, square)


def test_no_two_cells_of_an_array_stand_at_one_place() -> None:
    for chip, plan in FLOOR_PLANS.items():
        for name, block in plan.items():
            x, y = positions(((chip, ()),), [((name, (block.rows * block.columns,)), *CELL)])
            assert len({*zip(x.round(9), y.round(9), strict=True)}) == x.size, f"{chip}.{name}"


@pytest.mark.parametrize("place", [(("rebound_neuron", ()),), (("ranging_chip", ()), ("elsewhere", (2,)))])
def test_what_no_plan_names_stands_at_the_centre(place: tuple[tuple[str, tuple[int, ...]], ...]) -> None:
    x, y = positions(place, [(("array", (4,)), *CELL), CELL])
    np.testing.assert_array_equal(x, np.zeros(5))
    np.testing.assert_array_equal(y, np.zeros(5))


def test_a_cell_beyond_the_plan_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"ranging_chip\.neuron\[13\]: outside .* 13 rows and 1 columns"):
        positions((("ranging_chip", ()),), [(("neuron", (14,)), *CELL)])
