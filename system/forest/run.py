"""Forest: a bat flies left through a dense forest by narrow pings (Wen & Horiuchi 2022, analog model).

pings -> ranges and bearings of obstacles in the field of view -> memory of the risk of each arc -> most
desirable arc -> head and body. Ranges and bearings are exact, as in the paper, or those of a sonar or of a
ranging chip, and the selection is ideal or a chip's (`system.openspace.senses`). With chips a die is silicon,
and the number of a sample; without, no more than that number.

A run of the system is one sample: flights until a collision, or a number of pings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from chips.ranging.circuit import NEURONS
from chips.selection.model import selection_errors
from circuits.arrays import F64
from circuits.silicon.course import beginning_of, course_through
from circuits.silicon.process import AMI_1500
from system.forest.live import LiveForest
from system.forest.scenario import AREA, KINDS, Scenario, make, no_silicon, of_study
from system.forest.weights import WEIGHTS
from system.meaning import meanings, of_run
from system.openspace.flight import (
    FLIGHT_KEYS,
    SUCCESS,
    Run,
    Sample,
    ended_because,
    flight_entries,
    fly_sample,
    gets_on,
    planter,
)
from system.openspace.law import arcs_of
from system.openspace.moving import Moving, along_jitter
from system.openspace.picture import draw_view_of_run, film_of_flight
from system.openspace.population import jitter_of
from system.openspace.senses import IDEAL, Sensing, senses_of
from system.openspace.senses_kernel import Senses
from system.option import Option
from system.options.block import describe_run
from system.options.codes import described
from system.options.outside import inside_boxes
from system.plot import silicon_text
from system.spikes.output import spikes_made_again, trains_of
from system.system import PROGRAMS, SUCCEEDED, Account, Progress, RunTrace, System, part
from system.view.film import Film

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SUMMARY = meanings("""
avoided        number  -  obstacles that were detected and not collided with
collided       number  -  1 where it ended by a collision, 0 where it would have gone on
pings          number  -  pings that were made
time_s         number  s  time of all flights
distance_m     number  m  way of all flights
laps           number  -  crossings of the left border
runs           number  -  flights that it took
trapped        number  -  flights that ended without a new crossing for long
emergencies    number  -  times that the bat turned round
scans          number  -  pings after which only the head turned
heard          number  -  echoes that were heard; 0, as the six below, where ranges are exact
missed         number  -  echoes of which the chip had no reading
masked         number  -  echoes that an earlier one masked
occluded       number  -  obstacles that others hid
ghosts         number  -  echoes that came by way of two obstacles
late           number  -  selections that a chip had not made in time
ties           number  -  selections that the chip's model cannot tell
other_choices  number  -  selections that the desirabilities themselves would not have made
deciding_s     number  s  time that selections took
progress_m     number  m  how far the way led to the left
""")  # of a sample, which may have several flights
DOCUMENT = meanings("""
obstacles          integer    -  how many obstacles there are
silicon_noise      string     -  noise of the chip's devices: `off`, `white`, or `all` with flicker
ping_bias          number     -  what arcs in the direction of the last ping gain in desirability
immediacy_range_m  number     m  range within which an echo inhibits arcs
escape             integer    -  turns round in a row after which it flies the best arc all the same; 0 for
                                 none
area               number     -  area of the ranging chip's devices over the circuit's
selection_errors   number{}   -  errors of the selection's model, as its record has them, in the units
                                 of their names
arc                integer[]  -  number of the arc that was flown after each ping, from the left
scanning           boolean[]  -  whether only the head turned after it
summary.ran_on.ranging_area    number  -  area of the ranging chip's devices over the circuit's
summary.ran_on.selection_area  number  -  area of the selection's devices over the circuit's
""")  # rows are those of the first flight


@dataclass(frozen=True, slots=True)
class Trace(RunTrace[Scenario]):
    """What a run leaves: the counts of its sample, and its first flight.

    sample : counts of all flights of the sample.
    first : the first of these flights.
    """

    sample: Sample
    first: Run

    @property
    def path(self) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Places at the pings of the first run and at its end, float64[pings + 1, 2], m."""
        return np.concatenate([self.first.log[:, 1:3], [self.first.end]])


