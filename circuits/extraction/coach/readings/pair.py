"""The differential pair behind two converters."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from circuits.arrays import F64, Bools
from circuits.blocks.bench.differential_pair import build
from circuits.blocks.drive import driven
from circuits.blocks.mos import mos
from circuits.extraction.coach.bench import Bench, solved
from circuits.extraction.coach.conditions import Condition
from circuits.extraction.coach.readings.converter import DRIFT, count_noise, counts, current_of, weighted
from circuits.extraction.coach.table import Table
from circuits.extraction.coach.unknown import Unknown

_CIRCUIT = build()
_TAIL = mos("mb", "n", "d", "g", "s", 1.0, 1.0)
_AREA = 1e-12  # m^2
_BIAS, _DRAINS = "NDP_VB_N", 1.3  # V, of both drains: the converters' inputs; ours
_CALIBRATED = (("v1", 0.5982), ("v2", 0.1988))  # V, of channel 0; those of channel 1 are turned round
TRUSTED = 0.15  # V of difference beyond which the channels look locked


def unknowns(conditions: Mapping[str, Condition], a_vt: float) -> Iterator[Unknown]:
    """Deviations of the pair under the area law, and the drift of each run."""
    for device in ("m1", "m2"):
        sd = a_vt / math.sqrt(2.0 * _AREA)
        yield Unknown(f"differential_pair.{device}.v_t0", 0.0, sd, "V", "device", "area law")
    for each in conditions.values():
        if each.circuit == "differential-pair":
            for k in (1, 2):
                yield Unknown(f"{each.name} drift {k}", 0.0, DRIFT, "ln", "nuisance", "between executions")


def predict(bench: Bench, condition: Condition, table: Table) -> dict[str, F64]:
    """Counts of both channels, and the currents that the files make of them."""
    bias = condition.bias(_BIAS)
    code = float(weighted(bench, _BIAS, np.array([bias.fine]))[0])
    gate = bench.gate(bias, _TAIL, code)
    waves = {"v1": 0.0, "v2": 0.0, "i1": _DRAINS, "i2": _DRAINS, "v_tail": gate}
    cal = dict(_CALIBRATED)
    v1 = np.concatenate([[cal["v1"], cal["v2"]], table["v1_V"]])
    v2 = np.concatenate([[cal["v2"], cal["v1"]], table["v2_V"]])
    over = {"v1": v1, "v2": v2}
    current = solved(_CIRCUIT, driven(waves), bench.silicon(_CIRCUIT.name, ("n",)), over).current
    nominal = condition.settings["w"] * code / 256.0 * bias.master_current
    found: dict[str, F64] = {}
    for k in (1, 2):
        flow = current[f"m{k}"]
        # a channel's charge is in the scale of the nominal current at the voltages of its calibration
        scaled = flow[2:] / flow[k - 1] * nominal
        found[f"n{k}_counts"] = counts(bench, k - 1, scaled, f"{condition.name} drift {k}")
    return found


def converted(found: Mapping[str, F64]) -> dict[str, F64]:
    """The currents in A that the files have for counts."""
    return {f"i{k}_A": current_of(f"ndp_i{k}_runA", found[f"n{k}_counts"]) for k in (1, 2)}


def usable(condition: Condition, table: Table) -> dict[str, Bools]:
    """Points within the difference up to which the channels are trusted."""
    near = np.abs(table["v1_V"] - table["v2_V"]) < condition.settings["score_V"]
    return {f"n{k}_counts": np.asarray(near) for k in (1, 2)}


def noise(condition: Condition, predicted: Mapping[str, F64]) -> dict[str, F64]:
    """Standard deviation of counts."""
    return {name: count_noise(value) for name, value in predicted.items()}
