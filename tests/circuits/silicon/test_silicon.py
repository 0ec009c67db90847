"""Silicon: what the shared and the local part of a die do to a transistor's law."""

import numpy as np
import pytest

from circuits.errors import ParameterError
from circuits.silicon.die import CORNER_SIGMAS, Die
from circuits.silicon.process import AMI_1500_IDEAL, POLARITIES, Polarity, at_temperature
from circuits.silicon.silicon import Silicon

PATH = (("neuron", (3,)), ("m1", ()))
VARIATION = AMI_1500_IDEAL.variation


@pytest.mark.parametrize("polarity", POLARITIES)
@pytest.mark.parametrize("temperature_c", [0.0, 27.0, 60.0])
def test_the_nominal_die_has_the_process_s_law(polarity: Polarity, temperature_c: float) -> None:
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=temperature_c)
    assert silicon.law(polarity) == at_temperature(
        AMI_1500_IDEAL.model(polarity), AMI_1500_IDEAL, temperature_c
    )
    assert silicon.deviation("chip", PATH, 1e-12) == (0.0, 0.0)


@pytest.mark.parametrize("polarity", POLARITIES)
def test_a_corner_moves_threshold_and_current(polarity: Polarity) -> None:
    nominal, slow = (
        Silicon(AMI_1500_IDEAL).law(polarity),
        Silicon(AMI_1500_IDEAL, die=Die(corner="ss")).law(polarity),
    )
    assert slow.v_t0 - nominal.v_t0 == pytest.approx(CORNER_SIGMAS * VARIATION.sigma_v_t0)
    ratio = slow.square_current / nominal.square_current
    assert ratio == pytest.approx(1.0 - CORNER_SIGMAS * VARIATION.sigma_beta)


def test_the_die_s_shift_is_the_same_at_every_temperature_and_place() -> None:
    shifts = []
    for temperature_c in (0.0, 60.0):
        silicon = Silicon(
            AMI_1500_IDEAL, temperature_c=temperature_c, die=Die(number=1003), place=(("chip", ()),)
        )
        nominal = Silicon(AMI_1500_IDEAL, temperature_c=temperature_c).law("n")
        law = silicon.law("n")
        shifts.append((law.v_t0 - nominal.v_t0, law.square_current / nominal.square_current))
    assert shifts[0] == pytest.approx(shifts[1], rel=1e-12)
    assert abs(shifts[0][0]) > 1e-3


def test_deviations_of_several_paths_are_those_of_each() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=4))
    paths = (PATH, (("m2", ()),), (("neuron", (2,)), ("m3", ())))
    areas = np.array([1.0, 1.0, 1.0, 4.0, 9.0, 9.0]) * 1e-12
    together = silicon.deviations("chip", paths, areas)
    alone = [silicon.deviation("chip", p, a) for p, a in zip(paths, (1e-12, 4e-12, 9e-12), strict=True)]
    np.testing.assert_array_equal(together.v_t0, np.concatenate([np.ravel(d.v_t0) for d in alone]))
    np.testing.assert_array_equal(together.beta, np.concatenate([np.ravel(d.beta) for d in alone]))


def test_a_place_stands_for_the_names_above_the_circuit() -> None:
    die = Die(number=4)
    alone = Silicon(AMI_1500_IDEAL, die=die, place=(("chip", ()), ("neuron", (2,)))).deviation(
        "any", (("m1", ()),), 1e-12
    )
    chip = Silicon(AMI_1500_IDEAL, die=die).deviation("chip", PATH, 1e-12)
    assert float(np.ravel(alone.v_t0)[0]) == float(np.ravel(chip.v_t0)[2])


def test_temperature_has_its_range() -> None:
    with pytest.raises(ParameterError, match="must be within -40 to 125 degC"):
        Silicon(AMI_1500_IDEAL, temperature_c=200.0)
