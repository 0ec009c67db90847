"""Robot: a car with a narrow sonar drives through a forest of pipes (Wen & Horiuchi 2022, Figures 14 and 15).

pings of a head that turns -> echoes in three envelopes -> ranges and directions -> memory of the risk of each
of 15 arcs -> most desirable arc -> head, wheels. With `exact` ranges the places of the pipes in the field of
view are known; by `flight` they come from echoes; with `chip` the ranging chip of a die times these.

A run of the system is one drive through a forest that the seed draws.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from circuits.circuit import BiasKind, Circuit
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.silicon import Silicon
from system.car.arcs import Arcs, arcs_of
from system.car.drive import COUNTS, Drive, drive
from system.car.localiser import trained
from system.car.numbers import DIRECTIONS, OpenspaceNumbers, Robot
from system.car.picture import draw_robot
from system.car.sonar import SPEED, Sonar, noise_of
from system.car.world import (
    FORESTS,
    Pipes,
    check_forest,
    forest_of,
    is_file,
    number_of,
    read_pipes,
    start_of,
)
from system.openspace.reader import CALIBRATIONS, Calibration, readings
from system.openspace.reader_noise import no_reader, reader_of
from system.options.block import AS_BUILT, describe_run
from system.options.noise import Noisy, check_noise, silicon_noise
from system.reader import In, Readers, place, read_route, read_texts, switch, whole, words
from system.scenario import scenario_of
from system.system import SUCCEEDED, Account, Summary, metrics_with, summary_of
from system.worlds.standing import SLOW, evenly, share_standing

RANGES = ("flight", "exact", "chip")
PINGS = 1500  # of a run, three times those of a drive without detours; ours
ROOM_TEMPERATURE = 27.0
PARTS = {"robot": ("vmax", "ping_rate")}  # options of this field
ENDS = ("through", "out", "collided", "undecided")
SUMMARY = (*ENDS, "side_share", "time_s", "distance_m", *COUNTS)
QUANTITIES: Readers = {"vmax": In("m/s"), "ping_rate": In("Hz")}
SUCCESS = "it comes out at the far end of the forest without having touched a pipe"
STUDIED: Readers = {
    **QUANTITIES, "forest": words, "ranges": words, "pings": whole,
    "occlusion": switch, "multipath": switch, "soft_pings": switch, "reader": words,
    "silicon_noise": words, "noise_seed": whole,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Scenario:
    """What a robot is asked to do.

    forest: one of `FORESTS`, or a file; start: x, y in m, drawn unless given; pings: after which a run ends;
    occlusion, multipath, soft_pings: None where there is no sonar to have them; silicon_noise: of the chip's
    devices, by `noise_seed`, `seed` unless given.
    """

    robot: Robot = field(default_factory=Robot)
    mind: OpenspaceNumbers = field(default_factory=OpenspaceNumbers)
    forest: str = FORESTS[0]
    ranges: str = RANGES[0]
    occlusion: bool | None = None
    multipath: bool | None = None
    soft_pings: bool | None = None
    reader: Calibration | None = None
    bias_kind: BiasKind | None = None
    silicon_noise: Noisy = "off"
    noise_seed: int | None = None
    start: tuple[float, float] | None = None
    pings: int = PINGS
    seed: int = 0
    die: Die = NOMINAL
    temperature_c: float = ROOM_TEMPERATURE

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the option that breaks its rule."""
        check_forest(self.forest)
        if self.ranges not in RANGES:
            raise ParameterError(f"--ranges: {self.ranges}, must be {', '.join(RANGES[:-1])} or {RANGES[-1]}")
        if self.reader is not None and self.reader not in CALIBRATIONS:
            raise ParameterError(f"--reader: {self.reader}, must be {' or '.join(CALIBRATIONS)}")
        check_noise(self.silicon_noise, self.noise_seed)
        if self.seed < 0:
            raise ParameterError(f"--seed: {self.seed}, must be >= 0")
        if self.pings < 1:
            raise ParameterError(f"--pings: {self.pings}, must be at least 1")
        self._check_use()

    def _check_use(self) -> None:
        """Refuse options of a sonar or of silicon that are not there."""
        for name in ("occlusion", "multipath", "soft_pings"):
            if getattr(self, name) and self.ranges == "exact":
                shown = name.replace("_", "-")
                raise ParameterError(f"--{shown}: not with --ranges exact; give --ranges flight or chip")
        if self.silicon:
            return
        asked = {
            "reader": self.reader is not None,
            "bias-kind": self.bias_kind is not None,
            "silicon-noise": self.silicon_noise != "off",
            "temperature": self.temperature_c != ROOM_TEMPERATURE,
            "die": self.die != NOMINAL,
        }
        for name, given in asked.items():
            if given:
                raise ParameterError(f"--{name}: no chip is in the loop; give --ranges chip, or leave it out")

    @property
    def silicon(self) -> bool:
        """Whether a chip is in the loop."""
        return self.ranges == "chip"

    @property
    def senses(self) -> dict[str, bool]:
        """Options of the sonar as they are in force: all of them on with a sonar, unless given."""
        names = ("occlusion", "multipath", "soft_pings")
        if self.ranges == "exact":
            return dict.fromkeys(names, False)
        return {name: getattr(self, name) is not False for name in names}


