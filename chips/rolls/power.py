"""Power of a ROLLS chip, from its bias currents and the energies of a spike and of a synaptic event.

    P = V_dd sum of bias currents + P_rest + 256 f E_spike(f) + 256 f E_column
        + sum over latched synapses of f E_event(level)

Energies are what the supplies of transistor-level runs deliver, as slopes over the count of spikes or events.
`E_spike(f)` is of whole periods at the rate f, the power at rest taken off: it holds what the neuron burns
between spikes because it fires (its comparator crosses slowly). A column's event makes a pulse that all 256
synapses of the column see, latched or not; a latched one takes E_event more.

Not counted: the generator's own reference and splitters, address decoders, arbiters and pads, and
the wires' capacitance; the plastic array is in `chips.rolls.plastic.power`, cells of depression in
`chips.rolls.depression.power`. Every bias counts once, as its diode-connected copy's branch (ours).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from chips.rolls.circuit import FILTERS, Params, biases, chip
from chips.rolls.parts import gate_voltages, part_gates
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.program import missing_levels
from circuits.arrays import F64
from circuits.bias import rebias
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.circuit import BiasKind, Circuit
from circuits.devices import Source
from circuits.devices.source import Constant, Waveform
from circuits.errors import ParameterError
from circuits.event import pulse
from circuits.silicon.process import kelvin
from circuits.silicon.silicon import Silicon
from circuits.solver.power import delivered_energy, supply_power
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench

TYPICAL = 4e-3  # W; Qiao et al. 2015, abstract, and Milde et al. 2017
RTOL = 1e-5
LINE = 0.3  # V, ours: of the lines of a synapse that stands alone
EVENTS, EVENT_RATE = (1.0, 3.0), 500.0  # events of two runs, and their rate, Hz; ours
REST, RUN = 10e-3, 40e-3  # s, of runs without and with events; ours
MULTIPLES = (1.5, 3.0, 10.0, 40.0)  # of the rheobase, at which E_spike is taken; ours
LEVELS = (1, 2, 3, 4, -1, -2, -3, -4)
FEWEST = 4  # spikes of a run that counts
LONGER = (4.0, 16.0)  # times RUN, where it has fewer
_FILTER_BIASES = {"etau": "excitatory_tau", "ethr": "excitatory_thr", "itau": "inhibitory_tau",
                  "ithr": "inhibitory_thr"}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Energies:
    """Energies and powers of a chip's parts.

    rates (Hz), spike (J): E_spike over the rate, float64[k], by rising rate; event: by level, J, beside what
    an unlatched synapse takes; column: of a column's event without any latched synapse, J; rest: of all
    neurons, filters, synapses and extenders without events, W; biases: W.
    """

    rates: F64
    spike: F64
    event: Mapping[int, float]
    column: float
    rest: float
    biases: float

    def spike_at(self, rate: float) -> float:
        """Return E_spike at a rate, J, by a line over its logarithm, held beyond the ends."""
        return float(np.interp(np.log(max(rate, 1e-9)), np.log(self.rates), self.spike))

    def power(self, rate: float, latched: Mapping[int, int]) -> float:
        """Return the power of a chip whose neurons all fire at `rate` Hz, W; latched: synapses by level."""
        synapses = sum(count * self.event[level] for level, count in latched.items())
        each = self.spike_at(rate) + self.column
        return self.biases + self.rest + rate * (NEURONS * each + synapses)


def energies(
    table: BiasTable,
    silicon: Silicon,
    rheobase: float,
    kind: BiasKind = "gate",
    params: Params | None = None,
) -> Energies:
    """Measure the parts of a chip with the biases of `table`, on what the die's devices share.

    rheobase: A, of a neuron without I_dc. Raises `ParameterError` where no run has spikes.
    """
    params = Params() if params is None else params
    on = replace(silicon, die=replace(silicon.die, mismatch=False))
    gates = gate_voltages(chip(params, table, kind), on)
    extender = _Part(dpi_synapse.pulse_extender(params.synapse), part_gates("extender", gates))
    off = dict.fromkeys(("pulse", *dpi_synapse.LATCHES), 0.0)
    synapse = _Part(
        dpi_synapse.synapse(params.synapse),
        part_gates("synapse", gates) | off | {"exc": LINE, "inh": LINE},
    )
    rest = _rest(extender, on, {"event": 0.0}), _rest(synapse, on, {})
    neuron = _biased(rolls_neuron.build(params.neuron), table, kind)
    quiet = supply_power(_neuron_run(neuron, on, 0.0, REST))
    rates, spike = _spikes(neuron, on, rheobase, quiet)
    both = _biased(dpi_synapse.build(params.synapse), table, kind)
    silent = supply_power(_synapse_run(both, on, 0, 0.0, REST))
    filters = max(silent - sum(rest), 0.0) / 2.0
    virtual = params.virtual.excitatory + params.virtual.inhibitory
    extenders, synapses = NEURONS * (1 + virtual), NEURONS * (NEURONS + virtual)
    still = extenders * rest[0] + synapses * rest[1] + NEURONS * (quiet + (len(FILTERS) + 1) * filters)
    unlatched = _event(both, on, 0)
    alone = _extender_event(extender, on)
    levels = [level for level in LEVELS if level not in missing_levels(table)]
    event = {level: _event(both, on, level) - unlatched for level in levels}
    return Energies(rates, spike, event, alone + NEURONS * (unlatched - alone), still, bias_power(table, on))


def bias_power(table: BiasTable, silicon: Silicon) -> float:
    """Return the supply times the sum of all bias currents of `table`, W, at the temperature of `silicon`.

    The generator's currents are proportional to absolute temperature.
    """
    total = sum(table.current(name) for name in table.codes() if not table.is_off(name))
    scale = kelvin(silicon.temperature_c) / kelvin(silicon.process.nominal_temperature_c)
    return silicon.process.v_dd * total * scale


@dataclass(frozen=True, slots=True)
class _Part:
    """A part alone, and voltages of its ports."""

    circuit: Circuit
    levels: Mapping[str, float]


def _biased(block: Circuit, table: BiasTable, kind: BiasKind) -> Circuit:
    """A block that stands alone with the chip's biases; I_dc is off."""
    off = table.with_code("IF_DC_P", 7, 0)
    chip_has = {b.name: float(np.ravel(b.value)[0]) for b in biases(off) if b.kind != "voltage"}
    own = {b.name: chip_has.get(f"i_{_FILTER_BIASES.get(b.name[2:], b.name[2:])}") for b in block.biases}
    return rebias(block, {name: value for name, value in own.items() if value is not None}, kind)


