"""The open output follows on one side and switches; the loaded copies give a tanh of the inputs."""

import math
from dataclasses import replace

import numpy as np
import pytest

from circuits.bias import bias_voltages, rebias
from circuits.blocks.bench.curve import ramp
from circuits.blocks.bench.transamp import N, P, Params, stage
from circuits.blocks.block import Block
from circuits.blocks.drive import powered
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180, ROLLS_180_IDEAL, Polarity, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.power import drain_current
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

WEAK = 0.5e-9  # A
SIZES = Params()


def numbers(block: Block, process: Process = ROLLS_180_IDEAL, **knobs: float) -> dict[str, float | None]:
    circuit = rebias(block.build(block.sizes), {"i_tail": WEAK})
    return block.measures(simulate(block.bench(circuit, **knobs), Silicon(process)))


@pytest.mark.parametrize("polarity", ["n", "p"])
def test_a_stage_into_a_fixed_voltage_is_a_tanh(polarity: Polarity) -> None:
    silicon, circuit = Silicon(ROLLS_180_IDEAL), N.build(SIZES) if polarity == "n" else P.build(SIZES)
    tail = float(bias_voltages(circuit, replace(circuit.bias("i_tail"), value=WEAK), silicon))
    minus, far = (0.9, 1.5) if polarity == "n" else (0.9, 0.3)
    waves = {"v_plus": ramp(0.0, 1.0, 0.6, 1.2, 120), "v_minus": minus, "v_out": far, "v_tail": tail}
    bench = Testbench("stage", stage(polarity, SIZES), powered(1.8, waves), 1.0)
    result = simulate(bench, silicon)
    mirrored, own = (np.abs(drain_current(result, name)) for name in ("m4", "m2"))
    given = mirrored - own if polarity == "n" else own - mirrored
    kappa = (ROLLS_180.n if polarity == "n" else ROLLS_180.p).kappa
    closed = WEAK * np.tanh(kappa * (result["v_plus"] - minus) / (2.0 * silicon.thermal_voltage))
    assert np.abs(given - closed).max() < 0.02 * WEAK  # sqrt(I / I_S) / 2 of moderate inversion


@pytest.mark.parametrize("block", [N, P])
def test_the_loaded_copies_give_the_tail_near_their_rails(block: Block) -> None:
    # an input so near to its rail that a diode stands hardly beyond the pair's source: it draws 10 % at most
    found = numbers(block, v_minus=0.45 if block is N else 1.35)
    assert found["source_A"] == pytest.approx(WEAK, rel=0.1)
    assert found["sink_A"] == pytest.approx(WEAK, rel=0.1)


@pytest.mark.parametrize("block", [N, P])
def test_a_diode_beyond_the_pair_s_source_draws_more_than_the_tail(block: Block) -> None:
    found = numbers(block)
    assert found["switch_V"] == pytest.approx(0.9, abs=5e-3)
    assert (found["source_A"] if block is N else found["sink_A"]) > 5.0 * WEAK


@pytest.mark.parametrize(("block", "side"), [(N, "low_V"), (P, "high_V")])
def test_the_output_follows_with_about_kappa(block: Block, side: str) -> None:
    found = numbers(block)
    kappa = (ROLLS_180.n if block is N else ROLLS_180.p).kappa
    assert found["follower_slope"] == pytest.approx(kappa, rel=0.03)
    other = "high_V" if side == "low_V" else "low_V"
    assert math.isclose(found[other] or 0.0, 1.8 if other == "high_V" else 0.0, abs_tol=0.01)


@pytest.mark.parametrize("block", [N, P])
def test_the_loads_shift_where_the_currents_meet(block: Block) -> None:
    # the two copies' outputs stand 1 V apart, which the Early voltage of 4.75 V makes a fifth of the current
    assert abs(numbers(block, ROLLS_180)["offset_V"] or 0.0) > 5e-3


def test_what_leaves_the_supply_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"out: -1 V, must be within 0 V and the supply"):
        N.bench(out=-1.0)
    with pytest.raises(ParameterError, match=r"readout_p_width: -1 um, must be > 0"):
        Params(readout_p_width=-1.0)
