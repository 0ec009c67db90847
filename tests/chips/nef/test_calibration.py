"""A bench that counts spikes and reads a pad brings a die to the design, by codes of its generator."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from chips.codes import Codes
from chips.nef.calibration import (
    NAME,
    calibrated,
    coded,
    designed,
    neurons_of,
    settled,
    usual_codes,
    usual_currents,
    with_currents,
)
from chips.nef.chip import NefChip
from chips.nef.devices import TAUS, set_tau
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon

SILICON = Silicon(ROLLS_180, 27.0, Die(number=7))
COUNT = 256


@pytest.fixture(scope="module")
def codes() -> Codes:
    return calibrated(SILICON, "generator", (), COUNT)


def test_a_die_comes_to_the_design(codes: Codes) -> None:
    assert codes.failed == ""
    off = {m.name: (abs(m.before / m.wanted - 1.0), abs(m.after / m.wanted - 1.0)) for m in codes.measured}
    assert max(before for before, _ in off.values()) > 0.1
    # a code is half a step off at most: 1.5 % where ranges meet, and 4 % at the least current of a filter
    assert max(after for name, (_, after) in off.items() if name != f"tau[{len(TAUS) - 1}]") < 0.03
    assert off[f"tau[{len(TAUS) - 1}]"][1] < 0.06


def test_a_chip_at_codes_has_what_the_bench_told(codes: Codes) -> None:
    chip = NefChip(SILICON.die, neurons=COUNT, codes=codes).at(27.0)
    asked = np.array([2e-3, 8e-3, 0.1])  # one of them between two that have codes
    assert chip.filters(asked).tau == pytest.approx(asked, rel=0.05)
    assert float(np.median(chip.law.leak / chip.law.charge)) == pytest.approx(54.3, rel=0.03)
    # at 37 degC the same codes are what they are there
    assert NefChip(SILICON.die, neurons=COUNT, codes=codes).at(37.0).biases == chip.biases


def test_what_spikes_tell_is_the_neurons_own() -> None:
    lines = usual_currents({})
    biases = with_currents(lines, "ideal", {})
    chip = NefChip(bias_kind="ideal", process=ROLLS_180_IDEAL, neurons=COUNT, codes=usual_codes(
        Silicon(ROLLS_180_IDEAL), "ideal"))  # fmt: skip
    found, here = neurons_of(Silicon(ROLLS_180_IDEAL), COUNT, biases), chip.at(27.0)
    # 256 neurons, a second each: a part in a thousand, and the mirror's leakage is left out
    assert found.charge == pytest.approx(here.law.charge[0] / here.unit, rel=0.01)
    assert found.leak == pytest.approx(here.law.leak[0] / here.law.charge[0], rel=0.02)
    assert found.refractory == pytest.approx(here.law.refractory[0], rel=0.01)


def test_the_nearest_round_is_kept() -> None:
    lines = {"i_leak": np.array([10e-12]), "i_tau": np.full(2, 20e-12)}
    found = settled(lines, lambda now: {"i_tau": np.array([30e-12, 15e-12]) / now["i_tau"]})
    assert found["i_leak"] is lines["i_leak"]
    assert found["i_tau"] == pytest.approx(coded(np.array([30e-12, 15e-12])))
    # a line that leaks goes no lower: what came nearest is kept
    floor = settled(lines, lambda now: {"i_leak": 1e-12 / np.maximum(now["i_leak"], 5e-12)})
    assert floor["i_leak"][0] <= 5.1e-12


def test_codes_of_time_constants_are_met_in_between() -> None:
    biases = with_currents(usual_currents({}), "generator", {})
    now = {b.name: b.value for b in set_tau(biases, 3.2e-3)}
    ends = usual_currents({})["i_tau"][2:4]
    assert ends[1] < float(np.ravel(now["i_tau"])[0]) < ends[0]


def test_a_healed_die_keeps_the_codes_of_the_die_before(codes: Codes) -> None:
    healed = SILICON.die.healed("nef_chip.neuron[3]")
    with pytest.raises(ParameterError, match=r"die A/7, the run has A/7, healed nef_chip\.neuron\[3\]"):
        NefChip(healed, neurons=COUNT, codes=codes)
    chip = NefChip(healed, neurons=COUNT, codes=codes, coded_on=SILICON.die)
    assert chip.at(27.0).biases == NefChip(SILICON.die, neurons=COUNT, codes=codes).at(27.0).biases


def test_codes_of_another_die_and_a_silent_chip_are_refused(codes: Codes) -> None:
    with pytest.raises(ParameterError, match=f"codes of {NAME}: die A/7, the run has A/8"):
        NefChip(Die(number=8), codes=codes)
    with pytest.raises(ParameterError, match="could not be calibrated, silent"):
        NefChip(SILICON.die, codes=replace(codes, failed="silent"))
    dead = {**usual_currents({}), "i_leak": np.array([1e-9])}
    with pytest.raises(ParameterError, match=r"nef-chip.rates: .* Hz at codes \(5, 16, 64\)"):
        neurons_of(SILICON, 16, with_currents(dead, "generator", {}))
    assert designed(ROLLS_180)[0].charge > 0.0
