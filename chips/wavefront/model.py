"""Behavioural delays of a wavefront chip's axons on a die, at any code, temperature, bias and unit.

The delay of an axon is a charge over the current of its sink on this die (`chips.wavefront.axon_record`):

    D = [Q(code; T, I, I_cmp) + Q_u (sum_d (offset_d + gain_d code) x_d + sum_k a_k(code) c_k)] / I
    I = I_S (1 + beta) F(kappa (v_delay - V_T0 - dV_T) / U_T),   F(u) = ln^2(1 + e^(u/2))

I is the law's, exponential in the sink's own threshold. Under the full law it has body effect and the fall of
the mobility, and Q, which is measured under that law, what the drain does. x_d are the thresholds of the
comparator's pair and mirror `mc1` to `mc4`, and what a die's devices share. ln Q follows I to second order
about the die's current, and the tail's current, through the threshold of `mc0`, to first order. c_k are the
relative changes of the ramp's capacitors on a die whose capacitors deviate, a_k the charge on each of them.
All deviations are those that the transistor level draws for `axon[r,c]` of the chip. Left out: mismatch of
the axon's other devices and of the cells, whose input delay of nanoseconds is that of the temperature and the
shared shift. Of the variance of a unit on 300 dies with mismatch (`noctule montecarlo axon-delay --metric
unit_delay --contributions unit_delay`) `ms` has 99.6 %, `mc1` to `mc4` 0.1 % each, and every other device
less than 0.05 %.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from chips.measured.interpolation import lagrange_weights
from chips.measured.table_record import tables_of, temperature_weights
from chips.record import Record
from chips.record_file import stale
from chips.validity import require_inside
from chips.wavefront.axon_conditions import (
    CAPACITORS,
    LOCAL,
    SINK,
    TAIL,
    AxonModel,
    AxonTables,
    Conditions,
    Shifts,
    axon_tables,
    carried_at,
    check_local,
    conditions,
    process_shifts,
)
from chips.wavefront.axon_graph import AxonGraph
from chips.wavefront.axon_record import (
    COMPARATOR_CURRENT,
    CURRENT,
    TEMPERATURE,
    axon_key,
    axon_record,
    grid_of,
)
from circuits.arrays import F64, I64
from circuits.bias import rebias
from circuits.blocks.wavefront import axon_delay
from circuits.blocks.wavefront import cell as wavefront_cell
from circuits.blocks.wavefront import grid as wavefront_grid
from circuits.blocks.wavefront.axon_delay import HIGHEST, UNIT
from circuits.catalogue import later
from circuits.circuit import BiasKind, Circuit
from circuits.compiled import compiled
from circuits.errors import ParameterError
from circuits.lowering.capacitors_on_die import capacitor_changes, capacitors_deviate
from circuits.lowering.on_die import on_die
from circuits.silicon.die import Die, Path
from circuits.silicon.process import AMI_1500_IDEAL, POLARITIES, Process
from circuits.silicon.silicon import Silicon

interpolate = later("scipy.interpolate")  # slow to import


class AxonDraws(NamedTuple):
    """Local deviations of n axons, float64[n]; thresholds in V; local: of `LOCAL`, V, [n, 4].

    capacitor: relative changes of `CAPACITORS`, [n, 6], [n, 0] on a die whose capacitors do not deviate.
    """

    sink: F64
    beta: F64  # of the sink, relative
    tail: F64
    local: F64
    capacitor: F64


def axon_model(
    circuit: Circuit, process: Process = AMI_1500_IDEAL, record: Record | None = None
) -> AxonModel:
    """Return the model of a lone axonal delay element with the biases of `circuit`.

    record: the one in force unless given. Raises `DataError` where the record is of another circuit or
    process, and `ParameterError` where the process's law is not the model's.
    """
    return _model(circuit, circuit, process, record, (), (), 1.0)


def chip_model(
    shape: tuple[int, ...],
    process: Process = AMI_1500_IDEAL,
    *,
    bias_kind: BiasKind = "gate",
    unit: float = UNIT,
    area: float = 1.0,
    record: Record | None = None,
    current: float | None = None,
) -> AxonModel:
    """Return the model of all axons of a chip of `shape`, (rows, columns) of a grid or (cells,).

    bias_kind: of the axons' currents; unit: nominal delay a unit of code at 27 degC, s, of the bias currents
    under the ideal law: the same currents make one that is 2 % shorter under the full law; area: of the drawn
    devices over the circuit's; current: of the axons' sinks, A, in the place of that of the unit. Raises as
    `axon_model`, and `ParameterError` for a unit or an area that is not above 0 and finite.
    """
    for name, value, symbol in (("unit", unit, "s"), ("area", area, "times the circuit's")):
        if not (np.isfinite(value) and value > 0.0):
            raise ParameterError(f"wavefront_chip.{name}: {value:g} {symbol}, must be > 0")
    record = record or axon_record(process)
    chip = wavefront_grid.build(wavefront_grid.Params(1, 1))
    if current is None:
        usual = float(np.asarray(chip.bias("i_delay").value))
        current = usual * _unit_current(record, unit) / _unit_current(record, UNIT)
    chip = rebias(chip, {"i_delay": current}, bias_kind)
    return _model(chip, axon_delay.build(), process, record, ("axon",), shape, area)


def _model(
    circuit: Circuit, axon: Circuit, process: Process, record: Record | None, prefix: tuple[str, ...],
    shape: tuple[int, ...], area: float,
) -> AxonModel:  # fmt: skip
    record = record or axon_record(process)
    if axon_key(axon, process, grid_of(record)) != record.key:
        raise stale("axon_delay", process=process)
    return AxonModel(circuit, process, record, prefix, shape, area, axon)


def axon_draws(model: AxonModel, silicon: Silicon) -> AxonDraws:
    """Return the deviations of the model's axons on the silicon's die, as the transistor level draws them."""
    place: Path = ((model.circuit.name, ()), *((name, model.shape) for name in model.prefix))
    d = on_die(model.axon, silicon.of_area(model.area), (SINK, *LOCAL, TAIL), place).flat()
    local = np.stack([d.fet[name].v_t0 for name in LOCAL], axis=-1)
    changes = np.zeros((d.copies, 0))
    if capacitors_deviate(model.axon, silicon, place):
        found = capacitor_changes(model.axon, silicon, CAPACITORS, place)
        changes = np.stack([found[name].ravel() for name in CAPACITORS], axis=-1)
    sink = d.fet[SINK]
    return AxonDraws(sink.v_t0.copy(), sink.beta.copy(), d.fet[TAIL].v_t0.copy(), local, changes)


def axon_delays(
    model: AxonModel, silicon: Silicon, codes: NDArray[np.integer], draws: AxonDraws | None = None
) -> F64:
    """Return the delays of all axons, s, in the shape of `codes`, inf at code 0, where a cell is blocked.

    codes: integers of the model's shape, or flat; draws: of the silicon's die, drawn unless given, which
    serve at every temperature. Raises `ParameterError` outside the record (temperature, current, shifts), and
    for a code that is none.
    """
    flat = _checked_codes(model, codes)
    tables = axon_tables(model, silicon)
    found = np.empty(flat.size)
    _fill(tables, silicon, process_shifts(silicon), flat, draws, found)
    return found.reshape(np.shape(codes))


def edge_delays(
    graph: AxonGraph,
    codes: NDArray[np.integer],
    silicon: Silicon,
    *,
    bias_kind: BiasKind = "gate",
    unit: float = UNIT,
    area: float = 1.0,
    current: float | None = None,
) -> F64:
    """Return the delay of every edge of a chip, s, float64[edges]: its sender's axon and receiver's input.

    codes: of the sending cells, int64[n]; an edge from a blocked cell (0) has an infinite delay. The other
    arguments are those of `chip_model`. Raises `ParameterError` outside the record.
    """
    shape = graph_shape(graph)
    model = chip_model(shape, silicon.process, bias_kind=bias_kind, unit=unit, area=area, current=current)
    return np.asarray(dies_delays(model, silicon, codes, (silicon.die,))[0][graph.sources()])


def dies_delays(model: AxonModel, silicon: Silicon, codes: NDArray[np.integer], dies: Sequence[Die]) -> F64:
    """Return the delay of every cell's axon, with the input that it reaches, on several dies.

    The array is float64[dies, n], s; edges of an `AxonGraph` have `[:, graph.sources()]`. silicon: process
    and temperature. Raises as `axon_delays`.
    """
    flat = _checked_codes(model, codes)
    tables = axon_tables(model, silicon)
    input_table = _input_table(silicon.process, silicon.temperature_c)
    found = np.empty((len(dies), flat.size))
    for k, die in enumerate(dies):
        here = replace(silicon, die=die)
        shifts = process_shifts(here)
        _fill(tables, here, shifts, flat, None, found[k])
        found[k] += _at_shifts(input_table, shifts)
    return found


def graph_shape(graph: AxonGraph) -> tuple[int, ...]:
    """Return the shape of the arrays of cells and axons on the chip of a graph."""
    return (graph.cells,) if graph.shape is None else graph.shape


def input_delay(silicon: Silicon) -> float:
    """Return the time from an axon's step to the firing of the cell that it reaches, s."""
    return _at_shifts(_input_table(silicon.process, silicon.temperature_c), process_shifts(silicon))


