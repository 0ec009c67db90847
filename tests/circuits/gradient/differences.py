"""Central differences of measures by parameters of a machine, at a tolerance of 1e-9."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from circuits.arrays import F64
from circuits.devices import Transistor
from circuits.gradient.expression import Expression
from circuits.gradient.measure import Measure, Measured
from circuits.gradient.small_signal.spectrum import Spectrum
from circuits.gradient.small_signal.transfer import SmallSignal
from circuits.gradient.way import Way, way_of
from circuits.lowering.kernel import Machine, on_die, to_kernel
from circuits.measure.scope import TransientRecord
from circuits.silicon.die import shared
from circuits.solver.operating_point import operating_point, solve_near
from circuits.solver.transient import simulate

RTOL = 1e-9


def read(machine: Machine, measure: Measure) -> float:
    """The measure in a run of its own."""
    result = simulate(machine, rtol=RTOL)
    return measure.read(result, way_of(result)).value


def by_deviation(machine: Machine, measure: Measure, label: str, step: float) -> float:
    """Derivative by a device's or the process's deviation, whose label a study's draws have."""
    return float(by_deviations(machine, (measure,), label, step)[0])


def by_deviations(machine: Machine, measures: Sequence[Measure], label: str, step: float) -> F64:
    """Derivatives of some measures by a deviation, float64[measures]."""
    owner, _, parameter = label.rpartition(".")
    path, at = owner.removesuffix(".shared"), deviation_of(machine, label)
    there = [machine.silicon.die.with_(path, parameter, at + s) for s in (step, -step)]
    return _difference([on_die(machine, die) for die in there], measures, step)


def _difference(machines: Sequence[Machine], measures: Sequence[Measure], step: float) -> F64:
    """Central difference of the measures of two machines, a run of each."""
    ends = []
    for machine in machines:
        result = simulate(machine, rtol=RTOL)
        record, way = TransientRecord(result), way_of(result)
        ends.append(np.array([_value(measure, record, way) for measure in measures]))
    return np.asarray((ends[0] - ends[1]) / (2.0 * step))


def _value(measure: Measure, record: TransientRecord, way: Way) -> float:
    """A measure of a run, of what is read in several places the number alone."""
    if isinstance(measure, Expression):
        return measure.text.of(record).value
    if isinstance(measure, Measured):
        return measure.value(record.result)[0]
    return measure.read(record.result, way).value


def deviation_of(machine: Machine, label: str) -> float:
    """What a device, or a polarity, deviates by on the machine's die."""
    owner, _, parameter = label.rpartition(".")
    silicon = machine.silicon
    if owner.startswith("process."):
        return float(getattr(shared(silicon.die, silicon.process, owner.split(".")[1]), parameter))
    for group in machine.flat.groups:
        if isinstance(group.device, Transistor):
            size = group.parameters
            area = size["width"] * size["length"] * size["multiplicity"]
            path = (*group.path, (group.device.name, ()))
            own = silicon.deviation(machine.flat.circuit.name, path, area, group.device.polarity)
            values = np.broadcast_to(np.asarray(getattr(own, parameter)), area.shape)
            for k in range(area.size):
                if label.endswith(f"{group.label(k)}.{parameter}"):
                    return float(values[k])
    raise LookupError(label)


def by_temperature(machine: Machine, measure: Measure, step: float) -> float:
    """Derivative by the temperature."""
    return float(by_temperatures(machine, (measure,), step)[0])


def by_temperatures(machine: Machine, measures: Sequence[Measure], step: float) -> F64:
    """Derivatives of some measures by the temperature, float64[measures]."""
    silicon = machine.silicon
    there = [replace(silicon, temperature_c=silicon.temperature_c + s) for s in (step, -step)]
    return _difference([to_kernel(machine.testbench, each) for each in there], measures, step)


def by_small_signals(
    machine: Machine, measures: Sequence[SmallSignal], label: str, step: float, start: F64
) -> F64:
    """Derivatives of measures of small signals by a deviation, float64[measures]; start: of the rest state.

    Two central differences, whose errors of second order cancel.
    """
    owner, _, parameter = label.rpartition(".")
    path, at = owner.removesuffix(".shared"), deviation_of(machine, label)
    found = []
    for wide in (step, 2.0 * step):
        ends = []
        for s in (wide, -wide):
            there = on_die(machine, machine.silicon.die.with_(path, parameter, at + s))
            spectrum = Spectrum(solve_near(there, start) or operating_point(there))
            ends.append(np.array([each.read(spectrum).value for each in measures]))
        found.append((ends[0] - ends[1]) / (2.0 * wide))
    return np.asarray((4.0 * found[0] - found[1]) / 3.0)
