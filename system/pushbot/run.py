"""Pushbot: a robot with a dynamic vision sensor, steered by a network on the ROLLS chip (Milde et al. 2017).

scene -> sensor -> link, which drops most events -> obstacle populations and target field of a chip ->
drives and speed -> commands by equations (1) and (2) -> robot. Sensor and chip are of the same die's number.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from chips.rolls import circuit as rolls_circuit
from chips.rolls.chip import TEMPERATURE_STEP
from chips.rolls.program.address import NEURONS
from circuits.silicon.course import beginning_of, course_through
from system.meaning import meanings, of_run
from system.options.block import describe_run
from system.options.codes import described
from system.options.noise import device_noise
from system.options.on_silicon import IDEAL_CHIP
from system.options.outside import inside_boxes
from system.options.rolls.power import TABLE, power_numbers
from system.pushbot.body import SPEED_OF_FACTOR, Factors, Pushbot
from system.pushbot.brain import brain_of
from system.pushbot.course import NEAR, RESTS, Course, Errand, course_of, passage, stood
from system.pushbot.drive import Run, begin_run
from system.pushbot.live import LivePushbot
from system.pushbot.loop import Brain, Loop, Record, all_events, all_spikes, open_loop, rates, step
from system.pushbot.picture import draw_run, film_of
from system.pushbot.readout import LOOK, Readout
from system.pushbot.scenario import Scenario, check_scene, scene_of
from system.spikes.output import spikes_output, trains_of
from system.system import PROGRAMS, SUCCEEDED, Account, Output, RunTrace, System
from system.view.film import Film
from system.worlds.arena.scene import Scene
from system.worlds.camera.file import check_events, write_events

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FREE_RUN = 20.0  # s, of a run in a scene without an obstacle line; ours
MARGIN = 12.0  # s, that a run may take beyond twice the straight way to the line; ours
SUMMARY = meanings(
    """
collided            number   -    1 where it touched something, else 0
crossed             number   -    1 where it crossed the line of obstacles, else 0
between             number   -    1 where obstacles were then on both sides, else 0
distance_cm         number?  cm   distance from the nearest obstacle at the line; 0 after a collision, null
                                  where the line was not crossed
