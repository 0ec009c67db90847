"""A rover on its way that goes on by a control period of 0.1 s (`system.live.robot`).

An action is a turn rate; it always drives on at its speed. What it senses are the last fix of its GPS, its
compass, the next waypoint of its plan, the goal, the map's costs about the fix, and what its sonars see. The
reward is by how much the least cost of the way to the goal has fallen, `ARRIVAL` more where it arrives and
`INTERVENTION` less where an operator leads it round an obstacle (ours).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from circuits.arrays import F64
from system.live.signals import Channel, Signals, gathered
from system.plot import COLOURS
from system.rover.body import bearing, wrapped
from system.rover.cost_map import MAX_COST
from system.rover.drive import Avoid, Voyage, cell_at, locate, roll, steering
from system.rover.picture import draw_map, draw_ways
from system.rover.planner import Plan
from system.rover.search import dijkstra
from system.rover.sensors import Obstacle, nearest_ahead

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ARRIVAL, INTERVENTION = 10.0, 10.0  # units of cost; ours
AROUND = 2  # cells to either side of the fix whose costs are told; ours
_WIDTH = 2 * AROUND + 1
FAR = 1e6  # m, farther than any drive leads
SENSES = Signals(
    (
        Channel("last fix, east and north of the south-west corner", "m", -FAR, FAR, (2,)),
        Channel("heading by the compass, clockwise from true north", "rad", -math.pi, math.pi),
        Channel("turn to the next waypoint from the fix, clockwise", "rad", -math.pi, math.pi),
        Channel("distance of the next waypoint from the fix", "m", 0.0, 2.0 * FAR),
        Channel("turn to the goal from the fix, clockwise", "rad", -math.pi, math.pi),
        Channel("distance of the goal from the fix", "m", 0.0, 2.0 * FAR),
        Channel(
            "costs of the cells about the fix, row by row from the north, 0 blocked or beyond the map", "",
            0.0, MAX_COST, (_WIDTH * _WIDTH,),
        ),
        Channel("distance of the nearest obstacle that the sonars see", "m", -FAR, FAR),
        Channel("its side, clockwise from ahead; 0 for none", "rad", -math.pi, math.pi),
    )
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Readings:
    """What a rover knows before a step.

    fix : of the GPS, m east and north; heading : by its compass, rad clockwise from true north; obstacle :
    distance (m) and side (rad) of the nearest that the sonars see, None for none.
    """

    fix: tuple[float, float]
    heading: float
    obstacle: tuple[float, float] | None


class LiveRover:
    """A rover on its way; `System.open` of the rover.

    Parameters
    ----------
    voyage : the rover at its start.
    plan : the way that its planner found.
    posts : obstacles that no map has.
    avoid : its own law's turn away from them, None without sonars.
    """

    senses = SENSES

    def __init__(self, voyage: Voyage, plan: Plan, posts: tuple[Obstacle, ...], avoid: Avoid | None) -> None:
        self.voyage, self.plan, self._posts, self._avoid = voyage, plan, posts, avoid
        most = voyage.rover.turn_rate
        self.actions = Signals((Channel("turn rate, clockwise", "rad/s", -most, most),))
        costs = voyage.cost_map.costs
        goal = int(plan.path[-1, 0]), int(plan.path[-1, 1])
        self._least = dijkstra.distances(costs, goal)
        self._left = float(self._least[voyage.cell])
        self._costs = np.pad(costs, AROUND)
        self.reward, self._own = 0.0, True
        self._wanted: float | None = None
        self.path = [self.place]
        self._heading = voyage.pose.heading
        self._look()

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return self.voyage.time

    @property
    def place(self) -> tuple[float, float]:
        """Where it is, m east and north."""
        return self.voyage.pose.east, self.voyage.pose.north

    @property
    def ended(self) -> str:
        """Whether it has arrived: by every waypoint under its own law, else by the goal alone."""
        reach = self.voyage.rover.reach
        near = math.dist(self.voyage.gps.fix, self.voyage.points[-1]) < reach
        arrived = self.voyage.arrived if self._own else near
        return f"goal reached: a fix within {reach:g} m of it" if arrived else ""

    @property
    def late(self) -> str:
        """Whether its patience is over."""
        return f"time of {self.time:.0f} s over" if self.voyage.late else ""

    @property
    def succeeded(self) -> bool:
        """Whether it has arrived."""
        return bool(self.ended)

    def readings(self) -> Readings:
        """Return what it knows."""
        return self._seen

    def sense(self) -> F64:
        """Return the observation, as `SENSES`."""
        seen, voyage = self._seen, self.voyage
        target = voyage.points[min(voyage.waypoint, len(voyage.points) - 1)]
        row, column = cell_at(voyage.cost_map, *seen.fix)
        about = self._costs[row : row + _WIDTH, column : column + _WIDTH]
        obstacle = seen.obstacle or (voyage.rover.sonar_range, 0.0)
        towards = [self._towards(point) for point in (target, voyage.points[-1])]
        return gathered(seen.fix, seen.heading, *towards, about, obstacle)

    def own(self) -> F64:
        """Return the turn rate towards the next waypoint, or away from what the sonars see."""
        turn = None if self._avoid is None else self._avoid(self.voyage.pose)
        self._wanted = steering(self.voyage, self._heading) if turn is None else turn
        return np.array([self._wanted])

    def act(self, action: F64) -> None:
        """Drive for a control period at a turn rate."""
        turn = float(action[0])
        self._own = self._own and turn == self._wanted
        before, helped = self._left, self.voyage.interventions
        roll(self.voyage, turn, self._posts)
        self.path.append(self.place)
        self._look()
        self._left = self._value()
        self.reward = before - self._left + ARRIVAL * self.succeeded
        self.reward -= INTERVENTION * (self.voyage.interventions - helped)

    def draw(self, ax: Axes) -> None:
        """Draw the map, the planned and the driven way, and the rover."""
        draw_map(self.voyage.cost_map, None, ax)
        draw_ways(self.voyage.points, [np.array(self.path)], ax, self.voyage.rover.reach)
        ax.plot(*self.place, "o", color=COLOURS[1], markersize=5, zorder=6)

    def _look(self) -> None:
        """Take a fix where one is due; the compass is held while the own law turns away from an obstacle."""
        voyage = self.voyage
        locate(voyage)
        if self._avoid is None or self._avoid(voyage.pose) is None:
            self._heading = voyage.compass.heading(voyage.pose)
        obstacle = nearest_ahead(voyage.rover, voyage.pose, self._posts)
        self._seen = Readings(voyage.gps.fix, self._heading, obstacle)

    def _towards(self, point: F64) -> tuple[float, float]:
        """Turn (rad) and distance (m) to a point from the fix."""
        east, north = float(point[0]) - self._seen.fix[0], float(point[1]) - self._seen.fix[1]
        return wrapped(bearing(east, north) - self._heading), math.hypot(east, north)

    def _value(self) -> float:
        """Least cost of the way from here to the goal; that of the last free cell where none leads."""
        cost = float(self._least[self.voyage.cell])
        return cost if math.isfinite(cost) else self._left
