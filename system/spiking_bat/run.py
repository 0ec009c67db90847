"""A flight through a forest steered by spikes, as `noctule run forest --model` runs it.

The forest and the start are those of the analog model's first run with the same seed, so that models can be
compared on the same forests. A run is one flight: until a collision, or so many pings.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from chips.latency.calibration import calibrated
from chips.latency.chip import LatencyChip
from chips.latency.design import Design
from chips.latency.model import usual_biases
from chips.latency.unit_level import TransistorUnit
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.silicon import Silicon
from system.openspace.flight import begin, ended_because, gets_on
from system.openspace.law import Arcs, Bat, arcs_of
from system.openspace.map import OBSTACLES, SIDE, Forest, check_count, plant, read_forest
from system.openspace.picture import draw_view_of_run
from system.options.block import describe_die, describe_run
from system.options.noise import Noisy, silicon_noise
from system.spiking_bat.brain import Brain, check_timing, network_brain
from system.spiking_bat.chip_brain import ChipBrain, brain_with, design_of
from system.spiking_bat.flight import Flown, fly
from system.spiking_bat.lif import all_lif
from system.spiking_bat.numbers import PATHS, UNITS, Numbers, numbers_at
from system.system import Account, summary_of

MODELS = ("analog", "latency-network", "latency-chip", "latency-lif")  # of the bat's mind
CODES = ("usual", "calibrated")  # of a chip's biases
PING_RATE = 10.0  # Hz; the paper's in Figure 13
PINGS = 1000  # of a flight: 100 s, or some 40 s of computing the network; ours
ROOM_TEMPERATURE = 27.0  # degC
SUMMARY = ("collided", "avoided", "laps", "pings", "time_s", "distance_m", "emergencies", "scans")


@dataclass(frozen=True, slots=True)
class ChipChoice:
    """Which latency chip: its silicon, biases, and units at transistor level.

    codes: `usual`, or `calibrated` on its die at 27 degC; area: of its devices, over the circuits'; units: by
    memory and number; course: pairs of time (s) and degC that the temperature follows after its beginning;
    silicon_noise: of its devices, by the scenario's seed.
    """

    die: Die = NOMINAL
    temperature_c: float = ROOM_TEMPERATURE
    bias_kind: BiasKind = "gate"
    codes: str = CODES[0]
    area: float = 1.0
    units: tuple[tuple[int, int], ...] = ()
    course: tuple[tuple[float, float], ...] = ()
    silicon_noise: Noisy = "off"

    def __post_init__(self) -> None:
        if silicon_noise(self.silicon_noise, 0) is not None and self.units:
            raise ParameterError(
                f"--silicon-noise: {self.silicon_noise}, not with --unit, whose transistors make none here;"
                " leave one out"
            )
        if self.codes not in CODES:
            raise ParameterError(f"--codes: {self.codes}, must be {' or '.join(CODES)}")
        if self.area != 1.0 and self.units:
            raise ParameterError("--area: not with --unit, whose devices are the circuit's; leave one out")


@dataclass(frozen=True, slots=True)
class LatencyScenario:
    """What a bat that thinks in spikes is asked to do; fields as of `system.forest.run.Scenario`."""

    model: str = MODELS[1]
    max_speed: float = Bat().max_speed
    ping_rate: float = PING_RATE
    paths: int = PATHS
    taps: int = UNITS
    map: str | None = None
    obstacles: int = OBSTACLES
    start: tuple[float, float] | None = None
    pings: int = PINGS
    seed: int = 0
    chip: ChipChoice = field(default_factory=ChipChoice)

    def __post_init__(self) -> None:
        if self.seed < 0:
            raise ParameterError(f"--seed: {self.seed}, must be >= 0")
        if self.pings < 1:
            raise ParameterError(f"--pings: {self.pings}, must be at least 1")
        if self.map is None:
            check_count(self.obstacles)

    @property
    def bat(self) -> Bat:
        """The bat that flies."""
        return Bat(max_speed=self.max_speed, ping_rate=self.ping_rate)

    @property
    def numbers(self) -> Numbers:
        """Numbers of its network or chip."""
        return numbers_at(self.ping_rate, self.taps, self.paths)


@dataclass(frozen=True, slots=True)
class LatencyTrace:
    """A flight and where it was."""

    scenario: LatencyScenario
    forest: Forest
    start: tuple[float, float]
    flown: Flown = field(repr=False)
    counts: Mapping[str, int] = field(default_factory=dict)


def scenario_of(options: Mapping[str, Any]) -> LatencyScenario:
    """A scenario of these options; raises `ParameterError` naming one that its model does not have."""
    known = {f.name for f in fields(LatencyScenario)} | {"vmax"}
    of_chip = {f.name for f in fields(ChipChoice)}
    given = dict(options)
    chip = {name: given.pop(name) for name in of_chip & set(options)}
    if chip and options["model"] != MODELS[2]:
        name = min(chip).replace("_", "-")
        raise ParameterError(f"--{name}: only with --model {MODELS[2]}, which is silicon; leave it out")
    for name in given:
        if name not in known:
            shown = name.replace("_", "-")
            raise ParameterError(
                f"--{shown}: not with --model {options['model']}, whose ranges are exact and weights fixed;"
                " leave it out, or take --model analog"
            )
    if "vmax" in given:
        given["max_speed"] = given.pop("vmax")
    return LatencyScenario(chip=ChipChoice(**chip), **given)


def run(scenario: LatencyScenario, progress: Callable[[float], None] | None = None) -> LatencyTrace:
    """Fly once.

    Raises `DataError` for a map that is none, `ParameterError` for a forest too dense, a start inside a zone
    of collision, and what does not fit the network.
    """
    arcs = arcs_of(scenario.bat)
    brain = brain_of(scenario, arcs)
    forest, start = place(scenario, arcs)
    flown = fly(brain, arcs, forest, start, scenario.pings, progress=progress)
    counts = brain.counts() if isinstance(brain, ChipBrain) else {}
    return LatencyTrace(scenario, forest, start, flown, counts)


def brain_of(scenario: LatencyScenario, arcs: Arcs) -> Brain:
    """The brain of a scenario's model."""
    if scenario.model == MODELS[1]:
        return network_brain(arcs, scenario.numbers)
    if scenario.model == MODELS[3]:
        return network_brain(arcs, scenario.numbers, all_lif)
    check_timing(arcs, scenario.numbers)
    design = design_of(arcs, scenario.numbers)
    course = np.array(scenario.chip.course).T if scenario.chip.course else None
    temperature = None if course is None else (course[0], course[1])
    chip = chip_of(design, scenario.chip, scenario.seed)
    return brain_with(chip, arcs, scenario.numbers, temperature)


