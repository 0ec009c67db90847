"""What is in the record is what the circuits do."""

import math

import numpy as np
import pytest

from chips.lso.law import Comparator, Membrane, ramp_delay, spike_delay
from chips.lso.measure import (
    AT,
    LEVEL_AXON,
    LEVEL_COMPARATOR,
    SLOPES,
    WEAK,
    circuits,
    heard,
    level_delay,
    level_kappa,
    level_numbers,
    own_current,
    passed,
    spike_kappa,
)
from chips.measured.perturbation import deviations_of
from chips.measured.timer import COMPARATOR
from chips.record import kept_record
from circuits.bias import rebias
from circuits.blocks.latency.synapse import REFERENCE
from circuits.errors import SolverError
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon


def test_a_pair_moves_its_reference_by_its_own_offset() -> None:
    data = kept_record("lso_neuron")
    timer = dict(zip(deviations_of(COMPARATOR), np.asarray(data["comparator"])[2], strict=True))
    level = dict(zip(deviations_of(LEVEL_COMPARATOR), np.asarray(data["level"])[2], strict=True))
    # ln Q moves by dV / V_ref, 1/2 a volt, with the sign of the input that the device is at
    assert timer["mc1.v_t0"] == pytest.approx(0.5, rel=0.05)
    assert timer["mc2.v_t0"] == pytest.approx(-0.5, rel=0.05)
    # a level unit's threshold by dV, its mirror by less
    assert level["mc1.v_t0"] == pytest.approx(-1.0, rel=1e-3)
    assert level["mc2.v_t0"] == pytest.approx(1.0, rel=1e-3)
    assert 0.0 < level["mc4.v_t0"] < 1.0


def test_the_nominal_level_unit_is_the_records() -> None:
    level = rebias(circuits()[1], {}, "ideal")
    offset, charge, lag = level_numbers(level, Silicon(AMI_1500_IDEAL))
    data = kept_record("lso_neuron")
    at = data.numbers("temperature").index(27.0), 0, data.numbers("shift").index(0.0)
    assert offset == pytest.approx(float(data["level_offset"][at]), abs=1e-6)
    assert charge == pytest.approx(float(data["level_charge"][at]), rel=1e-4)
    assert lag * own_current(level, "i_cmp", Silicon(AMI_1500_IDEAL)) == pytest.approx(
        float(data["level_lag"][at]), rel=1e-3
    )


@pytest.mark.parametrize("slope", [400.0, 1e3, 1e4, 3e4])
def test_a_level_unit_is_as_late_as_its_law(slope: float) -> None:
    """On ramps between those that the record is of and beyond, from 12 to 70 us."""
    level, silicon = rebias(circuits()[1], {}, "ideal"), Silicon(AMI_1500)
    offset, charge, lag = level_numbers(level, silicon)
    current = own_current(level, "i_cmp", silicon)
    kappa = float(level_kappa(level, silicon, current))
    found = offset / slope + lag + float(ramp_delay(slope, charge, current, kappa, silicon.thermal_voltage))
    assert found == pytest.approx(level_delay(level, silicon, slope), rel=0.015)


def test_thresholds_of_the_axon_move_its_charge() -> None:
    data = kept_record("lso_neuron")
    found = dict(zip(deviations_of(LEVEL_AXON), np.asarray(data["axon"])[2], strict=True))
    # its input must rise by what the nFET's threshold does, of some 2.5 V; the pFET helps
    assert 0.5 < found["ma3.v_t0"] < 2.0
    assert found["ma1.v_t0"] < 0.0


def test_a_mirror_takes_what_it_is_given() -> None:
    # its law is in the model: what is left over is the solver's
    assert np.asarray(kept_record("lso_neuron")["mirror"]) == pytest.approx(1.0, abs=2e-3)


def test_a_ramp_without_a_spike_is_named() -> None:
    with pytest.raises(SolverError, match=r"sonar_head\.level: no spike in the run"):
        level_delay(
            rebias(circuits()[1], {}, "ideal"),
            Silicon(AMI_1500_IDEAL),
            SLOPES[-1],
            "comparator.mc7.v_t0",
            -0.2,
        )


@pytest.mark.parametrize(("times", "part"), [(2.0, 1.0), (6.0, 1.0), (1.0, 0.2), (6.0, 0.2), (3.0, 0.05)])
def test_a_membrane_s_comparator_is_as_late_as_its_law(times: float, part: float) -> None:
    """Ramps and tails between and beyond those of the record: from 10 to 100 us."""
    silicon, data = Silicon(AMI_1500), kept_record("lso_neuron", AMI_1500)
    at = data.numbers("temperature").index(27.0), 0, data.numbers("shift").index(0.0)
    lso = rebias(circuits()[0], {"i_exc": 6e-9 * times, "i_cmp": 50e-9 * part}, "ideal")
    run = heard(lso, silicon, excite_1=AT)
    current = own_current(lso, "i_cmp", silicon)
    along = math.log(part) / math.log(WEAK)
    spike, lag = (
        float(data[name][at]) * (1.0 - along) + float(data[f"{name}_weak"][at]) * along
        for name in ("spike", "lag")
    )
    comparator = Comparator(spike, current, float(spike_kappa(lso, silicon, current)), lag / current)
    charge = float(data["membrane"][at])
    membrane = Membrane(charge / REFERENCE, REFERENCE, 0.0, silicon.thermal_voltage, comparator)
    found = float(run.spikes["spike"][0]) - passed(run)
    assert spike_delay(membrane, own_current(lso, "i_exc", silicon), 0.0) == pytest.approx(found, rel=0.05)
