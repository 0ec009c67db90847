"""A car with a narrow sonar drives through a forest of pipes (Wen & Horiuchi 2022, Figures 14 and 15).

pings of a head that turns -> echoes in three envelopes -> ranges and directions -> memory of the risk of each
of 15 arcs -> most desirable arc -> head, wheels. With `exact` ranges the places of the pipes in the field of
view are known; by `flight` they come from echoes; with `chip` the ranging chip of a die times these.

A run of the system is one drive through a forest that the seed draws.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chips.ranging.circuit import NEURONS
from circuits.arrays import F64, I64
from circuits.silicon.course import beginning_of
from system.car.arcs import Arcs, arcs_of
from system.car.drive import COUNTS, REASONS, Drive, Pose, SonarAt, Voyage, drive
from system.car.live import LiveCar
from system.car.localiser import trained
from system.car.numbers import DIRECTIONS, PIPE_RADIUS
from system.car.picture import draw_robot
from system.car.scenario import Scenario, check_pipes, no_silicon
from system.car.sonar import SPEED, Sonar, listened, noise_of
from system.car.world import Pipes, forest_of, number_of, start_of
from system.meaning import meanings, of_run
from system.openspace.flight import WAY_KEYS, entries_of
from system.openspace.moving import along_jitter
from system.openspace.population import (
    check_rate,
    coded,
    jitter_of,
    no_population,
    population_on,
    unsure_delays,
)
from system.openspace.reader import CALIBRATIONS, readings
from system.openspace.reader_noise import no_reader, reader_of
from system.options.block import describe_run
from system.options.codes import described
from system.options.noise import device_noise
from system.options.outside import inside_boxes
from system.plot import entitle, silicon_text, sized_axes
from system.spikes.output import spikes_made_again, trains_of
from system.system import PROGRAMS, SUCCEEDED, Account, Progress, RunTrace, System, part
from system.view.film import NO_YES, Film, Stage, Track, circles, signal
from system.worlds.standing import SLOW, evenly, share_standing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ENDS = ("through", "out", "collided", "undecided")
SUMMARY = meanings("""
through     number  -  1 where it came through the forest, else 0
out         number  -  1 where it left the forest by a side, else 0
collided    number  -  1 where it touched a pipe, else 0
undecided   number  -  1 where all pings were made before an end, else 0
side_share  number  -  share of the pings that did not go straight ahead
time_s      number  s  time of the drive
distance_m  number  m  way driven
pings       number  -  pings that were made, soft ones not among them
soft_pings  number  -  softer pings, that followed where something was near
echoes      number  -  echoes that gave a place
near        number  -  pipes that answered within the blanking after a call
missed      number  -  echoes of which the chip had no reading
occluded    number  -  pipes that others hid
clipped     number  -  directions beyond what the network was trained for
scans       number  -  pings after which only the head turned
retreats    number  -  times that the car went back the way that it came
""")
DOCUMENT = {
    **meanings("""
occlusion              boolean     -     whether a pipe hides those behind it
multipath              boolean     -     whether echoes come by way of two pipes
soft_pings             boolean     -     whether a softer ping follows where something is near
unsure_delays          integer     -     delays in the chip's table that were too near a tie to call
zone_m                 number      m     distance from a pipe at which it counts as touched
steering_deg           number[]    deg   angle of the front wheels on each arc, from the left
curvature_per_m        number[]    1/m   curvature of each arc
ping_direction_of_arc  integer[]   -     number of the direction in which the head looks on each arc
ping_directions_deg    number[]    deg   these directions, from straight ahead to the left
start_m                number[]    m     where it began, east and north
ended                  string      -     why it ended
pipes_m                number[][]  m     places of the pipes, east and north
arc                    integer[]   -     number of the arc that was driven after each ping, from the left
scanning               boolean[]   -     whether only the head turned after it
soft_ping              boolean[]   -     whether a softer ping followed it
"""),
    **WAY_KEYS,
}
SUCCESS = "it comes out at the far end of the forest without having touched a pipe"


@dataclass(frozen=True, slots=True)
class Trace(RunTrace[Scenario]):
    """What a drive leaves.

    unsure : how many delays of the chip's table were too near to call.
    arcs : of the car.
    forest : the pipes.
    drive : the way, and why it ended.
    """

    arcs: Arcs
    forest: Pipes
    drive: Drive
    unsure: int

    @property
    def path(self) -> F64:
        """Places of the body's middle at the pings and at the end, float64[pings + 1, 2], m."""
        return np.concatenate([self.drive.log[:, 1:3], [self.drive.end[:2]]])


