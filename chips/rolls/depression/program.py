"""Short-term depression in a ROLLS program: that it is on, and the current that no bias of the chip names.

    biases = default_biases().with_code("NPA_WEIGHT_STD_N", 5, 36)
    program = Program(levels, biases, depression=ShortTermDepression())

The step's current is the code of NPA_WEIGHT_STD_N in the program's bias table; shipped tables have it off.
The recovery's current has no name in the control software, so its code stands here. All non-plastic
excitatory synapses are depressed, since all have the cell; inhibitory, virtual and plastic ones are not.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from circuits.blocks.rolls.bias import Code, current_of
from circuits.blocks.rolls.depressing_synapse import RECOVERY, Params
from circuits.errors import ParameterError

STEP_BIAS = "NPA_WEIGHT_STD_N"


@dataclass(frozen=True, slots=True)
class ShortTermDepression:
    """That a program's excitatory synapses are depressed.

    Attributes
    ----------
    recovery
        Code (coarse, fine) of I_rec.
    cell
        Sizes of the cell, whose synapse is the chip's own.

    Raises
    ------
    ParameterError
        The recovery is no code, or off.
    """

    recovery: Code = RECOVERY
    cell: Params = field(default_factory=Params)

    def __post_init__(self) -> None:
        current_of(self.recovery)
        if self.recovery[1] == 0:
            raise ParameterError(
                "depression.recovery: fine code 0, must be > 0, or no weight comes back; leave depression out"
            )
