"""The bias generator: currents of codes, temperature, mismatch, the floor at code 0, start-up.

Codes, PTAT slope and published spreads: facts on the ROLLS bias generator (variation below 10 % in strong and
20 to 30 % in weak inversion; non-monotone steps at 32-code carries).
"""

from __future__ import annotations

import math
from dataclasses import replace
from statistics import stdev

import pytest

from circuits.blocks.bias.generator import BLOCK, Params, build, output_current, transistor_current
from circuits.devices import Source, Transistor
from circuits.devices.source import Constant
from circuits.errors import ParameterError, UnknownNameError
from circuits.generator.circuit import MASTER_CURRENT
from circuits.generator.code import COARSE, CODES, REFERENCE_C
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import OperatingPoint, operating_point, solve_near
from circuits.solver.transient import simulate
from circuits.testbench import Testbench
from tests.refusals import refusals

DEFAULTS = BLOCK.defaults
DIES = range(1000, 1020)
NOMINAL = Silicon(AMI_1500_IDEAL)


def nominal_current(params: Params, temperature_c: float = REFERENCE_C) -> float:
    """Current that a code stands for, A: `I_coarse fine / 256`, proportional to absolute temperature."""
    scale = (temperature_c + 273.15) / (REFERENCE_C + 273.15)
    return scale * COARSE[int(params.coarse)] * params.fine / CODES


def rest(coarse: int, fine: int, silicon: Silicon = NOMINAL, output: float = 2.5) -> OperatingPoint:
    circuit = build(Params(coarse, fine))
    sources = (Source("vdd", "vdd", Constant(5.0)), Source("i_out", "i_out", Constant(output)))
    return operating_point(Testbench("bias generator", circuit, sources, 1.0), silicon)


def current(coarse: int, fine: int, silicon: Silicon = NOMINAL) -> float:
    return output_current(rest(coarse, fine, silicon))


def off_current(silicon: Silicon) -> float:
    """Off current of the square nFET at the output: `I_0 W/L` with equation (1)'s `I_0`."""
    law = silicon.law("n")
    return law.square_current * math.exp(-law.kappa * law.v_t0 / law.u_t)


def with_changes(point: OperatingPoint, index: int, v_t0: float = 0.0, beta: float = 0.0) -> OperatingPoint:
    """The state with one transistor's V_T0 shifted (V) and its beta changed by a share."""
    kernel = point.machine.kernel
    v, i = kernel.transistors.v_t0.copy(), kernel.transistors.specific_current.copy()
    v[index] += v_t0
    i[index] *= 1.0 + beta
    changed = kernel._replace(transistors=kernel.transistors._replace(v_t0=v, specific_current=i))
    found = solve_near(replace(point.machine, kernel=changed), point.voltage)
    assert found is not None
    return found


def expected_spread(coarse: int, fine: int) -> float:
    """Standard deviation of ln I: the devices' variances by area, each by its sensitivity, summed."""
    point = rest(coarse, fine)
    transistors = [g.device for g in point.machine.flat.groups if isinstance(g.device, Transistor)]
    base, variance = math.log(output_current(point)), 0.0
    for k, device in enumerate(transistors):
        area = 2.0 * device.width * device.length * device.multiplicity
        by_v_t0 = (math.log(output_current(with_changes(point, k, v_t0=1e-4))) - base) / 1e-4
        by_beta = (math.log(output_current(with_changes(point, k, beta=1e-3))) - base) / 1e-3
        variance += (
            (by_v_t0 * AMI_1500_IDEAL.pair_a_vt) ** 2 + (by_beta * AMI_1500_IDEAL.pair_a_beta) ** 2
        ) / area
    return math.sqrt(variance)


def spread(coarse: int, fine: int) -> float:
    dies = (Silicon(AMI_1500_IDEAL, die=Die("A", number, process=False)) for number in DIES)
    return stdev(math.log(current(coarse, fine, silicon)) for silicon in dies)


@pytest.mark.parametrize("coarse", range(len(COARSE)))
@pytest.mark.parametrize("fine", [1, 64, 255])
def test_a_code_gives_its_current(coarse: int, fine: int) -> None:
    # 0.1 % of the current, from R's last digit, and the off current that the output copy adds
    found = current(coarse, fine)
    assert found == pytest.approx(
        nominal_current(Params(coarse, fine)), rel=1e-3, abs=2 * off_current(NOMINAL)
    )


def test_the_master_current_is_the_stated_one() -> None:
    point = rest(5, 125)
    assert transistor_current(point, "m1") == pytest.approx(MASTER_CURRENT, rel=1e-3)
    # m2 in weak inversion: U_T ln 8 over the resistor, 10 % more for the core's inversion coefficient of 0.1
    assert point["core_r"] == pytest.approx(Silicon(AMI_1500_IDEAL).thermal_voltage * math.log(8.0), rel=0.12)


def test_current_rises_with_every_fine_code_on_the_nominal_die() -> None:
    """Bits add up, so a step depends on the lowest bit that is set alone, but for what all draw together."""
    for lowest in (2**bit for bit in range(8)):
        for code in {lowest, 256 - lowest}:
            step = current(5, code) - current(5, code - 1)
            assert step == pytest.approx(COARSE[5] / 256, rel=0.01)


@pytest.mark.parametrize("coarse", [0, 7])
def test_current_rises_by_a_step_at_every_carry_of_the_outer_ranges(coarse: int) -> None:
    for carry in (1, 2, 4, 8, 16, 32, 64, 96, 128, 160, 192, 224):
        rise = current(coarse, carry) - current(coarse, carry - 1)
        # the off current of the output is lost bit by bit as the first codes come
        assert rise == pytest.approx(COARSE[coarse] / 256, rel=1e-3, abs=0.6 * off_current(NOMINAL))


