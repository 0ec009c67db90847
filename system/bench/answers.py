"""Numbers that a student of the labs extracts from a die, and how near to the die's own they must be.

Each is measured as its lab does, on the die's own bench, several times over; the mean is the die's. What the
bench can tell is a number each, ours: a step of the DAC or a sample of a record, or three standard deviations
of readings where these are more. A number is NaN on a die whose neuron stays silent.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from chips.coach.bench import CoachBench
from circuits.arrays import F64
from circuits.errors import DataError, unknown_name
from circuits.silicon.die import Die
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.files.document import converted, toml_file

READINGS = 5  # times that a number is measured
SIGMAS = 3.0
_PAIR_SPAN, _WRT_SPAN = 0.1, 0.04  # V
_LEAST_JUMP = 0.1  # V, below which a neuron is silent


@dataclass(frozen=True, slots=True)
class Asked:
    """A number that is asked for.

    unit : its unit; empty for a plain number.
    error : what the bench can tell, in that unit, or as a share of the number where `relative`.
    relative : whether `error` is a share.
    """

    unit: str
    error: float
    relative: bool = False


ASKED: Mapping[str, Asked] = {
    "threshold_V": Asked("V", 3e-3),
    "pair_kappa": Asked("", 0.015),
    "pair_offset_V": Asked("V", 1.5e-3),
    "amplifier_switch_V": Asked("V", 4e-3),
    "slew_V_per_s": Asked("V/s", 0.05, relative=True),
    "follower_tau_s": Asked("s", 0.15, relative=True),
    "synapse_floor_V": Asked("V", 3e-3),
    "synapse_recovery_V_per_s": Asked("V/s", 0.04, relative=True),
    "hillock_jump_V": Asked("V", 15e-3),
    "neuron_interval_s": Asked("s", 0.03, relative=True),
}


@dataclass(frozen=True, slots=True)
class Answer:
    """A die's own number, and by how much one may be off, in its unit."""

    value: float
    error: float


def answers_of(die: int, names: tuple[str, ...] = tuple(ASKED)) -> dict[str, Answer]:
    """Measure a die's numbers.

    Parameters
    ----------
    die
        Number of the die in the lot A.
    names
        Which of `ASKED`.
    """
    benches = [CoachBench(Silicon(ROLLS_180, die=Die(number=die)), seed=k) for k in range(READINGS)]
    found = {}
    for name in names:
        values = np.array([_MEASURED[name](bench) for bench in benches])
        value, asked = float(values.mean()), ASKED[name]
        least = asked.error * abs(value) if asked.relative else asked.error
        found[name] = Answer(value, max(least, SIGMAS * float(values.std(ddof=1))))
    return found


def read_numbers(path: str) -> tuple[int, dict[str, float]]:
    """Read a student's die and numbers from a TOML file.

    Raises `DataError` for a file that cannot be read, without a die, or with a name that nobody asked for.
    """
    content = toml_file(Path(path))
    remedy = "write die = 1003 and numbers as threshold_V = 0.43"
    if "die" not in content:
        raise DataError(f"{path}: die: missing; {remedy}")
    die = converted(content.pop("die"), int, f"{path}: die", remedy)
    for name in content:
        if name not in ASKED:
            raise DataError(f"{path}: {unknown_name('number', name, ASKED)}")
    numbers = {name: converted(value, float, f"{path}: {name}", remedy) for name, value in content.items()}
    if not numbers:
        raise DataError(f"{path}: no numbers, must be at least one; {remedy}")
    return die, numbers


def _threshold(bench: CoachBench) -> float:
    bench.select("NFET")
    bench.set_voltage("GO22", bench.silicon.process.v_dd)
    rows = [(bench.set_voltage("AIN0", v), bench.read_current("GO20")) for v in np.arange(0.3, 0.7, 0.01)]
    gate, current = np.array(rows).T
    seen = current > 20e-9
    return float(np.interp(np.log(100e-9), np.log(current[seen]), gate[seen]))


def _amperes(bench: CoachBench, pin: str) -> float:
    return bench.current_of(pin, bench.read_counts(pin))


