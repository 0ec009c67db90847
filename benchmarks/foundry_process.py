"""What our transistor law leaves out of a real process, by how much: gf180mcu's 3.3 V devices.

The foundry's BSIM4 cards in ngspice against our law, one square device of each polarity, 3 um by 3 um,
saturated. The law's three parameters V_T0, kappa and mu Cox are fitted to the
foundry's current at 27 degC, source at bulk, where it is from 10 pA to 10 uA; everything else is predicted:
temperature by our process's laws (dV_T0/dT, mobility's exponent), body effect with a constant kappa (`ekv`)
or with that which gamma gives (`ekv-gamma`). The foundry's current is the drain's, its leakage included.

Rows: `ours` is the law's value and `peer` the foundry's; of a current's error, the largest |ratio - 1| in a
region of the inversion coefficient. Nothing here is a pass or a failure.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.optimize import least_squares

from _report import Row, parser_of, report
from circuits.arrays import F64
from circuits.devices import Transistor
from circuits.devices.transistor import drain_current
from circuits.silicon.process import (
    AMI_1500_IDEAL,
    POLARITIES,
    Law,
    Polarity,
    Process,
    TransistorModel,
    at_temperature,
    thermal_voltage,
)
from netlists.foundry.deck import sweep_gate
from netlists.foundry.process import read_foundry

MAPPING = read_foundry("gf180mcu")
SIDE = 3e-6  # m
STEP = 5e-3  # V, of the gate
FITTED = (1e-11, 1e-5)  # A
TEMPERATURES = (-20.0, 27.0, 85.0)  # degC
SOURCES = (0.0, 0.5, 1.0, 1.5)  # V to the bulk
LAWS: tuple[Law, ...] = ("ekv", "ekv-gamma")
PROBE = 1e-9  # A, at which gate voltages are compared
PROBES = (1e-10, 1e-8, 1e-6, 1e-5)  # A, at which g_m / I_D is compared
REGIONS = {"weak": (1e-4, 0.1), "moderate": (0.1, 10.0), "strong": (10.0, 100.0)}  # inversion coefficients


@dataclass(frozen=True, slots=True)
class Case:
    """One polarity: the fitted model, and the foundry's currents by (temperature, source)."""

    polarity: Polarity
    model: TransistorModel
    gate: F64
    current: dict[tuple[float, float], F64]

    def law(self, temperature_c: float, source: float, law: Law = "ekv") -> F64:
        """Our law's current over `gate`, A."""
        return ours(replace(self.model, law=law), self.gate, temperature_c, source)


def ours(model: TransistorModel, gate: F64, temperature_c: float, source: float) -> F64:
    """Current of a square nFET of the model, A; a pFET's is the same in mirrored voltages."""
    at = at_temperature(model, made_of(model), temperature_c)
    return drain_current(at, "n", SIDE, SIDE, MAPPING.v_dd, gate, source)


def made_of(model: TransistorModel) -> Process:
    """A process of one model: the temperature laws take nothing else from it."""
    return replace(AMI_1500_IDEAL, n=model, p=model)


def measure(polarity: Polarity) -> Case:
    """Sweep the foundry's device, and fit the law to it."""
    device = Transistor("m", polarity, "d", "g", "s", "b", SIDE, SIDE)
    gate, current = np.zeros(0), {}
    for temperature_c, source in [(t, 0.0) for t in TEMPERATURES] + [(27.0, s) for s in SOURCES[1:]]:
        gate, (swept,) = sweep_gate([device], MAPPING, (0.0, MAPPING.v_dd, STEP), temperature_c, source)
        current[temperature_c, source] = swept
    return Case(polarity, fit(AMI_1500_IDEAL.model(polarity), gate, current[27.0, 0.0]), gate, current)


def fit(start: TransistorModel, gate: F64, current: F64) -> TransistorModel:
    """Model with V_T0, kappa and mu Cox that bring ln I closest; the rest as in `start`."""
    used = (current > FITTED[0]) & (current < FITTED[1])

    def changed(x: F64) -> TransistorModel:
        return replace(start, v_t0=float(x[0]), kappa=float(x[1]), mu_cox=float(np.exp(x[2])))

    def error(x: F64) -> F64:
        return np.log(ours(changed(x), gate[used], 27.0, 0.0) / current[used])

    return changed(least_squares(error, [start.v_t0, start.kappa, np.log(start.mu_cox)]).x)


def gate_at(gate: F64, current: F64, wanted: float) -> float:
    """Gate voltage at which a rising current is `wanted`, V."""
    rising = np.maximum.accumulate(current)
    return float(np.interp(np.log(wanted), np.log(rising), gate))


def efficiency_at(gate: F64, current: F64, wanted: float) -> float:
    """g_m / I_D where a rising current is `wanted`, 1/V."""
    return float(np.interp(gate_at(gate, current, wanted), gate, efficiency(gate, current)))


def efficiency(gate: F64, current: F64) -> F64:
    """g_m / I_D by central differences of ln I, 1/V."""
    return np.gradient(np.log(current), gate)


