"""Components of variation, each against its formula; off, every draw is today's.

Statistical bounds are four standard errors of fixed draws: they do not depend on chance.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from circuits.errors import ParameterError
from circuits.silicon.components import AMI_1500_COMPONENTS, DIES_A_WAFER, EXTENTS, Extent
from circuits.silicon.die import CORNER_SIGMAS, Die, Place, mismatch, shared
from circuits.silicon.floor_plan import FLOOR_PLANS
from circuits.silicon.passive import Kind, passive
from circuits.silicon.process import AMI_1500_IDEAL, POLARITIES, Polarity, Process
from circuits.silicon.sampling import Sampling
from circuits.silicon.silicon import Silicon
from tests.refusals import refusals

DRAWS = 2000
ERRORS = 4.0  # standard errors that a statistic may be off
FIGURES, VARIATION = AMI_1500_COMPONENTS, AMI_1500_IDEAL.variation
CHIP: Place = (("chip", ()),)
WAFERS = DRAWS * 2 // DIES_A_WAFER


def die(number: int, lot: str = "A", variation: Extent = "full") -> Die:
    return Die(lot, number, variation=variation)


def require_sigma(values: np.ndarray, sigma: float) -> None:
    """Assert that a sample's standard deviation, about 0, is `sigma` within its sampling error."""
    found = float(np.sqrt(np.mean(values**2)))
    assert found == pytest.approx(sigma, rel=ERRORS / np.sqrt(2.0 * values.size))


def test_what_dies_of_many_lots_share_has_the_variance_that_the_process_states() -> None:
    dies = [die(k, f"lot {k}") for k in range(DRAWS)]
    shifts = np.array([[shared(each, AMI_1500_IDEAL, polarity) for polarity in POLARITIES] for each in dies])
    for p in range(2):
        require_sigma(shifts[:, p, 0], VARIATION.sigma_v_t0)
        require_sigma(shifts[:, p, 1], VARIATION.sigma_beta)
    for k, rho in enumerate((FIGURES.correlation_v_t0, FIGURES.correlation_beta)):
        found = np.corrcoef(shifts[:, 0, k], shifts[:, 1, k])[0, 1]
        assert found == pytest.approx(rho, abs=ERRORS * (1.0 - rho**2) / np.sqrt(DRAWS))


@pytest.mark.parametrize("polarity", POLARITIES)
def test_an_edit_of_what_one_polarity_shares_leaves_the_other_as_it_is(polarity: Polarity) -> None:
    other: Polarity = "p" if polarity == "n" else "n"
    drawn = {each: shared(die(1003), AMI_1500_IDEAL, each) for each in POLARITIES}
    for edited in (die(1003).healed(f"process.{polarity}"), die(1003).only(f"process.{other}")):
        for each in (edited, edited.without_mismatch()):
            assert shared(each, AMI_1500_IDEAL, other) == drawn[other]
            assert tuple(map(abs, shared(each, AMI_1500_IDEAL, polarity))) == (0.0, 0.0)


@pytest.mark.parametrize("level", ["lot", "wafer"])
def test_an_edit_of_a_lot_or_a_wafer_moves_what_it_has_in_its_polarity_alone(level: str) -> None:
    of_level = replace(FIGURES, lot_share=float(level == "lot"), wafer_share=float(level == "wafer"))
    share = np.sqrt(getattr(FIGURES, f"{level}_share"))
    for polarity in POLARITIES:
        other: Polarity = "p" if polarity == "n" else "n"
        own, rest = (shared(die(1003), AMI_1500_IDEAL, each) for each in (polarity, other))
        part = share * shared(die(1003), replace(AMI_1500_IDEAL, components=of_level), polarity).v_t0
        healed = die(1003).healed(f"{level}.{polarity}")
        told = die(1003).with_(f"{level}.{polarity}", "v_t0", 0.02)
        for each in (healed, healed.without_mismatch()):
            assert shared(each, AMI_1500_IDEAL, polarity).v_t0 == pytest.approx(own.v_t0 - part, rel=1e-12)
            assert shared(each, AMI_1500_IDEAL, other) == rest
        for each in (told, told.without_mismatch()):
            moved = own.v_t0 - part + 0.02
            assert shared(each, AMI_1500_IDEAL, polarity).v_t0 == pytest.approx(moved, rel=1e-12)


