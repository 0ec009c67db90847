"""Calibration of a whole ROLLS die: what it measures, what it leaves out, and what a run makes of it."""

from __future__ import annotations

import numpy as np
import pytest

from chips.codes import Codes, key_of
from chips.rolls.calibration import Calibration as Found
from chips.rolls.chip import Spikes
from chips.rolls.program.bias_file import BiasTable, default_biases, shipped_biases
from circuits.arrays import F64
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.rolls import codes as rolls_codes
from system.rolls.codes import KNOB, calibrate_rolls, off_of, table_at
from system.rolls.run import Trace, run, summarise
from system.rolls.scenario import Scenario

NOMINAL, DRAWN = Silicon(ROLLS_180), Silicon(ROLLS_180, die=Die(number=3))
TABLE = shipped_biases("rolls_parallella")


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> F64:
    """Rates that the bench counts, those without events behind them; the search finds another code."""
    rates = np.full((2, 256), 100.0)
    rates[1] = 0.0
    counted = iter((rates[0], rates[0], rates[1]))
    monkeypatch.setattr(rolls_codes, "neuron_rates", lambda *_: next(counted))
    rolls_codes._nominal_rate.cache_clear()

    def searched(*_: object) -> Found:
        return Found(TABLE.with_code(KNOB, 6, 59), {}, {"neurons": 99.0}, {"neurons": 70.0}, 5)

    monkeypatch.setattr(rolls_codes, "calibrate", searched)
    return rates


def test_a_die_gets_the_code_that_was_found_and_is_measured_at_it(bench: F64) -> None:
    found = calibrate_rolls(DRAWN, "generator", TABLE)
    assert found.biases == {KNOB: ((6, 59),)}
    assert (found.failed, found.unmended, off_of(found)) == ("", (), ())
    assert [(m.wanted, m.before, m.after) for m in found.measured] == [(100.0, 70.0, 100.0)]
    assert table_at(TABLE, found).code(KNOB) == (6, 59)
    assert table_at(TABLE, None) == TABLE
    found.check("rolls", DRAWN, "generator", TABLE)


def test_neurons_that_cannot_be_used_are_left_out_with_their_reason(bench: F64) -> None:
    bench[0, 3], bench[0, 4], bench[1, 5] = 0.0, 201.0, 1.0
    found = calibrate_rolls(DRAWN, "generator", TABLE)
    assert off_of(found) == (3, 4, 5)
    assert found.unmended == (
        "neuron[3]: it is silent, switched off",
        "neuron[4]: it fires above 2 times the median rate, switched off",
        "neuron[5]: it fires without events, switched off",
    )


def test_a_die_most_of_which_is_silent_cannot_be_used(bench: F64) -> None:
    bench[0, :130] = 0.0
    assert calibrate_rolls(DRAWN, "generator", TABLE).failed == "130 of 256 neurons cannot be used"


def test_the_nominal_die_is_what_others_are_brought_to(bench: F64) -> None:
    found = calibrate_rolls(NOMINAL, "generator", TABLE)
    assert found.biases == {KNOB: (TABLE.code(KNOB),)}
    assert found.measured[0].before == found.measured[0].wanted


def test_what_is_left_out_gets_no_events_and_counts_in_no_number() -> None:
    scenario = Scenario(die=Die(number=3), duration=0.12, codes="default")
    plain = run(scenario)
    rates = plain.rates.copy()
    rates[7] = 0.0
    none = Spikes(np.empty(0), np.empty(0, np.int64))
    found = summarise(Trace(scenario, none, rates, np.arange(256) == 7, plain.chip, off=(7,)))
    assert (found["silent"], found["restless"], found["off"]) == (0.0, 0.0, 1.0)
    assert plain.off == ()


def test_a_run_takes_its_codes_and_those_of_another_table_are_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def codes(table: BiasTable) -> Codes:
        return Codes("rolls", key_of(DRAWN, "generator", table), 27.0, {KNOB: ((6, 59),)}, {"neuron": (2,)})

    made = codes(default_biases())
    monkeypatch.setattr(Scenario, "codes_of", lambda *_, **__: made)
    trace = run(Scenario(die=Die(number=3), duration=0.12))
    assert trace.off == (2,)
    assert trace.chip.program.biases.code(KNOB) == (6, 59)
    with pytest.raises(ValueError, match="codes of rolls: setup"):
        made.check("rolls", DRAWN, "generator", TABLE)
