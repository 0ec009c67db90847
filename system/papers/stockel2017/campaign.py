"""What dies, neurons, area and temperature do to Bug 0 and the improved Bug 2 on the NEF chip.

No figure of the paper, which has no chip. Robots drive on `bug-field`, for at most 100 s (an unhindered one
needs about 55), and the shares that reach the goal are compared between conditions. Die k has the network of
seed k, both from 5000 on. One quantity is changed at a time about the design: 27
degC, ideal biases, the areas as drawn. Away from 27 degC a chip is used in one of three ways:

* held: biases and decoders stay as they were at 27 degC;
* solved: biases stay, decoders are solved from curves counted at the new temperature; where a neuron cannot
  fire as fast as its network asks there is none, and the die counts as refused, and as one not reached;
* calibrated: biases are trimmed there too.

Rules (ours, set after runs on dies 900 to 902, those on area with fixed gates), for Bug 0: calibrated at 7
and 47 degC it reaches the goal on 90 % of dies with both kinds of biases, as a sixteenth of the area still
does; held 2 degC from 27 it does so on fewer dies with fixed gates than with ideal currents. For Bug 2: a
quarter of the neurons reach on fewer dies.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from importlib.metadata import version
from statistics import median

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from circuits.arrays import I64
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import Die
from system.bug.run import run, summarise
from system.bug.scenario import Scenario
from system.experiment import Experiment, Progress, Report
from system.plot import COLOURS, draw_estimates
from system.rule import apart_below, at_least
from system.statement import Statement
from system.study.campaign import ALONE, Campaign, Execution, Numbered
from system.study.statistics.share import Share
from system.verdict.null import Null, nulls_of, shuffled

FIRST, DIES, DURATION = 5000, 10, 100.0  # first die, how many, s
HOME = 27.0  # degC
KINDS: tuple[BiasKind, ...] = ("ideal", "gate")
HELD, SOLVED, CALIBRATED = "held", "solved", "calibrated"
NEURONS = {"bug0": (512, 1025, 2050, 4100, 8000), "bug2": (1665, 3330, 5000, 6660, 8000)}
DESIGN = {"bug0": 2050, "bug2": 6660}
AREAS = (0.0625, 0.25, 1.0, 4.0, 16.0)
NEAR = (17.0, 22.0, 25.0, 27.0, 29.0, 32.0, 37.0)  # degC, held
FAR = (7.0, 27.0, 47.0)  # degC, solved and calibrated
ENOUGH = 0.9
STILL, THERE, DRAWN = "never moves", "always reaches the goal", "conditions drawn anew"
NULLS = (STILL, THERE, DRAWN)


@dataclass(frozen=True, slots=True)
class Condition:
    """Where a robot's chip is used, and how large it is."""

    agent: str
    neurons: int
    area: float = 1.0
    kind: BiasKind = "ideal"
    use: str = HELD
    temperature_c: float = HOME

    def scenario(self, number: int) -> Scenario:
        """On a die."""
        at, whole = self.temperature_c, self.use == CALIBRATED
        return Scenario(
            self.agent, "chip", "improved" if self.agent == "bug2" else "published",
            None if self.neurons == DESIGN[self.agent] else self.neurons, map="bug-field", duration=DURATION,
            seed=number, die=Die(number=number), temperature_c=at, calibrated_c=at if whole else HOME,
            solved_c=HOME if self.use == HELD else at, bias_kind=self.kind, area=self.area, law="ideal",
        )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Drive:
    """What a run came to: time (s) and path over the shortest if it reached; clips; 1 if it was refused."""

    reached: bool
    time_s: float | None
    path_ratio: float | None
    clipped: int
    refused: int


@dataclass(frozen=True, slots=True)
class Outcome:
    """Of runs: how many reached; of those time (s) and path over the shortest; clips; refused dies."""

    share: Share
    times: tuple[float, ...]
    ratios: tuple[float, ...]
    clipped: int
    refused: int = 0

    def __str__(self) -> str:
        if not self.times:
            return str(self.share)
        way = f"{median(self.ratios):.2f} of the shortest way"
        return f"{self.share}, median {median(self.times):.1f} s and {way}"


Found = Mapping[Condition, Outcome]


def conditions(agent: str) -> list[Condition]:
    """List all conditions of an agent, each once."""
    size = DESIGN[agent]
    every = [
        *(Condition(agent, n) for n in NEURONS[agent]),
        *(Condition(agent, size, a) for a in AREAS),
        *(Condition(agent, size, 1.0, kind, HELD, t) for kind in KINDS for t in NEAR),
        *(
            Condition(agent, size, 1.0, kind, use if t != HOME else HELD, t)
            for kind in KINDS for use in (SOLVED, CALIBRATED) for t in FAR
        ),
    ]  # fmt: skip
    return list(dict.fromkeys(every))


def reproduce(progress: Progress, execution: Execution = ALONE, dies: int = DIES) -> Report:
    """Drive in all conditions on the same dies."""
    every = by_name()
    keys = [Numbered(name, FIRST + k) for name in every for k in range(dies)]
    numbers = (version("noctule"), DURATION, *every.values())
    campaign = Campaign(EXPERIMENT.name, drive_one, Numbered, Drive, numbers)
    kept = execution.by_condition(campaign, keys, progress)
    found = {condition: outcome(kept[name]) for name, condition in every.items()}
    notes = tuple(f"{described(c)}: {o}; {o.clipped} clipped, {o.refused} refused" for c, o in found.items())
    return Report(rows(found), lambda figure: _draw(found, figure), notes, _nulls(found))


