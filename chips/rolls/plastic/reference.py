"""One plastic synapse with its learning circuit, by its transistors and by the steps of a chip.

`pair()` is a circuit of both blocks on their own: events of the synapse and of the neuron, and the membrane
as a voltage that is given. `simulated` runs it; `stepped` runs the compiled functions of the chip's kernel
with the lumped devices of the very same circuit and die.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from chips.rolls.chip import STEP
from chips.rolls.layout import (
    COUNTS,
    NEVER,
    SHUT,
    STATE_ROWS,
    ZETA,
    Traffic,
    new_scratch,
)
from chips.rolls.plastic.kernel import deliver_plastic, step_plastic
from chips.rolls.plastic.layout import Plastic, PlasticEvents
from chips.rolls.plastic.model import CELL_ARRAYS, Cells, cell_model, cells_of, gate_model, gates_of
from chips.rolls.plastic.state import arrays_of, rest_of_plastic, scratch_of, settle
from chips.rolls.plastic.tables import Parts, assemble
from chips.rolls.synapse.charge import pulse_length
from chips.rolls.synapse.model import model_of
from circuits.arrays import F64
from circuits.bias import bias_voltages, rebias
from circuits.blocks.ports import SUPPLY
from circuits.blocks.rest import started_at_rest
from circuits.blocks.rolls import calcium_gate, dpi_synapse, plastic_synapse
from circuits.circuit import BiasKind, Circuit, Instance, Port
from circuits.devices import Source
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.event import pulse
from circuits.lowering.on_die import DieDevices, standing
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

COPIES = 8  # of the one synapse: what the kernel's working space wants
LINE = 0.9  # V, ours: ideal voltage of the synapse's line
EDGE = 1e-6  # s, in which the membrane changes
MOVES = 0.05  # V, ours: by which a weight has to change to have been moved


@dataclass(frozen=True, slots=True)
class Stimulus:
    """What both levels of description get.

    events: of the synapse, spikes: of the neuron, s; membrane: (time, V) from which on it has a voltage, the
    first at 0 s; duration: s.
    """

    events: tuple[float, ...]
    spikes: tuple[float, ...]
    membrane: tuple[tuple[float, float], ...]
    duration: float

    def level(self, t: float) -> float:
        """Return the membrane's voltage at `t` s, V."""
        return next(v for begin, v in reversed(self.membrane) if begin <= t)


def pair() -> Circuit:
    """Build the pair: its ports are event (of the synapse), spike, v_mem, line, w, low, and all biases."""
    gate, cell = calcium_gate.build(), plastic_synapse.build()
    own = cell.wired()
    renamed = {b.port: f"n_{b.port}" for b in calcium_gate.BIASES}
    wires = {p.name: renamed.get(p.name, p.name) for p in gate.ports} | {"event": "spike"}
    biases = (
        *(replace(b, device=f"synapse.{b.device}" if b.device else None) for b in plastic_synapse.BIASES),
        *(
            replace(
                b, name=f"n_{b.name}", port=f"n_{b.port}", device=f"neuron.{b.device}" if b.device else None
            )
            for b in calcium_gate.BIASES
        ),
    )
    ports = (
        SUPPLY, Port("event", "event"), Port("spike", "event"), Port("v_mem", "analog"),
        *(Port(name, "analog", "out") for name in ("line", "w", "low", "up_b", "dn")),
        *(Port(b.port, "bias") for b in biases),
    )  # fmt: skip
    instances = (Instance("synapse", cell, own), Instance("neuron", gate, wires))
    return Circuit("plastic_pair", ports, (), instances, biases=biases)


def simulated(s: Stimulus, silicon: Silicon, kind: BiasKind, times: F64) -> F64:
    """Return the weight at `times` (s) by the transistors, V."""
    v_dd, corners = silicon.process.v_dd, [(0.0, s.membrane[0][1])]
    for before, (begin, volts) in zip(s.membrane, s.membrane[1:], strict=False):
        corners += [(begin - EDGE, before[1]), (begin, volts)]
    at, volts_at = zip(*corners, strict=True)
    sources = (
        Source("vdd", "vdd", Constant(v_dd)),
        Source("event", "event", pulse(s.events, v_dd)),
        Source("spike", "spike", pulse(s.spikes, v_dd)),
        Source("v_mem", "v_mem", PiecewiseLinear(at, volts_at) if len(at) > 1 else Constant(volts_at[0])),
        Source("line", "line", Constant(LINE)),
    )
    bench = Testbench("plastic pair", rebias(pair(), {}, kind), sources, s.duration)
    result = simulate(started_at_rest(bench, silicon.process), silicon)
    return np.interp(times, result.time, result["w"])


