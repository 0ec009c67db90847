"""How a solver ended."""

from __future__ import annotations

from enum import Enum


class Outcome(Enum):
    """How a solver ended; each value is the remedy that the text of an error ends with."""

    DONE = "nothing to do"
    EVENT = "stopped at the first output event; advance again"
    STEP_TOO_SMALL = (
        "the step fell below the smallest one; loosen rtol, or look for a node without capacitance"
    )
    TOO_MANY_STEPS = "raise max_steps, or look for an oscillation in the waveforms"
    NO_OPERATING_POINT = "give start voltages near the state that is meant"
    BUFFER_FULL = "internal: the recording is emptied and the run goes on"
