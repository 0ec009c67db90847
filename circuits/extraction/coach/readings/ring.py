"""The winner-take-all's ring: its converters, its input transistors, and which of two cells wins.

An input transistor of cell k is read through the mirror of its own cell and through channel k, whose gain is
known from another mirror of that cell: of the three, the fit tells only what they are together.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

import numpy as np

from circuits.arrays import F64, Bools
from circuits.blocks.bench.winner_take_all_ring import build
from circuits.blocks.drive import Wave, powered
from circuits.blocks.mos import mos
from circuits.devices.transistor import drain_current
from circuits.extraction.coach.bench import ADC, Bench, lowered
from circuits.extraction.coach.conditions import V_DD, Condition
from circuits.extraction.coach.readings.converter import (
    DEAD,
    DEAD_SPREAD,
    count_noise,
    line_unknowns,
    weighted,
)
from circuits.extraction.coach.table import Table
from circuits.extraction.coach.unknown import Unknown
from circuits.measure.current import static_currents
from circuits.solver.operating_point import operating_point
from circuits.solver.sweep.continuation import trace
from circuits.testbench import Testbench

CELLS = 16
_CIRCUIT = build()
_N, _P = (1.0, 1.0), (3.4, 1.0)  # um
_N_AREA, _P_AREA = 1e-12, 3.4e-12  # m^2
_DOUBLE = (6, 14)  # channels that count each event twice
_OUT = 0.6  # V, of v_out while the input transistors are read; ours
_READ_OUT, _READ_ALL = 0.6, 1.2  # V, at which converters take a current; ours
_LEAST = 25.0  # counts, below which the floor shows
_LINE = "WTA 460 pA"
_SATURATED = 12000.0  # counts at which a channel changes its range; only a flag beyond
_NOISE = 2e-3  # V
UT_KAPPA_N, UT_KAPPA_P = 0.0345, 0.0375  # V, U_T / kappa of mirrors, for the spread of their ratios; ours


def _cell(k: int, device: str) -> str:
    return f"winner_take_all_ring.cell[{k}].{device}.v_t0"


def unknowns(conditions: Mapping[str, Condition], a_vt: float) -> Iterator[Unknown]:
    """Charges of the 16 channels, and deviations of what they are read through."""
    del conditions
    for k in range(CELLS):
        yield Unknown(
            f"ring channel {k} Q", math.log(2.6e-13), 0.4, "ln", "nuisance", "with its cell's mirror"
        )
        mirror = a_vt / math.sqrt(_P_AREA) / UT_KAPPA_P
        yield Unknown(f"ring mirror {k}", 0.0, mirror, "ln", "device", "of the output's mirror, in Q")
        yield Unknown(_cell(k, "mi"), 0.0, a_vt / math.sqrt(2.0 * _P_AREA), "V", "device", "area law")
        for device in ("m6", "m7"):
            yield Unknown(_cell(k, device), 0.0, a_vt / math.sqrt(2.0 * _N_AREA), "V", "device", "area law")
    yield Unknown("ring gain", 0.0, 0.5, "ln", "nuisance", "output device of V_gain")
    yield Unknown("ring t_d", DEAD, DEAD_SPREAD, "s", "nuisance", "as of the converters elsewhere")
    yield from line_unknowns(_LINE)


def predict_converters(bench: Bench, condition: Condition, table: Table) -> dict[str, F64]:
    """Counts while one cell carries all tail currents."""
    bits = weighted(bench, _LINE, table["fine_code"])
    total = CELLS * condition.settings["w"] * bits / 256.0 * condition.biases[0].master_current
    total = total * math.exp(bench.theta["s 460 pA"])
    return {f"n{k}_counts": _counts(bench, k, total, 0.0) for k in range(CELLS)}


def _counts(bench: Bench, k: int, current: F64, gain: float) -> F64:
    twice = 2.0 if k in _DOUBLE else 1.0
    charge = math.exp(bench.theta[f"ring channel {k} Q"] + gain)
    return twice * bench.counts(current, charge, bench.theta["ring t_d"])


def predict_inputs(bench: Bench, condition: Condition, table: Table) -> dict[str, F64]:
    """Counts of the input transistors' currents through their cells' mirrors."""
    del condition
    silicon = bench.silicon("none")
    law, u_t = silicon.law("p"), silicon.thermal_voltage
    kappa = silicon.law("n").of_size(1e-6, 1e-6).kappa
    own = {d: np.array([bench.theta[_cell(k, d)] for k in range(CELLS)]) for d in ("mi", "m6", "m7")}
    # a higher threshold is a higher gate; all cells at once, as one vector
    gate = np.ravel((table["v_in_V"] + bench.theta["dac offset"])[None, :] + own["mi"][:, None])
    flow = np.abs(drain_current(law, "p", 3.4e-6, 1e-6, _OUT, gate, V_DD, V_DD)).reshape(CELLS, -1)
    mirror = np.exp(kappa * (own["m6"] - own["m7"]) / u_t)
    return {
        f"n{k}_counts": _counts(bench, k, flow[k] * mirror[k], bench.theta[f"ring mirror {k}"])
        for k in range(CELLS)
    }


def usable_counts(condition: Condition, table: Table) -> dict[str, Bools]:
    """Counts above the floor."""
    least = _LEAST if condition.circuit == "ring-inputs" else 5.0
    names = [f"n{k}_counts" for k in range(CELLS)]
    key = "fine_code" if "fine_code" in table else "v_in_V"
    kept = {n: np.asarray(table[n] > least * (2.0 if int(n[1:-7]) in _DOUBLE else 1.0)) for n in names}
    return {n: np.asarray(k & (table[key] > 0.0)) for n, k in kept.items()}


def noise(condition: Condition, predicted: Mapping[str, F64]) -> dict[str, F64]:
    """Standard deviation of readings."""
    del condition
    return {
        n: count_noise(v) if n.endswith("_counts") else np.full(v.size, math.hypot(_NOISE, ADC))
        for n, v in predicted.items()
    }


def predict(bench: Bench, condition: Condition, table: Table) -> dict[str, F64]:
    """Outputs of cells 0 and 1 while the input of cell 0 falls and rises, and their counts."""
    shift = bench.theta["dac offset"]
    n, p = mos("mb", "n", "d", "g", "s", *_N), mos("m5", "p", "d", "g", "s", *_P)
    lines = {"WTA_VB_N": n, "WTA_VEX_N": n, "WTA_VGAIN_P": p, "WTA_VINH_P": p}
    gates = {name: bench.gate(condition.bias(name), device) for name, device in lines.items()}
    line = condition.bias("WTA_VGAIN_P")
    gates[line.name] = bench.gate(line, p, (line.fine or 0) * math.exp(bench.theta["ring gain"]))
    others = condition.voltages["v_in_others"] + shift
    waves: dict[str, Wave] = dict.fromkeys(_CIRCUIT.port("v_in").elements(), others)
    waves |= dict.fromkeys(_CIRCUIT.port("i_out").elements(), _READ_OUT)
    waves |= dict.fromkeys(_CIRCUIT.port("i_all").elements(), _READ_ALL)
    waves |= {
        "v_in[0]": float(table["v_in0_V"][0]) + shift, "v_in[1]": condition.voltages["v_in1"] + shift,
        "v_tail": gates["WTA_VB_N"], "v_gain": gates["WTA_VGAIN_P"], "v_ex": gates["WTA_VEX_N"],
        "v_inh": gates["WTA_VINH_P"], "enable": 0.0,
    }  # fmt: skip
    testbench = Testbench("winner-take-all ring", _CIRCUIT, powered(V_DD, waves), math.inf)
    machine = lowered(testbench, bench.silicon(_CIRCUIT.name))
    first = operating_point(machine).voltage
    position = machine.source_names.index("v_in[0]")
    v = trace(machine, position, table["v_in0_V"] + shift, first)
    node = dict(zip(machine.names, v[:, machine.column].T, strict=True))
    current = static_currents(machine, v)
    found = {f"v_out{k}_V": bench.adc(node[f"v_out[{k}]"]) for k in (0, 1)}
    for k in (0, 1):
        for name, device in (("iout", "m4"), ("iall", "m7")):
            column = f"n_{name}{k}_counts"
            if name == "iall" and "n_iall0_counts" not in table:
                continue
            gain = 0.0 if name == "iout" else bench.theta[f"ring mirror {k}"]
            flow = np.abs(current[f"cell[{k}].{device}"])
            found[column] = np.minimum(_counts(bench, k, flow, gain), _SATURATED)
    return found


def usable(condition: Condition, table: Table) -> dict[str, Bools]:
    """All readings of voltages that are there."""
    del condition
    return {name: np.isfinite(table[name]) for name in ("v_out0_V", "v_out1_V")}


def matching(values: Mapping[str, float]) -> tuple[F64, float]:
    """What the 16 inputs deviate by in all, as logarithms, and the variance of that over A_VT^2, 1/(V m)^2.

    values: unknowns by name. Transistor, mirror and readout of a cell together are what its counts fix.
    """
    total = np.array([
        -values[_cell(k, "mi")] / UT_KAPPA_P
        + (values[_cell(k, "m6")] - values[_cell(k, "m7")]) / UT_KAPPA_N
        - values[f"ring mirror {k}"]
        for k in range(CELLS)
    ])  # fmt: skip
    pair = 0.5 / _P_AREA / UT_KAPPA_P**2 + 1.0 / _N_AREA / UT_KAPPA_N**2 + 1.0 / _P_AREA / UT_KAPPA_P**2
    return total, pair
