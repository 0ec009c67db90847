"""ROLLS synapse with short-term depression: spikes weaken its excitatory weights, which recover.

It is the non-plastic synapse (`circuits.blocks.rolls.dpi_synapse`), but each of the three pFETs of the
excitatory weights has its gate on a capacitor of its own, `x` volt above the bias of the weight:

* step: an excitatory pulse of length t connects a pFET of I_std to the supply, `x += I_std t / C_w`. Between
  pulses its source is held at the bias of the weight, 0.4 V and more below the supply: its switch leaks to
  there, and it carries nothing. Its drain is at the capacitor, so that little of the switches' charge gets
  there.
* recovery: a pFET between the capacitor and the bias has r times the W/L of a diode whose source is at that
  bias and that carries I_rec: `C_w dx/dt = -r I_rec (e^(x / U_T) - 1)` in weak inversion.

With `R = e^(-x / U_T)` these are `R -> R e^(-I_std t / (C_w U_T))` at a spike, and between spikes `dR/dt = (1
- R) / tau` with `tau = C_w U_T / (r I_rec)`: R is the resource of the phenomenological models of depression,
at any depth. The weight is `I_w = I_w0 R^kappa` in weak inversion. A train at the interval T finds `R = (1 -
E) / (1 - E e^(-d / U_T))` at its pulses, d being a step and `E = e^(-T / tau)`.

Found is the name of one bias, NPA_WEIGHT_STD_N, with code 0 in the default file of the control software
(mn256r1_ncs), and no equation. The form is general knowledge and unverified: a step of the weight's gate at a
spike, a recovery, an exponential weight. That NPA_WEIGHT_STD is the current of the step is ours: were it that
of the recovery, synapses of the default file would not come back from their first spikes. Topology, sizes,
capacitor, I_rec, for which there is no name, and the codes of both currents are ours.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from circuits.arrays import F64
from circuits.blocks.block import Values, catalogued
from circuits.blocks.mos import mos
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_in
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls.bias import gate_bias
from circuits.blocks.rolls.dpi_synapse import Params as SynapseParams
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Circuit
from circuits.devices import Capacitor
from circuits.event import falling_crossing, rising_crossing
from circuits.lowering.supply import half_supply
from circuits.silicon.process import ROLLS_180, thermal_voltage
from circuits.solver.power import drain_current
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

WEIGHTS = ("exc", "exc0", "exc1")  # the gates, each with a capacitor
STEP, RECOVERY = (5, 36), (7, 27)  # codes, ours: R falls to 0.6 at a spike; tau 50 ms


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitor of a weight (F), sizes (um) and the synapse; ours."""

    weight_capacitance: float = quantity(0.2e-12, "F")
    bias_width: float = um(0.5)  # of the nFETs of both biases, long enough to be turned off
    bias_length: float = um(4.5)
    mirror_width: float = um(0.5)  # of the step's pFETs
    mirror_length: float = um(2.0)
    switch_width: float = um(0.25)
    switch_length: float = um(2.0)  # long: for an inverter's delay both switches conduct
    # of the recovery's diode; W/L over that of its transistor divides I_rec
    diode_width: float = um(1.0)
    diode_length: float = um(1.0)
    recovery_width: float = um(0.25)
    recovery_length: float = um(4.0)
    synapse: SynapseParams = field(default_factory=SynapseParams)

    @property
    def ratio(self) -> float:
        """The share r of I_rec that recovery gets."""
        return self.recovery_width * self.diode_length / (self.recovery_length * self.diode_width)


def depression(params: Params) -> Circuit:
    """One weight's gate: ports exc_off, exc_on (pulse), level (its bias), w (the gate), v_std, v_rec."""
    bias, mirror, switch = params.sizes("bias", "mirror", "switch")
    devices = (
        Capacitor("c_w", "w", "0", params.weight_capacitance),
        mos("ms1", "n", "step", "v_std", "0", *bias),
        mos("ms2", "p", "step", "step", "vdd", *mirror),
        mos("ms3", "p", "w", "step", "s", *mirror),
        mos("ms4", "p", "s", "exc_off", "vdd", *switch),
        mos("ms5", "p", "level", "exc_on", "s", *switch),
        mos("mr1", "n", "back", "v_rec", "0", *bias),
        mos("mr2", "p", "back", "back", "level", *params.size("diode")),
        mos("mr3", "p", "level", "back", "w", *params.size("recovery")),
    )
    pulse, biases = analog_in("exc_off", "exc_on"), bias_in("v_std", "v_rec")
    ports = (SUPPLY, *pulse, *bias_in("level"), *analog_out("w"), *biases)
    return Circuit("weight_depression", ports, devices)


def synapse(params: Params) -> Circuit:
    """The non-plastic synapse with its excitatory pulse brought out and the gates of its weights free."""
    one = dpi_synapse.synapse(params.synapse)
    gates = {f"v_{name}" for name in WEIGHTS}
    ports = tuple(replace(p, kind="analog") if p.name in gates else p for p in one.ports)
    return replace(one, ports=(*ports, *analog_out("exc_off", "exc_on")))


