"""Planning by a wave of spikes, on ideal cells or on a chip.

Ideal cells delay a spike by the cost of their place exactly. A chip's delays are those of its die's
transistors at a temperature: codes are written, the wave runs, and the first-arrival pointers are read from
the goal back to the start, on either. Costs above 31 have no code and are refused on a chip.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from chips.wavefront.chip import ChipCells, WavefrontChip
from chips.wavefront.kernel import integer_wave
from chips.wavefront.paper_walk import plan_in_two_passes
from chips.wavefront.readout import UnreachableError, pointer_path
from circuits.arrays import F64, I64
from circuits.blocks.wavefront.axon_delay import UNIT
from circuits.errors import ParameterError

Cell = tuple[int, int]

_MOST_NEURONS = 10_000  # of the discrete model, a matter of time; ours


def plan_ideal(costs: I64, start: Cell, goal: Cell) -> I64 | None:
    """Path of ideal cells, int64[n, 2], start first; None where the goal does not fire."""
    try:
        return pointer_path(integer_wave(costs, start, goal).pointers, start, goal)
    except UnreachableError:
        return None


def plan_discrete(costs: I64, start: Cell, goal: Cell) -> I64 | None:
    """Path of the paper's discrete model and walk after the second pass, int64[n, 2]; None where it has none.

    It may be None where there is a path: a neuron of long delay that is made to fire again and again never
    delivers its spike. A neuron may occur twice. Raises `ParameterError` for a map of more than 10,000 cells:
    every step works on all neurons, and a wave that never arrives ends only when all delays have passed.
    """
    if costs.size > _MOST_NEURONS:
        raise ParameterError(
            f"planner: paper on {costs.size} cells, must be at most {_MOST_NEURONS}; use `planner=wave`"
        )
    try:
        return plan_in_two_passes(costs, start, goal).second_path
    except UnreachableError:
        return None


@dataclass(frozen=True, slots=True)
class ChipPlanner:
    """A planner by a wavefront chip that is as large as the map.

    cells : the cells of a die; unit : delay of a unit of cost, s; number : of the plan, by which its noise is
    drawn; arrivals : of each wave so far, when every cell fired, s after its start, inf where it did not.
    """

    cells: ChipCells
    unit: float = UNIT
    number: int = 0
    arrivals: list[F64] = field(default_factory=list, repr=False, compare=False)

    def __call__(self, costs: I64, start: Cell, goal: Cell) -> I64 | None:
        """Path of the chip, int64[n, 2], start first; None where the goal does not fire.

        Raises `ParameterError` for a cost without a code, and for silicon outside the chip's record.
        """
        chip = WavefrontChip(*costs.shape, cells=self.cells, unit=self.unit)
        wave = chip.plan(chip.program(costs), start, goal, number=self.number)
        self.arrivals.append(wave.arrivals)
        try:
            return wave.path()
        except UnreachableError:
            return None
