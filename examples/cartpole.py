"""A policy for CartPole that was trained outside, as a network for ROLLS and one for the NEF chip."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from policies_on_a_die import TASKS, trained

from system.api.network import Connection, Input, Network, Population, Probe, write_network

CELLS, TAU = 16, 10e-3  # neurons a push; s
DRIVE, AWAKE = 0.3, 0.6  # weight of the strongest number, and of a constant that keeps both sides awake
VALUES = """ensemble = [
    {{ name = "lean", neurons = 60, radius = 0.5 }},
    {{ name = "push", neurons = 60, dimensions = 2 }},
]
input = [{{ name = "cart", size = 4 }}]
probe = [{{ name = "side", ensemble = "push", synapse = "5ms" }}]
connection = [
    {{ from = "cart", to = "lean", transform = [{row}] }},
    {{ from = "lean", to = "push", transform = [[-1.0], [1.0]] }},
]
"""


def main():
    """Write cartpole.toml, two pushes that the signs of numbers excite, and cartpole-values.toml, a sum."""
    weights = trained(TASKS[0])
    connections = []
    for push, sign in (("left", -1.0), ("right", 1.0)):
        both = np.stack([sign * weights, -sign * weights], axis=1).clip(0.0, None).ravel()
        row = np.append(DRIVE * both, AWAKE)
        connections.append(Connection("cart", push, rule="matrix", tau=TAU, matrix=np.tile(row, (CELLS, 1))))
    write_network(
        "cartpole.toml",
        Network(
            (Population("left", CELLS), Population("right", CELLS)),
            (Input("cart", 2 * len(weights) + 1),),
            tuple(connections),
            (Probe("push left", "left"), Probe("push right", "right")),
        ),
    )
    Path("cartpole-values.toml").write_text(VALUES.format(row=weights.round(4).tolist()), encoding="utf-8")
    print(f"weights {np.round(weights, 2).tolist()}, of shares of {', '.join(map(str, TASKS[0].reach))}")


if __name__ == "__main__":
    main()
