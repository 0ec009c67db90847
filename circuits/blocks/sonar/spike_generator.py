"""Spike generator: one spike when its input rises above a threshold, and none while it stays there.

The onset neuron and the high-threshold neuron share it. It has three parts:

* comparator: a differential pair with the tail current I_cmp. The input of the axon gets
  `I_cmp tanh(kappa_p (v_in - v_threshold) / 2 U_T)`, and the node `v_active` is high while the input is above
  the threshold.
* axon: that of the rebound neuron, with larger capacitors. Its spike also empties C_ref (node `v_ref`).
* refractory: R_ref charges C_ref towards the supply. Until `v_ref` passes the threshold V_inv of an inverter,
  the input of the axon is held down at I_pw; while the input stays above the threshold, `v_ref` is held at
  ground.

So the neuron is silent from its spike until `R_ref C_ref ln(V_dd / (V_dd - V_inv))` after the input has
fallen below the threshold, which is about `0.6 R_ref C_ref`. A resistor and a capacitor keep that time over
temperature. The spike lasts about `V_dd C_fb / (2 I_pw - I_cmp)`, C_fb being the feedback of the axon.

Sources: the axon is that of Cheely & Horiuchi 2003, Figure 3 (their reference 22). The sizes of the
comparator, the refractory part and every number here are ours. The pair is large: mismatch shifts its
threshold by 3 mV.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from circuits.blocks.block import Block, Stimulus, Values, catalogued, lasting
from circuits.blocks.drive import powered
from circuits.blocks.measure import between, fall, latency, rise, spike_outcome
from circuits.blocks.mos import mos
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_in, event_out
from circuits.blocks.sonar.rebound_neuron import Params as RangingParams
from circuits.blocks.sonar.rebound_neuron import axon, differential_stage
from circuits.circuit import Bias, Circuit, Instance
from circuits.devices import Capacitor, Resistor
from circuits.devices.source import PiecewiseLinear
from circuits.errors import ParameterError
from circuits.solver.transient import Result
from circuits.testbench import Testbench


@dataclass(frozen=True, slots=True)
class GeneratorParams:
    """Capacitors (F) and resistor (Ohm); ours."""

    axon_capacitance: float = 2e-12
    feedback_capacitance: float = 1e-12
    refractory_capacitance: float = 470e-12  # a board's capacitor
    refractory_resistance: float = 1.5e6


def comparator() -> Circuit:
    """A differential pair that charges `v_ax`, and a copy of one of its sides that drives `v_active`.

    mc7 carries 0.65 of the tail: `v_active` rises while mc1 carries less than that, just below the threshold.
    """
    inputs = analog_in("v_in", "v_threshold")
    return Circuit(
        "spike_comparator",
        (SUPPLY, *inputs, *analog_out("v_ax", "v_active"), *bias_in("v_bcmp")),
        (
            *differential_stage("v_in", "v_threshold", pair=(30, 6), mirror=(10, 10)),
            mos("mc6", "n", "v_active", "m", "0", 10, 10),
            mos("mc7", "p", "v_active", "v_bcmp", "vdd", 3.9, 6),
        ),
    )


def refractory(params: GeneratorParams) -> Circuit:
    """C_ref, which the axon's spike empties, holds `v_ax` down until R_ref has filled it again."""
    return Circuit(
        "refractory",
        (SUPPLY, *analog_out("v_ref", "v_ax"), *analog_in("v_active"), *bias_in("v_pw")),
        (
            Capacitor("c_ref", "v_ref", "0", params.refractory_capacitance),
            Resistor("r_ref", "vdd", "v_ref", params.refractory_resistance),
            mos("mf1", "p", "v_block", "v_ref", "vdd", 6, 1.5),
            mos("mf2", "n", "v_block", "v_ref", "0", 3, 1.5),
            mos("mf3", "n", "v_ax", "v_block", "bm", 3, 1.5),
            mos("mf4", "n", "bm", "v_pw", "0", 6, 6),
            mos("mf5", "n", "v_ref", "v_block", "hm", 3, 1.5),
            mos("mf6", "n", "hm", "v_active", "0", 3, 1.5),
        ),
    )


def spike_generator(params: GeneratorParams) -> Circuit:
    """The circuit: ports v_in, v_threshold (in), spike (event out), v_bcmp, v_ilim, v_pw and the supply."""
    spiking = axon(
        RangingParams(
            axon_capacitance=params.axon_capacitance, feedback_capacitance=params.feedback_capacitance
        )
    )
    inputs, biases = analog_in("v_in", "v_threshold"), bias_in("v_bcmp", "v_ilim", "v_pw")
    ports = (SUPPLY, *inputs, *event_out("spike"), *biases)
    instances = (
        comparator().instance("comparator"),
        spiking.instance("axon", v_mem="v_ref"),  # which the axon pulls down during a spike
        refractory(params).instance("refractory"),
    )
    return Circuit("spike_generator", ports, (), instances)