@inside_boxes
def run(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
    """Drive once through a forest; forest, start and noise are drawn from the seed.

    Raises `ParameterError` for a start at a pipe.
    """
    s = scenario
    random, forest, start = _drawn(s)
    arcs = arcs_of(s.robot, s.openspace)
    sonar_at, unsure = sonar_of(s, random)
    driven = drive(s.robot, s.openspace, arcs, sonar_at, forest, start, s.pings, progress)
    return Trace(s, arcs, forest, driven, unsure)


def open_drive(scenario: Scenario) -> LiveCar:
    """Return the car of a scenario at its start, which goes on ping by ping; raises as `run` does."""
    s = scenario
    random, forest, start = _drawn(s)
    sonar_at, _ = sonar_of(s, random)
    return LiveCar(
        Voyage(s.robot, s.openspace, arcs_of(s.robot, s.openspace), sonar_at, forest, start), s.pings
    )


def _drawn(scenario: Scenario) -> tuple[np.random.Generator, Pipes, Pose]:
    """What draws a drive's noise, its forest, and its start."""
    random = np.random.default_rng((scenario.seed, number_of(scenario.forest)))
    forest = forest_of(scenario.forest, random)
    return random, forest, start_of(forest, random, scenario.robot.radius, scenario.start)


def spike_trains(trace: Trace, progress: Progress) -> tuple[dict[str, F64], float]:
    """Return the spikes of the ranging chip, s by neuron, and the end of the drive, s; it is driven again."""
    s = trace.scenario
    random, forest, start = _drawn(s)
    kept: list[tuple[F64, I64]] = []
    sonar_at, _ = sonar_of(s, random, kept)
    again = drive(s.robot, s.openspace, trace.arcs, sonar_at, forest, start, s.pings, progress)
    times = np.concatenate([np.empty(0), *(time for time, _ in kept)])
    neurons = np.concatenate([np.empty(0, dtype=np.int64), *(which for _, which in kept)])
    return trains_of("neuron", NEURONS, times, neurons), again.time


def no_spikes(scenario: Scenario) -> str:
    """Say what makes a scenario's ranging chip spike one by one; empty where it does."""
    if not scenario.silicon:
        return no_silicon(scenario)
    if scenario.ranging_codes is not None:
        return ""
    return "" if scenario.silicon_noise != "off" else "give `silicon_noise=white`, or all"


def sonar_of(
    scenario: Scenario, random: np.random.Generator, spikes: list[tuple[F64, I64]] | None = None
) -> tuple[SonarAt | None, int]:
    """Return the sonar of a scenario in a ping at a time, s, and how many delays of its chip are unsure.

    These are counted at the beginning. There is no sonar, but None, with exact ranges. spikes: where those of
    the chip are kept.
    """
    s = scenario
    if s.ranges == "exact":
        return None, 0
    noise = noise_of(s.robot, random)
    still = Sonar(
        s.robot, trained(s.robot), noise, np.empty(0), reader=no_reader(), population=no_population(),
        spikes=spikes, **s.senses,
    )  # fmt: skip
    if not s.silicon:
        return lambda _: still, 0
    codes = s.ranging_codes
    noisy = device_noise(s)
    if codes is not None:  # a soft ping's echoes too, for which a cycle is longer by a blanking
        check_rate("ping_rate", s.robot.ping_rate, listened(s.robot))
    begun_c = beginning_of(s.temperature_c, s.course) if s.course else None

    def made(celsius: float) -> tuple[Sonar, int]:
        silicon = s.silicon_at(celsius)
        if codes is None:
            delays, unsure = readings(silicon, CALIBRATIONS[0], 1.0, s.bias_kind)
            reader = reader_of(silicon, CALIBRATIONS[0], noisy, bias_kind=s.bias_kind, begun_c=begun_c)
            return replace(still, reading=0.5 * SPEED * delays, reader=reader), unsure
        chip = coded(silicon, codes, s.bias_kind)
        return replace(still, population=population_on(chip, noisy, begun_c)), unsure_delays(chip)

    at = along_jitter(
        s.course, s.temperature_c, made, lambda found: jitter_of(found[0].population, found[0].reader)
    )
    return lambda time: at(time)[0], at(0.0)[1]


def side_share(drive: Drive) -> float:
    """Share of the pings that did not go straight ahead."""
    return float((drive.log[:, 4] != DIRECTIONS // 2).mean())


def summarise(trace: Trace) -> dict[str, float | None]:
    """Return the numbers of a drive by their names; of its ends one is 1 and the others are 0."""
    d = trace.drive
    return {
        **{name: float(d.ended == name) for name in ENDS},
        "side_share": side_share(d),
        "time_s": d.time,
        "distance_m": d.distance,
        **{name: float(d.counts[name]) for name in COUNTS},
    }


def account(trace: Trace) -> Account:
    """Say whether a run succeeded, why it ended, and what it ran on.

    An emergency is a retreat the way that the car came.
    """
    s, d = trace.scenario, trace.drive
    on: dict[str, Any] = {"ranges": s.ranges, **s.senses}
    if s.silicon:
        on |= {
            **described(s),
            "silicon_noise": s.silicon_noise,
            **describe_run(s),
        }
    path = evenly(np.append(d.log[:, 0], d.time), trace.path, 1.0 / s.robot.ping_rate)
    return Account(
        succeeded=d.ended == "through",
        reason=REASONS.get(d.ended, f"all {d.counts['pings']} pings made"),
        ran_on=on,
        parts={
            "ranges": part(
                s.ranges, "ranging chip", {"flight": "program that times echoes", "exact": "exact places"}
            ),
            "bearings, choice of an arc and wheels": PROGRAMS,
        },
        distance_m=d.distance,
        emergency_share=d.counts["retreats"] / d.counts["pings"],
        standing_share=share_standing(path, SLOW * s.robot.max_speed),
        outside=trace.outside,
    )


def document(trace: Trace) -> dict[str, Any]:
    """Return the entries that only this system's JSON document has, by their keys."""
    s, log = trace.scenario, trace.drive.log
    chip = {"unsure_delays": trace.unsure} if s.silicon else {}
    return {
        **s.senses,
        **chip,
        "zone_m": s.robot.zone,
        "steering_deg": np.degrees(trace.arcs.steering),
        "curvature_per_m": trace.arcs.curvature,
        "ping_direction_of_arc": trace.arcs.group,
        "ping_directions_deg": np.degrees(trace.arcs.direction),
        "start_m": trace.path[0],
        "ended": account(trace).reason,
        "pipes_m": trace.forest.place,
        **entries_of(log, trace.path),
        "arc": log[:, 5].astype(int),
        "scanning": log[:, 6].astype(bool),
        "soft_ping": log[:, 7].astype(bool),
    }


def told(trace: Trace) -> Iterator[str]:
    """Return the lines that stand under the numbers of a drive."""
    s, path = trace.scenario, trace.path
    where = [f"{x:.2f},{y:.2f} m" for x, y in (path[0], path[-1])]
    yield f"from {where[0]} to {where[1]}"
    if s.silicon:
        yield "the chip gives ranges only: directions are those of the three envelopes"
    if trace.drive.ended == "undecided":
        yield "`pings=N` drives on"


def draw(trace: Trace, figure: Figure) -> None:
    """Fill an empty figure with a drive, as in Figure 15."""
    s, d, said = trace.scenario, trace.drive, account(trace)
    die = f", {silicon_text(s.die, s.temperature_c, s.bias_kind, s.course, s.law)}" if s.silicon else ""
    title = (
        f"{trace.forest.name}, ranges {s.ranges}{die}, {d.time:.1f} s:"
        f" {100.0 * side_share(d):.0f} % of {len(d.log)} pings to the side\n{said.headline}"
    )
    ax = sized_axes(figure, 8.0, 6.1)
    draw_robot(trace.forest, trace.arcs, trace.path, d.log, s.robot.zone, ax, succeeded=said.succeeded)
    entitle(title, ax)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8)


def film(trace: Trace, _: tuple[str, ...] | None) -> Film:
    """Return the film of a drive: pipes, the car's way, and what it decided at each ping."""
    d, s = trace.drive, trace.scenario
    log, path, pipes = d.log, trace.path, trace.forest.place
    shapes = circles("shade", pipes, s.robot.zone, "zone of collision")
    shapes += circles("obstacle", pipes, PIPE_RADIUS, "pipe")
    car = Track(
        name="car", time=np.append(log[:, 0], d.time), x=path[:, 0], y=path[:, 1],
        heading=np.unwrap(np.append(log[:, 3], d.end[2])), radius=s.robot.radius,
    )  # fmt: skip
    angle = np.degrees(trace.arcs.direction[log[:, 4].astype(np.int64)])
    decided = (
        signal("direction of the ping, left above", "deg", log[:, 0], angle, "ping"),
        signal("chosen arc", "", log[:, 0], log[:, 5], "arc"),
        signal("scans", "", log[:, 0], log[:, 6], words=NO_YES),
        signal("soft ping", "", log[:, 0], log[:, 7], words=NO_YES),
    )
    stage = Stage(unit="m", shapes=tuple(shapes), tracks=(car,))
    return Film(title="", headline="", duration=d.time, world=stage, panels=decided)


SYSTEM = System(
    name="car",
    summary="car with a narrow sonar among pipes, by a choice of 15 arcs (Wen & Horiuchi 2022)",
    kind=Scenario,
    success=SUCCESS,
    run=run,
    account=account,
    numbers=summarise,
    draw=draw,
    film=film,
    yes_no=(SUCCEEDED, *ENDS),
    study_metrics=("collided", "through", "side_share"),
    usual=lambda _: {"ranges": "chip"},
    ideal={"ranges": "flight"},
    check_study=check_pipes,
    no_silicon=no_silicon,
    outputs={"spikes": spikes_made_again("the spikes of the ranging chip", spike_trains, no_spikes)},
    open=open_drive,
    document=document,
    meanings=of_run(SUMMARY, DOCUMENT),
    title=lambda trace: f"{trace.scenario.forest}, ranges {trace.scenario.ranges}",
    after=told,
)
