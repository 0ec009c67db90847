"""Figure 6 of Stöckel 2017: Bug 0 and Bug 2, as programs and as neurons, where Bug 0 cannot succeed.

Both agents drive as programs and with five networks each, and their ways are compared with the paper's words:
both Bug 0 repeat their way over and over, both Bug 2 reach the goal, and trajectories of program and neurons
are highly similar. The map is ours (`bug-spiral`), as the paper's is a picture. So is the measure of
similarity, the median over the neurons' path of the distance to the program's; for Bug 0 it must be below two
radii of the robot. All five networks must do as the paper says.
"""

from __future__ import annotations

from dataclasses import dataclass

from matplotlib.figure import Figure

from system.bug.body import RADIUS
from system.bug.path import median_distance
from system.bug.picture import draw_paths, draw_shortest, draw_world
from system.bug.run import Trace, run
from system.bug.scenario import Scenario
from system.experiment import Experiment, Progress, Report, with_progress
from system.rule import below, equal
from system.statement import Statement
from system.verdict.null import nulls_of

MAP = "bug-spiral"
SEEDS = (1000, 1001, 1002, 1003, 1004)
DURATION = 200.0  # s
NEAR = 2.0 * RADIUS
LATE = 60.0  # s before the end, over which a way is compared with what was before
AWAY = 1.0  # map unit, from a program's way: beyond what counts as similar; ours
NULLS = ("never moves", "always reaches the goal", "never does, nor repeats its way")


@dataclass(frozen=True, slots=True)
class Seen:
    """Of a run: whether it repeats its way, reaches the goal, and its median distance from the program's."""

    repeats: bool
    reached: bool
    apart: float


Found = dict[str, list[Seen]]


def traces(
    progress: Progress, seeds: tuple[int, ...] = SEEDS, duration: float = DURATION
) -> dict[str, list[Trace]]:
    """Drive both agents, and give the runs by agent and brain."""
    asked = [
        (a, b, s) for a in ("bug0", "bug2") for b, s in (("reference", 0), *(("ideal", s) for s in seeds))
    ]
    found: dict[str, list[Trace]] = {}
    for agent, brain, seed in with_progress(asked, progress):
        trace = run(Scenario(agent, brain, map=MAP, seed=seed, duration=duration))
        found.setdefault(f"{agent} {brain}", []).append(trace)
    return found


def repeats(trace: Trace) -> bool:
    """Tell whether a run missed the goal, and was in its last minute only where it had been before."""
    late, early = trace.path[-round(100 * LATE) :: 20], trace.path[: -round(100 * LATE)]
    return not trace.reached and median_distance(late, early) < NEAR


def seen(found: dict[str, list[Trace]]) -> Found:
    """Sum up the runs, by agent and brain."""
    programs = {name.partition(" ")[0]: runs[0].path for name, runs in found.items() if "reference" in name}
    return {
        name: [
            Seen(repeats(t), t.reached, median_distance(t.path, programs[name.partition(" ")[0]]))
            for t in runs
        ]
        for name, runs in found.items()
    }


def _nulls(found: dict[str, list[Trace]]) -> dict[str, Found]:
    """Robots that stand at the start, which is on every way, are at the goal, or wander far from any way."""
    made = (Seen(repeats=True, reached=False, apart=0.0), Seen(repeats=False, reached=True, apart=AWAY),
            Seen(repeats=False, reached=False, apart=AWAY))  # fmt: skip
    return {
        null: {name: [each] * len(runs) for name, runs in found.items()}
        for null, each in zip(NULLS, made, strict=True)
    }


def rows(found: Found) -> tuple[Statement, ...]:
    """Make the statements of the figure."""
    made = []
    for brain in ("reference", "ideal"):
        again = [t.repeats for t in found[f"bug0 {brain}"]]
        reached = [t.reached for t in found[f"bug2 {brain}"]]
        made += [
            _share(f"bug0_{brain}_repeats_its_way_share", again),
            _share(f"bug2_{brain}_reaches_share", reached),
        ]
    for agent in ("bug0", "bug2"):
        apart = max(t.apart for t in found[f"{agent} ideal"])
        made.append(
            Statement(
                f"{agent}_median_distance_of_paths",
                "highly similar",
                apart,
                below(NEAR, "below {limit:g} map units"),
            )
        )
    return tuple(made)


def reproduce(progress: Progress) -> Report:
    """Drive both agents, as programs and as neurons."""
    found = traces(progress)
    return Report(rows(seen(found)), lambda figure: _draw(found, figure), nulls=nulls_of(rows, _nulls(found)))


def _share(name: str, said: list[bool]) -> Statement:
    return Statement(name, 1.0, sum(said) / len(said), equal())


def _draw(found: dict[str, list[Trace]], figure: Figure) -> None:
    figure.set_size_inches(9.6, 4.2)
    for ax, agent in zip(figure.subplots(1, 2), ("bug0", "bug2"), strict=True):
        program, neurons = found[f"{agent} reference"][0], found[f"{agent} ideal"]
        draw_world(program.world, ax)
        draw_shortest(program.shortest, ax)
        paths = {"program": program.path} | {f"neurons, seed {t.scenario.seed}": t.path for t in neurons}
        draw_paths(paths, ax)
        ax.set_title(f"{agent}: {program.ended}; neurons: {neurons[0].ended}", fontsize=9)
    figure.legend(*ax.get_legend_handles_labels(), loc="outside lower center", ncols=5, fontsize=8)


EXPERIMENT = Experiment(
    "stockel2017-fig6", "Bug 0 repeats its way where Bug 2 reaches the goal, programs and neurons", reproduce,
    nulls=NULLS,
)  # fmt: skip