def _nulls(found: Found) -> tuple[Null, ...]:
    """Robots that never reach, and always do, and conditions whose outcomes change their places."""
    every = list(found.values())
    never, always = (
        {c: replace(o, share=Share(reached * o.share.of, o.share.of)) for c, o in found.items()}
        for reached in (0, 1)
    )

    def drawn(order: I64) -> Found:
        return dict(zip(found, [every[k] for k in order], strict=True))

    return (
        *nulls_of(rows, {STILL: never, THERE: always}),
        shuffled(DRAWN, rows, drawn, len(every)),
    )


def outcome(kept: Sequence[Drive]) -> Outcome:
    """Sum up the runs of a condition."""
    there = [r for r in kept if r.reached]
    return Outcome(
        Share(len(there), len(kept)),
        tuple(float(r.time_s or 0.0) for r in there),
        tuple(float(r.path_ratio or 0.0) for r in there),
        sum(r.clipped for r in kept),
        sum(r.refused for r in kept),
    )


def drive_one(key: Numbered) -> Drive:
    """Drive in the condition of a name on the die of a number; refused where biases leave no network."""
    condition = by_name()[key[0]]
    try:
        trace = run(condition.scenario(key[1]))
    except ParameterError:
        if condition.use != SOLVED:
            raise
        return Drive(reached=False, time_s=None, path_ratio=None, clipped=0, refused=1)
    said = summarise(trace)
    clipped = int((trace.chip or {}).get("clipped", 0))
    return Drive(bool(trace.reached), said["time_s"], said["path_ratio"], clipped, 0)


@lru_cache(maxsize=1)
def by_name() -> dict[str, Condition]:
    """List all conditions of both agents by name."""
    return {described(c): c for agent in DESIGN for c in conditions(agent)}


def described(c: Condition) -> str:
    """Describe a condition in words."""
    size = f"{c.neurons} neurons, area {c.area:g}"
    return f"{c.agent}, {size}, {c.kind}, {c.use} at {c.temperature_c:g} degC"


def rows(found: Found) -> tuple[Statement, ...]:
    """Make the statements about calibration, area, temperature and the number of neurons."""
    size, few = DESIGN["bug0"], NEURONS["bug2"][0]
    base = Condition("bug0", size)
    far = [t for t in FAR if t != HOME]
    return (
        *(
            _enough(f"bug0_calibrated_7_and_47_degC_{kind}_share", [
                found[replace(base, kind=kind, use=CALIBRATED, temperature_c=t)] for t in far
            ])
            for kind in KINDS
        ),
        _enough("bug0_area_1_16_share", [found[replace(base, area=AREAS[0])]]),
        *(
            _fewer(
                f"bug0_held_at_{t:g}_degC_gate_share",
                found[replace(base, kind="gate", temperature_c=t)],
                found[replace(base, temperature_c=t)],
            )
            for t in (25.0, 29.0)
        ),
        _fewer(
            "bug2_quarter_of_the_neurons_share", found[Condition("bug2", few)],
            found[Condition("bug2", DESIGN["bug2"])],
        ),
    )  # fmt: skip


def _enough(name: str, held: Sequence[Outcome]) -> Statement:
    worst = min(held, key=lambda o: o.share.value)
    return Statement(name, None, worst.share.value, at_least(ENOUGH).beside(worst))


def _fewer(name: str, less: Outcome, more: Outcome) -> Statement:
    """Intervals must be apart."""
    rule = apart_below(more.share, "below {limit:g}, 95 % intervals apart").beside(less)
    return Statement(name, None, less.share.measured(less.share.value), rule)


def _draw(found: Found, figure: Figure) -> None:
    """Share that reaches over neurons, area and temperature, a row an agent."""
    figure.set_size_inches(11.0, 5.6)
    axes = figure.subplots(2, 4, sharey=True)
    for line, agent in zip(axes, DESIGN, strict=True):
        base = Condition(agent, DESIGN[agent])
        sweep(line[0], {float(n): found[replace(base, neurons=n)] for n in NEURONS[agent]}, "", COLOURS[0])
        sweep(line[1], {a: found[replace(base, area=a)] for a in AREAS}, "", COLOURS[0])
        for ax, kind in zip(line[2:], KINDS, strict=True):
            for colour, use in zip(COLOURS, (HELD, SOLVED, CALIBRATED), strict=False):
                at = {
                    t: found[replace(base, kind=kind, use=use if t != HOME else HELD, temperature_c=t)]
                    for t in (NEAR if use == HELD else FAR)
                }
                sweep(ax, at, use, colour)
            ax.set_xlabel(f"temperature (degC), {kind}", fontsize=8)
        line[0].set_xlabel("neurons", fontsize=8)
        line[1].set_xlabel("area of devices", fontsize=8)
        for ax in line[:2]:
            ax.set_xscale("log")
        line[0].set_ylabel(f"{agent}\nshare that reaches")
    figure.legend(*axes[0, 2].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)


def sweep(ax: Axes, held: Mapping[float, Outcome], label: str, colour: str) -> None:
    """Draw shares with their intervals."""
    look = {"color": colour, "marker": "o", "markersize": 3, "capsize": 2, "label": label}
    draw_estimates(list(held), [o.share for o in held.values()], look, ax)
    ax.set_ylim(-0.03, 1.05)


EXPERIMENT = Experiment(
    "stockel2017-campaign", "Bug robots on the NEF chip over dies, neurons, area and temperature", reproduce,
    {"dies": DIES}, NULLS,
)  # fmt: skip
