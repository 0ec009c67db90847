"""Runs a compiled Verilog-A cell: the compiler's residuals and Jacobians under an integrator of scipy's.

The compiler gives currents `i(v)`, charges `q(v)` and their derivatives; with `d` the driven ports,

    dq/dv_free dv_free/dt = -i_free - dq_free/dv_d dv_d/dt

which Radau IIA integrates from corner to corner of the pulses, from the operating point on.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from circuits.arrays import F64

CORNERS = (0.0, 0.1e-6, 10.1e-6, 10.2e-6)  # s, of an event's pulse
FREE = ("v_mem", "v_r", "v_ex", "inhibit", "fill", "fire")
DRIVEN = ("call", "echo", "v_ex_max")


@dataclass(frozen=True, slots=True)
class Drive:
    """Pulses' starts (s) and the level of v_ex_max (V)."""

    calls: Sequence[float]
    echoes: Sequence[float]
    v_ex_max: float


@dataclass(frozen=True, slots=True)
class CompiledCell:
    """A module as the compiler gives it, with the values of its parameters; `nodes` in its order."""

    module: Any
    figures: Mapping[str, float]
    nodes: tuple[str, ...]

    def spikes(self, drive: Drive, until: float) -> F64:
        """Times at which `fire` rises through 1/2, s."""
        starts = {t + c for t in (*drive.calls, *drive.echoes) for c in CORNERS}
        edges = sorted({0.0, *starts, until})
        y, found = self._rest(drive), []

        def fires(time: float, y: F64) -> float:
            return float(y[-1] - 0.5)

        rising: Any = fires
        rising.direction = 1.0
        for begin, end in itertools.pairwise(edges):
            first = min(1e-9, 0.1 * (end - begin))
            run = solve_ivp(
                lambda t, y: self._system(t, y, drive)[0],
                (begin, end), y, "Radau", jac=lambda t, y: self._system(t, y, drive)[1],
                events=rising, rtol=1e-6, atol=1e-7, first_step=first,
            )  # fmt: skip
            assert run.success, run.message
            y = run.y[:, -1]
            found += list(run.t_events[0])
        return np.array(found)

    def _rest(self, drive: Drive) -> F64:
        y = np.array([self.figures["v_rest"], self.figures["v_rest"] + 1.0, self.figures["v_dd"], 0, 0, 0])
        for _ in range(200):
            current, slope, _ = self._at(self._voltages(-1.0, y, drive)[0])
            step = np.linalg.solve(slope[:, : len(FREE)], -current)
            y = y + np.clip(step, -0.05, 0.05)
            if abs(step).max() < 1e-9:
                return np.asarray(y)
        raise AssertionError("no operating point")

    def _system(self, time: float, y: F64, drive: Drive) -> tuple[F64, F64]:
        """dv/dt of the free nodes and its derivative."""
        voltages, slopes = self._voltages(time, y, drive)
        current, conductance, capacitance = self._at(voltages)
        own = capacitance[:, : len(FREE)]
        pushed = capacitance[:, len(FREE) :] @ slopes
        rates, slopes_of_rates = (
            np.linalg.solve(own, x) for x in (-current - pushed, -conductance[:, : len(FREE)])
        )
        return np.asarray(rates), np.asarray(slopes_of_rates)

    def _voltages(self, time: float, y: F64, drive: Drive) -> tuple[dict[str, float], F64]:
        (call, d_call), (echo, d_echo) = (self._pulse(time, s) for s in (drive.calls, drive.echoes))
        voltages = dict(zip(FREE, y, strict=True)) | {"call": call, "echo": echo}
        return voltages | {"v_ex_max": drive.v_ex_max, "spike": 0.0}, np.array([d_call, d_echo, 0.0])

    def _pulse(self, time: float, starts: Sequence[float]) -> tuple[float, float]:
        """Voltage and slope of a line of pulses."""
        v_dd = self.figures["v_dd"]
        for start in starts:
            x, (_, top, fall, end) = time - start, CORNERS
            if 0.0 <= x < top:
                return v_dd * x / top, v_dd / top
            if top <= x < fall:
                return v_dd, 0.0
            if fall <= x < end:
                return v_dd * (end - x) / (end - fall), -v_dd / (end - fall)
        return 0.0, 0.0

    def _at(self, voltages: Mapping[str, float]) -> tuple[F64, F64, F64]:
        """Currents of the free nodes, their conductances and capacitances to the free and driven nodes."""
        module = self.module
        given = dict(self.figures) | {"mfactor": 1.0}
        for name, kind in zip(module.param_names, module.param_kinds, strict=True):
            if kind == "voltage":
                ends = [voltages[n] for n in name[2:-1].split(",")]
                given[name] = ends[0] - sum(ends[1:])
        residuals, jacobian = module.run_init_eval(given)
        rows = [self.nodes.index(n) for n in FREE]
        conductance, capacitance = np.zeros((2, len(self.nodes), len(self.nodes)))
        for i, j, g, c in jacobian:
            conductance[i, j] += g
            capacitance[i, j] += c
        block = np.ix_(rows, [*rows, *(self.nodes.index(n) for n in DRIVEN)])
        return np.array([residuals[r][0] for r in rows]), conductance[block], capacitance[block]
