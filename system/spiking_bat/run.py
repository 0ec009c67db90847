"""Spiking bat: a flight through a forest steered by spike latencies (Wen & Horiuchi 2022, sections 3 and 5).

The brain is a network of ideal neurons, one of integrate-and-fire neurons, or the latency chip of a die.

The forest and the start are those of the analog model's first run with the same seed, so that models can be
compared on the same forests. A run is one flight: until a collision, or so many pings.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chips.latency.calibration import NAME, Sized, biases_of
from chips.latency.chip import LatencyChip
from chips.latency.design import Design
from chips.latency.measure import circuits
from chips.latency.model import usual_biases
from chips.latency.unit_level import TransistorUnit
from circuits.arrays import F64, I64
from circuits.errors import ParameterError
from circuits.silicon.course import course_through
from system.meaning import meanings, of_run
from system.openspace.flight import (
    FLIGHT_KEYS,
    SUCCESS,
    begin,
    ended_because,
    flight_entries,
    gets_on,
    planter,
)
from system.openspace.law import Arcs, arcs_of
from system.openspace.map import SIDE, Forest
from system.openspace.picture import draw_view_of_run, film_of_flight
from system.options.block import describe_run
from system.options.codes import described
from system.options.noise import NOISELESS, device_noise
from system.options.outside import inside_boxes
from system.plot import silicon_text
from system.spikes.output import spikes_output, trains_of
from system.spiking_bat.brain import Brain, check_timing, network_brain
from system.spiking_bat.chip_brain import EMERGENCY, ChipBrain, brain_with, design_of
from system.spiking_bat.flight import Flown, fly
from system.spiking_bat.lif import all_lif
from system.spiking_bat.scenario import Scenario, make, no_silicon
from system.system import PROGRAMS, SUCCEEDED, Account, RunTrace, System, metrics_with, part
from system.view.film import Film, Panel, Raster, merged

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BRAINS = {"network": "ideal neurons", "lif": "integrate-and-fire neurons"}  # beside the chip
COUNTED = ("collided", "avoided", "laps", "pings", "time_s", "distance_m", "emergencies", "scans")
SUMMARY = meanings("""
collided     number  -  1 where it ended by a collision, 0 where it would have gone on
avoided      number  -  obstacles that were detected and not collided with
laps         number  -  crossings of the left border
pings        number  -  pings that were made
time_s       number  s  time of the flight
distance_m   number  m  way of the flight
emergencies  number  -  times that the bat turned round
scans        number  -  pings after which only the head turned
progress_m   number  m  how far the way led to the left
""")
ON_CHIP = meanings("""
lost        number  -  events that the chip's bus lost
overflowed  number  -  inputs that found all synapses of their neuron taken, and were lost
undecided   number  -  detectors so near a tie that the model cannot tell
""")  # numbers of a run whose brain is a chip
DOCUMENT = meanings("""
transistor_units  integer[][]  -  memory and unit of each that is kept at transistor level
obstacles      integer     -     how many obstacles there are
winner         integer[]   -     number of the arc that won after each ping, from the left
scanning       boolean[]   -     whether only the head turned after it
summary.ran_on.transistor_units  integer  -  how many units are kept at transistor level
""")


@dataclass(frozen=True, slots=True)
class Trace(RunTrace[Scenario]):
    """What a run leaves: the flight, the forest that it went through, and counts of its chip.

    start : where it began, m.
    flown : the flight.
    spikes : of its chip, times (s) and addresses (`ChipBrain.spikes`); None without a chip.
    """

    forest: Forest
    start: tuple[float, float]
    flown: Flown = field(repr=False)
    counts: Mapping[str, int] = field(default_factory=dict)
    spikes: tuple[F64, I64] | None = field(default=None, repr=False)


@inside_boxes
def run(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
    """Fly once and return the flight.

    Raises `DataError` for a map that is none, `ParameterError` for a forest too dense, a start inside a zone
    of collision, and what does not fit the network.
    """
    arcs = arcs_of(scenario.bat)
    brain = brain_of(scenario, arcs)
    forest, start = place(scenario, arcs)
    flown = fly(brain, arcs, forest, start, scenario.pings, progress=progress)
    if not isinstance(brain, ChipBrain):
        return Trace(scenario, forest, start, flown)
    return Trace(scenario, forest, start, flown, brain.counts(), brain.spikes())


def brain_of(scenario: Scenario, arcs: Arcs) -> Brain:
    """Return the brain that a scenario asks for, ready for its first ping."""
    if scenario.brain == "network":
        return network_brain(arcs, scenario.numbers)
    if scenario.brain == "lif":
        return network_brain(arcs, scenario.numbers, all_lif)
    check_timing(arcs, scenario.numbers)
    design = design_of(arcs, scenario.numbers)
    return brain_with(chip_of(design, scenario), arcs, scenario.numbers, course_through(scenario.course))


def chip_of(design: Design, scenario: Scenario) -> LatencyChip:
    """Return the chip of a scenario.

    Raises `ParameterError` for silicon or codes that there are none of.
    """
    s = scenario
    silicon = s.silicon_at(s.beginning_c)
    codes = s.codes_of(NAME, setup=Sized(design, s.area))
    biases = (
        usual_biases(design, s.bias_kind, silicon.process)
        if codes is None
        else biases_of(codes, design, silicon.process)
    )
    bare = LatencyChip(design, biases, silicon, area=s.area)
    for memory, unit in s.units:
        bare.check_unit(memory, unit)
    units = {(p, u): TransistorUnit(biases, silicon, p, u) for p, u in s.units}
    noise = device_noise(s)
    return LatencyChip(design, biases, silicon, area=s.area, units=units, noise=noise)


def place(scenario: Scenario, arcs: Arcs) -> tuple[Forest, tuple[float, float]]:
    """Return forest and start, those of the analog model's first run with this seed."""
    random = np.random.default_rng((scenario.seed, 0, 0))
    forest = planter(scenario.obstacles, scenario.map)(random)
    return forest, begin(arcs, forest, random, scenario.start)


