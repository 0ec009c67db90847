"""Measurement of the sonar head's record: charges, delays and offsets of its level units and LSO neurons.

With the transistor-level solver, over temperature and the threshold shift that a die's transistors of a
polarity share, with ideal currents:

    compared            current of the comparators, A, and `level_compared` of the level units', as measured
    timer, membrane     Q of a synapse's step and of a spike, C, threshold and parasitics in it
    onset, dead         charges (C) over the comparator's current: from an event to its current on the
                        membrane, and of the membrane near ground after a spike
    spike, lag          charge (C) that the pair of the membrane's comparator brings up, and over the
                        comparator's current how much later it spikes
    mirror              what an inhibitory current takes over what the same excitatory one gives
    gate, gate_rest     capacitance of the mirror's gate, F, and its voltage before any input, V
    level_offset        of a level unit's threshold, V
    level_charge        Q of its axon's input, C
    level_rest          how deep its input must rest to be heard, over that of the law (`chips.lso.rest`)
    level_lag           charge (C) over its comparator's current: how much later it spikes on any ramp

From when the membrane passes the reference with one input and with two, `t = Q / (n I - I_off) + t_onset`,
how much later it spikes with one input and with one of `STRONG` times its current (a timer's comparator is
another such), and from the interval of two, `Q / (2 I - I_off) + t_spike + t_dead`, where I_off is what
switches that are off take; the mirror from the interval of two inputs against one, its gate from how fast one
current charges it, and of a level unit on ramps of five slopes, by the laws of `chips.lso.law`. And over
temperature `comparator`, d ln Q / dx of each device's x, V_T0 (V) and ln beta, of the comparator that ends
all charges, `level`, slopes of level_offset by the level unit's comparator, and `axon`, d ln Q / dx of its
axon's input.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from chips.lso.law import Comparator, Membrane, ramp_delay, rise_time, spike_delay
from chips.lso.rest import DEVICES, LINE, PART, THRESHOLD, law_depth, pair_kappa
from chips.measured.perturbation import deviating, deviations_of, slopes
from chips.measured.table_record import TEMPERATURES, Quantities, measure_over, shifts
from chips.measured.timer import PARAMETERS, STEPS, timer_slopes
from chips.record import Record, Table
from chips.shot_noise import steepness
from circuits.arrays import F64
from circuits.bias import bias_voltages, rebias
from circuits.blocks.latency.synapse import REFERENCE
from circuits.blocks.latency.tonic import START
from circuits.blocks.lso import lso_neuron
from circuits.blocks.sonar import high_threshold_neuron
from circuits.catalogue import later
from circuits.circuit import Circuit
from circuits.devices import Source
from circuits.devices.channel import pinched, terms_of
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import SolverError
from circuits.event import EDGE, WIDTH
from circuits.lowering.kernel import to_kernel
from circuits.lowering.on_die import DieDevices, on_die, standing, transistor_of
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench

optimise = later("scipy.optimize")

LEVELS = 10  # level units of an ear, and synapses of either side of an LSO neuron; ours
SHIFTS = shifts(5)  # V
LEVEL_COMPARATOR = ("mc1", "mc2", "mc4", "mc5")
LEVEL_AXON = ("ma1", "ma3")  # whose thresholds say what its input takes
FOLLOWING = ("onset", "dead", "spike", "lag", "level_offset", "level_charge")
WEAK = 0.1  # of the comparators' usual currents, at which what follows them is measured again; ours
QUANTITIES = (
    "timer", "membrane", "mirror", "gate", "gate_rest", "level_rest", "level_lag", "compared",
    "level_compared", *FOLLOWING, *(f"{name}_weak" for name in FOLLOWING),
)  # fmt: skip
MEMBRANE_SWITCHES = ("cell.mz", "cell.mq")
TIMER_SWITCHES = ("excite0.mr",)
STRONG = 12.0  # times the usual current, of an input on whose ramp the comparator's pair turns at once; ours
SLOPES = 200.0, 600.0, 2e3, 6e3, 2e4  # V/s, of a level unit's ramps; an echo's edge: 600 to 30,000
SLOW, FAST = SLOPES[0], SLOPES[3]
GATE_PART = 0.25, 0.6  # of what the mirror's gate rises by: between them its rise is measured; ours
FROM, TO = -0.05, 1.0  # V about the threshold, of a ramp
AFTER = 0.5e-3  # s, for which a run goes on after it: weak comparators take a fifth of that
QUIET = 10e-3  # s, ours: before a ramp, three refractory periods
REST, REST_STEP = (0.7, 1.5), 2e-3  # of the law's depth, between which a unit begins to be heard; ours
RTOL = 1e-5
AT = 0.5e-3  # s, of the first input after the reset
STOP = 6e-3  # s, of the LSO neuron's runs: its steps last 4.6 ms at -10 degC


def circuits() -> tuple[Circuit, ...]:
    """Return what the record is measured from: an LSO neuron and a level unit."""
    return (
        lso_neuron.build(lso_neuron.Params(excitations=LEVELS, inhibitions=LEVELS)),
        high_threshold_neuron.build(),
    )


def measure(process: Process) -> Record:
    """Measure the record in a process without its errors; it takes eight minutes on one core."""
    silicons = [Silicon(process, t) for t in TEMPERATURES]
    timer = np.array([_timer_slopes(s) for s in silicons])
    level = np.array([_level_slopes(s) for s in silicons])
    axon = np.array([_axon_slopes(s) for s in silicons])
    return measure_over(quantities, circuits(), SHIFTS, {}, process).extended(
        {
            "comparator": Table(("temperature", "parameter"), timer),
            "level": Table(("temperature", "level_parameter"), level),
            "axon": Table(("temperature", "axon_parameter"), axon),
        },
        {
            "parameter": PARAMETERS,
            "level_parameter": deviations_of(LEVEL_COMPARATOR),
            "axon_parameter": deviations_of(LEVEL_AXON),
        },
    )


class Cell(NamedTuple):
    """An LSO neuron on a silicon, without mismatch.

    membrane: with its comparator; onset: of a current after its event, s; dead: time after a spike, s;
    one: its run with one input; compared: current of its comparator's tail, A.
    """

    membrane: Membrane
    onset: float
    dead: float
    one: Result
    compared: float


def quantities(silicon: Silicon) -> Quantities:
    """Return the quantities of the circuits on a silicon, with ideal biases, by name."""
    lso, level = (rebias(c, {}, "ideal") for c in circuits())
    usual, weak = (measured_cell(_compared_by(lso, part), silicon) for part in (1.0, WEAK))
    held = float(np.ravel(idle(standing(lso, silicon), *TIMER_SWITCHES))[0])
    step = own_current(lso, "i_step", silicon) - held
    lasted = (lso_neuron.measures(usual.one)["step_s"] or np.nan) - WIDTH
    late = spike_delay(usual.membrane._replace(leak=0.0), step, 0.0)  # of the timer's comparator, on its ramp
    current = own_current(lso, "i_exc", silicon)
    turned = heard(lso, silicon, excite_1=AT, excite_2=AT, inhibit_1=AT)
    slow = _enough(turned, 2)
    taken = _taken(usual.membrane, 2.0 * current, float(slow[1] - slow[0]) - usual.dead)
    gate, gate_rest = _gate(turned, START + AT, float(slow[0]), current)
    *own, lag = level_numbers(level, silicon)
    faint = _compared_by(level, WEAK)
    whole, part = (own_current(c, "i_cmp", silicon) for c in (level, faint))
    less = level_numbers(faint, silicon, lag * whole / part)  # on its ramps a lag and a charge are one
    return {
        "timer": (lasted - late) * step,
        "membrane": usual.membrane.capacitance * REFERENCE,
        "mirror": taken / current,
        "gate": gate,
        "gate_rest": gate_rest,
        "level_rest": _rest(level, silicon),
        "compared": usual.compared,
        "level_compared": whole,
        "level_lag": lag * whole,
        **_following(usual, own),
        **{f"{name}_weak": x for name, x in _following(weak, less).items()},
    }


def _compared_by(circuit: Circuit, part: float) -> Circuit:
    """The circuit with comparators of a part of their usual current."""
    return rebias(circuit, {"i_cmp": part * float(np.ravel(circuit.bias("i_cmp").value)[0])})


def _following(cell: Cell, level: Sequence[float]) -> Quantities:
    """The quantities that follow the comparators' currents, `FOLLOWING`; level: offset (V) and charge (C)."""
    comparator = cell.membrane.comparator
    return {
        "onset": cell.onset * cell.compared,
        "dead": cell.dead * cell.compared,
        "spike": comparator.charge,
        "lag": comparator.lag * cell.compared,
        "level_offset": level[0],
        "level_charge": level[1],
    }


