"""When does a range-tuned neuron fire? Scan the echo's delay and print the facilitating interval."""

from __future__ import annotations

import numpy as np

from circuits.blocks.sonar import rebound_neuron
from circuits.solver.transient import simulate


def main() -> None:
    """Print one line a delay, then the interval."""
    circuit = rebound_neuron.build()
    stimuli = rebound_neuron.BLOCK.defaults
    fired = []
    for delay in np.arange(4e-3, 9.01e-3, 0.5e-3):
        result = simulate(rebound_neuron.testbench(circuit, {**stimuli, "delay": float(delay)}, 5.0))
        spikes = result.spikes["spike"]
        outcome, peak = rebound_neuron.BLOCK.outcome(result), result["v_mem"].max()
        print(f"echo at {delay * 1e3:.1f} ms: {outcome}, peak {peak:.3f} V")
        if spikes.size:
            fired.append(float(delay))
    print(f"fires for echoes from {min(fired) * 1e3:.1f} to {max(fired) * 1e3:.1f} ms")


if __name__ == "__main__":
    main()
