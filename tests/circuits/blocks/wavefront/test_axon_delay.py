"""The axonal delay follows its code, is undone by the reset, and works with both kinds of bias."""

from dataclasses import replace

import pytest

from circuits.bias import rebias
from circuits.blocks.wavefront.axon_delay import (
    BIASES,
    BITS,
    BLOCK,
    Params,
    bit_capacitance,
    build,
    code_voltages,
)
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from tests.circuits.blocks.values import number

DEFAULTS = BLOCK.defaults


def run(temperature: float = 27.0, kind: BiasKind | None = None, **stimuli: float | None) -> Result:
    circuit = rebias(build(), kind=kind)
    return simulate(
        BLOCK.testbench(circuit, DEFAULTS | stimuli, 5.0), Silicon(AMI_1500_IDEAL, temperature_c=temperature)
    )


def test_every_bias_but_the_code_has_a_value() -> None:
    ports = {p.name for p in build().ports if p.kind == "bias"}
    assert {b.port for b in BIASES} == ports - {"v_code"}


@pytest.mark.parametrize("code", [1, 7, 31])
def test_the_delay_is_the_code_in_units_of_100_us(code: int) -> None:
    found = BLOCK.measures(run(code=code))
    # the integral non-linearity, 0.037 % of 3.1 ms, and 0.1 us of offset
    assert number(found["delay_s"]) == pytest.approx(code * 100e-6, abs=1.3e-6)
    assert BLOCK.outcome(run(code=code)) == "delayed"


def test_the_reset_is_quick_and_the_ramp_falls_to_ground() -> None:
    result = run(code=7)
    # a fiftieth of a unit
    assert 0.0 < number(BLOCK.measures(result)["recovery_s"]) < 2e-6
    assert result["ramp"].max() < 5.05
    # at the reset the gates' overlap pushes it 12 mV below ground
    assert result["ramp"].min() == pytest.approx(0.0, abs=0.02)


def test_floating_plates_stay_between_the_rails() -> None:
    result = run(code=1)
    for k in range(1, BITS):
        assert -0.01 < result[f"plate{k}"].min() < 1.0
        assert result[f"plate{k}"][-1] == pytest.approx(5.0, abs=0.05)


def test_a_gate_voltage_drifts_and_a_generator_follows_absolute_temperature() -> None:
    warm = {kind: number(BLOCK.measures(run(60.0, kind))["delay_s"]) for kind in ("gate", "ideal")}
    assert warm["ideal"] == pytest.approx(700e-6 * 300.15 / 333.15, rel=0.002)
    # the threshold falls by 33 mV at 27/V and U_T grows: several % a kelvin
    assert 0.2 < warm["gate"] / 700e-6 < 0.5


def test_a_short_run_shows_no_step() -> None:
    result = run(code=31, duration=1e-3)
    assert BLOCK.outcome(result) == "none"
    assert BLOCK.measures(result)["delay_s"] is None


@pytest.mark.parametrize("code", [-1.0, 32.0, 2.5])
def test_a_code_that_is_none_is_refused(code: float) -> None:
    with pytest.raises(ParameterError, match=r"code: .*whole number from 0 to 31"):
        run(code=code)


def test_codes_are_written_least_bit_first() -> None:
    assert code_voltages(6, 5.0) == (0.0, 5.0, 5.0, 0.0, 0.0)


def test_a_bit_adds_its_weight() -> None:
    parasitic = 2.0 * 3e-6 * (0.2e-9 + 1.5e-9)  # overlap and junction of the switch and of the reset
    c = bit_capacitance(200e-15)
    assert c**2 / (c + parasitic) == pytest.approx(200e-15, rel=1e-12)


def test_a_size_that_is_none_is_refused() -> None:
    with pytest.raises(ParameterError, match="unit_capacitance: 0 F, must be > 0"):
        replace(Params(), unit_capacitance=0.0)