def _bench(part: _Part, levels: Mapping[str, Waveform], stop: float) -> Testbench:
    waves: dict[str, Waveform] = {k: Constant(v) for k, v in part.levels.items() if k != "0"}
    known = {p.name for p in part.circuit.ports}
    sources = (Source(k, k, w) for k, w in (waves | dict(levels)).items() if k in known)
    return Testbench(part.circuit.name, part.circuit, tuple(sources), stop)


def _rest(part: _Part, silicon: Silicon, levels: Mapping[str, float]) -> float:
    """Power of a part at rest, W."""
    waves = {k: Constant(v) for k, v in levels.items()} | {"vdd": Constant(silicon.process.v_dd)}
    return supply_power(simulate(_bench(part, waves, 1e-3), silicon, rtol=RTOL))


def _extender_event(part: _Part, silicon: Silicon) -> float:
    """Energy of an event of a pulse extender without load, J."""
    found = []
    for count in EVENTS:
        wave = pulse(tuple(1e-3 + k / EVENT_RATE for k in range(int(count))), silicon.process.v_dd)
        bench = _bench(part, {"event": wave, "vdd": Constant(silicon.process.v_dd)}, RUN)
        found.append(_energy(simulate(bench, silicon, rtol=RTOL)))
    return (found[1] - found[0]) / (EVENTS[1] - EVENTS[0])


def _neuron_run(circuit: Circuit, silicon: Silicon, current: float, duration: float) -> Result:
    stimuli = rolls_neuron.BLOCK.defaults
    values = stimuli | {"current": current, "duration": duration}
    return simulate(rolls_neuron.testbench(circuit, values, silicon.process.v_dd), silicon, rtol=RTOL)


def _synapse_run(circuit: Circuit, silicon: Silicon, level: int, events: float, duration: float) -> Result:
    """Without an event the first of one comes after the end."""
    rate = EVENT_RATE if events else 1.0
    values = {"level": float(level), "events": max(events, 1.0), "rate": rate, "duration": duration}
    bench = dpi_synapse.testbench(circuit, values, silicon.process.v_dd)
    if not events:
        quiet = tuple(replace(s, waveform=Constant(0.0)) if s.name == "event" else s for s in bench.sources)
        bench = replace(bench, sources=quiet)
    return simulate(bench, silicon, rtol=RTOL)


def _event(circuit: Circuit, silicon: Silicon, level: int) -> float:
    """Energy of an event at a synapse of a level with its pulse, J."""
    few, many = (_energy(_synapse_run(circuit, silicon, level, count, RUN)) for count in EVENTS)
    return (many - few) / (EVENTS[1] - EVENTS[0])


def _spikes(circuit: Circuit, silicon: Silicon, rheobase: float, quiet: float) -> tuple[F64, F64]:
    """Rates, Hz, and energies a spike, J, of a neuron; quiet: its power at rest, W."""
    found = []
    for multiple in MULTIPLES:
        result = _neuron_run(circuit, silicon, multiple * rheobase, RUN)
        for longer in LONGER:
            if result.spikes["spike"].size >= FEWEST:
                break
            result = _neuron_run(circuit, silicon, multiple * rheobase, longer * RUN)
        times = result.spikes["spike"]
        if times.size >= FEWEST:
            # whole periods, cut where little flows
            begin, end = 0.5 * (times[0] + times[1]), 0.5 * (times[-2] + times[-1])
            kept = (result.time >= begin) & (result.time <= end)
            part = replace(result, time=result.time[kept], voltage=result.voltage[kept])
            count, span = times.size - 2, float(part.time[-1] - part.time[0])
            found.append((count / (end - begin), (_energy(part) - quiet * span) / count))
    if not found:
        raise ParameterError(
            f"power.rheobase: {rheobase:g} A, must make the neuron fire within {LONGER[-1] * RUN:g} s;"
            " give another bias file"
        )
    rates, spike = np.array(sorted(found)).T
    return rates, spike


def _energy(result: Result) -> float:
    """What the supplies delivered, J."""
    return sum(delivered_energy(result).values())
