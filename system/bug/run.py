"""Bug: a robot with a compass and a contact sensor looks for a goal among obstacles (Stöckel 2017).

map -> polygons -> senses every 10 ms -> brain -> steering vector -> disc that slides along walls. A brain is
one of three agents, Bug 0, 1 or 2, as a program (`reference`), as a network of ideal spiking neurons
(`ideal`), or as that network on the NEF chip (`chip`). A run ends at the goal, when the brain says that the
goal cannot be reached, or with the time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from shapely import Polygon

from chips.nef.build import Built, build, moved
from chips.nef.calibration import NAME, usual_codes
from chips.nef.chip import NefChip
from chips.nef.network.curves import Curves, IdealCurves
from chips.nef.network.demand import check_demand
from chips.nef.simulation import Simulation
from circuits.arrays import F64, I64
from circuits.errors import ParameterError
from circuits.silicon.course import Course, course_through, told_when
from circuits.silicon.process import ROLLS_180
from system.bug.body import ARRIVED, FASTEST, RADIUS, STEP, Robot, Senses
from system.bug.brain import STATES, Brain
from system.bug.live import LiveBug
from system.bug.map import Point, load_map, pick
from system.bug.neural import NeuralBrain, network_of, neural_brain
from system.bug.path import path_length, shortest_path
from system.bug.picture import draw_run
from system.bug.reference import reference_brain
from system.bug.scenario import Scenario, check_seed, no_silicon
from system.bug.world import World, build_world, check_place
from system.meaning import meanings, of_run
from system.options.block import describe_run
from system.options.codes import described
from system.options.noise import device_noise
from system.options.outside import inside_boxes
from system.options.temperature import temperature_text
from system.plot import silicon_text
from system.spikes.output import spikes_made_again, trains_of
from system.system import PROGRAMS, SUCCEEDED, Account, RunTrace, System, part
from system.view.film import Film, Shape, Stage, Track, circles, corners, signal
from system.worlds.standing import SLOW, share_standing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SUMMARY = meanings("""
reached               number   -  1 where it came to the goal, else 0
unreachable           number   -  1 where it found that no way leads to the goal, else 0
time_s                number   s  time of the run
path_length           number   -  way travelled, in units of the map
shortest_path_length  number?  -  shortest way, in units of the map; null where there is none
path_ratio            number?  -  the way over the shortest; null where it did not arrive
final_distance        number   -  distance from the goal at the end, in units of the map
""")
DOCUMENT = meanings("""
design             string?      -     design of Bug 2's neurons: published or improved; null for a program
neurons            integer?     -     neurons in all; null for a program
solved_C           number       degC  temperature at which the decoders were solved
chip               object       -     counters of the chip
chip.spikes        integer      -     spikes that were made
chip.dropped       integer      -     spikes that were lost since too many waited
chip.most_waiting  integer      -     most spikes that ever waited
chip.clipped       integer      -     steps in which a converter was at its highest level
chip.lost          integer      -     of these, those whose rest was too large to be carried to the next
chip.cut           integer      -     stages that should give more than their highest code does
unmended           string[]     -     what its calibration left off, a sentence each
map                string       -     name of the map
start              number[]     -     where it began, in units of the map
goal               number[]     -     where the goal is, in units of the map
reached            boolean      -     whether it came to the goal
ended              string       -     why it ended
time_s             number       s     time of the run
step_s             number       s     time between two entries of `path` and `state`
path               number[][]   -     places, one more than there are steps, in units of the map
state              string[]     -     what the brain did in each step: `memorise`, `go`, `store` or `follow`
shortest_path      number[][]?  -     corners of the shortest way, in units of the map; null where none
                                     leads there
