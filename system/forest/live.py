"""A bat in the forest that goes on ping by ping (`system.live.robot`).

An action is the arc that is flown until the next ping, the direction of that ping, and whether the bat turns
round first, as it does in an emergency. What it senses are the echoes of the last ping. The reward is the way
to the left in m, `COLLISION` less where it collides (ours).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from circuits.arrays import F64, I64
from system.forest.scenario import Scenario
from system.live.robot import Chosen
from system.live.signals import Channel, Signals, gathered, padded
from system.openspace.choice import arc_actions
from system.openspace.flight import begin, gets_on, margin_of, planter
from system.openspace.kernel import LONGEST, TRAPPED_AFTER, advance, choose, ping
from system.openspace.law import ARCS, DIRECTIONS
from system.openspace.map import cells_of
from system.openspace.moving import Moving
from system.openspace.picture import draw_forest, draw_path
from system.openspace.reader_noise import answers
from system.openspace.senses import begin_again
from system.openspace.senses_kernel import SILENT
from system.openspace.state import (
    ARC,
    CROSSED,
    ECHO_BEARING,
    ECHO_NUMBER,
    ECHO_RANGE,
    ECHO_X,
    ECHO_Y,
    EMERGENCIES,
    HEAD,
    HEADING,
    LAPS_X,
    SCANNING,
    TIME,
    Flight,
    X,
    Y,
    new_flight,
)
from system.plot import COLOURS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ECHOES = 16  # of an observation, the nearest; ours
COLLISION = 10.0  # m of way that a collision costs; ours
SHARPEST, FAR = 1000.0, 1000.0  # 1/m and m, beyond any arc and echo
SENSES = Signals(
    (
        Channel("cosine of the goal's bearing", "", -1.0, 1.0),
        Channel("sine of the goal's bearing, to the left", "", -1.0, 1.0),
        Channel("direction of the last ping, to the left", "rad", -math.pi, math.pi),
        Channel("curvature of the arc that is flown, to the left", "1/m", -SHARPEST, SHARPEST),
        Channel("ranges of the nearest echoes, 0 for none", "m", 0.0, FAR, (ECHOES,)),
        Channel("their bearings from straight ahead, to the left", "rad", -math.pi, math.pi, (ECHOES,)),
    )
)
ACTIONS = arc_actions(ARCS, DIRECTIONS, "whether it turns round first")


class LiveForest:
    """A bat on one flight; `System.open` of the forest.

    Parameters
    ----------
    scenario : whose forest, start, senses and selection it has.
    moving : its senses over time.
    key : of its forest and start.
    """

    senses, actions = SENSES, ACTIONS

    def __init__(self, scenario: Scenario, moving: Moving, key: tuple[int, ...]) -> None:
        self.scenario, self.arcs, self._moving = scenario, scenario.arcs, moving
        random = np.random.default_rng((*key, 0))
        self.forest = planter(scenario.obstacles, scenario.map)(random)
        x, y = begin(self.arcs, self.forest, random, scenario.start)
        self._cells = cells_of(self.forest, margin_of(self.arcs))
        self._flight = new_flight(x, y, -math.pi, DIRECTIONS, len(self.forest.place), 0)
        self._senses = moving.at(0.0)
        begin_again(self._senses)
        self.path = [(x, y)]
        self.reward, self.ended, self._begin = 0.0, "", x
        self._choice: Chosen[Flight] | None = None
        self._pings = 0
        self._ping()

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return float(self._flight.pose[TIME])

    @property
    def place(self) -> tuple[float, float]:
        """Where it is, m."""
        return float(self._flight.pose[X]), float(self._flight.pose[Y])

    @property
    def late(self) -> str:
        """Whether all pings are flown."""
        return f"all {self._pings} pings flown" if self._pings >= self.scenario.pings else ""

    @property
    def succeeded(self) -> bool:
        """Whether it has not ended, and has come on to the left."""
        straight = self.time * self.scenario.bat.max_speed
        return not self.ended and gets_on(self._begin - float(self._flight.pose[LAPS_X]), straight)

    def readings(self) -> F64:
        """Ranges (m) and bearings (rad) of all echoes of the last ping, float64[echoes, 2], nearest first."""
        rows = self._flight.echo
        end = np.flatnonzero(np.isnan(rows[:, ECHO_RANGE]))
        x, y = rows[: end[0] if end.size else None][:, [ECHO_X, ECHO_Y]].T
        x, y = x[~np.isnan(x)], y[~np.isnan(x)]
        heard = np.stack([np.hypot(x, y), np.arctan2(y, x)], axis=1)
        return np.asarray(heard[np.argsort(heard[:, 0], kind="stable")])

    def spikes(self) -> tuple[F64, I64]:
        """Return the spikes of its ranging chip's neurons in the last ping: times, s, and neurons.

        Of a chip without codes they are those by which echoes are read: a neuron's first within `WINDOW`
        after each echo.
        """
        flight, senses = self._flight, self._senses
        if senses.population.on.size:
            return senses.population.spoke()
        rows = flight.echo[: np.flatnonzero(np.isnan([*flight.echo[:, ECHO_RANGE], np.nan]))[0]]
        sounding = rows[rows[:, ECHO_NUMBER] != SILENT]
        pace = float(self.arcs.speed[flight.counts[ARC]])
        toward = senses.sound_speed + pace * np.cos(sounding[:, ECHO_BEARING])
        told = [answers(senses.reader, delay) for delay in (2.0 * sounding[:, ECHO_RANGE] / toward).tolist()]
        times = self.time + np.concatenate([np.empty(0), *(late for late, _ in told)])
        return times, np.concatenate([np.empty(0, dtype=np.int64), *(which for _, which in told)])

    def sense(self) -> F64:
        """Return the observation, as `SENSES`."""
        flight, arcs = self._flight, self.arcs
        bearing = math.pi - float(flight.pose[HEADING])
        told = arcs.direction[flight.counts[HEAD]], arcs.curvature[flight.counts[ARC]]
        echoes = padded(self.readings(), ECHOES, 0.0)
        return gathered(math.cos(bearing), math.sin(bearing), told, echoes.T)

    def own(self) -> I64:
        """Return the action of Curved Openspace, or of its chip."""
        before = self._flight
        copied = {name: getattr(before, name).copy() for name in _CHOSEN}
        after = before._replace(**copied)
        choose(self.arcs, self._senses, after)
        turned = int(after.counts[EMERGENCIES] - before.counts[EMERGENCIES])
        action = np.array([after.counts[ARC], after.counts[HEAD], turned], dtype=np.int64)
        self._choice = Chosen(action, after)
        return action.copy()

    def act(self, action: I64) -> None:
        """Fly on with an action until the next ping, and ping."""
        chosen, self._choice = self._choice, None
        if chosen is not None and np.array_equal(action, chosen.action):
            self._flight = chosen.after
        else:
            self._steer(*action.tolist())
        before = float(self._flight.pose[LAPS_X])
        collided = advance(self.arcs, self._cells, self._flight)
        self._pings += 1
        self.path.append(self.place)
        self.reward = before - float(self._flight.pose[LAPS_X]) - COLLISION * collided
        self.ended = self._why(collided=collided)
        if not self.ended:
            self._ping()

    def draw(self, ax: Axes) -> None:
        """Draw the forest, the way and the bat."""
        draw_forest(self.forest.place, self.scenario.bat.zone, ax)
        draw_path(np.array(self.path), ax)
        ax.plot(*self.place, "o", color=COLOURS[1], markersize=5)

    def _ping(self) -> None:
        self._senses = self._moving.at(self.time)
        ping(self.arcs, self._senses, self._cells, self._flight)

    def _steer(self, arc: int, head: int, turns: int) -> None:
        flight = self._flight
        if turns:
            flight.pose[HEADING] -= math.copysign(math.pi, flight.pose[HEADING])
        flight.counts[ARC], flight.counts[HEAD], flight.counts[SCANNING] = arc, head, 0

    def _why(self, *, collided: bool) -> str:
        """Why the flight is over, empty while it goes on."""
        if collided:
            return "collided with an obstacle"
        if self.time - float(self._flight.pose[CROSSED]) >= TRAPPED_AFTER:
            return f"trapped: {TRAPPED_AFTER:g} s without a new crossing"
        return f"{LONGEST:g} s flown" if self.time >= LONGEST else ""


_CHOSEN = ("pose", "counts", "risk", "wish", "sensed", "current")  # of a flight, that a choice overwrites