def generator(capacitance: float, resistance: float, v_in: str) -> Instance:
    """A spike generator called `generator` at node `v_in`.

    capacitance, resistance: C_ref (F) and R_ref (Ohm) of its refractory part.
    """
    params = GeneratorParams(refractory_capacitance=capacitance, refractory_resistance=resistance)
    return spike_generator(params).instance("generator", v_in=v_in)


BIASES = (  # of a block with a `generator`; all ours
    Bias("i_cmp", "v_bcmp", "gate", 250e-9, "generator.comparator.mc3"),
    Bias("i_lim", "v_ilim", "gate", 6.3e-6, "generator.axon.ma1"),
    Bias("i_pw", "v_pw", "gate", 500e-9, "generator.axon.ma7"),
)


SOUND_TIME = 0.5e-3  # s, ours: when the testbench's first sound begins
AFTER_SOUND = 2e-3  # s, ours: how long a testbench goes on after the last sound
PEDESTAL = 0.15  # V, ours: the envelope detector's output in silence


def _sound_stimuli(amplitude: float) -> tuple[Stimulus, ...]:
    """Knobs of a neuron that listens to an envelope: two sounds, the first `amplitude` (V) high."""
    return (
        Stimulus("amplitude", "V", amplitude, "height of the first sound's envelope"),
        Stimulus("second_amplitude", "V", None, "height of a second sound's envelope", can_be_off=True),
        Stimulus("delay", "s", 2e-3, "second sound after the first"),
        lasting(1e-3, "length of each sound, its edges included"),
        Stimulus("rise_time", "s", 0.2e-3, "each edge of a sound"),
    )


def envelope_testbench(title: str, circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """One or two sounds: trapezoids of the envelope on its pedestal, at 0.5 ms and `delay` (s) later.

    Raises `ParameterError` for edges that do not fit into a sound.
    """
    values = {name: value or 0.0 for name, value in stimuli.items()}
    rise, duration, delay = values["rise_time"], values["duration"], values["delay"]
    if not 0.0 < 2.0 * rise <= duration:
        raise ParameterError(f"rise_time: {rise:g} s, must be > 0 and at most half of {duration:g} s")
    shape = np.array([0.0, rise, duration - rise, duration])
    starts = SOUND_TIME + np.array([0.0, delay])
    time = np.unique(np.concatenate([[0.0], *(start + shape for start in starts)]))
    height = PEDESTAL + sum(
        values[name] * np.interp(time, start + shape, [0.0, 1.0, 1.0, 0.0])
        for name, start in zip(("amplitude", "second_amplitude"), starts, strict=True)
    )
    envelope = PiecewiseLinear(tuple(time.tolist()), tuple(height.tolist()))
    last = SOUND_TIME + (0.0 if stimuli["second_amplitude"] is None else delay)
    stop = last + duration + AFTER_SOUND
    return Testbench(title, circuit, powered(v_dd, {"envelope": envelope}), stop, watch=("spike",))


def _spike_measures(result: Result, signal: str, threshold: str) -> dict[str, float | None]:
    """Numbers of a run: `latency_s`, `interval_s`, `spike_width_s` and `margin_V`.

    latency: from the start of the first sound to the first spike. interval: from there to the second spike.
    spike_width: of the first spike at half the supply. All are None without such a spike. margin: the largest
    difference of node `signal` to node `threshold`, below zero where there is no reason to fire.
    """
    spikes = result.spikes["spike"]
    return {
        "latency_s": latency(result, SOUND_TIME),
        "interval_s": float(spikes[1] - spikes[0]) if spikes.size > 1 else None,
        "spike_width_s": between(rise(result, "spike"), fall(result, "spike")),
        "margin_V": float((result[signal] - result[threshold]).max()),
    }


def listening_block(
    name: str, build: Callable[..., Circuit], amplitude: float, plotted: tuple[str, ...], signal: str
) -> Block:
    """The block of a neuron that listens to an envelope, and spikes where `signal` is above `v_threshold`.

    amplitude: height (V) of the sound that its testbench gives it by default. signal: the node that is
    compared. The other arguments are those of `Block`.
    """
    bench = partial(envelope_testbench, f"{name.removesuffix('-neuron')} neuron")
    measures = partial(_spike_measures, signal=signal, threshold="v_threshold")
    return catalogued(name, build, _sound_stimuli(amplitude), bench, measures, spike_outcome, plotted)
