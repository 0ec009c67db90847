"""The synapse of the teaching chip recovers at I over C, and its floor follows the threshold's bias."""

import pytest

from circuits.bias import rebias
from circuits.blocks.bench.bias import MASTERS, code_current
from circuits.blocks.bench.dpi_synapse import BLOCK, Params
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

SIZES = Params()


def numbers(params: Params = SIZES, **codes: int) -> dict[str, float | None]:
    currents = {f"i_{name}": code_current(MASTERS[0], fine, 1.0, 1.0) for name, fine in codes.items()}
    bench = BLOCK.bench(rebias(BLOCK.build(params), currents))
    return BLOCK.measures(simulate(bench, Silicon(ROLLS_180_IDEAL)))


@pytest.mark.parametrize("fine", [25, 40])
def test_v_syn_recovers_at_the_current_over_the_capacitor(fine: int) -> None:
    found, current = numbers(tau=fine), code_current(MASTERS[0], fine, 1.0, 1.0)
    # gates of three devices of 10 um^2 add to 2.08 pF; the last of the way back bends
    assert found["recovery_V_per_s"] == pytest.approx(current / 2.08e-12, rel=0.1)
    slower = Silicon(ROLLS_180_IDEAL).thermal_voltage / (ROLLS_180.p.kappa * found["recovery_V_per_s"])
    assert found["tau_s"] == pytest.approx(slower, rel=0.02)


def test_the_floor_follows_the_threshold_s_bias() -> None:
    high, low = numbers(thr=10)["floor_V"], numbers(thr=80)["floor_V"]
    # V_thr moves by U_T ln(8) / kappa_p, and v_syn with it
    moved = Silicon(ROLLS_180_IDEAL).thermal_voltage * 2.0794 / ROLLS_180.p.kappa
    assert high - low == pytest.approx(moved, rel=0.05)


def test_a_line_slows_it_and_no_event_is_silent() -> None:
    alone, loaded = numbers(), numbers(Params(line_capacitance=2e-12))
    ratio = loaded["tau_s"] / alone["tau_s"]
    assert 1.8 < ratio < 2.0
    result = simulate(BLOCK.bench(rebias(BLOCK.build(), {"i_weight": 1e-14})), Silicon(ROLLS_180_IDEAL))
    assert BLOCK.outcome(result) == "silent"


def test_what_cannot_be() -> None:
    with pytest.raises(ParameterError, match=r"events: .* must be"):
        BLOCK.bench(events=0.0)
    with pytest.raises(ParameterError, match=r"filter_width: 0 um, must be > 0"):
        Params(filter_width=0.0)