def _pair(bench: CoachBench) -> tuple[float, float]:
    """Slope of ln(I_1 / I_2) over the difference, 1/V, and the offset, V."""
    bench.select("NDP")
    bench.set_bias("NDP_VB_N", "N", 30e-9, 20)
    rows = []
    for wanted in np.linspace(-_PAIR_SPAN, _PAIR_SPAN, 41):
        plus = bench.set_voltage("AIN5", 0.9 + wanted / 2.0)
        minus = bench.set_voltage("AIN6", 0.9 - wanted / 2.0)
        rows.append((plus - minus, np.log(_amperes(bench, "C2F0") / _amperes(bench, "C2F1"))))
    difference, logarithm = np.array(rows).T
    slope, at_zero = np.polyfit(difference, logarithm, 1)
    return float(slope), float(-at_zero / slope)


def _switch(bench: CoachBench) -> float:
    bench.select("WRT")
    bench.set_bias("WRT_VB_N", "N", 30e-9, 85)
    bench.set_voltage("AIN8", 0.9)
    levels = np.arange(0.9 - _WRT_SPAN, 0.9 + _WRT_SPAN, 4e-3)
    rows = [(bench.set_voltage("AIN7", v), bench.read_voltage("ADC11")) for v in levels]
    v_in, v_out = np.array(rows).T
    return float(np.interp(0.9, v_out, v_in))


def _follower(bench: CoachBench) -> tuple[float, float]:
    """Slew rate, V/s, and time constant, s."""
    bench.select("FOI")
    bench.set_bias("FOI_VB_N", "N", 460e-12, 37)
    bench.set_voltage("AIN9", 0.9)
    record = bench.record(["ADC10"], 250, 20e-6, steps={"AIN9": 1.2}, fast=True)
    time, out = record.time, record.values["ADC10"]
    share = (out - out[0]) / (out[-1] - out[0])
    middle = (share > 0.1) & (share < 0.5)
    left = out[-20:].mean() - out
    ending = (left < 0.06) & (left > 0.012) & (share > 0.5)
    return _slope(time[middle], out[middle]), -1.0 / _slope(time[ending], np.log(left[ending]))


def _synapse(bench: CoachBench) -> tuple[float, float]:
    """Floor, V, and recovery, V/s."""
    bench.select("DPI")
    bench.set_bias("DPI_VTAU_P", "P", 60e-12, 25)
    bench.set_bias("DPI_VTHR_N", "P", 60e-12, 30)
    bench.set_bias("DPI_VWEIGHT_N", "N", 30e-9, 100)
    bench.set_bias("PEX_VTAU_N", "N", 60e-12, 40)
    record = bench.record(["ADC14"], 150, 1e-3, events=[1e-3])
    time, v = record.time, record.values["ADC14"]
    floor, quarter = v.min(), 0.25 * (v[0] - v.min())
    back = (np.arange(v.size) > v.argmin()) & (v > floor + quarter) & (v < v[0] - quarter)
    return float(floor), _slope(time[back], v[back])


def _jump(bench: CoachBench) -> float:
    bench.select("AHN")
    bench.set_bias("AHN_VPW_N", "N", 60e-12, 8)
    jump = float(np.diff(bench.record(["ADC11"], 600, 4e-3).values["ADC11"]).max())
    return jump if jump > _LEAST_JUMP else float("nan")


def _interval(bench: CoachBench) -> float:
    bench.select("ACN")
    bench.set_bias("ACN_VDC_P", "P", 30e-9, 10)
    bench.set_bias("ACN_VGAIN_N", "N", 60e-12, 6)
    bench.set_bias("ACN_VLEAK_N", "N", 60e-12, 2)
    bench.set_bias("ACN_VREFR_N", "N", 30e-9, 10)
    record = bench.record(["ADC10"], 1200, 50e-6)
    v = record.values["ADC10"]
    falls = record.time[np.flatnonzero((v[1:] < 0.1) & (v[:-1] > 0.1))]
    return float(np.diff(falls).mean()) if falls.size > 1 else float("nan")


def _slope(x: F64, y: F64) -> float:
    return float(np.polyfit(x, y, 1)[0])


def _kappa(bench: CoachBench) -> float:
    return _pair(bench)[0] * bench.silicon.thermal_voltage


_MEASURED: Mapping[str, Callable[[CoachBench], float]] = {
    "threshold_V": _threshold,
    "pair_kappa": _kappa,
    "pair_offset_V": lambda bench: _pair(bench)[1],
    "amplifier_switch_V": _switch,
    "slew_V_per_s": lambda bench: _follower(bench)[0],
    "follower_tau_s": lambda bench: _follower(bench)[1],
    "synapse_floor_V": lambda bench: _synapse(bench)[0],
    "synapse_recovery_V_per_s": lambda bench: _synapse(bench)[1],
    "hillock_jump_V": _jump,
    "neuron_interval_s": _interval,
}