closest_cm          number?  cm   least distance from an obstacle on the whole way
passed              number?  -    side on which the obstacles' middle was passed: 1 left, -1 right
time_s              number   s    time of the run
path_m              number   m    way driven
mean_speed_m_per_s  number   m/s  the way over the time
rate_OL_Hz          number   Hz   mean rate of a neuron that sees obstacles on the left
rate_OR_Hz          number   Hz   the same on the right
rate_DL_Hz          number   Hz   mean rate of a neuron that turns to the left
rate_DR_Hz          number   Hz   the same to the right
rate_sp_Hz          number   Hz   mean rate of a neuron that sets the speed
events              number   -    events of the sensor that arrived
lost_events         number   -    events that the link from the sensor lost
lost_inputs         number   -    events that the chip's input bus lost
lost_spikes         number   -    spikes that the chip's output bus lost
held                number   -    filters times steps in which a filter stayed at the end of its table
raised_s            number   s    time with raised lateral weights
frame_spikes        number   -    spikes of the second chip, which turns the target's frame
"""
    + TABLE
)
DOCUMENT = meanings("""
scene            string       -   name of the scene
turn_factor      number       -   factor of equation (1)
window_s         number       s   time in which spikes are counted
readout          string       -   how they are counted: `fixed`, `sliding` or `spikes`
target_field     boolean      -   whether the chip has a field of neurons for targets
bias_codes       integer[]{}  -   coarse and fine code of each bias, by its name
neurons          integer{}    -   neurons of each population, by its name
cautions         string[]     -   what the chip warns of
touched          string?      -   what the robot touched
path             number[][]   -   time (s), place (m, m) and heading (rad) in each step
commands         number[][]   -   time (s), speed (m/s) and turn (rad/s) of each command
rate_time_s      number[]     s   times of the rates
rates_Hz         number[]{}   Hz  mean rate of a neuron of each population, by its name
obstacle_line_m  number?      m   distance from the start to the line of obstacles; null where there is none
summary.ran_on.frame          boolean  -  whether a second chip turned the target's frame
summary.ran_on.raise_lateral  boolean  -  whether lateral weights were raised while the target was lost
""")
SUCCESS = (
    "it touches nothing, and gets past the line of its scene's obstacles; in a scene with another robot"
    f" it comes within {100.0 * NEAR:g} cm of that, in all others it stands for {100.0 * RESTS:g} % of"
    " its time at most"
)


@dataclass(frozen=True, slots=True, eq=False)
class Trace(RunTrace[Scenario]):
    """What a run leaves: world and robot at its end, what the chip did, and why it ended.

    Attributes
    ----------
    errand : Errand
        What it was there for, with its world in its light and colour.
    brain : Brain
        The chip with its network.
    drive : Run
        Robot and sensor at the end of the run, and its path.
    record : Record
        Spikes, events and commands.
    """

    errand: Errand
    brain: Brain
    drive: Run
    record: Record

    @property
    def scene(self) -> Scene:
        """The world."""
        return self.errand.scene

    @property
    def course(self) -> Course | None:
        """The line of obstacles, None where the scene has none."""
        return self.errand.course

    @property
    def reason(self) -> str:
        """Why the run ended, as a reader is told."""
        return self.errand.why(self.drive)


@inside_boxes
def run(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
    """Drive until the robot touches something, has passed the obstacles, or time or way are over.

    Raises `ParameterError` for a speed or turn factor that is not above 0, a network that the chip has no
    room for, and what the scene refuses; `UnknownNameError` for an unknown scene.

    Parameters
    ----------
    scenario
        What is driven.
    progress
        Function that is told the share that is done.
    """
    readout, scene = scenario.read(), scene_of(scenario)
    return run_with(make_brain(scenario), scenario, scene, readout, progress)


def make_brain(scenario: Scenario) -> Brain:
    """Return the chip that a scenario asks for."""
    begin = beginning_of(scenario.temperature_c, scenario.course, TEMPERATURE_STEP)
    architecture = scenario.architecture()
    return brain_of(
        architecture, scenario.silicon_at(begin, scenario.made_in), scenario.bias_kind,
        codes=scenario.codes_of(architecture.calibration, scenario.made_in, setup=architecture.layout),
        noise=device_noise(scenario),
    )  # fmt: skip


def run_with(
    brain: Brain, scenario: Scenario, scene: Scene, readout: Readout,
    progress: Callable[[float], None] | None = None,
) -> Trace:  # fmt: skip
    """Drive with a chip that has been made before."""
    robot = Pushbot(dropped=scenario.dropped)
    drive = begin_run(scene, seed=scenario.seed, die=scenario.die, robot=robot)
    errand = errand_of(scenario, scene, readout, robot)
    followed = course_through(scenario.course, TEMPERATURE_STEP)
    loop = open_loop(brain, drive, readout, None if followed is None else followed.at)
    while not errand.why(drive):
        step(loop)
        if progress is not None:
            progress(min(max(drive.time / errand.duration, drive.way / errand.way), 1.0))
    return Trace(scenario, errand, brain, drive, loop.record)


def errand_of(scenario: Scenario, scene: Scene, readout: Readout, robot: Pushbot) -> Errand:
    """Return what a scenario's run is there for, and when it ends."""
    course = course_of(scene)
    duration = scenario.duration if scenario.duration is not None else scene.duration
    if duration is None:
        duration = _time_for(course, readout.factors, robot)
    return Errand(scene, course, duration, math.inf if scenario.way is None else scenario.way)


def open_drive(scenario: Scenario) -> LivePushbot:
    """Return the robot of a scenario at its start, which goes on look by look; raises as `run` does.

    The chip is made, and calibrated, where its commands are first asked for.
    """
    readout, scene = scenario.read(), scene_of(scenario)
    robot = Pushbot(dropped=scenario.dropped)
    drive = begin_run(scene, seed=scenario.seed, die=scenario.die, robot=robot)
    return LivePushbot(
        drive, errand_of(scenario, scene, readout, robot), lambda: _loop(scenario, drive), readout
    )


def _loop(scenario: Scenario, drive: Run) -> Loop:
    """The chip of a scenario in its loop with a robot."""
    followed = course_through(scenario.course, TEMPERATURE_STEP)
    temperature = None if followed is None else followed.at
    return open_loop(make_brain(scenario), drive, scenario.read(), temperature)


def _time_for(course: Course | None, factors: Factors, robot: Pushbot) -> float:
    if course is None:
        return FREE_RUN
    speed = min(SPEED_OF_FACTOR * factors.speed, robot.top_speed)
    return math.ceil(2.0 * course.distance / speed + MARGIN)