""")
SUCCESS = "it reaches the goal, or says that none can be reached where no way leads there"
_BRAINS = {"reference": "program", "ideal": "ideal neurons"}  # beside the chip
KEPT = 4  # networks on their neurons that are kept, 40 MB each
_SIGN_OF_LIFE = 100  # steps
_DRIFT = (
    "what the published Bug 2 stores drifts on the chip, a direction, its length and a distance, so that it"
    " may miss the place to leave a wall; `design=improved` holds them"
)


@dataclass(frozen=True, slots=True)
class Trace(RunTrace[Scenario]):
    """What a run leaves.

    path : places, float64[steps + 1, 2], map units; state : int64[steps], numbers in `STATES`, every 10 ms;
    verdict : what the brain has found out, empty for nothing; shortest : way of a point, None if there is
    none; chip : counters of a brain on a chip, and `cut`, how many stages give less than they should;
    unmended : what the chip's calibration left off, a sentence each.
    world : the obstacles.
    reached : whether the robot came to its goal.
    """

    world: World
    path: F64
    state: I64
    reached: bool
    verdict: str
    shortest: F64 | None
    chip: Mapping[str, int] | None = None
    unmended: tuple[str, ...] = ()

    @property
    def time(self) -> float:
        """Length of the run, s."""
        return STEP * len(self.state)

    @property
    def ended(self) -> str:
        """Why the run ended, in a word or two."""
        return "reached" if self.reached else self.verdict or "out of time"

    @property
    def reason(self) -> str:
        """Why the run ended, as a sentence for a reader."""
        if self.reached:
            return f"goal reached after {self.time:.2f} s"
        if self.verdict:
            return f"goal found {self.verdict} after {self.time:.2f} s"
        return f"time of {self.scenario.duration:g} s over"


@inside_boxes
def run(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
    """Drive until the goal, a verdict or the end of the time.

    Raises `DataError` for a map that is none, `ParameterError` for a start or goal where the robot does not
    fit.
    """
    robot, start, goal = _at_start(scenario)
    world = robot.world
    brain = make_brain(scenario, world)
    path, states = drive(robot, warmed(brain, scenario), round(scenario.duration / STEP), progress)
    reached = robot.distance < ARRIVED
    shortest = shortest_path(world, start, goal)
    verdict = "" if reached else brain.verdict
    return Trace(
        scenario, world, path, states, reached, verdict, shortest, counted(brain), unmended_of(brain)
    )  # fmt: skip


def open_drive(scenario: Scenario) -> LiveBug:
    """Return the robot of a scenario at its start, which goes on by 10 ms; raises as `run` does."""
    robot, _, _ = _at_start(scenario)
    return LiveBug(robot, scenario.duration, lambda: warmed(make_brain(scenario, robot.world), scenario))


def _at_start(scenario: Scenario) -> tuple[Robot, Point, Point]:
    """The robot of a scenario, where it starts, and its goal."""
    world = build_world(load_map(scenario.map))
    start = pick(world.map.starts, scenario.start, "start")
    goal = pick(world.map.goals, scenario.goal, "goal")
    check_place(world, start, RADIUS, "start")
    check_place(world, goal, RADIUS, "goal")
    return Robot(world, start, goal), start, goal


def make_brain(scenario: Scenario, world: World) -> Brain:
    """Return the brain that a scenario asks for."""
    if scenario.brain == "reference":
        return reference_brain(scenario.agent, world.map.diagonal)
    return neural_brain(scenario.agent, built_network(scenario))


def built_network(scenario: Scenario) -> Built:
    """Return the network of a scenario's brain on its neurons, ideal ones or those of a chip."""
    agent = scenario.agent, scenario.design, scenario.neurons, scenario.seed
    if scenario.brain == "ideal":
        return built_on(*agent, IdealCurves())
    chip = chip_of(scenario)
    check_demand(network_of(*agent[:3]), chip)  # before it is calibrated
    built = built_on(*agent, chip.at(scenario.solved))
    begin = scenario.beginning_c
    return built if begin == scenario.solved else moved(built, chip.at(begin))


@lru_cache(maxsize=KEPT)
def built_on(agent: str, design: str, neurons: int | None, seed: int, curves: Curves) -> Built:
    """Return the network of an agent on its neurons; no run changes it, so that the last ones are kept."""
    return build(network_of(agent, design, neurons), curves, seed)


def chip_of(scenario: Scenario) -> NefChip:
    """Return the chip of a scenario at its codes; fixed gates have none, and are trimmed."""
    s = scenario
    codes, coded_on = s.codes_of(NAME, ROLLS_180, s.area), s.coded_on
    if codes is None and s.bias_kind != "gate":  # of no die
        coded_on = None
        codes = usual_codes(s.silicon_at(s.calibrated_c, ROLLS_180).of_area(s.area), s.bias_kind)
    return NefChip(
        s.die, s.bias_kind, {}, s.calibrated_c, area=s.area, noise=device_noise(s),
        process=ROLLS_180.under(s.law), codes=codes, coded_on=coded_on,
    )  # fmt: skip


