"""Spike generator: one spike when its input rises above a threshold, and none while it stays there.

Shared by the onset neuron and the high-threshold neuron. Three parts:

* comparator: a differential pair with tail current I_cmp; the axon's input gets
  `I_cmp tanh(kappa_p (v_in - v_threshold) / 2 U_T)`, and node `v_active` is high while the input is above
  the threshold;
* axon: that of the rebound neuron, with larger capacitors. Its spike also empties C_ref (node `v_ref`);
* refractory: R_ref charges C_ref towards the supply. Until `v_ref` passes the inverter's threshold V_inv the
  axon's input is held down at I_pw; while the input stays above the threshold `v_ref` is held at ground.

So the neuron is silent from its spike until `R_ref C_ref ln(V_dd / (V_dd - V_inv))` after the input has
fallen below the threshold, about `0.6 R_ref C_ref`. Resistor and capacitor keep that time over temperature.
The spike lasts about `V_dd C_fb / (2 I_pw - I_cmp)`, C_fb the axon's feedback.

Sources: the axon is that of Cheely & Horiuchi 2003, Figure 3 (their reference 22); comparator sizes,
refractory part and every number here are ours. The pair is large: mismatch shifts its threshold by 3 mV.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from circuits.blocks.block import Stimulus, Values
from circuits.blocks.sonar.rebound_neuron import Params as RangingParams
from circuits.blocks.sonar.rebound_neuron import axon
from circuits.circuit import Bias, Circuit, Instance, Port
from circuits.devices import Capacitor, Resistor, Source, Transistor
from circuits.devices.source import Constant, PiecewiseLinear
from circuits.errors import ParameterError
from circuits.event import falling_crossing, rising_crossing
from circuits.lowering.supply import half_supply
from circuits.silicon.process import Polarity
from circuits.solver.power import supply_power
from circuits.solver.transient import Result
from circuits.testbench import Testbench

UM = 1e-6
SUPPLY = Port("vdd", "supply")


@dataclass(frozen=True, slots=True)
class GeneratorParams:
    """Capacitors in farad, resistor in ohm; all ours."""

    axon_capacitance: float = 2e-12
    feedback_capacitance: float = 1e-12
    refractory_capacitance: float = 470e-12  # a board's capacitor
    refractory_resistance: float = 1.5e6


def comparator() -> Circuit:
    """Differential pair that charges `v_ax`, and a copy of one side that drives `v_active`.

    mc7 is 0.65 of the tail: `v_active` rises while mc1 carries less than that, just below the threshold.
    """
    ports = (Port("v_in", "analog"), Port("v_threshold", "analog"))
    out = (Port("v_ax", "analog", "out"), Port("v_active", "analog", "out"))
    return Circuit(
        "spike_comparator",
        (SUPPLY, *ports, *out, Port("v_bcmp", "bias")),
        (
            _mos("mc3", "p", "tail", "v_bcmp", "vdd", 6, 6),
            _mos("mc1", "p", "m", "v_in", "tail", 30, 6),
            _mos("mc2", "p", "v_ax", "v_threshold", "tail", 30, 6),
            _mos("mc4", "n", "m", "m", "0", 10, 10),
            _mos("mc5", "n", "v_ax", "m", "0", 10, 10),
            _mos("mc6", "n", "v_active", "m", "0", 10, 10),
            _mos("mc7", "p", "v_active", "v_bcmp", "vdd", 3.9, 6),
        ),
    )


def refractory(params: GeneratorParams) -> Circuit:
    """C_ref, emptied by the axon's spike, holds `v_ax` down until R_ref has filled it."""
    ports = (Port("v_ref", "analog", "out"), Port("v_ax", "analog", "out"), Port("v_active", "analog"))
    return Circuit(
        "refractory",
        (SUPPLY, *ports, Port("v_pw", "bias")),
        (
            Capacitor("c_ref", "v_ref", "0", params.refractory_capacitance),
            Resistor("r_ref", "vdd", "v_ref", params.refractory_resistance),
            _mos("mf1", "p", "v_block", "v_ref", "vdd", 6, 1.5),
            _mos("mf2", "n", "v_block", "v_ref", "0", 3, 1.5),
            _mos("mf3", "n", "v_ax", "v_block", "bm", 3, 1.5),
            _mos("mf4", "n", "bm", "v_pw", "0", 6, 6),
            _mos("mf5", "n", "v_ref", "v_block", "hm", 3, 1.5),
            _mos("mf6", "n", "hm", "v_active", "0", 3, 1.5),
        ),
    )