def stepped(s: Stimulus, silicon: Silicon, kind: BiasKind, step: float = STEP) -> tuple[F64, F64]:
    """Return the weight after every step by the chip's kernel, V, and the times, s.

    Events act at the beginning of their step.
    """
    plastic, state = prepared(silicon, kind, step)
    steps = round(s.duration / step)
    events = np.floor(np.array(s.events) / step).astype(np.int64)
    spikes = np.floor(np.array(s.spikes) / step).astype(np.int64)
    counts, last = np.zeros(COUNTS, np.int64), np.zeros(4 * COPIES, np.int64)
    none = np.empty(0)
    bits = np.ones(COPIES).view(np.int64)
    traffic = Traffic(
        none, none.astype(np.int64), none.astype(np.int64), none, none.astype(np.int64), last, counts
    )
    found, excite = np.empty(steps), np.zeros(COPIES, np.float32)
    for k in range(steps):
        # a column's event reaches all copies; a spike, sent by each, is calcium alone
        state[ZETA] = s.level(k * step)
        now = int((events == k).sum())
        plastic = plastic._replace(
            events=PlasticEvents(np.zeros(now), np.zeros(now, np.int64), np.zeros(now, np.int64))
        )
        plastic.arrays.read[0] = 0
        fired = int((spikes == k).sum())
        deliver_plastic(plastic, state, traffic, (k + 1) * step)
        plastic.scratch.filters.charge[1] += fired * plastic.tables.spike
        step_plastic(plastic, state, bits, step, excite)
        settle(plastic)
        found[k] = plastic.arrays.weights[0, 0]
    return found, step * np.arange(1, steps + 1, dtype=np.float64)


def moves(weights: Sequence[float], times: F64, events: Sequence[float], step: float) -> tuple[int, ...]:
    """Return which way each event moved a weight by more than `MOVES`: 1 up, -1 down, 0 not."""
    return tuple(int(np.sign(x)) if abs(x) > MOVES else 0 for x in sizes(weights, times, events, step))


def sizes(weights: Sequence[float], times: F64, events: Sequence[float], step: float) -> F64:
    """Return by how much each event moved a weight, V, float64[events]."""
    after, before = (np.interp(np.array(events) + n * step, times, weights) for n in (2.0, -1.0))
    return np.asarray(after - before)


def prepared(silicon: Silicon, kind: BiasKind, step: float) -> tuple[Plastic, F64]:
    """Return COPIES of the pair for the chip's kernel, their weights low, and rows of a chip's state."""
    circuit = rebias(pair(), {}, kind)
    d = standing(circuit, silicon).taken(np.zeros(COPIES, dtype=np.int64))
    volts = {b.port: np.asarray(bias_voltages(circuit, b, silicon)) for b in circuit.biases}
    gates = {p: v for p, v in volts.items() if not p.startswith("n_")}
    own = {p.removeprefix("n_"): v for p, v in volts.items() if p.startswith("n_")}
    synapse = model_of(dpi_synapse.build(), silicon.process)
    cells = cells_of(
        _part(d, "synapse.cell.", gates), cell_model(plastic_synapse.Params(), silicon.process), LINE
    )
    learners = gates_of(_part(d, "neuron.gate.", own), gate_model(calcium_gate.Params(), silicon.process))
    lengths = pulse_length(synapse, _part(d, "synapse.extender.", gates, "extender."))
    spikes = pulse_length(synapse, _part(d, "neuron.extender.", own, "extender."))
    one = np.eye(COPIES, dtype=np.bool_)
    tiled = (np.tile(getattr(cells, name)[:1], COPIES**2) for name in CELL_ARRAYS)
    shared = Cells._make((*tiled, np.ravel(cells.capacitance)[:1], cells.effect))
    parts = Parts(
        learners.filter, shared, learners, lengths, spikes, one, np.zeros((COPIES, 1, 2), np.float32),
        learners.membrane, silicon.process.v_dd,
    )  # fmt: skip
    built = assemble(parts, step)
    start = rest_of_plastic(built, np.zeros((COPIES, COPIES), np.bool_), step)
    state = np.zeros((STATE_ROWS, COPIES))
    state[SHUT] = NEVER
    none = np.empty(0)
    events = PlasticEvents(none, none.astype(np.int64), none.astype(np.int64))
    return Plastic(built.tables, arrays_of(start), events, scratch_of(new_scratch(COPIES))), state


def _part(d: DieDevices, prefix: str, gates: dict[str, F64], new: str = "") -> DieDevices:
    return d.renamed(prefix, new)._replace(gate=gates)
