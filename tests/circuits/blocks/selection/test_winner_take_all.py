"""The best direction wins, at every temperature, in a time that grows as one over the contrast."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.blocks.selection.winner_take_all import (
    BLOCK,
    CELLS,
    RELEASE,
    Params,
    build,
    decision_testbench,
    lines_high,
)
from circuits.errors import ParameterError
from circuits.lowering.check import check_circuit
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.power import drain_current
from circuits.solver.transient import Result, simulate
from tests.circuits.blocks.values import number

DEFAULTS = BLOCK.defaults
CIRCUIT = build()
PAIR: dict[str, float | None] = {"winner": 3, "rival": 5, "obstacle": None}  # both see as many neighbours


def run(silicon: Silicon | None = None, **stimuli: float | None) -> Result:
    return simulate(BLOCK.testbench(CIRCUIT, DEFAULTS | stimuli, 5.0), silicon or Silicon(AMI_1500_IDEAL))


def test_the_circuit_is_sound_and_so_is_the_whole_selection() -> None:
    check_circuit(CIRCUIT)
    whole = build(Params(cells=CELLS))
    check_circuit(whole)
    assert whole.port("line").shape == (33,)
    assert [i.shape for i in whole.instances] == [(33,)]


@pytest.mark.parametrize("winner", [0, 4, 8])
def test_the_greatest_excitation_wins_at_the_edges_too(winner: int) -> None:
    result = run(winner=winner, rival=3, obstacle=None)
    assert BLOCK.outcome(result) == str(winner)
    found = BLOCK.measured(result)
    assert found["winner"] == winner
    # 50 nA and 0.7 pF: some microseconds; the whole run has 30 of them
    assert 1e-6 < number(found["decision_s"]) < 30e-6
    assert number(found["margin_V"]) > 0.02  # of the order of U_T / kappa
    assert 0.0 < number(found["supply_power_W"]) < 100e-6


@pytest.mark.parametrize("temperature", [-20.0, 27.0, 85.0])
def test_the_equalised_state_is_a_stable_rest_without_a_winner(temperature: float) -> None:
    point = operating_point(
        BLOCK.testbench(CIRCUIT, DEFAULTS, 5.0), Silicon(AMI_1500_IDEAL, temperature_c=temperature)
    )
    assert point.stable
    assert not point.others
    inputs = [point[f"v_in[{k}]"] for k in range(9)]
    assert np.ptp(inputs) < 1e-3  # the switches' resistance, some kOhm, times tens of nA
    assert max(point[f"line[{k}]"] for k in range(9)) < 0.1


@pytest.mark.parametrize("temperature", [-20.0, 85.0])
def test_it_decides_cold_and_hot(temperature: float) -> None:
    assert BLOCK.outcome(run(Silicon(AMI_1500_IDEAL, temperature_c=temperature))) == "4"


def test_a_risk_takes_a_gaussian_from_its_neighbourhood() -> None:
    """Currents of the mirrors of one risk in the equalised state, over what flows into it."""
    risk = np.zeros(9)
    risk[4] = 10e-9
    bench = decision_testbench(CIRCUIT, np.full(9, 50e-9), risk, RELEASE, 5.0)
    result = simulate(bench, Silicon(AMI_1500_IDEAL))
    found = [drain_current(result, f"mg{k}_{4 - k + 3}")[0] / 10e-9 for k in range(1, 8)]
    expected = np.exp(-((np.arange(-3, 4) / 2.0) ** 2))
    assert found == pytest.approx(expected, rel=1e-3)


def test_inhibition_changes_the_winner() -> None:
    """The rival is 5 % below; an obstacle beside the winner takes e^-1/4 of its risk from it."""
    assert BLOCK.outcome(run(obstacle=3, risk=2e-9, rival=8, duration=120e-6)) == "4"
    assert BLOCK.outcome(run(obstacle=3, risk=5e-9, rival=8, duration=120e-6)) == "8"


def test_the_time_grows_as_one_over_the_contrast() -> None:
    """A logarithm would add the same for every decade; here it is ten times as long.

    Between contrasts of 3e-3 and 3e-4 the slope in logarithms is -1 within 5 %: what does not grow, the line
    and the others, is 10 us and less of 170 us.
    """
    contrasts = np.array([3e-3, 1e-3, 3e-4])
    times = [
        number(BLOCK.measures(run(**PAIR, contrast=c, duration=RELEASE + 1e-6 / c))["decision_s"])
        for c in contrasts
    ]
    slope = np.polyfit(np.log(contrasts), np.log(times), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.05)


def test_a_tie_is_not_decided() -> None:
    result = run(**PAIR, contrast=0.0, duration=200e-6)
    assert BLOCK.outcome(result) == "undecided"
    assert lines_high(result).size == 0
    found = BLOCK.measures(result)
    assert found["winner"] is None
    assert found["decision_s"] is None
    assert found["margin_V"] is None
    # both have half of the tail
    assert result["v_in[3]"][-1] == pytest.approx(result["v_in[5]"][-1], abs=1e-3)


def test_several_lines_would_be_a_tie() -> None:
    result = run()
    high = result["line[4]"]
    voltage = result.voltage.copy()
    voltage[:, result.nodes.index("line[5]")] = high
    assert BLOCK.outcome(replace(result, voltage=voltage)) == "tie"


def test_without_excitation_above_the_risks_nobody_wins() -> None:
    bench = decision_testbench(CIRCUIT, np.full(9, 5e-9), np.full(9, 20e-9), 60e-6, 5.0)
    assert BLOCK.outcome(simulate(bench, Silicon(AMI_1500_IDEAL))) == "undecided"


def test_a_size_or_a_stimulus_that_is_none_is_refused() -> None:
    with pytest.raises(ParameterError, match="cells: 1, must be a whole number from 2 to 64"):
        Params(cells=1)
    with pytest.raises(ParameterError, match="reach: -1, must be a whole number from 0 to 64"):
        Params(reach=-1)
    with pytest.raises(ParameterError, match="sigma: 0, must be > 0"):
        Params(sigma=0.0)
    with pytest.raises(ParameterError, match="winner: 9, must be a cell from 0 to 8, or off"):
        run(winner=9)
    with pytest.raises(ParameterError, match="contrast: 2, must be > 0 and 0 to 1"):
        run(contrast=2.0)
