"""What a measurement of circuits rests on beside the circuits: the law, evaluated at a fixed lattice.

A record carries the numbers of its own day (`Law`). When it is read, the same functions are evaluated again
in the same process, and where a number has moved by more than `TOLERANCE` the record is stale: it stands for
transistors that noctule no longer has. A function that is renamed or moved changes no number, another
processor none by so much; a constant or an equation that is changed does.

| family | what is evaluated |
|---|---|
| unit | 1 with every prefix, read from its text |
| event | the lengths of the pulse by which an event enters a circuit, s |
| temperature | U_T, and per polarity I_S of a square device, V_T0, kappa, gamma, leakage, at `TEMPERATURES` |
| current, slope | drain currents at `POINTS`, A, and their derivatives by drain, gate and source voltage, S |
| junction, junction_slope | leakage of both junctions there, A, and its derivative, S |
| capacitance | capacitances of devices of `SIZES`, F |
| mismatch | V_T0 (V) and beta of devices of `SIZES` on `DIE`, and what all of a polarity share there |
| bias | gate voltages (V) that give `CURRENTS` by the kinds `gate` and `ideal`, and what these give, A |
| closed_form | the interpolation and the pinch-off voltage as models take them, and their inverses |

All of it is for the process's own parameters, and from temperature to junction also with every effect on that
can be off (`_with_effects`). The numbers of the lattice are ours: from off to strong inversion, forward and
reverse, and with junctions forward biased. None is a difference of nearly equal numbers, which another
processor's rounding would move.

Codes of a chip carry their law too, as a key (`law_key`): two sums for each family, which move by more than
`TOLERANCE` where any number of it does. No record is measured with the bias generator's circuit, but codes
are found with it. So their key has one more family, `generator`: the voltages of its masters and of lines for
`CURRENTS` on `DIE`, V.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from circuits.arrays import F64
from circuits.bias import bias_voltages, saturation_current
from circuits.circuit import Bias, BiasKind, Circuit, Port
from circuits.devices import Transistor
from circuits.devices.ekv import argument, interpolation, of_weak, steepness, weak_over
from circuits.devices.pinch_off import pinch_off
from circuits.devices.transistor import capacitances, drain_currents, transistor_arrays, transistor_work
from circuits.errors import DataError, ParameterError, SolverError
from circuits.event import EDGE, HALF_WIDTH, LENGTH, WIDTH
from circuits.generator.voltage import Line, line_voltages, masters_at_rest, resistor_of
from circuits.silicon.die import Die, shared
from circuits.silicon.process import (
    POLARITIES,
    Polarity,
    Process,
    TransistorModel,
    Variation,
    at_temperature,
    thermal_voltage,
)
from circuits.silicon.silicon import Silicon
from circuits.silicon.size import SizeTerms
from circuits.solver.version import VERSION
from circuits.units import parse_quantity

TOLERANCE = 1e-9  # relative; ours: other processors and libraries stay a thousand times below it
PREFIXES = ("a", "f", "p", "n", "u", "m", "", "k", "M", "G", "T")
TEMPERATURES = (-10.0, 27.0, 65.0)  # degC
SIZES = ((6e-6, 6e-6, 1.0), (24e-6, 3e-6, 2.0), (3e-6, 12e-6, 1.0))  # width and length, m; multiplicity
POINTS = (  # drain, gate and source above the bulk, over the supply; mirrored for a pFET
    (0.02, 0.10, 0.00), (1.00, 0.10, 0.00), (0.20, 0.15, 0.00), (1.00, 0.15, 0.05), (0.05, 0.20, 0.20),
    (0.50, 0.20, 0.00), (1.00, 0.40, 0.00), (0.10, 0.40, 0.00), (0.50, 1.00, 0.10), (0.02, 1.00, 0.00),
    (0.30, 0.00, 0.00), (-0.05, 0.15, 0.00), (0.50, 0.00, -0.15), (0.50, -0.05, 0.00),
)  # fmt: skip
DIE = Die(lot="0", number=500)
CURRENTS = (10e-12, 1e-9, 0.3e-6)  # A
_UNTOLD = {"components", "cards"}  # of a process, in a record: they move no number of the law
DRIVES = (-20.0, -3.0, 0.5, 10.0)  # arguments of the interpolation
KINDS: tuple[BiasKind, ...] = ("gate", "ideal")
_STEPS = (0.6180339887, 0.4142135623)  # of weights, irrational so that few coincide


@dataclass(frozen=True, slots=True, eq=False)
class Law:
    """The law of a process at the time of a measurement.

    Attributes
    ----------
    process
        The process with all its parameters.
    solver
        Version of the solvers (`circuits.solver.version`).
    values
        Numbers by family, float64, one dimension each.
    """

    process: Process
    solver: int
    values: Mapping[str, F64]


@cache
def law_of(process: Process) -> Law:
    """Return today's law of a process, which is evaluated once: it takes some milliseconds.

    It is without components of variation, for records are measured on dies that have none.
    """
    process = replace(process, components=None)
    currents = [_currents(process, model, t) for model in _models(process) for t in TEMPERATURES]
    families = {
        "unit": [parse_quantity(f"1{prefix}s", "s", "unit") for prefix in PREFIXES],
        "event": [WIDTH, EDGE, HALF_WIDTH, LENGTH],
        "temperature": [_at(process, model, t) for model in _models(process) for t in TEMPERATURES],
        **{name: [c[name] for c in currents] for name in currents[0]},
        "capacitance": [_capacitances(process.model(polarity)) for polarity in POLARITIES],
        "mismatch": _mismatch(process),
        "bias": [_biases(process, polarity) for polarity in POLARITIES],
        "closed_form": _closed_forms(process),
    }
    return Law(
        process, VERSION, {name: np.ravel(np.array(f, dtype=np.float64)) for name, f in families.items()}
    )


def changed(kept: Law) -> str:
    """Return what a record was made by that is no longer so, empty where nothing has changed."""
    now = law_of(kept.process)
    if kept.solver != now.solver:
        return f"solvers of version {kept.solver}, not {now.solver}"
    families = {**kept.values, **now.values}
    return _told([name for name in families if not _same(kept.values.get(name), now.values.get(name))])


@cache
def law_key(process: Process) -> dict[str, tuple[float, ...]]:
    """Return today's law of a process as codes carry it: two sums a family, and the solvers' version.

    Each sum is of logarithms of the family's numbers with weights from 1 to 2, so that a number that is
    larger by a small share moves it by that share or more.
    """
    law = law_of(process)
    families = {**law.values, "generator": _generator(law.process)}
    return {"solver": (float(law.solver),)} | {name: _sums(values) for name, values in families.items()}


def key_changed(kept: Mapping[str, tuple[float, ...]], process: Process) -> str:
    """Return what of a process's law codes were found by that is no longer so, empty where nothing is."""
    if not kept:
        return "a law that they do not tell"
    now = law_key(process)
    apart = {name: np.subtract(now.get(name, math.nan), kept.get(name, math.nan)) for name in {**kept, **now}}
    return _told([name for name, x in apart.items() if not (np.abs(x) <= TOLERANCE).all()])


