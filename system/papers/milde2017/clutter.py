"""Section 3.4, Figures 10 and 11 of Milde et al. 2017: 8 to 12 blocks, plain and modified architecture.

In the paper, at 0.35 m/s the plain network touches two of the obstacles in its figure's run; the modified one
avoids collisions at 0.5 m/s. Here both networks drive through the same scenes on the same dies, and their
collisions are compared. A run ends at its
first collision, the arena's wall included, after WAY, or when the time is over, which is told. As in the
paper the plain network's spikes are counted in fixed windows of 500 ms, the modified one's in a running
window of 50 ms. The paper names no turn factor here: the plain network has 0.5, the only one that it names
with 0.35 m/s (Table 1, sections 3.5 and 3.7), and once more 1, with which it keeps farther from single blocks
in Table 1; the modified one 2 (ours). Rule: at 0.5 m/s the modified network has fewer collisions, paired
(exact sign test on the scenes in which they differ, p < 0.05), than the plain one at either turn factor.

All are asked for the same way, because the plain network stands for much of its time and a robot that hardly
moves touches little; the same rule on the first EARLY seconds of the same runs is told beside it. A robot
that turns in one place touches as little, so squares of the floor are counted. Collisions a metre are
compared as well (exact binomial test of two rates), once without those with yellow blocks, which the sensor
hardly sees; and each robot is to move at half of its speed at least. These rules are ours.

The way is made alike, and turn factor 0.5 added, since runs of 40 s on dies from 9800 had shown nothing
(against turn factor 1: 7 scenes better, 13 worse).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import CensoredData, binomtest, ecdf

from circuits.arrays import F64
from system.experiment import Experiment, Progress, Report
from system.papers.conditions import IDEAL_CURRENTS
from system.papers.milde2017.null import ROBOTS, runs_of
from system.plot import COLOURS, sized_axes
from system.pushbot.body import SPEED_OF_FACTOR
from system.pushbot.campaign import FIRST, Drive, Runs, Summary, drive_repeats, share_of, summaries_of
from system.pushbot.course import stood
from system.pushbot.run import Trace, summarise
from system.pushbot.scenario import MODIFIED_TURN_FACTOR, TURN_FACTOR, Scenario
from system.rule import Measured, at_least, significant
from system.statement import Statement
from system.study.campaign import ALONE, Execution
from system.study.statistics.power import detectable_ratio, detectable_share
from system.verdict.family import family
from system.verdict.null import nulls_of
from system.worlds.arena.scene import COLOURS as REFLECTANCES

SPEEDS = (0.35, 0.5)  # m/s; the paper's
SCENES, DIES = 100, 25
WAY = 20.0  # m; ours: one collision comes in 12 to 46 m
LIMIT, EARLY = 600.0, 40.0  # s; ours
FRESH = FIRST + 500  # first die and seed: none that another experiment reports on, or that other codes saw
P = 0.05
MOVES = 0.5  # of the demanded speed
SQUARE = 0.2  # m; a robot that turns in one place touches little: on how many of these was it? ours

# what drives; without speed, scene, die and seed
NETWORKS: Mapping[str, Scenario] = {
    "plain": Scenario(
        scene="clutter", turn_factor=TURN_FACTOR, readout="fixed", silicon_noise="off", **IDEAL_CURRENTS
    ),
    "plain_turn_factor_1": Scenario(
        scene="clutter", turn_factor=1.0, readout="fixed", silicon_noise="off", **IDEAL_CURRENTS
    ),
    "modified": Scenario(
        scene="clutter",
        turn_factor=MODIFIED_TURN_FACTOR,
        modified=True,
        silicon_noise="off",
        **IDEAL_CURRENTS,
    ),
}

CHANGED = (
    "what is compared was changed after runs of 40 s on dies from 9800 had shown nothing: the rows are of"
    " fresh dies, and of a question that was not the first"
)
ALIKE = "all networks are the plain one"
NULLS = (*ROBOTS, ALIKE)

Found = Mapping[tuple[str, float], Sequence[Summary]]


def reproduce(
    progress: Progress, execution: Execution = ALONE, count: int = SCENES, dies: int = DIES, way: float = WAY
) -> Report:
    """Drive all scenes with each network at each speed."""
    cells = {
        (name, speed): Drive(
            replace(base, speed_factor=speed / SPEED_OF_FACTOR, duration=LIMIT, way=way), outcome
        )
        for name, base in NETWORKS.items()
        for speed in SPEEDS
    }
    asked, usual = Runs(count, dies, FRESH), Runs(SCENES, DIES, FRESH)
    found = summaries_of(drive_repeats(execution, EXPERIMENT.name, cells, asked, usual, progress))
    nulls = {**runs_of(ROBOTS, found), ALIKE: _alike(found)}
    told = (*notes(found), CHANGED, _power(found))
    return Report(rows(found), lambda figure: _draw(found, figure), told, nulls_of(rows, nulls))


def _alike(found: Found) -> Found:
    """The plain network in the place of all."""
    return {(name, speed): found["plain", speed] for name, speed in found}


def outcome(trace: Trace) -> Summary:
    """Give what was touched, how much of it early, and the share of the time at rest."""
    touched = trace.drive.touched or ""
    faint = {b.name for b in trace.scene.bodies if b.reflectance >= REFLECTANCES["yellow"]}
    path = np.array(trace.drive.path)
    return summarise(trace) | {
        "touched_block": float(touched.startswith("block")), "touched_wall": float(touched == "wall"),
        "touched_visible": float(bool(touched) and touched not in faint),
        "touched_early": float(bool(touched) and float(path[-1, 0]) <= EARLY),
        "way_early_m": way_until(path, EARLY), "stood": stood(path), "squares": squares(path),
    }  # fmt: skip


def way_until(path: F64, time: float) -> float:
    """Give the length (m) of what a path, float64[n, 4] of s, m, m, rad, has gone until `time` s."""
    early = path[path[:, 0] <= time, 1:3]
    return float(np.hypot(*np.diff(early, axis=0).T).sum())


def squares(path: F64) -> float:
    """Count the squares of side SQUARE that a path, float64[n, 4] of s, m, m, rad, was on."""
    return float(len(np.unique(path[:, 1:3] // SQUARE, axis=0)))


def rows(found: Found) -> tuple[Statement, ...]:
    """Compare the modified with the plain network at the higher speed, by scene and by metre."""
    others = [name for name in NETWORKS if name != "modified"]
    compared = [
        rule(title.format(name), found[name, SPEEDS[1]], found["modified", SPEEDS[1]], kind)
        for rule, title, kind in RULES
        for name in others
    ]
    return family((*compared, *(_moves(network, speed, runs) for (network, speed), runs in found.items())))


def _power(found: Found) -> str:
    """The least effects that the runs at the higher speed tell, of the plain network's usual turn factor."""
    plain, modified = (found[name, SPEEDS[1]] for name in ("plain", "modified"))
    differ = sum(bool(a["collided"]) != bool(b["collided"]) for a, b in zip(plain, modified, strict=True))
    ways = [total(runs, "path_m") for runs in (plain, modified)]
    hits = sum(share_of(runs, "collided").passed for runs in (plain, modified))
    ratio = detectable_ratio(ways[0], ways[1], hits)
    return (
        f"power (80 %, two-sided 5 %, before Holm): {differ} scenes that differ tell"
        f" {detectable_share(differ):.2f} of them better from a half; {hits} collisions tell a ratio a"
        f" metre of {ratio:.2f}"
    )