def test_lot_wafer_and_die_have_their_shares() -> None:
    v_t0 = np.array([shared(die(k), AMI_1500_IDEAL, "n").v_t0 for k in range(WAFERS * DIES_A_WAFER)])
    by_wafer = v_t0.reshape(WAFERS, DIES_A_WAFER)
    own = by_wafer - by_wafer.mean(axis=1, keepdims=True)
    left = 1.0 - FIGURES.lot_share - FIGURES.wafer_share
    within = np.sqrt(left * (1.0 - 1.0 / DIES_A_WAFER)) * VARIATION.sigma_v_t0
    require_sigma(own, within)
    # means of wafers differ by what a wafer shares, and by the mean of its dies
    between = np.sqrt(FIGURES.wafer_share + left / DIES_A_WAFER) * VARIATION.sigma_v_t0
    found = float(by_wafer.mean(axis=1).std(ddof=1))
    assert found == pytest.approx(between, rel=ERRORS / np.sqrt(2.0 * WAFERS))
    lots = np.array([
        np.mean([shared(die(k * DIES_A_WAFER, f"lot {n}"), AMI_1500_IDEAL, "n").v_t0 for k in range(20)])
        for n in range(100)
    ])  # fmt: skip
    among = np.sqrt(FIGURES.lot_share + (1.0 - FIGURES.lot_share) / 20) * VARIATION.sigma_v_t0
    assert float(lots.std(ddof=1)) == pytest.approx(among, rel=ERRORS / np.sqrt(2.0 * 100))


def test_the_die_s_own_part_is_the_draw_of_the_plain_die() -> None:
    alone = replace(AMI_1500_IDEAL, components=replace(FIGURES, lot_share=0.0, wafer_share=0.0))
    for number in range(5):
        assert shared(die(number), alone, "n") == shared(Die(number=number), AMI_1500_IDEAL, "n")


@pytest.mark.parametrize("variation", EXTENTS)
def test_a_corner_is_the_same_with_components(variation: Extent) -> None:
    at = Die(number=3, corner="ss", variation=variation)
    assert shared(at, AMI_1500_IDEAL, "n").v_t0 == CORNER_SIGMAS * VARIATION.sigma_v_t0
    assert isinstance(passive(at, AMI_1500_IDEAL, CHIP, [(("r", ()),)], "resistor", np.ones(1)), float) == (
        variation != "full"
    )


def plane_differences(dx: int, dy: int, polarity: Polarity) -> np.ndarray:
    """Differences of V_T0 (V) and of beta of two cells of the wavefront chip on many dies."""
    path = (("axon", (20, 20)), ("m", ()))
    found = []
    for number in range(DRAWS):
        plane = Silicon(AMI_1500_IDEAL, die=die(number, variation="transistors"))
        local = mismatch(plane.die, AMI_1500_IDEAL, (("wavefront_chip", ()),), [path], 1e-12)
        given = plane.deviations("wavefront_chip", [path], 1e-12, [polarity])
        row = [np.asarray(a - b).reshape(20, 20) for a, b in zip(given, local, strict=True)]
        found.append([x[0, 0] - x[dy, dx] for x in row])
    return np.array(found)


@pytest.mark.parametrize(("dx", "dy", "polarity"), [(1, 0, "n"), (0, 5, "p"), (12, 16, "n")])
def test_a_pair_differs_by_its_distance_in_any_direction(dx: int, dy: int, polarity: Polarity) -> None:
    pitch = FLOOR_PLANS["wavefront_chip"]["axon"].pitch[0]
    apart = pitch * np.hypot(dx, dy)
    found = plane_differences(dx, dy, polarity)
    require_sigma(found[:, 0], FIGURES.distance_v_t0 * apart)
    require_sigma(found[:, 1], FIGURES.distance_beta * apart)


@pytest.mark.parametrize("value", [50e-15, 2e-12])
def test_capacitors_differ_by_their_area_and_share_a_shift(value: float) -> None:
    values = np.full(50, value)
    path = (("cell", (50,)), ("c", ()))
    found = np.array([
        passive(die(k, f"lot {k}"), AMI_1500_IDEAL, CHIP, [path], "capacitor", values) for k in range(DRAWS)
    ])  # fmt: skip
    single = FIGURES.pair_a_capacitance / np.sqrt(2.0 * value / FIGURES.capacitance_density)
    local = found - found.mean(axis=1, keepdims=True)
    require_sigma(local, single * np.sqrt(1.0 - 1.0 / 50))
    require_sigma(found.mean(axis=1), np.hypot(FIGURES.sigma_capacitance, single / np.sqrt(50)))


def test_resistors_of_a_die_share_a_shift_alone() -> None:
    path = (("cell", (2,)), ("r", ()))
    found = np.array([
        passive(die(k, f"lot {k}"), AMI_1500_IDEAL, CHIP, [path], "resistor", np.array([1e3, 1e6]))
        for k in range(DRAWS)
    ])  # fmt: skip
    assert (found[:, 0] == found[:, 1]).all()
    require_sigma(found[:, 0], FIGURES.sigma_resistance)


@pytest.mark.parametrize("kind", ["capacitor", "resistor"])
def test_parts_of_a_board_are_those_of_no_die(kind: Kind) -> None:
    place: Place = (("vocalization_controller", ()),)
    assert passive(die(3), AMI_1500_IDEAL, place, [(("c", ()),)], kind, np.ones(1)) == 0.0


def test_transistors_alone_leaves_capacitors_and_resistors() -> None:
    there = die(3, variation="transistors")
    assert passive(there, AMI_1500_IDEAL, CHIP, [(("c", ()),)], "capacitor", np.ones(1)) == 0.0
    assert (
        shared(there, AMI_1500_IDEAL, "p")
        == shared(die(3), AMI_1500_IDEAL, "p")
        != shared(Die(number=3), AMI_1500_IDEAL, "p")
    )


