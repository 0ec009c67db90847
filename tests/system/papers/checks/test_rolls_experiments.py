"""Experiments on ROLLS: drift, mismatch and published forms, on a part of their box."""

import math

import pytest
from matplotlib.figure import Figure

from chips.rolls import spread as rolls_spread
from chips.rolls.program.bias_file import default_biases
from chips.rolls.spread import parts_of
from circuits.bias import rebias
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.silicon.process import ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from system.papers.checks import rolls_drift, rolls_forms, rolls_mismatch


def test_drift_of_currents_follows_the_law(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rolls_drift, "QUANTITIES", rolls_drift.QUANTITIES[:2])
    done: list[float] = []
    report = rolls_drift.run(done.append)
    assert report.agrees
    assert done[-1] == 1.0
    slopes = {row.name: row.shown for row in report.rows}
    assert slopes["filter_current_ideal_per_K"] == pytest.approx(1.0 / 300.15, rel=1e-3)
    assert isinstance(slopes["filter_current_gate_per_K"], float)
    assert 0.038 < slopes["filter_current_gate_per_K"] < 0.056
    report.draw(Figure())


def test_a_period_of_a_fixed_gate_falls_as_its_current_rises() -> None:
    pulse = rolls_drift.QUANTITIES[-1]
    low, high = (rolls_drift.measured(pulse, "gate", t) for t in (22.0, 32.0))
    expected = rolls_drift.derived_slope(pulse, "gate")
    assert (high / low - 1.0) / 10.0 == pytest.approx(expected, rel=0.15)  # a slope over 10 K, to first order


def test_a_derived_slope_is_the_facts_formula_in_weak_inversion() -> None:
    """The slow leak, 2.3 pA in 1 um by 9 um: I / I_S is 1e-4, G 0.994."""
    circuit = rebias(rolls_neuron.build(), kind="gate")
    u_t = 1.380649e-23 * 300.15 / 1.602176634e-19
    n = ROLLS_180_IDEAL.n
    below = -u_t / n.kappa * _log_inversion(2.34375e-12)
    facts = 0.5 / 300.15 + n.kappa * 1e-3 / u_t + n.kappa * below / (u_t * 300.15)
    assert rolls_drift.current_slope(circuit, "i_tau1", "gate") == pytest.approx(facts, rel=0.01)


def _log_inversion(current: float) -> float:
    """Ln(I / I_S) of ml3."""
    n, u_t = ROLLS_180_IDEAL.n, 1.380649e-23 * 300.15 / 1.602176634e-19
    return math.log(current / (2.0 * n.mu_cox * u_t**2 / n.kappa / 9.0))


def test_mismatch_of_filters_agrees_and_the_published_figure_stands_beside(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for module in (rolls_spread, rolls_mismatch):
        monkeypatch.setattr(module, "RATES", (200.0,))
    parts = parts_of(default_biases(), Silicon(ROLLS_180_IDEAL))
    monkeypatch.setattr(rolls_mismatch, "parts_of", lambda *_: parts)
    report = rolls_mismatch.run_on(lambda _: None, (1002,))
    rows = {row.name: row for row in report.rows}
    # one die tells a CV half as well as four
    assert rows["excitatory_time_constant_cv"].agrees
    assert rows["correlation_excitatory_time_constant_and_excitatory_gain"].agrees
    beside = rows["neuron_mismatch"]
    assert beside.paper == 0.094
    assert isinstance(beside.shown, float)
    assert 0.01 < beside.shown < 0.5
    assert any("leak.ml4 100 %" in note for note in report.notes)
    report.draw(Figure())


def test_forms_are_told_by_how_much_each_is_off(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rolls_forms, "LEVELS", (4,))
    monkeypatch.setattr(rolls_forms, "TRAINS", ((1000.0, 5),))
    monkeypatch.setattr(rolls_forms, "CURRENTS", (1.22e-9,))
    monkeypatch.setattr(rolls_forms, "LENGTH", 25e-3)
    report = rolls_forms.run(lambda _: None)
    # after a train so short there is no decay to be measured, and its row says so
    assert report.disagreeing == ("synapse_decay_output_kappa_s",)
    rows = {row.name: row for row in report.rows}
    jump = rows["synapse_mean_jump_level4_1000Hz_A"]
    assert isinstance(jump.paper, float)
    assert isinstance(jump.shown, float)
    assert abs(jump.paper / jump.shown - 1.0) > 0.5
    ours = rows["neuron_rate_both_kappas_1.22nA_Hz"]
    assert ours.rule.tolerance == 0.1
    assert ours.agrees
    assert rows["neuron_rate_ahp_once_Hz"].agrees
    report.draw(Figure())