def law_text(law: Law) -> tuple[str, F64]:
    """Return a law as text and numbers, float64, one dimension, which `law_from` reads to the bit."""
    sizes = {family: values.size for family, values in law.values.items()}
    process = {name: value for name, value in asdict(law.process).items() if name not in _UNTOLD}
    for polarity in POLARITIES:
        if process[polarity]["size"] is None:
            del process[polarity]["size"]  # as in records from before numbers could follow the size
    text = json.dumps({"process": process, "solver": law.solver, "families": sizes})
    return text, np.concatenate(list(law.values.values()))


def law_from(text: str, numbers: F64) -> Law:
    """Return the law that `law_text` wrote.

    Raises `DataError` where it is none, or its process has a parameter that processes no longer have.
    """
    try:
        found = json.loads(text)
        process, sizes = found["process"], found["families"]
        models = {polarity: _model_of(process.pop(polarity)) for polarity in POLARITIES}
        process = Process(**{**process, **models, "variation": Variation(**process["variation"])})
        ends = np.cumsum(list(sizes.values()))
        if numbers.ndim != 1 or numbers.size != ends[-1]:
            raise ValueError(f"{numbers.size} numbers for {ends[-1]}")
        return Law(process, int(found["solver"]), dict(zip(sizes, np.split(numbers, ends[:-1]), strict=True)))
    except (ValueError, TypeError, KeyError, AttributeError, IndexError) as error:
        raise DataError(f"law: {' '.join(str(error).split())[:200]}, must be of today's process") from None


def _model_of(numbers: dict[str, Any]) -> TransistorModel:
    """A model of its numbers, with the terms of its size where it has some."""
    size = numbers.pop("size", None)
    return TransistorModel(**numbers, size=None if size is None else SizeTerms(**size))


def _told(families: list[str]) -> str:
    return f"another law of {', '.join(families)}" if families else ""


def _sums(values: F64) -> tuple[float, float]:
    """Two sums of the logarithms of numbers, of which 0 counts as e, and negative ones as e-fold."""
    size = np.log(np.abs(values), where=values != 0.0, out=np.ones(values.shape)) + (values < 0.0)
    weights = (1.0 + np.arange(values.size) * step % 1.0 for step in _STEPS)
    one, other = (math.fsum(weight * size) for weight in weights)
    return one, other