def _paired(name: str, plain: Sequence[Summary], modified: Sequence[Summary], kind: str) -> Statement:
    """Whether the modified network has fewer collisions of a kind, scene by scene."""
    pairs = [(bool(a[kind]), bool(b[kind])) for a, b in zip(plain, modified, strict=True)]
    better, worse = pairs.count((True, False)), pairs.count((False, True))
    p = binomtest(better, better + worse).pvalue if better + worse else 1.0
    ours = Measured(better - worse, f"{better} scenes better, {worse} worse, p {p:.2g}", p=p)
    return Statement(name, "no collisions", ours, significant(1, P, "better"))


def _a_metre(name: str, plain: Sequence[Summary], modified: Sequence[Summary], kind: str) -> Statement:
    """Whether the modified network has fewer collisions of a kind a metre."""
    ways = [total(runs, "path_m") for runs in (plain, modified)]
    hits = [share_of(runs, kind).passed for runs in (plain, modified)]
    p = binomtest(hits[1], sum(hits), ways[1] / sum(ways)).pvalue if sum(hits) else 1.0
    shown = [f"{hit} in {way:.0f} m" for hit, way in zip(hits, ways, strict=True)]
    apart = hits[1] * ways[0] - hits[0] * ways[1]
    ours = Measured(apart, f"modified {shown[1]}, plain {shown[0]}, p {p:.2g}", p=p)
    return Statement(name, None, ours, significant(-1, P, "fewer"))


