"""What an approach leaves: its arrays over time, its numbers, its account and its picture.

The picture is that of Figure 11 of Cheely & Horiuchi 2003.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from chips.ranging import circuit as ranging_chip
from circuits.arrays import F64
from circuits.blocks.sonar import centroid_board
from system.approach.scenario import BOXES, Box, Scenario, air_of
from system.meaning import meanings
from system.options.block import describe_run
from system.options.codes import described
from system.options.noise import NOISELESS
from system.options.temperature import temperature_text
from system.plot import COLOURS, INK, PALE, die_label
from system.spikes.output import trains_of
from system.system import Account, RunTrace
from system.worlds.sound.acoustics import speed_of_sound
from system.worlds.sound.microphone import Microphone
from system.worlds.sound.targets import range_at

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, slots=True)
class Trace(RunTrace[Scenario]):
    """A run's arrays on a 10 ms grid and its events.

    time_s, range_m (first target's), estimate_m, proximity_V, call_rate_Hz (inverse of the last interval,
    NaN before there are two calls), call_amplitude_V (amplitude stage): float64[T]. calls: float64[calls, 2],
    time and amplitude. pulses, echoes: high-threshold and onset spikes, s; spikes: (time s, neuron).

    counts : counters of the run by name, such as `solver_steps` and `undecided_spikes`.
    """

    time_s: F64
    range_m: F64
    estimate_m: F64
    proximity_V: F64  # noqa: N815 - the name in JSON, with its unit
    call_rate_Hz: F64  # noqa: N815
    call_amplitude_V: F64  # noqa: N815
    calls: F64
    pulses: F64
    echoes: F64
    spikes: tuple[tuple[float, int], ...]
    counts: dict[str, int]


def estimated_range(proximity: F64, scenario: Scenario) -> F64:
    """Range that the linear look-up assigns to a proximity voltage, m.

    proximity: float64[T], V. Below the last entry the line goes on to the far default at 0 V.
    """
    table = centroid_board.linear_lookup()
    delays = ranging_chip.BEST_DELAYS
    slope = (delays[-1] - delays[0]) / (table[0] - table[-1])
    delay = delays[0] + slope * (table[0] - proximity)
    mouth_ear = Microphone().mouth_ear_delay
    speed = speed_of_sound(air_of(scenario).temperature)
    return np.asarray(0.5 * speed * (delay + mouth_ear))


SUMMARY = meanings("""
calls                   number   -   calls that were made
spikes                  number   -   spikes of the 13 neurons together
first_call_s            number?  s   time of the first call
shortest_interval_s     number?  s   shortest time between two calls
longest_best_delay_s    number   s   delay of an echo to which the neuron with the longest one answers best
call_rate_first_Hz      number?  Hz  call rate at the second call: the inverse of the first interval
call_rate_last_Hz       number?  Hz  call rate at the end
call_amplitude_first_V  number   V   amplitude of a call at the start
call_amplitude_last_V   number   V   amplitude of a call at the end
range_error_mean_m      number?  m   mean of the estimate's distance from the first target's range, after 1 s
range_error_max_m       number?  m   the greatest of it, after 1 s
held_fraction           number?  -   share of the time after 1 s in which the estimate is nearer to the first
                                     target than to any other; null where there is no other