@dataclass(slots=True)
class Warmed:
    """A brain on a chip whose temperature follows a course: in every 10 ms it is that at their beginning.

    brain : whose network's codes and decoders stay what they are.
    simulation : of the network.
    course : of the chip's temperature.
    chip : on which the network was placed.
    time : of the run, s, that it has come to.
    """

    brain: Brain
    simulation: Simulation
    course: Course
    chip: NefChip
    time: float = 0.0

    @property
    def state(self) -> str:
        """What the brain is doing."""
        return self.brain.state

    @property
    def verdict(self) -> str:
        """What the brain has found out about the goal."""
        return self.brain.verdict

    def step(self, senses: Senses) -> F64:
        """Steering vector for the next 10 ms, float64[2]."""
        run = self.simulation
        where, wanted = run.built.where, self.course.at(self.time)
        if where is not None and where.temperature_c != wanted:
            with told_when(self.time):
                run.move(moved(run.built, self.chip.at(wanted)))
        self.time += STEP
        return self.brain.step(senses)


def warmed(brain: Brain, scenario: Scenario) -> Brain:
    """Return the brain with its chip along the scenario's course, itself where there is none."""
    course = course_through(scenario.course)
    if course is None or not isinstance(brain, NeuralBrain):
        return brain
    where = brain.simulation.built.where
    return brain if where is None else Warmed(brain, brain.simulation, course, where.chip)


def counted(brain: Brain) -> dict[str, int] | None:
    """Return the counters of a brain's chip, None where there is no chip."""
    if not isinstance(brain, NeuralBrain) or brain.simulation.built.placed is None:
        return None
    return {**brain.simulation.counters, "cut": brain.simulation.built.placed.cut}


def unmended_of(brain: Brain) -> tuple[str, ...]:
    """Return what the calibration of a brain's chip left off, a sentence each."""
    where = brain.simulation.built.where if isinstance(brain, NeuralBrain) else None
    return () if where is None or where.chip.codes is None else where.chip.codes.unmended


def drive(
    robot: Robot, brain: Brain, steps: int, progress: Callable[[float], None] | None = None
) -> tuple[F64, I64]:
    """Let a brain drive a robot for at most so many steps of 10 ms.

    Returns the places, float64[steps + 1, 2], and the numbers of the states, int64[steps].
    """
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


def spike_trains(trace: Trace, progress: Callable[[float], None]) -> tuple[dict[str, F64], float]:
    """Return the spikes of a run's neurons, s by their names, and its end, s; the run is made again."""
    s = trace.scenario
    robot, _, _ = _at_start(s)
    brain = make_brain(s, trace.world)
    if not isinstance(brain, NeuralBrain):
        raise ParameterError("spikes: a program has no neurons; give `brain=chip`")
    brain.simulation.record()
    drive(robot, warmed(brain, s), len(trace.state), progress)
    times, neurons = brain.spikes()
    return trains_of("neuron", brain.simulation.built.network.neurons, times, neurons), trace.time


def no_neurons(scenario: Scenario) -> str:
    """Say what puts neurons into the loop; empty where there are some."""
    return "" if scenario.brain != "reference" else "add `brain=chip`"


def summarise(trace: Trace) -> dict[str, float | None]:
    """Return the numbers of a run by their names; None where a number is not defined.

    Lengths are in map units.
    """
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
    """Say whether a run succeeded, why it ended, and what it ran on.

    A map's unit has no length in m, so that a run has no distance.
    """
    s = trace.scenario
    time = STEP * np.arange(len(trace.path))
    on: dict[str, Any] = {"agent": s.agent, "brain": s.brain}
    if s.brain != "reference":
        on["design"] = s.design
    if s.brain == "chip":
        on |= {
            "area": s.area,
            "silicon_noise": s.silicon_noise,
            **described(s),
            **describe_run(s),
        }
    return Account(
        succeeded=trace.reached or (bool(trace.verdict) and trace.shortest is None),
        reason=trace.reason,
        ran_on=on,
        parts={
            "states and steering": part(s.brain, "NEF chip", _BRAINS),
            "compass, contact and wheels": PROGRAMS,
        },
        cautions=(_DRIFT,) if (s.agent, s.brain, s.design) == ("bug2", "chip", "published") else (),
        standing_share=share_standing(np.column_stack([time, trace.path]), SLOW * FASTEST),
        outside=trace.outside,
    )


def goal_of(trace: Trace) -> Point:
    """Return the place of a run's goal."""
    return pick(trace.world.map.goals, trace.scenario.goal, "goal")


