"""Power of a ROLLS chip by block: static, of its biases, and dynamic.

    P = P_static + P_bias + P_dynamic
    P_bias = V_dd (sum I_bias + sum I_coarse + sum of the coarse splitter's branches)
    P_dynamic = sum over neurons of f (E_spike(f) + E_column) + sum over levels of r_level E_event(level)
        + sum over signs of r_virtual E_virtual(sign)

f: rate of a neuron, r: events a second at all latched synapses of a level, and at all virtual ones of a sign.
P_static is that of neurons, filters, synapses and pulse extenders without events. Every command takes the
power of this chip from `chip_power`.

Energies are what the supplies of transistor-level runs deliver, as slopes over the count of spikes or events.
`E_spike(f)` is of whole periods at the rate f, the power at rest taken off: it holds what the neuron burns
between spikes because it fires (its comparator crosses slowly). A column's event makes a pulse that all 256
synapses of the column see, latched or not; a latched one takes E_event more.

Every bias counts once as its diode-connected copy's branch (ours), and once as the splitter of its fine code,
which takes the whole coarse current whatever the code is (`circuits.blocks.bias.generator`); the coarse
splitter counts once a chip (ours).

Not counted: the generator's core, address decoders, arbiters and pads, and the wires' capacitance; the
plastic array is in `chips.rolls.plastic.power`, cells of depression in `chips.rolls.depression.power`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from chips.rolls.chip import RollsChip
from chips.rolls.circuit import FILTERS, Params, biases, chip
from chips.rolls.parts import gate_voltages, part_gates
from chips.rolls.portrait import LEAST, nominal_neuron, rheobase
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.program import Program, missing_levels
from circuits.arrays import F64, I64
from circuits.bias import rebias
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.circuit import BiasKind, Circuit
from circuits.devices import Source
from circuits.devices.source import Constant, Waveform
from circuits.errors import ParameterError
from circuits.event import pulse
from circuits.generator.code import COARSE
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
MEASURED = 32  # chips whose energies are kept; ours
VIRTUAL: Mapping[int, Mapping[str, str]] = {  # by sign: biases of a block, and those of the chip it has there
    1: {"i_exc": "VA_EXC_N", "i_etau": "VDPIE_TAU_P", "i_ethr": "VDPIE_THR_P"},
    -1: {"i_inh": "VA_INH_P", "i_itau": "VDPII_TAU_N", "i_ithr": "VDPII_THR_N"},
}
_FILTER_BIASES = {"etau": "excitatory_tau", "ethr": "excitatory_thr", "itau": "inhibitory_tau",
                  "ithr": "inhibitory_thr"}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Activity:
    """What happens on a chip.

    Attributes
    ----------
    rates : array
        Rate of every neuron, float64[256], Hz.
    synapses : mapping of int to float
        Events a second at all latched non-plastic synapses together, by their level, Hz.
    virtual : mapping of int to float
        Events a second at all virtual synapses together, by their sign, 1 or -1, Hz.
    """

    rates: F64
    synapses: Mapping[int, float] = field(default_factory=dict)
    virtual: Mapping[int, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Power:
    """Power of a chip by block, W.

    Attributes
    ----------
    static : mapping of str to float
        Leakage and rest currents of neurons, filters, synapses and extenders.
    bias : mapping of str to float
        The biases' branches and the generator's splitters.
    dynamic : mapping of str to float
        Spikes of neurons, events of columns, of latched synapses, and of virtual ones.
    """

    static: Mapping[str, float]
    bias: Mapping[str, float]
    dynamic: Mapping[str, float]

    @property
    def parts(self) -> dict[str, float]:
        """Sums of the three by their names, W."""
        return {
            "static": sum(self.static.values()),
            "bias": sum(self.bias.values()),
            "dynamic": sum(self.dynamic.values()),
        }

    @property
    def total(self) -> float:
        """Power of the chip, W."""
        return sum(self.parts.values())


@dataclass(frozen=True, slots=True)
class Energies:
    """Energies and powers of a chip's parts.

    rates (Hz), spike (J): E_spike over the rate, float64[k], by rising rate; event: by level, J, beside what
    an unlatched synapse takes; virtual: of an event at a virtual synapse with its extender, by sign, J;
    column: of a column's event without any latched synapse, J; still: of neurons, filters, synapses and
    extenders without events, W; biases, generator: of the biases' branches and of the splitters, W.
    """

    rates: F64
    spike: F64
    event: Mapping[int, float]
    virtual: Mapping[int, float]
    column: float
    still: Mapping[str, float]
    biases: float
    generator: float

    @property
    def rest(self) -> float:
        """Power of all neurons, filters, synapses and extenders without events, W."""
        return sum(self.still.values())

    def spike_at(self, rate: F64 | float) -> F64:
        """Return E_spike at a rate, J, by a line over its logarithm, held beyond the ends."""
        return np.asarray(np.interp(np.log(np.maximum(rate, 1e-9)), np.log(self.rates), self.spike))

    def power(self, rate: float, latched: Mapping[int, int]) -> float:
        """Return the power of a chip whose neurons all fire at `rate` Hz, W; latched: synapses by level."""
        synapses = {level: rate * count for level, count in latched.items()}
        return chip_power(self, Activity(np.full(NEURONS, rate), synapses)).total


def chip_power(e: Energies, activity: Activity) -> Power:
    """Return the power of a chip by block.

    Raises `ParameterError` for events at a level or a sign whose energy was not measured.

    Parameters
    ----------
    e
        Energies of the chip's parts.
    activity
        What happens on it.
    """
    dynamic = {
        "neurons": float((activity.rates * e.spike_at(activity.rates)).sum()),
        "columns": float(activity.rates.sum()) * e.column,
        "synapses": _events(activity.synapses, e.event, "level"),
        "virtual": _events(activity.virtual, e.virtual, "sign"),
    }
    return Power(dict(e.still), {"branches": e.biases, "generator": e.generator}, dynamic)


def _events(rates: Mapping[int, float], energy: Mapping[int, float], what: str) -> float:
    """Power of events, W."""
    for key, rate in rates.items():
        if rate and key not in energy:
            raise ParameterError(
                f"power.activity: {rate:g} Hz at {what} {key}, must have an energy; its bias is off"
            )
    return sum(rate * energy[key] for key, rate in rates.items() if rate)


def activity_of(program: Program, spikes: I64, virtual: Mapping[int, int], duration: float) -> Activity:
    """Return what a run made happen: every spike goes to its column, and to all synapses latched in it.

    Raises `ParameterError` for a duration that is not above 0.

    Parameters
    ----------
    program
        Program of the chip.
    spikes
        Neuron of every spike, int64[m].
    virtual
        How many events came to virtual synapses, by their sign.
    duration
        Of the run, s.
    """
    if not duration > 0.0:
        raise ParameterError(f"power.duration: {duration:g} s, must be > 0; give that of the run")
    rates = np.bincount(spikes, minlength=NEURONS) / duration
    used = {int(level) for level in np.unique(program.levels)} - {0}
    synapses = {level: float(((program.levels == level).sum(axis=0) * rates).sum()) for level in used}
    return Activity(rates, synapses, {sign: count / duration for sign, count in virtual.items()})


def energies_of(chip: RollsChip) -> Energies:
    """Return the energies of a chip's parts, measured once for all chips of its biases and silicon.

    Raises `ParameterError` where no run has spikes.
    """
    on = replace(chip.silicon, die=chip.silicon.die.without_mismatch())
    return _energies_of(chip.program.biases, on, chip.kind, chip.params)


@lru_cache(maxsize=MEASURED)
def _energies_of(table: BiasTable, silicon: Silicon, kind: BiasKind, params: Params) -> Energies:
    one = nominal_neuron(table, silicon, kind, params)
    return energies(table, silicon, max(float(rheobase(one)[0]), LEAST), kind, params)


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
    on = replace(silicon, die=silicon.die.without_mismatch())
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
    still = {
        "neurons": NEURONS * quiet,
        "filters": NEURONS * (len(FILTERS) + 1) * filters,
        "synapses": synapses * rest[1],
        "extenders": extenders * rest[0],
    }
    unlatched = _event(both, on, 0)
    alone = _extender_event(extender, on)
    levels = [level for level in LEVELS if level not in missing_levels(table)]
    event = {level: _event(both, on, level) - unlatched for level in levels}
    lone = {
        sign: _event(rebias(both, {own: table.current(name) for own, name in names.items()}, kind), on, sign)
        for sign, names in VIRTUAL.items()
        if not table.is_off(next(iter(names.values())))
    }
    column = alone + NEURONS * (unlatched - alone)
    return Energies(
        rates, spike, event, lone, column, still, bias_power(table, on), generator_power(table, on)
    )


def bias_power(table: BiasTable, silicon: Silicon) -> float:
    """Return the supply times the sum of all bias currents of `table`, W, at the temperature of `silicon`.

    The generator's currents are proportional to absolute temperature.
    """
    total = sum(table.current(name) for name in table.codes() if not table.is_off(name))
    return _ptat_power(total, silicon)


def generator_power(table: BiasTable, silicon: Silicon) -> float:
    """Return what the splitters of the bias generator take, W, at the temperature of `silicon`.

    The splitter of a bias's fine code takes its whole coarse current, on or off; the coarse splitter takes
    the sum of all coarse currents, once.
    """
    fine = sum(COARSE[coarse] for coarse, _ in table.codes().values())
    return _ptat_power(fine + sum(COARSE), silicon)


def _ptat_power(current: float, silicon: Silicon) -> float:
    """Power of a current, A at the nominal temperature, that is proportional to absolute temperature, W."""
    scale = kelvin(silicon.temperature_c) / kelvin(silicon.process.nominal_temperature_c)
    return silicon.process.v_dd * current * scale


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
