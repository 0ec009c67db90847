"""The follower-integrator behind its buffer: steps of the input, and a slow sine."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from circuits.arrays import F64, Bools
from circuits.blocks.bench.follower_integrator import Params, build
from circuits.blocks.drive import Wave, powered
from circuits.blocks.mos import mos
from circuits.devices.source import PiecewiseLinear
from circuits.extraction.coach.bench import Bench, code_name, code_unknowns, lowered
from circuits.extraction.coach.conditions import V_DD, Condition
from circuits.extraction.coach.table import Table
from circuits.extraction.coach.unknown import Unknown
from circuits.lowering.on_die import transistor_names, transistor_of
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

_TAIL = mos("mb", "n", "d", "g", "s", 1.0, 1.0)
_CIRCUIT = build()
_BEFORE, _EDGE = 1e-4, 1e-7  # s, ahead of the first sample, and how long an edge takes; ours
_SAMPLE = 20e-6  # s
_NOISE = 1.2e-3  # V: interference near 10 kHz; scaled by the fit
_RTOL = 1e-4
_BIAS = "FOI_VB_N"


def unknowns(conditions: Mapping[str, Condition], a_vt: float) -> Iterator[Unknown]:
    """Capacitance of the output's line, when the step came, the levels that were set."""
    yield Unknown("foi line", math.log(0.1e-12), 0.7, "ln", "nuisance", "line and buffer")
    for device in transistor_names(_CIRCUIT):
        made = transistor_of(_CIRCUIT, device)
        sd = a_vt / math.sqrt(2.0 * made.gate_area)
        yield Unknown(f"{_CIRCUIT.name}.{device}.v_t0", 0.0, sd, "V", "device", "area law")
    for each in conditions.values():
        if each.circuit == "follower-integrator":
            yield Unknown(f"{each.name} start", 0.0, 10e-6, "s", "nuisance", "of the step")
            yield Unknown(f"{each.name} drift", 0.0, 0.01, "ln", "nuisance", "of the bias")
    own = [each for each in conditions.values() if each.circuit == "follower-integrator"]
    yield from code_unknowns("foi", own, 0.03)
    yield Unknown("foi high", 1.007, 4e-3, "V", "nuisance", "small step's level")
    yield Unknown("foi read", 0.008, 0.003, "s", "nuisance", "from setting to reading; ours")


def predict(bench: Bench, condition: Condition, table: Table) -> dict[str, F64]:
    """The voltages that are read."""
    if condition.settings["input"] == "sine":
        return {"v_out_V": _sine(bench, condition, table)}
    high = bench.theta["foi high"] if condition.voltages["v_to"] < 1.1 else condition.voltages["v_to"]
    start = _BEFORE + bench.theta[f"{condition.name} start"]
    offset = bench.theta["dac offset"]
    low = condition.voltages["v_from"] + offset
    wave = PiecewiseLinear((0.0, start, start + _EDGE), (low, low, high + offset))
    times = _BEFORE + table["t_s"]
    return {"v_out_V": bench.adc(_run(bench, condition, wave, times))}


def _sine(bench: Bench, condition: Condition, table: Table) -> F64:
    step, lag = condition.settings["sample_s"], bench.theta["foi read"]
    given = table["v_in_V"] + bench.theta["dac offset"]
    begin = step * np.arange(given.size)
    time = np.ravel(np.column_stack([begin + _EDGE, begin + step]))
    wave = PiecewiseLinear(tuple(map(float, time)), tuple(map(float, np.repeat(given, 2))))
    return bench.adc(_run(bench, condition, wave, begin + lag))


def _run(bench: Bench, condition: Condition, wave: Wave, times: F64) -> F64:
    line = math.exp(bench.theta["foi line"])
    bias = condition.bias(_BIAS)
    scale = math.exp(bench.theta[f"{condition.name} drift"] + bench.theta[code_name("foi", bias)])
    gate = bench.gate(bias, _TAIL, scale * (bias.fine or 0))
    circuit = build(Params(line_capacitance=line))
    sources = powered(V_DD, {"v_in": wave, "v_tail": gate})
    testbench = Testbench("follower-integrator", circuit, sources, float(times.max()) + 1e-6)
    machine = lowered(testbench, bench.silicon(circuit.name))
    result = simulate(machine, rtol=_RTOL, record=("v_out",), start={"v_out": 0.9}, at_rest=True)
    return np.interp(times, result.time, result["v_out"])


def usable(condition: Condition, table: Table) -> dict[str, Bools]:
    """All points."""
    return {"v_out_V": np.isfinite(table["v_out_V"])}


def noise(condition: Condition, predicted: Mapping[str, F64]) -> dict[str, F64]:
    """Standard deviation of readings."""
    return {name: np.full(value.size, _NOISE) for name, value in predicted.items()}
