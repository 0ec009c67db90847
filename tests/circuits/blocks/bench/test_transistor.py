"""The lone transistors: their law's own figures come back, and the shunts take what Ohm's law says."""

import pytest

from circuits.blocks.bench.transistor import NFET, PFET, Params
from circuits.blocks.block import Block
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

SIZES = Params()


def numbers(
    block: Block, params: Params = SIZES, process: Process = ROLLS_180, **knobs: float
) -> dict[str, float | None]:
    bench = block.bench(block.build(params), **knobs)
    return block.measured(simulate(bench, Silicon(process)))


@pytest.mark.parametrize("block", [NFET, PFET])
def test_without_second_order_effects_kappa_is_the_process_s(block: Block) -> None:
    found = numbers(block, Params(drain_resistance=1.0, source_resistance=1.0), ROLLS_180_IDEAL)
    law = ROLLS_180.n if block is NFET else ROLLS_180.p
    # weak inversion's slope falls by about q / 2, at 1 nA and an I_S of 0.5 uA 2 %
    assert found["kappa"] == pytest.approx(law.kappa, rel=0.03)
    assert found["early_voltage_V"] is None or found["early_voltage_V"] > 1e4  # none: flat


def test_body_effect_makes_kappa_rise_with_the_source() -> None:
    low, high = (numbers(NFET, source=v)["kappa"] for v in (0.0, 0.5))
    assert 1.04 < high / low < 1.15


@pytest.mark.parametrize("block", [NFET, PFET])
def test_the_shunts_take_what_ohm_s_law_says(block: Block) -> None:
    result = simulate(block.bench(block.build(Params()), gate=0.8), Silicon(ROLLS_180))
    found = block.measures(result)
    without = numbers(block, Params(drain_resistance=1.0, source_resistance=1.0), gate=0.8)
    rail = abs(result["drain"][0] - result["source"][0])
    assert rail == pytest.approx(1.8)
    across = abs(result["s"] - result["source"]).max()
    assert across == pytest.approx(33e3 * found["on_current_A"], rel=1e-3)
    assert found["on_current_A"] < without["on_current_A"]
    # the source rises by 3.3 mV, and the gate by that over the slope of what is above threshold
    shift = found["threshold_V"] - without["threshold_V"]
    assert shift == pytest.approx(33e3 * 100e-9 / found["kappa"], rel=0.15)


def test_the_early_voltage_follows_the_length() -> None:
    long, short = (numbers(NFET, Params(width=k, length=k))["early_voltage_V"] for k in (4.0, 1.0))
    assert 3.0 < long / short < 5.0


def test_a_device_without_a_square_s_current_is_off() -> None:
    bench = NFET.bench(NFET.build(Params()), drain=0.0)
    assert NFET.outcome(simulate(bench, Silicon(ROLLS_180))) == "off"


def test_what_leaves_the_supply_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"gate: 2 V, must be within 0 V and the supply of 1.8 V"):
        NFET.bench(gate=2.0)
    with pytest.raises(ParameterError, match=r"width: 0 um, must be > 0"):
        Params(width=0.0)