# how the modified network is compared, in which words, and by which number of a run
RULES = (
    (_paired, "collides_less_than_{}", "collided"),
    (_paired, f"collides_less_than_{{}}_in_{EARLY:g}_s", "touched_early"),
    (_a_metre, "collisions_a_metre_than_{}", "collided"),
    (_a_metre, "visible_collisions_a_metre_than_{}", "touched_visible"),
)


def _moves(network: str, speed: float, runs: Sequence[Summary]) -> Statement:
    mean = total(runs, "path_m") / total(runs, "time_s")
    name, ours = f"{network}_moves_at_{speed:g}_m_per_s", Measured(mean, f"{mean:.3f} m/s")
    return Statement(name, speed, ours, at_least(MOVES * speed))


def total(runs: Sequence[Summary], name: str) -> float:
    """Add up a number of the runs' summaries."""
    return float(np.sum([s[name] or 0.0 for s in runs]))


def notes(found: Found) -> tuple[str, ...]:
    """Tell the collisions of each network at each speed, and the way driven to one."""
    out = []
    for (network, speed), runs in found.items():
        way = total(runs, "path_m")
        still, seen = (total(runs, name) / len(runs) for name in ("stood", "squares"))
        met, early = share_of(runs, "collided"), share_of(runs, "touched_early").passed
        blocks, walls = (share_of(runs, f"touched_{name}").passed for name in ("block", "wall"))
        late = sum((s["time_s"] or 0.0) >= LIMIT - 1e-6 for s in runs)
        out.append(
            f"{network}, {speed:g} m/s: collided {met}, of them blocks {blocks}, wall {walls};"
            f" {way / max(met.passed, 1):.1f} m a collision in {way:.0f} m;"
            f" {early} in {total(runs, 'way_early_m'):.0f} m of the first {EARLY:g} s;"
            f" stands {100.0 * still:.0f} % of the time;"
            f" is on {seen:.0f} squares of {100.0 * SQUARE:.0f} cm; {late} out of time"
        )
    return tuple(out)


def _draw(found: Found, figure: Figure) -> None:
    ax = sized_axes(figure, 6.0, 3.4)
    for k, ((network, speed), runs) in enumerate(found.items()):
        ways, left = kept(runs)
        style = "-" if speed == SPEEDS[1] else ":"
        colour = COLOURS[k // len(SPEEDS)]
        label = f"{network.replace('_', ' ')}, {speed:g} m/s"
        ax.step(ways, left, style, where="post", color=colour, label=label)
    ax.set(xlabel="way (m)", ylabel="share without a collision", ylim=(0.0, 1.02))
    ax.legend(fontsize=8)


def kept(runs: Sequence[Summary]) -> tuple[F64, F64]:
    """Ways (m) from 0 on at which the share without a collision falls, and the share from there on.

    Kaplan and Meier's estimate: a run that was out of time counts as far as it went.
    """
    ways = np.array([s["path_m"] or 0.0 for s in runs])
    free = np.array([not s["collided"] for s in runs])
    share = ecdf(CensoredData.right_censored(ways, free)).sf
    return np.array([0.0, *share.quantiles]), np.array([1.0, *share.probabilities])


EXPERIMENT = Experiment(
    "milde2017-clutter", "plain and modified network among many blocks", reproduce,
    {"count": SCENES, "dies": DIES}, NULLS,
)  # fmt: skip
