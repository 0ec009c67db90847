"""Currents give the design's times; codes come near them; what cannot be built is refused."""

from dataclasses import replace

import numpy as np
import pytest

from chips.latency.design import Charges, gate_voltages, lines_of
from chips.latency.errors import usual_design
from chips.latency.model import nominal_charges, usual_biases
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from tests.refusals import refusals

DESIGN = usual_design()
CHARGES = Charges(1e-11, 1.1e-11, 1e-11, 2e-11, 2e-11, 2.1e-11, 1e-11, 14e-6)


def test_a_current_is_a_charge_over_a_time() -> None:
    lines = lines_of(DESIGN, CHARGES)
    assert lines["window"].current == pytest.approx(1e-11 / 3e-3)
    assert lines["passive"].current == pytest.approx(np.full(33, 2e-11 / 58e-3))
    assert 1.1e-11 / lines["tap"].current[1:] + 14e-6 == pytest.approx(np.full(15, 3e-3))
    # a standard deviation of one path
    assert lines["inhibit"].current[1] / lines["inhibit"].current[0] == pytest.approx(np.exp(-0.5))


def test_a_fixed_gate_knows_no_die_and_the_others_do() -> None:
    for kind, same in (("gate", True), ("ideal", False), ("generator", False)):
        biases = usual_biases(DESIGN, kind)  # type: ignore[arg-type]
        found = [gate_voltages(biases, Silicon(AMI_1500_IDEAL, die=Die(number=n)))["tap"] for n in (1, 2)]
        assert np.array_equal(*found) is same


test_what_cannot_be_built_is_refused = refusals(
    ParameterError,
    lambda changes: replace(DESIGN, **changes),
    [
        ({"share": (1.0,) * 3}, "latency_chip.paths: 33 groups and 3 passive currents"),
        ({"taps": 0}, "latency_chip.taps: 0, must be a whole number"),
        ({"second": (2e-3,)}, "latency_chip.group: must be 0 to 0"),
        ({"hop": 0.0}, "latency_chip.hop: 0, must be > 0"),
    ],
)


def test_the_nominal_charges_are_capacitors_and_their_parasitics() -> None:
    q = nominal_charges()
    # 5 and 10 pF to 2 V, and gates and junctions: up to 3 %
    assert 1.0 < q.timer / 10e-12 < 1.03
    assert 1.0 < q.race / 20e-12 < 1.03
    assert DESIGN.span == pytest.approx(4.6e-3 + 45e-3)
