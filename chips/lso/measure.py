"""Measurement of the sonar head's record: charges, delays and offsets of its level units and LSO neurons.

With the transistor-level solver, over temperature and the threshold shift that a die's transistors of a
polarity share, with ideal currents:

    timer, membrane     Q of a synapse's step and of a spike, C, threshold and parasitics in it
    onset, dead         charges (C) over the comparator's current: from an event to its current on the
                        membrane, and of the membrane near ground after a spike
    left                voltage of the membrane then, V: above ground where warm silicon of low thresholds
                        ends the spike before its end
    spike, lag          charge (C) that the pair of the membrane's comparator brings up, and over the
                        comparator's current how much later it spikes
    mirror              what an inhibitory current takes over what the same excitatory one gives
    turn                charge of the mirror's gate, before which it takes nothing, C
    level_offset        of a level unit's threshold, V
    level_charge        Q of its axon's input, C

From when the membrane passes the reference with one input and with two, `t = Q / (n I - I_off) + t_onset`,
how much later it spikes with one input and with one of `STRONG` times its current, and from the interval of
two, `Q / (2 I - I_off) + t_spike + t_dead`, where I_off is what switches that are off take; mirror and turn
from two inputs against one, and of a level unit on ramps of two slopes, by the laws of `chips.lso.law`. And
over temperature `comparator`, d ln Q / dx of each device's x, V_T0 (V) and ln beta, of the comparator that
ends all charges, and `level`, slopes of level_offset by the level unit's own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from chips.lso.law import Comparator, Membrane, ramp_delay, rise_time, spike_delay
from chips.measured.perturbation import deviating, deviations_of, slopes
from chips.measured.table_record import TEMPERATURES, Quantities, measure_over, shifts
from chips.measured.timer import PARAMETERS, STEPS, timer_slopes
from chips.record import Record, Table
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
SHIFTS = shifts(5)  # V; `left` is 0 at all but the lowest
LEVEL_COMPARATOR = ("mc1", "mc2", "mc4", "mc5")
QUANTITIES = (
    "timer", "membrane", "onset", "dead", "left", "spike", "lag", "mirror", "turn", "level_offset",
    "level_charge",
)  # fmt: skip
MEMBRANE_SWITCHES = ("cell.mz", "cell.mq")
TIMER_SWITCHES = ("excite0.mr",)
STRONG = 12.0  # times the usual current, of an input on whose ramp the comparator's pair turns at once; ours
SLOW, FAST = 200.0, 5e3  # V/s, of a level unit's ramps; an echo's edge has 600 to 30,000
FROM, TO = -0.05, 1.0  # V about the threshold, of a ramp
THRESHOLD = 0.6  # V, of the level unit that is measured: offset and charge do not depend on it
RTOL = 1e-5
STOP = 6e-3  # s, of the LSO neuron's runs: its steps last 4.6 ms at -10 degC


def circuits() -> tuple[Circuit, ...]:
    """Return what the record is measured from: an LSO neuron and a level unit."""
    return (
        lso_neuron.build(lso_neuron.Params(excitations=LEVELS, inhibitions=LEVELS)),
        high_threshold_neuron.build(),
    )


def measure(process: Process) -> Record:
    """Measure the record in a process without its errors; it takes five minutes on one core."""
    silicons = [Silicon(process, t) for t in TEMPERATURES]
    timer = np.array([_timer_slopes(s) for s in silicons])
    level = np.array([_level_slopes(s) for s in silicons])
    return measure_over(quantities, circuits(), SHIFTS, {}, process).extended(
        {
            "comparator": Table(("temperature", "parameter"), timer),
            "level": Table(("temperature", "level_parameter"), level),
        },
        {"parameter": PARAMETERS, "level_parameter": deviations_of(LEVEL_COMPARATOR)},
    )


def quantities(silicon: Silicon) -> Quantities:
    """Return the quantities of the circuits on a silicon, with ideal biases, by name."""
    lso, level = (rebias(c, {}, "ideal") for c in circuits())
    current, comparator, step = (own_current(lso, name, silicon) for name in ("i_exc", "i_cmp", "i_step"))
    leak, held = (
        float(np.ravel(idle(standing(lso, silicon), *names))[0])
        for names in (MEMBRANE_SWITCHES, TIMER_SWITCHES)
    )
    at = 0.5e-3
    one = heard(lso, silicon, excite_1=at)
    two = heard(lso, silicon, excite_1=at, excite_2=at)
    turned = heard(lso, silicon, excite_1=at, excite_2=at, inhibit_1=at)
    first, second, slow = (r.spikes["spike"] for r in (one, two, turned))
    if min(first.size, second.size - 1, slow.size - 1) < 1:
        raise SolverError("sonar_head.membrane: too few spikes in the run; give it stronger currents")
    strong = rebias(lso, {"i_exc": STRONG * float(np.ravel(lso.bias("i_exc").value)[0])})
    other = heard(strong, silicon, excite_1=at)
    reached = [passed(r) - START - at for r in (one, two)]
    nets = [k * current - leak for k in (1.0, 2.0)]
    charge = (reached[0] - reached[1]) / (1.0 / nets[0] - 1.0 / nets[1])
    onset = reached[1] - charge / nets[1]
    late = [float(r.spikes["spike"][0]) - passed(r) for r in (one, other)]
    ends = current, own_current(strong, "i_exc", silicon)
    membrane = _membrane(silicon, charge, comparator, [i - leak for i in ends], late)._replace(leak=leak)
    left = emptied(two, float(second[0]), float(second[1]))
    dead = float(second[1] - second[0]) - _risen(membrane, 2.0 * current, 0.0, left)
    taken = _taken(membrane, 2.0 * current, float(slow[1] - slow[0]) - dead, left)
    turned_on = float(slow[0]) - START - at - onset - _risen(membrane, 2.0 * current, taken)
    lasted = lso_neuron.measures(one)["step_s"] or np.nan
    offset, axon = level_numbers(level, silicon, lambda s: level_delay(level, silicon, s))
    return {
        "timer": (lasted - WIDTH) * (step - held),
        "membrane": membrane.capacitance * REFERENCE,
        "onset": onset * comparator,
        "dead": dead * comparator,
        "left": left,
        "spike": membrane.comparator.charge,
        "lag": membrane.comparator.lag * comparator,
        "mirror": taken / current,
        # without its gate's charge the first spike would be later, at 2 I - 0 in the place of 2 I - I
        "turn": -turned_on * (nets[1] - taken),
        "level_offset": offset,
        "level_charge": axon,
    }


def _risen(membrane: Membrane, given: float, taken: float, volts: float = 0.0) -> float:
    """Time from a voltage (V) of the membrane to a spike, s; given, taken: A, but for what leaks."""
    net = given - membrane.leak
    return rise_time(membrane, volts, net, taken) + spike_delay(membrane, net, taken)


def emptied(result: Result, begin: float, end: float) -> float:
    """Return the lowest voltage of a run's membrane between two times (s), V, not below ground."""
    between = (result.time > begin) & (result.time < end)
    return max(0.0, float(result["v_mem"][between].min()))


