"""Sonar head: two ears on a servo neck that turn to a moving target (Cheely & Horiuchi 2003, Figure 7).

call -> echo at two ears -> envelopes -> level units -> two LSO neurons, excited by one ear and inhibited by
the other -> spikes of the left less those of the right -> neck. Level units and neurons are those of a die.

A run follows one target for a while. The paper has no numbers of its own for this: see
`system.head.numbers`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from chips.lso.measure import circuits
from chips.lso.model import RECORD, Head, head_on
from chips.lso.noise import LsoNoise, noise_of
from chips.record import current_record
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.silicon import Silicon
from system.head.ear import SPEED, hearing
from system.head.loop import COUNTS, LOST, WIRINGS, Log, follow
from system.head.numbers import Motion, SonarHead
from system.head.picture import draw_head
from system.head.world import MOTIONS, way_of
from system.option import bias_kind_option, check_options, die_option, option, seed_option, temperature_option
from system.options.block import describe_run
from system.options.noise import Noisy, check_noise, noise_option, noise_seed_option, silicon_noise
from system.system import Account, System, metrics_with

ROOM_TEMPERATURE = 27.0  # degC
DURATION = 20.0  # s, two periods of the sine; ours
SUMMARY = (
    "error_rms_deg", "settled_rms_deg", "error_max_deg", "spikes_a_ping", "lost", *COUNTS, "deaf_levels",
)  # fmt: skip
SETTLED, ANSWERED = 5.0, 0.9  # deg rms of the second half, share of the pings; ours
SUCCESS = (
    f"in the second half it points at the target within {SETTLED:g} degrees rms, and"
    f" {100.0 * ANSWERED:g} % of its pings have an answer"
)


@dataclass(frozen=True, slots=True)
class Scenario:
    """What a head is asked to do: a motion of `MOTIONS` for a time (s), with one of `WIRINGS`.

    area: of the chip's devices over the circuits'; silicon_noise: of these, by `noise_seed`, `seed` unless
    given.
    """

    head: SonarHead = field(default_factory=SonarHead)
    target: Motion = field(default_factory=Motion)
    motion: str = option(MOTIONS[0], "Of the target", choices=MOTIONS, study=True)
    wiring: str = option(
        WIRINGS[0],
        "Excitation has no inhibition, one-ear is against what is usual",
        choices=WIRINGS,
        study=True,
    )
    duration: float = option(DURATION, "Length of the run", unit="s", study=True)
    area: float = option(1.0, "Of the chip's devices, relative, from 1/16", unit="", above=0.0, study=True)
    bias_kind: BiasKind | None = bias_kind_option(None)
    silicon_noise: Noisy = noise_option()
    noise_seed: int | None = noise_seed_option()
    seed: int = seed_option()
    die: Die = die_option(NOMINAL)
    temperature_c: float = temperature_option(ROOM_TEMPERATURE)

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the field that breaks its rule."""
        check_options(self)
        check_noise(self.silicon_noise, self.noise_seed)
        if not self.head.period <= self.duration < math.inf:
            raise ParameterError(
                f"duration: {self.duration:g} s, must be at least a ping's period,"
                f" {self.head.period:g} s, and finite"
            )
        self._check_delay()

    def _check_delay(self) -> None:
        """Refuse pings that come before the last one's echo was counted."""
        farthest = self.target.distance + self.target.swing
        delay, last = 2.0 * farthest / SPEED, self.head.decision * self.head.period
        if delay >= last:
            raise ParameterError(
                f"ping_rate: {self.head.ping_rate:g} Hz, an echo from {farthest:g} m takes {delay:.3g} s,"
                f" must be below {self.head.decision:g} of a period, {last:.3g} s; ping less often"
            )

    @property
    def silicon(self) -> Silicon:
        """Process, temperature and die."""
        return Silicon(temperature_c=self.temperature_c, die=self.die)

    def noise(self, chip: Head) -> LsoNoise | None:
        """Noise of a chip on the silicon."""
        seed = self.seed if self.noise_seed is None else self.noise_seed
        noise = silicon_noise(self.silicon_noise, seed)
        return None if noise is None else noise_of(chip, self.silicon, noise, self.area)


@dataclass(frozen=True, slots=True)
class Trace:
    """A run, and the numbers of the die that it was on."""

    scenario: Scenario
    chip: Head
    log: Log


def run(scenario: Scenario, progress: Callable[[float], None] | None = None) -> Trace:
    """Follow a target; way and noise are the seed's, each by a generator of its own."""
    s = scenario
    chip = head_on(s.silicon, s.bias_kind or "gate", s.area)
    way_random, noise_random = (np.random.default_rng((s.seed, k)) for k in range(2))
    way = way_of(s.motion, s.target, s.duration + s.head.period, way_random)
    log = follow(s.head, chip, way, s.duration, noise_random, s.wiring, progress, s.noise(chip))
    return Trace(s, chip, log)


def summarise(trace: Trace) -> dict[str, float | None]:
    """Scalars of a run; settled: its second half."""
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
    """What a run says of itself: it follows its target or does not, until its time is over."""
    s, found = trace.scenario, summarise(trace)
    settled, lost = found["settled_rms_deg"], found["lost"]
    answered = 1.0 - (lost or 0.0) / len(trace.log.time)
    return Account(
        succeeded=settled is not None and settled <= SETTLED and answered >= ANSWERED,
        reason=f"time of {s.duration:g} s over",
        ran_on={
            "wiring": s.wiring,
            "area": s.area,
            "silicon_noise": s.silicon_noise,
            **describe_run(s.die, s.temperature_c, s.bias_kind or "gate"),
        },
    )


def document(trace: Trace) -> dict[str, Any]:
    """Entries of JSON that are the run's own."""
    s, log = trace.scenario, trace.log
    return {
        "bias_kind": s.bias_kind or "gate",
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


def unanswered(trace: Trace) -> tuple[str, ...]:
    """A line on pings without an answer, where there are any."""
    lost = {name: trace.log.counts[name] for name in LOST if trace.log.counts[name]}
    if not lost:
        return ()
    return ("pings without an answer: " + ", ".join(f"{n} {name}" for name, n in lost.items()),)


def draw(trace: Trace, figure: Figure) -> None:
    """Fill a figure with angles and rasters over time."""
    s, found = trace.scenario, summarise(trace)
    title = (
        f"{s.motion}, {s.wiring}, {s.die}, {s.temperature_c:g} degC:"
        f" error {found['error_rms_deg']:.1f} deg rms,"
        f" {found['lost']:.0f} of {len(trace.log.time)} pings lost\n{account(trace).headline}"
    )
    draw_head(trace.log, figure)
    figure.suptitle(title, fontsize=9)


SYSTEM = System(
    name="head",
    summary="sonar head that turns to a moving target by the level difference of its ears",
    about="A sonar head turns to a moving target by its two ears (Cheely & Horiuchi 2003).",
    success=SUCCESS,
    kind=Scenario,
    run=run,
    account=account,
    numbers=summarise,
    draw=draw,
    metrics=metrics_with(SUMMARY),
    study_metrics=("error_rms_deg", "lost"),
    document=document,
    title=lambda trace: f"{trace.scenario.motion}, {trace.scenario.wiring}",
    after=unanswered,
    circuits=circuits,
)
