"""The DPI synapse with its pulse extender: two pulses, and a reading every 20 ms and an overhead."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from circuits.arrays import F64, Bools
from circuits.blocks.bench.dpi_synapse import OUT_AT, Params, build
from circuits.blocks.drive import Wave, powered
from circuits.blocks.mos import mos
from circuits.event import pulse
from circuits.extraction.coach.bench import ADC, Bench, code_name, code_unknowns, lowered
from circuits.extraction.coach.conditions import V_DD, Condition
from circuits.extraction.coach.readings.converter import DARK
from circuits.extraction.coach.table import Table
from circuits.extraction.coach.unknown import Unknown
from circuits.solver.power import drain_current
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

_P = mos("p", "p", "d", "g", "s", 3.2, 3.2)
_N = mos("n", "n", "d", "g", "s", 3.2, 3.2)
_TAU = mos("t", "n", "d", "g", "s", 4.0, 4.0)
_FIRST, _WINDOW = 1e-3, 20e-3  # s, of the first pulse; ours, and for how long events are counted
_SECOND = 10  # sample that the second pulse comes before
_RTOL = 1e-4
_STEEP = 0.02  # V between samples above which their time matters
_NOISE, _JITTERED = 1.2e-3, 0.012  # V; a jitter of 1.5 ms is that of 8 V/s
_COUNTS = 0.02  # relative


def unknowns(conditions: Mapping[str, Condition]) -> Iterator[Unknown]:
    """Time, lines, the threshold's line and the converter of the synapse."""
    yield Unknown("dpi spacing", math.log(25e-3), 0.08, "ln", "nuisance", "20 ms and an overhead")
    yield Unknown("dpi delay", math.log(15e-3), 1.2, "ln", "nuisance", "from a pulse to its sample, not told")
    yield Unknown("dpi line", math.log(0.3e-12), 0.7, "ln", "nuisance", "line and buffer")
    yield Unknown("dpi threshold", 0.0, 0.6, "ln", "nuisance", "size of the output device of type P")
    yield Unknown("dpi extender", 0.0, 0.7, "ln", "nuisance", "current and swing of the extender")
    yield Unknown("dpi Q", math.log(3e-13), 1.0, "ln", "nuisance", "its references were others")
    own = [each for each in conditions.values() if each.circuit == "dpi-synapse"]
    yield from code_unknowns("dpi", own, 0.03, ("PEX_VTAU_N",))
    yield Unknown("dpi buffer", 0.0, 5e-3, "V", "nuisance", "offset of its buffer")
    yield Unknown("dpi t_d", 2e-6, 0.7e-6, "s", "nuisance")


def predict(bench: Bench, condition: Condition, table: Table) -> dict[str, F64]:
    """Readings of v_syn, and counts in the 20 ms after each."""
    theta = bench.theta
    delay, spacing = math.exp(theta["dpi delay"]), math.exp(theta["dpi spacing"])
    count = table["t_nominal_s"].size
    sample = _FIRST + delay + spacing * np.arange(count)
    second = float(sample[_SECOND - 1] + spacing)
    sample[_SECOND:] += second + delay - sample[_SECOND]
    circuit = build(Params(line_capacitance=math.exp(theta["dpi line"])))
    waves: dict[str, Wave] = {
        "event": pulse((_FIRST, second), V_DD), "i_out": OUT_AT, **_gates(bench, condition),
    }  # fmt: skip
    testbench = Testbench("dpi synapse", circuit, powered(V_DD, waves), float(sample[-1]) + _WINDOW)
    machine = lowered(testbench, bench.silicon(circuit.name))
    result = simulate(machine, rtol=_RTOL, at_rest=True, start={"v_syn": V_DD})
    read = np.interp(sample, result.time, result["v_syn"])
    flow = np.abs(drain_current(result, "filter.md5"))
    charge = math.exp(theta["dpi Q"])
    rate = 1.0 / (charge / np.maximum(flow, 1e-18) + theta["dpi t_d"])
    total = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * np.diff(result.time))])
    events = np.interp(sample + _WINDOW, result.time, total) - np.interp(sample, result.time, total)
    return {"v_syn_V": bench.adc(read) + theta["dpi buffer"], "n_isyn_counts": events + DARK * 0.1}


def _gates(bench: Bench, condition: Condition) -> dict[str, float]:
    lines = {
        "v_tau": ("DPI_VTAU_P", _P, 0.0), "v_thr": ("DPI_VTHR_N", _P, bench.theta["dpi threshold"]),
        "v_weight": ("DPI_VWEIGHT_N", _N, 0.0), "v_pulse": ("PEX_VTAU_N", _TAU, bench.theta["dpi extender"]),
    }  # fmt: skip
    found = {}
    for port, (name, device, factor) in lines.items():
        bias = condition.bias(name)
        error = 0.0 if name == "PEX_VTAU_N" else bench.theta[code_name("dpi", bias)]
        found[port] = bench.gate(bias, device, (bias.fine or 0) * math.exp(factor + error))
    return found


def usable(condition: Condition, table: Table) -> dict[str, Bools]:
    """All voltages, and counts that are no dark ones."""
    del condition
    return {"v_syn_V": np.isfinite(table["v_syn_V"]), "n_isyn_counts": table["n_isyn_counts"] > 20.0}


def noise(condition: Condition, predicted: Mapping[str, F64]) -> dict[str, F64]:
    """Standard deviation of readings; more where v_syn moves, as their times are not even."""
    del condition
    found = {}
    for name, value in predicted.items():
        if name == "v_syn_V":
            after = np.abs(np.diff(value, prepend=value[0])) > _STEEP
            falls = np.diff(value, prepend=value[0]) < 0.0
            found[name] = np.where(after & ~falls, _JITTERED, math.hypot(_NOISE, ADC))
        else:
            found[name] = np.hypot(_COUNTS * value, 1.0)
    return found