def summarise(trace: Trace) -> dict[str, float]:
    """Return the numbers of a flight by their names.

    Where `collided` is 0 the flight would have gone on.
    """
    found = {name: float(getattr(trace.flown, name)) for name in COUNTED}
    found["progress_m"] = progress(trace.flown.path)
    return found | {name: float(count) for name, count in trace.counts.items()}


def account(trace: Trace) -> Account:
    """Say whether a run succeeded, why it ended, and what it ran on.

    As `system.forest.run`, which flies the analog model.
    """
    s, flown = trace.scenario, trace.flown
    on: dict[str, Any] = {"brain": s.brain}
    if s.brain == "chip":
        on |= {
            **described(s),
            "area": s.area,
            "transistor_units": len(s.units),
            "silicon_noise": s.silicon_noise,
            NOISELESS: "units at transistor level" if s.units and s.silicon_noise != "off" else None,
            **describe_run(s),
        }
    return Account(
        succeeded=not flown.collided and gets_on(progress(flown.path), flown.time_s * s.max_speed),
        reason=ended_because(flown.pings, collided=flown.collided),
        ran_on=on,
        parts={
            "memory and choice of an arc": part(s.brain, "latency chip", _BRAINS),
            "sonar, maps and flight": PROGRAMS,
        },
        distance_m=flown.distance_m,
        emergency_share=flown.emergencies / flown.pings,
        outside=trace.outside,
    )


def progress(path: F64) -> float:
    """How far (m) a path on the torus, float64[n, 2] in steps shorter than half of it, led to the left."""
    steps = np.diff(path[:, 0])
    return float(-(steps - SIDE * np.round(steps / SIDE)).sum())


