"""The compiled loop against the paper's equations written out with numpy, and against dense sampling."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from circuits.arrays import F64
from system.openspace.kernel import COLLIDED, OVER, TRAPPED, advance, choose, fly, goal_arc, ping
from system.openspace.law import ARCS, DIRECTIONS, MIDDLE, Arcs, Bat, arcs_of, detectable
from system.openspace.map import SIDE, Cells, Forest, cells_of, clearance, plant
from system.openspace.senses import EXACT
from system.openspace.state import (
    ARC,
    AVOIDED,
    CROSSED,
    EMERGENCIES,
    HEAD,
    HEADING,
    HIT,
    LAP,
    SCANNING,
    SEEN,
    TIME,
    Flight,
    X,
    Y,
    new_flight,
)

BAT = Bat()
ARCS_OF = arcs_of(BAT)


def scene(*obstacles: tuple[float, float]) -> tuple[Cells, int]:
    place = np.array(obstacles, dtype=np.float64).reshape(-1, 2) % SIDE
    return cells_of(Forest("scene", place), BAT.max_range + 1.0), len(place)


def flight(obstacles: int, x: float = 25.0, y: float = 25.0, heading: float = -math.pi) -> Flight:
    return new_flight(x, y, heading, DIRECTIONS, obstacles, 0)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(0, DIRECTIONS - 1))
def test_what_is_in_view(seed: int, head: int) -> None:
    random = np.random.default_rng(seed)
    forest = Forest("wood", random.random((1400, 2)) * SIDE)
    x, y = random.random(2) * SIDE
    heading = random.uniform(-math.pi, math.pi)
    state = flight(1400, x, y, heading)
    state.counts[HEAD] = head
    ping(ARCS_OF, EXACT, cells_of(forest, BAT.max_range + 1.0), state)
    apart = forest.place - np.array([x, y])
    apart -= SIDE * np.round(apart / SIDE)
    bearing = np.arctan2(apart[:, 1], apart[:, 0]) - heading - ARCS_OF.direction[head]
    bearing = (bearing + math.pi) % (2.0 * math.pi) - math.pi
    seen = np.hypot(*apart.T) <= detectable(BAT, bearing)
    assert state.counts[SEEN] == state.counts[AVOIDED] == seen.sum()
    assert np.array_equal(state.met == 1, seen)


def desirability(bat: Bat, arcs: Arcs, state: Flight, head: int, arc: int) -> F64:
    """Equation (6)."""
    p = np.arange(ARCS)
    aim = goal_arc(arcs, float(state.pose[HEADING]))
    wish = arcs.bias + bat.goal_gain * np.exp(-((p - aim) ** 2) / bat.goal_sigma**2)
    wish += bat.ping_bias * (arcs.group == head)
    wish += bat.hysteresis * np.exp(-((p - arc) ** 2) / bat.hysteresis_sigma**2)
    for q in range(ARCS):
        wish -= bat.suppression * state.risk[q] * np.exp(-((p - q) ** 2) / bat.suppression_sigma**2)
    return np.asarray(wish)


@pytest.mark.parametrize("heading", [-math.pi, -2.0, 0.4, 3.0])
def test_memory_and_desirability_follow_the_equations(heading: float) -> None:
    forest = plant(1400, np.random.default_rng(5))
    cells = cells_of(forest, BAT.max_range + 1.0)
    state = flight(1400, 12.0, 30.0, heading)
    state.risk[:] = np.random.default_rng(6).uniform(0.0, 10.0, ARCS)
    for scanning in (0, 1):
        state.counts[SCANNING] = scanning
        before, head, arc = state.risk.copy(), int(state.counts[HEAD]), int(state.counts[ARC])
        ping(ARCS_OF, EXACT, cells, state)
        decayed = before - (0.0 if scanning else BAT.decay)
        decayed -= BAT.inhibition * (ARCS_OF.group == head)
        assert np.allclose(state.risk, np.maximum(decayed, np.minimum(state.fresh, BAT.max_risk)))
        expected = desirability(BAT, ARCS_OF, state, head, arc)
        choose(ARCS_OF, EXACT, state)
        # the Gaussian of the goal comes from a recurrence of 32 steps
        assert np.allclose(state.wish, expected, rtol=0.0, atol=1e-12)


def test_the_goal_lies_due_west() -> None:
    assert goal_arc(ARCS_OF, -math.pi) == MIDDLE
    assert goal_arc(ARCS_OF, math.pi - 0.1) < MIDDLE < goal_arc(ARCS_OF, 0.1 - math.pi)  # to the left: fewer
    beyond = math.pi - BAT.goal_span - 0.1
    assert goal_arc(ARCS_OF, beyond) == 0.0
    assert goal_arc(ARCS_OF, -beyond) == ARCS - 1


def test_a_clear_path_is_flown_without_scanning() -> None:
    cells, count = scene((10.0, 40.0))
    state = flight(count)
    assert fly(ARCS_OF, EXACT, cells, state, 10) == 0
    assert state.pose[Y] == pytest.approx(25.0)
    assert state.pose[X] == pytest.approx(25.0 - 10 * BAT.max_speed / BAT.ping_rate)
    assert state.pose[TIME] == pytest.approx(10 / BAT.ping_rate)


def test_the_first_touch_is_where_the_zone_is_reached() -> None:
    cells, count = scene((24.5, 25.1), (24.6, 24.75))
    state = flight(count)
    assert advance(replace_speed(10.0), cells, state)
    zone = BAT.zone
    ways = [0.5 - math.sqrt(zone**2 - 0.1**2), 0.4 - math.sqrt(max(zone**2 - 0.25**2, 0.0))]
    assert 25.0 - state.pose[X] == pytest.approx(min(ways), abs=1e-9)
    assert state.counts[HIT] == int(np.argmin(ways))


def replace_speed(speed: float) -> Arcs:
    return arcs_of(replace(BAT, max_speed=speed))


def test_a_collided_obstacle_is_not_avoided() -> None:
    cells, count = scene((23.0, 25.0), (22.5, 25.6))
    state = flight(count)
    ping(ARCS_OF, EXACT, cells, state)
    assert state.counts[AVOIDED] == 2
    for _ in range(20):
        if advance(ARCS_OF, cells, state):  # straight on, whatever is there
            break
    assert state.counts[HIT] == 0
    assert state.counts[AVOIDED] == 1


def test_obstacles_count_again_after_the_left_border() -> None:
    cells, count = scene((47.0, 25.8))
    state = flight(count, x=1.0)
    for _ in range(6):
        ping(ARCS_OF, EXACT, cells, state)
        advance(ARCS_OF, cells, state)
    assert state.counts[LAP] == 1
    assert state.counts[AVOIDED] == 2  # seen from 1 m and 0.2 m right of the border, and from beyond it
    assert state.pose[X] == pytest.approx(SIDE + 1.0 - 6 * BAT.max_speed / BAT.ping_rate)


def test_with_all_ways_barred_it_turns_round() -> None:
    bearing = np.linspace(-math.pi, math.pi, 40, endpoint=False)
    cells, count = scene(*[(25.0 + 0.8 * math.cos(b), 25.0 + 0.8 * math.sin(b)) for b in bearing])
    state = flight(count)
    arcs = ARCS_OF
    for _ in range(6):
        ping(arcs, EXACT, cells, state)
        choose(arcs, EXACT, state)
        if state.counts[EMERGENCIES]:
            break
    assert state.counts[EMERGENCIES] == 1
    assert state.pose[HEADING] == pytest.approx(0.0)
    assert state.counts[ARC] == MIDDLE
    assert state.risk.max() == 0.0


def test_it_turns_round_for_ever_by_the_papers_law_and_twice_in_a_row_with_an_escape() -> None:
    apart = np.linspace(-math.pi, math.pi, 40, endpoint=False)
    place = [(25.0 + 0.8 * math.cos(a), 25.0 + 0.8 * math.sin(a)) for a in apart]
    cells, count = scene(*place)
    plain, escaping = flight(count), flight(count)
    fly(ARCS_OF, EXACT, cells, plain, 12)
    fly(ARCS_OF._replace(escape=2), EXACT, cells, escaping, 3)
    assert plain.counts[EMERGENCIES] == 12
    assert escaping.counts[EMERGENCIES] == 2


def test_who_does_not_get_anywhere_is_trapped() -> None:
    arcs = arcs_of(replace(BAT, goal_gain=0.0001, hysteresis=8.0))  # whatever arc it is on, it stays on
    cells, count = scene((10.0, 10.0))
    state = flight(count)
    state.counts[ARC] = 2
    assert fly(arcs, EXACT, cells, state, 20_000) == TRAPPED
    assert state.pose[TIME] == pytest.approx(2500.0, abs=1.0 / BAT.ping_rate)


def test_a_run_is_over_after_250_000_seconds() -> None:
    cells, count = scene((10.0, 40.0))
    state = flight(count)
    state.pose[TIME] = state.pose[CROSSED] = 249_999.5
    assert fly(ARCS_OF, EXACT, cells, state, 100) == OVER
    assert state.pose[TIME] == pytest.approx(250_000.0, abs=1.0 / BAT.ping_rate)


def test_it_collides_in_the_end() -> None:
    forest = plant(1700, np.random.default_rng(2))
    random = np.random.default_rng(2)
    while clearance(forest, *(start := SIDE * random.random(2))) < 1.0:
        pass
    state = flight(1700, *start)
    arcs = arcs_of(replace(BAT, max_speed=12.0))
    assert fly(arcs, EXACT, cells_of(forest, 6.0), state, 100_000) == COLLIDED
    hit = forest.place[state.counts[HIT]] - state.pose[:2]
    hit -= SIDE * np.round(hit / SIDE)
    assert np.hypot(*hit) == pytest.approx(BAT.zone, abs=1e-9)
