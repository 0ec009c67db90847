"""The modified architecture of the Pushbot (Milde et al. 2017, section 3.4) on one ROLLS.

Two more populations, GL and GR, "receive input from the inertia measurement unit of the Pushbot" and
"suppress obstacle populations when the robot is turning". Homogeneous connections from obstacle to drive
populations become "graded connections that become stronger for obstacles detected in the center": a neuron of
an obstacle population owns four columns of the sensor, the first at the edge, and from there to the
centre each four neurons have the next stronger of the four exciting weights. What owns columns hears few
events; it has the slower leak, IF_TAU1, and so a lower threshold, as the target field has. It must still sum
events that come close to one another in time: where each makes spikes, noise near the centre steers.

The robot looks between turns. What a turn of its own moves over the sensor says little of what is near: the
gyro's populations silence OL and OR from about 0.5 rad/s on, so drives, which no longer inhibit them, answer
to what was seen before. A drive's filter holds that for some 60 ms; meanwhile drives and gyro hold sp back
(no source shows these two arrows), whose inhibition lasts about 120 ms. Then the robot goes on, and looks.

What was tried on dies 100 to 123, 12 m a run. The network itself touches 4 times in 24 runs. So do
variants, 4 to 7 times: the gyro from 0.75 or 1 rad/s on, half the drives' or the inhibition's time, turn
factors 1.5 and 3, half as many spikes again in the obstacle populations. Flatter ramps touch 8 and 14
times. With the gyro from 1.5 rad/s on it is twice, but the robot then turns 25 rad a metre. Events of the
gyro that hold sp for longer after a turn made it worse (13 of 36).

How strong the ramp to the drives is decides. At up to 1.6 uA and turn factor 5 it touched 2 times in 72
scenes and 807 m, but half of its turns were of more than 160 degrees: it tumbled on some ten squares of 20
cm. With the same ramp (dies 100 to 105, 18 scenes each) turn factors 3, 2 and 1.5 touched 2, 4 and 9 times,
on 9, 16 and 27 squares. A collision less is not taken where it is a way less.

16 neurons a gyro population and the levels are ours. With exc of 16 neurons the chip is full.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.network import Network, PopulationInput
from chips.rolls.program.population import Population, Projection, all_to_all, place
from chips.rolls.program.program import level_current
from system.pushbot.network.plain import PAPER, TARGET_NEURONS, PushbotLayout, PushbotLevels, pushbot_network

_GYRO = 16  # neurons of a gyro population; ours


@dataclass(frozen=True, slots=True)
class ModifiedLevels:
    """Levels that differ from the plain network's, ours; currents: those of `biases.MODIFIED`.

    The ramp takes the stronger exciting levels; what is not part of it has the weakest.
    """

    gyro_to_obstacle: int = -1  # 14 nA
    gyro_to_speed: int = -1
    drive_to_speed: int = -1
    drive_to_obstacle: int = 0  # none: the gyro's populations do what drives do in the plain network
    obstacle_to_speed: int = -2  # 24 nA
    exc_to_speed: int = 1  # 0.13 uA
    target_to_drive: int = 1
    field_near: tuple[int, ...] = (1, 1, 1)


MODIFIED_LEVELS = ModifiedLevels()


def field_network(layout: PushbotLayout, levels: PushbotLevels) -> Network:
    """Return the plain network with the target field on the slower leak."""
    network = pushbot_network(layout, levels)
    return replace(network, slow=(network["target"],))


def modified_network(
    levels: PushbotLevels, biases: BiasTable, layout: PushbotLayout = PAPER, gyro: int = _GYRO
) -> Network:
    """The network with graded connections and gyro populations, inputs `gyro_left` and `gyro_right`.

    Raises `ParameterError` where the chip has too few neurons.
    """
    changed = MODIFIED_LEVELS
    own = replace(
        levels, drive_to_obstacle=changed.drive_to_obstacle, obstacle_to_speed=changed.obstacle_to_speed,
        exc_to_speed=changed.exc_to_speed, target_to_drive=changed.target_to_drive,
        field_near=changed.field_near,
    )  # fmt: skip
    base = pushbot_network(layout, own)
    sizes = {"before": 5 * layout.population + layout.exc + TARGET_NEURONS, "GL": gyro, "GR": gyro}
    placed = place(sizes)
    turning = placed["GL"], placed["GR"]
    obstacles = base["OL"], base["OR"]
    graded = {("OR", "DL"), ("OL", "DR")}
    kept = tuple(p for p in base.projections if (p.source.name, p.target.name) not in graded)
    ramps = tuple(_ramp(base[a], base[b], biases) for a, b in sorted(graded))
    suppress = tuple(all_to_all(g, o, changed.gyro_to_obstacle) for g in turning for o in obstacles)
    slow = (
        *(all_to_all(base[d], base["sp"], changed.drive_to_speed) for d in ("DL", "DR")),
        *(all_to_all(g, base["sp"], changed.gyro_to_speed) for g in turning),
    )
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
