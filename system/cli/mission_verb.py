"""The verbs on missions: `mission` and `merge`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from system.cli import shared_options as shared
from system.cli.shared_options import Level, ManyDies
from system.cli.verb import argument, like, required
from system.option import option
from system.options.silicon import USUAL_CELSIUS, SiliconChoice


@dataclass(frozen=True, slots=True, kw_only=True)
class Mission(ManyDies):
    """Measure what share of dies does what a robot is for. Failures are split by what they come from."""

    OWN: ClassVar[str] = "lot"
    system: str = argument("SYSTEM", "A robot: see noctule list", names="system.registry:system_names")
    success: str | None = option(
        None, 'As "collided == 0 and distance_m >= 20"; the robot\'s own unless given', metavar="TEXT"
    )
    dies: int = option(100, "Number of dies, with --until at most", short="n")
    first_die: int = option(1000, "Number of the first die")
    worlds: int = option(2, "Worlds that each die meets, its own")
    trials: int = option(2, "Runs in each world, with noise of their own")
    temperature: tuple[str, ...] = option((USUAL_CELSIUS,), "Degrees Celsius, repeatable", metavar="DEGC")
    calibrated_at: str | None = option(None, "Where chips were calibrated; 27 unless given", metavar="DEGC")
    bias_kind: tuple[Literal["generator", "ideal", "gate"], ...] = option(
        (), "Of its chips, repeatable; the robot's own unless given"
    )
    change: tuple[str, ...] = option(
        (), "Tried on the same dies, as area=4, codes=default, bias-kind=ideal, or usual", metavar="TEXT"
    )
    blame: int = option(0, "Failing dies of each temperature and kind of bias to be blamed", metavar="COUNT")
    until: str | None = option(None, "Stop when the yield is known to +- this, as 2%", metavar="SHARE")
    param: tuple[str, ...] = option((), "An option of the robot, repeatable", metavar="NAME=VALUE")
    level: Level = option("behavioural", "Of its chips")
    lot: str = like(SiliconChoice, "lot")
    variation: SiliconChoice = shared.silicon_part(
        "temperature", "lot", "die", "study", "corner", "at", "process", "allow_implausible"
    )
    chunk: int = option(8, "Dies that are run and kept together")
    output: str | None = option(None, "Keep runs and the page there", short="o", metavar="FOLDER")
    resume: bool = option(default=False, about="Go on with the mission in --output")
    shard: str | None = option(None, "Run this part alone, as 3/8; merge puts parts together", metavar="I/N")
    threads: int | None = shared.threads_option()
    workers: int | None = shared.workers_option()
    scheduler: str | None = shared.scheduler_option()
    plot: str | None = shared.plot_option()
    as_json: bool = shared.json_option()


@dataclass(frozen=True, slots=True, kw_only=True)
class Merge:
    """Put the parts of a mission together, which --shard ran. The result is that of one run."""

    parts: tuple[str, ...] = argument("FOLDER...", "Folders of all parts")
    output: str = required("Folder of the whole", short="o", metavar="FOLDER")
    plot: str | None = shared.plot_option()
    as_json: bool = shared.json_option()
