"""Power of ROLLS' plastic array: what its parts take at rest and an event, by the transistor-level solver.

    P = P_rest + N_high P_high + N_low P_low
        + rate [256 (E_extender + E_spike) + N_high E_high + N_low E_low]

of a chip whose neurons all fire at `rate`: every one of them is a column of the array, and its own spike goes
to its learning circuit with an extender. E of an event is the difference of runs with three and with one, of
a synapse whose weight is high or low and is not moved; what a high weight draws comes from the supply,
through its filter. The biases are among those of `chips.rolls_power`, the slow filters among its filters.
Not counted: the charge that moves a weight (0.03 pJ for 0.18 V), and what the NMDA gate passes.

A high weight takes 7 uW at rest: its comparator's output is no lower than the pair's tail, 0.58 V, at which
the short inverter behind it conducts 4 uA. 65,536 of them would take 0.5 W, a hundred times what ROLLS takes,
so that the chip's own comparator is another one; the behavioural model takes no notice of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from chips.rolls_address import NEURONS
from chips.rolls_bias_file import BiasTable
from chips.rolls_plastic_biases import CELL_BIASES, GATE_BIASES, PULSE
from chips.rolls_plastic_circuit import Learning
from circuits.bias import rebias
from circuits.blocks import calcium_gate, plastic_synapse
from circuits.blocks.rebound_neuron import pulse
from circuits.circuit import BiasKind, Circuit, Node
from circuits.devices import Source
from circuits.devices.source import Constant
from circuits.errors import ParameterError
from circuits.silicon import Silicon
from circuits.solver.power import delivered_energy
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

RTOL = 1e-5
EVENTS, RATE = (1, 3), 500.0  # of two runs, and their rate, Hz; ours
REST, RUN = 10e-3, 40e-3  # s, ours
FIRST = 1e-3  # s, of the first event; ours


@dataclass(frozen=True, slots=True)
class PlasticEnergies:
    """rest: W of all learning circuits and extenders; low_rest, high_rest: of a synapse, by its weight.

    All else J an event: extender: of a column; spike: of a neuron in its learning circuit and that one's
    extender; low, high: of a synapse, by its weight.
    """

    rest: float
    low_rest: float
    high_rest: float
    extender: float
    spike: float
    low: float
    high: float

    def power(self, rate: float, high: int = 0) -> float:
        """W where all neurons fire at `rate` Hz; high: how many of the weights are.

        Raises `ParameterError` for more weights than the array has.
        """
        total = NEURONS * NEURONS
        if not 0 <= high <= total:
            raise ParameterError(f"power.high: {high}, must be 0 to {total}; the array has {total} weights")
        low = total - high
        still = self.rest + high * self.high_rest + low * self.low_rest
        events = NEURONS * (self.extender + self.spike) + high * self.high + low * self.low
        return still + rate * events


def plastic_energies(
    table: BiasTable, silicon: Silicon, kind: BiasKind = "gate", learning: Learning | None = None
) -> PlasticEnergies:
    """Measure the parts of a plastic array with the biases of `table`, on what the die's devices share."""
    sizes = Learning() if learning is None else learning
    on = replace(silicon, die=replace(silicon.die, mismatch=False))
    cell = _biased(plastic_synapse.build(sizes.cell), {"i_pwlk": PULSE, **CELL_BIASES}, table, kind)
    gate = _biased(calcium_gate.build(sizes.gate), {"i_pwlk": PULSE, **GATE_BIASES}, table, kind)
    extender, still = _measured(_extender(cell), {}, on)
    (low, low_rest), (high, high_rest) = (_measured(cell, {"up": up}, on) for up in (0.0, -1.0))
    spike, learner = _measured(gate, {"membrane": 0.0}, on)
    return PlasticEnergies(
        NEURONS * (still + learner), low_rest - still, high_rest - still, extender, spike, low - extender,
        high - extender,
    )  # fmt: skip


def _biased(block: Circuit, names: Mapping[str, str], table: BiasTable, kind: BiasKind) -> Circuit:
    """A block that stands alone with the chip's biases."""
    return rebias(
        block, {b.name: table.current(names[b.name]) for b in block.biases if b.name in names}, kind
    )


def _extender(cell: Circuit) -> Circuit:
    """The extender of a synapse, alone."""
    kept = tuple(i for i in cell.instances if i.name == "extender")
    ports = tuple(p for p in cell.ports if p.name in ("vdd", "event", "v_pwlk"))
    biases = tuple(b for b in cell.biases if b.port == "v_pwlk")
    nodes = (*cell.nodes, Node("pulse", ())) if "pulse" not in {n.name for n in cell.nodes} else cell.nodes
    return replace(cell, name="plastic_extender", ports=ports, instances=kept, nodes=nodes, biases=biases)


def _measured(circuit: Circuit, held: Mapping[str, float], silicon: Silicon) -> tuple[float, float]:
    """Energy of an event, J, and power at rest, W."""
    few, many = (_energy(_bench(circuit, held, count, RUN, silicon), silicon) for count in EVENTS)
    quiet = _energy(_bench(circuit, held, 0, REST, silicon), silicon) / REST
    return (many - few) / (EVENTS[1] - EVENTS[0]), quiet


def _bench(
    circuit: Circuit, held: Mapping[str, float], count: int, duration: float, silicon: Silicon
) -> Testbench:
    """`count` events; a synapse from its rail, not moved."""
    v_dd = silicon.process.v_dd
    values: dict[str, float | None] = {"events": 1.0, "spikes": 1.0, "rate": RATE, "duration": duration}
    times = tuple(FIRST + k / RATE for k in range(count))
    event = Source("event", "event", pulse(times, v_dd) if count else Constant(0.0))
    if not held:
        return Testbench(circuit.name, circuit, (Source("vdd", "vdd", Constant(v_dd)), event), duration)
    make = plastic_synapse.testbench if "up" in held else calcium_gate.testbench
    bench = make(circuit, {**values, **held}, v_dd)
    given = {"event": event, "dn": Source("dn", "dn", Constant(0.0))}
    return replace(bench, sources=tuple(given.get(s.name, s) for s in bench.sources))


def _energy(bench: Testbench, silicon: Silicon) -> float:
    """What the sources delivered, J, the line's charge from the supply."""
    found = delivered_energy(simulate(bench, silicon, rtol=RTOL))
    scale = silicon.process.v_dd / plastic_synapse.LINE
    return sum(energy * (scale if name == "line" else 1.0) for name, energy in found.items())
