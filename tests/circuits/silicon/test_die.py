"""Keyed draws: Philox4x32-10 against its authors' known answers, and what a key must guarantee.

Statistical bounds are five standard errors or more of fixed draws: they do not depend on chance.
"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.errors import ParameterError
from circuits.silicon.die import (
    CORNER_SIGMAS,
    CORNERS,
    Die,
    Path,
    Place,
    mismatch,
    philox,
    shared,
    standard_normals,
)
from circuits.silicon.process import AMI_1500_IDEAL, POLARITIES

CHIP: Place = (("chip", ()),)
NAMES = st.text(alphabet="ab._", min_size=1, max_size=3)
DIES = st.builds(Die, lot=st.sampled_from(["A", "B"]), number=st.integers(0, 2**63 - 1))
SHAPES = st.lists(st.integers(1, 4), max_size=2).map(tuple)


def draw(die: Die, path: Path, parameter: str = "v_t0", place: Place = CHIP) -> np.ndarray:
    return standard_normals(die, place, [path], parameter)


def array(*shape: int) -> Path:
    return (("neuron", shape), ("m", ()))


# Known answers of the authors' library Random123 for 10 rounds: counter, key, output.
ANSWERS = [
    ("00000000 00000000 00000000 00000000", "00000000 00000000", "6627e8d5 e169c58d bc57ac4c 9b00dbd8"),
    ("ffffffff ffffffff ffffffff ffffffff", "ffffffff ffffffff", "408f276d 41c83b0e a20bc7c6 6d5451fd"),
    ("243f6a88 85a308d3 13198a2e 03707344", "a4093822 299f31d0", "d16cfe09 94fdcceb 5001e420 24126ea1"),
]


def _words(text: str) -> np.ndarray:
    return np.array([[int(word, 16)] for word in text.split()], dtype=np.uint32)


@pytest.mark.parametrize(("counter", "key", "answer"), ANSWERS)
def test_philox_gives_the_known_answers(counter: str, key: str, answer: str) -> None:
    words = np.zeros((4, 1), dtype=np.uint32)
    philox(_words(key), _words(counter), words)
    np.testing.assert_array_equal(words, _words(answer))


def test_draws_are_these_for_ever() -> None:
    """A change here changes every die that anybody has ever named."""
    found = draw(Die("A", 1003), array(3))
    np.testing.assert_allclose(found, FIXED, rtol=1e-12)


FIXED = [0.10453549361440335, 0.3847756310530947, 0.395329817716581]


@given(die=DIES, small=st.integers(1, 5), large=st.integers(5, 40), data=st.data())
def test_a_device_is_the_same_in_any_array(die: Die, small: int, large: int, data: st.DataObject) -> None:
    whole = draw(die, array(large))
    np.testing.assert_array_equal(draw(die, array(small)), whole[:small])
    k = data.draw(st.integers(0, large - 1))
    alone = standard_normals(die, (*CHIP, ("neuron", (k,))), [(("m", ()),)], "v_t0")
    np.testing.assert_array_equal(alone, whole[k : k + 1])


@given(die=DIES, rows=st.integers(1, 4), columns=st.integers(1, 4), wide=st.integers(4, 9))
def test_a_device_is_the_same_in_any_table(die: Die, rows: int, columns: int, wide: int) -> None:
    part = draw(die, array(rows, columns)).reshape(rows, columns)
    whole = draw(die, array(5, wide)).reshape(5, wide)
    np.testing.assert_array_equal(part, whole[:rows, :columns])


@given(die=DIES, shapes=st.lists(SHAPES, min_size=1, max_size=4), order=st.randoms(use_true_random=False))
def test_batch_and_order_change_nothing(die: Die, shapes: list[tuple[int, ...]], order: object) -> None:
    paths = [((f"part{i}", shape), ("m", ())) for i, shape in enumerate(shapes)]
    alone = {path: draw(die, path) for path in paths}
    shuffled = list(paths)
    order.shuffle(shuffled)  # type: ignore[attr-defined]  # hypothesis gives a Random
    together = standard_normals(die, CHIP, shuffled, "v_t0")
    np.testing.assert_array_equal(together, np.concatenate([alone[p] for p in shuffled]))


@given(numbers=st.lists(st.integers(0, 10**6), min_size=1, max_size=8))
def test_workers_change_nothing(numbers: list[int]) -> None:
    def one(number: int) -> list[float]:
        return draw(Die(number=number), array(3)).tolist()  # type: ignore[no-any-return]

    with ThreadPoolExecutor(2) as executor:
        assert list(executor.map(one, numbers)) == [one(n) for n in numbers]


@given(a=st.lists(NAMES, min_size=1, max_size=3), b=st.lists(NAMES, min_size=1, max_size=3))
def test_different_names_never_look_alike(a: list[str], b: list[str]) -> None:
    first, second = (draw(Die(number=1), tuple((n, ()) for n in names)) for names in (a, b))
    assert (first[0] == second[0]) == (a == b)


@pytest.mark.parametrize(
    ("a", "b"),
    [
        ((("a.b", ()), ("c", ())), (("a", ()), ("b.c", ()))),
        ((("a", ()), ("bc", ())), (("ab", ()), ("c", ()))),
        ((("a", ()), ("m", ())), (("a", (1,)), ("m", ()))),
        ((("a", (2,)), ("b", ()), ("m", ())), (("a", ()), ("b", (2,)), ("m", ()))),
    ],
)
def test_paths_that_read_alike_are_different(a: Path, b: Path) -> None:
    assert draw(Die(number=1), a)[0] != draw(Die(number=1), b)[0]


def test_every_part_of_the_key_gives_other_draws() -> None:
    n = 20_000
    variants = [
        draw(Die("A", 1), array(n)),
        draw(Die("B", 1), array(n)),
        draw(Die("A", 2), array(n)),
        draw(Die("A", 1), array(n), "beta"),
        draw(Die("A", 1), (("neuron", (n,)), ("m2", ()))),
        draw(Die("A", 1), (("other", (n,)), ("m", ()))),
        draw(Die("A", 1), array(n), place=(("chip2", ()),)),
        draw(Die("A", 1), array(n), place=(*CHIP, ("row", (0,)))),
        draw(Die("A", 1), array(n), place=(*CHIP, ("row", (1,)))),
    ]
    correlation = np.corrcoef(variants)
    np.fill_diagonal(correlation, 0.0)
    assert np.abs(correlation).max() < 5.0 / np.sqrt(n)
    neighbours = np.corrcoef(variants[0][1:], variants[0][:-1])[0, 1]
    assert abs(neighbours) < 5.0 / np.sqrt(n)


def test_draws_are_standard_normal() -> None:
    n = 200_000
    x = draw(Die(number=5), array(n))
    moments = [x.mean(), (x**2).mean() - 1.0, (x**3).mean(), (x**4).mean() - 3.0]
    deviations = np.sqrt(np.array([1.0, 2.0, 15.0, 96.0]) / n)
    assert (np.abs(moments) < 5.0 * deviations).all()
    assert np.isfinite(x).all()


@pytest.mark.parametrize("multiplicity", [1.0, 4.0])
@pytest.mark.parametrize(("width", "length"), [(3e-6, 1.5e-6), (6e-6, 6e-6)])
def test_sigma_follows_the_area_with_the_pair_s_figure(
    width: float, length: float, multiplicity: float
) -> None:
    n = 100_000
    v_t0, beta = mismatch(Die(number=1), AMI_1500_IDEAL, CHIP, [array(n)], width * length * multiplicity)
    root = np.sqrt(2.0 * width * length * multiplicity)
    assert np.std(v_t0) == pytest.approx(AMI_1500_IDEAL.pair_a_vt / root, rel=5.0 / np.sqrt(2 * n))
    assert np.std(beta) == pytest.approx(AMI_1500_IDEAL.pair_a_beta / root, rel=5.0 / np.sqrt(2 * n))
    pair = np.asarray(v_t0)[: n // 2] - np.asarray(v_t0)[n // 2 :]
    published = AMI_1500_IDEAL.pair_a_vt / np.sqrt(width * length * multiplicity)
    assert np.std(pair) == pytest.approx(published, rel=5.0 / np.sqrt(n))


def test_mismatch_and_process_are_switched_separately() -> None:
    both, local, common = (
        Die(number=7),
        Die(number=7, process=False),
        Die(number=7, mismatch=False),
    )

    def deviations(die: Die) -> list[float]:
        return [float(np.ravel(x)[0]) for x in mismatch(die, AMI_1500_IDEAL, CHIP, [array(1)], 1e-12)]

    def shifts(die: Die) -> list[float]:
        return [x for p in POLARITIES for x in shared(die, AMI_1500_IDEAL, p)]

    assert deviations(both) == deviations(local) != [0.0, 0.0]
    assert deviations(common) == [0.0, 0.0]
    assert shifts(both) == shifts(common)
    assert len(set(shifts(both))) == 4
    assert shifts(local) == [0.0] * 4
    assert deviations(Die()) == [0.0, 0.0]
    assert shifts(Die()) == [0.0] * 4


def test_process_shifts_have_their_sigma_from_die_to_die() -> None:
    n = 2000
    shifts = np.array([shared(Die(number=k), AMI_1500_IDEAL, "n") for k in range(n)])
    expected = (AMI_1500_IDEAL.variation.sigma_v_t0, AMI_1500_IDEAL.variation.sigma_beta)
    np.testing.assert_allclose(shifts.std(axis=0), expected, rtol=5.0 / np.sqrt(2 * n))
    assert abs(np.corrcoef(shifts.T)[0, 1]) < 5.0 / np.sqrt(n)


def test_a_circuit_called_process_shares_no_draw_with_the_process() -> None:
    shift = shared(Die(number=1), AMI_1500_IDEAL, "n").v_t0 / AMI_1500_IDEAL.variation.sigma_v_t0
    assert draw(Die(number=1), (("n", ()),), place=(("process", ()),))[0] != shift


@pytest.mark.parametrize(
    ("corner", "n", "p"), [("ss", 1, 1), ("ff", -1, -1), ("sf", 1, -1), ("fs", -1, 1), ("typical", 0, 0)]
)
def test_corners_are_three_sigma(corner: str, n: int, p: int) -> None:
    for polarity, slow in zip(POLARITIES, (n, p), strict=True):
        variation = AMI_1500_IDEAL.variation
        expected = (slow * CORNER_SIGMAS * variation.sigma_v_t0, -slow * CORNER_SIGMAS * variation.sigma_beta)
        for die in (Die(corner=corner), Die(number=3, corner=corner)):  # type: ignore[arg-type]
            assert tuple(shared(die, AMI_1500_IDEAL, polarity)) == expected
    assert corner in CORNERS


def test_a_corner_keeps_the_mismatch() -> None:
    drawn, slow = (
        mismatch(Die(number=3, corner=corner), AMI_1500_IDEAL, CHIP, [array(2)], 1e-12)
        for corner in (CORNERS[0], CORNERS[2])
    )
    np.testing.assert_array_equal(np.array(drawn), np.array(slow))


def test_numpy_s_numbers_name_the_same_die() -> None:
    die = Die(np.str_("A"), np.int64(7))  # type: ignore[arg-type]
    assert die == Die("A", 7)
    np.testing.assert_array_equal(draw(die, array(2)), draw(Die("A", 7), array(2)))


@pytest.mark.parametrize("number", [-1, 2**63, 1.0, 1.5, "7"])
def test_a_die_s_number_is_whole(number: object) -> None:
    with pytest.raises(ParameterError, match="must be a whole number"):
        Die(number=number)  # type: ignore[arg-type]


def test_unknown_corners_and_deep_arrays_are_refused() -> None:
    with pytest.raises(ParameterError, match=r"corner: .xy., must be random, typical, ss, ff, sf or fs"):
        Die(corner="xy")  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match=r"chip\.a\.b\.m: 5 index dimensions, must be at most 4"):
        draw(Die(number=1), (("a", (2, 2)), ("b", (2, 2, 2)), ("m", ())))


@pytest.mark.parametrize(
    ("die", "text"),
    [
        (Die(), "die nominal"),
        (Die(corner="ss"), "die nominal ss"),
        (Die("B", 12), "die B/12"),
        (Die("B", 12, "ff", mismatch=False), "die B/12 ff no mismatch"),
        (Die(number=1, process=False), "die A/1 no process variation"),
    ],
)
def test_a_die_says_what_it_is(die: Die, text: str) -> None:
    assert str(die) == text


def test_plain_variation_goes_unsaid_where_kept_runs_are_named() -> None:
    plain = "Die(lot='A', number=3, corner='random', mismatch=True, process=True, sampling=None)"
    assert repr(Die("A", 3)) == plain
    assert repr(Die("A", 3, variation="full")) == plain.replace(")", ", variation='full')")
