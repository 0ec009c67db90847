"""The NEF chip:networks of ensembles, the curves of their neurons, and runs on a die."""

from chips.nef.build import build
from chips.nef.chip import NefChip
from chips.nef.network.network import Connection, Ensemble, EnsembleArray, Network, Neurons, Node, Probe, join
from chips.nef.simulation import Simulation

__all__ = [  # noqa: RUF022 - in the order of the reference, grouped by its headings
    # Networks
    "Network",
    "Ensemble",
    "EnsembleArray",
    "Node",
    "Neurons",
    "Connection",
    "Probe",
    "join",
    # The chip and its curves
    "NefChip",
    # Runs
    "build",
    "Simulation",
]