def chip_of(design: Design, choice: ChipChoice, seed: int = 0) -> LatencyChip:
    """The chip of a choice; raises `ParameterError` for silicon or codes that there are none of.

    seed: of its devices' noise.
    """
    silicon = Silicon(temperature_c=choice.temperature_c, die=choice.die)
    if choice.codes == CODES[1]:
        at = replace(silicon, temperature_c=ROOM_TEMPERATURE)
        biases = calibrated(design, at, choice.bias_kind, area=choice.area)
    else:
        biases = usual_biases(design, choice.bias_kind)
    bare = LatencyChip(design, biases, silicon, area=choice.area)
    for memory, unit in choice.units:
        bare.check_unit(memory, unit)
    units = {(p, u): TransistorUnit(biases, silicon, p, u) for p, u in choice.units}
    noise = silicon_noise(choice.silicon_noise, seed)
    return LatencyChip(design, biases, silicon, area=choice.area, units=units, noise=noise)


def place(scenario: LatencyScenario, arcs: Arcs) -> tuple[Forest, tuple[float, float]]:
    """Forest and start, those of the analog model's first run with this seed."""
    random = np.random.default_rng((scenario.seed, 0, 0))
    forest = plant(scenario.obstacles, random) if scenario.map is None else read_forest(scenario.map)
    return forest, begin(arcs, forest, random, scenario.start)