def summarise(trace: Trace) -> dict[str, float | None]:
    """Return the numbers of a run by their names; None where a number is not defined.

    `distance_cm` is that at the line of obstacles: 0 after a collision, None where it was not crossed.
    """
    path = np.array(trace.drive.path)
    time = float(path[-1, 0])
    collided = trace.drive.touched is not None
    found = None if trace.course is None else passage(trace.course, trace.drive.obstacles, path)
    distance = None if found is None else found.distance
    _, mean = rates(trace.brain.network, trace.record, max(time, 0.05))
    _, neurons = all_spikes(trace.record)
    return {
        "collided": float(collided),
        "crossed": float(found is not None and found.crossed),
        "between": float(found is not None and found.between),
        "distance_cm": 0.0 if collided and found is not None else _cm(distance),
        "closest_cm": None if found is None else _cm(found.closest),
        "passed": None if found is None or found.side is None else float(found.side),
        "time_s": time,
        "path_m": trace.drive.way,
        "mean_speed_m_per_s": trace.drive.way / max(time, 1e-9),
        **{f"rate_{name}_Hz": float(mean[name].mean()) for name in ("OL", "OR", "DL", "DR", "sp")},
        "events": float(sum(len(e) for e in trace.record.events)),
        "lost_events": float(trace.drive.lost),
        "lost_inputs": float(trace.record.lost_in),
        "lost_spikes": float(trace.record.lost_out),
        "held": float(trace.record.held),
        "raised_s": trace.record.raised,
        "frame_spikes": float(trace.record.frame_spikes),
        **power_numbers(trace.brain.chip, neurons, {1: trace.record.inputs}, max(time, 0.05)),
    }


def account(trace: Trace) -> Account:
    """Say whether a run succeeded, why it ended, and what it ran on."""
    s, drive = trace.scenario, trace.drive
    standing = stood(np.array(drive.path))
    return Account(
        succeeded=trace.errand.reached(drive),
        reason=trace.reason,
        ran_on={
            "modified": s.modified,
            "readout": s.readout,
            "process": s.process,
            **described(s),
            "frame": s.frame,
            "raise_lateral": s.raise_lateral,
            "silicon_noise": s.silicon_noise,
            **describe_run(s),
        },
        parts={
            "network": "ROLLS chip",
            "camera, counting of spikes and wheels": PROGRAMS,
        },
        distance_m=drive.way,
        standing_share=standing,
        cautions=trace.brain.chip.cautions(),
        outside=trace.outside,
    )


def _cm(metres: float | None) -> float | None:
    return None if metres is None or not math.isfinite(metres) else 100.0 * metres


def document(trace: Trace) -> dict[str, Any]:
    """Return the entries that only this system's JSON document has, by their keys."""
    s, path = trace.scenario, np.array(trace.drive.path)
    time, found = rates(trace.brain.network, trace.record, max(float(path[-1, 0]), LOOK))
    readout, chip = s.read(), trace.brain.chip
    return {
        "scene": trace.scene.name,
        "turn_factor": readout.factors.turn,
        "window_s": readout.window,
        "readout": readout.kind,
        "target_field": trace.brain.target,
        "bias_codes": dict(sorted(chip.program.biases.codes().items())),  # coarse and fine
        "neurons": {p.name: len(p) for p in trace.brain.network.populations},
        "cautions": chip.cautions(),
        "touched": trace.drive.touched,
        "path": path,  # s, m, m, rad
        "commands": np.array(trace.record.commands).reshape(-1, 3),  # s, v, w
        "rate_time_s": time,
        "rates_Hz": found,
        "obstacle_line_m": None if trace.course is None else trace.course.distance,
    }


def title(trace: Trace) -> str:
    """Return the heading of the table of a run's numbers."""
    s = trace.scenario
    factors = f"speed factor {s.speed_factor:g}, turn factor {s.read().factors.turn:g}"
    return f"{trace.scene.name}, {factors}, {s.die}"


def draw(trace: Trace, figure: Figure) -> None:
    """Fill an empty figure with a run."""
    said, course = account(trace).headline, trace.scenario.course
    draw_run(trace.scene, trace.drive, trace.brain, trace.record, said, figure, course)


def film(trace: Trace, asked: tuple[str, ...] | None) -> Film:
    """Return the film of a run, with what is inside the neurons that are asked for."""
    return film_of(trace.scene, trace.drive, trace.brain, trace.record, asked)


SYSTEM = System(
    name="pushbot",
    summary="robot with an event camera, steered by the ROLLS chip (Milde et al. 2017)",
    kind=Scenario,
    success=SUCCESS,
    run=run,
    account=account,
    numbers=summarise,
    draw=draw,
    film=film,
    yes_no=(SUCCEEDED, "collided", "crossed", "between"),
    ideal=IDEAL_CHIP,
    study_metrics=("collided", "distance_cm"),
    open=open_drive,
    check_study=check_scene,
    document=document,
    meanings=of_run(SUMMARY, DOCUMENT),
    title=title,
    outputs={
        "events": Output(
            help="Write events that arrived, at their times there, into a .aedat4, .npz or .txt.",
            check=check_events,
            write=lambda path, trace, _: write_events(path, all_events(trace.record)),
        ),
        "spikes": spikes_output(
            "the spikes that left the chip's bus",
            lambda trace: (trains_of("neuron", NEURONS, *all_spikes(trace.record)), trace.drive.time),
        ),
    },
    circuits=lambda: (rolls_circuit.row(),),
)
