"""The bump-antibump circuit behind three converters."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from circuits.arrays import F64, Bools
from circuits.blocks.bench.bump_antibump import build
from circuits.blocks.drive import driven
from circuits.blocks.mos import mos
from circuits.extraction.coach.bench import Bench, lowered, swept
from circuits.extraction.coach.conditions import Condition
from circuits.extraction.coach.readings.converter import (
    DOUBLE_DRIFT,
    DRIFT,
    count_noise,
    counts,
    current_of,
    weighted,
)
from circuits.extraction.coach.table import Table
from circuits.extraction.coach.unknown import Unknown
from circuits.testbench import Testbench

_CIRCUIT = build()
_TAIL = mos("mb", "n", "d", "g", "s", 3.0, 1.0)
_DRAINS = 1.3  # V, of all drains: the converters' inputs; ours
_BIAS = "BAB_VB_N"
_CHANNELS = (("n1_counts", "m1", 1.0), ("n2_counts", "m2", 2.0), ("nout_counts", "m4", 1.0))
_CALIBRATED = ((0.6985, 0.1988), (0.1988, 0.6985), (0.4997, 0.4997))  # V of both inputs, of each channel
_SHARE = 0.8  # of the tail, that the calibration of the third channel assumes
_ROWS = ("bab_i1_runA", "bab_i2_runA", "bab_iout")


def unknowns(conditions: Mapping[str, Condition]) -> Iterator[Unknown]:
    """Drift of each channel in each run; that of channel 6 is larger."""
    for each in conditions.values():
        if each.circuit == "bump-antibump":
            for name, _, gain in _CHANNELS:
                sd = DRIFT if gain == 1.0 else DOUBLE_DRIFT
                yield Unknown(f"{each.name} drift {name}", 0.0, sd, "ln", "nuisance", "between executions")


def predict(bench: Bench, condition: Condition, table: Table) -> dict[str, F64]:
    """Counts of the three channels."""
    bias = condition.bias(_BIAS)
    code = float(weighted(bench, _BIAS, np.array([bias.fine]))[0])
    waves = {"v1": 0.0, "v2": 0.0, "i1": _DRAINS, "i2": _DRAINS, "i_out": _DRAINS}
    waves["v_tail"] = bench.gate(bias, _TAIL, code)
    testbench = Testbench("bump-antibump", _CIRCUIT, driven(waves), math.inf)
    machine = lowered(testbench, bench.silicon(_CIRCUIT.name, ("n",)))
    v1 = np.concatenate([[v for v, _ in _CALIBRATED], table["v1_V"]])
    v2 = np.concatenate([[v for _, v in _CALIBRATED], table["v2_V"]])
    flow = swept(machine, {"v1": v1, "v2": v2}).current
    nominal = condition.settings["w"] * code / 256.0 * bias.master_current
    found: dict[str, F64] = {}
    for k, (name, device, gain) in enumerate(_CHANNELS):
        share = _SHARE if device == "m4" else 1.0
        scaled = flow[device][3:] / flow[device][k] * share * nominal
        channel = condition.settings["channels"][k]
        found[name] = gain * counts(bench, channel, scaled, f"{condition.name} drift {name}")
    return found


def converted(found: Mapping[str, F64]) -> dict[str, F64]:
    """The currents in A that the files have for counts."""
    names = ("i1_A", "i2_A", "iout_A")
    return {
        current: current_of(row, found[name])
        for current, row, (name, _, _) in zip(names, _ROWS, _CHANNELS, strict=True)
    }


def usable(condition: Condition, table: Table) -> dict[str, Bools]:
    """All points that are there."""
    del condition
    return {name: np.isfinite(table[name]) for name, _, _ in _CHANNELS}


def noise(condition: Condition, predicted: Mapping[str, F64]) -> dict[str, F64]:
    """Standard deviation of counts."""
    del condition
    return {name: count_noise(value) for name, value in predicted.items()}