def summarise(trace: LatencyTrace) -> dict[str, float]:
    """Scalars of a flight; where `collided` is 0 it would have gone on."""
    found = {name: float(getattr(trace.flown, name)) for name in SUMMARY}
    found["progress_m"] = progress(trace.flown.path)
    return found | {name: float(count) for name, count in trace.counts.items()}


def account(trace: LatencyTrace) -> Account:
    """What a flight says of itself, as of `system.forest.run`."""
    s, flown = trace.scenario, trace.flown
    on: dict[str, Any] = {"model": s.model}
    if s.model == MODELS[2]:
        chip = s.chip
        on |= {
            "codes": chip.codes,
            "area": chip.area,
            "transistor_units": len(chip.units),
            "silicon_noise": chip.silicon_noise,
            **describe_run(chip.die, chip.temperature_c, chip.bias_kind),
        }
    return Account(
        succeeded=not flown.collided and gets_on(progress(flown.path), flown.time_s * s.max_speed),
        reason=ended_because(flown.pings, collided=flown.collided),
        ran_on=on,
        distance_m=flown.distance_m,
        emergency_share=flown.emergencies / flown.pings,
    )


def progress(path: F64) -> float:
    """How far (m) a path on the torus, float64[n, 2] in steps shorter than half of it, led to the left."""
    steps = np.diff(path[:, 0])
    return float(-(steps - SIDE * np.round(steps / SIDE)).sum())


def document(trace: LatencyTrace) -> dict[str, Any]:
    """A flight by the names that JSON has for its parts; a row is a stretch of one arc."""
    s, log = trace.scenario, trace.flown.log
    return {
        "system": "forest",
        "model": s.model,
        "map": s.map,
        "obstacles": len(trace.forest.place),
        "max_speed_m_per_s": s.max_speed,
        "ping_rate_Hz": s.ping_rate,
        "paths": s.paths,
        "taps": s.taps,
        **(_of_chip(s.chip) if s.model == MODELS[2] else {}),
        "zone_m": s.bat.zone,
        "seed": s.seed,
        "start_m": trace.start,
        "ended": account(trace).reason,
        "obstacles_m": trace.forest.place,
        "time_s": log[:, 0],
        "path_m": trace.flown.path,
        "heading_rad": log[:, 3],
        "ping_direction": log[:, 4].astype(int),
        "winner": log[:, 6].astype(int),
        "scanning": log[:, 7].astype(bool),
        "summary": summary_of(account(trace), summarise(trace)),
    }


def _of_chip(choice: ChipChoice) -> dict[str, Any]:
    return {
        "temperature_C": choice.course or choice.temperature_c,
        **describe_die(choice.die),
        "bias_kind": choice.bias_kind,
        "codes": choice.codes,
        "area": choice.area,
        "transistor_units": choice.units,
        "silicon_noise": choice.silicon_noise,
    }


def _warmth(choice: ChipChoice) -> str:
    if not choice.course:
        return f"{choice.temperature_c:g}"
    return f"{min(c for _, c in choice.course):g} to {max(c for _, c in choice.course):g}"


def draw(trace: LatencyTrace, figure: Figure) -> None:
    """Fill `figure` with the path in its forest."""
    s = trace.scenario
    title = (
        f"{s.model}: {len(trace.forest.place)} obstacles, {s.max_speed:g} m/s, {s.ping_rate:g} Hz:"
        f" {trace.flown.avoided} avoided"
    )
    if s.model == MODELS[2]:
        title += f"\n{s.chip.die}, {_warmth(s.chip)} degC, biases by {s.chip.bias_kind}, {s.chip.codes}"
    said = account(trace)
    title += f"\n{said.headline}"
    place, path = trace.forest.place, trace.flown.path
    draw_view_of_run(place, s.bat.zone, path, figure, title, succeeded=said.succeeded)
