"""Sonar head: two ears on a servo neck that turn to a moving target (Cheely & Horiuchi 2003, Figure 7).

call -> echo at two ears -> envelopes -> level units -> two LSO neurons, excited by one ear and inhibited by
the other -> spikes of the left less those of the right -> neck. Level units and neurons are those of a die.

A run follows one target for a while. The paper has no numbers of its own for this: see
`system.head.numbers`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from chips.lso.measure import LEVELS, circuits
from chips.lso.model import RECORD, SIDES, Head
from chips.record import current_record
from circuits.arrays import F64
from circuits.silicon.course import along
from system.head.ear import hearing
from system.head.live import LiveHead
from system.head.loop import ANSWERED, COUNTS, LOST, SETTLED, Log, begin_following, follow, follows
from system.head.picture import draw_head
from system.head.scenario import Scenario
from system.head.world import Way, way_of
from system.meaning import meanings, of_run
from system.options.block import describe_run
from system.options.codes import described
from system.options.on_silicon import IDEAL_CHIP
from system.options.outside import inside_boxes
from system.plot import silicon_text
from system.spikes.output import spikes_output, trains_of
from system.system import PROGRAMS, Account, RunTrace, System
from system.view.film import Film, Group, Line, Panel, Raster, Shape, Stage, Track

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SUMMARY = meanings("""
error_rms_deg    number  deg  rms angle between head and target
settled_rms_deg  number  deg  the same in the second half of the run
error_max_deg    number  deg  greatest angle between them
spikes_a_ping    number  -    spikes of both sides over the pings
lost             number  -    pings without an answer, for any of the four reasons below
faint            number  -    of these, echoes that no level unit heard
blanked          number  -    of these, echoes that came while the ears were shut
behind           number  -    of these, targets behind the head
late             number  -    of these, echoes that came after the decision
clipped          number  -    ears whose envelope was cut off
late_spikes      number  -    spikes after the decision, and so in vain
steps_over       number  -    pings whose synapses' steps outlast the period, which the next one does not know
neck_ends        number  -    commands beyond the neck's reach
neck_late        number  -    pings before which the neck was not yet there
deaf_levels      number  -    level units that the die makes deaf
""")
DOCUMENT = meanings("""
gain_deg_a_spike  number     deg  how far a spike turns the head
time_s            number[]   s    times of the pings
target_deg        number[]   deg  direction of the target at each
head_deg          number[]   deg  direction of the head at each
range_m           number[]   m    distance of the target at each
spikes_left       integer[]  -    spikes of the left side after each
spikes_right      integer[]  -    spikes of the right side after each
lost              string[]   -    why a ping had no answer: `faint`, `blanked`, `behind` or `late`, else empty
model_errors      number{}   -    errors of the chip's model on other dies, as its record has them, in the
                                  units of their names
""")
SUCCESS = (
    f"in the second half it points at the target within {SETTLED:g} degrees rms, and"
    f" {100.0 * ANSWERED:g} % of its pings have an answer"
)


@dataclass(frozen=True, slots=True)
class Trace(RunTrace[Scenario]):
    """What a run leaves: its log, and the numbers of the die that it was on.

    chip : numbers of its die at the beginning.
    log : the run, ping by ping.
    """

    chip: Head
    log: Log


@inside_boxes
def run(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
    """Follow a target; its way and the noise are drawn from the seed, each by a generator of its own."""
    s = scenario
    chip_at = along(s.course, s.temperature_c, s.chip)
    way, noise = _drawn(s)
    log = follow(s.head, chip_at, way, s.duration, noise, s.wiring, progress, _balance(s))
    return Trace(s, chip_at(0.0)[0], log)


def open_head(scenario: Scenario) -> LiveHead:
    """Return the head of a scenario at rest, which goes on ping by ping; raises as `run` does."""
    s = scenario
    way, noise = _drawn(s)
    chip_at = along(s.course, s.temperature_c, s.chip)
    return LiveHead(begin_following(s.head, chip_at, way, s.duration, noise, s.wiring, _balance(s)))


def _drawn(scenario: Scenario) -> tuple[Way, np.random.Generator]:
    """The way of the target, and what draws the echoes' noise."""
    s = scenario
    way_random, noise_random = (np.random.default_rng((s.seed, k)) for k in range(2))
    return way_of(s.motion, s.target, s.duration + s.head.period, way_random), noise_random


def _balance(scenario: Scenario) -> float:
    return scenario.balance if scenario.wiring == "lso" else 0.0


