"""The modified architecture of the Pushbot (Milde et al. 2017, section 3.4) on one ROLLS.

Two more populations, GL and GR, "receive input from the inertia measurement unit of the Pushbot" and
"suppress obstacle populations when the robot is turning". Homogeneous connections from obstacle to drive
populations become "graded connections that become stronger for obstacles detected in the center": a neuron of
an obstacle population owns four columns of the sensor, the first at the edge, and from there to the
centre each four neurons have the next stronger of the four exciting weights. What owns columns hears few
events; it has the slower leak, IF_TAU1, and so a lower threshold, as the target field has. It must still sum
events that come close to one another in time: where each makes spikes, noise near the centre steers.

Drives inhibit sp, which no source shows: in a turn the gyro's populations silence the obstacle populations,
so sp would come back and the robot speed up towards what is still ahead. The paper finds that speed is
smoother with the modified architecture; one that depends on the decision, and not on each event, is. With
level -1 the robot drives through its turns and touches as often a metre as without; with -3 it stops in them.

16 neurons a gyro population and the levels are ours. With exc of 16 neurons the chip is full.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from chips.population import Population, Projection, all_to_all, place
from chips.pushbot_network import PAPER, TARGET_NEURONS, PushbotLayout, PushbotLevels, pushbot_network
from chips.rolls_bias_file import BiasTable
from chips.rolls_network import Network, PopulationInput
from chips.rolls_program import level_current

GYRO = 16  # neurons of a gyro population; ours
GYRO_TO_OBSTACLE = -1
DRIVE_TO_OBSTACLE = -1  # level: the gyro's populations do part of what drives do in the plain network
SLOWING = -2  # level from obstacle populations to sp, 39 nA with the biases of this network
EXC_TO_SPEED = 3  # level, as strong as the plain network's
DRIVE_TO_SPEED = -3  # level from drives to sp, 0.24 uA: one spike of a drive and sp is silent


def field_network(layout: PushbotLayout, levels: PushbotLevels) -> Network:
    """The plain network with the target field on the slower leak."""
    network = pushbot_network(layout, levels)
    return replace(network, slow=(network["target"],))


def modified_network(
    levels: PushbotLevels, biases: BiasTable, layout: PushbotLayout = PAPER, gyro: int = GYRO
) -> Network:
    """The network with graded connections and gyro populations, inputs `gyro_left` and `gyro_right`.

    Raises `ParameterError` where the chip has too few neurons.
    """
    own = replace(
        levels, drive_to_obstacle=DRIVE_TO_OBSTACLE, obstacle_to_speed=SLOWING, exc_to_speed=EXC_TO_SPEED
    )
    base = pushbot_network(layout, own)
    sizes = {"before": 5 * layout.population + layout.exc + TARGET_NEURONS, "GL": gyro, "GR": gyro}
    placed = place(sizes)
    turning = placed["GL"], placed["GR"]
    obstacles = base["OL"], base["OR"]
    graded = {("OR", "DL"), ("OL", "DR")}
    kept = tuple(p for p in base.projections if (p.source.name, p.target.name) not in graded)
    ramps = tuple(_ramp(base[a], base[b], biases) for a, b in sorted(graded))
    suppress = tuple(all_to_all(g, o, GYRO_TO_OBSTACLE) for g in turning for o in obstacles)
    slow = tuple(all_to_all(base[d], base["sp"], DRIVE_TO_SPEED) for d in ("DL", "DR"))
    inputs = tuple(
        PopulationInput(name, population, levels.dvs_synapses)
        for name, population in zip(("gyro_left", "gyro_right"), turning, strict=True)
    )
    return Network(
        (*base.populations, *turning), (*kept, *ramps, *suppress, *slow), (*base.inputs, *inputs),
        (*obstacles, base["target"]),
    )  # fmt: skip


def _ramp(source: Population, target: Population, biases: BiasTable) -> Projection:
    """From the weakest level at the sensor's edge to the strongest in its centre, by current."""
    rising = sorted(range(1, 5), key=lambda level: level_current(biases, level))
    levels = np.array(rising)[np.arange(len(source)) * len(rising) // len(source)]
    return Projection(source, target, np.tile(levels, (len(target), 1)))
