"""Measurement of what mismatch does to the hearing's thresholds, with the transistor-level solver.

| quantity | measured as |
|---|---|
| log threshold | smallest peak of a lone sound at the microphone that makes a spike, bisected |
| rest margin | by how much v_level (V) may fall before `v_active` of the resting onset neuron is high |

Each with central differences over the deviations of `chips.hearing.mismatch`, at every temperature. A rest
margin below zero is a neuron that is silent at rest: from power-up on, and after a spike, its refractory
capacitor is held empty, until the tail of a loud sound takes v_h far enough below its rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from chips.hearing.mismatch import PARAMETERS
from chips.hearing.model import hearing_on, rest_margin_on
from chips.measured.held_out import rms_and_max
from chips.measured.perturbation import deviating
from chips.measured.search import narrowed_by_share
from chips.measured.table_record import POLARITIES, TEMPERATURES, shifts
from circuits.arrays import F64
from circuits.blocks.sonar import envelope_detector, high_threshold_neuron, onset_neuron
from circuits.circuit import Circuit
from circuits.devices import Source
from circuits.devices.source import Constant, PiecewiseLinear, Polyline
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon.die import NOMINAL
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point, solve_near
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

RTOL, NEURON_RTOL = 1e-4, 1e-4
ONSET, DURATION, STOP = 0.3e-3, 1e-3, 2.5e-3  # s, of the sound and of the run
CLOSE = 5e-5  # of a bisected threshold, relative
LEVEL = 20e-6  # V, of a bisected rest margin; nearer to the edge there is no state to be found
FAR = 0.3  # V, within which a rest margin lies
BRACKETS = {"onset_neuron": (5e-3, 0.4), "high_threshold_neuron": (1.0, 2.0)}  # V, of a threshold
STEPS = {"v_t0": 1e-3, "beta": 0.01}  # V, and of ln beta; larger ones silence the neuron at 65 degC
NEURONS: dict[str, Callable[[], Circuit]] = {
    "onset_neuron": onset_neuron.build,
    "high_threshold_neuron": high_threshold_neuron.build,
}
BENT, BEND_STEP = "onset_neuron/generator.comparator.mc6.v_t0", 3e-3  # V
EVERY = "*"  # in the place of a circuit: all of them
REST_SHIFTS = shifts(9)  # V
WIDE = 1.1  # about the nominal threshold, within which a step moves it
GRADIENTS = {
    "onset_neuron": "onset_threshold_gradient",
    "high_threshold_neuron": "high_threshold_threshold_gradient",
    "rest": "onset_rest_margin_gradient",
}


@dataclass(frozen=True, slots=True)
class Deviating:
    """The hearing's circuits on a silicon with one deviation.

    parameter: a name of `PARAMETERS`, none if empty; amount: of the deviation, V or 1.
    """

    silicon: Silicon
    parameter: str = ""
    amount: float = 0.0

    def machine(self, bench: Testbench) -> Machine:
        """Return the testbench lowered for the solver, with the deviation where it has the device."""
        machine = to_kernel(bench, self.silicon)
        circuit, _, name = self.parameter.partition("/")
        if circuit not in {bench.circuit.name, EVERY}:
            return machine
        return deviating(machine, name, self.amount)


def gradients(process: Process) -> dict[str, F64]:
    """Return the derivatives of thresholds and rest margin by `PARAMETERS`, by the name of their table.

    Each is float64[temperatures, parameters], 1/V or 1 of ln(threshold), V/V or V of the margin. It takes
    four minutes on one core.
    """
    rows = [_at(Silicon(process, t)) for t in TEMPERATURES]
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def rest_margins(process: Process) -> F64:
    """Return the rest margin over temperature, polarity and `REST_SHIFTS`, V.

    The array is float64[temperatures, 2, shifts]. Bias voltages stay where they are, so that a shift of the
    pFETs moves the comparator's current.
    """
    return np.array(
        [
            [
                [rest_margin(Deviating(Silicon(process, t), f"{EVERY}/{p}.v_t0", s)) for s in REST_SHIFTS]
                for p in POLARITIES
            ]
            for t in TEMPERATURES
        ]
    )


def rest_bends(process: Process) -> F64:
    """Return the curvature of the rest margin by what mc6 adds to it, 1/V, float64[temperatures]."""
    found = []
    for t in TEMPERATURES:
        low, middle, high = (
            rest_margin(Deviating(Silicon(process, t), BENT, k * BEND_STEP)) for k in (-1.0, 0.0, 1.0)
        )
        found.append((high - 2.0 * middle + low) / (0.5 * (high - low)) ** 2)
    return np.array(found)


def _at(silicon: Silicon) -> dict[str, F64]:
    nominal = Deviating(silicon)
    brackets = {n: _about(threshold(nominal, n)) for n in NEURONS}
    found: dict[str, list[float]] = {name: [] for name in GRADIENTS.values()}
    for parameter in PARAMETERS:
        circuit, _, name = parameter.partition("/")
        h = STEPS[name.rpartition(".")[2]]
        pair = Deviating(silicon, parameter, -h), Deviating(silicon, parameter, h)
        for neuron, bracket in brackets.items():
            seen = circuit in {neuron, "envelope_detector"}
            low, high = (threshold(c, neuron, bracket) if seen else 1.0 for c in pair)
            found[GRADIENTS[neuron]].append(math.log(high / low) / (2.0 * h))
        low, high = (rest_margin(c) if circuit == "onset_neuron" else 0.0 for c in pair)
        found[GRADIENTS["rest"]].append((high - low) / (2.0 * h))
    return {name: np.array(values) for name, values in found.items()}


def _about(peak: float) -> tuple[float, float]:
    return peak / WIDE, peak * WIDE


def threshold_errors(silicons: Iterable[tuple[int, Silicon]]) -> dict[str, float]:
    """Errors of thresholds (relative) and of the rest margin (V) on other dies, and how many are silent.

    silicons: as of `chips.measured.held_out.every_silicon`.

    A die whose onset neuron is silent at rest has no threshold of it, and neither has one whose rest margin
    is above zero by so little that no sound makes it spike; `silent_unmatched` counts those that are so on
    one level only. Of the onset neuron's threshold 2.4 % is the thinning of the envelope at its
    port, which the record has and a lone run does not.
    """
    off: dict[str, list[float]] = {"onset_threshold": [], "high_threshold_threshold": [], "rest_margin": []}
    silent, unmatched = 0, 0
    for _, silicon in silicons:
        case, model = Deviating(silicon), hearing_on(silicon)
        margin = rest_margin(case)
        ours = rest_margin_on(silicon)
        off["rest_margin"].append(ours - margin)
        high = threshold(case, "high_threshold_neuron")
        off["high_threshold_threshold"].append(math.log(model.high_threshold.threshold / high))
        onset = threshold(case, "onset_neuron") if margin > 0.0 else math.inf
        silent += math.isinf(onset)
        unmatched += math.isinf(onset) != (ours < 0.0)
        if math.isfinite(onset):
            off["onset_threshold"].append(math.log(model.onset.threshold / onset))
    errors = {"silent_dies": float(silent), "silent_unmatched": float(unmatched)}
    for name, values in off.items():
        errors |= rms_and_max(name, values, "V" if name == "rest_margin" else "")
    return errors


def threshold(case: Deviating, name: str, bracket: tuple[float, float] | None = None) -> float:
    """Return the least peak at the microphone (V) of a lone sound at which a neuron spikes, inf for none.

    case: the circuits; name: of the neuron; bracket: V, within which the threshold is looked for.
    """
    low, high = BRACKETS[name] if bracket is None else bracket
    if not fires(case, name, high):
        return math.inf
    low, high = narrowed_by_share(lambda peak: fires(case, name, peak), low, high, CLOSE)
    return math.sqrt(low * high)


def fires(case: Deviating, name: str, peak: float) -> bool:
    """Return whether a lone sound of this peak (V) makes the neuron `name` spike."""
    time, value = _envelope(case, peak)
    line = PiecewiseLinear(tuple(time.tolist()), tuple(value.tolist()))
    bench = _neuron(case, NEURONS[name](), Source("envelope", "envelope", line))
    return bool(simulate(case.machine(bench), rtol=NEURON_RTOL, record=()).spikes["spike"].size)


def rest_margin(case: Deviating) -> float:
    """Return by how much v_level may fall before the resting onset neuron is silent, V, below 0 if it is."""
    circuit = onset_neuron.build()
    level = float(np.asarray(circuit.bias("v_level").value))
    half = 0.5 * case.silicon.process.v_dd
    pedestal = Constant(float(_envelope(case, 0.0)[1][0]))
    low, high = level - FAR, level + FAR
    # states of the nominal device on either side of the edge: starts from which others are found
    plain = Deviating(replace(case.silicon, die=NOMINAL))
    silent, ready = (operating_point(_resting(plain, circuit, pedestal, v)) for v in (low, high))
    while high - low > LEVEL:
        middle = 0.5 * (low + high)
        machine = _resting(case, circuit, pedestal, middle)
        found = (solve_near(machine, near.voltage) for near in (ready, silent))
        point = next((p for p in found if p is not None), None) or operating_point(machine)
        if point["generator.v_active"] < half:
            high, ready = middle, point
        else:
            low, silent = middle, point
    return level - 0.5 * (low + high)


def _resting(case: Deviating, circuit: Circuit, pedestal: Constant, level: float) -> Machine:
    sources = Source("envelope", "envelope", pedestal), Source("v_level", "v_level", Constant(level))
    return case.machine(_neuron(case, circuit, *sources))


def _neuron(case: Deviating, circuit: Circuit, *sources: Source) -> Testbench:
    supply = Source("vdd", "vdd", Constant(case.silicon.process.v_dd))
    return Testbench(circuit.name, circuit, (supply, *sources), STOP, watch=("spike",))


def _envelope(case: Deviating, peak: float) -> Polyline:
    v_dd = case.silicon.process.v_dd
    stop = STOP if peak > 0.0 else 1e-6
    wave = envelope_detector.tone_bursts(((ONSET, DURATION, peak),), stop, 0.5 * v_dd, v_dd)
    sources = (Source("vdd", "vdd", Constant(v_dd)), Source("microphone", "microphone", wave))
    bench = Testbench("envelope detector", envelope_detector.build(), sources, stop)
    result = simulate(case.machine(bench), rtol=RTOL, record=("envelope",))
    return result.time, result["envelope"]
