"""Slopes of a timer: those of the comparator's pair, and a timer that is never on."""

import numpy as np
import pytest

from chips.measured.timer import PARAMETERS, timer_slopes
from circuits.bias import rebias
from circuits.blocks.latency.coincidence import BLOCK
from circuits.errors import SolverError
from circuits.lowering.kernel import Machine, to_kernel

TIMER = "input0.timer"


@pytest.fixture(scope="module")
def machine() -> Machine:
    return to_kernel(BLOCK.bench(rebias(BLOCK.build(), kind="ideal"), second=None))


def test_a_pair_moves_the_charge_by_its_own_offset(machine: Machine) -> None:
    found = timer_slopes(machine, TIMER, lambda result: BLOCK.measures(result)["window_s"], 1e-6)
    slopes = dict(zip(PARAMETERS, found, strict=True))
    # ln Q moves by dV / V_ref, V_ref = 2 V, with the sign of the input that the device is at
    assert slopes["mc1.v_t0"] == pytest.approx(0.5, rel=0.05)
    assert slopes["mc2.v_t0"] == pytest.approx(-0.5, rel=0.05)
    assert np.isfinite(found).all()


def test_a_timer_that_is_never_on_is_named(machine: Machine) -> None:
    with pytest.raises(SolverError, match=r"^input0\.timer\.mc0\.v_t0: the timer is never on"):
        timer_slopes(machine, TIMER, lambda _: None, 1e-6)
