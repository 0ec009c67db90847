"""Networks of nengo on the NEF chip; needs the optional extra `nengo`."""

from chips.nef.nengo.simulator import Simulator

__all__ = [
    # The simulator
    "Simulator",
]
