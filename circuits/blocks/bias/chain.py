"""Bias chain of the ranging chip: gate voltages for 13 neurons from a cascade of current mirrors.

There is a chain for I_inh_tau and one for I_ex_tau. A stage copies the current of the stage before through
two mirrors, the second with a size ratio r, and adds a further small current of its own:

    I_0 = I_start,    I_s = r_s I_(s-1) + I_step,    stage s biases neuron 12 - s

The last neuron has the smallest currents and the longest delay, so that the chains begin there: what
accumulates over the stages ends where the delay, and with it the error in time, is short. The sum flows into
a diode-connected device with the W/L of the biased one (mi5 of the neuron, or me4 in the other polarity),
whose gate voltage the neuron takes. A shift of V_T in a stage moves that stage and all later ones.

There are two settings. `LINEAR`, with all ratios 1, is the paper's "approximately linearly increasing set of
currents". `RECIPROCAL` (ours) has ratios from 1.04 to 2.88, set by the width of the second mirror's output,
at the same added current in every stage, so that I_inh_tau falls as 1/delay and the best delays are nearly
linear in the neuron's number. I_ex_tau is linear in both. On the nominal die all currents are within 1 % of
those of the rebound neuron's facts, by design.

Source: Cheely & Horiuchi 2003, section "Biasing and power consumption": "a cascaded series of current mirrors
with a further small bias current added in at each stage". The currents are from the facts on the rebound
neuron; the topology of a stage and sizes are ours.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64
from circuits.blocks.block import DURATION, Values, catalogued
from circuits.blocks.drive import powered
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_in, bias_ports
from circuits.circuit import Bias, Circuit, Instance, Port
from circuits.devices import Transistor
from circuits.devices.transistor import drain_current
from circuits.errors import ParameterError
from circuits.silicon.process import Polarity
from circuits.solver.operating_point import OperatingPoint
from circuits.solver.transient import Result
from circuits.testbench import Testbench
from circuits.units import quantity

NEURONS = 13
BIASED_SIZE = 6e-6  # m, width and length of mi5 and me4
SIDE = 24e-6  # m; ours: V_T of a device 0.8 mV, a quarter of a 6/6 device's
STOP = 1e-3  # s; ours: nothing moves

# Of stages 1 to 12; ours, so that the currents are those of the facts within 1 %.
RECIPROCAL_RATIOS = (1.040, 1.050, 1.063, 1.081, 1.100, 1.124, 1.155, 1.199, 1.265, 1.382, 1.644, 2.883)
EVEN_RATIOS = (1.0,) * (NEURONS - 1)


@dataclass(frozen=True, slots=True)
class Params:
    """Size ratios of stages 1 to 12, currents of the biases (A), and the side of a device, m.

    Raises `ParameterError` unless there are 12 ratios for each chain, all above zero.
    """

    inhibition_ratios: tuple[float, ...] = quantity(RECIPROCAL_RATIOS, "")
    inhibition_start_current: float = quantity(40.1e-12, "A")  # facts: neuron 12
    inhibition_step_current: float = quantity(2e-12, "A")  # ours
    excitation_ratios: tuple[float, ...] = quantity(EVEN_RATIOS, "")
    excitation_start_current: float = quantity(19.7e-12, "A")  # facts: neuron 12
    excitation_step_current: float = quantity(4.1e-12, "A")  # facts: 68.9 to 19.7 pA in 12 steps
    side_length: float = quantity(SIDE, "m")

    def __post_init__(self) -> None:
        for name in ("inhibition_ratios", "excitation_ratios"):
            ratios = getattr(self, name)
            if len(ratios) != NEURONS - 1 or not all(r > 0.0 for r in ratios):
                raise ParameterError(f"{name}: {ratios}, must be {NEURONS - 1} numbers > 0, one a stage")


RECIPROCAL = Params()
# facts: 955.3 to 40.1 pA in 12 steps
LINEAR = Params(inhibition_ratios=EVEN_RATIOS, inhibition_step_current=(955.3e-12 - 40.1e-12) / 12)


class Currents(NamedTuple):
    """I_inh_tau and I_ex_tau of neurons 0 to 12, float64[13] each, A."""

    inh_tau: F64
    ex_tau: F64


def build(params: Params = Params()) -> Circuit:
    """Both chains: ports v_inh_tau[13], v_ex_tau[13] (out), start and step biases of each, the supply."""
    chains = (
        ("inhibition", "inh", _chain("n", params.inhibition_ratios, params.side_length)),
        ("excitation", "ex", _chain("p", params.excitation_ratios, params.side_length)),
    )
    values = {
        "i_inh_start": params.inhibition_start_current,
        "i_inh_step": params.inhibition_step_current,
        "i_ex_start": params.excitation_start_current,
        "i_ex_step": params.excitation_step_current,
    }
    devices = {"start": "stage_0.ma", "step": "stage_1.ma"}
    biases = tuple(
        Bias(
            f"i_{short}_{what}", f"v_{short}_{what}", "gate", values[f"i_{short}_{what}"], f"{name}.{device}"
        )
        for name, short, _ in chains
        for what, device in devices.items()
    )
    instances = tuple(
        chain.instance(name, v=f"v_{short}_tau", v_start=f"v_{short}_start", v_step=f"v_{short}_step")
        for name, short, chain in chains
    )
    ports = (
        SUPPLY,
        Port("v_inh_tau", "analog", "out", (NEURONS,)),
        Port("v_ex_tau", "analog", "out", (NEURONS,)),
        *bias_ports(biases),
    )
    return Circuit("bias_chain", ports, (), instances, biases=biases)


def _chain(polarity: Polarity, ratios: tuple[float, ...], side: float) -> Circuit:
    """Thirteen stages; `polarity` is that of the biased devices, and element k of `v` is neuron k's."""
    first, stage = _first_stage(polarity, side), _stage(polarity, side)
    last = NEURONS - 1
    instances = [Instance("stage_0", first, {"vdd": "vdd", "v": f"v[{last}]", "v_add": "v_start"})]
    for s, ratio in enumerate(ratios, start=1):
        connections = {
            "vdd": "vdd",
            "v_before": f"v[{last - s + 1}]",
            "v": f"v[{last - s}]",
            "v_add": "v_step",
        }
        instances.append(Instance(f"stage_{s}", stage, connections, {"mq.width": ratio * side}))
    ports = (SUPPLY, Port("v", "analog", "out", (NEURONS,)), *bias_in("v_start", "v_step"))
    return Circuit(f"current_chain_{polarity}", ports, (), tuple(instances))


