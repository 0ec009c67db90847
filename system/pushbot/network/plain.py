"""Obstacle avoidance and target acquisition of the Pushbot on one ROLLS (Milde et al. 2017, section 2.4).

    OR -> DL, OL -> DR    an obstacle on one side makes the robot turn to the other
    DL <-> DR             drives inhibit each other, so that one wins
    DL, DR -> OL, OR      turning makes events of its own: both obstacle populations are inhibited
    OL, OR -> sp          an obstacle slows the robot down
    exc -> exc, sp        fires constantly once triggered, and sets the speed
    target                neural field over the columns of the sensor: its left part drives DL, its right part
                          DR, its centre nothing

Found: populations, their sizes, and the arrows above, in the paper; the order of the populations on the chip
and the sizes of `NOTEBOOK`, in the authors' notebooks (NCSRobotLib, "Target Acquisition"). Not found: the
levels (Figure 4 and Table 2 of Appendix B). `PushbotLevels` are ours, from two networks for the same chip: in
SequenceLearning.cpp a field has self 2, neighbours 3, the rest -2; in OmniRobotRollsController.cpp drives
inhibit each other with -4 and a constantly firing group has 4 to itself and to what it holds. Whether drives
or obstacle populations excite themselves is not said; here they do not.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from chips.rolls.program.network import Network, PopulationInput
from chips.rolls.program.population import all_to_all, neural_field, place, winner_take_all
from circuits.errors import ParameterError

TARGET_NEURONS = 128


@dataclass(frozen=True, slots=True)
class PushbotLayout:
    """How many neurons the populations of the Pushbot's network have.

    Attributes
    ----------
    population : int
        Neurons of OR, OL, DR, DL and sp, each.
    exc : int
        Neurons of exc.
    centre : int
        Neurons in the middle of the target field that drive nothing; even, so that both sides have one size.

    Raises
    ------
    ParameterError
        `centre` is odd or leaves no side.
    """

    population: int = 16
    exc: int = 16
    centre: int = 16

    def __post_init__(self) -> None:
        if not (0 <= self.centre < TARGET_NEURONS and self.centre % 2 == 0):
            raise ParameterError(
                f"pushbot.centre: {self.centre}, must be even and 0 to {TARGET_NEURONS - 2};"
                " both sides have the same size"
            )


PAPER = PushbotLayout()
"""The paper's sizes: six populations of 16 neurons, 96 together, beside the target field."""
NOTEBOOK = PushbotLayout(exc=8, centre=20)
"""The sizes of the authors' notebooks, with the target field on neurons 88 to 215."""


@dataclass(frozen=True, slots=True)
class PushbotLevels:
    """The weight levels of the Pushbot's network, and its fan-out from the sensor.

    Levels are whole numbers from -4 to 4. The paper gives none, so they are ours; the module says from what.
    A target drives less than an obstacle, as section 2.4.2 asks. A positive level excites, a negative one
    inhibits.

    Attributes
    ----------
    obstacle_to_drive : int
        From an obstacle population to the drive that turns away.
    obstacle_to_speed : int
        From both obstacle populations to the speed population.
    drive_to_drive : int
        From each drive population to the other.
    drive_to_obstacle : int
        From each drive population to both obstacle populations.
    exc_to_exc : int
        From the constantly firing group to itself.
    exc_to_speed : int
        From the constantly firing group to the speed population.
    target_to_drive : int
        From a side of the target field to the drive on that side.
    field_near : tuple of int
        In the target field: from a neuron to itself, to its next neighbour and to the one after, on either
        side.
    field_far : int
        In the target field: from a neuron to all further ones.
    dvs_synapses : int
        Virtual synapses of a neuron that an event of the sensor goes to; the robot's code stimulates 0 to 3.
    """

    obstacle_to_drive: int = 3
    obstacle_to_speed: int = -1
    drive_to_drive: int = -4
    drive_to_obstacle: int = -1
    exc_to_exc: int = 4
    exc_to_speed: int = 4
    target_to_drive: int = 2
    field_near: tuple[int, ...] = (2, 3, 3)
    field_far: int = -2
    dvs_synapses: int = 4


def pushbot_network(
    layout: PushbotLayout = PAPER,
    levels: PushbotLevels = PushbotLevels(),
    blacklist: Collection[int] = (),
) -> Network:
    """Make the network of the Pushbot: populations OR, OL, DR, DL, sp, exc and target, in this order.

    Its inputs are `dvs_right` and `dvs_left` to the obstacle populations (an event of the lower half of the
    sensor is for every neuron of its side), `dvs_columns` to the target (the upper half of a column is for
    one neuron), and `start` to exc.

    Parameters
    ----------
    layout
        Sizes of the populations.
    levels
        Weight levels.
    blacklist
        Neurons of the chip that no population gets.

    Raises
    ------
    ParameterError
        The chip has too few neurons.
    """
    names = ("OR", "OL", "DR", "DL", "sp")
    sizes = dict.fromkeys(names, layout.population) | {"exc": layout.exc, "target": TARGET_NEURONS}
    p = place(sizes, blacklist)
    side = (TARGET_NEURONS - layout.centre) // 2
    left, right = p["target"].part(0, side), p["target"].part(side + layout.centre, TARGET_NEURONS)
    obstacles, drives = (p["OL"], p["OR"]), (p["DL"], p["DR"])
    projections = (
        all_to_all(p["OR"], p["DL"], levels.obstacle_to_drive),
        all_to_all(p["OL"], p["DR"], levels.obstacle_to_drive),
        *winner_take_all(drives, 0, levels.drive_to_drive),
        *(all_to_all(d, o, levels.drive_to_obstacle) for d in drives for o in obstacles),
        *(all_to_all(o, p["sp"], levels.obstacle_to_speed) for o in obstacles),
        all_to_all(p["exc"], p["exc"], levels.exc_to_exc),
        all_to_all(p["exc"], p["sp"], levels.exc_to_speed),
        neural_field(p["target"], levels.field_near, levels.field_far),
        all_to_all(left, p["DL"], levels.target_to_drive),
        all_to_all(right, p["DR"], levels.target_to_drive),
    )
    reached = {"dvs_right": "OR", "dvs_left": "OL", "dvs_columns": "target", "start": "exc"}
    inputs = tuple(PopulationInput(k, p[name], levels.dvs_synapses) for k, name in reached.items())
    return Network(tuple(p.values()), projections, inputs)
