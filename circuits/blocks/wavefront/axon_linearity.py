"""Delay of an axonal delay element over its code, and the metrics of it: unit, offset, non-linearity.

D(code) = unit code + offset, by least squares over codes 1 to 31
INL = max |D(code) - unit code - offset| / D(31)
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from operator import attrgetter

import numpy as np

from circuits.arrays import F64
from circuits.blocks.drive import elements, powered, step
from circuits.blocks.metric import Metric
from circuits.blocks.wavefront.axon_delay import BITS, HIGHEST, code_voltages
from circuits.circuit import Circuit
from circuits.devices.source import vertices
from circuits.errors import SolverError
from circuits.lowering.kernel import Machine, to_kernel
from circuits.silicon.silicon import Silicon
from circuits.solver.operating_point import operating_point
from circuits.solver.transient import DEFAULT_RTOL, Runner
from circuits.testbench import Testbench

FIRE_TIME = 1e-6  # s
EDGE = 1e-9  # s, of `fired`: what a cell gives
LONGEST = 10.0  # s that a delay is waited for
CODES = tuple(range(1, HIGHEST + 1))


@dataclass(frozen=True, slots=True)
class Linearity:
    """Delays of an element at codes 1 to 31, float64[31], s.

    reason: why there are none, empty where there are.
    """

    delays: F64
    reason: str = ""

    @property
    def unit(self) -> float:
        """Delay for each unit of the code, by the best line, s."""
        return float(np.polyfit(CODES, self.delays, 1)[0])

    @property
    def offset(self) -> float:
        """Delay at code 0, by the best line, s."""
        return float(np.polyfit(CODES, self.delays, 1)[1])

    @property
    def non_linearity(self) -> float:
        """Integral non-linearity, as a share of full scale."""
        line = np.polyval(np.polyfit(CODES, self.delays, 1), CODES)
        return float(np.abs(self.delays - line).max() / self.delays[-1])


def delay_machine(circuit: Circuit, silicon: Silicon) -> Machine:
    """The element with a cell that fires at 1 us and stays so, at code 1 until `delay_at` sets another."""
    v_dd = silicon.process.v_dd
    fired = step(FIRE_TIME - 0.5 * EDGE, FIRE_TIME + 0.5 * EDGE, 0.0, v_dd)
    bits = elements(circuit.port("v_code"), dict(enumerate(code_voltages(1, v_dd))))
    sources = powered(v_dd, {"fired": fired, **bits})
    return to_kernel(Testbench("axon delay", circuit, sources, np.inf, watch=("delayed",)), silicon)


def delay_at(machine: Machine, code: int, rtol: float = DEFAULT_RTOL) -> float:
    """Delay at a code, s, on a machine of `delay_machine`.

    Raises `SolverError` where the step has not come after 10 s.
    """
    lines = list(machine.polylines)
    for k, v in enumerate(code_voltages(code, machine.silicon.process.v_dd)):
        name = f"v_code[{k}]"
        lines[machine.source_names.index(name)] = vertices(name, (0.0,), (v,))
    coded = replace(machine, polylines=tuple(lines))
    runner = Runner(coded, (), rtol)
    _, segment = runner.advance(runner.begin(operating_point(coded)), FIRE_TIME + LONGEST)
    if not segment.spikes:
        raise SolverError(f"{machine.testbench.title}: no step within {LONGEST:g} s; raise i_delay")
    return segment.spikes[0][1] - FIRE_TIME


def delays_at(machine: Machine, codes: Sequence[int], rtol: float = DEFAULT_RTOL) -> F64:
    """Delays at several codes, float64[codes], s, on a machine of `delay_machine`."""
    return np.array([delay_at(machine, code, rtol) for code in codes])


def linearity(machine: Machine) -> Linearity:
    """Delays at all codes, on a machine of `delay_machine`; a failure is given as its reason."""
    try:
        return Linearity(delays_at(machine, CODES))
    except SolverError as error:
        return Linearity(np.full(len(CODES), math.nan), str(error))


def _outcome(found: Linearity) -> str:
    if found.reason:
        return "none"
    return "monotone" if (np.diff(found.delays) > 0.0).all() else "not-monotone"


def shown(_: Linearity) -> dict[str, float | None]:
    """Knobs of the testbench that show a delay: the middle code; the run lasts until the step is over."""
    return {"code": float(_MIDDLE)}


def _delay(found: Linearity) -> float:
    return float(found.delays[_MIDDLE - 1])


def _metric(name: str, unit: str, summary: str, value: Callable[[Linearity], float]) -> Metric:
    return Metric(
        name, unit, summary, ("axon_delay",), delay_machine, linearity, _outcome, attrgetter("reason"), value,
        shown=shown,
    )  # fmt: skip


_MIDDLE = 1 << (BITS - 1)  # code 16

DELAY = _metric("delay", "s", f"axonal delay at code {_MIDDLE}", _delay)
UNIT_DELAY = _metric(
    "unit_delay", "s", "axonal delay a unit of the code, by the best line", attrgetter("unit")
)
DELAY_OFFSET = _metric("delay_offset", "s", "axonal delay at code 0, by the best line", attrgetter("offset"))
INL = _metric(
    "inl", "", "integral non-linearity of the axonal delay, a share of full scale",
    attrgetter("non_linearity"),
)  # fmt: skip
