"""Tables, state and working space of a ROLLS chip's steps, in the form that compiled code takes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from circuits.arrays import F32, F64, I64
from circuits.compiled import compiled

# What a step runs: a product may be added without a rounding of its own, a zero has no sign, and a division
# may be a product; the second is copied into its caller
step_compiled = compiled(fastmath={"contract", "nsz", "arcp"})
step_inlined = compiled(fastmath={"contract", "nsz", "arcp"}, forceinline=True)

# v and u^power over z: points from LOW to SPLIT, FINE an e-fold, then every COARSE up to HIGH
LOW, SPLIT, FINE, COARSE, COARSE_POINTS = -28.0, 256.0, 32, 16.0, 16384
FINE_POINTS = int((SPLIT - LOW) * FINE)
HIGH = SPLIT + COARSE * (COARSE_POINTS - 1)
VALUE, SLOPE, POWER, POWER_SLOPE = range(4)  # columns of that table

OCTAVE_BITS = 4  # 16 lines an octave of zeta
SHIFT = 52 - OCTAVE_BITS  # of a float64's bits
BASE = 1023 << OCTAVE_BITS  # of 1.0
STATIC, BENT, DRAWN = 0, 2, 4  # columns of a neuron's lines: intercept, and the slope behind it
REACH = 6  # zeta down to which, and behind it up to which, a line is taken
LINE_COLUMNS = 8
# Columns of what a hard step needs: 1 / Q_0 (1/C), zeta of the top, s from there to the spike, s of the
# refractory period, V of v_ahp where all of a spike's current enters, and the membrane's own current at 0 V
# (A) with its slope
INVERSE, TOP, DELAY, REFRACTORY, KICK, OWN, OWN_SLOPE = range(7)
SPIKING_COLUMNS = 8
STEEP = 0.2  # of the slope times the step, from which an upstroke may be told; ours
SURE = 2.0  # times what drives it: a membrane's own current from which it is told; ours
NEVER = 1e30  # s
STRONGEST = np.float32(30.0)  # e-folds that an inhibition's slope may have in a step

# float32, in which all is done but what adds up over steps: with a float64 among them numba makes all float64
ZERO, HALF, ONE, TWO = np.float32(0.0), np.float32(0.5), np.float32(1.0), np.float32(2.0)
SIXTH, C24 = np.float32(1.0 / 6.0), np.float32(1.0 / 24.0)
C11, C32, C35, C20 = np.float32(11.0 / 60.0), np.float32(1.5), np.float32(0.6), np.float32(0.05)

VIRTUAL = 8  # columns of virtual synapses, four excitatory and four inhibitory
SIGNS = 4  # filters of a neuron: excitatory, inhibitory, virtual excitatory, virtual inhibitory
# Rows of the state: z of the four filters, what their lines have taken since a pulse, and how long ago it was
Z, TAKEN, SINCE, V_AHP, ZETA, WAIT, SHUT = 0, 4, 8, 12, 13, 14, 15
STATE_ROWS = 16  # SHUT: s to a spike that is sure; WAIT: s until a neuron is let go


class FilterBank(NamedTuple):
    """Filters of one kind, arrays of [n] each."""

    lost: F64  # 1 - e^(-dt / tau)
    fall: F64  # dt / tau
    rest: F64  # z where the leak and what idle synapses bring are alike
    empty: F32  # u^power at v_dd
    idle: F32  # what idle synapses bring in a step, in z
    line: F32  # C_line U_T in z, times the step, s
    first: F32  # what the line takes in a step with a pulse
    lag: F32  # by how much z is below its end on the mean of such a step, as the line takes it bit by bit
    scale: F32  # E of u = 1
    fallen: F32  # by how much the mean of E over a step is below its beginning, where the whole leak flows
    specific: F32  # I_S of the output times the mirror's gain, A


Banks = tuple[FilterBank, FilterBank, FilterBank, FilterBank]


class Membranes(NamedTuple):
    """Membranes of the neurons, arrays of [n] unless said."""

    lines: F32  # float32[n, rows, LINE_COLUMNS] over zeta
    voltage: F32  # float32[n, rows, 2] over zeta: lines of v_mem, V
    inverse: F32  # 1 / Q_0, 1/C
    strong: F32  # 1 / I_S of the pair, 1/A
    top: F64  # zeta at which the neuron spikes
    spiking: F64  # float64[n, SPIKING_COLUMNS]
    rise: F32  # float32[n, rows, 4] over zeta: T_0 (s) and T_1 / T_0 (1/A)
    adapting: bool  # whether v_ahp moves at all
    quiet: F64  # float64[n, points]: dv_ahp/dt, V/s
    share: F64  # float64[n, points]
    drawn: F64  # float64[n, points], A
    ahp_step: float  # V between points


class ChipTables(NamedTuple):
    """All that a step needs of a chip.

    charges: kappa_n Q / (C U_T) of one event, below 0 where the synapse inhibits, float32[pre, post]; parts:
    of a step, which fast neurons take one by one; part_banks: filters for such parts; fast: z of the exciting
    filters from which a neuron is fast, float64[SIGNS, n].
    """

    step: float  # s
    omega: F32  # float32[SIGNS, points, 4]
    banks: Banks
    live: tuple[bool, bool, bool, bool]  # filters that something can reach
    charges: F32
    virtual: F32  # float32[columns, n], of the virtual synapses' events
    membranes: Membranes
    parts: int
    part_banks: Banks
    fast: F64


class Scratch(NamedTuple):
    """Working space of `run_chip`, arrays of [n] unless said.

    excite, inhibit: currents into i_in and drawn from v_mem, A; beside: what of them no filter of the array
    brings, float32[2, n]; own, rate, slope, low, high: of membranes and their lines; push: what noise adds to
    the rate, 1/s; calm: that after a spike, A; hard, fast: marks; hard_words, fast_words: the same, by eight;
    found: neurons and words that are marked.
    """

    charge: F32  # float32[SIGNS, n]
    place: F64
    value: F32
    power: F32
    lag: F32
    excite: F32
    inhibit: F32
    own: F32
    rate: F32
    slope: F32
    low: F32
    high: F32
    push: F32
    calm: F32
    beside: F32
    hard: NDArray[np.uint8]
    hard_words: I64
    fast: NDArray[np.uint8]
    fast_words: I64
    found: I64  # int64[4, n + 1]: of hard neurons and their words, and of fast ones


class Traffic(NamedTuple):
    """Events into a chip, and spikes out of it.

    times (s, rising), columns (0 to 7 virtual, from 8 on presynaptic neuron), neurons: of the events; sent
    (s), senders: room for the spikes, in the order of steps; last: neurons that spiked in the step before,
    with room for all that a step can have; counts: int64[COUNTS].
    """

    times: F64
    columns: I64
    neurons: I64
    sent: F64
    senders: I64
    last: I64
    counts: I64


class ChipRun(NamedTuple):
    """A chip's neurons, filters and non-plastic synapses in a call of its kernel.

    tables: of the chip; state: float64[STATE_ROWS, n], overwritten; bits: its row of zeta as int64[n], of the
    same memory; traffic: events in and spikes out; scratch: working space; part_state, part_scratch: that of
    fast neurons, with the rows of a state.
    """

    tables: ChipTables
    state: F64
    bits: I64
    traffic: Traffic
    scratch: Scratch
    part_state: F64
    part_scratch: Scratch


# Steps done, spikes written, events read, neurons in `last`, filters times steps beyond their table's end
DONE, WRITTEN, READ, LAST, HELD = range(5)
COUNTS = 5


def new_scratch(n: int) -> Scratch:
    """Return the working space of `n` neurons, a multiple of eight."""
    value, power, lag, excite, inhibit, own, rate, slope, low, high, push, calm = np.zeros(
        (12, n), np.float32
    )
    hard, fast = np.zeros((2, n), np.uint8)
    return Scratch(
        np.zeros((SIGNS, n), np.float32), np.zeros(n), value, power, lag, excite, inhibit, own, rate, slope,
        low, high, push, calm, np.zeros((2, n), np.float32), hard, hard.view(np.int64), fast,
        fast.view(np.int64), np.zeros((4, n + 1), np.int64),
    )  # fmt: skip