def cell_circuits() -> tuple[Circuit, ...]:
    """Return what the wavefront cell's record is measured from."""
    return (wavefront_cell.build(),)


def cell_record(process: Process) -> Record:
    """Return the wavefront cell's record; raises `DataError` unless it is of this circuit and process."""
    like = AMI_1500_IDEAL
    plain = replace(process, pair_a_vt=like.pair_a_vt, pair_a_beta=like.pair_a_beta, variation=like.variation)
    return tables_of("wavefront_cell", cell_circuits, plain)


@lru_cache(maxsize=64)
def _input_table(process: Process, temperature_c: float) -> tuple[F64, F64]:
    """Shared shifts, float64[k], V, and input delay over them by polarity, float64[2, k], s."""
    data = cell_record(process)
    values = np.tensordot(temperature_weights(data, temperature_c), data["input_delay_s"], (0, 0))
    return data["shift"], values


def _at_shifts(table: tuple[F64, F64], shifts: Shifts) -> float:
    grid, values = table
    parts = [float(np.interp(shifts[p].v_t0, grid, values[k])) for k, p in enumerate(POLARITIES)]
    return parts[0] + parts[1] - float(np.interp(0.0, grid, values[0]))


def _unit_current(record: Record, unit: float) -> float:
    """Sink's current, A, at which the unit is `unit` (s) at 27 degC and the comparator's usual current."""
    comparator = float(np.asarray(axon_delay.build().bias("i_cmp").value))
    charge = np.tensordot(lagrange_weights(record.numbers(TEMPERATURE), 27.0), record["log_charge"], (0, 0))
    charge = interpolate.CubicSpline(np.log(record[COMPARATOR_CURRENT]), charge, axis=1)(np.log(comparator))
    units = (np.exp(charge[:, -1]) - np.exp(charge[:, 0])) / (HIGHEST - 1) / record[CURRENT]
    require_inside("wavefront_chip.unit", unit, (float(units[-1]), float(units[0])), "s")
    spline = interpolate.CubicSpline(np.log(units[::-1]), np.log(record[CURRENT][::-1]))
    return float(np.exp(spline(np.log(unit))))


