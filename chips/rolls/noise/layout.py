"""Tables of a ROLLS chip's noise, in the form that compiled code takes."""

from __future__ import annotations

from typing import NamedTuple

from chips.lines.steps import LineSteps
from chips.noise_draw import Draws, Slow
from circuits.arrays import F32

# Columns of a neuron's rows: D without input (1/s), what an ampere that flows in and one that is drawn add
# to it (1/C), what stands for 1/h while the neuron rises (1/s), what a whole change of the leak, the
# feedback and the direct current comes to (zeta/s), 1 - share of the input's pair, and zeta a coulomb that is
# drawn
WHITE, INPUT, DRAWN, RISE, LEAK, BACK, DIRECT, PAIR, REVERSED = range(9)
NOISE_COLUMNS = 9
# Slow processes, relative: leak, feedback, direct current, the input's pair, and the filters of either sign
SLOW_LEAK, SLOW_BACK, SLOW_DIRECT, SLOW_PAIR, SLOW_EXCITE, SLOW_INHIBIT = range(6)
# Lines that all neurons share: leak, direct current, time constant and gain of the filters of either sign
LINE_LEAK, LINE_DIRECT, LINE_EXC_TAU, LINE_EXC_GAIN, LINE_INH_TAU, LINE_INH_GAIN = range(6)


class NoiseTables(NamedTuple):
    """Noise of n neurons.

    rows: float32[n, rows, NOISE_COLUMNS] over zeta; grain: float32[signs, n], an electron in z; excess:
    float32[signs, n], electrons of noise that an electron of a pulse has beyond the first; plastic_grain,
    plastic_excess: float32[2, n], the same of the plastic array's filters, where there is one. lines: of the
    chip's generator, none where they do not wander.
    """

    rows: F32
    grain: F32
    excess: F32
    draws: Draws
    slow: Slow
    plastic_grain: F32
    plastic_excess: F32
    lines: LineSteps
