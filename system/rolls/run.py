"""A whole ROLLS die as a study sees it: the rates of its 256 neurons, all driven alike.

Every neuron gets regular events of one rate through one excitatory virtual synapse, each with a phase of its
own that the seed draws, so that what differs between neurons is silicon. No neuron is connected to another,
and I_dc is off, whatever the bias file says. Neurons that the die's calibration leaves out get no events and
are not counted. Rates are counted from `SETTLING` to the end. A neuron is silent that does not fire at all,
hot where it fires more than `HOT` times the median of those that fire, restless where it would fire without
events.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from chips.rolls.chip import TEMPERATURE_STEP, RollsChip, Spikes
from chips.rolls.circuit import chip
from chips.rolls.program.address import NEURONS
from chips.rolls.validity import check_rate
from circuits.arrays import F64, Bools
from circuits.silicon.course import beginning_of, course_through
from system.meaning import meanings, of_run
from system.options.block import describe_run
from system.options.codes import described
from system.options.noise import device_noise
from system.options.on_silicon import IDEAL_CHIP
from system.options.outside import inside_boxes
from system.options.rolls.power import TABLE, power_numbers
from system.options.temperature import temperature_text
from system.plot import COLOURS, INK
from system.rolls.codes import HOT, off_of, table_at
from system.rolls.drive import program_of, regular_events
from system.rolls.scenario import SETTLING, STUDY_DURATION, Scenario, check_table
from system.spikes.output import spikes_output, trains_of
from system.system import Account, RunTrace, System
from system.view.film import Film, Line, Panel, Raster, busiest
from system.view.rolls import Heard, neuron_inside

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN = 0.5  # s, of the picture
SUMMARY = meanings(
    """
population_rate  number   Hz  mean rate of the neurons
rate_cv          number?  -   standard deviation of their rates over the mean; null where none fires
silent           number   -   neurons that do not fire
hot              number   -   neurons above twice the median rate of those that fire
restless         number   -   neurons that fire without input
off              number   -   neurons that the calibration leaves out, which no other number counts
events_lost      number   -   events that the input bus lost
spikes_lost      number   -   spikes that the output bus lost
"""
    + TABLE
)
DOCUMENT = meanings("""
rates_Hz       number[]   Hz  rate of each neuron
restless       boolean[]  -   whether it fires without input
spike_times_s  number[]   s   times of all spikes
spike_neurons  integer[]  -   neuron of each
""")
SUCCESS = (
    "with events no neuron is silent, hot, or fires without them, and no event or spike is lost;"
    " without events no neuron fires"
)


BIN = 20e-3  # s, of the mean rate in a film; ours


@dataclass(frozen=True, slots=True)
class Trace(RunTrace[Scenario]):
    """What a run leaves.

    spikes : all spikes of the run; rates : of each neuron, Hz, float64[256]; restless : which neurons fire
    without input, bool[256]; chip : what ran; given : how many events it was given; off : neurons that its
    calibration leaves out; cautions : sentences of the chip.
    """

    spikes: Spikes
    rates: F64
    restless: Bools
    chip: RollsChip
    given: int = 0
    off: tuple[int, ...] = ()
    cautions: tuple[str, ...] = ()


@inside_boxes
def run(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
    """Drive the die and return its spikes and rates.

    Raises `DataError` for a file of biases that is none.
    """
    s = scenario
    check_rate(s.input_rate)
    found = s.found
    off = off_of(found)
    noise = device_noise(s)
    silicon = s.silicon_at(beginning_of(s.temperature_c, s.course, TEMPERATURE_STEP), s.made_in)
    on_die = RollsChip(program_of(table_at(s.table, found)), silicon, s.bias_kind, step=s.step, noise=noise)
    followed = course_through(s.course, TEMPERATURE_STEP)
    given = regular_events(s.input_rate, s.duration, s.seed, off)
    spikes, _ = on_die.run(on_die.at_rest(), s.duration, given, None if followed is None else followed.at)
    if progress is not None:
        progress(1.0)
    counted = spikes.neurons[spikes.times >= SETTLING]
    rates = np.bincount(counted, minlength=NEURONS) / (s.duration - SETTLING)
    cautions = on_die.cautions()
    return Trace(s, spikes, rates, on_die.restless(), on_die, given.times.size, off, cautions)


def summarise(trace: Trace) -> dict[str, float | None]:
    """Return the numbers of a run by their names; None where a number is not defined.

    Rates are in Hz; the others are counts of neurons and events.
    """
    rates = np.delete(trace.rates, trace.off)
    mean = float(rates.mean())
    firing = rates[rates > 0.0]
    hot = int((rates > HOT * np.median(firing)).sum()) if firing.size else 0
    return {
        "population_rate": mean,
        "rate_cv": float(rates.std()) / mean if mean else None,
        "silent": float((rates == 0.0).sum()),
        "hot": float(hot),
        "restless": float(np.delete(trace.restless, trace.off).sum()),
        "off": float(len(trace.off)),
        "events_lost": float(trace.spikes.lost_in),
        "spikes_lost": float(trace.spikes.lost_out),
        **power_numbers(trace.chip, trace.spikes.neurons, {1: trace.given}, trace.scenario.duration),
    }


def account(trace: Trace) -> Account:
    """Say whether a run succeeded, why it ended, and what it ran on."""
    s, found = trace.scenario, summarise(trace)
    driven = ("silent", "hot", "restless", "events_lost", "spikes_lost")
    wrong = driven if s.input_rate else ("population_rate", "restless")
    return Account(
        succeeded=not any(found[name] for name in wrong),
        reason=f"time of {s.duration:g} s over",
        ran_on={
            "bias_file": s.bias_file,
            "silicon_noise": s.silicon_noise,
            "process": s.process,
            **described(s),
            **describe_run(s),
        },
        parts={"neurons and synapses": "ROLLS chip", "events to them": "program; no chip makes them"},
        cautions=trace.cautions,
        outside=trace.outside,
    )


def draw(trace: Trace, figure: Figure) -> None:
    """Fill `figure` with the spikes of the first half second, and the rate of each neuron."""
    raster, beside = figure.subplots(1, 2, sharey=True, width_ratios=(3, 1))
    first = trace.spikes.times <= SHOWN
    raster.plot(
        trace.spikes.times[first], trace.spikes.neurons[first], color=INK, marker=".", markersize=1.0,
        linestyle="",
    )  # fmt: skip
    raster.set_xlabel("time (s)")
    raster.set_ylabel("neuron")
    beside.barh(np.arange(NEURONS), trace.rates, 1.0, color=COLOURS[0])
    beside.set_xlabel("rate (Hz)")
    s = trace.scenario
    figure.suptitle(
        f"ROLLS, {s.die}, {temperature_text(s.temperature_c, s.course)} °C,"
        f" {s.input_rate:g} events/s a neuron"
        f"\n{account(trace).headline}",
        fontsize=10,
    )


def document(trace: Trace) -> dict[str, Any]:
    """Return the entries that only this system's JSON document has, by their keys."""
    return {
        "rates_Hz": trace.rates,
        "restless": trace.restless,
        "spike_times_s": trace.spikes.times,
        "spike_neurons": trace.spikes.neurons,
    }


