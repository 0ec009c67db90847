"""The greatest input takes all tails; the feedback's line sets the hysteresis; joints reach neighbours."""

from dataclasses import replace

import numpy as np
import pytest

from circuits.bias import rebias
from circuits.blocks.bench.bias import MASTERS, code_current
from circuits.blocks.bench.winner_take_all_ring import BLOCK, Params, build
from circuits.circuit import Circuit
from circuits.errors import ParameterError
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from circuits.solver.power import drain_current
from circuits.solver.transient import Result, simulate

FOUR = Params(cells=4)


def gained(fine: int, off: bool = False) -> Circuit:
    gain = code_current(MASTERS[3], fine, 3.4, 1.0)
    circuit = rebias(build(FOUR), {"i_gain": gain, **({"v_enable": 1.8} if off else {})})
    plain = [
        replace(b, kind="voltage", value=0.0, device=None) if b.name == "i_ex" else b for b in circuit.biases
    ]
    return replace(circuit, biases=tuple(plain))


def run(circuit: Circuit, **knobs: float) -> Result:
    return simulate(BLOCK.bench(circuit, **knobs), Silicon(ROLLS_180))


def test_the_winner_has_all_tails_and_the_rival_none() -> None:
    result = run(gained(255, off=True))
    low = int(result["v_in[0]"].argmin())
    shares = [abs(drain_current(result, f"cell[{k}].m2")[low]) for k in range(4)]
    tails = sum(abs(drain_current(result, f"cell[{k}].mb")[low]) for k in range(4))
    assert shares[0] > 0.99 * tails
    assert max(shares[1:]) < 0.01 * tails


def test_without_feedback_both_ways_switch_where_the_inputs_are_equal() -> None:
    found = BLOCK.measures(run(gained(255, off=True)))
    assert found["switch_down_V"] == pytest.approx(1.65, abs=1.5e-3)
    assert abs(found["hysteresis_V"] or 0.0) < 2e-3  # what the nodes' charge takes at 0.2 V/s


def test_less_of_a_bias_is_more_hysteresis() -> None:
    widths = [BLOCK.measures(run(gained(fine)))["hysteresis_V"] or np.inf for fine in (2, 3, 4)]
    assert widths[0] > widths[1] > widths[2] > 0.0


def test_neighbours_that_inhibit_alone_leave_more_than_one_winner() -> None:
    ring = rebias(gained(255, off=True), {"v_inh": 0.0})
    result = run(ring, low=1.649, rival=1.65)
    assert BLOCK.outcome(run(gained(255, off=True))) == "switches"
    assert min(result["v_out[0]"].max(), result["v_out[1]"].max()) > 0.4


def test_what_cannot_be() -> None:
    with pytest.raises(ParameterError, match=r"cells: 2, must be a whole number from 3"):
        Params(cells=2)
    with pytest.raises(ParameterError, match=r"rival: 1.9 V, must be within 0 V and the supply"):
        BLOCK.bench(rival=1.9)