def measured_cell(lso: Circuit, silicon: Silicon) -> Cell:
    """Measure an LSO neuron from what it does with one input, with two and with a strong one."""
    current, compared = (own_current(lso, name, silicon) for name in ("i_exc", "i_cmp"))
    leak = float(np.ravel(idle(standing(lso, silicon), *MEMBRANE_SWITCHES))[0])
    strong = rebias(lso, {"i_exc": STRONG * float(np.ravel(lso.bias("i_exc").value)[0])})
    one, two, other = (
        heard(lso, silicon, excite_1=AT),
        heard(lso, silicon, excite_1=AT, excite_2=AT),
        heard(strong, silicon, excite_1=AT),
    )
    first, second, third = _enough(one, 1), _enough(two, 2), _enough(other, 1)
    reached = [passed(r) - START - AT for r in (one, two)]
    nets = [k * current - leak for k in (1.0, 2.0)]
    charge = (reached[0] - reached[1]) / (1.0 / nets[0] - 1.0 / nets[1])
    late = [float(spikes[0]) - passed(r) for spikes, r in ((first, one), (third, other))]
    ends = nets[0], own_current(strong, "i_exc", silicon) - leak
    kappa = float(spike_kappa(lso, silicon, compared))
    membrane = _membrane(silicon, charge, (compared, kappa), ends, late)._replace(leak=leak)
    dead = float(second[1] - second[0]) - _risen(membrane, 2.0 * current, 0.0)
    return Cell(membrane, reached[1] - charge / nets[1], dead, one, compared)