BIASES = (
    *dpi_synapse.BIASES,
    gate_bias("std", STEP, "depression_exc.ms1"),
    gate_bias("rec", RECOVERY, "depression_exc.mr1"),
)


def build(params: Params = Params()) -> Circuit:
    """The synapse: ports of the DPI synapse, and the gates w_exc, w_exc0 and w_exc1 of its weights."""
    base, cell = dpi_synapse.build(params.synapse), depression(params)
    to_gate = {f"v_{name}": f"w_{name}" for name in WEIGHTS}
    connected = synapse(params).instance("synapse", **to_gate)
    cells = (cell.instance(f"depression_{name}", level=f"v_{name}", w=f"w_{name}") for name in WEIGHTS)
    instances = (*(connected if i.name == "synapse" else i for i in base.instances), *cells)
    ports = (*base.ports, *bias_in("v_std", "v_rec"), *analog_out(*to_gate.values()))
    return Circuit("depressing_synapse", ports, (), instances, biases=BIASES)


AFTER = 25e-3  # s, ours: of the run, after the last event


STIMULI = dpi_synapse.knobs(6.0, 200.0)
PLOTTED = ("event", "w_exc", "v_exc_syn")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """`events` events at `rate` (Hz) from 1 ms on, at a rested synapse of a `level`."""
    bench = dpi_synapse.testbench(circuit, stimuli, v_dd)
    last = dpi_synapse.FIRST_EVENT + (int(stimuli["events"] or 0) - 1) / float(stimuli["rate"] or 1.0)
    return replace(bench, title="depressing synapse", stop=stimuli["duration"] or last + AFTER)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `step_V`, `depression_V`, `recovery_s`, `weight_A`, `paired_pulse`, `last_to_first`.

    step: of the gate of the constant weight over the first pulse; None where the next pulse comes before it
    has settled. depression: x after the last pulse. recovery: time constant of `1 - R` from there to the end
    of the run. weight: mean current of the first pulse. paired_pulse, last_to_first: charge of the second and
    of the last pulse over that of the first. All are None without a pulse.
    """
    pulses = _pulses(result)
    if not pulses:
        return dict.fromkeys(MEASURED, None)
    time, x = result.time, result["w_exc"] - float(np.interp(pulses[0][0], result.time, result["w_exc"]))
    first, last = (float(np.interp(pulses[k][1] + SETTLED, time, x)) for k in (0, -1))
    charges = [_charge(result, *p) for p in pulses]
    apart = len(pulses) == 1 or pulses[1][0] > pulses[0][1] + SETTLED
    values = (
        first if apart else None,
        last,
        _recovery(time, x, pulses[-1][1] + SETTLED, thermal_voltage(result.machine.silicon.temperature_c)),
        charges[0] / (pulses[0][1] - pulses[0][0]),
        charges[1] / charges[0] if len(charges) > 1 else None,
        charges[-1] / charges[0] if len(charges) > 1 else None,
    )
    return dict(zip(MEASURED, values, strict=True))


MEASURED = ("step_V", "depression_V", "recovery_s", "weight_A", "paired_pulse", "last_to_first")
SETTLED = 0.1e-3  # s after a pulse, ours: the nodes at the gate have come back, and x has not yet
LEAST = 0.02  # of 1 - R, ours: below, no time constant is read


def _pulses(result: Result) -> list[tuple[float, float]]:
    """Beginnings and ends of the excitatory pulses, s."""
    half = half_supply(result.machine)
    time, off = result.time, result["exc_off"]
    found: list[tuple[float, float]] = []
    while (begin := falling_crossing(time, off, half)) is not None:
        rest = time > begin
        end = rising_crossing(time[rest], off[rest], half)
        if end is None:
            break
        found.append((begin, end))
        time, off = time[time > end], off[time > end]
    return found


def _charge(result: Result, begin: float, end: float) -> float:
    """What the synapse draws from the line of its filter in a pulse, C."""
    inside = (result.time >= begin) & (result.time <= end)
    pulse = replace(result, time=result.time[inside], voltage=result.voltage[inside])
    return float(np.trapezoid(drain_current(pulse, "synapse.me9"), pulse.time))


def _recovery(time: F64, x: F64, begin: float, u_t: float) -> float | None:
    spent = 1.0 - np.exp(-np.array([np.interp(begin, time, x), x[-1]]) / u_t)
    if spent[1] < LEAST or spent[0] <= spent[1]:
        return None
    return float((time[-1] - begin) / np.log(spent[0] / spent[1]))


DEPRESSES = 0.95  # last charge over the first below which a run is called so; ours


def outcome(result: Result) -> str:
    """`depresses`, `steady`, or `silent` without excitatory pulses."""
    pulses = _pulses(result)
    if not pulses:
        return "silent"
    return "depresses" if _charge(result, *pulses[-1]) < DEPRESSES * _charge(result, *pulses[0]) else "steady"


BLOCK = catalogued("depressing-synapse", build, STIMULI, testbench, measures, outcome, PLOTTED, ROLLS_180)
