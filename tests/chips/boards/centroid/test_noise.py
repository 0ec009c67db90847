"""Noise of the proximity voltage against the board's own noise analysis."""

import numpy as np

from chips.boards.centroid.noise import proximity_noise
from circuits.blocks.sonar import centroid_board
from circuits.devices import Source
from circuits.devices.noise import WHITE_ONLY
from circuits.devices.source import Constant
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from circuits.solver.noise.analysis import noise
from circuits.solver.operating_point import operating_point
from circuits.testbench import Testbench


def test_it_is_what_the_circuit_integrates_to() -> None:
    quiet = [Source(f"s{k}", f"spike[{k}]", Constant(0.0)) for k in range(centroid_board.NEURONS)]
    sources = Source("vdd", "vdd", Constant(AMI_1500_IDEAL.v_dd)), *quiet
    bench = Testbench("centroid board", centroid_board.build(), sources, 1.0)
    point = operating_point(bench, Silicon(AMI_1500_IDEAL))
    # from far below 1 / 2 pi 2 s to far above the low-pass, whose resistor the followers pass on
    found = noise(point, "proximity", np.geomspace(1e-4, 1e5, 200), model=WHITE_ONLY)
    # at rest off currents of saturated gates hold the node too, and make half of k T / C for their share;
    # strays of gates add 3 % to the hold capacitor
    assert 0.85 < np.sqrt(found.variance) / proximity_noise(Silicon(AMI_1500_IDEAL)) < 1.0