def _enough(result: Result, count: int) -> F64:
    """The spikes (s) of a run, at least `count`."""
    spikes = result.spikes["spike"]
    if spikes.size < count:
        raise SolverError("sonar_head.membrane: too few spikes in the run; give it stronger currents")
    return np.asarray(spikes)


def _risen(membrane: Membrane, given: float, taken: float) -> float:
    """Time from an empty membrane to a spike, s; given, taken: A, but for what leaks."""
    net = given - membrane.leak
    return rise_time(membrane, 0.0, net, taken) + spike_delay(membrane, net, taken)


def _gate(result: Result, begin: float, end: float, current: float) -> tuple[float, float]:
    """Return the capacitance (F) of the mirror's gate, and its voltage before any input (V).

    begin: of an inhibitory current (A) into it, s; end: when it has long been charged, s.
    """
    v, t = result["turned"], result.time
    rest, last = (float(np.interp(x, t, v)) for x in (begin, end))
    within = (t >= begin) & (t <= end)
    at = np.interp([rest + part * (last - rest) for part in GATE_PART], v[within], t[within])
    return current * float(at[1] - at[0]) / ((GATE_PART[1] - GATE_PART[0]) * (last - rest)), rest


def passed(result: Result) -> float:
    """Return when a run's membrane first passes the reference, s."""
    v = result["v_mem"]
    k = int(np.argmax((v[1:] >= REFERENCE) & (v[:-1] < REFERENCE)))
    part = (REFERENCE - v[k]) / (v[k + 1] - v[k])
    return float(result.time[k] + part * (result.time[k + 1] - result.time[k]))


def _membrane(
    silicon: Silicon,
    charge: float,
    pair: tuple[float, float],
    currents: Sequence[float],
    late: Sequence[float],
) -> Membrane:
    """The membrane of a charge (C) that spikes so late (s) after its reference at two currents, A.

    pair: current (A) of its comparator's tail, and kappa.
    """
    tail, kappa = pair
    u_t = silicon.thermal_voltage
    slopes = [i * REFERENCE / charge for i in currents]

    def turned(spike: float) -> list[float]:
        return [float(ramp_delay(s, spike, tail, kappa, u_t)) for s in slopes]

    def apart(spike: float) -> float:
        first, last = turned(spike)
        return first - last - (late[0] - late[1])

    spike = float(optimise.brentq(apart, 1e-16, 2e-12, xtol=1e-20))
    comparator = Comparator(spike, tail, kappa, late[0] - turned(spike)[0])
    return Membrane(charge / REFERENCE, REFERENCE, 0.0, u_t, comparator)


def idle(d: DieDevices, *names: str) -> F64 | float:
    """Return what switches take from a capacitor that fills to the reference, A, where the drain is halfway.

    The current of a leak depends on the drain by the Early effect, in a straight line, once the drain is some
    U_T above ground.
    """
    return d.idle(*names, drain=0.5 * REFERENCE)


