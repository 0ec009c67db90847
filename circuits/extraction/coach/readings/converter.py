"""The current-to-frequency converters: charge, dead time, and the bit weights of the codes they were read at.

    n = m t / (Q / I + t_d) + n_dark,    I = w I_master sum(b_k w_k 2^k) / 256

Q is in the scale of the nominal current of the laboratory's text (its w), as are the currents of the files;
what a code's current is in truth is a factor of the master (`bench`). A channel drifts from one execution to
another.
"""

from __future__ import annotations

import csv
import functools
import math
from collections.abc import Iterator, Mapping

import numpy as np

from circuits.arrays import F64, Bools
from circuits.extraction.coach.bench import DARK, SECONDS, Bench
from circuits.extraction.coach.conditions import DATA, Condition
from circuits.extraction.coach.table import Table
from circuits.extraction.coach.unknown import Unknown

BITS = 7  # of the fine codes that are used: none reaches 128
_BIT = 0.06  # relative spread of what a bit of the splitter is worth on all lines; ours
_LINE = 0.03  # and of a line's own splitter, by mismatch; ours
_CHARGE, _CHARGE_SPREAD = 1.3e-13, 0.5  # C, and of its logarithm; ours
DEAD, DEAD_SPREAD = 2e-6, 0.7e-6  # s; ours
DRIFT = 0.015  # relative, of a channel between two executions; 4.4 % was seen once, 0.2 % otherwise
DOUBLE_DRIFT = 2.5 * DRIFT  # of one that counts events twice: 5 % from run to run
_NOISE = 0.005  # relative, of a count beside its own; scaled by the fit


def calibrations(conditions: Mapping[str, Condition]) -> list[Condition]:
    """Conditions of calibrations of a channel."""
    return [each for each in conditions.values() if each.circuit == "converter"]


def unknowns(conditions: Mapping[str, Condition]) -> Iterator[Unknown]:
    """Charge and dead time of each channel, drift of each execution, bit weights of each bias line."""
    found = calibrations(conditions)
    for channel in sorted({c.settings["channel"] for c in found}):
        yield Unknown(f"channel {channel} Q", math.log(_CHARGE), _CHARGE_SPREAD, "ln", "nuisance")
        yield Unknown(f"channel {channel} t_d", DEAD, DEAD_SPREAD, "s", "nuisance")
    for each in found:
        sd = DOUBLE_DRIFT if each.settings["counts_per_event"] > 1.0 else DRIFT
        yield Unknown(f"{each.name} drift", 0.0, sd, "ln", "nuisance", "between executions")
    for k in range(BITS):
        yield Unknown(f"splitter bit {k}", 1.0, _BIT * (2.0 if k < 2 else 1.0), "", "nuisance")
    for bias in sorted({c.settings["bias"] for c in found}):
        yield from line_unknowns(bias)


def line_unknowns(line: str) -> Iterator[Unknown]:
    """What the bits of a line's own splitter are worth, over those of all lines."""
    for k in range(BITS):
        yield Unknown(f"{line} bit {k}", 1.0, _LINE, "", "nuisance", "mismatch")


def bit_weights(theta: Mapping[str, float], line: str) -> F64:
    """What the bits of a line's fine code are worth of their nominal weights, float64[bits]."""
    return np.array([theta[f"splitter bit {k}"] * theta[f"{line} bit {k}"] for k in range(BITS)])


def weighted(bench: Bench, bias: str, codes: F64) -> F64:
    """Fine codes by the weights of a line's bits, float64 of their shape."""
    whole = np.asarray(codes, dtype=np.int64)
    if f"{bias} bit 0" not in bench.theta:
        return np.asarray(codes, dtype=np.float64)
    weights = 2.0 ** np.arange(BITS) * bit_weights(bench.theta, bias)
    low = (whole[..., None] >> np.arange(BITS) & 1) @ weights
    return np.asarray(low + (whole >> BITS) * 2.0**BITS)


def counts(bench: Bench, channel: int, nominal: F64, drift: str = "", seconds: float = SECONDS) -> F64:
    """Events that a channel counts for a current in its calibration's scale, A."""
    charge = math.exp(bench.theta[f"channel {channel} Q"] + (bench.theta[drift] if drift else 0.0))
    return bench.counts(nominal, charge, bench.theta[f"channel {channel} t_d"], seconds)


def predict(bench: Bench, condition: Condition, table: Table) -> dict[str, F64]:
    """Counts of a calibration."""
    s = condition.settings
    nominal = s["w"] * weighted(bench, s["bias"], table["fine_code"]) / 256.0 * s["master"]
    found = counts(bench, s["channel"], nominal, f"{condition.name} drift")
    return {"n_counts": s["counts_per_event"] * found}


def usable(condition: Condition, table: Table) -> dict[str, Bools]:
    """Points up to the code that the condition names; code 0 is the dark count."""
    code = table["fine_code"]
    return {"n_counts": np.asarray((code > 0) & (code <= condition.settings["most_code"]))}


def noise(condition: Condition, predicted: Mapping[str, F64]) -> dict[str, F64]:
    """Standard deviation of counts: of a whole number, and relative."""
    return {name: count_noise(value) for name, value in predicted.items()}


def count_noise(value: F64) -> F64:
    """Standard deviation of counts, before it is scaled by what residuals say."""
    return np.hypot(_NOISE * value, 1.0)


@functools.lru_cache(maxsize=1)
def _channels() -> dict[str, tuple[float, float, float]]:
    with (DATA / "c2f_channels.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    return {r["calibration"]: (float(r["Q_C"]), float(r["t_dead_s"]), float(r["count_gain"])) for r in rows}


def current_of(calibration: str, count: F64) -> F64:
    """The current in A that the files have for counts: `Q / (t / n - t_d)` with a calibration's numbers.

    Parameters
    ----------
    calibration
        Name of a row of `c2f_channels.csv`.
    count
        Counts in 0.1 s.
    """
    charge, dead, gain = _channels()[calibration]
    with np.errstate(divide="ignore"):
        left = SECONDS * gain / np.maximum(count, 1e-9) - dead
    return np.where(count > 0.0, charge / np.maximum(left, 1e-9), 0.0)


__all__ = ["DARK", "calibrations", "count_noise", "counts", "current_of", "weighted"]
