"""Figure 5 of Milde et al. 2017: the matrix of weights on the chip.

The network is built, not run, and compared with the paper's text, as the figure prints no numbers: with which
sign populations connect (section 2.4), how many neurons avoid obstacles, and how many neurons of the field
drive nothing.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from chips.rolls.program.connectivity_picture import draw_connectivity
from chips.rolls.program.network import Network
from chips.rolls.program.program import level_current
from system.experiment import Experiment, Progress, Report
from system.pushbot.network.biases import LEVELS, pushbot_biases
from system.pushbot.network.plain import pushbot_network
from system.rule import all_of, as_many
from system.statement import Statement

ARROWS = {  # sign of each connection of section 2.4
    ("OR", "DL"): 1, ("OL", "DR"): 1, ("DL", "DR"): -1, ("DR", "DL"): -1, ("DL", "OL"): -1, ("DL", "OR"): -1,
    ("DR", "OL"): -1, ("DR", "OR"): -1, ("OL", "sp"): -1, ("OR", "sp"): -1, ("exc", "exc"): 1,
    ("exc", "sp"): 1,
}  # fmt: skip
AVOIDANCE = 96  # neurons of the six populations; the paper's
CENTRE = 16  # unconnected neurons of the field; the paper's


def reproduce(progress: Progress) -> Report:
    """Build the network."""
    network = pushbot_network(levels=LEVELS)
    progress(1.0)
    return Report(rows(network), lambda figure: _draw(network, figure), notes())


def rows(network: Network) -> tuple[Statement, ...]:
    """Make the statements about signs, sizes, and the centre of the field."""
    levels = network.levels()
    right = sum(_sign(network, *arrow) == {sign} for arrow, sign in ARROWS.items())
    small = sum(len(p) for p in network.populations if p.name != "target")
    target = network["target"].neurons
    drives = [*network["DL"].neurons, *network["DR"].neurons]
    idle = int((levels[np.ix_(drives, target)] == 0).all(axis=0).sum())
    return (
        Statement("connections_of_the_right_sign", float(len(ARROWS)), float(right), all_of(len(ARROWS))),
        Statement("neurons_of_obstacle_avoidance", float(AVOIDANCE), float(small), as_many("the same")),
        Statement("field_neurons_that_drive_nothing", float(CENTRE), float(idle), as_many("the same")),
    )


def _sign(network: Network, source: str, target: str) -> set[int]:
    levels = network.levels()[np.ix_(network[target].neurons, network[source].neurons)]
    return {int(s) for s in np.unique(np.sign(levels))}


def notes() -> tuple[str, ...]:
    """Tell the currents of the levels."""
    biases = pushbot_biases()
    listed = ", ".join(
        f"{k:+d} {1e9 * level_current(biases, k):.3g} nA" for k in (-4, -3, -2, -1, 1, 2, 3, 4)
    )
    return (f"Nominal currents of the levels: {listed}. They do not rise with the level.",)


def _draw(network: Network, figure: Figure) -> None:
    figure.set_size_inches(6.4, 5.6)
    draw_connectivity(network, figure.subplots())


EXPERIMENT = Experiment("milde2017-fig5", "matrix of weights on the chip", reproduce)
