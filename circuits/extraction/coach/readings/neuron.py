"""Both neurons: what is fitted of a waveform that repeats is its shape over its own period, and the period.

When a record begins within a period is not known; a draw takes any phase alike.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping

import numpy as np

from circuits.arrays import F64, Bools
from circuits.blocks.bench import adaptive_neuron, axon_hillock
from circuits.blocks.drive import Wave, current_into, powered
from circuits.blocks.mos import mos
from circuits.catalogue import later
from circuits.devices import Transistor
from circuits.errors import SolverError
from circuits.extraction.coach.bench import ADC, Bench, code_name, code_unknowns, lowered
from circuits.extraction.coach.conditions import DATA, V_DD, Condition, read_conditions
from circuits.extraction.coach.metrics import Metric, metrics_of
from circuits.extraction.coach.table import Table, read_table
from circuits.extraction.coach.unknown import Unknown
from circuits.solver.transient import Result, simulate
from circuits.testbench import Testbench

special = later("scipy.special")

PHASES = 24  # of a period, at which a shape is fitted
_FEATURES = ("threshold_up_V", "top_V", "threshold_down_V", "bottom_V", "rise_V_per_s", "fall_V_per_s")
_SPREADS = (0.008, 0.012, 0.012, 0.008, 0.01, 0.02)  # of these, in their units: half a sample's way, and ours
_RESET = mos("m_pw", "n", "d", "g", "s", 3.4, 1.0)
_SQUARE, _INPUT = mos("m", "n", "d", "g", "s", 4.0, 4.0), mos("m_dc", "p", "d", "g", "s", 3.4, 1.0)
_RTOL = 1e-4
_SHAPE, _ISI, _NOISE = 8e-3, 0.3, 1e-3  # V, samples, V
_NAMES = {"axon-hillock": "ahn", "adaptive-neuron": "acn"}  # how their unknowns begin
_EDGE = 3e-3  # s; ours
_PACE = "acn_dc10"  # the record by whose interval samples are paced
_FALL = 0.2  # V, of a membrane that is reset


def unknowns(conditions: Mapping[str, Condition]) -> Iterator[Unknown]:
    """Input, lines and time of both neurons, and the phase at which each record begins."""
    yield Unknown("ahn input", math.log(2e-12), 0.6, "ln", "nuisance", "of order 1 pA, not told")
    yield Unknown("ahn line", math.log(0.4e-12), 0.6, "ln", "nuisance", "line, buffer and gates")
    yield Unknown("acn time", math.log(1.8), 0.4, "ln", "nuisance", "a sample's 0.25 ms, times 1 to 3.3")
    yield Unknown("acn line", math.log(0.3e-12), 0.7, "ln", "nuisance", "line and buffer")
    yield Unknown("acn gain", 0.0, 0.5, "ln", "nuisance", "output device of V_gain")
    yield Unknown("acn reset", 0.0, 0.5, "ln", "nuisance", "swing of the refractory capacitor")
    for circuit, name in _NAMES.items():
        own = [each for each in conditions.values() if each.circuit == circuit]
        for each in own:
            yield Unknown(f"{each.name} phase", 0.0, 1.0, "", "nuisance", "normal score of a uniform phase")
        yield from code_unknowns(name, own, 0.04)


def _gate(bench: Bench, condition: Condition, name: str, device: Transistor, factor: float = 0.0) -> float:
    bias = condition.bias(name)
    error = bench.theta[code_name(_NAMES[condition.circuit], bias)]
    return bench.gate(bias, device, (bias.fine or 0) * math.exp(factor + error))


def predict(bench: Bench, condition: Condition, table: Table) -> dict[str, F64]:
    """The membrane at samples from some phase on; of a table of features, these."""
    if "isi_samples" in table or "top_V" in table:
        return _features(bench, condition)
    time, v, period = _period(bench, condition)
    sample = _sample(bench, condition)
    if condition.circuit == "adaptive-neuron":
        sample = _paced(bench)
    phase = float(special.ndtr(bench.theta[f"{condition.name} phase"]))
    at = (phase * period + sample * np.arange(table["t_nominal_s"].size)) % period
    return {"v_mem_V": bench.adc(np.interp(at, time, v))}


def _paced(bench: Bench) -> float:
    """A sample's time, s, by which the neuron that was fitted has the interval that was measured.

    The time's own unknown is linear in the fit's posterior, the interval is not.
    """
    condition, table = _reference()
    return _period(bench, condition)[2] / metrics_of(condition, table)["isi_samples"].value


@functools.lru_cache(maxsize=1)
def _reference() -> tuple[Condition, Table]:
    condition = read_conditions()[_PACE]
    return condition, read_table(DATA / condition.file, condition)


def _sample(bench: Bench, condition: Condition) -> float:
    nominal = float(condition.settings["sample_s"])
    if condition.circuit == "axon-hillock":
        return nominal * 1.02  # 50 ms and 0 to 2 ms
    return nominal * math.exp(bench.theta["acn time"])


def _features(bench: Bench, condition: Condition) -> dict[str, F64]:
    time, v, period = _period(bench, condition)
    sample = _sample(bench, condition)
    if condition.circuit == "adaptive-neuron":
        at = (np.arange(PHASES) + 0.5) / PHASES * period
        return {
            "isi_samples": np.full(PHASES, period / sample),
            "shape_V": bench.adc(np.interp(at, time, v)),
        }
    # a jump begins and ends at most _EDGE from where the membrane moves most
    inner = slice(1, -1)  # not the jump at which the period begins
    rate = np.diff(v[inner]) / np.maximum(np.diff(time[inner]), 1e-12)
    fall = float(time[inner][int(np.argmin(rate))])
    moments = {
        "threshold_up_V": period - _EDGE, "top_V": _EDGE, "threshold_down_V": fall - _EDGE,
        "bottom_V": fall + _EDGE,
    }  # fmt: skip
    found = {name: float(np.interp(t, time, v)) for name, t in moments.items()}
    scale = sample / condition.settings["sample_s"]
    found["rise_V_per_s"] = (
        scale * (found["threshold_up_V"] - found["bottom_V"]) / (period - fall - 2 * _EDGE)
    )
    found["fall_V_per_s"] = scale * (found["threshold_down_V"] - found["top_V"]) / (fall - 2 * _EDGE)
    return {name: np.array([found[name]]) for name in _FEATURES}


def features(condition: Condition, table: Table) -> Table:
    """What is fitted of a record: numbers of one neuron's cycle, or the other's shape over its period."""
    found = metrics_of(condition, table)
    if condition.circuit == "axon-hillock":
        return Table({name: np.array([value]) for name, value in _cycle(condition, found).items()})
    v, isi = table["v_mem_V"], found["isi_samples"].value
    begins = np.flatnonzero(np.diff(v) < -_FALL) + 1
    first = float(begins[0])
    phase = ((np.arange(v.size) - first) / isi) % 1.0
    # samples of all periods over one, from the first sample after the fall on
    order = np.argsort(phase)
    at = (np.arange(PHASES) + 0.5) / PHASES
    shape = [float(np.median(v[order][np.abs(phase[order] - p) < 0.5 / PHASES])) for p in at]
    return Table(isi_samples=np.full(PHASES, isi), shape_V=np.array(shape))


def _cycle(condition: Condition, found: Mapping[str, Metric]) -> dict[str, float]:
    """Where jumps begin and end: samples lie half a step before and after them on average."""
    half = 0.5 * condition.settings["sample_s"]
    rise, fall = found["rise_V_per_s"].value, found["fall_V_per_s"].value
    up, down = found["threshold_up_V"].value, found["threshold_down_V"].value
    values = (
        up + half * rise, up + found["jump_up_V"].value - half * fall, down + half * fall,
        down + found["jump_down_V"].value - half * rise, rise, fall,
    )  # fmt: skip
    return dict(zip(_FEATURES, values, strict=True))


def _period(bench: Bench, condition: Condition) -> tuple[F64, F64, float]:
    """One period of a membrane from its fall (or its rise by a jump) on: times, voltages, length in s."""
    run = _axon_hillock if condition.circuit == "axon-hillock" else _adaptive
    result = run(bench, condition)
    spikes = result.spikes["spike"]
    if spikes.size < 3:
        raise SolverError(f"{condition.file}: {spikes.size} spikes, must be three for a period")
    begin, end = float(spikes[-2]), float(spikes[-1])
    inside = (result.time >= begin) & (result.time <= end)
    return result.time[inside] - begin, result["v_mem"][inside], end - begin


def _axon_hillock(bench: Bench, condition: Condition) -> Result:
    theta = bench.theta
    params = axon_hillock.Params(line_capacitance=math.exp(theta["ahn line"]))
    circuit = axon_hillock.build(params)
    gate = _gate(bench, condition, "AHN_VPW_N", _RESET)
    current = math.exp(theta["ahn input"])
    sources = (*powered(V_DD, {"v_pw": gate}), current_into("v_mem", current))
    total = (params.membrane_capacitance + params.feedback_capacitance + params.line_capacitance) * V_DD
    stop = min(8.0 * total / current, 60.0)
    testbench = Testbench("axon hillock", circuit, sources, stop, watch=("spike",), initial={"v_mem": 0.6})
    return simulate(lowered(testbench, bench.silicon(circuit.name)), rtol=_RTOL, record=("v_mem",))


def _adaptive(bench: Bench, condition: Condition) -> Result:
    theta = bench.theta
    circuit = adaptive_neuron.build(adaptive_neuron.Params(line_capacitance=math.exp(theta["acn line"])))
    waves: dict[str, Wave] = {
        "v_dc": _gate(bench, condition, "ACN_VDC_P", _INPUT),
        "v_gain": _gate(bench, condition, "ACN_VGAIN_N", _SQUARE, theta["acn gain"]),
        "v_leak": _gate(bench, condition, "ACN_VLEAK_N", _SQUARE),
        "v_ref": _gate(bench, condition, "ACN_VREFR_N", _SQUARE, theta["acn reset"]),
        "adapt": 0.0, "dc_off": 0.0, "v_aw": 0.0, "v_athr": 0.0, "v_atau": V_DD, "v_casc": 0.0,
    }  # fmt: skip
    stop = 0.25e-3 * math.exp(theta["acn time"]) * 53.0 * 5.0
    testbench = Testbench(
        "adaptive neuron", circuit, powered(V_DD, waves), stop, watch=("spike",), initial={"v_mem": 0.0}
    )
    return simulate(lowered(testbench, bench.silicon(circuit.name)), rtol=_RTOL, record=("v_mem",))


def usable(condition: Condition, table: Table) -> dict[str, Bools]:
    """All of the features."""
    del condition
    return {name: np.isfinite(column) for name, column in table.items()}


def noise(condition: Condition, predicted: Mapping[str, F64]) -> dict[str, F64]:
    """Standard deviation of readings and of features."""
    del condition
    found = {}
    for name, value in predicted.items():
        known = dict(zip(_FEATURES, _SPREADS, strict=True))
        sd = {"shape_V": _SHAPE, "isi_samples": _ISI * math.sqrt(PHASES), "v_mem_V": math.hypot(_NOISE, ADC)}
        found[name] = np.full(value.size, known.get(name, sd.get(name, _NOISE)))
    return found