def rows_of(case: Case) -> Iterator[Row]:
    """All rows of one polarity."""
    p, m, foundry = case.polarity, case.model, case.current[27.0, 0.0]
    law = case.law(27.0, 0.0)
    fitted = f"fitted: V_T0 {m.v_t0:.3f} V, kappa {m.kappa:.3f}, mu Cox {m.mu_cox * 1e6:.0f} uA/V^2"
    specific = at_temperature(m, made_of(m), 27.0).square_current
    for region, (low, high) in REGIONS.items():
        inside = (foundry > low * specific) & (foundry < high * specific)
        ratio = (law / foundry)[inside]
        k = int(np.argmax(np.abs(np.log(ratio))))
        at, f = law[inside][k], foundry[inside][k]
        yield compared(f"{p}FET, {region} inversion, worst current (A)", (at, f), fitted)
    for wanted in PROBES:
        name = f"{p}FET, g_m/I_D at {wanted:g} A (1/V)"
        both = efficiency_at(case.gate, law, wanted), efficiency_at(case.gate, foundry, wanted)
        yield compared(name, both, fitted)
    yield from temperature_rows(case)
    yield from body_rows(case)


def temperature_rows(case: Case) -> Iterator[Row]:
    """Off current, and gate voltage and efficiency at `PROBE`, over temperature."""
    p, gate = case.polarity, case.gate
    for t in TEMPERATURES:
        law, foundry = case.law(t, 0.0), case.current[t, 0.0]
        yield compared(f"{p}FET, gate at 0 V, {t:g} degC (A)", (law[0], foundry[0]), "off current")
        if t == 27.0:
            continue
        both = gate_at(gate, law, PROBE), gate_at(gate, foundry, PROBE)
        yield compared(f"{p}FET, gate at {PROBE:g} A, {t:g} degC (V)", both, apart(both))
        both = efficiency_at(gate, law, PROBE), efficiency_at(gate, foundry, PROBE)
        limit = f"limit kappa / U_T = {case.model.kappa / thermal_voltage(t):.2f} 1/V"
        yield compared(f"{p}FET, g_m/I_D at {PROBE:g} A, {t:g} degC (1/V)", both, limit)


def body_rows(case: Case) -> Iterator[Row]:
    """Gate voltage to the bulk at `PROBE` with the source above the bulk."""
    for source in SOURCES[1:]:
        foundry = gate_at(case.gate, case.current[27.0, source], PROBE)
        for law in LAWS:
            both = gate_at(case.gate, case.law(27.0, source, law), PROBE), foundry
            name = f"{case.polarity}FET, gate at {PROBE:g} A, source {source:g} V, {law} (V)"
            yield compared(name, both, apart(both))


def compared(name: str, both: tuple[float, float], accuracy: str) -> Row:
    """Row of the law's value and the foundry's."""
    law, foundry = (float(x) for x in both)
    return Row(name, law, foundry, law / foundry, accuracy)


def apart(both: tuple[float, float]) -> str:
    """Difference of two voltages."""
    return f"{1e3 * (both[0] - both[1]):+.1f} mV"


def draw(cases: Sequence[Case], figure: Figure) -> None:
    """A row of axes a polarity: current, efficiency, body effect; the foundry's are lines, the law dashed."""
    grid = figure.subplots(len(cases), 3, squeeze=False)
    for case, axes in zip(cases, grid, strict=True):
        draw_case(case, *axes)
    figure.tight_layout()


def draw_case(case: Case, current: Axes, ratio: Axes, body: Axes) -> None:
    """Fill the three axes of one polarity."""
    for k, t in enumerate(TEMPERATURES):
        for i, style in ((case.current[t, 0.0], "-"), (case.law(t, 0.0), "--")):
            label = f"{t:g} °C" if style == "-" else None
            current.semilogy(case.gate, i, style, color=f"C{k}", label=label)
            seen = (i > FITTED[0] / 10.0) & (i < 10.0 * FITTED[1])
            ratio.semilogx(i[seen], efficiency(case.gate, i)[seen], style, color=f"C{k}", label=label)
    current.set(
        xlabel="gate voltage (V)", ylabel=f"drain current, {case.polarity}FET (A)", ylim=(1e-14, 1e-3)
    )
    ratio.set(xlabel="drain current (A)", ylabel="g_m/I_D (1/V)")
    points = [gate_at(case.gate, case.current[27.0, s], PROBE) for s in SOURCES]
    body.plot(SOURCES, points, "o-", color="k", label="foundry")
    for law, style in zip(LAWS, ("--", ":"), strict=True):
        line = [gate_at(case.gate, case.law(27.0, s, law), PROBE) for s in SOURCES]
        body.plot(SOURCES, line, style, color="C3", label=law)
    body.set(xlabel="source voltage to bulk (V)", ylabel=f"gate voltage at {PROBE:g} A (V)")
    for axes in (current, ratio, body):
        axes.legend(fontsize="small")


def main() -> int:
    """Measure and print all rows; draw them on request."""
    parser = parser_of(__doc__, "the same: it takes seconds")
    parser.add_argument("--plot", type=Path, metavar="FILE", help="picture of the currents")
    options = parser.parse_args()
    cases = [measure(polarity) for polarity in POLARITIES]
    rows = [row for case in cases for row in rows_of(case)]
    if options.plot is not None:
        mpl.use("Agg")
        figure = Figure(figsize=(13.0, 7.5))
        draw(cases, figure)
        figure.savefig(options.plot)
    return report(rows, options, figures)


def figures(row: Row) -> str:
    """The law's value, the foundry's, and their ratio."""
    return f"law {row.ours:10.4g}  foundry {row.peer:10.4g}  {row.ratio:6.3f}"


if __name__ == "__main__":
    sys.exit(main())