def passed(result: Result) -> float:
    """Return when a run's membrane first passes the reference, s."""
    v = result["v_mem"]
    k = int(np.argmax((v[1:] >= REFERENCE) & (v[:-1] < REFERENCE)))
    part = (REFERENCE - v[k]) / (v[k + 1] - v[k])
    return float(result.time[k] + part * (result.time[k + 1] - result.time[k]))


def _membrane(
    silicon: Silicon, charge: float, tail: float, currents: Sequence[float], late: Sequence[float]
) -> Membrane:
    """The membrane of a charge (C) that spikes so late (s) after its reference at two currents, A."""
    kappa, u_t = spike_kappa(silicon), silicon.thermal_voltage
    slopes = [i * REFERENCE / charge for i in currents]

    def turned(spike: float) -> list[float]:
        return [float(ramp_delay(s, spike, tail, kappa, u_t)) for s in slopes]

    def apart(spike: float) -> float:
        first, last = turned(spike)
        return first - last - (late[0] - late[1])

    spike = float(optimise.brentq(apart, 1e-16, 2e-12, xtol=1e-20))
    comparator = Comparator(spike, tail, kappa, late[0] - turned(spike)[0])
    return Membrane(charge / REFERENCE, REFERENCE, 0.0, u_t, 0.0, comparator)