def spike_generator(params: GeneratorParams) -> Circuit:
    """Ports v_in, v_threshold (analog in), spike (event out), v_bcmp, v_ilim, v_pw (bias), supply."""
    parts = {
        "comparator": comparator(),
        "axon": axon(RangingParams(
            axon_capacitance=params.axon_capacitance, feedback_capacitance=params.feedback_capacitance
        )),
        "refractory": refractory(params),
    }  # fmt: skip
    ports = (
        SUPPLY,
        Port("v_in", "analog"),
        Port("v_threshold", "analog"),
        Port("spike", "event", "out"),
        *(Port(p, "bias") for p in ("v_bcmp", "v_ilim", "v_pw")),
    )
    renamed = {"v_mem": "v_ref"}  # the axon pulls this port down during a spike
    instances = tuple(
        Instance(name, part, {p.name: renamed.get(p.name, p.name) for p in part.ports})
        for name, part in parts.items()
    )
    return Circuit("spike_generator", ports, (), instances)


def generator_biases(instance: str) -> tuple[Bias, ...]:
    """Biases of a block that holds a spike generator as `instance`; all ours."""
    return (
        Bias("i_cmp", "v_bcmp", "gate", 250e-9, f"{instance}.comparator.mc3"),
        Bias("i_lim", "v_ilim", "gate", 6.3e-6, f"{instance}.axon.ma1"),
        Bias("i_pw", "v_pw", "gate", 500e-9, f"{instance}.axon.ma7"),
    )


SOUND_TIME = 0.5e-3  # s, ours: when the testbench's first sound begins
AFTER_SOUND = 2e-3  # s, ours: how long a testbench goes on after the last sound
PEDESTAL = 0.15  # V, ours: the envelope detector's output in silence


def sound_stimuli(amplitude: float) -> tuple[Stimulus, ...]:
    """Stimuli of a neuron that listens to an envelope: a trapezoid, and a second one."""
    return (
        Stimulus("amplitude", "V", amplitude, "height of the first sound's envelope"),
        Stimulus("second_amplitude", "V", None, "height of a second sound's envelope", can_be_off=True),
        Stimulus("delay", "s", 2e-3, "second sound after the first"),
        Stimulus("duration", "s", 1e-3, "length of each sound, its edges included"),
        Stimulus("rise_time", "s", 0.2e-3, "each edge of a sound"),
    )


def envelope_testbench(title: str, circuit: Circuit, stimuli: Values, v_dd: float) -> Testbench:
    """Trapezoids of the envelope on its pedestal, at 0.5 ms and `delay` later."""
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
    sources = (Source("vdd", "vdd", Constant(v_dd)), Source("envelope", "envelope", envelope))
    last = SOUND_TIME + (0.0 if stimuli["second_amplitude"] is None else delay)
    return Testbench(title, circuit, sources, last + duration + AFTER_SOUND, watch=("spike",))


def spike_measures(result: Result, signal: str, threshold: str) -> dict[str, float | None]:
    """`latency_s`, `interval_s`, `spike_width_s`, `margin_V`, `supply_power_W`.

    latency: from the first sound's start to the first spike; interval: from there to the second spike;
    spike_width: of the first spike at half the supply; None without such a spike. margin: the largest of
    node `signal` minus node `threshold`, below 0 where there is no reason to fire.
    """
    half = half_supply(result.machine)
    spikes = result.spikes["spike"]
    up = rising_crossing(result.time, result["spike"], half)
    down = falling_crossing(result.time, result["spike"], half)
    return {
        "latency_s": float(spikes[0]) - SOUND_TIME if spikes.size else None,
        "interval_s": float(spikes[1] - spikes[0]) if spikes.size > 1 else None,
        "spike_width_s": None if up is None or down is None else down - up,
        "margin_V": float((result[signal] - result[threshold]).max()),
        "supply_power_W": supply_power(result),
    }


def _mos(
    name: str, polarity: Polarity, drain: str, gate: str, source: str, width: float, length: float
) -> Transistor:
    bulk = "vdd" if polarity == "p" else "0"
    return Transistor(name, polarity, drain, gate, source, bulk, width * UM, length * UM)
