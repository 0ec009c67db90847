"""Noise of a sampling switch: k T / C from the noise analysis, and from transients with noise."""

from __future__ import annotations

import numpy as np

from circuits.circuit import Circuit, Port
from circuits.devices import Capacitor, Source, Transistor
from circuits.devices.noise import WHITE_ONLY
from circuits.devices.source import Constant
from circuits.lowering.kernel import to_kernel
from circuits.silicon.process import BOLTZMANN
from circuits.solver.noise.analysis import noise
from circuits.solver.noise.transient import NoiseRun, simulate_noisy
from circuits.solver.operating_point import operating_point
from circuits.solver.small_signal import frequency_grid, linearise
from circuits.testbench import Testbench

switch = Circuit(
    "switch",
    (Port("gate", "bias"), Port("held", "analog", "out")),
    (
        Transistor("m", "n", "held", "gate", "0", "0", 3e-6, 1.5e-6),
        Capacitor("c", "held", "0", 1e-12),
    ),
)
gate = Source("gate", "gate", Constant(0.8))
point = operating_point(Testbench("switch", switch, (gate,), 1.0))
linear = linearise(point)
capacitance = linear.charge[0, 0]
tau = capacitance / linear.conductance[0, 0]

analysis = noise(point, "held", frequency_grid(1e-4 / tau, 1e4 / tau, 20), model=WHITE_ONLY)
bench = Testbench("switch", switch, (gate,), 5000 * tau)
waves = simulate_noisy(to_kernel(bench), NoiseRun(seed=1, step=tau / 20, flicker=WHITE_ONLY))

thermal = np.sqrt(BOLTZMANN * 300.15 / capacitance)
measured = np.std(waves["held"])
print(f"time constant {1e9 * tau:.0f} ns, sqrt(k T / C) {1e6 * thermal:.1f} uV")
print(f"noise analysis {1e6 * np.sqrt(analysis.variance):.1f} uV, transient {1e6 * measured:.0f} uV")