def spike_kappa(lso: Circuit, silicon: Silicon, current: F64 | float) -> F64:
    """Return kappa of a comparator's pair of an LSO neuron by which its half of a tail's current (A) follows.

    It is that of where its gates are, by how steeply v_p follows them there, less by what the pair's
    inversion takes.
    """
    law = silicon.law("n")
    own = float(pinched(terms_of(law, 1.0, 1.0, 1.0, law.v_t0), REFERENCE)[1])
    specific = law.square_current * transistor_of(lso, "cell.threshold.mc1").square
    return np.asarray(own * steepness(0.5 * np.asarray(current), specific))


def _taken(membrane: Membrane, given: float, time: float) -> float:
    """Inhibitory current (A) with which the empty membrane spikes in a time (s)."""

    def later(taken: float) -> float:
        return _risen(membrane, given, taken) - time

    return float(optimise.brentq(later, 0.01 * given, 0.99 * given, xtol=1e-18))


def level_numbers(level: Circuit, silicon: Silicon, lag: float | None = None) -> tuple[float, float, float]:
    """Return the offset (V), the charge (C) and the lag (s) of a level unit.

    They are those with which the law is nearest to its delays on `SLOPES`; lag: s, which is sought unless
    given.
    """
    current = own_current(level, "i_cmp", silicon)
    kappa, u_t = float(level_kappa(level, silicon, current)), silicon.thermal_voltage
    slopes = np.array(SLOPES)
    delays = np.array([level_delay(level, silicon, s) for s in SLOPES])
    scale = np.array([1e-3, 1e-12, 1e-6])  # of an offset, a charge, a lag: differences are of 1
    fixed = () if lag is None else (lag / scale[2],)

    def apart(x: F64) -> F64:
        offset, charge, late = np.append(x, fixed) * scale
        law = offset / slopes + late + ramp_delay(slopes, charge, current, kappa, u_t)
        return np.asarray(law / delays - 1.0)

    start = (0.0, 3.0, 0.0)[: 3 - len(fixed)]
    bounds = (-np.inf, 0.0, -np.inf)[: len(start)], np.inf
    found = optimise.least_squares(apart, start, bounds=bounds, xtol=1e-12)
    offset, charge, late = (float(x) for x in np.append(found.x, fixed) * scale)
    return offset, charge, late


def _rest(level: Circuit, silicon: Silicon) -> float:
    """How deep a level unit's input must rest to be heard, over what the law of its devices has."""
    line = {LINE: float(bias_voltages(level, level.bias("i_cmp"), silicon)[()])}
    units = on_die(level, silicon, tuple(f"{PART}.{d}" for d in DEVICES), (), line)
    law = float(np.ravel(law_depth(units, level, silicon))[0])
    bench = rebias(level, {"v_threshold": THRESHOLD})

    def hears(part: float) -> bool:
        run = simulate(
            ramp_bench(bench, FAST, silicon.process.v_dd, QUIET, part * law), silicon, rtol=RTOL, record=()
        )
        return bool((run.spikes["spike"] > QUIET).any())

    deaf, heard = REST
    if hears(deaf) or not hears(heard):
        found = f"must be at {heard:g} times its law's depth and not at {deaf:g}"
        raise SolverError(f"sonar_head.level: heard, {found}; give it other currents")
    while heard - deaf > REST_STEP:
        middle = 0.5 * (deaf + heard)
        deaf, heard = (deaf, middle) if hears(middle) else (middle, heard)
    return 0.5 * (deaf + heard)


def own_current(circuit: Circuit, bias: str, silicon: Silicon) -> float:
    """Return the saturated current (A) of the device that a bias is for, on the silicon.

    It has no Early effect in it, as none is in the currents of the model: charges over it have that of the
    device where its drain is.
    """
    found = circuit.bias(bias)
    gate = float(bias_voltages(circuit, found, silicon)[()])
    name = found.device or ""
    above = silicon.process.v_dd - gate if transistor_of(circuit, name).polarity == "p" else gate
    return float(on_die(circuit, silicon, (name,)).saturated(name, above))


def level_kappa(level: Circuit, silicon: Silicon, current: F64 | float) -> F64:
    """Return kappa of a level unit's pair by which its half of a tail's current (A) follows its input.

    It is that of weak inversion (`pair_kappa`), less by what the pair's inversion takes.
    """
    pair = transistor_of(level, "generator.comparator.mc1")
    specific = silicon.law("p").square_current * pair.square
    return np.asarray(pair_kappa(silicon) * steepness(0.5 * np.asarray(current), specific))