def _checked_codes(model: AxonModel, codes: NDArray[np.integer]) -> I64:
    flat = np.ascontiguousarray(codes).ravel()
    count = int(np.prod(model.shape, dtype=np.int64))
    low, high = flat.min(initial=0), flat.max(initial=0)
    if flat.dtype.kind not in "iu" or flat.size != count or low < 0 or high > HIGHEST:
        raise ParameterError(
            f"{model.circuit.name}.codes: {flat.size} from {low} to {high}, must be {count} whole numbers"
            f" from 0 to {HIGHEST}"
        )
    return flat.astype(np.int64)


def _fill(
    tables: AxonTables, silicon: Silicon, shifts: Shifts, codes: I64, draws: AxonDraws | None, found: F64
) -> None:
    """Delays of a die's axons, s, into `found`."""
    draws = axon_draws(tables.model, silicon) if draws is None else draws
    check_local(tables.model, draws.local)
    _delays(conditions(tables, silicon, shifts), draws, codes, found)


@compiled()
def _delays(c: Conditions, draws: AxonDraws, codes: I64, found: F64) -> None:
    """Delays of all axons, s, into `found`; codes: int64[n], 0 to 31."""
    for i in range(codes.size):
        code = codes[i]
        if code == 0:
            found[i] = np.inf
            continue
        carried = carried_at(c, c.whole, draws.sink[i])
        current = c.specific_current * (1.0 + draws.beta[i]) * carried
        apart = np.log(current) - c.log_current
        k = code - 1
        log_charge = c.log_charge[0, k] + c.tail[k] * draws.tail[i]
        log_charge += apart * (c.log_charge[1, k] + 0.5 * apart * c.log_charge[2, k])
        change = 0.0
        for p in range(draws.local.shape[1]):
            change += (c.offset[p] + c.gain[p] * code) * draws.local[i, p]
        for p in range(draws.capacitor.shape[1]):
            change += c.capacitor[p, (code >> p) & 1] * draws.capacitor[i, p]
        found[i] = (np.exp(log_charge) + c.unit_charge * change) / current
