"""Codes bring a die's times to the design's, as near as codes come; only the parts that are asked for."""

import numpy as np
import pytest

from chips.latency.calibration import calibrated
from chips.latency.errors import usual_design
from chips.latency.model import lumped, usual_biases
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

DESIGN = usual_design()
CODE = 0.018  # half a step of the coarsest fine codes, 1.6 %, and what other codes changed since


@pytest.mark.parametrize("kind", ["gate", "ideal"])
def test_every_part_comes_to_its_time(kind: BiasKind) -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=11))
    found = lumped(DESIGN, calibrated(DESIGN, silicon, kind), silicon)
    wanted = lumped(DESIGN, usual_biases(DESIGN, kind), Silicon(AMI_1500_IDEAL))
    assert found.tap == pytest.approx(wanted.tap, rel=CODE)
    assert found.race / found.passive == pytest.approx(wanted.race / wanted.passive, rel=CODE)
    assert found.hold.mean() == pytest.approx(wanted.hold.mean(), rel=CODE)


def test_what_is_not_asked_for_stays() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=11))
    usual = lumped(DESIGN, usual_biases(DESIGN), silicon)
    found = lumped(DESIGN, calibrated(DESIGN, silicon, parts=("taps",)), silicon)
    assert np.array_equal(found.hold, usual.hold)
    assert not np.array_equal(found.tap, usual.tap)


def test_another_part_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"latency_chip\.calibration: lamps, must be one of taps"):
        calibrated(DESIGN, Silicon(AMI_1500_IDEAL), parts=("lamps",))