def test_dies_are_not_monotone_at_large_carries_as_published_generators_are() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die("A", 1000))

    def rises(fine: int) -> bool:
        return current(5, fine, silicon) > current(5, fine - 1, silicon)

    assert not all(rises(carry) for carry in range(32, 256, 32))
    assert all(rises(fine) for fine in range(17, 256, 32))


@pytest.mark.parametrize(("coarse", "fine"), [(0, 255), (2, 128), (5, 125)])
def test_current_is_proportional_to_absolute_temperature(coarse: int, fine: int) -> None:
    cold, hot = (current(coarse, fine, Silicon(AMI_1500_IDEAL, temperature_c=t)) for t in (17.0, 37.0))
    slope = (hot - cold) / 20.0 / current(coarse, fine)
    assert slope == pytest.approx(1.0 / 300.15, rel=0.05)  # +0.33 %/K
    for temperature in (0.0, 60.0):
        found = current(coarse, fine, Silicon(AMI_1500_IDEAL, temperature_c=temperature))
        assert found == pytest.approx(nominal_current(Params(coarse, fine), temperature), rel=0.01)


@pytest.mark.parametrize("temperature", [0.0, 27.0, 85.0])
def test_code_0_leaves_the_off_current_of_the_output(temperature: float) -> None:
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=temperature)
    assert current(7, 0, silicon) == pytest.approx(off_current(silicon), rel=0.05)


def test_the_output_does_not_depend_on_its_voltage_nor_the_core_on_the_code() -> None:
    assert output_current(rest(5, 125, output=5.0)) == pytest.approx(output_current(rest(5, 125, output=1.0)))
    masters = [transistor_current(rest(*code), "m1") for code in ((0, 255), (7, 0))]
    assert masters[0] == pytest.approx(masters[1], rel=1e-6)


@pytest.mark.parametrize("code", [(0, 255), (5, 125), (7, 16)])
def test_spread_over_dies_follows_area(code: tuple[int, int]) -> None:
    # the standard deviation of 20 draws has a relative error of 1 / sqrt(2 * 19) = 16 %; within 3 of them
    assert spread(*code) == pytest.approx(expected_spread(*code), rel=0.5)


def test_spread_is_that_of_published_generators_in_size() -> None:
    assert spread(0, 255) < 0.10
    assert 0.10 < spread(7, 16) < 0.30


def test_a_mirror_in_weak_inversion_has_the_closed_sensitivity() -> None:
    point = rest(7, 16)
    names = [g.device.name for g in point.machine.flat.groups if isinstance(g.device, Transistor)]
    moved = output_current(with_changes(point, names.index("mout"), v_t0=1e-4))
    law = Silicon(AMI_1500_IDEAL).law("n")
    assert math.log(moved / output_current(point)) == pytest.approx(-law.kappa * 1e-4 / law.u_t, rel=0.01)


@pytest.mark.parametrize("corner", ["ss", "ff", "sf", "fs"])
@pytest.mark.parametrize("temperature", [-20.0, 85.0])
def test_it_starts_and_gives_its_current_at_every_corner(corner: str, temperature: float) -> None:
    silicon = Silicon(AMI_1500_IDEAL, temperature_c=temperature, die=Die(corner=corner))  # type: ignore[arg-type]
    found = current(2, 128, silicon)
    assert found == pytest.approx(nominal_current(Params(2, 128), temperature), rel=0.1)


@pytest.mark.parametrize("leakage", [0.0, 1e-9])
def test_the_working_state_is_the_only_one(leakage: float) -> None:
    # with junctions that leak 1 nA a metre, off currents alone would not start the core
    n, p = (replace(model, junction_leakage=leakage) for model in (AMI_1500_IDEAL.n, AMI_1500_IDEAL.p))
    process = replace(AMI_1500_IDEAL, n=n, p=p)
    bench = BLOCK.testbench(build(), DEFAULTS, 5.0)
    dead = {"core_n": 0.0, "core_p": 5.0, "kick": 0.0, "vdd": 5.0, "i_out": 2.5}
    point = operating_point(bench, Silicon(process), start=dead)
    assert transistor_current(point, "m1") == pytest.approx(MASTER_CURRENT, rel=0.02)
    assert point.stable
    assert point.others == ()
    assert abs(transistor_current(point, "mk4")) < 1e-3 * MASTER_CURRENT


test_codes_outside_the_ranges_are_refused = refusals(
    ParameterError,
    lambda sizes: Params(**sizes),
    [
        ({"coarse": 8}, "coarse: 8, must be a whole number from 0 to 7"),
        ({"fine": 256}, "fine: 256, must be a whole number from 0 to 255"),
        ({"core_ratio": 1.0}, "core_ratio: 1, must be > 1"),
        ({"core_resistance": 0.0}, "core_resistance: 0 Ohm, must be > 0"),
    ],
)


def test_an_unknown_transistor_is_named() -> None:
    with pytest.raises(UnknownNameError, match="bias_generator transistor m99"):
        transistor_current(rest(5, 125), "m99")


def test_measures_and_outcome_of_a_run() -> None:
    result = simulate(BLOCK.testbench(build(), DEFAULTS, 5.0), Silicon(AMI_1500_IDEAL))
    found = BLOCK.measured(result)
    assert found["output_current_A"] == pytest.approx(400e-12, rel=2e-3)
    assert found["master_current_A"] == pytest.approx(MASTER_CURRENT, rel=1e-3)
    # both core branches, the coarse currents, the start-up and little else
    assert found["supply_power_W"] == pytest.approx(5.0 * (2 * MASTER_CURRENT + sum(COARSE)), rel=0.01)
    assert BLOCK.outcome(result) == "started"
