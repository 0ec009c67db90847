"""Data sheet of behavioural rebound neurons on a die: their numbers, validity and measured error.

For whoever writes the neurons down elsewhere. The numbers are those of `chips.ranging.model` on this die at
this temperature; the capacitances are the branches of the matrix that the model inverts:

    C[i, j] = -c_ij (i != j),  C[i, i] = c_i + sum_j c_ij,  i, j of v_mem, v_r, v_ex
"""

from __future__ import annotations

import numpy as np

from chips.model import Sheet
from chips.model_law import check_law
from chips.ranging.chip import ABOVE_SUPPLY, RangingChip
from chips.ranging.law import Neurons
from chips.ranging.record import ReboundRecord
from circuits.arrays import F64
from circuits.circuit import Circuit
from circuits.event import EDGE, WIDTH
from circuits.silicon.silicon import Silicon

_NODES = ("mem", "r", "ex")
_CALL_WIDTH = WIDTH + 1.5 * EDGE  # s, from the event to the fall through half the supply
_NO_NUMBERS = ("inverse_capacitance", "follow", "margin", "rebound_bound", "v_ex_max", "effects")


def rebound_sheet(circuit: Circuit, silicon: Silicon) -> Sheet:
    """Return the data sheet of a rebound neuron, or of an array of them, on a silicon.

    Raises `ParameterError` outside the record's validity box (`chips.validity`) and under a law with
    second-order effects, and `DataError` where the
    record is of another circuit or process.
    """
    check_law(silicon.process)  # its equations are those of the ideal law
    chip = RangingChip(silicon, circuit, circuit.name)
    neurons = chip.neurons_at(silicon.temperature_c)
    figures = tuple(_figures(neurons, k) for k in range(neurons.t_inh.size))
    return Sheet(circuit.port("spike").shape, figures, _remarks(chip.model.record, silicon))


def _figures(neurons: Neurons, k: int) -> dict[str, float]:
    names = [name for name in Neurons._fields if name not in _NO_NUMBERS]
    branches = _branches(np.linalg.inv(neurons.inverse_capacitance[k, 0]))
    return {name: float(getattr(neurons, name)[k]) for name in names} | branches | {"call_width": _CALL_WIDTH}


def _branches(matrix: F64) -> dict[str, float]:
    """Capacitances of branches, F; what inverting has left of a 0 is a 0."""
    floor = 1e-9 * matrix.max()
    found = {f"c_{name}": float(matrix[i].sum()) for i, name in enumerate(_NODES)}
    for i, j in ((0, 1), (0, 2), (1, 2)):
        found[f"c_{_NODES[i]}_{_NODES[j]}"] = max(0.0, float(-matrix[i, j])) if -matrix[i, j] > floor else 0.0
    return found


def _remarks(record: ReboundRecord, silicon: Silicon) -> tuple[str, ...]:
    grid, box, v_dd = record.grid, record.box, silicon.process.v_dd
    held = (
        f"valid at {grid.temperature[0]:g} to {grid.temperature[-1]:g} degC",
        f"I_inh_tau {grid.current[0]:.3g} to {grid.current[-1]:.3g} A",
        f"v_ex_max {v_dd - box.v_ex_max:g} to {v_dd + ABOVE_SUPPLY:g} V",
    )
    shifts = (
        f"threshold shifts within {box.threshold:g} V",
        f"ln beta shifts within {box.log_beta:g}",
        f"v_th within {box.v_th:g} V of the record's",
    )
    return (
        f"numbers of one die at {silicon.temperature_c!r} degC: they do not follow a simulator's temperature",
        ", ".join(held),
        ", ".join(shifts),
        "measured against the transistors, on dies that were not used to build it:",
        *(f"  {name}: {value:.3g}" for name, value in record.errors.items()),
        f"undecided is a spike that moving the threshold by {record.margin:.3g} V would undo or bring about",
    )