def test_off_nothing_is_another_draw() -> None:
    """Of the plain die: the same numbers with and without components stated."""
    bare = replace(AMI_1500_IDEAL, components=None)
    path = (("neuron", (13,)), ("m", ()))
    for process in (AMI_1500_IDEAL, bare):
        silicon = Silicon(process, die=Die(number=1003))
        v_t0, beta = silicon.deviations("ranging_chip", [path], 1e-12)
        own = mismatch(silicon.die, bare, (("ranging_chip", ()),), [path], 1e-12)
        np.testing.assert_array_equal((v_t0, beta), own)
        assert silicon.law("p") == Silicon(bare, die=Die(number=1003)).law("p")


def test_order_neighbours_and_workers_change_nothing() -> None:
    paths = [(("neuron", (13,)), (f"m{k}", ())) for k in range(3)]
    area = np.full(39, 1e-12)

    def one(number: int) -> list[float]:
        silicon = Silicon(AMI_1500_IDEAL, die=die(number))
        v_t0, _ = silicon.deviations("ranging_chip", paths, area, ["n", "p", "n"])
        alone = [
            silicon.deviations("ranging_chip", [path], area[:13], [polarity]).v_t0
            for path, polarity in zip(paths, ("n", "p", "n"), strict=True)
        ]
        np.testing.assert_array_equal(v_t0, np.concatenate(alone))
        c = passive(silicon.die, AMI_1500_IDEAL, CHIP, paths, "capacitor", np.full(39, 1e-12))
        return [*np.ravel(v_t0), *np.ravel(c), *shared(silicon.die, AMI_1500_IDEAL, "p")]

    with ThreadPoolExecutor(2) as executor:
        assert list(executor.map(one, range(8))) == [one(k) for k in reversed(range(8))][::-1]


def test_a_plan_gives_the_draws_of_wafers_and_gradients() -> None:
    columns = {"wafer.n.shared.v_t0": 0, "gradient.n.x.v_t0": 1, "ranging_chip.c.capacitance": 2}
    low, high = (
        Silicon(AMI_1500_IDEAL, die=replace(die(7), sampling=Sampling("mine", 7, columns, np.array([row]))))
        for row in ([0.0, 0.0, 0.0], [2.0, 3.0, 4.0])
    )
    share = np.sqrt(FIGURES.wafer_share) * VARIATION.sigma_v_t0
    assert high.law("n").v_t0 - low.law("n").v_t0 == pytest.approx(2.0 * share, rel=1e-9)
    x = FLOOR_PLANS["ranging_chip"]["chain"].centre[0]
    path = (("chain", ()), ("m", ()))
    slopes = [float(s.deviation("ranging_chip", path, 1e-12, "n").v_t0[0]) for s in (low, high)]
    assert slopes[1] - slopes[0] == pytest.approx(3.0 * FIGURES.distance_v_t0 * x, rel=1e-9)
    value = np.array([1e-12])
    single = FIGURES.pair_a_capacitance / np.sqrt(2.0 * value[0] / FIGURES.capacitance_density)
    made = [1.0 + s.change("ranging_chip", [(("c", ()),)], "capacitor", value).value[0] for s in (low, high)]
    assert made[1] / made[0] == pytest.approx(1.0 + 4.0 * single, rel=1e-9)


def test_a_circuit_called_wafer_is_no_wafer() -> None:
    each = [
        float(Silicon(AMI_1500_IDEAL, die=die(k)).deviation("wafer", (("n", ()),), 1e-12, "n").v_t0[0])
        for k in (3, 4)
    ]
    assert each[0] != each[1]


def without(process: Process) -> Silicon:
    return Silicon(process, die=die(3))


test_a_process_without_components_is_refused = refusals(
    ParameterError,
    without,
    [(replace(AMI_1500_IDEAL, components=None), "ami-1500.components: none stated.*plain")],
)
test_gradients_need_polarities = refusals(
    ParameterError,
    lambda number: Silicon(AMI_1500_IDEAL, die=die(number)).deviation("c", (("m", ()),), 1e-12),
    [(3, "c: no polarities of its transistors")],
)
test_figures_that_are_none_are_refused = refusals(
    ParameterError,
    lambda given: replace(FIGURES, **given),
    [
        ({"lot_share": 0.8}, "components.wafer_share: 0.3 beside a lot_share of 0.8"),
        ({"correlation_beta": -1.1}, "components.correlation_beta: -1.1, must be within -1 to 1"),
        ({"sigma_resistance": -0.1}, "components.sigma_resistance: -0.1, must be >= 0"),
        ({"capacitance_density": 0.0}, "components.capacitance_density: 0 F/m"),
    ],
)
test_another_extent_is_refused = refusals(
    ParameterError, lambda given: Die(variation=given), [("some", "variation: '?some'?, must be")]
)
