"""Bug: a robot with a compass and a contact sensor looks for a goal among obstacles (Stöckel 2017).

map -> polygons -> senses every 10 ms -> brain -> steering vector -> disc that slides along walls. A brain is
one of three agents, Bug 0, 1 or 2, as a program (`reference`), as a network of ideal spiking neurons
(`ideal`), or as that network on the NEF chip (`chip`). A run ends at the goal, when the brain says that the
goal cannot be reached, or with the time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from chips.nef.build import Built, build, moved
from chips.nef.chip import REFERENCE_C, NefChip
from chips.nef.network.curves import IdealCurves
from chips.noise import SiliconNoise
from circuits.arrays import F64, I64
from circuits.circuit import BiasKind, Circuit
from circuits.errors import ParameterError, unknown_name
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import check_temperature
from system.bug.body import ARRIVED, FASTEST, RADIUS, STEP, Robot
from system.bug.brain import AGENTS, STATES, Brain
from system.bug.map import Point, load_map, pick
from system.bug.neural import NeuralBug0, NeuralBug2, network_of, neural_brain
from system.bug.path import path_length, shortest_path
from system.bug.picture import draw_run
from system.bug.reference import no_agent, reference_brain
from system.bug.world import World, build_world, check_place
from system.options.block import describe_run
from system.options.noise import Noisy, check_noise, silicon_noise
from system.reader import In, Readers, number, read_route, read_texts, seconds, whole, words
from system.scenario import scenario_of
from system.system import SUCCEEDED, Account, Summary, metrics_with, summary_of
from system.worlds.standing import SLOW, share_standing

BRAINS = ("reference", "ideal", "chip")
SUMMARY = (
    "reached", "unreachable", "time_s", "path_length", "shortest_path_length", "path_ratio", "final_distance",
)  # fmt: skip
SUCCESS = "it reaches the goal, or says that none can be reached where no way leads there"
DEFAULT_MAP = "bug-spiral"
DURATION = 200.0  # s, after which a run ends; ours
QUANTITIES: Readers = {"area": number, "calibrated": In("degC"), "solved": In("degC"), "duration": seconds}
STUDIED: Readers = {
    **QUANTITIES, "map": words, "start": words, "goal": words, "agent": words, "design": words,
    "neurons": whole, "silicon_noise": words, "noise_seed": whole,
}  # fmt: skip
PARTS = {"calibrated_c": ("calibrated",), "solved_c": ("solved",)}  # options of these fields
_SIGN_OF_LIFE = 100  # steps


@dataclass(frozen=True, slots=True)
class Scenario:
    """What a robot is asked to do.

    design: of Bug 2's network, `published` or `improved`; neurons: how many in all, about, the design's if
    None; map: one of `bug_map.MAPS`, or a file; start, goal: numbers from 0 in reading order, or `X,Y` in map
    units; duration: s; seed: of the network's neurons. Of a chip: die, temperature_c, the one at which its
    biases were calibrated, the one at which its decoders were solved (None: the same), kind of its biases,
    area of its devices, relative, and their noise, whose seed is `seed` unless `noise_seed` is given.
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
    temperature_c: float = REFERENCE_C
    calibrated_c: float = REFERENCE_C
    solved_c: float | None = None
    bias_kind: BiasKind = "gate"
    area: float = 1.0
    silicon_noise: Noisy = "off"
    noise_seed: int | None = None

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
        check_temperature(self.temperature_c)
        check_temperature(self.calibrated_c)
        check_temperature(self.solved)
        check_noise(self.silicon_noise, self.noise_seed)
        if self.brain != "chip":
            _refuse_silicon(self)

    def device_noise(self) -> SiliconNoise | None:
        """Noise of the chip's devices."""
        return silicon_noise(self.silicon_noise, self.seed if self.noise_seed is None else self.noise_seed)

    @property
    def solved(self) -> float:
        """Where decoders were solved, degC."""
        return self.calibrated_c if self.solved_c is None else self.solved_c


def _refuse_silicon(scenario: Scenario) -> None:
    """Refuse what only a chip has."""
    for option, value, default in (
        ("--temperature", scenario.temperature_c, REFERENCE_C),
        ("--calibrated", scenario.calibrated_c, REFERENCE_C),
        ("--solved", scenario.solved_c, None),
        ("--bias-kind", scenario.bias_kind, "gate"),
        ("--area", scenario.area, 1.0),
        ("--die", scenario.die, NOMINAL),
        ("--silicon-noise", scenario.silicon_noise, "off"),
    ):
        if value != default:
            raise ParameterError(
                f"{option}: {value}, no chip is in the loop; add --brain chip, or leave it out"
            )