def summarise(trace: Trace) -> dict[str, float | None]:
    """Return the numbers of a run by their names; `settled` is of its second half."""
    log = trace.log
    error = np.degrees(log.error)
    return {
        "error_rms_deg": float(np.sqrt(np.mean(error**2))),
        "settled_rms_deg": float(np.sqrt(np.mean(error[error.size // 2 :] ** 2))),
        "error_max_deg": float(np.abs(error).max()),
        "spikes_a_ping": float(log.heard.sum() / len(log.time)),
        "lost": float(sum(log.counts[name] for name in LOST)),
        **{name: float(log.counts[name]) for name in COUNTS},
        "deaf_levels": float((~hearing(trace.scenario.head, trace.chip)).sum()),
    }


def account(trace: Trace) -> Account:
    """Say whether the head followed its target; a run ends when its time is over."""
    s = trace.scenario
    return Account(
        succeeded=follows(trace.log),
        reason=f"time of {s.duration:g} s over",
        ran_on={
            "wiring": s.wiring,
            **described(s),
            "area": s.area,
            "silicon_noise": s.silicon_noise,
            **describe_run(s),
        },
        parts={"ears": "LSO neurons of the chip", "target, calls and motor": PROGRAMS},
        outside=trace.outside,
    )


def document(trace: Trace) -> dict[str, Any]:
    """Return the entries that only this system's JSON document has, by their keys."""
    s, log = trace.scenario, trace.log
    return {
        "bias_kind": s.bias_kind,
        "gain_deg_a_spike": np.degrees(s.head.gain),
        "time_s": log.time,
        "target_deg": np.degrees(log.target),
        "head_deg": np.degrees(log.head),
        "range_m": log.distance,
        "spikes_left": log.heard[:, 0],
        "spikes_right": log.heard[:, 1],
        "lost": list(log.lost),
        "model_errors": dict(current_record(RECORD).errors),
    }


def spike_trains(trace: Trace) -> tuple[dict[str, F64], float]:
    """Return the spikes of the LSO neurons of both sides, s, and the end of the run, s."""
    times, side = trace.log.spikes.T
    left, right = trains_of("side", SIDES, times, side.astype(np.int64)).values()
    return {"left": left, "right": right}, trace.scenario.duration


def unanswered(trace: Trace) -> tuple[str, ...]:
    """Return a line on pings without an answer, where there are any."""
    lost = {name: trace.log.counts[name] for name in LOST if trace.log.counts[name]}
    if not lost:
        return ()
    return ("pings without an answer: " + ", ".join(f"{n} {name}" for name, n in lost.items()),)


def draw(trace: Trace, figure: Figure) -> None:
    """Fill an empty figure with angles and rasters over time."""
    s, found = trace.scenario, summarise(trace)
    title = (
        f"{s.motion}, {s.wiring}, {silicon_text(s.die, s.temperature_c, course=s.course, law=s.law)}:"
        f" error {found['error_rms_deg']:.1f} deg rms,"
        f" {found['lost']:.0f} of {len(trace.log.time)} pings lost\n{account(trace).headline}"
    )
    draw_head(trace.log, figure)
    figure.suptitle(title, fontsize=9)


def film(trace: Trace, _: tuple[str, ...] | None) -> Film:
    """Return the film of a run: where target and head point, and the spikes of both ears."""
    log = trace.log
    x, y = log.distance * np.cos(log.target), log.distance * np.sin(log.target)
    zero, far = np.zeros(log.time.size), float(np.max(log.distance))
    across = Shape(role="way", points=((0.0, -far), (0.0, far)), closed=False, name="azimuth of 90 deg")
    tracks = (
        Track(name="head", time=log.time, x=zero, y=zero, heading=log.head, radius=0.03 * far),
        Track(name="target", time=log.time, x=x, y=y, radius=0.02 * far, role="moving"),
    )
    azimuths = tuple(
        Line(name=name, time=log.time, value=np.degrees(value), step=name == "head")
        for name, value in (("target", log.target), ("head", log.head))
    )
    return Film(
        title="",
        headline="",
        duration=trace.scenario.duration,
        world=Stage(unit="m", shapes=(across,), tracks=tracks),
        panels=(
            Panel(title="azimuth", unit="deg", lines=azimuths),
            Panel(title="LSO neurons", raster=_raster(log.spikes, 1)),
            Panel(title="level units of the ears", raster=_raster(log.levels, LEVELS)),
        ),
    )


def _raster(spikes: F64, count: int) -> Raster:
    """Spikes (s, side, and unit where a side has `count` of them) of both sides."""
    times, *where = spikes[np.argsort(spikes[:, 0], kind="stable")].T
    row = (where[0] * count + (where[1] if count > 1 else 0.0)).astype(np.int64)
    sides = ("left", "right")
    rows = tuple(f"level {k}" if count > 1 else side for side in sides for k in range(count))
    groups = tuple(Group(f"{side} ear", k * count, count) for k, side in enumerate(sides) if count > 1)
    return Raster(time=times, row=row, rows=rows, groups=groups)


SYSTEM = System(
    name="head",
    summary="sonar head that turns to a moving target by its two ears (Cheely & Horiuchi 2003)",
    kind=Scenario,
    success=SUCCESS,
    run=run,
    account=account,
    numbers=summarise,
    draw=draw,
    film=film,
    ideal=IDEAL_CHIP,
    study_metrics=("error_rms_deg", "lost"),
    open=open_head,
    document=document,
    meanings=of_run(SUMMARY, DOCUMENT),
    title=lambda trace: f"{trace.scenario.motion}, {trace.scenario.wiring}",
    after=unanswered,
    outputs={"spikes": spikes_output("the spikes of both LSO neurons", spike_trains)},
    circuits=circuits,
)