def document(trace: Trace) -> dict[str, Any]:
    """Return the entries that only this system's JSON document has, by their keys.

    A row is a stretch along one arc.
    """
    s, log = trace.scenario, trace.flown.log
    return {
        "obstacles": len(trace.forest.place),
        **flight_entries(trace.forest, s.bat.zone, trace.start, account(trace).reason, log, trace.flown.path),
        "winner": log[:, 6].astype(int),
        "scanning": log[:, 7].astype(bool),
    }


def title(trace: Trace) -> str:
    """Return the heading of the table of a run's numbers."""
    s = trace.scenario
    return f"{s.brain}, {len(trace.forest.place)} obstacles, {s.max_speed:g} m/s, {s.ping_rate:g} Hz"


def where(trace: Trace) -> tuple[str, ...]:
    """Return a line with the places where the flight began and ended."""
    begin_at, end_at = ("{:.2f},{:.2f}".format(*at) for at in (trace.start, trace.flown.end))
    return (f"flight from {begin_at} m to {end_at} m",)


def told(trace: Trace) -> tuple[str, ...]:
    """Return how a flight that did not end could go on."""
    return () if trace.flown.collided else ("`pings=N` flies on",)


def spike_trains(trace: Trace) -> tuple[dict[str, F64], float]:
    """Return the spikes of the arcs that won and of the emergency neuron, s, and the end of the run, s."""
    if trace.spikes is None:
        raise ParameterError("spikes: only those of a chip are recorded; run it on one")
    *arcs, alarm = trains_of("arc", EMERGENCY + 1, *trace.spikes).items()
    return {**dict(arcs), "emergency": alarm[1]}, trace.flown.time_s


def draw(trace: Trace, figure: Figure) -> None:
    """Fill `figure` with the path in its forest."""
    s, said = trace.scenario, account(trace)
    heading = f"{title(trace)}: {trace.flown.avoided} avoided"
    if s.brain == "chip":
        on = silicon_text(s.die, s.temperature_c, s.bias_kind, s.course, s.law)
        heading += f"\n{on}, {described(s)['codes']} codes"
    heading += f"\n{said.headline}"
    place, path = trace.forest.place, trace.flown.path
    draw_view_of_run(place, s.bat.zone, path, figure, heading, succeeded=said.succeeded)


def film(trace: Trace, _: tuple[str, ...] | None) -> Film:
    """Return the film of a flight, with the spikes of the chip where it is on one."""
    flown, s = trace.flown, trace.scenario
    log = flown.log.copy()
    log[:, 5] = log[:, 6]  # here the winner is the arc that is flown
    found = film_of_flight(trace.forest.place, s.bat.zone, log, flown.end, flown.time_s, arcs_of(s.bat))
    if trace.spikes is None:
        return found
    trains = spike_trains(trace)[0]
    times, rows = merged(list(trains.values()))
    raster = Raster(time=times, row=rows, rows=tuple(trains))
    return replace(found, panels=(Panel(title="arcs that win", raster=raster), *found.panels))


SYSTEM = System(
    name="spiking-bat",
    summary="bat in a dense forest by spike latencies, network or chip (Wen & Horiuchi 2022)",
    kind=Scenario,
    success=SUCCESS,
    run=run,
    account=account,
    numbers=summarise,
    draw=draw,
    film=film,
    metrics=metrics_with(SUMMARY),
    yes_no=(SUCCEEDED, "collided"),
    study_metrics=("avoided", "collided"),
    usual=lambda _: {"brain": "chip"},
    ideal={"brain": "network"},
    no_silicon=no_silicon,
    make=make,
    document=document,
    meanings=of_run({**SUMMARY, **ON_CHIP}, {**DOCUMENT, **FLIGHT_KEYS}),
    title=title,
    before=where,
    after=told,
    outputs={"spikes": spikes_output("the spikes of the latency chip", spike_trains, no_silicon)},
    circuits=circuits,
)
