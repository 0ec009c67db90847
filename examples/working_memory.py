"""An integrator on the NEF chip holds a number after its input is gone, on a die, and while it warms up."""

from __future__ import annotations

from chips.api import open_chip
from chips.api.nef import Connection, Ensemble, Network, Node, Probe
from circuits.api import Die


def main() -> None:
    """Write 0.5, look at it for two seconds, and at another temperature."""
    network = Network(
        (Ensemble("held", 200),),
        (Node("in", 1),),
        (
            Connection("in", "held", transform=[[0.1]], synapse=0.1),
            Connection("held", "held", synapse=0.1),
        ),
        (Probe("value", "held", synapse=0.02),),
    )
    chip = open_chip("nef-chip", Die("A", 1001), network=network)
    chip.advance(0.2)
    chip.drive("in", 5.0)
    chip.advance(0.1)
    chip.drive("in", 0.0)
    for _ in range(2):
        spikes = chip.advance(1.0)
        print(f"{chip.time:.1f} s: holds {chip.show()['value'][0]:.2f}, {spikes.times.size} spikes a second")
    chip.warm(35.0)
    chip.advance(1.0)
    print(f"{chip.time:.1f} s, at 35 degC: holds {chip.show()['value'][0]:.2f}; lost: {chip.lost}")


if __name__ == "__main__":
    main()