def idle(d: DieDevices, *names: str) -> F64 | float:
    """Return what switches take from a capacitor that fills to the reference, A, where the drain is halfway.

    The current of a leak depends on the drain by the Early effect, in a straight line, once the drain is some
    U_T above ground.
    """
    return d.idle(*names, drain=0.5 * REFERENCE)


def spike_kappa(silicon: Silicon) -> float:
    """Return kappa of the comparator's pair of an LSO neuron where its gates are, as `pair_kappa`."""
    law = silicon.law("n")
    return float(pinched(terms_of(law, 1.0, 1.0, 1.0, law.v_t0), REFERENCE)[1])


def _taken(membrane: Membrane, given: float, time: float, volts: float) -> float:
    """Inhibitory current (A) with which the membrane spikes in a time (s) from a voltage (V)."""

    def later(taken: float) -> float:
        return _risen(membrane, given, taken, volts) - time

    return float(optimise.brentq(later, 0.01 * given, 0.99 * given, xtol=1e-18))


def level_numbers(level: Circuit, silicon: Silicon, delay: Callable[[float], float]) -> tuple[float, float]:
    """Return the offset (V) and the charge (C) of a level unit.

    delay: gives its delay (s) on a ramp (V/s), and is asked for `SLOW` and `FAST`.
    """
    kappa, current = pair_kappa(silicon), own_current(level, "i_cmp", silicon)
    u_t, slow, fast = silicon.thermal_voltage, delay(SLOW), delay(FAST)

    def apart(charge: float) -> float:
        over = [
            (d - float(ramp_delay(s, charge, current, kappa, u_t))) * s
            for d, s in ((slow, SLOW), (fast, FAST))
        ]
        return over[0] - over[1]

    charge = float(optimise.brentq(apart, 1e-13, 5e-11, xtol=1e-18))
    return (slow - float(ramp_delay(SLOW, charge, current, kappa, u_t))) * SLOW, charge


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


def pair_kappa(silicon: Silicon) -> float:
    """Return kappa of a level unit's pair where its gates are, by how steeply v_p follows them there."""
    law = silicon.law("p")
    return float(pinched(terms_of(law, 1.0, 1.0, 1.0, law.v_t0), silicon.process.v_dd - THRESHOLD)[1])


def level_delay(
    level: Circuit, silicon: Silicon, slope: float, parameter: str = "", move: float = 0.0
) -> float:
    """Return the time from a ramp's crossing of the level unit's threshold to its spike, s.

    slope: of the ramp, V/s; parameter, move: a deviation of the unit's comparator, none if empty. Raises
    `SolverError` where it does not spike.
    """
    bench = ramp_bench(rebias(level, {"v_threshold": THRESHOLD}), slope, silicon.process.v_dd)
    machine = to_kernel(bench, silicon)
    if parameter:
        machine = deviating(machine, f"generator.comparator.{parameter}", move)
    spikes = simulate(machine, rtol=RTOL, record=()).spikes["spike"]
    if not spikes.size:
        raise SolverError("sonar_head.level: no spike in the run; give it a higher ramp")
    return float(spikes[0]) - crossing(slope)


def ramp_bench(level: Circuit, slope: float, v_dd: float, quiet: float = 0.0) -> Testbench:
    """Return the testbench of a level unit whose envelope passes `THRESHOLD` at `quiet + crossing(slope)`.

    slope: of the envelope, V/s; v_dd: supply, V; quiet: for how long before the envelope has been low after
    it was high, s, so that the unit must have ended a refractory period; 0 leaves that to where it rests.
    """
    start, end = quiet + crossing(slope) + FROM / slope, quiet + crossing(slope) + TO / slope
    low, high = THRESHOLD + FROM, THRESHOLD + TO
    before: tuple[tuple[float, float], ...] = ((0.0, low),)
    if quiet > 0.0:
        before = ((0.0, high), (0.1 * quiet, high), (0.1 * quiet + EDGE, low))
    times, volts = zip(*before, (start, low), (end, high), strict=True)
    wave = PiecewiseLinear(times, volts)
    sources = (Source("vdd", "vdd", Constant(v_dd)), Source("envelope", "envelope", wave))
    return Testbench("level unit", level, sources, end + 1e-4, watch=("spike",))


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
        return level_delay(level, silicon, SLOW, parameter, move) * SLOW

    return slopes(offset, deviations_of(LEVEL_COMPARATOR), STEPS)
