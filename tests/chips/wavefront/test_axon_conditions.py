"""Where a die's axons stand in the record: currents by the law, derivatives, and the record's limits."""

from dataclasses import replace

import numpy as np
import pytest

from chips.wavefront.axon_conditions import (
    SINK,
    axon_tables,
    carried,
    check_local,
    conditions,
    process_shifts,
)
from chips.wavefront.model import axon_model
from circuits.bias import die_current, rebias
from circuits.blocks.wavefront import axon_delay
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.lowering.on_die import standing
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500, AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon

CIRCUIT = axon_delay.build()


def test_under_the_full_law_both_currents_are_those_of_drains_that_are_far() -> None:
    silicon = Silicon(AMI_1500, 60.0, Die(number=1000, mismatch=False))
    devices = standing(CIRCUIT, silicon)
    model = axon_model(CIRCUIT, AMI_1500)
    found = conditions(axon_tables(model, silicon), silicon, process_shifts(silicon))
    expected = float(devices.saturated(SINK, devices.gate["v_delay"])[0])
    assert np.exp(found.log_current) == pytest.approx(expected, rel=1e-12)
    share, shifts = np.empty(2), np.array([0.0, 2e-3])
    carried(found, shifts, share)
    assert found.specific_current * share[0] == pytest.approx(expected, rel=1e-12)
    moved = float(devices.saturated(SINK, devices.gate["v_delay"] - 2e-3)[0])
    assert found.specific_current * share[1] == pytest.approx(moved, rel=1e-12)


@pytest.mark.parametrize("kind", ["gate", "ideal", "generator"])
@pytest.mark.parametrize("temperature", [0.0, 27.0, 60.0])
def test_the_sink_s_current_is_the_law_s_on_the_die(kind: BiasKind, temperature: float) -> None:
    circuit = rebias(CIRCUIT, kind=kind)
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=temperature, die=Die(number=1000, mismatch=False))
    found = conditions(axon_tables(axon_model(circuit), silicon), silicon, process_shifts(silicon))
    expected = die_current(circuit, circuit.bias("i_delay"), silicon)
    assert np.exp(found.log_current) == pytest.approx(expected, rel=1e-9)
    half = found.pinch
    assert found.specific_current * np.logaddexp(0.0, half) ** 2 == pytest.approx(expected, rel=1e-9)


def test_fixed_gates_are_found_once_and_a_generator_s_on_every_die() -> None:
    assert axon_tables(axon_model(CIRCUIT), Silicon(AMI_1500_IDEAL)).gates is not None
    assert axon_tables(axon_model(rebias(CIRCUIT, kind="ideal")), Silicon(AMI_1500_IDEAL)).gates is None


def test_the_derivatives_by_the_current_are_those_of_the_value() -> None:
    model = axon_model(CIRCUIT)
    step = 1e-3
    at = [
        conditions(
            axon_tables(
                replace(model, circuit=rebias(CIRCUIT, {"i_delay": 3e-9 * np.exp(s)})),
                Silicon(AMI_1500_IDEAL),
            ),
            Silicon(AMI_1500_IDEAL),
            process_shifts(Silicon(AMI_1500_IDEAL)),
        ).log_charge
        for s in (-step, 0.0, step)
    ]
    # central differences of a cubic: exact but for rounding, 1e-16 / step^2
    assert (at[2][0] - at[0][0]) / (2.0 * step) == pytest.approx(at[1][1], rel=1e-4, abs=1e-6)
    assert (at[2][0] - 2.0 * at[1][0] + at[0][0]) / step**2 == pytest.approx(at[1][2], rel=1e-3, abs=1e-6)


def test_what_lies_outside_the_record_is_refused_by_name() -> None:
    model = axon_model(rebias(CIRCUIT, {"i_cmp": 1e-9}))
    with pytest.raises(ParameterError, match=r"axon_delay\.i_cmp: 1e-09 A, must be 3e-09 to 3e-06 A"):
        conditions(
            axon_tables(model, Silicon(AMI_1500_IDEAL)),
            Silicon(AMI_1500_IDEAL),
            process_shifts(Silicon(AMI_1500_IDEAL)),
        )
    with pytest.raises(ParameterError, match=r"axon_delay\.temperature: -40 degC, must be -10 to 65 degC"):
        axon_tables(model, Silicon(AMI_1500_IDEAL, temperature_c=-40.0))
    check_local(model, np.array([[0.05, 0.05, -0.05, -0.05]]))  # both of a pair, by a gradient
    with pytest.raises(ParameterError, match=r"mc\.v_t0_shift: 0\.05 V, must be -0\.04 to 0\.04 V"):
        check_local(model, np.array([[0.0, 0.1, 0.0, 0.0]]))
    with pytest.raises(ParameterError, match=r"pair\.v_t0_shift: 0\.13 V, must be -0\.12 to 0\.12 V"):
        check_local(model, np.array([[0.0, 0.0, 0.13, 0.13]]))
