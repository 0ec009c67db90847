"""The test transistors behind their ammeters: shunts in series, an offset; a dead zone is left out.

An ammeter's amplifier has an offset of its own, which both the dead zone of the nFETs' and the floor of the
pFETs' come from: so it is one number an ammeter and range, which all sweeps share. Beside it each sweep has
the error of the one reading that was subtracted of it. A search for a source's voltage had none subtracted.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from circuits.arrays import F64, Bools
from circuits.blocks.bench.transistor import Params, nfet, pfet
from circuits.blocks.drive import current_into, driven
from circuits.devices import Source
from circuits.extraction.coach.bench import Bench, solved
from circuits.extraction.coach.conditions import V_DD, Condition
from circuits.extraction.coach.table import Table, columns_of
from circuits.extraction.coach.unknown import Unknown
from circuits.silicon.process import Polarity

SHUNT = {"high": 330.0, "low": 33e3}  # Ohm
_FLOOR = {"high": 3e-6, "low": 25e-9}  # A, below which the ammeter's dead zone may reach
_P_FLOOR = {"high": 4e-6, "low": 40e-9}  # a pFET's
_CLIP = {"high": 95e-6, "low": 0.9e-6}  # A, above which it clips, less a margin
_OFFSET = {"high": 1e-6, "low": 8e-9}  # A, of a sweep
_AMMETER = {
    ("n", "high"): (-1e-6, 1e-6), ("n", "low"): (-10e-9, 10e-9), ("p", "high"): (3.5e-6, 2e-6),
    ("p", "low"): (-14e-9, 14e-9),
}  # fmt: skip
"""Offset of an ammeter and its spread, A: a dead zone of 2 uA, 20 nA and 28 nA, of which a part is a shift,
and a floor of 1 to 6 uA."""
_RAW = 35e-9  # A, offset of a reading of which none was subtracted: that floor, in the low range
_NOISE = {"high": (0.005, 0.3e-6), "low": (0.01, 2e-9)}  # relative, and A; scaled by the fit
_SEARCH = 1.0e-3  # V: half a step of the voltage and what 5 % of the current leave


def unknowns(conditions: Mapping[str, Condition]) -> Iterator[Unknown]:
    """Shunts, and an offset of each sweep."""
    for name, ohm in SHUNT.items():
        yield Unknown(f"shunt {name}", math.log(ohm), 0.05, "ln", "nuisance", f"{ohm:g} Ohm told")
    for each in conditions.values():
        if each.circuit in ("nfet", "pfet") and each.settings["analysis"] != "source search":
            sd = _OFFSET[each.settings["range"]]
            yield Unknown(f"{each.name} offset", 0.0, sd, "A", "nuisance", "reading without a current")
    for (polarity, name), (mean, sd) in _AMMETER.items():
        yield Unknown(f"fet_{polarity} ammeter {name}", mean, sd, "A", "nuisance", "dead zone and floor")
    for polarity, held in (("n", 135e-9), ("p", 62.7e-9)):
        yield Unknown(
            f"fet_{polarity}_backgate held", 0.0, _RAW / held, "ln", "nuisance", "offset of the search"
        )


def predict(bench: Bench, condition: Condition, table: Table) -> dict[str, F64]:
    """Readings of a sweep, by column."""
    if condition.settings["analysis"] == "source search":
        return {"v_s_V": _searched(bench, condition, table)}
    polarity: Polarity = "n" if condition.circuit == "nfet" else "p"
    ohm = math.exp(bench.theta[f"shunt {condition.settings['range']}"])
    params = Params(drain_resistance=ohm, source_resistance=ohm)
    circuit = nfet(params) if polarity == "n" else pfet(params)
    volts = condition.voltages
    waves = {"drain": volts.get("v_d", 0.0), "gate": 0.0, "source": volts["v_s"]}
    waves |= {"well": volts["v_well"]} if polarity == "p" else {}
    over = {"gate": table["v_g_V"]} | ({"drain": table["v_d_V"]} if "v_d_V" in table else {})
    silicon = bench.silicon(circuit.name, (polarity,))
    through = np.abs(solved(circuit, driven(waves), silicon, over).current["m"])
    column = columns_of(condition)[1][0]
    ammeter = bench.theta[f"fet_{polarity} ammeter {condition.settings['range']}"]
    return {column: through + ammeter + bench.theta[f"{condition.name} offset"]}


def _searched(bench: Bench, condition: Condition, table: Table) -> F64:
    """The source's voltage at which the transistor carries the held current."""
    polarity: Polarity = "n" if condition.circuit == "nfet" else "p"
    ohm = math.exp(bench.theta["shunt low"])
    held = condition.settings["held_A"] * math.exp(bench.theta[f"fet_{polarity}_backgate held"])
    params = Params(drain_resistance=ohm, source_resistance=ohm)
    circuit = nfet(params) if polarity == "n" else pfet(params)
    sign = -1.0 if polarity == "n" else 1.0
    waves = {"drain": condition.voltages["v_d"], "gate": 0.0}
    waves |= {"well": condition.voltages["v_well"]} if polarity == "p" else {}
    sources: tuple[Source, ...] = (*driven(waves), current_into("source", sign * held))
    over, silicon = {"gate": table["v_g_V"]}, bench.silicon(circuit.name, (polarity,))
    found = solved(circuit, sources, silicon, over).voltage["source"]
    return np.clip(found, 0.0, condition.voltages.get("v_well", V_DD))


def usable(condition: Condition, table: Table) -> dict[str, Bools]:
    """Points that the ammeter can tell: above its dead zone, below its clip, in the range that is told."""
    column = columns_of(condition)[1][0]
    value, gate = table[column], table["v_g_V"]
    low, high = condition.settings.get("usable", (-math.inf, math.inf))
    kept = (gate >= low) & (gate <= high) & np.isfinite(value)
    if column != "v_s_V":
        kept &= value < _CLIP[condition.settings["range"]]
        floor = (_FLOOR if condition.circuit == "nfet" else _P_FLOOR)[condition.settings["range"]]
        kept &= value > floor
        if "v_d_V" not in table:  # beyond a reading in the dead zone or floor no other one is a current
            sign = 1.0 if condition.circuit == "nfet" else -1.0
            kept &= sign * gate > np.max(sign * gate[~(value > floor)], initial=-math.inf)
    return {column: np.asarray(kept)}


def noise(condition: Condition, predicted: Mapping[str, F64]) -> dict[str, F64]:
    """Standard deviation of readings, by column, before it is scaled by what the residuals say."""
    column, value = next(iter(predicted.items()))
    if column == "v_s_V":
        return {column: np.full(value.size, _SEARCH)}
    relative, floor = _NOISE[condition.settings["range"]]
    return {column: np.hypot(relative * value, floor)}
