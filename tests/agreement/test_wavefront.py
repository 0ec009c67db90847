"""The wavefront chip in ngspice: two cells of a die at rest, and a wave from the one to the other."""

from __future__ import annotations

import numpy as np
import pytest

from circuits.blocks.wavefront.grid import Params, build, plan_testbench
from circuits.silicon.die import Die
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from netlists.ngspice import engine
from netlists.ngspice.agreement import USUAL
from netlists.ngspice.form import started

pytestmark = pytest.mark.usefixtures("kept_ngspice")


def test_a_wave_reaches_the_next_cell_at_the_same_time() -> None:
    silicon = Silicon(AMI_1500_IDEAL, die=Die(number=1003))
    codes = np.ones((1, 2), dtype=np.int64)
    bench = plan_testbench(build(Params(1, 2)), codes, (0, 0), 90e-6, 5.0)  # the other cell fires at 84 us
    ours = simulate(bench, silicon, rtol=1e-6)
    peer = engine.simulate(started(bench, silicon), silicon, reltol=1e-3, tmax=2e-6)
    rest, again = ours.operating_point.voltages(), peer.operating_point.voltages()
    assert max(abs(rest[node] - again[node]) for node in rest) < USUAL.operating_point
    # the project's allowance for spikes, without its share of the time
    for port in ("fired[0,0]", "fired[0,1]", "first[0,1,6]"):
        assert ours.spikes[port].size == 1
        assert peer.spikes[port] == pytest.approx(ours.spikes[port], abs=USUAL.spike_time)