def _first_stage(polarity: Polarity, side: float) -> Circuit:
    """The added current ma into the diode md."""
    ports = (SUPPLY, *analog_out("v"), *bias_in("v_add"))
    return Circuit(f"chain_start_{polarity}", ports, _diode_and_adder(polarity, side))


def _stage(polarity: Polarity, side: float) -> Circuit:
    """Copy mc of the stage before, mirror mp to mq, added current ma, diode md."""
    other: Polarity = "p" if polarity == "n" else "n"
    devices = (
        _mos("mc", polarity, ("m", "v_before"), side),
        _mos("mp", other, ("m", "m"), side),
        _mos("mq", other, ("v", "m"), side),
        *_diode_and_adder(polarity, side),
    )
    ports = (SUPPLY, *analog_in("v_before"), *analog_out("v"), *bias_in("v_add"))
    return Circuit(f"chain_stage_{polarity}", ports, devices)


def _diode_and_adder(polarity: Polarity, side: float) -> tuple[Transistor, Transistor]:
    other: Polarity = "p" if polarity == "n" else "n"
    return _mos("md", polarity, ("v", "v"), side), _mos("ma", other, ("v", "v_add"), side)


def _mos(name: str, polarity: Polarity, nodes: tuple[str, str], side: float) -> Transistor:
    """A square transistor of (drain, gate) nodes, source and bulk at its supply."""
    rail = "vdd" if polarity == "p" else "0"
    return Transistor(name, polarity, *nodes, rail, rail, side, side)


def currents(point: OperatingPoint) -> Currents:
    """Currents (A) that the chains' gate voltages give in biased devices without mismatch of their own.

    point: operating point of the chains, or of a chip whose nodes v_inh_tau[13] and v_ex_tau[13] they drive.
    """
    silicon = point.machine.silicon
    v_dd, size = silicon.process.v_dd, (BIASED_SIZE, BIASED_SIZE)
    v_inh, v_ex = (np.array([point[f"{v}[{k}]"] for k in range(NEURONS)]) for v in ("v_inh_tau", "v_ex_tau"))
    sink = drain_current(silicon.law("n").of_size(*size), "n", *size, v_dd, v_inh, 0.0, 0.0)
    source = drain_current(silicon.law("p").of_size(*size), "p", *size, 0.0, v_ex, v_dd, v_dd)
    return Currents(sink, -source)


STIMULI = (DURATION,)
PLOTTED = ("v_inh_tau[0]", "v_inh_tau[12]", "v_ex_tau[0]", "v_ex_tau[12]")


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """The supply alone."""
    return Testbench("bias chain", circuit, powered(v_dd), stimuli["duration"] or STOP)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: the currents of neurons 0 and 12, called `i_inh_tau_0_A` and the like."""
    found = currents(result.operating_point)
    ends = {
        f"i_{name}_{k}_A": float(values[k])
        for name, values in found._asdict().items()
        for k in (0, NEURONS - 1)
    }
    return {**ends}


def outcome(result: Result) -> str:
    """`falling` where both currents fall from neuron to neuron, else `not-monotone`."""
    steps = [np.diff(values) for values in currents(result.operating_point)]
    return "falling" if all((s < 0.0).all() for s in steps) else "not-monotone"


BLOCK = catalogued("bias-chain", build, STIMULI, testbench, measures, outcome, PLOTTED)
