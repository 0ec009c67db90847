"""Where runs of one circuit go side by side: in lanes of the processor, or on a graphics processor."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal, TypeAlias

from circuits.checks import require_choice
from circuits.solver.lanes.layout import Found, Jobs, Wiring, new_found, new_team
from circuits.solver.lanes.on_gpu import run_on_gpu
from circuits.solver.lanes.run import FINISHED, run
from circuits.vectors.vector import WIDTH

Place = Literal["cpu", "gpu"]
PLACES: tuple[Place, ...] = ("cpu", "gpu")
"""In lanes of the processor, or in threads of a graphics processor."""

Runs: TypeAlias = Callable[[Wiring, Jobs], Iterator[Found]]
"""Does jobs, and gives what they have left each time that what they have recorded is to be taken."""

_POINTS = 256  # of a block
_ROOM = 2 << 20  # bytes of all blocks, which stay near the processor; ours


def runs_at(place: Place) -> Runs:
    """What does runs at a place; raises ParameterError for one that there is not."""
    require_choice("place", place, PLACES)
    return run_on_gpu if place == "gpu" else run_in_lanes


def run_in_lanes(w: Wiring, jobs: Jobs) -> Iterator[Found]:
    """Do jobs in lanes of the processor; what has been taken is overwritten."""
    count = len(jobs.start)
    blocks = max(4 * WIDTH, _ROOM // (8 * _POINTS * (1 + w.recorded.size))) if jobs.recording else 0
    found, team, code = new_found(w, count, blocks, _POINTS), new_team(w, count), -1
    while code != FINISHED:
        code = run(w, jobs, team, found)
        yield found
        found.used[:] = 0
        team.block[:] = -1