@inside_boxes
def run(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
    """Fly one sample and return it with its first flight.

    Raises `DataError` for a map that is none, `ParameterError` for a forest too dense or a start inside a
    zone of collision.
    """
    key = _key(scenario)
    sample, first = fly_sample(
        scenario.arcs,
        planter(scenario.obstacles, scenario.map),
        key,
        scenario.pings,
        scenario.start,
        min(scenario.rows, scenario.pings),
        progress,
        moving_of(scenario),
    )
    return Trace(scenario, sample, first)


def open_flight(scenario: Scenario) -> LiveForest:
    """Return the bat of a scenario at its start, which goes on ping by ping; raises as `run` does."""
    return LiveForest(scenario, moving_of(scenario), _key(scenario))


def spike_trains(trace: Trace, progress: Progress) -> tuple[dict[str, F64], float]:
    """Return the spikes of the ranging chip in the first flight of a sample, s by neuron, and its end, s."""
    bat, pings = open_flight(trace.scenario), trace.scenario.pings
    told = []
    while not (bat.ended or bat.late):
        told.append(bat.spikes())
        bat.act(bat.own())
        progress(len(told) / pings)
    times, neurons = (np.concatenate(each) for each in zip(*told, strict=True))
    return trains_of("neuron", NEURONS, times, neurons), bat.time


def no_spikes(scenario: Scenario) -> str:
    """Say what makes a scenario's ranging chip spike one by one; empty where it does."""
    sensing = scenario.sensing
    if sensing.ranges != "chip":
        return "give `ranges=chip`"
    if scenario.ranging_codes is not None:
        return ""
    return "" if sensing.silicon_noise != "off" else "give `silicon_noise=white`, or all"


def _key(scenario: Scenario) -> tuple[int, int]:
    """Of the forests and starts of a sample."""
    number = -1 if scenario.die.number is None else scenario.die.number
    return scenario.seed, number + 1


def moving_of(scenario: Scenario) -> Moving:
    """Return the senses of a scenario over time."""
    s, key = scenario, _key(scenario)
    begun_c = beginning_of(s.temperature_c, s.course) if s.course else None
    codes, selecting = s.ranging_codes, s.selecting

    def made(celsius: float) -> Senses:
        silicon = s.silicon_at(celsius)
        sensing = replace(s.sensing, ripple=s.ripple)
        return senses_of(sensing, s.bat, silicon, key, begun_c, s.bias_kind, codes, selecting)

    senses_at = along_jitter(s.course, s.temperature_c, made, lambda s: jitter_of(s.population, s.reader))
    return Moving(senses_at, course_through(s.course))


def summarise(trace: Trace) -> dict[str, float | None]:
    """Return the numbers of a sample by their names.

    Where `collided` is 0 the sample ended undecided, and would have avoided more obstacles.
    """
    return {name: float(getattr(trace.sample, name)) for name in SUMMARY}


def account(trace: Trace) -> Account:
    """Say whether a run succeeded, why it ended, and what it ran on.

    The bat never rests, so that a sample has no share of standing.
    """
    s, sample = trace.scenario, trace.sample
    sensing = s.sensing
    on: dict[str, Any] = {"ranges": sensing.ranges, "selection": sensing.selection}
    if sensing.silicon:
        on |= {
            **described(s),
            "ranging_area": sensing.ranging_area,
            "selection_area": sensing.selection_area,
            "silicon_noise": sensing.silicon_noise,
            **describe_run(s),
        }
    on_time = sample.time_s * s.bat.max_speed
    return Account(
        succeeded=not (sample.collided or sample.trapped) and gets_on(sample.progress_m, on_time),
        reason=ended_because(sample.pings, collided=sample.collided),
        ran_on=on,
        parts=_parts(sensing),
        distance_m=sample.distance_m,
        emergency_share=sample.emergencies / sample.pings,
        outside=trace.outside,
    )


def _parts(sensing: Sensing) -> dict[str, str]:
    """What senses, what chooses, and what flies."""
    ranges = {"exact": "exact places", "sonar": "a sonar's time of flight"}
    return {
        "ranges": part(sensing.ranges, "ranging chip", ranges),
        "choice of an arc": part(sensing.selection, "selection chip", {"ideal": "program"}),
        "bearings, memory and flight": PROGRAMS,
    }


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


def film(trace: Trace, _: tuple[str, ...] | None) -> Film:
    """Return the film of the first run."""
    first, sample, s = trace.first, trace.sample, trace.scenario
    last = sample.time_s if sample.runs == 1 else (float(first.log[-1, 0]) if len(first.log) else 0.0)
    return film_of_flight(first.forest.place, s.bat.zone, first.log, first.end, last, arcs_of(s.bat))


def _of_senses(scenario: Scenario) -> str:
    sensing = scenario.sensing
    if sensing == IDEAL:
        return ""
    on = silicon_text(scenario.die, scenario.temperature_c, course=scenario.course, law=scenario.law)
    die = f", {on}" if sensing.silicon else ""
    return f"\nranges {sensing.ranges}, selection {sensing.selection}{die}"


def document(trace: Trace) -> dict[str, Any]:
    """Return the entries that only this system's JSON document has, by their keys.

    Its rows are those of the first flight.
    """
    s, first = trace.scenario, trace.first
    log, sensing = first.log, s.sensing
    return {
        "obstacles": len(first.forest.place),
        "silicon_noise": sensing.silicon_noise,
        "ping_bias": s.bat.ping_bias,
        "immediacy_range_m": s.bat.immediacy_range,
        "escape": s.escape,
        **({AREA: sensing.ranging_area} if sensing.silicon else {}),
        **({"selection_errors": _errors(s)} if sensing.selection == "chip" else {}),
        **flight_entries(first.forest, s.bat.zone, first.start, account(trace).reason, log, trace.path),
        "arc": log[:, 5].astype(int),
        "scanning": log[:, 7].astype(bool),
    }


def _errors(scenario: Scenario) -> dict[str, float]:
    """Errors of the selection's model under the law of a scenario."""
    return dict(selection_errors(AMI_1500.under(scenario.law)))


def title(trace: Trace) -> str:
    """Return the heading of the table of a run's numbers."""
    bat, sensing = trace.scenario.bat, trace.scenario.sensing
    flight = f"{len(trace.first.forest.place)} obstacles, {bat.max_speed:g} m/s, {bat.ping_rate:g} Hz"
    return f"{flight}, ranges {sensing.ranges}, selection {sensing.selection}"


def first_run(trace: Trace) -> tuple[str, ...]:
    """Return a line with the places where the first flight began and ended."""
    (x, y), (end_x, end_y) = trace.first.start, trace.first.end
    return (f"first of {trace.sample.runs} runs from {x:.2f},{y:.2f} m to {end_x:.2f},{end_y:.2f} m",)


def told(trace: Trace) -> Iterator[str]:
    """Return the lines that stand under the numbers of a sample."""
    if trace.scenario.sensing.ranges == "chip":
        yield "the chip gives ranges only: azimuths are the true ones, with `azimuth_noise` if any"
    if not trace.sample.collided:
        yield "`pings=N` flies on"


SYSTEM = System(
    name="forest",
    summary="bat in a dense forest by pings in five directions and arcs (Wen & Horiuchi 2022)",
    kind=Scenario,
    success=SUCCESS,
    run=run,
    account=account,
    numbers=summarise,
    draw=draw,
    film=film,
    yes_no=(SUCCEEDED, "collided"),
    study_metrics=("avoided", "collided"),
    usual=lambda _: {"ranges": "chip", "selection": "chip"},
    ideal={"ranges": "exact", "selection": "ideal"},
    study=of_study,
    no_silicon=no_silicon,
    open=open_flight,
    more={
        KINDS: Option(help="Fixed, or by the speed straight ahead", choices=WEIGHTS, study=True),
        AREA: Option(help="Of a chip's devices, over the circuits'", unit="", study=True, silicon=True),
    },
    make=make,
    document=document,
    meanings=of_run(SUMMARY, {**DOCUMENT, **FLIGHT_KEYS}),
    title=title,
    before=first_run,
    after=told,
    outputs={
        "spikes": spikes_made_again(
            "the spikes of the ranging chip in the first flight", spike_trains, no_spikes
        ),
    },
)
