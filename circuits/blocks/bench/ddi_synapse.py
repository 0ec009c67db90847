"""Synapse of two DPI filters whose outputs are subtracted: a current like an alpha function.

Both filters get the same pulse, each through a weight of its own. The first one's output flows into `i_out`,
that of the second, which is faster, is turned round by a mirror and drawn from there:

    I_out = I_1(t) - I_2(t)

With equal peaks it begins at nothing, has its peak where the second has decayed, and ends with the time
constant of the first. Where the second is greater the current is drawn.

Source: two filters with the sizes of the other synapse, capacitors of 32 um and 26.77 um square, mirrors of
3.2 um. Which capacitor is which filter's, and the biases, are ours; there is no measurement.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from circuits.blocks.bench import pulse_extender
from circuits.blocks.bench.bias import MASTERS, coded_bias
from circuits.blocks.bench.curve import slope
from circuits.blocks.bench.dpi_synapse import FIRST_EVENT, SIZE, STIMULI
from circuits.blocks.bench.dpi_synapse import Params as DpiParams
from circuits.blocks.bench.dpi_synapse import testbench as events_into
from circuits.blocks.block import catalogued
from circuits.blocks.measure import between, fall, rise
from circuits.blocks.mos import mos
from circuits.blocks.ports import SUPPLY, analog_out, biased, event_in
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.sizes import Sizes, um
from circuits.circuit import Circuit
from circuits.silicon.process import ROLLS_180
from circuits.solver.power import drain_current
from circuits.solver.transient import Result
from circuits.units import quantity


@dataclass(frozen=True, slots=True)
class Params(Sizes):
    """Capacitors (F) and sizes (um).

    slow, fast: of the filter whose output flows into i_out, and of that whose output is drawn from there.
    filter: of both filters' transistors and of the weights. switch: of the nFETs that a pulse opens.
    """

    slow_capacitance: float = quantity(2.08e-12, "F")
    fast_capacitance: float = quantity(1.45e-12, "F")
    extender_capacitance: float = quantity(0.40e-12, "F")
    filter_width: float = um(3.2)
    filter_length: float = um(3.2)
    switch_width: float = um(1.0)
    switch_length: float = um(1.0)


BIASES = (
    coded_bias("tau1", MASTERS[0], 10, "slow.md3", SIZE),
    coded_bias("thr1", MASTERS[0], 60, "slow.md4", SIZE),
    coded_bias("tau2", MASTERS[0], 60, "fast.md3", SIZE),
    coded_bias("thr2", MASTERS[0], 60, "fast.md4", SIZE),
    coded_bias("weight1", MASTERS[2], 100, "mw1", SIZE),
    coded_bias("weight2", MASTERS[2], 100, "mw2", SIZE),
    coded_bias("pulse", MASTERS[1], 100, "extender.m_tau", (4.0, 4.0)),
)


def build(params: Params = Params()) -> Circuit:
    """The synapse: ports event (in), i_out (current out), biases and the supply; params: its sizes."""
    size, switch = params.sizes("filter", "switch")
    shared = DpiParams(filter_width=size[0], filter_length=size[1]).filter_params()
    slow = replace(shared, synapse_capacitance=params.slow_capacitance)
    fast = replace(shared, synapse_capacitance=params.fast_capacitance)
    extender = pulse_extender.Params(extender_capacitance=params.extender_capacitance)
    instances = (
        pulse_extender.build(extender).instance("extender", v_tau="v_pulse"),
        dpi_synapse.excitatory_filter(slow, "0").instance(
            "slow", line="line1", v_syn="v_syn1", v_thr="v_thr1", v_tau="v_tau1"
        ),
        dpi_synapse.inhibitory_filter(fast, "0").instance(
            "fast", line="line2", v_syn="v_syn2", v_thr="v_thr2", v_tau="v_tau2"
        ),
    )
    weights = (
        mos("mw1", "n", "line1", "v_weight1", "low1", *size),
        mos("m_in1", "n", "low1", "pulse", "0", *switch),
        mos("mw2", "n", "line2", "v_weight2", "low2", *size),
        mos("m_in2", "n", "low2", "pulse", "0", *switch),
    )
    ports = (SUPPLY, *event_in("event"), *analog_out("i_out"))
    return biased("ddi_synapse", ports, BIASES, weights, instances)


def measures(result: Result) -> dict[str, float | None]:
    """Numbers of a run: `pulse_width_s`, `peak_A`, `to_peak_s`, `trough_A` and `tau_s`.

    Of the current into the output: its highest, how long after the event that is, its lowest (negative where
    it is drawn), and the time constant with which it falls from half of its peak to a tenth. None where it
    does not come so far.
    """
    time = result.time
    current = np.abs(drain_current(result, "slow.md5")) - np.abs(drain_current(result, "fast.md7"))
    top, peak = int(current.argmax()), float(current.max())
    ending = (np.arange(time.size) > top) & (current < 0.5 * peak) & (current > 0.1 * peak)
    decay = slope(time, np.log(np.maximum(current, 1e-30)), ending)
    return {
        "pulse_width_s": between(rise(result, "pulse"), fall(result, "pulse")),
        "peak_A": peak,
        "to_peak_s": float(time[top]) - FIRST_EVENT,
        "trough_A": float(current.min()),
        "tau_s": None if decay is None or decay >= 0.0 else -1.0 / decay,
    }


def outcome(result: Result) -> str:
    """`excites` where the output gives more than it draws at most, else `inhibits`."""
    found = measures(result)
    return "excites" if (found["peak_A"] or 0.0) > -(found["trough_A"] or 0.0) else "inhibits"


PLOTTED = ("event", "pulse", "v_syn1", "v_syn2")

BLOCK = catalogued("ddi-synapse", build, STIMULI, events_into, measures, outcome, PLOTTED, ROLLS_180)
