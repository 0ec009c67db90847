"""Bug 2 of 4,010 spiking neurons (Stöckel 2017, III.D and Figures 3 and 5).

Four states: memorise the absolute direction to the goal, go towards it, store the distance where a wall is
hit, follow the wall. Each has neurons that fire when it is over: a memory is done, there is contact, or the
robot is nearer to the goal than where it hit the wall, in the direction that it has memorised. Their sum
triggers a state machine, which silences the neurons of every state but one.

| ours | neurons |
|---|---|
| rays 8 x 50, go 100, follow 100, motor 150 | 750 |
| contact | 100 |
| memory of the direction: stored 500, difference 250, done 60 | 810 |
| memory of the distance: stored 300, difference 150, done 60 | 510 |
| leave: nearer 150, astray 300, both 100 | 550 |
| old and current state, 250 each; two gates of 150 | 800 |
| trigger 45 and its inversion 45; hysteresis 4 x 50; inversion 4 x 50 | 490 |

`IMPROVED`, ours, has 6,660. The direction is drawn weakly to a circle, both memories have more neurons,
slower synapses and decoders that are fitted more closely, and the direction is compared within 3 degrees: so
it leaves a wall near the line from the start, and the next wall that it hits is one that the line crosses.
States are corners of a tetrahedron: on the circle `follow` is opposite to `go`, and between them `memorise`
is near. The window of directions is shifted past the line, so that it leaves within 1 degree of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from chips.nef.network.memory import (
    MemorySize,
    StateSize,
    apart,
    is_above,
    memory,
    near,
    state_machine,
    states,
    threshold_neurons,
    unless_active,
)
from chips.nef.network.network import Connection, Ensemble, Network, Node, Probe, join
from circuits.arrays import F64
from system.bug.brain import CONTACT_FILTER, FOLLOW, GO, MEMORISE, STATES, STORE
from system.bug.neural0 import NetworkSize, behaviours

AFTER = {MEMORISE: GO, GO: STORE, STORE: FOLLOW, FOLLOW: GO}
DIRECTION = MemorySize(500, 250, 60, reach=0.3, near=0.05)
DISTANCE = MemorySize(300, 150, 60, reach=0.15, near=0.015)
LAYOUTS = {"circle": states, "simplex": apart}
MACHINE = StateSize(250, 150, 45, 50, 50)


@dataclass(frozen=True, slots=True)
class Bug2Size(NetworkSize):
    """How many neurons each part of the network has, 4,010 in the published design; and its constants.

    layout: of the states' points, a circle as published, or a simplex, where all are equally far from each
    other; length: of a direction that is stored, which the circle sets; reach: largest difference of
    directions that is represented; same: length of a difference of unit vectors that counts as the same
    direction, 7 degrees in the published design; margin: of the map's diagonal, by which it must be nearer to
    the goal than at the hit; quick: synapse of the neurons that say so, s; beyond: angle past the line, rad,
    as it is crossed with the wall on the left, about which directions count as the same; all ours.

    distance : of the memory of the distance.
    astray : that hold the direction against the stored one.
    leave : that fire when the wall can be left.
    machine : of the state machine.
    """

    direction: MemorySize = DIRECTION
    distance: MemorySize = DISTANCE
    nearer: int = 150
    astray: int = 300
    leave: int = 100
    machine: StateSize = MACHINE
    layout: str = "circle"
    length: float = 1.0
    reach: float = 0.4
    same: float = 0.12
    margin: float = 0.01
    quick: float = 0.02
    beyond: float = 0.0


def _turned(angle: float) -> F64:
    """Matrix that turns a vector counterclockwise, rad."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s], [s, c]])


PUBLISHED = Bug2Size()
IMPROVED = Bug2Size(
    direction=MemorySize(1000, 400, 60, reach=0.3, near=0.05, synapse=0.3, circle=0.1, holding=0.003),
    distance=MemorySize(1000, 300, 60, reach=0.15, near=0.015, synapse=0.3, holding=0.003),
    nearer=300,
    astray=800,
    machine=StateSize(400, 250, 45, 50, 50),
    layout="simplex",
    quick=0.01,
    beyond=0.03,
    reach=0.16,
    same=0.05,
    margin=0.005,
)
DESIGNS = {"published": PUBLISHED, "improved": IMPROVED}


def bug2_network(s: Bug2Size = PUBLISHED) -> Network:
    """Return the network of Bug 2.

    Nodes: `ranges` (nearness), `ahead`, `north`, `distance`, `touch`, `one`, `start` (a state's point);
    probes `motor?`, `state?` (activity of each state), `direction?`, `distance?` (what is stored).
    """
    number = {state: k for k, state in enumerate(STATES)}
    points = LAYOUTS[s.layout](len(STATES))

    def only_in(state: str, *posts: str) -> tuple[Connection, ...]:
        return tuple(unless_active("state", number[state], len(STATES), post) for post in posts)

    control = Network(
        (
            threshold_neurons("contact", s.contact),
            Ensemble("nearer", s.nearer, radius=0.2),
            Ensemble("astray", s.astray, 2, radius=s.reach),
            threshold_neurons("leave", s.leave),
        ),
        (Node("touch", 1), Node("north", 2), Node("distance", 1), Node("start", points.shape[1])),
        (
            Connection("touch", "contact", synapse=CONTACT_FILTER),
            Connection("north", "direction.difference", transform=s.length),
            Connection("distance", "distance.difference"),
            Connection("distance.stored", "nearer"),
            Connection("distance", "nearer", transform=-1.0),
            Connection("north", "astray"),
            Connection("direction.stored", "astray", transform=-_turned(-s.beyond) / s.length),
            Connection("nearer", "leave", is_above(s.margin), synapse=s.quick),
            Connection("astray", "leave", near(s.same), synapse=s.quick),
            Connection("one", "leave", transform=-0.9),
            Connection("start", "state.old", transform=2.0),
            Connection("start", "state.current", transform=2.0),
            *(
                Connection(done, "state.trigger", is_above(0.5), 1.2)
                for done in ("direction.done", "contact", "distance.done", "leave")
            ),
            *only_in(MEMORISE, "direction.difference", "direction.done"),
            *only_in(GO, "go", "contact"),
            *only_in(STORE, "distance.difference", "distance.done"),
            *only_in(FOLLOW, "follow", "leave"),
        ),
        (
            Probe("state?", "state.active"),
            Probe("direction?", "direction.stored", synapse=0.1),
            Probe("distance?", "distance.stored", synapse=0.1),
        ),
    )
    machine = state_machine("state", [number[AFTER[state]] for state in STATES], s.machine, points)
    return join(
        (
            behaviours(s.ray, s.go, s.follow, s.motor),
            memory("direction", 2, s.direction),
            memory("distance", 1, s.distance),
            machine,
            control,
        )
    )
