"""Forest: a bat flies left through a dense forest by narrow pings (Wen & Horiuchi 2022, analog model).

pings -> ranges and bearings of obstacles in the field of view -> memory of the risk of each arc -> most
desirable arc -> head and body. Ranges and bearings are exact, as in the paper, or those of a sonar or of a
ranging chip, and the selection is ideal or a chip's (`system.openspace.senses`). With chips a die is silicon,
and the number of a sample; without, no more than that number.

A run of the system is one sample: flights until a collision, or a number of pings.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from circuits.circuit import BiasKind, Circuit
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from system.forest.weights import WEIGHTS, weighted
from system.openspace.flight import SUCCESS, Planter, Run, Sample, ended_because, fly_sample, gets_on, planter
from system.openspace.law import Bat, arcs_of
from system.openspace.map import OBSTACLES, SIDE, Forest, check_count, read_forest
from system.openspace.picture import draw_view_of_run
from system.openspace.senses import IDEAL, Sensing, senses_of, with_area
from system.options.block import AS_BUILT, describe_run
from system.reader import In, Readers, number, place, read_route, read_texts, whole, words
from system.scenario import scenario_of
from system.system import SUCCEEDED, Account, Summary, metrics_with, summary_of

SUMMARY = (
    "avoided", "collided", "pings", "time_s", "distance_m", "laps", "runs", "trapped", "emergencies", "scans",
    "heard", "missed", "masked", "occluded", "ghosts", "late", "ties", "other_choices", "deciding_s",
    "progress_m",
)  # fmt: skip
PINGS = 20_000  # of a sample: more make a picture of one colour; ours
STUDY_PINGS = 1_250_000  # of a sample of a study: 200 of them are the limit of a configuration, 2.5e8
CHIP_STUDY_PINGS = 125_000  # with chips, whose limit is 2.5e7
ROOM_TEMPERATURE = 27.0
SENSES = (
    "ranges", "selection", "occlusion", "multipath", "azimuth_noise", "reader", "bias_kind", "silicon_noise",
    "noise_seed",
)  # fmt: skip
PARTS = {"bat": ("vmax", "ping_rate", "weights"), "sensing": (*SENSES, "area")}  # options of these fields

QUANTITIES: Readers = {"vmax": In("m/s"), "ping_rate": In("Hz"), "area": number, "azimuth_noise": In("deg")}
STUDIED: Readers = {
    "map": words, "obstacles": whole, "vmax": In("m/s"), "ping_rate": In("Hz"), "ranges": words,
    "selection": words, "reader": words, "area": number, "weights": words, "pings": whole,
    "silicon_noise": words, "noise_seed": whole,
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Scenario:
    """What a bat is asked to do.

    map: file of obstacles, None to plant `obstacles` from the seed; start: x, y in m, drawn unless given;
    pings: after which a sample ends undecided; rows: pings of the first run whose path is kept.
    """

    bat: Bat = field(default_factory=Bat)
    sensing: Sensing = IDEAL
    map: str | None = None
    obstacles: int = OBSTACLES
    start: tuple[float, float] | None = None
    pings: int = PINGS
    rows: int = PINGS
    seed: int = 0
    die: Die = NOMINAL
    temperature_c: float = ROOM_TEMPERATURE

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise ParameterError(f"--seed: {self.seed}, must be >= 0")
        if self.pings < 1:
            raise ParameterError(f"--pings: {self.pings}, must be at least 1")
        way = self.bat.max_speed / self.bat.ping_rate
        if way > self.bat.max_range:
            raise ParameterError(
                f"--vmax: {self.bat.max_speed:g} m/s at {self.bat.ping_rate:g} Hz is {way:.3g} m between"
                f" pings, must be at most the {self.bat.max_range:g} m that a ping shows; fly slower"
            )
        if self.temperature_c != ROOM_TEMPERATURE and not self.sensing.silicon:
            raise ParameterError(
                f"--temperature: {self.temperature_c:g} degC, must be {ROOM_TEMPERATURE:g}: no chip is in the"
                " loop; give --ranges chip or --selection chip, or leave it out"
            )
        if self.map is None:
            check_count(self.obstacles)


@dataclass(frozen=True, slots=True)
class Trace:
    """A sample and its first run."""

    scenario: Scenario
    sample: Sample
    first: Run

    @property
    def path(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Places at the pings of the first run and at its end, float64[pings + 1, 2], m."""
        return np.concatenate([self.first.log[:, 1:3], [self.first.end]])


