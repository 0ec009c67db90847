"""Bug: a robot with a compass and a contact sensor looks for a goal among obstacles (Stöckel 2017).

map -> polygons -> senses every 10 ms -> brain -> steering vector -> disc that slides along walls. A brain is
one of three agents, Bug 0, 1 or 2, as a program (`reference`) or as a network of ideal spiking neurons
(`ideal`). A run ends at the goal, when the brain says that the goal cannot be reached, or with the time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from chips.nef_build import build
from chips.nef_curves import IdealCurves
from circuits.circuit import BiasKind, Circuit
from circuits.die import NOMINAL, Die
from circuits.errors import ParameterError, unknown_name
from system.bug_brain import AGENTS, STATES, Brain
from system.bug_map import Point, load_map, pick
from system.bug_neural import network_of, neural_brain
from system.bug_path import path_length, shortest_path
from system.bug_picture import draw_run
from system.bug_reference import no_agent, reference_brain
from system.bug_robot import ARRIVED, RADIUS, STEP, Robot
from system.bug_world import World, build_world, check_place

F64 = NDArray[np.float64]
I64 = NDArray[np.int64]

BRAINS = ("reference", "ideal")
SUMMARY = (
    "reached", "unreachable", "time_s", "path_length", "shortest_path_length", "path_ratio", "final_distance",
)  # fmt: skip
DEFAULT_MAP = "bug-spiral"
DURATION = 200.0  # s, after which a run ends; ours
ROOM_TEMPERATURE = 27.0
_SIGN_OF_LIFE = 100  # steps


@dataclass(frozen=True, slots=True)
class Scenario:
    """What a robot is asked to do.

    design: of Bug 2's network, `published` or `improved`; neurons: how many in all, about, the design's if
    None; map: one of `bug_map.MAPS`, or a file; start, goal: numbers from 0 in reading order, or `X,Y` in map
    units; duration: s; seed: of the network's neurons.
    """

    agent: str = "bug2"
    brain: str = "reference"
    design: str = "published"
    neurons: int | None = None
    map: str = DEFAULT_MAP
    start: str = "0"
    goal: str = "0"
    duration: float = DURATION
    seed: int = 0
    die: Die = NOMINAL
    temperature_c: float = ROOM_TEMPERATURE

    def __post_init__(self) -> None:
        if self.agent not in AGENTS:
            raise no_agent(self.agent)
        if self.brain not in BRAINS:
            raise unknown_name("--brain", self.brain, BRAINS)
        if self.brain == "reference" and (self.neurons is not None or self.design != "published"):
            option = "--design" if self.neurons is None else "--neurons"
            raise ParameterError(f"{option}: a reference has no neurons; add --brain ideal, or leave it out")
        if self.seed < 0:
            raise ParameterError(f"--seed: {self.seed}, must be >= 0")
        if not STEP <= self.duration < 1e6:
            raise ParameterError(f"--duration: {self.duration:g} s, must be at least {STEP:g} s, below 1e6 s")
        if self.temperature_c != ROOM_TEMPERATURE:
            raise ParameterError(
                f"--temperature: {self.temperature_c:g} degC, must be {ROOM_TEMPERATURE:g}: no chip is in the"
                " loop; leave it out"
            )


@dataclass(frozen=True, slots=True)
class Trace:
    """A run: places, float64[steps + 1, 2], and states, int64[steps], numbers in `STATES`, every 10 ms.

    verdict: what the brain has found out, empty for nothing; shortest: way of a point, None if there is none.
    """

    scenario: Scenario
    world: World
    path: F64
    state: I64
    reached: bool
    verdict: str
    shortest: F64 | None

    @property
    def time(self) -> float:
        """Length of the run, s."""
        return STEP * len(self.state)

    @property
    def ended(self) -> str:
        """Why it ended."""
        return "reached" if self.reached else self.verdict or "out of time"


def run(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
    """Drive until the goal, a verdict or the end of the time.

    Raises `DataError` for a map that is none, `ParameterError` for a start or goal where the robot does not
    fit.
    """
    world = build_world(load_map(scenario.map))
    start = pick(world.map.starts, scenario.start, "--start")
    goal = pick(world.map.goals, scenario.goal, "--goal")
    check_place(world, start, RADIUS, "--start")
    check_place(world, goal, RADIUS, "--goal")
    robot = Robot(world, start, goal)
    brain = make_brain(scenario, world)
    path, states = drive(robot, brain, round(scenario.duration / STEP), progress)
    reached = robot.distance < ARRIVED
    shortest = shortest_path(world, start, goal)
    return Trace(scenario, world, path, states, reached, "" if reached else brain.verdict, shortest)


def make_brain(scenario: Scenario, world: World) -> Brain:
    """The brain that a scenario asks for."""
    if scenario.brain == "reference":
        return reference_brain(scenario.agent, world.map.diagonal)
    network = network_of(scenario.agent, scenario.design, scenario.neurons)
    return neural_brain(scenario.agent, build(network, IdealCurves(), scenario.seed))


def drive(
    robot: Robot, brain: Brain, steps: int, progress: Callable[[float], None] | None = None
) -> tuple[F64, I64]:
    """Let a brain drive a robot, at most so many steps of 10 ms; returns places and states."""
    path, states = np.empty((steps + 1, 2)), np.empty(steps, dtype=np.int64)
    path[0], done = robot.place, 0
    while done < steps and robot.distance >= ARRIVED and not brain.verdict:
        robot.step(brain.step(robot.sense()))
        states[done] = STATES.index(brain.state)
        done += 1
        path[done] = robot.place
        if progress is not None and done % _SIGN_OF_LIFE == 0:
            progress(done / steps)
    return path[: done + 1], states[:done]


def summarise(trace: Trace) -> dict[str, float | None]:
    """Scalars of a run; lengths in map units, None where there is no way."""
    length = path_length(trace.path)
    shortest = None if trace.shortest is None else path_length(trace.shortest)
    goal = goal_of(trace)
    return {
        "reached": float(trace.reached),
        "unreachable": float(bool(trace.verdict)),
        "time_s": trace.time,
        "path_length": length,
        "shortest_path_length": shortest,
        "path_ratio": length / shortest if shortest and trace.reached else None,
        "final_distance": float(np.hypot(*(trace.path[-1] - goal))),
    }


def goal_of(trace: Trace) -> Point:
    """The goal of a run."""
    return pick(trace.world.map.goals, trace.scenario.goal, "--goal")


def read_options(options: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of a scenario from those of the command line, which have the same names."""
    return dict(options)


