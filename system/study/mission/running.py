"""The runs of a mission: way after way, each a study of its own, and a page that grows with them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from system.study.campaign import Workers
from system.study.engine import run_study
from system.study.manifest import FILE, Study
from system.study.mission.found import Found, found_of
from system.study.mission.mission import Mission, Way
from system.study.statistics.clustered import narrow
from system.study.table import Table, join

Told = Callable[[Sequence[Found]], object]  # told what was found so far, after each chunk


@dataclass(frozen=True, slots=True)
class Part:
    """Which chunks of each way are run here: all, or every `of`-th one from the `number`-th on.

    Attributes
    ----------
    number : int
        Number of the part, from 1 on.
    of : int
        How many parts there are.
    """

    number: int = 1
    of: int = 1

    def chunks(self, study: Study) -> range:
        """Numbers of its chunks among those of a study."""
        return range(self.number - 1, len(study.chunks()), self.of)


ALL = Part()


def _nobody(_: object) -> None:
    """Takes what nobody asked to be told."""


def run_mission(
    mission: Mission, folder: Path | None = None, *, workers: Workers,
    progress: Callable[[float], None] = _nobody, told: Told = _nobody, command: Sequence[str] = (),
    part: Part = ALL,
) -> tuple[Found, ...]:  # fmt: skip
    """Run all ways of a mission, or go on with them.

    Parameters
    ----------
    mission
        The mission.
    folder
        Folder of the mission, in which each way has one; nothing is kept where it is None.
    workers
        What runs the chunks.
    progress
        Told the share of the runs that are done, 0 to 1.
    told
        Told what was found so far.
    command
        Words of the command, which the manifests of the ways keep.
    part
        Which chunks are run here.
    """
    done: list[Found] = []
    for k, way in enumerate(mission.ways):
        going = _Going(mission, way, done, told, _dies_of_base(way, done))
        own = None if folder is None else folder / way.name
        begun = own is not None and (own / FILE).exists()
        outcome = run_study(
            way.study, own, workers=workers, resume=begun, stop=going.stop, command=command,
            progress=partial(_told_share, progress, k, len(mission.ways)), part=part.chunks(way.study),
        )  # fmt: skip
        done.append(found_of(mission, way, outcome.table))
    return tuple(done)


def _told_share(progress: Callable[[float], None], ways: int, of: int, share: float) -> None:
    """Tell the share of all ways that is done, of which some are finished and one to a share."""
    progress((ways + share) / of)


def _dies_of_base(way: Way, done: Sequence[Found]) -> int | None:
    """Dies of the way that a way changes, as far as it was run; None where the way is no change."""
    if not way.change:
        return None
    return next(len(each.dies) for each in done if each.way.base == way.base and not each.way.change)


@dataclass(frozen=True, slots=True)
class _Going:
    """A way while it is run.

    dies: after how many dies it ends, as a change does that is compared with what it changes.
    """

    mission: Mission
    way: Way
    done: Sequence[Found]
    told: Told
    dies: int | None
    tables: list[Table] = field(default_factory=list)

    def stop(self, table: Table) -> bool:
        """Take a chunk's samples, and say whether they are enough."""
        self.tables.append(table)
        found = found_of(self.mission, self.way, join(self.tables))
        self.told((*self.done, found))
        until = self.mission.asked.until
        if until is None:
            return False
        return len(found.dies) >= self.dies if self.dies is not None else narrow(found.estimate, until)
