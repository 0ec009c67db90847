"""The transconductance amplifiers: open outputs behind the buffer, and the copies behind the converters."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from circuits.arrays import F64, Bools
from circuits.blocks.bench import transamp, wide_range_transamp
from circuits.blocks.drive import powered
from circuits.blocks.mos import mos
from circuits.circuit import Circuit
from circuits.devices import Transistor
from circuits.extraction.coach.bench import ADC, Bench, lowered, swept
from circuits.extraction.coach.conditions import V_DD, Condition
from circuits.extraction.coach.readings.converter import DRIFT, count_noise, counts, current_of, weighted
from circuits.extraction.coach.table import Table
from circuits.extraction.coach.unknown import Unknown
from circuits.testbench import Testbench

_N_TAIL = mos("mb", "n", "d", "g", "s", 1.0, 1.0)
_P_TAIL = mos("mb", "p", "d", "g", "s", 3.4, 1.0)
_OPEN: Mapping[str, tuple[Circuit, Transistor]] = {
    "transamp-n": (transamp.stage("n", transamp.Params()), _N_TAIL),
    "transamp-p": (transamp.stage("p", transamp.Params()), _P_TAIL),
    "wide-range-transamp": (wide_range_transamp.build(), _N_TAIL),
}
_READ = 0.6  # V, at which a converter takes a current; ours
_CALIBRATED = (0.7988, 0.1988)  # V of the inputs, of channel 11; those of channel 12 are turned round
_NOISE = 1e-3  # V, of a reading


def unknowns(conditions: Mapping[str, Condition]) -> Iterator[Unknown]:
    """Drift of the copies' channels in each run, and the size of what loads them."""
    yield Unknown("copies load", 0.0, 0.5, "ln", "nuisance", "width of loads and mirrors, not told")
    for each in conditions.values():
        if each.circuit == "transamp-n-copies":
            for name in ("plus", "minus"):
                yield Unknown(f"{each.name} drift {name}", 0.0, DRIFT, "ln", "nuisance", "between executions")


def _gate(bench: Bench, condition: Condition, tail: Transistor) -> float:
    bias = condition.biases[0]
    return bench.gate(bias, tail, float(weighted(bench, bias.name, np.array([bias.fine]))[0]))


def predict_open(bench: Bench, condition: Condition, table: Table) -> dict[str, F64]:
    """Output voltage over v1 as it is read."""
    circuit, tail = _OPEN[condition.circuit]
    shift = bench.theta["dac offset"]
    waves = {
        "v_plus": 0.0,
        "v_minus": condition.voltages["v2"] + shift,
        "v_tail": _gate(bench, condition, tail),
    }
    testbench = Testbench(condition.circuit, circuit, powered(V_DD, waves), math.inf)
    machine = lowered(testbench, bench.silicon(circuit.name))
    # at ground and above the supply the DAC's own offset cannot leave its range
    plus = np.maximum(table["v1_V"] + shift, 0.0)
    return {"v_out_V": bench.adc(swept(machine, {"v_plus": plus}).voltage["v_out"])}


def predict_copies(bench: Bench, condition: Condition, table: Table) -> dict[str, F64]:
    """Counts of what the second copy's output gives and what the third one's takes."""
    bias = condition.biases[0]
    code = float(weighted(bench, bias.name, np.array([bias.fine]))[0])
    waves = {
        "v_plus": 0.0, "v_minus": 0.0, "v_tail": _gate(bench, condition, _N_TAIL), "i_plus": _READ,
        "i_minus": _READ,
    }  # fmt: skip
    wide = math.exp(bench.theta["copies load"])
    circuit = transamp.with_nfets(transamp.Params(readout_n_width=wide, readout_p_width=3.4 * wide))
    testbench = Testbench(condition.circuit, circuit, powered(V_DD, waves), math.inf)
    machine = lowered(testbench, bench.silicon(circuit.name))
    high, low = _CALIBRATED
    plus = np.concatenate([[high, low], table["v1_V"]])
    minus = np.concatenate([[low, high], table["v2_V"]])
    found = swept(machine, {"v_plus": plus, "v_minus": minus}).current
    nominal = condition.settings["w"] * code / 256.0 * bias.master_current
    read: dict[str, F64] = {}
    for k, (name, mirror) in enumerate((("plus", "mp2"), ("minus", "mm4"))):
        flow = np.abs(found[mirror])
        channel = condition.settings["channels"][k]
        drift = f"{condition.name} drift {name}"
        read[f"n_{name}_counts"] = counts(bench, channel, flow[2:] / flow[k] * nominal, drift)
    return read


def converted(found: Mapping[str, F64]) -> dict[str, F64]:
    """The currents in A that the files have for counts."""
    return {f"i_{name}_A": current_of(f"nta_{name}", found[f"n_{name}_counts"]) for name in ("plus", "minus")}


def usable(condition: Condition, table: Table) -> dict[str, Bools]:
    """All points that are there."""
    del condition
    return {n: np.isfinite(c) for n, c in table.items() if n == "v_out_V" or n.endswith("_counts")}


def noise(condition: Condition, predicted: Mapping[str, F64]) -> dict[str, F64]:
    """Standard deviation of readings."""
    del condition
    return {
        n: np.full(v.size, math.hypot(_NOISE, ADC)) if n == "v_out_V" else count_noise(v)
        for n, v in predicted.items()
    }
