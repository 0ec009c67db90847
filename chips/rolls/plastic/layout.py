"""Tables, state and working space of the plastic array's steps, in the form that compiled code takes."""

from __future__ import annotations

from typing import NamedTuple

from chips.rolls.layout import FilterBank, Scratch
from circuits.arrays import F32, F64, I32, I64

# Rows of the state: those of the two filters as in `chips.rolls.layout`, and the three nodes (V) that
# are high where calcium is above SL_THMIN, SL_THDN and SL_THUP
SLOW, CALCIUM = 0, 1  # filters: of the plastic synapses, and of the neurons' own spikes
OVER = 12
LEAST, MOST_DOWN, MOST_UP = range(3)
NODES = 3
PLASTIC_ROWS = OVER + NODES


class PlasticTables(NamedTuple):
    """All that a step of n neurons and their plastic synapses needs; arrays [pre, post] are of weights."""

    omega: F32  # float32[2, points, 4]
    banks: tuple[FilterBank, FilterBank]
    spike: F32  # float32[n]: what a spike brings its calcium, in z
    share: F32  # float32[n, rows, 2] over zeta: what the NMDA gate passes into the input
    silent: F32  # float32[n], A: output of the plastic filter that the neuron's own tables have
    ratio: F32  # float32[3, n]: copies of the calcium's current over the first one
    threshold: F32  # float32[3, n], A
    charging: F32  # float32[3, n], V/A: by what a current moves a node in a step
    passed: F32  # float32[3, n], V: where a node counts as high
    membrane: F64  # float64[n]: zeta above which a weight goes up
    supply: F32  # float32[1], V
    up: F32  # float32[pre, post], V: what an event moves a weight by
    down: F32
    rise: F32  # float32[pre, post], V: drift in a step, above the threshold and below
    fall: F32
    middle: F32  # float32[pre, post], V: threshold of a weight
    charge: F32  # float32[pre, post]: what an event brings the filter where the weight is high, in z
    active: F32  # float32[2], V: what the drift has more in a step while weights may go up, and down
    # under the full law: shares by w of `up` and `down`, 1/V, and the voltage of w where they hold, V
    effect: F32 | None = None
    # of a copy of the calcium, downwards, and of its threshold, upwards, by their node's voltage, 1/V
    soft: F32 | None = None


class PlasticArrays(NamedTuple):
    """State of a run of the plastic array.

    filters: float64[PLASTIC_ROWS, n]; weights: as they were at step `seen`, V, float32[pre, post]; seen:
    int32[pre, post]; clock: steps done, read: events read, held: filters times steps beyond their table's
    end, int64[1] each.
    """

    filters: F64
    weights: F32
    seen: I32
    clock: I64
    read: I64
    held: I64


class PlasticEvents(NamedTuple):
    """Events from outside to single plastic synapses: times (s, rising), columns, neurons."""

    times: F64
    columns: I64
    neurons: I64


class PlasticScratch(NamedTuple):
    """Working space: of the filters, and which neurons let their weights go up and down, float32[n] each."""

    filters: Scratch
    up: F32
    down: F32
    lift: F32  # V, what the drift has more in a step
    output: F32  # A, of the plastic filters
    calcium: F32  # A


class Plastic(NamedTuple):
    """The plastic part of a chip in a call of its kernel."""

    tables: PlasticTables
    arrays: PlasticArrays
    events: PlasticEvents
    scratch: PlasticScratch
