"""How a ranging chip's neurons are coupled through its bias chain, beside neurons that run alone.

Coupled, the chip with its bias chain is one circuit. Separately stepped, as in a run of a system, its bias
network is solved at rest and every neuron runs alone with its bias ports held at those voltages. The two
differ by what a neuron puts on the nodes that the chain drives: a call's edge reaches v_inh_tau through the
overlap of mi5, and passes from stage to stage.

Measured with the same solver on both sides: t_inh after a call alone, and the first spike after a call and an
echo at the best delay that each neuron aims at.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from chips.ranging import circuit as ranging_chip
from circuits.arrays import F64
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Bias, Circuit
from circuits.event import falling_crossing
from circuits.lowering.kernel import to_kernel
from circuits.place import circuit_at
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import OperatingPoint, operating_point
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench

RTOL = 1e-6


@dataclass(frozen=True, slots=True)
class Coupling:
    """Times of both runs by neuron, s, float64[13], NaN without a release or a spike.

    Inhibition is counted from the call to its release, spikes from the call on.
    """

    t_inh_coupled: F64
    t_inh_separate: F64
    spike_coupled: F64
    spike_separate: F64

    @property
    def t_inh(self) -> F64:
        """By how much inhibition ends earlier when the neurons are coupled, s, float64[13]."""
        return self.t_inh_separate - self.t_inh_coupled

    @property
    def spike(self) -> F64:
        """By how much the spike comes earlier when the neurons are coupled, s, float64[13].

        It is NaN unless both fire.
        """
        return self.spike_separate - self.spike_coupled

    @property
    def only_one_fires(self) -> tuple[int, ...]:
        """Numbers of the neurons that fire in only one of the two runs."""
        return tuple(np.flatnonzero(np.isnan(self.spike_coupled) != np.isnan(self.spike_separate)).tolist())


def measure_coupling(silicon: Silicon, delay_ratio: float = 1.0, rtol: float = RTOL) -> Coupling:
    """Compare the chip with its bias chain with its separately stepped neurons.

    Parameters
    ----------
    silicon
        Process, temperature and die.
    delay_ratio
        t_inh at this temperature over that at 27 degC; the delays of the echoes are multiplied by it.
    rtol
        The solver's.
    """
    chip = ranging_chip.build_with_chain()
    rest = operating_point(to_kernel(_bench(chip, silicon, None, 1e-3), silicon))
    delays = delay_ratio * np.array(ranging_chip.BEST_DELAYS)
    stops = rebound_neuron.CALL_TIME + delays + delay_ratio * rebound_neuron.AFTER_RELEASE
    coupled = _coupled(chip, rest, delays, stops, rtol)
    separate = np.array([_alone(chip, rest, k, delays, stops, rtol) for k in range(ranging_chip.NEURONS)]).T
    return Coupling(coupled[0], separate[0], coupled[1], separate[1])


def separate_neuron(chip: Circuit, rest: OperatingPoint, k: int) -> tuple[Circuit, Silicon]:
    """Return neuron `k` alone and the silicon at its place.

    The ports that the chain drives are held at rest.
    """
    neuron, place = circuit_at(chip, (("neuron", (k,)),))
    silicon = replace(rest.machine.silicon, place=place)
    driven = {name: rest[f"{name}[{k}]"] for name in ("v_inh_tau", "v_ex_tau")}
    return replace(neuron, biases=tuple(_held(b, driven) for b in neuron.biases)), silicon


def _held(bias: Bias, voltages: Mapping[str, float]) -> Bias:
    if bias.port not in voltages:
        return bias
    return replace(bias, kind="voltage", value=voltages[bias.port], device=None, place=None)


def _coupled(chip: Circuit, rest: OperatingPoint, delays: F64, stops: F64, rtol: float) -> tuple[F64, F64]:
    """t_inh after a call alone, and each neuron's spike in the run with the echo at its delay."""
    silicon = rest.machine.silicon
    gates = tuple(f"neuron[{k}].inhibition.b" for k in range(ranging_chip.NEURONS))
    bench = _bench(chip, silicon, None, float(stops[-1]))
    result = simulate(bench, silicon, rtol=rtol, record=gates, point=rest)
    ends = np.array([_release(result, gate, silicon) for gate in gates])
    spikes = []
    for k, (delay, stop) in enumerate(zip(delays.tolist(), stops.tolist(), strict=True)):
        run = simulate(_bench(chip, silicon, delay, stop), silicon, rtol=rtol, record=(), point=rest)
        spikes.append(_spike(run, f"spike[{k}]", delay))
    return ends, np.array(spikes)


def _alone(
    chip: Circuit, rest: OperatingPoint, k: int, delays: F64, stops: F64, rtol: float
) -> tuple[float, float]:
    """t_inh and spike of a separately stepped neuron."""
    neuron, there = separate_neuron(chip, rest, k)
    gate, delay, stop = "inhibition.b", float(delays[k]), float(stops[k])
    call = simulate(_bench(neuron, there, None, stop), there, rtol=rtol, record=(gate,))
    both = simulate(_bench(neuron, there, delay, stop), there, rtol=rtol, record=())
    return _release(call, gate, there), _spike(both, "spike", delay)


def _bench(circuit: Circuit, silicon: Silicon, delay: float | None, stop: float) -> Testbench:
    """A call, an echo `delay` (s) later unless None; `call` and `echo` are shared ports of a chip."""
    stimuli = {"delay": delay or 0.0, "call": 1.0, "echo": None if delay is None else 1.0, "duration": stop}
    return rebound_neuron.testbench(circuit, stimuli, silicon.process.v_dd)


def _release(result: Result, gate: str, silicon: Silicon) -> float:
    """From the call to the fall of the inhibition's gate through half the supply, s; NaN without one."""
    found = falling_crossing(result.time, result[gate], 0.5 * silicon.process.v_dd)
    return math.nan if found is None else found - rebound_neuron.CALL_TIME


def _spike(result: Result, port: str, delay: float) -> float:
    """First spike after the echo, from the call on, s; NaN without one."""
    times = result.spikes[port] - rebound_neuron.CALL_TIME
    later = times[times >= delay]
    return float(later[0]) if later.size else math.nan