def title(trace: Trace) -> str:
    """Return the heading of the table of a run's numbers."""
    s = trace.scenario
    return f"{s.die}, {temperature_text(s.temperature_c, s.course)} degC, {s.input_rate:g} events/s a neuron"


def film(trace: Trace, asked: tuple[str, ...] | None) -> Film:
    """Return the film of a run: spikes of all neurons, and devices of those that are asked for."""
    order = np.argsort(trace.spikes.times, kind="stable")
    times, rows = trace.spikes.times[order], trace.spikes.neurons[order]
    names = tuple(f"neuron[{k}]" for k in range(NEURONS))
    edges = np.arange(0.0, trace.scenario.duration + 0.5 * BIN, BIN)
    mean = np.histogram(times, edges)[0] / (BIN * NEURONS)
    lines = (Line(name="all neurons", time=edges[:-1], value=mean, step=True),)
    return Film(
        title="", headline="", duration=trace.scenario.duration,
        panels=(
            Panel(title="neurons", raster=Raster(time=times, row=rows, rows=names)),
            Panel(title="mean rate of a neuron", unit="Hz", lines=lines),
        ),
        neurons=tuple(
            neuron_inside(trace.chip, name, None if asked is None else _heard(trace))
            for name in busiest(names, rows, asked)
        ),
    )  # fmt: skip


def _heard(trace: Trace) -> Heard:
    """What the neurons of a run got."""
    s, spikes = trace.scenario, trace.spikes
    order = np.argsort(spikes.times, kind="stable")
    given = regular_events(s.input_rate, s.duration, s.seed, trace.off)
    return Heard(spikes.times[order], spikes.neurons[order], lambda *_: given)


SYSTEM = System(
    name="rolls",
    summary="rates of all neurons of a ROLLS die under equal input",
    kind=Scenario,
    success=SUCCESS,
    run=run,
    account=account,
    numbers=summarise,
    draw=draw,
    film=film,
    ideal=IDEAL_CHIP,
    study_metrics=("population_rate", "rate_cv", "silent", "hot"),
    study=lambda _: {"duration": STUDY_DURATION},
    check_study=check_table,
    document=document,
    meanings=of_run(SUMMARY, DOCUMENT),
    title=title,
    outputs={
        "spikes": spikes_output(
            "the spikes that left the chip's bus",
            lambda trace: (
                trains_of("neuron", NEURONS, trace.spikes.times, trace.spikes.neurons),
                trace.scenario.duration,
            ),
        )
    },
    circuits=lambda: (chip(),),
)