def run(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
    """Fly one sample.

    Raises `DataError` for a map that is none, `ParameterError` for a forest too dense or a start inside a
    zone of collision.
    """
    number = -1 if scenario.die.number is None else scenario.die.number
    key = scenario.seed, number + 1
    senses = senses_of(scenario.sensing, scenario.bat, scenario.die, scenario.temperature_c, key)
    sample, first = fly_sample(
        arcs_of(scenario.bat),
        _forests(scenario),
        key,
        scenario.pings,
        scenario.start,
        min(scenario.rows, scenario.pings),
        progress,
        senses,
    )
    return Trace(scenario, sample, first)


def read_options(options: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of a scenario from those of the command line; start is `X,Y`, speed and rate are the bat's."""
    fields = read_texts(options, {**QUANTITIES, "start": read_place})
    if "map" in fields and "obstacles" in fields:
        raise ParameterError("--obstacles: not with --map, which has its own; leave one out")
    numbers = {}
    for option, name, unit in (("vmax", "max_speed", "m/s"), ("ping_rate", "ping_rate", "Hz")):
        if option in fields:
            value = fields.pop(option)
            if not 0.0 < value < float("inf"):
                shown = option.replace("_", "-")
                raise ParameterError(f"--{shown}: {value:g} {unit}, must be above 0 and finite")
            numbers[name] = value
    weights = fields.pop("weights", WEIGHTS[0])
    sensing = read_sensing(fields)
    return {**fields, "sensing": sensing, "bat": weighted(Bat(**numbers), weights)}


def read_sensing(fields: dict[str, Any]) -> Sensing:
    """Take the options of the senses out of `fields`; `azimuth_noise` is in degrees, `area` of both chips."""
    given = {name: fields.pop(name) for name in SENSES if name in fields}
    if "azimuth_noise" in given:
        given["azimuth_noise"] = math.radians(given["azimuth_noise"])
    sensing = Sensing(**given)
    if "area" not in fields:
        return sensing
    if not sensing.silicon:
        raise ParameterError("--area: no chip is in the loop; give --ranges chip or --selection chip")
    return with_area(sensing, fields.pop("area"))


def read_place(text: str, option: str) -> tuple[float, float]:
    """Place of `X,Y`, m; raises `ParameterError` naming the option."""
    x, y = place(text, option)
    if not (0.0 <= x < SIDE and 0.0 <= y < SIDE):
        raise ParameterError(
            f'{option}: "{text}", must be from 0m to below {SIDE:g}m; write as in {option}=40m,25m'
        )
    return x, y


def summarise(trace: Trace) -> dict[str, float | None]:
    """Scalars of a sample; where `collided` is 0 it ended undecided, and would have avoided more."""
    return {name: float(getattr(trace.sample, name)) for name in SUMMARY}


def account(trace: Trace) -> Account:
    """What a sample says of itself; a bat never rests."""
    s, sample = trace.scenario, trace.sample
    sensing = s.sensing
    on: dict[str, Any] = {"ranges": sensing.ranges, "selection": sensing.selection}
    if sensing.silicon:
        on |= {
            "reader": sensing.reader,
            "ranging_area": sensing.ranging_area,
            "selection_area": sensing.selection_area,
            "silicon_noise": sensing.silicon_noise,
            **describe_run(s.die, s.temperature_c, sensing.bias_kind or AS_BUILT),
        }
    on_time = sample.time_s * s.bat.max_speed
    return Account(
        succeeded=not (sample.collided or sample.trapped) and gets_on(sample.progress_m, on_time),
        reason=ended_because(sample.pings, collided=sample.collided),
        ran_on=on,
        distance_m=sample.distance_m,
        emergency_share=sample.emergencies / sample.pings,
    )


def draw(trace: Trace, figure: Figure) -> None:
    """Fill `figure` with the first run's path in its forest, as in Figure 10B."""
    s, sample, said = trace.scenario, trace.sample, account(trace)
    shown = "" if sample.runs == 1 else f" in {sample.runs} runs, of which this is the first"
    title = (
        f"{len(trace.first.forest.place)} obstacles, {s.bat.max_speed:g} m/s, {s.bat.ping_rate:g} Hz:"
        f" {sample.avoided} avoided{shown}{_of_senses(s)}\n{said.headline}"
    )
    succeeded = said.succeeded if sample.runs == 1 else None
    draw_view_of_run(trace.first.forest.place, s.bat.zone, trace.path, figure, title, succeeded=succeeded)


def _of_senses(scenario: Scenario) -> str:
    sensing = scenario.sensing
    if sensing == IDEAL:
        return ""
    die = f", {scenario.die}, {scenario.temperature_c:g} degC" if sensing.silicon else ""
    return f"\nranges {sensing.ranges}, selection {sensing.selection}{die}"


def _forests(scenario: Scenario) -> Planter:
    if scenario.map is None:
        return planter(scenario.obstacles)
    forest = read_forest(scenario.map)

    def same(_: np.random.Generator) -> Forest:
        return forest

    return same


@dataclass(frozen=True, slots=True)
class ForestSystem:
    """The system as the command line sees it."""

    name: str = "forest"
    summary: str = "bat that flies through a dense forest by pings in five directions and a choice of arcs"
    success: str = SUCCESS
    metrics: tuple[str, ...] = metrics_with(SUMMARY)
    yes_no: tuple[str, ...] = (SUCCEEDED, "collided")
    study_metrics: tuple[str, ...] = ("avoided", "collided")  # unless others are asked for

    def scenario(self, **options: Any) -> Scenario:
        """A scenario of these fields, or of options as the command line has them."""
        return scenario_of(self.name, Scenario, options, read_options, PARTS)

    def study_options(
        self, level: str, bias_kind: BiasKind | None, route: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Fields of a study's scenario: a forest a die, with chips its silicon too."""
        if level != "behavioural":
            raise ParameterError("--level: the forest's chips are behavioural models; leave it out")
        given = read_route(self.name, route, STUDIED)
        if bias_kind is not None:
            given["bias_kind"] = bias_kind
        silicon = read_options(given)["sensing"].silicon
        return {"pings": CHIP_STUDY_PINGS if silicon else STUDY_PINGS, "rows": 0, **given}

    def circuits(self) -> tuple[Circuit, ...]:
        """What its chips are made of: nothing that deviates in every one of its runs."""
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
        draw(trace, figure)


SYSTEM = ForestSystem()