""")
DOCUMENT = meanings("""
targets                   string[]    -   names of the targets, the first of which is to be held
noisy_boxes               string[]    -   boxes whose devices make noise in this run
time_s                    number[]    s   times of the arrays below, every 10 ms
range_m                   number[]    m   true range of the first target
estimate_m                number[]    m   range that the proximity voltage stands for
proximity_V               number[]    V   proximity voltage, the centroid board's output
call_rate_Hz              number?[]   Hz  inverse of the interval between the last two calls
call_amplitude_V          number[]    V   amplitude that a call would have
calls_s                   number[]    s   times of the calls
pulses_s                  number[]    s   times of spikes of the high-threshold neuron: the chip's call
echoes_s                  number[]    s   times of spikes of the onset neuron: the chip's echo
spikes                    object[]    -   spikes of the range-tuned neurons
spikes.time_s             number      s   when it came
spikes.neuron             integer     -   which neuron, from 0 with the shortest best delay on
counts                    object      -   counters of the run
counts.solver_steps       integer     -   steps of the circuit solver in boxes at transistor level
counts.merged_events      integer     -   events that came within another's pulse and became one with it
counts.repeated_advances  integer     -   times that a box was moved again, since another spoke earlier
counts.clipped_samples    integer     -   samples of the microphone that were cut off
counts.undecided_sounds   integer     -   onsets that the behavioural hearing could not decide
counts.clipped_sounds     integer     -   sounds whose envelope was cut off
counts.undecided_spikes   integer     -   spikes that the behavioural chip could not decide
summary.ran_on.transistors  string?   -   boxes that are kept as transistors, with commas between them
""")
SETTLED = 1.0  # s, time given to find the target before errors count; ours
HELD = 0.9  # of the time after SETTLED, that the target must be held; ours
NEAR = 0.5  # m, largest mean error where nothing else reflects: windows are 0.36 m apart; ours
SUCCESS = (
    f"after the first {SETTLED:g} s the estimate is nearer to the first target than to any other reflector"
    f" for {100.0 * HELD:g} % of the time, or, where there is no other, off by {NEAR:g} m on average at most"
)


def summarise(trace: Trace) -> dict[str, float | None]:
    """Return the numbers of a run, in SI units that their names end with; None where not defined.

    `held_fraction`: share of the time after the first second in which the estimate is nearer to the first
    target than to any other reflector.
    """
    interval = np.diff(trace.calls[:, 0])
    late = trace.time_s >= SETTLED
    error = np.abs(trace.estimate_m - trace.range_m)[late]
    rate = trace.call_rate_Hz[np.isfinite(trace.call_rate_Hz)]
    others = [range_at(t.trajectory, trace.time_s[late]) for t in trace.scenario.targets[1:]]
    nearest = (
        np.min([np.abs(trace.estimate_m[late] - r) for r in others], axis=0)
        if others and late.any()
        else None
    )
    return {
        "calls": float(len(trace.calls)),
        "spikes": float(len(trace.spikes)),
        "first_call_s": float(trace.calls[0, 0]) if len(trace.calls) else None,
        "shortest_interval_s": float(interval.min()) if interval.size else None,
        "longest_best_delay_s": ranging_chip.BEST_DELAYS[-1],
        "call_rate_first_Hz": float(rate[0]) if rate.size else None,
        "call_rate_last_Hz": float(rate[-1]) if rate.size else None,
        "call_amplitude_first_V": float(trace.call_amplitude_V[0]),
        "call_amplitude_last_V": float(trace.call_amplitude_V[-1]),
        "range_error_mean_m": float(error.mean()) if error.size else None,
        "range_error_max_m": float(error.max()) if error.size else None,
        "held_fraction": None if nearest is None else float((error < nearest).mean()),
    }


def _parts(scenario: Scenario) -> dict[str, str]:
    """What each box was."""
    levels = {"transistor": "its transistors", "behavioural": "its measured model"}
    names = {"chip": "ranging chip", "centroid": "centroid board", "vocalization": "vocalization board"}
    boxes: tuple[Box, ...] = tuple(box for box in BOXES if box != "isolation" or scenario.isolation)
    found = {names.get(box, box): levels[scenario.level_of(box)] for box in boxes}
    return {**found, "targets, air and microphone": "programs; no chip is that"}


def account(trace: Trace) -> Account:
    """Say whether the sonar held its target; a run ends when its time is over."""
    s, found = trace.scenario, summarise(trace)
    held, error = found["held_fraction"], found["range_error_mean_m"]
    near = error is not None and error <= NEAR
    return Account(
        succeeded=near if held is None else held >= HELD,
        reason=f"time of {s.duration:g} s over",
        ran_on={
            "level": s.level,
            "transistors": ", ".join(sorted(s.transistors)) or None,
            "isolation": s.isolation,
            "amplitude_law": s.amplitude_law,
            **described(s),
            "silicon_noise": s.silicon_noise,
            NOISELESS: ", ".join(s.noiseless_boxes) or None,
            **describe_run(s),
        },
        parts=_parts(s),
        outside=trace.outside,
    )


def document(trace: Trace) -> dict[str, Any]:
    """Return the entries that only this system's JSON document has, by their keys.

    The counters of a run stand beside its numbers.
    """
    arrays = ("time_s", "range_m", "estimate_m", "proximity_V", "call_rate_Hz", "call_amplitude_V")
    return {
        "noisy_boxes": trace.scenario.noisy_boxes,
        "targets": [t.name for t in trace.scenario.targets],
        **{name: getattr(trace, name) for name in arrays},
        "calls_s": trace.calls[:, 0],
        "pulses_s": trace.pulses,
        "echoes_s": trace.echoes,
        "spikes": [{"time_s": time, "neuron": neuron} for time, neuron in trace.spikes],
        "counts": trace.counts,
    }


def spike_trains(trace: Trace) -> tuple[dict[str, F64], float]:
    """Return the spikes of the range-tuned neurons, then those of both hearing neurons, s; and the end, s."""
    times = np.array([time for time, _ in trace.spikes])
    neurons = np.array([neuron for _, neuron in trace.spikes], dtype=np.int64)
    trains = trains_of("neuron", ranging_chip.NEURONS, times, neurons)
    return {**trains, "high_threshold": trace.pulses, "onset": trace.echoes}, trace.scenario.duration


def title(trace: Trace) -> str:
    """Return the heading of the table of a run's numbers."""
    s = trace.scenario
    return f"{s.level} level, {temperature_text(s.temperature_c, s.course)} degC, {s.die}"