@dataclass(frozen=True, slots=True)
class BugSystem:
    """The system as the command line sees it."""

    name: str = "bug"
    summary: str = "robot with a compass and contact that follows walls: Bug 0, 1, 2 as programs and neurons"
    metrics: tuple[str, ...] = SUMMARY
    study_metrics: tuple[str, ...] = ("reached", "time_s", "path_length")

    def scenario(self, **options: Any) -> Scenario:
        """A scenario of these fields."""
        return Scenario(**options)

    def study_options(
        self, level: str, duration: float, bias_kind: BiasKind | None, route: Mapping[str, str]
    ) -> dict[str, Any]:
        """Fields of a study's scenario."""
        if level != "behavioural" or bias_kind is not None:
            option = "--level" if level != "behavioural" else "--bias-kind"
            raise ParameterError(f"{option}: no chip is in the robot's loop; leave it out")
        for name in route:
            if name != "map":
                raise ParameterError(f"--{name}: not an option of a robot's study; leave it out")
        return dict(route)

    def circuits(self) -> tuple[Circuit, ...]:
        """What it is made of: none."""
        return ()

    def run(self, scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
        """Run a scenario."""
        return run(scenario, progress)

    def summarise(self, trace: Trace) -> dict[str, float | None]:
        """Scalars of a run."""
        return summarise(trace)

    def draw(self, trace: Trace, figure: Figure) -> None:
        """Fill a figure with a run."""
        s = trace.scenario
        title = f"{s.agent}, {s.brain}, {trace.world.map.name}: {trace.ended} after {trace.time:.1f} s"
        draw_run(trace.world, trace.path, trace.shortest, title, figure)


SYSTEM = BugSystem()