def _generator(process: Process) -> F64:
    """Voltages of masters and lines, V; 0 where the process has no room for the generator."""
    place = (("law", ()),)
    found: list[F64] = []
    try:
        resistance = resistor_of(process)
        for silicon in (Silicon(process, t, DIE, place) for t in TEMPERATURES):
            found += masters_at_rest(silicon, resistance).voltages.values()
            for polarity in POLARITIES:
                device = Transistor("m", polarity, "out", "gate", "0", "0", *SIZES[1])
                line = Line(place, "line", (len(CURRENTS),), None, device)
                found.append(line_voltages(line, np.array(CURRENTS), silicon))
    except (SolverError, ParameterError):
        return np.zeros(1)
    return np.concatenate(found)


def _same(one: F64 | None, other: F64 | None) -> bool:
    if one is None or other is None or one.shape != other.shape:
        return False
    return bool(np.allclose(one, other, rtol=TOLERANCE, atol=0.0))


def _models(process: Process) -> list[tuple[Polarity, TransistorModel]]:
    own = [(polarity, process.model(polarity)) for polarity in POLARITIES]
    return [*own, *((polarity, _with_effects(model)) for polarity, model in own)]


def _with_effects(model: TransistorModel) -> TransistorModel:
    """A model with every second-order effect; the numbers are ours."""
    return replace(
        model, law="ekv-gamma", early_field=5e6, early_rise=0.2, mobility_reduction=0.5,
        junction_leakage=1e-6, gate_induced_leakage=1e-6, gate_induced_slope=0.5,
    )  # fmt: skip


def _at(process: Process, model: tuple[Polarity, TransistorModel], temperature_c: float) -> list[float]:
    law = at_temperature(model[1], process, temperature_c)
    return [
        thermal_voltage(temperature_c), law.square_current, law.u_t, law.v_t0, law.kappa, law.gamma,
        law.surface_potential, law.early_field, law.early_rise, law.mobility_reduction,
        law.junction_leakage, law.gate_induced_leakage, law.gate_induced_slope, law.gate_induced_from,
    ]  # fmt: skip


def _currents(
    process: Process, model: tuple[Polarity, TransistorModel], temperature_c: float
) -> dict[str, F64]:
    polarity, own = model
    n = len(POINTS)
    bulk, sign = (0.0, 1.0) if polarity == "n" else (process.v_dd, -1.0)
    above = process.v_dd * np.array(POINTS).T
    width, length, multiplicity = (np.resize(side, n) for side in zip(*SIZES, strict=True))
    arrays = transistor_arrays(
        np.arange(4 * n, dtype=np.int32).reshape(4, n), polarity, at_temperature(own, process, temperature_c),
        width, length, multiplicity, delta_v_t=5e-3, relative_beta=0.02,
    )  # fmt: skip
    work = transistor_work(n)
    drain_currents(arrays, np.concatenate([(bulk + sign * above).ravel(), np.full(n, bulk)]), work)
    return {
        "current": work.current,
        "slope": work.conductance,
        "junction": work.junction,
        "junction_slope": work.junction_conductance,
    }


def _capacitances(model: TransistorModel) -> list[F64]:
    width, length, multiplicity = (np.array(side) for side in zip(*SIZES, strict=True))
    found = capacitances(model, width, length, multiplicity)
    return [found[pair] for pair in sorted(found)]


def _mismatch(process: Process) -> list[float]:
    silicon = Silicon(process, die=DIE)
    area = np.array([width * length * multiplicity for width, length, multiplicity in SIZES])
    path = (("array", (area.size,)), ("device", ()))
    local = silicon.of_area(2.0).deviation("law", path, area)
    common = [x for polarity in POLARITIES for x in shared(DIE, process, polarity)]
    laws = [silicon.law(polarity) for polarity in POLARITIES]
    return [
        *np.ravel(local.v_t0),
        *np.ravel(local.beta),
        *common,
        *(x for law in laws for x in (law.v_t0, law.square_current)),
    ]


def _biases(process: Process, polarity: Polarity) -> list[F64]:
    rail = "0" if polarity == "n" else "vdd"
    width, length, multiplicity = SIZES[1]
    device = Transistor("m", polarity, "out", "gate", rail, rail, width, length, multiplicity)
    ports = Port("vdd", "supply"), Port("out", "analog"), Port("gate", "bias", shape=(len(CURRENTS),))
    circuit = Circuit("law", ports, (replace(device, gate="gate[0]"),))
    found = []
    for kind in KINDS:
        bias = Bias("i", "gate", kind, CURRENTS, "m")
        for t in TEMPERATURES:
            silicon = Silicon(process, t, DIE)
            found += [bias_voltages(circuit, bias, silicon), saturation_current(circuit, bias, silicon)]
    return found


def _closed_forms(process: Process) -> list[F64]:
    drive = np.array(DRIVES)
    f = interpolation(drive)
    forms = [f, argument(f), of_weak(np.exp(drive)), weak_over(f), steepness(f)]
    kappa, threshold = process.n.kappa, process.n.v_t0
    return [*forms, pinch_off(kappa, process.v_dd * drive / max(DRIVES), threshold)]