def draw(trace: Trace, figure: Figure) -> None:
    """Fill `figure` as in Figure 11: range, proximity voltage, and the calls with amplitude and rate."""
    axes = figure.subplots(4, 1, sharex=True)
    axes[0].set_title(account(trace).headline, fontsize=9)
    axes[0].plot(trace.time_s, trace.range_m, color=PALE, lw=3, label=trace.scenario.targets[0].name)
    for other in trace.scenario.targets[1:]:
        axes[0].plot(
            trace.time_s,
            range_at(other.trajectory, trace.time_s),
            color=PALE,
            lw=1,
            ls="--",
            label=other.name,
        )
    label = f"estimate, {die_label(trace.scenario.die)}"
    axes[0].plot(trace.time_s, trace.estimate_m, color=COLOURS[0], label=label)
    axes[0].set_ylabel("range (m)")
    axes[0].legend(loc="upper right", ncols=2, fontsize="small")
    axes[1].plot(trace.time_s, trace.proximity_V, color=COLOURS[0])
    axes[1].set_ylabel("proximity (V)")
    if len(trace.calls):
        axes[2].vlines(trace.calls[:, 0], 0.0, trace.calls[:, 1], color=COLOURS[1], lw=0.8)
    axes[2].set_ylabel("call (V)")
    axes[2].set_ylim(bottom=0.0)
    axes[3].plot(trace.time_s, trace.call_rate_Hz, color=COLOURS[1], drawstyle="steps-post")
    axes[3].set_ylabel("call rate (Hz)")
    axes[3].set_ylim(bottom=0.0)
    axes[3].set_xlabel("time (s)")
    figure.align_ylabels(axes)


def draw_beside(trace: Trace, figure: Figure) -> None:
    """Draw the estimate and the proximity voltage of another run over a picture of `draw`."""
    axes = figure.axes
    own: dict[str, Any] = {"color": INK, "ls": ":", "zorder": 1}
    axes[0].plot(trace.time_s, trace.estimate_m, label=f"estimate, {die_label(trace.scenario.die)}", **own)
    axes[0].legend(loc="upper right", ncols=2, fontsize="small")
    axes[1].plot(trace.time_s, trace.proximity_V, **own)
    axes[3].plot(trace.time_s, trace.call_rate_Hz, drawstyle="steps-post", **own)
