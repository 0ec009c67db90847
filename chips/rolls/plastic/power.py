"""Power of ROLLS' plastic array, at rest and an event, by the transistor-level solver.

    P = P_rest + N_high P_high + N_low P_low
        + rate [256 (E_extender + E_spike(rate)) + N_high E_high + N_low E_low]

of a chip whose neurons all fire at `rate`: every one of them is a column of the array, and its own spike goes
to its learning circuit with an extender. E of an event is the difference of runs with three and with one, of
a synapse whose weight is high or low and is not moved; what a high weight draws comes from the supply,
through its filter. E_spike is of whole periods when calcium has settled at the rate, the power at rest taken
off: it holds what the inverters at the calcium's nodes burn where the rate keeps such a node between the
rails, up to 52 nJ a spike where an extender takes 0.05. The biases are among those of `chips.rolls.power`,
the slow filters among its filters. Not counted: the charge that moves a weight (0.03 pJ for 0.18 V), and what
the NMDA gate passes.

At rest a weight takes I_cmp in one of its comparator's branches, and leaks: 0.09 nW with the default codes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from chips.rolls.plastic.biases import CELL_BIASES, GATE_BIASES, PULSE
from chips.rolls.plastic.circuit import Learning
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.rolls import calcium_gate, plastic_synapse
from circuits.circuit import BiasKind, Circuit, Node
from circuits.devices import Source
from circuits.devices.source import Constant
from circuits.errors import ParameterError
from circuits.event import pulse
from circuits.silicon.silicon import Silicon
from circuits.solver.power import delivered_energy
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

RTOL = 1e-5
EVENTS, RATE = (1, 3), 500.0  # of two runs, and their rate, Hz; ours
REST, RUN = 10e-3, 40e-3  # s, ours
FIRST = 1e-3  # s, of the first event; ours
AT_GROUND = {"membrane": 0.0}  # of a learning circuit
SPIKE_RATES = (5.0, 20.0, 50.0, 100.0, 300.0)  # Hz, at which E_spike is taken; ours
SETTLED, WINDOW = 0.4, 0.1  # s, ours: until calcium has settled, and over which E_spike is a mean


@dataclass(frozen=True, slots=True)
class PlasticEnergies:
    """Powers and energies of the plastic array's parts.

    rest: of all learning circuits and extenders, W; low_rest, high_rest: of a synapse, by its weight, W;
    extender: of an event of a column, low, high: of a synapse, by its weight, J; spike: of a neuron in its
    learning circuit and that one's extender, J, over the rate, float64[k], by rising rates (Hz).
    """

    rest: float
    low_rest: float
    high_rest: float
    extender: float
    low: float
    high: float
    rates: F64
    spike: F64

    def spike_at(self, rate: float) -> float:
        """Return E_spike at a rate, J, by a line over its logarithm, held beyond the ends."""
        return float(np.interp(np.log(max(rate, 1e-9)), np.log(self.rates), self.spike))

    def power(self, rate: float, high: int = 0) -> float:
        """Return the power where all neurons fire at `rate` Hz, W; high: how many of the weights are high.

        Raises `ParameterError` for more weights than the array has.
        """
        total = NEURONS * NEURONS
        if not 0 <= high <= total:
            raise ParameterError(f"power.high: {high}, must be 0 to {total}; the array has {total} weights")
        low = total - high
        still = self.rest + high * self.high_rest + low * self.low_rest
        events = NEURONS * (self.extender + self.spike_at(rate)) + high * self.high + low * self.low
        return still + rate * events


def lacking(table: BiasTable) -> tuple[str, ...]:
    """Return the biases of the array that a table does not have, as that of a chip without one."""
    needed = (PULSE, *CELL_BIASES.values(), *GATE_BIASES.values())
    return tuple(name for name in needed if name not in table.names)


def plastic_energies(
    table: BiasTable, silicon: Silicon, kind: BiasKind = "gate", learning: Learning | None = None
) -> PlasticEnergies:
    """Measure the parts of a plastic array with the biases of `table`, on what the die's devices share.

    Raises `UnknownNameError` for a bias that the table lacks.
    """
    sizes = Learning() if learning is None else learning
    on = replace(silicon, die=silicon.die.without_mismatch())
    cell = _biased(plastic_synapse.build(sizes.cell), {"i_pwlk": PULSE, **CELL_BIASES}, table, kind)
    gate = _biased(calcium_gate.build(sizes.gate), {"i_pwlk": PULSE, **GATE_BIASES}, table, kind)
    extender, still = _measured(_extender(cell), {}, on)
    (low, low_rest), (high, high_rest) = (_measured(cell, {"up": up}, on) for up in (0.0, -1.0))
    learner = _energy(_bench(gate, AT_GROUND, (), REST, on), on) / REST
    spike = np.array([_spike(gate, rate, learner, on) for rate in SPIKE_RATES])
    return PlasticEnergies(
        NEURONS * (still + learner), low_rest - still, high_rest - still, extender, low - extender,
        high - extender, np.array(SPIKE_RATES), spike,
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
    times = (tuple(FIRST + k / RATE for k in range(count)) for count in EVENTS)
    few, many = (_energy(_bench(circuit, held, each, RUN, silicon), silicon) for each in times)
    quiet = _energy(_bench(circuit, held, (), REST, silicon), silicon) / REST
    return (many - few) / (EVENTS[1] - EVENTS[0]), quiet


def _spike(gate: Circuit, rate: float, quiet: float, silicon: Silicon) -> float:
    """Energy of a spike of a neuron that fires at `rate` Hz in its learning circuit, J; quiet: W at rest."""
    count = max(1, round(WINDOW * rate))
    begin = (np.ceil(SETTLED * rate) - 0.5) / rate
    end = begin + count / rate
    times = tuple(np.arange(0.5, end * rate) / rate)
    result = simulate(_bench(gate, AT_GROUND, times, end, silicon), silicon, rtol=RTOL)
    inside = result.time >= begin
    part = replace(result, time=result.time[inside], voltage=result.voltage[inside])
    span = float(part.time[-1] - part.time[0])
    return (sum(delivered_energy(part).values()) - quiet * span) / count


def _bench(
    circuit: Circuit, held: Mapping[str, float], times: tuple[float, ...], duration: float, silicon: Silicon
) -> Testbench:
    """Events at `times`; a synapse's weight is held at its rail, which leaks may not do when it is warm."""
    v_dd = silicon.process.v_dd
    values: dict[str, float | None] = {"events": 1.0, "spikes": 1.0, "rate": RATE, "duration": duration}
    event = Source("event", "event", pulse(times, v_dd) if times else Constant(0.0))
    if not held:
        return Testbench(circuit.name, circuit, (Source("vdd", "vdd", Constant(v_dd)), event), duration)
    make = plastic_synapse.testbench if "up" in held else calcium_gate.testbench
    bench = make(circuit, {**values, **held}, v_dd)
    given = {
        "event": event,
        "dn": Source("dn", "dn", Constant(0.0)),
        "up_b": Source("up_b", "up_b", Constant(v_dd)),
    }
    sources = tuple(given.get(s.name, s) for s in bench.sources)
    if "up" not in held:
        return replace(bench, sources=sources)
    weight = Source("w", "w", Constant(v_dd if held["up"] < 0.0 else 0.0))
    free = {node: v for node, v in bench.start.items() if node != "w"}
    return replace(bench, sources=(*sources, weight), start=free)


def _energy(bench: Testbench, silicon: Silicon) -> float:
    """What the sources delivered, J, the line's charge from the supply."""
    found = delivered_energy(simulate(bench, silicon, rtol=RTOL))
    scale = silicon.process.v_dd / plastic_synapse.LINE
    return sum(energy * (scale if name == "line" else 1.0) for name, energy in found.items())
