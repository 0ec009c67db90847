"""The ranging chip as a circuit: 13 rebound neurons whose best delays span 2 to 28 ms.

Shared biases reach every neuron; I_inh_tau and I_ex_tau are one per neuron (Cheely & Horiuchi 2003,
section "Biasing and power consumption"), set at ports or by a bias chain on the chip (`build_with_chain`).
The currents of the feasibility study fall as 1/delay, so that the best delays are near-linear (ours); the
paper's own are approximately linear in the index.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from circuits.blocks.bias import chain as bias_chain
from circuits.blocks.block import Block, Values
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Bias, Circuit, Instance, InstanceArray, Node, Port
from circuits.solver.transient import Result
from circuits.testbench import Testbench

NEURONS = 13

# Per neuron: best delay aimed at (s), I_inh_tau (A), I_ex_tau (A).
BEST_DELAYS = tuple(
    1e-3 * d for d in (2.0, 4.17, 6.33, 8.5, 10.67, 12.83, 15.0, 17.17, 19.33, 21.5, 23.67, 25.83, 28.0)
)
I_INH_TAU = tuple(
    1e-12 * i for i in (955.3, 330.7, 199.9, 143.2, 111.6, 91.4, 77.4, 67.1, 59.2, 52.9, 47.9, 43.7, 40.1)
)
I_EX_TAU = tuple(
    1e-12 * i for i in (68.9, 64.8, 60.7, 56.6, 52.5, 48.4, 44.3, 40.2, 36.1, 32.0, 27.9, 23.8, 19.7)
)


def linear_currents() -> tuple[float, ...]:
    """Return currents I_inh_tau that are linear in the neuron's number, as on the paper's chip, A."""
    return tuple(float(i) for i in np.linspace(I_INH_TAU[0], I_INH_TAU[-1], NEURONS))


@dataclass(frozen=True, slots=True)
class Params:
    """Sizes of the neurons."""

    neuron: rebound_neuron.Params = field(default_factory=rebound_neuron.Params)


@dataclass(frozen=True, slots=True)
class BiasedParams:
    """Sizes of the neurons, and of the bias chain."""

    neuron: rebound_neuron.Params = field(default_factory=rebound_neuron.Params)
    chain: bias_chain.Params = field(default_factory=bias_chain.Params)


_PER_NEURON = {"i_inh_tau": I_INH_TAU, "i_ex_tau": I_EX_TAU}


def build(params: Params = Params()) -> Circuit:
    """Build the chip, whose biases are all set at ports.

    Its ports are the events call and echo, which all neurons share, spike[13], v_mem[13], the biases and the
    supply.
    """
    neuron = rebound_neuron.build(params.neuron)
    biases = tuple(_chip_bias(b) for b in neuron.biases)
    shape = (NEURONS,)
    ports = (
        Port("vdd", "supply"),
        Port("call", "event"),
        Port("echo", "event"),
        Port("v_mem", "analog", "out", shape),
        Port("spike", "event", "out", shape),
        *(Port(b.port, "bias", "in", shape if b.name in _PER_NEURON else ()) for b in biases),
    )
    array = InstanceArray("neuron", neuron, shape, neuron.wired())
    return Circuit("ranging_chip", ports, (), (array,), biases=biases)


def build_with_chain(params: BiasedParams = BiasedParams()) -> Circuit:
    """Build the chip with its bias chain inside: v_inh_tau[13] and v_ex_tau[13] are nodes, not ports.

    The bias ports are those that all neurons share, and the chain's start and step. The circuit has the name
    of the chip without the chain, so that a die has the same neurons in both. Calls reach the chain through
    the overlap of mi5 and pass from stage to stage: on the nominal die inhibition ends earlier than with
    fixed gate voltages, by 5 % in neurons 0 to 3 (at most 0.4 ms) and 0.1 % in neuron 12.
    """
    plain = build(Params(params.neuron))
    chain = bias_chain.build(params.chain)
    inside = {b.port for b in plain.biases if b.name in _PER_NEURON}
    own = tuple(replace(b, device=f"chain.{b.device}") for b in chain.biases)
    return replace(
        plain,
        ports=(*(p for p in plain.ports if p.name not in inside), *(chain.port(b.port) for b in own)),
        nodes=tuple(Node(p, (NEURONS,)) for p in sorted(inside)),
        instances=(*plain.instances, Instance("chain", chain, chain.wired())),
        biases=(*(b for b in plain.biases if b.port not in inside), *own),
    )


def _chip_bias(bias: Bias) -> Bias:
    device = None if bias.device is None else f"neuron.{bias.device}"
    return replace(bias, device=device, value=_PER_NEURON.get(bias.name, bias.value))


def neuron_biases(chip: Circuit, k: int) -> dict[str, float]:
    """Return the bias values of neuron `k` of a chip by name, A or V."""
    return {b.name: float(np.broadcast_to(np.asarray(b.value), (NEURONS,))[k]) for b in chip.biases}


def testbench(circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """Return a testbench with a call at 1 ms and an echo after `delay`, unless it is off, for `duration`."""
    bench = rebound_neuron.testbench(circuit, {**stimuli, "duration": stimuli["duration"] or 45e-3}, v_dd)
    return replace(bench, title="ranging chip")


def measures(result: Result) -> dict[str, float | None]:
    """Return `spiking_neurons`, how many fired."""
    fired = sum(1 for times in result.spikes.values() if times.size)
    return {"spiking_neurons": float(fired)}


def outcome(result: Result) -> str:
    """Return the numbers of the neurons that fired, in order, as in `2+3`, or `none`."""
    fired = [k for k in range(NEURONS) if result.spikes[f"spike[{k}]"].size]
    return "+".join(map(str, fired)) or "none"


CHIP = Block(
    name="ranging-chip",
    summary="13 rebound neurons with best delays of 2 to 28 ms",
    build=build,
    stimuli=rebound_neuron.BLOCK.stimuli,
    testbench=testbench,
    measures=measures,
    outcome=outcome,
    plotted=("call", "echo", *(f"v_mem[{k}]" for k in (0, 2, 6, 12))),
)

BIASED_CHIP = replace(
    CHIP,
    name="ranging-chip-biased",
    summary="the ranging chip with its bias chain inside",
    build=build_with_chain,
)
