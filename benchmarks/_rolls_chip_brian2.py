"""A network like a ROLLS chip's in Brian2's cpp_standalone, for `rolls_chip.py`, which starts it.

Reads network.npz of the folder that it is given and writes result.npz: CPU seconds of 1 s of the compiled
program, and the mean rate. 256 neurons with two shared DPI filters in current mode,
`(1 + I_th / I) tau dI/dt = -I - I_th`, on an event `I += q I_th / (1 + I_th / I)`, membranes of the software
models' form with exponential feedback, forward Euler; floors as those have. The
direct current that gives the rate asked for is bisected; the run whose rate is
nearest counts. Charges are a tenth of the chip's: with all of them this network is either silent or runs at
213 Hz, and what an event costs does not depend on its size. Imports nothing of ours.
"""

from __future__ import annotations

import resource
import sys
from pathlib import Path

import brian2 as b
import numpy as np

NEURONS = 256
SHARE = 0.1  # of the chip's charges; ours
EQUATIONS = """
dIe/dt = -(Ie + Ith) / (tau_e * (1 + Ith / Ie)) : amp
dIi/dt = -(Ii + Ith) / (tau_i * (1 + Ith / Ii)) : amp
dIm/dt = (Ithm / Itau * (clip(Ie, I0, 1*uA) + drive) - Ithm - Im * (1 + clip(Ii, I0, 1*uA) / Itau)
    + Ifb / Itau * (Im + Ithm)) / (tau * (1 + Ithm / Im)) : amp (unless refractory)
Ifb = I0 * (Im / I0) ** 0.57 : amp
tau_e : second (constant)
tau_i : second (constant)
held : second (constant)
drive : amp (constant)
"""
CONSTANTS = {
    "Ith": 8.8 * b.pA, "Ithm": 6.5 * b.nA, "Itau": 64 * b.pA, "I0": 0.5 * b.pA, "tau": 1.1 * b.ms,
}  # fmt: skip


def run(folder: Path, current: float) -> tuple[float, float]:
    """CPU seconds and mean rate of 1 s at a direct current, A."""
    given = np.load(folder / "network.npz")
    b.device.reinit()
    b.device.activate(directory=str(folder / "code"), build_on_run=False)
    b.defaultclock.dt = float(given["step"]) * b.second
    neurons = b.NeuronGroup(
        NEURONS, EQUATIONS, threshold="Im > 1*uA", reset="Im = I0", refractory="held", method="euler",
        namespace=CONSTANTS,
    )  # fmt: skip
    neurons.tau_e, neurons.tau_i = given["tau_e"] * b.second, given["tau_i"] * b.second
    neurons.held, neurons.drive = given["refractory"] * b.second, current * b.amp
    neurons.Ie = neurons.Ii = neurons.Im = CONSTANTS["I0"]
    floor = "Ie = clip(Ie, I0, 1*uA); Ii = clip(Ii, I0, 1*uA); Im = clip(Im, I0, 10*uA)"
    neurons.run_regularly("\n".join(floor.split("; ")))
    network = b.Network(neurons)
    for sign, name in enumerate(("Ie", "Ii")):
        charge = np.maximum((1 - 2 * sign) * given["charges"], 0.0)
        pre, post = np.nonzero(charge)
        synapses = b.Synapses(
            neurons, neurons, "q : 1", namespace=CONSTANTS,
            on_pre=f"{name}_post += q * Ith / (1 + Ith / {name}_post)",
        )  # fmt: skip
        synapses.connect(i=pre, j=post)
        synapses.q = SHARE * charge[pre, post]
        network.add(synapses)
    spikes = b.SpikeMonitor(neurons)
    network.add(spikes)
    network.run(1 * b.second, report=None)
    b.device.build(compile=True, run=False)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    b.device.run(with_output=False)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    taken = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return taken, spikes.num_spikes / NEURONS


def main() -> None:
    """Find the direct current, and time the run."""
    folder = Path(sys.argv[1])
    b.prefs.devices.cpp_standalone.openmp_threads = 0
    b.set_device("cpp_standalone", build_on_run=False)
    wanted = float(np.load(folder / "network.npz")["rate"])
    low, high = 1e-10, 1e-6
    best = (float("nan"), float("inf"))
    for _ in range(9):
        middle = float(np.sqrt(low * high))
        taken, rate = run(folder, middle)
        if abs(rate - wanted) < abs(best[1] - wanted):
            best = (taken, rate)
        if abs(rate - wanted) < 0.15 * wanted:
            break
        low, high = (middle, high) if rate < wanted else (low, middle)
    np.savez(folder / "result.npz", taken=best[0], rate=best[1])


if __name__ == "__main__":
    main()