@dataclass(frozen=True, slots=True)
class Trace:
    """A drive; `unsure` delays of the chip's table were too near to call."""

    scenario: Scenario
    arcs: Arcs
    forest: Pipes
    drive: Drive
    unsure: int

    @property
    def path(self) -> F64:
        """Places of the body's middle at the pings and at the end, float64[pings + 1, 2], m."""
        return np.concatenate([self.drive.log[:, 1:3], [self.drive.end[:2]]])


def run(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
    """Drive once; raises `ParameterError` for a start at a pipe. Forest, start and noise are the seed's."""
    s = scenario
    random = np.random.default_rng((s.seed, number_of(s.forest)))
    forest = forest_of(s.forest, random)
    start = start_of(forest, random, s.robot.radius, s.start)
    arcs = arcs_of(s.robot, s.mind)
    sonar, unsure = sonar_of(s, random)
    driven = drive(s.robot, s.mind, arcs, sonar, forest, start, s.pings, progress)
    return Trace(s, arcs, forest, driven, unsure)


def sonar_of(scenario: Scenario, random: np.random.Generator) -> tuple[Sonar | None, int]:
    """The sonar of a scenario, None with exact ranges; and how many delays of its chip are unsure."""
    s = scenario
    if s.ranges == "exact":
        return None, 0
    reading, unsure, reader = np.empty(0), 0, no_reader()
    if s.silicon:
        silicon, values = Silicon(temperature_c=s.temperature_c, die=s.die), s.reader or CALIBRATIONS[0]
        delays, unsure = readings(silicon, values, 1.0, s.bias_kind)
        reading = 0.5 * SPEED * delays
        noisy = silicon_noise(s.silicon_noise, s.seed if s.noise_seed is None else s.noise_seed)
        reader = reader_of(silicon, values, noisy, bias_kind=s.bias_kind)
    noise = noise_of(s.robot, random)
    return Sonar(s.robot, trained(s.robot), noise, reading, **s.senses, reader=reader), unsure


def read_options(options: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of a scenario from those of the command line: start is `X,Y`, speed and rate are the robot's."""
    fields = read_texts(options, {**QUANTITIES, "start": place})
    numbers = {}
    for option, name, unit in (("vmax", "max_speed", "m/s"), ("ping_rate", "ping_rate", "Hz")):
        if option in fields:
            value = float(fields.pop(option))
            if not 0.0 < value < math.inf:
                shown = option.replace("_", "-")
                raise ParameterError(f"--{shown}: {value:g} {unit}, must be above 0 and finite")
            numbers[name] = value
    return {**fields, "robot": Robot(**numbers)}


def side_share(drive: Drive) -> float:
    """Share of the pings that did not go straight ahead."""
    return float((drive.log[:, 4] != DIRECTIONS // 2).mean())


def summarise(trace: Trace) -> dict[str, float | None]:
    """Scalars of a drive: one of its ends is 1, the others 0."""
    d = trace.drive
    return {
        **{name: float(d.ended == name) for name in ENDS},
        "side_share": side_share(d),
        "time_s": d.time,
        "distance_m": d.distance,
        **{name: float(d.counts[name]) for name in COUNTS},
    }


_REASONS = {
    "through": "came through the forest",
    "out": "left the forest by a side",
    "collided": "collided with a pipe",
}


def account(trace: Trace) -> Account:
    """What a drive says of itself; an emergency is a retreat the way that it came."""
    s, d = trace.scenario, trace.drive
    on: dict[str, Any] = {"ranges": s.ranges, **s.senses}
    if s.silicon:
        on |= {
            "reader": s.reader or CALIBRATIONS[0],
            "silicon_noise": s.silicon_noise,
            **describe_run(s.die, s.temperature_c, s.bias_kind or AS_BUILT),
        }
    path = evenly(np.append(d.log[:, 0], d.time), trace.path, 1.0 / s.robot.ping_rate)
    return Account(
        succeeded=d.ended == "through",
        reason=_REASONS.get(d.ended, f"all {d.counts['pings']} pings made"),
        ran_on=on,
        distance_m=d.distance,
        emergency_share=d.counts["retreats"] / d.counts["pings"],
        standing_share=share_standing(path, SLOW * s.robot.max_speed),
    )


@dataclass(frozen=True, slots=True)
class RobotSystem:
    """The system as the command line sees it."""

    name: str = "robot"
    summary: str = "car with a narrow sonar that drives through a forest of pipes by a choice of 15 arcs"
    success: str = SUCCESS
    metrics: tuple[str, ...] = metrics_with(SUMMARY)
    yes_no: tuple[str, ...] = (SUCCEEDED, *ENDS)
    study_metrics: tuple[str, ...] = ("collided", "through", "side_share")  # unless others are asked for

    def scenario(self, **options: Any) -> Scenario:
        """A scenario of these fields, or of options as the command line has them."""
        return scenario_of(self.name, Scenario, options, read_options, PARTS)

    def study_options(
        self, level: str, bias_kind: BiasKind | None, route: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Fields of a study's scenario: a die's ranging chip times the echoes unless told otherwise."""
        if level != "behavioural":
            raise ParameterError("--level: the robot's chip is a behavioural model; leave it out")
        given = {"ranges": "chip", **read_route(self.name, route, STUDIED)}
        if is_file(given.get("forest", FORESTS[0])):
            read_pipes(given["forest"])  # what is wrong with it is said before the study
        return given if bias_kind is None else {**given, "bias_kind": bias_kind}

    def circuits(self) -> tuple[Circuit, ...]:
        """What its chip is made of: nothing that deviates in every one of its runs."""
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
        """Fill a figure with a run, as in Figure 15."""
        s, d, said = trace.scenario, trace.drive, account(trace)
        die = f", {s.die}, {s.temperature_c:g} degC" if s.silicon else ""
        title = (
            f"{trace.forest.name}, ranges {s.ranges}{die}, {d.time:.1f} s:"
            f" {100.0 * side_share(d):.0f} % of {len(d.log)} pings to the side\n{said.headline}"
        )
        figure.set_size_inches(8.0, 5.9)
        ax = figure.subplots()
        draw_robot(trace.forest, trace.arcs, trace.path, d.log, s.robot.zone, ax, succeeded=said.succeeded)
        ax.set_title(title, fontsize=9)
        figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=7, fontsize=8)


SYSTEM = RobotSystem()
