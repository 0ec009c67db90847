"""State of a ROLLS chip's depressed synapses between runs, and cautions on where they are not modelled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from chips.rolls.depression.kernel import recover
from chips.rolls.depression.layout import (
    BuiltDepression,
    Depressing,
    DepressionArrays,
    new_depression_scratch,
)
from chips.rolls.depression.program import STEP_BIAS
from chips.rolls.program.program import Program
from circuits.arrays import F32, I32
from circuits.errors import ParameterError

DEEPEST_MEASURED = 2.5  # step of a pulse over U_T
LEAST_MEASURED = 2e-9  # A, of a level: below, its mirror does not come up in a pulse
LONG_AGO = 1 << 28  # steps, a day
FEWEST_STEPS = 10.0  # of the chip in a time constant; ours


@dataclass(frozen=True, slots=True)
class DepressionState:
    """R behind the last event of each weight device, float32[devices], and the step of it, int32[devices]."""

    resource: F32
    seen: I32


def rest_of_depression(built: BuiltDepression) -> DepressionState:
    """Return the state of synapses that recovered long ago; noise of a first event is that of rest."""
    devices = built.step.size
    return DepressionState(np.ones(devices, np.float32), np.full(devices, -LONG_AGO, np.int32))


def depressing_of(built: BuiltDepression | None, state: DepressionState | None) -> Depressing | None:
    """Return tables and a copy of the state for a run, None where a chip has neither.

    Raises `ParameterError` for the state of a chip with other synapses.
    """
    if built is None and state is None:
        return None
    if built is None or state is None or state.resource.size != built.step.size:
        raise ParameterError(
            "chip.run.state: of a chip with other depressed synapses, must be of this one; use at_rest"
        )
    arrays = DepressionArrays(state.resource.copy(), state.seen.copy())
    return Depressing(built.tables, arrays, new_depression_scratch(built.tables), built.noise)


def state_of(depressing: Depressing | None) -> DepressionState | None:
    """Return the state after a run."""
    return None if depressing is None else DepressionState(*depressing.arrays)


def converted_depression(
    old: BuiltDepression | None, new: BuiltDepression | None, depressing: Depressing | None, now: int
) -> Depressing | None:
    """Return the synapses at another temperature from step `now` on, up to which they recover.

    Their voltages stay.
    """
    if depressing is None or old is None or new is None:
        return None
    recover(depressing, now)
    kept = depressing.arrays.resource ** np.float32(old.u_t / new.u_t)
    # R is over that at rest, which is another voltage then
    kept = kept * np.exp((new.rest - old.rest) / new.u_t).astype(np.float32)
    arrays = depressing.arrays._replace(resource=kept)
    return depressing._replace(tables=new.tables, arrays=arrays, noise=new.noise)


def depression_cautions(
    program: Program, built: BuiltDepression | None, levels: Mapping[int, float], step: float
) -> tuple[str, ...]:
    """Return, in sentences, where depression is not modelled, or outside of what was measured.

    levels: mean currents of the levels that the program has, A; step: of the chip, s.
    """
    if built is None:
        on = STEP_BIAS in program.biases.names and not program.biases.is_off(STEP_BIAS)
        text = f"depression: {STEP_BIAS} is on, and weights stay; give the program a ShortTermDepression"
        return (text,) if on else ()
    found = []
    deepest, shortest = float(built.step.max() / built.u_t), float(built.tau.min())
    if deepest > DEEPEST_MEASURED:
        found.append(
            f"depression: a pulse takes {deepest:.2g} U_T, measured up to {DEEPEST_MEASURED:g};"
            f" lower {STEP_BIAS}"
        )
    if shortest < FEWEST_STEPS * step:
        found.append(
            f"depression: time constants down to {shortest:.2g} s, fewer than {FEWEST_STEPS:g} steps of"
            f" {step:g} s; give the chip a smaller step"
        )
    for level, current in levels.items():
        if 0.0 < current < LEAST_MEASURED and level > 0:
            found.append(
                f"depression: level {level} draws {current:.2g} A, measured from {LEAST_MEASURED:g} A on;"
                " raise the weight, and lower the filter's threshold"
            )
    return tuple(found)
