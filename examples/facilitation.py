"""When does a range-tuned neuron fire? Scan the echo's delay and print the facilitating interval."""

from __future__ import annotations

import numpy as np

from circuits.api import load_block, simulate


def main() -> None:
    """Print one line a delay, then the interval."""
    neuron = load_block("rebound-neuron")
    circuit = neuron.build(neuron.params())
    fired = []
    for delay in np.arange(4e-3, 9.01e-3, 0.5e-3):
        result = simulate(neuron.bench(circuit, delay=float(delay)))
        spikes = result.spikes["spike"]
        outcome, peak = neuron.outcome(result), result["v_mem"].max()
        print(f"echo at {delay * 1e3:.1f} ms: {outcome}, peak {peak:.3f} V")
        if spikes.size:
            fired.append(float(delay))
    print(f"fires for echoes from {min(fired) * 1e3:.1f} to {max(fired) * 1e3:.1f} ms")


if __name__ == "__main__":
    main()
