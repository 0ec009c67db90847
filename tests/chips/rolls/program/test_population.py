"""Populations: where they stand, patterns of levels between them, kernels of fields, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from chips.rolls.program.population import (
    Population,
    Projection,
    all_to_all,
    neural_field,
    one_to_one,
    place,
    winner_take_all,
    with_probability,
    without_self,
)
from circuits.errors import ParameterError

A, B = Population("a", (0, 1, 2, 3)), Population("b", (9, 8, 7))


@given(st.lists(st.integers(1, 20), min_size=1, max_size=8), st.sets(st.integers(0, 255), max_size=8))
def test_placed_populations_are_disjoint_and_avoid_the_blacklist(
    sizes: list[int], blacklist: set[int]
) -> None:
    placed = place({f"p{k}": size for k, size in enumerate(sizes)}, blacklist)
    neurons = [n for population in placed.values() for n in population.neurons]
    assert [len(p) for p in placed.values()] == sizes
    assert neurons == sorted(set(neurons) - blacklist)
    skipped = sum(n < neurons[-1] for n in blacklist)
    assert neurons[-1] == sum(sizes) - 1 + skipped


def test_more_neurons_than_the_chip_has_are_refused() -> None:
    assert len(place({"all": 256})["all"]) == 256
    with pytest.raises(
        ParameterError, match=r"population.more: 7 neurons, must be <= 5, .* left of 255; make"
    ):
        place({"most": 250, "more": 7}, blacklist=(3,))


def test_parts_count_within_the_population() -> None:
    part = B.part(1, 3)
    assert (part.name, part.neurons) == ("b[1:3]", (8, 7))
    for start, stop in ((-1, 2), (2, 2), (0, 4)):
        with pytest.raises(
            ParameterError, match=rf"population.b.part: {start} to {stop}, must be within 0 to 3"
        ):
            B.part(start, stop)
    for neurons in ((), (1, 1)):
        with pytest.raises(ParameterError, match=r"population.c: \d neurons, must be one or more, each once"):
            Population("c", neurons)


def test_patterns() -> None:
    assert all_to_all(A, B, -3).levels.tolist() == [[-3] * 4] * 3
    assert one_to_one(A.part(0, 3), B, 2).levels.tolist() == [[2, 0, 0], [0, 2, 0], [0, 0, 2]]
    assert all_to_all(A, B, 1).name == "a -> b"
    with pytest.raises(ParameterError, match="a -> b: 4 and 3 neurons, must be as many"):
        one_to_one(A, B, 2)


def test_a_neuron_is_left_out_where_it_would_reach_itself() -> None:
    assert without_self(all_to_all(B, B, 2)).levels.tolist() == [[0, 2, 2], [2, 0, 2], [2, 2, 0]]
    assert without_self(all_to_all(B.part(1, 3), B, 2)).levels.tolist() == [[2, 2], [0, 2], [2, 0]]
    assert without_self(all_to_all(A, B, 2)).levels.all()


def test_probability_is_by_pair_and_by_seed() -> None:
    big = Population("big", tuple(range(200)))
    first, same, other = (with_probability(big, big, 2, 0.3, seed).levels for seed in (7, 7, 8))
    assert (first == same).all()
    assert (first != other).any()
    # 40,000 pairs: sigma of the share is 0.0023, so that 0.01 is beyond 4 sigma
    assert (first == 2).mean() == pytest.approx(0.3, abs=0.01)
    assert set(np.unique(first)) == {0, 2}
    assert not with_probability(A, B, 2, 0.0, 1).levels.any()
    assert with_probability(A, B, 2, 1.0, 1).levels.all()
    with pytest.raises(ParameterError, match=r"a -> b: probability 1.1, must be 0 to 1"):
        with_probability(A, B, 2, 1.1, 1)


def test_field_is_its_kernel_at_every_distance() -> None:
    population = Population("f", tuple(range(9)))
    levels = neural_field(population, (1, 3, 2), -2).levels
    assert levels[4].tolist() == [-2, -2, 2, 3, 1, 3, 2, -2, -2]
    assert levels[0].tolist() == [1, 3, 2, -2, -2, -2, -2, -2, -2]
    assert (levels == levels.T).all()
    local = neural_field(population, (1, 3), -2, reach=3).levels
    assert local[0].tolist() == [1, 3, -2, -2, 0, 0, 0, 0, 0]
    ring = neural_field(population, (1, 3), -2, reach=3, boundary="ring").levels
    assert ring[0].tolist() == [1, 3, -2, -2, 0, 0, -2, -2, 3]
    assert all((np.roll(ring[0], k) == ring[k]).all() for k in range(9))
    with pytest.raises(ParameterError, match=r"f.reach: 0, must be >= 1, as far as near goes"):
        neural_field(population, (1, 3), -2, reach=0)
    with pytest.raises(ParameterError, match=r"f.boundary: torus, must be open or ring"):
        neural_field(population, (1,), -1, boundary="torus")


def test_a_kernel_wider_than_its_population_is_cut() -> None:
    assert neural_field(B, (1, 2, 3, 4, 4), -1).levels.tolist() == [[1, 2, 3], [2, 1, 2], [3, 2, 1]]


def test_winner_take_all_excites_itself_and_inhibits_the_others() -> None:
    projections = winner_take_all((A, B), 2, -4)
    assert {(p.name, int(p.levels[0, 0])) for p in projections} == {
        ("a -> a", 2),
        ("a -> b", -4),
        ("b -> a", -4),
        ("b -> b", 2),
    }
    assert [p.name for p in winner_take_all((A, B), 0, -1)] == ["a -> b", "b -> a"]
    with pytest.raises(ParameterError, match=r"winner_take_all: excitation 2, inhibition 1"):
        winner_take_all((A, B), 2, 1)


def test_levels_that_the_chip_does_not_have_are_refused() -> None:
    with pytest.raises(ParameterError, match="a -> b: level 5, must be -4 to 4; the chip has eight weights"):
        all_to_all(A, B, 5)
    with pytest.raises(ParameterError, match="b -> b: level -5"):
        neural_field(B, (1,), -5)
    with pytest.raises(ParameterError, match="a -> b: levels of 4 x 3, must be 3 x 4; rows are targets"):
        Projection(A, B, np.zeros((4, 3), dtype=np.int8))
    with pytest.raises(ParameterError, match="a -> b: float64 levels, must be whole numbers"):
        Projection(A, B, np.full((3, 4), 1.5))  # type: ignore[arg-type]