def document(trace: Trace) -> dict[str, Any]:
    """Return the entries that only this system's JSON document has, by their keys.

    Lengths are in map units.
    """
    s = trace.scenario
    network = s.brain != "reference"
    chip = (
        {}
        if trace.chip is None
        else {"solved_C": s.solved, "chip": dict(trace.chip), "unmended": trace.unmended}
    )
    return {
        "design": s.design if network else None,
        "neurons": network_of(s.agent, s.design, s.neurons).neurons if network else None,
        **chip,
        "map": trace.world.map.name,
        "start": trace.path[0],
        "goal": goal_of(trace),
        "reached": trace.reached,
        "ended": trace.reason,
        "time_s": trace.time,
        "step_s": STEP,
        "path": trace.path,
        "state": [STATES[k] for k in trace.state],
        "shortest_path": trace.shortest,
    }


def told(trace: Trace) -> Iterator[str]:
    """Return the lines that stand over the numbers of a run."""
    s = trace.scenario
    if trace.shortest is None:
        yield f"{trace.world.map.name}: no way leads from the start to the goal"
    if trace.chip is not None:
        counts = ", ".join(f"{name.replace('_', ' ')} {k}" for name, k in trace.chip.items())
        yield f"chip on {s.die} at {temperature_text(s.temperature_c, s.course)} degC: {counts}"
    for sentence in trace.unmended:
        yield f"calibrated, but {sentence}"


def draw(trace: Trace, figure: Figure) -> None:
    """Fill an empty figure with a run."""
    s = trace.scenario
    on = silicon_text(s.die, s.temperature_c, s.bias_kind, s.course, s.law)
    chip = f" on {on}" if s.brain == "chip" else ""
    title = f"{s.agent}, {s.brain}{chip}, {trace.world.map.name}\n{account(trace).headline}"
    draw_run(trace.world, trace.path, trace.shortest, title, figure)


def film(trace: Trace, _: tuple[str, ...] | None) -> Film:
    """Return the film of a run: walls, start, goal, the robot's way and what it was doing."""
    path, where = trace.path, trace.world.map
    time = STEP * np.arange(len(path), dtype=np.float64)
    shapes = []
    outer_first = sorted(trace.world.obstacles.geoms, key=lambda one: -Polygon(one.exterior).area)
    for polygon in outer_first:  # what is inside another is drawn on it
        shapes.append(Shape(role="obstacle", points=corners(np.array(polygon.exterior.coords)[:-1])))
        shapes += [Shape(role="floor", points=corners(np.array(h.coords)[:-1])) for h in polygon.interiors]
    shapes += circles("start", np.array(where.starts)) + circles("goal", np.array(where.goals))
    if trace.shortest is not None:
        told = "shortest path of a point"
        shapes.append(Shape(role="way", points=corners(trace.shortest), closed=False, name=told))
    steps = np.diff(path, axis=0)
    heading = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    robot = Track(
        name=trace.scenario.agent, time=time, x=path[:, 0], y=path[:, 1],
        heading=np.append(heading, heading[-1:]) if heading.size else None, radius=0.15,
    )  # fmt: skip
    doing = signal("what it does", "", time[:-1], trace.state.astype(np.float64), "state", STATES)
    stage = Stage(unit="map units", shapes=tuple(shapes), tracks=(robot,))
    return Film(title="", headline="", duration=trace.time, panels=(doing,), world=stage)


def _usual(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the options of a run on silicon: Bug 2 in the design whose memories hold on a chip."""
    agent = given.get("agent", "bug2")
    if agent == "bug1":
        return {}
    on_chip = given.get("brain", "chip") == "chip"
    return {"brain": "chip", **({"design": "improved"} if agent == "bug2" and on_chip else {})}


SYSTEM = System(
    name="bug",
    summary="robot with compass and contact: Bug 0, 1, 2 as programs and neurons (Stöckel 2017)",
    kind=Scenario,
    success=SUCCESS,
    run=run,
    account=account,
    numbers=summarise,
    draw=draw,
    film=film,
    yes_no=(SUCCEEDED, "reached", "unreachable"),
    study_metrics=("reached", "time_s", "path_length", "path_ratio"),
    usual=_usual,
    ideal={"brain": "reference"},
    check_run=check_seed,
    no_silicon=no_silicon,
    open=open_drive,
    outputs={"spikes": spikes_made_again("the spikes of the network's neurons", spike_trains, no_neurons)},
    document=document,
    meanings=of_run(SUMMARY, DOCUMENT),
    title=lambda trace: f"{trace.world.map.name}, {trace.scenario.agent}, {trace.scenario.brain}",
    before=told,
)