@dataclass(frozen=True, slots=True)
class Trace:
    """A run: places, float64[steps + 1, 2], and states, int64[steps], numbers in `STATES`, every 10 ms.

    verdict: what the brain has found out, empty for nothing; shortest: way of a point, None if there is none;
    chip: of a brain on a chip, its counters and `cut`, how many stages give less than they should.
    """

    scenario: Scenario
    world: World
    path: F64
    state: I64
    reached: bool
    verdict: str
    shortest: F64 | None
    chip: Mapping[str, int] | None = None

    @property
    def time(self) -> float:
        """Length of the run, s."""
        return STEP * len(self.state)

    @property
    def ended(self) -> str:
        """Why it ended."""
        return "reached" if self.reached else self.verdict or "out of time"

    @property
    def reason(self) -> str:
        """Why it ended, as a reader is told."""
        if self.reached:
            return f"goal reached after {self.time:.2f} s"
        if self.verdict:
            return f"goal found {self.verdict} after {self.time:.2f} s"
        return f"time of {self.scenario.duration:g} s over"


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
    verdict = "" if reached else brain.verdict
    return Trace(scenario, world, path, states, reached, verdict, shortest, counted(brain))


def make_brain(scenario: Scenario, world: World) -> Brain:
    """The brain that a scenario asks for."""
    if scenario.brain == "reference":
        return reference_brain(scenario.agent, world.map.diagonal)
    return neural_brain(scenario.agent, built_network(scenario))


def built_network(scenario: Scenario) -> Built:
    """The network of a scenario's brain on its neurons."""
    network = network_of(scenario.agent, scenario.design, scenario.neurons)
    if scenario.brain == "ideal":
        return build(network, IdealCurves(), scenario.seed)
    chip = NefChip(
        scenario.die, scenario.bias_kind, {}, scenario.calibrated_c, area=scenario.area,
        noise=scenario.device_noise(),
    )  # fmt: skip
    built = build(network, chip.at(scenario.solved), scenario.seed)
    if scenario.temperature_c == scenario.solved:
        return built
    return moved(built, chip.at(scenario.temperature_c))


def counted(brain: Brain) -> dict[str, int] | None:
    """Counters of a brain's chip, None without one."""
    if not isinstance(brain, NeuralBug0 | NeuralBug2) or brain.simulation.built.placed is None:
        return None
    return {**brain.simulation.counters, "cut": brain.simulation.built.placed.cut}


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


def account(trace: Trace) -> Account:
    """What a run says of itself; a map's unit has no length in m."""
    s = trace.scenario
    time = STEP * np.arange(len(trace.path))
    on: dict[str, Any] = {"agent": s.agent, "brain": s.brain}
    if s.brain != "reference":
        on["design"] = s.design
    if s.brain == "chip":
        on |= {
            "area": s.area,
            "silicon_noise": s.silicon_noise,
            **describe_run(s.die, s.temperature_c, s.bias_kind),
        }
    return Account(
        succeeded=trace.reached or (bool(trace.verdict) and trace.shortest is None),
        reason=trace.reason,
        ran_on=on,
        standing_share=share_standing(np.column_stack([time, trace.path]), SLOW * FASTEST),
    )


def goal_of(trace: Trace) -> Point:
    """The goal of a run."""
    return pick(trace.world.map.goals, trace.scenario.goal, "--goal")


def read_options(options: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of a scenario from the command line's, where `calibrated` and `solved` are temperatures."""
    fields = read_texts(options, QUANTITIES)
    for name in ("calibrated", "solved"):
        if name in fields:
            fields[f"{name}_c"] = fields.pop(name)
    return fields


@dataclass(frozen=True, slots=True)
class BugSystem:
    """The system as the command line sees it."""

    name: str = "bug"
    summary: str = "robot with a compass and contact that follows walls: Bug 0, 1, 2 as programs and neurons"
    success: str = SUCCESS
    metrics: tuple[str, ...] = metrics_with(SUMMARY)
    yes_no: tuple[str, ...] = (SUCCEEDED, "reached", "unreachable")
    study_metrics: tuple[str, ...] = ("reached", "time_s", "path_length", "path_ratio")

    def scenario(self, **options: Any) -> Scenario:
        """A scenario of these fields, or of options as the command line has them."""
        return scenario_of(self.name, Scenario, options, read_options, PARTS)

    def study_options(
        self, level: str, bias_kind: BiasKind | None, route: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Fields of a study's scenario, on the chip."""
        if level != "behavioural":
            raise ParameterError("--level: transistor, a brain's neurons are models; leave it out")
        fields = {"brain": "chip", **read_options(read_route(self.name, route, STUDIED))}
        if bias_kind is not None:
            fields["bias_kind"] = bias_kind
        return fields

    def circuits(self) -> tuple[Circuit, ...]:
        """What it is made of: none."""
        return ()

    def run(self, scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
        """Run a scenario."""
        return run(scenario, progress)

    def account(self, trace: Trace) -> Account:
        """What a run says of itself."""
        return account(trace)

    def summarise(self, trace: Trace) -> Summary:
        """Account and scalars of a run."""
        return summary_of(account(trace), summarise(trace))

    def draw(self, trace: Trace, figure: Figure) -> None:
        """Fill a figure with a run."""
        s = trace.scenario
        title = f"{s.agent}, {s.brain}, {trace.world.map.name}; {account(trace).headline}"
        draw_run(trace.world, trace.path, trace.shortest, title, figure)


SYSTEM = BugSystem()
