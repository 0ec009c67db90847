"""Portrait of a ROLLS die: its curves, spreads and weights are those of its transistors."""

import numpy as np
import pytest

from chips.rolls import portrait as rolls_portrait
from chips.rolls.circuit import Params
from chips.rolls.neuron.model import neurons_of
from chips.rolls.portrait import DC, Portrait, dc_currents, neuron_devices, portrait, rates, rheobase
from chips.rolls.program.bias_file import default_biases
from chips.rolls.tables import prepare
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180_IDEAL, thermal_voltage
from circuits.silicon.silicon import Silicon

OFF = default_biases().with_code(DC, 7, 0)


@pytest.fixture(scope="module")
def found() -> Portrait:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rolls_portrait, "MULTIPLES", np.array([0.5, 3.0, 9.0]))
        return portrait(default_biases(), Silicon(ROLLS_180_IDEAL, 27.0, Die(number=1003, process=False)))


def test_curves_rise_from_silence(found: Portrait) -> None:
    assert found.rates.shape == (3, 256)
    assert not found.rates[0].any()
    assert (np.diff(found.rates[1:], axis=0) > 0.0).all()
    assert found.nominal_rates[1] == pytest.approx(found.rates[1].mean(), rel=0.02)


def test_every_neuron_fires_by_the_default_current(found: Portrait) -> None:
    # IF_DC_P of the control software, 87.5 nA, is some 700 times the threshold
    assert found.restless.all()


def test_the_time_constant_spreads_as_the_area_of_its_leak(found: Portrait) -> None:
    # ml4 is 1 um by 9 um and in weak inversion; 256 neurons tell a CV to 4.4 % (standard error)
    sigma = ROLLS_180_IDEAL.pair_a_vt / np.sqrt(2.0 * 9e-12)
    expected = ROLLS_180_IDEAL.n.kappa * sigma / thermal_voltage(27.0)
    assert np.log(found.tau).std() == pytest.approx(expected, rel=0.12)


def test_an_event_brings_its_current_for_the_length_of_a_pulse(found: Portrait) -> None:
    assert [w.level for w in found.weights] == [1, 2, 3, 4, -1, -2, -3, -4]
    length = found.pulses.mean()
    for w in found.weights:
        # the mirror comes late, most at the weakest level, and the die's mean is not the codes' sum
        assert 0.85 < w.charge / (w.current * length) < 1.05
        assert w.current == pytest.approx(w.nominal, rel=0.1)
        assert w.charge_cv > 0.01


def test_the_threshold_is_where_the_neuron_begins_to_fire() -> None:
    silicon = Silicon(ROLLS_180_IDEAL)
    d = neuron_devices(Params(), OFF, "gate", silicon)
    m = neurons_of(d, prepare(Params(), ROLLS_180_IDEAL).neuron)
    one = rolls_portrait.neurons_chosen(m, np.array([7]))
    threshold = float(rheobase(m)[7])
    # 5 %: the table has 257 points over v_mem
    around = np.array([[0.95 * threshold], [1.05 * threshold]])
    below, above = rates(one, around, np.array([0.4, 0.4]))[:, 0]
    assert below == 0.0
    assert above > 0.0


def test_dc_transistors_of_the_nominal_die_give_the_nominal_current() -> None:
    d = neuron_devices(Params(), OFF, "gate", Silicon(ROLLS_180_IDEAL))
    currents = np.array([1e-10, 1e-8])
    assert dc_currents(d, d, currents) == pytest.approx(np.tile(currents[:, None], 256), rel=1e-9)


def test_missing_levels_are_told() -> None:
    table = default_biases().with_code("NPA_WEIGHT_EXC0_P", 2, 0)
    assert set(rolls_portrait.weight_program(table, ()).levels.ravel().tolist()) == {1, 3, -1, -2, -3, -4}