def level_delay(
    level: Circuit, silicon: Silicon, slope: float, parameter: str = "", move: float = 0.0
) -> float:
    """Return the time from a ramp's crossing of the level unit's threshold to its spike, s.

    slope: of the ramp, V/s; parameter, move: a deviation of the unit, as `comparator.mc1.v_t0`, none if
    empty. Raises `SolverError` where it does not spike.
    """
    bench = ramp_bench(rebias(level, {"v_threshold": THRESHOLD}), slope, silicon.process.v_dd)
    machine = to_kernel(bench, silicon)
    if parameter:
        machine = deviating(machine, f"generator.{parameter}", move)
    spikes = simulate(machine, rtol=RTOL, record=()).spikes["spike"]
    if not spikes.size:
        raise SolverError("sonar_head.level: no spike in the run; give it a higher ramp")
    return float(spikes[0]) - crossing(slope)


def ramp_bench(
    level: Circuit, slope: float, v_dd: float, quiet: float = 0.0, depth: float = -FROM
) -> Testbench:
    """Return the testbench of a level unit whose envelope passes `THRESHOLD` at `quiet + crossing(slope)`.

    slope: of the envelope, V/s; v_dd: supply, V; quiet: for how long before the envelope has been low after
    it was high, s, so that the unit must have ended a refractory period; 0 leaves that to where it rests;
    depth: how far below the threshold it is low, V.
    """
    start, end = quiet + crossing(slope) - depth / slope, quiet + crossing(slope) + TO / slope
    low, high = THRESHOLD - depth, THRESHOLD + TO
    before: tuple[tuple[float, float], ...] = ((0.0, low),)
    if quiet > 0.0:
        before = ((0.0, high), (0.1 * quiet, high), (0.1 * quiet + EDGE, low))
    times, volts = zip(*before, (start, low), (end, high), strict=True)
    wave = PiecewiseLinear(times, volts)
    sources = (Source("vdd", "vdd", Constant(v_dd)), Source("envelope", "envelope", wave))
    return Testbench("level unit", level, sources, end + AFTER, watch=("spike",))


def crossing(slope: float) -> float:
    """Return when the ramp of `ramp_bench` passes the threshold, s."""
    return 0.2e-3 - FROM / slope


def heard(lso: Circuit, silicon: Silicon, **stimuli: float) -> Result:
    """Run an LSO neuron with the given stimuli of its block's testbench, s, and no other."""
    quiet: dict[str, float | None] = {s.name: None for s in lso_neuron.BLOCK.stimuli}
    bench = lso_neuron.testbench(lso, quiet | stimuli | {"duration": STOP}, silicon.process.v_dd)
    return simulate(bench, silicon, rtol=RTOL)


def _timer_slopes(silicon: Silicon) -> F64:
    """Slopes d ln Q / dx of a timer by each parameter of its comparator."""
    circuit = rebias(lso_neuron.build(), {}, "ideal")
    quiet: dict[str, float | None] = {s.name: None for s in lso_neuron.BLOCK.stimuli}
    bench = lso_neuron.testbench(
        circuit, quiet | {"excite_1": 0.5e-3, "duration": STOP}, silicon.process.v_dd
    )
    machine = to_kernel(bench, silicon)
    return timer_slopes(machine, "excite0.timer", lambda result: lso_neuron.measures(result)["step_s"], RTOL)


def _level_slopes(silicon: Silicon) -> F64:
    """Slopes (V/V or V) of a level unit's offset by each parameter of its comparator."""
    level = rebias(high_threshold_neuron.build(), {}, "ideal")

    def offset(parameter: str, move: float) -> float:
        return level_delay(level, silicon, SLOW, f"comparator.{parameter}", move) * SLOW

    return slopes(offset, deviations_of(LEVEL_COMPARATOR), STEPS)


def _axon_slopes(silicon: Silicon) -> F64:
    """Slopes d ln Q / dx of what a level unit's axon takes by each parameter of its devices."""
    level = rebias(high_threshold_neuron.build(), {}, "ideal")
    _, charge, _ = level_numbers(level, silicon)
    current = own_current(level, "i_cmp", silicon)
    kappa, u_t = float(level_kappa(level, silicon, current)), silicon.thermal_voltage
    less, more = (float(ramp_delay(FAST, charge * part, current, kappa, u_t)) for part in (0.99, 1.01))
    steep = math.log(1.01 / 0.99) / (more - less)  # d ln Q over a delay, 1/s

    def log_charge(parameter: str, move: float) -> float:
        return steep * level_delay(level, silicon, FAST, f"axon.{parameter}", move)

    return slopes(log_charge, deviations_of(LEVEL_AXON), STEPS)
