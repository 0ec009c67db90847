"""Export of a ROLLS program to NIR, as leaky integrators (filters) and integrate-and-fire neurons.

    neurons -> excitatory -> excitatory_filter -> neurons -> spikes
    neurons -> inhibitory -> inhibitory_filter -> neurons
    virtual_excitatory -> virtual_excitatory_weight -> virtual_excitatory_filter -> neurons, inhibitory alike

Weights are `Linear` (256 x 256) from the neurons, `Scale` from the virtual inputs, filters `LI`, neurons
`LIF`, by NIR's equations:

    filter:  tau di/dt = -i + r (weight S),         r = I_th / I_tau,     weight = I_w t_pulse / I_threshold
    neuron:  tau_m dv/dt = v_leak - v + r_m i,      r_m = I_thr / I_leak
             v_leak = (r_m I_dc - I_thr) / I_threshold

so that v is I_mem over the neuron's threshold current and spikes at 1. `Linearisation` has the numbers;
without one they are the nominal ones at 27 degC: `tau = C U_T / (kappa I_tau)`, `t_pulse = C_pw V_dd / (2
I_pwlk)`, and as threshold the I_mem at which the positive feedback balances the leak alone,

    I_threshold = I_leak e^(V_shift / U_T) L / W
    from  I_leak = I_fb = (W / L) I_mem e^(-V_shift / U_T), W and L of the transistor that senses it

(derived, not measured on the circuit). `LOST` says what a graph does not have; it is in its metadata too.

Sources: NIR's reference implementation (package nir) for its equations; equations and capacitors of
`circuits.blocks.rolls.dpi_synapse` and `circuits.blocks.rolls.neuron` for the chip's.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable
from chips.rolls.program.program import (
    HIGHEST_LEVEL,
    Program,
    check_undepressed,
    check_unlearned,
    level_current,
)
from circuits.arrays import F64
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.errors import DataError, ParameterError
from circuits.silicon.process import ROLLS_180_IDEAL, at_temperature

REFERENCE_C = 27.0
LOST = (
    "filters and membrane are linear: the factor 1 + I_th / I and the floor of the currents are gone",
    "the positive feedback is a threshold: no acceleration before a spike",
    "no refractory period: nothing limits the rate of a neuron",
    "no adaptation, no NMDA gate, no short-term depression",
    "a pulse of t_pulse is an impulse of the same charge",
    "mismatch, temperature and bias drift: numbers are those handed in, else nominal at 27 degC",
    "shared hardware: eight weights and filters shared by a neuron are free numbers in the graph",
    "virtual synapses of one sign are one input: an event on k of them is k events",
    "addresses, bandwidth and latency of the event bus; names of populations and inputs",
    "bias codes and latches: a graph does not become a program again",
)


class Filter(NamedTuple):
    """A shared filter: time constant (s) and gain `I_th / I_tau`, float64[256] each."""

    tau: F64
    gain: F64


@dataclass(frozen=True, slots=True)
class Linearisation:
    """Numbers of the linear model, one a neuron: float64[256], currents in A, times in s.

    filters: by `excitatory`, `inhibitory`, `virtual_excitatory`, `virtual_inhibitory`; pulse: width of an
    event; weights: current of levels -4 to 4, float64[9]; virtual: currents of an excitatory and an
    inhibitory virtual synapse; offset: `r_m I_dc - I_thr`.
    """

    filters: dict[str, Filter]
    membrane: Filter
    offset: F64
    threshold: F64
    pulse: F64
    weights: F64
    virtual: tuple[float, float]

    def __post_init__(self) -> None:
        pairs = {**self.filters, "membrane": self.membrane}
        values = {f"{name}.tau": f.tau for name, f in pairs.items()} | {"threshold": self.threshold}
        for name, value in values.items():
            if value.shape != (NEURONS,) or not (value > 0.0).all():
                raise ParameterError(
                    f"linearisation.{name}: shape {value.shape}, must be {NEURONS} numbers > 0; one a neuron"
                )


def nominal_linearisation(program: Program) -> Linearisation:
    """Return the linear model of the nominal circuits at 27 degC."""
    biases, process = program.biases, ROLLS_180_IDEAL
    n, p = (at_temperature(model, process, REFERENCE_C) for model in (process.n, process.p))
    synapse, neuron = dpi_synapse.Params(), rolls_neuron.Params()

    def shared(tau: str, thr: str) -> Filter:
        i_tau = np.full(NEURONS, biases.current(tau))
        return Filter(synapse.synapse_capacitance * p.u_t / (p.kappa * i_tau), biases.current(thr) / i_tau)

    leak = np.where(program.slow_leak(), biases.current("IF_TAU1_N"), biases.current("IF_TAU2_N"))
    i_thr = biases.current("IF_THR_N")
    membrane = Filter(neuron.membrane_capacitance * n.u_t / (n.kappa * leak), i_thr / leak)
    shift = rolls_neuron.build().bias("v_shift").value
    feedback = neuron.feedback_width / neuron.feedback_length * np.exp(-np.asarray(shift) / n.u_t)
    pulse = synapse.pulse_capacitance * 0.5 * process.v_dd / biases.current("NPA_PWLK_P")
    return Linearisation(
        filters={
            "excitatory": shared("NPDPIE_TAU_P", "NPDPIE_THR_P"),
            "inhibitory": shared("NPDPII_TAU_P", "NPDPII_THR_P"),
            "virtual_excitatory": shared("VDPIE_TAU_P", "VDPIE_THR_P"),
            "virtual_inhibitory": shared("VDPII_TAU_N", "VDPII_THR_N"),
        },
        membrane=membrane,
        offset=membrane.gain * biases.current("IF_DC_P") - i_thr,
        threshold=leak / feedback,
        pulse=np.full(NEURONS, pulse),
        weights=_weights(biases),
        virtual=(biases.current("VA_EXC_N"), biases.current("VA_INH_P")),
    )


def nir_graph(program: Program, linearisation: Linearisation | None = None) -> Any:
    """Return the `nir.NIRGraph` of a program, with `LOST` in its metadata.

    Its inputs are `virtual_excitatory` and `virtual_inhibitory`, one channel a neuron, its output `spikes`.

    Parameters
    ----------
    program
        The program.
    linearisation
        Linear model of the neurons; that of the nominal circuits at 27 degC unless given.

    Raises
    ------
    DataError
        The package nir is not installed.
    ParameterError
        The program has a plastic array or depression, which no node of NIR says.
    """
    check_unlearned(program, "a NIR graph")
    check_undepressed(program, "a NIR graph")
    nir, model = nir_package(), linearisation or nominal_linearisation(program)
    scale = model.pulse / model.threshold
    current = model.weights[program.levels.astype(np.int64) + HIGHEST_LEVEL] * scale[:, None]
    nodes: dict[str, Any] = {}
    edges: list[tuple[str, str]] = []
    for name, sign in (("excitatory", 1.0), ("inhibitory", -1.0)):
        nodes[name] = nir.Linear(weight=np.where(np.sign(current) == sign, current, 0.0))
        edges += [("neurons", name), *_filtered(nir, nodes, name, model.filters[name])]
    for name, weight, count in (
        ("virtual_excitatory", model.virtual[0], max(program.virtual.excitatory, 1)),
        ("virtual_inhibitory", -model.virtual[1], program.virtual.inhibitory),
    ):
        if count:  # a graph needs an input, so that of excitation is always there
            nodes[name] = nir.Input(input_type={"input": np.array([NEURONS])})
            nodes[f"{name}_weight"] = nir.Scale(scale=weight * scale)
            edges.append((name, f"{name}_weight"))
            edges += _filtered(nir, nodes, f"{name}_weight", model.filters[name])
    nodes["neurons"] = nir.LIF(
        tau=model.membrane.tau,
        r=model.membrane.gain,
        v_leak=model.offset / model.threshold,
        v_threshold=np.ones(NEURONS),
        v_reset=np.zeros(NEURONS),
    )
    nodes["spikes"] = nir.Output(output_type={"output": np.array([NEURONS])})
    edges.append(("neurons", "spikes"))
    metadata = {"source": "noctule", "chip": "rolls", "lost": "\n".join(LOST)}
    return nir.NIRGraph(nodes=nodes, edges=edges, metadata=metadata)


def write_nir(path: Path, program: Program, linearisation: Linearisation | None = None) -> None:
    """Write the NIR graph of a program to a file at `path`.

    Raises `DataError` without the package nir, or for an impossible path.

    Parameters
    ----------
    path
        Path of the file.
    program
        The program.
    linearisation
        Linear model of the neurons, as of `nir_graph`.
    """
    nir, graph = nir_package(), nir_graph(program, linearisation)
    try:
        nir.write(path, graph)
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else str(error)
        raise DataError(f"{path}: {reason}, must be a file to write; give another") from error


def _filtered(
    nir: Any,
    nodes: dict[str, Any],
    name: str,
    model: Filter,
) -> list[tuple[str, str]]:
    """Add the filter behind node `name`; returns its edges."""
    after = f"{name.removesuffix('_weight')}_filter"
    nodes[after] = nir.LI(tau=model.tau, r=model.gain, v_leak=np.zeros(NEURONS))
    return [(name, after), (after, "neurons")]


def _weights(biases: BiasTable) -> F64:
    """Currents of levels -4 to 4, negative where they inhibit, A."""
    levels = range(-HIGHEST_LEVEL, HIGHEST_LEVEL + 1)
    return np.array([np.sign(level) * level_current(biases, level) for level in levels])


def nir_package() -> Any:
    """Return the package nir; raises `DataError` where it is not installed."""
    try:
        return import_module("nir")
    except ModuleNotFoundError as error:
        raise DataError("nir is not installed; pip install 'noctule[nir]'") from error
