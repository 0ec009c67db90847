"""Sonar head: two ears on a servo neck that turn to a moving target (Cheely & Horiuchi 2003, Figure 7).

call -> echo at two ears -> envelopes -> level units -> two LSO neurons, excited by one ear and inhibited by
the other -> spikes of the left less those of the right -> neck. Level units and neurons are those of a die.

A run follows one target for a while. The paper has no numbers of its own for this: see
`system.head.numbers`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from chips.lso.measure import circuits
from chips.lso.model import Head, head_on
from chips.lso.noise import LsoNoise, noise_of
from circuits.circuit import BiasKind, Circuit
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.silicon import Silicon
from system.head.ear import SPEED, hearing
from system.head.loop import COUNTS, LOST, WIRINGS, Log, follow
from system.head.numbers import Motion, SonarHead
from system.head.picture import draw_head
from system.head.world import MOTIONS, way_of
from system.options.block import describe_run
from system.options.noise import Noisy, check_noise, silicon_noise
from system.reader import In, Readers, metres, number, read_route, read_texts, seconds, whole, words
from system.scenario import scenario_of
from system.system import SUCCEEDED, Account, Summary, metrics_with, summary_of

ROOM_TEMPERATURE = 27.0  # degC
DURATION = 20.0  # s, two periods of the sine; ours
SUMMARY = (
    "error_rms_deg", "settled_rms_deg", "error_max_deg", "spikes_a_ping", "lost", *COUNTS, "deaf_levels",
)  # fmt: skip
QUANTITIES: Readers = {
    "duration": seconds, "area": number, "ping_rate": In("Hz"), "gain": In("deg"), "noise": number,
    "azimuth": In("deg"), "period": seconds, "distance": metres, "swing": metres,
}  # fmt: skip
SETTLED, ANSWERED = 5.0, 0.9  # deg rms of the second half, share of the pings; ours
SUCCESS = (
    f"in the second half it points at the target within {SETTLED:g} degrees rms, and"
    f" {100.0 * ANSWERED:g} % of its pings have an answer"
)
STUDIED: Readers = {
    **QUANTITIES, "motion": words, "wiring": words, "silicon_noise": words, "noise_seed": whole,
}  # fmt: skip
# options of the command line: field, and its unit in SI
_HEAD = {"ping_rate": ("ping_rate", 1.0), "gain": ("gain", math.radians(1.0)), "noise": ("ear_noise", 1.0)}
_MOTION = {
    "azimuth": ("azimuth", math.radians(1.0)), "period": ("period", 1.0), "distance": ("distance", 1.0),
    "swing": ("swing", 1.0),
}  # fmt: skip
PARTS = {"head": tuple(_HEAD), "target": tuple(_MOTION)}  # options of these fields


@dataclass(frozen=True, slots=True)
class Scenario:
    """What a head is asked to do: a motion of `MOTIONS` for a time (s), with one of `WIRINGS`.

    area: of the chip's devices over the circuits'; silicon_noise: of these, by `noise_seed`, `seed` unless
    given.
    """

    head: SonarHead = field(default_factory=SonarHead)
    target: Motion = field(default_factory=Motion)
    motion: str = MOTIONS[0]
    wiring: str = WIRINGS[0]
    duration: float = DURATION
    area: float = 1.0
    bias_kind: BiasKind | None = None
    silicon_noise: Noisy = "off"
    noise_seed: int | None = None
    seed: int = 0
    die: Die = NOMINAL
    temperature_c: float = ROOM_TEMPERATURE

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the option that breaks its rule."""
        if self.motion not in MOTIONS:
            raise ParameterError(
                f"--motion: {self.motion}, must be {', '.join(MOTIONS[:-1])} or {MOTIONS[-1]}"
            )
        if self.wiring not in WIRINGS:
            raise ParameterError(
                f"--wiring: {self.wiring}, must be {', '.join(WIRINGS[:-1])} or {WIRINGS[-1]}"
            )
        check_noise(self.silicon_noise, self.noise_seed)
        if self.seed < 0:
            raise ParameterError(f"--seed: {self.seed}, must be >= 0")
        if not (math.isfinite(self.area) and self.area > 0.0):
            raise ParameterError(f"--area: {self.area:g} times the circuits', must be > 0")
        if not self.head.period <= self.duration < math.inf:
            raise ParameterError(
                f"--duration: {self.duration:g} s, must be at least a ping's period,"
                f" {self.head.period:g} s, and finite"
            )
        self._check_delay()

    def _check_delay(self) -> None:
        """Refuse pings that come before the last one's echo was counted."""
        farthest = self.target.distance + self.target.swing
        delay, last = 2.0 * farthest / SPEED, self.head.decision * self.head.period
        if delay >= last:
            raise ParameterError(
                f"--ping-rate: {self.head.ping_rate:g} Hz, an echo from {farthest:g} m takes {delay:.3g} s,"
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


def read_options(options: Mapping[str, Any]) -> dict[str, Any]:
    """Fields of a scenario from those of the command line; gain in deg a spike, azimuth in deg."""
    fields = read_texts(options, QUANTITIES)
    found: list[dict[str, float]] = []
    for table in (_HEAD, _MOTION):
        numbers = {}
        for option, (name, unit) in table.items():
            if option in fields:
                value = float(fields.pop(option))
                _check_option(option, value)
                numbers[name] = value * unit
        found.append(numbers)
    return {**fields, "head": SonarHead(**found[0]), "target": Motion(**found[1])}


def _check_option(option: str, value: float) -> None:
    shown = option.replace("_", "-")
    if option in ("gain", "noise", "swing", "azimuth"):
        if not 0.0 <= value < math.inf:
            raise ParameterError(f"--{shown}: {value:g}, must be >= 0 and finite")
    elif not 0.0 < value < math.inf:
        raise ParameterError(f"--{shown}: {value:g}, must be > 0 and finite")


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


@dataclass(frozen=True, slots=True)
class SonarHeadSystem:
    """The system as the command line sees it."""

    name: str = "head"
    summary: str = "sonar head that turns to a moving target by the level difference of its ears"
    success: str = SUCCESS
    metrics: tuple[str, ...] = metrics_with(SUMMARY)
    yes_no: tuple[str, ...] = (SUCCEEDED,)
    study_metrics: tuple[str, ...] = ("error_rms_deg", "lost")  # unless others are asked for

    def scenario(self, **options: Any) -> Scenario:
        """A scenario of these fields, or of options as the command line has them."""
        return scenario_of(self.name, Scenario, options, read_options, PARTS)

    def study_options(
        self, level: str, bias_kind: BiasKind | None, route: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Fields of a study's scenario."""
        if level != "behavioural":
            raise ParameterError("--level: the head's chip is a behavioural model; leave it out")
        given = read_route(self.name, route, STUDIED)
        return given if bias_kind is None else {**given, "bias_kind": bias_kind}

    def circuits(self) -> tuple[Circuit, ...]:
        """What its chip is made of."""
        return circuits()

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
        """Fill a figure with angles and rasters over time."""
        s, found = trace.scenario, summarise(trace)
        title = (
            f"{s.motion}, {s.wiring}, {s.die}, {s.temperature_c:g} degC:"
            f" error {found['error_rms_deg']:.1f} deg rms,"
            f" {found['lost']:.0f} of {len(trace.log.time)} pings lost\n{account(trace).headline}"
        )
        draw_head(trace.log, figure)
        figure.suptitle(title, fontsize=9)


SYSTEM = SonarHeadSystem()
