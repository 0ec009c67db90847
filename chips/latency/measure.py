"""Measurement of the latency chip's record: the charges behind its times, and a comparator's slopes.

Every time on the chip is a charge over the current of one device, `T = Q / I`. Measured from the blocks'
circuits, over temperature and the threshold shift that a die's transistors of a polarity share, with ideal
biases, and I where its drain stands in the middle of the swing (`chips.latency.swing`):

    timer, tap, tonic, integrating, race, second, recurrent    Q of each, C, threshold and parasitics in it
    pulse_width                                                of a tap's event, s
    sum                                                        Q of the coincidence detector's node

and over temperature `comparator`, d ln Q / dx of each device's x, V_T0 (V) and ln beta, of the comparator
that all of them have.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from chips.latency.swing import (
    detector_threshold,
    halfway,
    idle_inhibition,
    swing_current,
    taken_at,
)
from chips.measured.table_record import TEMPERATURES, Quantities, measure_over, shifts
from chips.measured.timer import PARAMETERS, timer_slopes
from chips.record import Record, Table
from circuits.arrays import F64
from circuits.bias import die_current, rebias
from circuits.blocks.block import Block
from circuits.blocks.latency import coincidence as latency_coincidence
from circuits.blocks.latency import layer as latency_layer
from circuits.blocks.latency import neuron as latency_neuron
from circuits.blocks.latency import race as latency_race
from circuits.blocks.latency import tap as latency_tap
from circuits.blocks.latency import tonic as latency_tonic
from circuits.circuit import Bias, Circuit
from circuits.errors import SolverError
from circuits.event import WIDTH
from circuits.lowering.kernel import to_kernel
from circuits.lowering.on_die import standing
from circuits.silicon.process import Process
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate

SHIFTS = shifts(5)  # V
SYNAPSES, EXCITATIONS, INHIBITIONS = 8, 2, 7  # of the chip's neurons and cells; ours
QUANTITIES = (
    "timer", "tap", "tonic", "integrating", "race", "second", "recurrent", "pulse_width", "sum",
)  # fmt: skip
FIRST = 3e-3  # s, of the integrating neuron's only input
LAG = 2e-3  # s, of the coincidence detector's second input
RTOL = 1e-6
PASSIVE = 1e-9  # A, of a cell under the full law, which at 65 degC may leak more than the race's own; ours


def circuits() -> tuple[Circuit, ...]:
    """Return the circuits that the record is measured from."""
    return (
        latency_neuron.build(latency_neuron.Params(synapses=SYNAPSES)),
        latency_race.build(latency_race.Params(excitations=EXCITATIONS, inhibitions=INHIBITIONS)),
        latency_layer.build(),
        latency_tap.build(),
        latency_tonic.build(),
        latency_coincidence.build(),
    )


def measure(process: Process) -> Record:
    """Measure the record in a process without its errors; it takes half a minute on one core."""
    record = measure_over(charges, circuits(), SHIFTS, {}, process)
    gradient = np.array([_gradient(Silicon(process, t)) for t in TEMPERATURES])
    tables = {"comparator": Table(("temperature", "parameter"), gradient)}
    return record.extended(tables, {"parameter": PARAMETERS})


def charges(silicon: Silicon) -> Quantities:
    """Return the quantities of the blocks on a silicon, with ideal biases, by name."""
    neuron, race, layer, tap, tonic, cd = (rebias(c, {}, "ideal") for c in circuits())
    if silicon.process.effects == "full":
        race = rebias(race, {"i_passive": PASSIVE})
    heard = measured(latency_neuron.BLOCK, neuron, silicon, first=FIRST, second=None)
    hop = measured(latency_tap.BLOCK, tap, silicon)
    stopped = measured(latency_layer.BLOCK, layer, silicon, excite_1=None, inhibit_1=None, inhibit_2=None)
    quiet: dict[str, float | None] = {s.name: None for s in latency_race.BLOCK.stimuli}
    alone = measured(latency_race.BLOCK, race, silicon, **quiet)
    period = tonic_period(tonic, silicon)
    met = measured(latency_coincidence.BLOCK, cd, silicon, second=LAG)
    single = latency_race.build(latency_race.Params(excitations=1, inhibitions=1))
    one = replace(single, biases=race.biases)
    second = measured(latency_race.BLOCK, one, silicon, **quiet)

    def times(value: float, circuit: Circuit, bias: str, *idle: str) -> float:
        return value * _current(circuit, circuit.bias(bias), silicon, idle)

    return {
        "timer": times(heard["step_s"] - WIDTH, neuron, "i_step", "synapse0.mr"),
        "tap": times(hop["delay_s"] - WIDTH, tap, "i_tap", "tap.mr"),
        "tonic": times(period, tonic, "i_tonic", "cell.mz", "cell.mx", "cell.mq"),
        "integrating": times(heard["latency_s"] - FIRST, neuron, "i_exc", "mz"),
        "race": times(alone["latency_s"] - WIDTH, race, "i_passive", "mz", "mx"),
        "second": times(second["latency_s"] - WIDTH, one, "i_passive", "mz", "mx"),
        "recurrent": times(stopped["stop_s"], layer, "i_recurrent", "recurrent.mz"),
        "pulse_width": hop["pulse_s"],
        "sum": (met["latency_s"] - LAG) * _excess(cd, silicon),
    }


def tonic_period(circuit: Circuit, silicon: Silicon) -> float:
    """Return the period of a tonic neuron, s, under the full law its first one after the start's reset.

    There, spikes of some dies and of warm silicon leave the membrane part of its charge.
    """
    given = {"inhibit": None, "duration": 40e-3}
    if silicon.process.effects == "ideal":
        return measured(latency_tonic.BLOCK, circuit, silicon, **given)["period_s"]
    values = latency_tonic.BLOCK.defaults | given
    bench = latency_tonic.testbench(circuit, values, silicon.process.v_dd)
    spikes = simulate(bench, silicon, rtol=RTOL, record=()).spikes["spike"]
    return float(spikes[0]) - latency_tonic.START - WIDTH


def _current(circuit: Circuit, bias: Bias, silicon: Silicon, idle: Sequence[str]) -> float:
    """Current of a bias's pFET while it charges a capacitor, A, less what idle devices take.

    idle: nFETs whose gates are at ground; inhibitions of a membrane are found.
    """
    if silicon.process.effects == "ideal":
        return die_current(circuit, bias, silicon)
    d = standing(circuit, silicon)
    taken = np.asarray(d.idle(*idle, drain=halfway("n", d.v_dd)))
    for part in circuit.instances:
        if part.name.startswith("inhibit"):
            taken = taken + idle_inhibition(d, f"{part.name}.", d.gate["v_inh"])
    return float((swing_current(d, bias.device or "", d.below(bias.port)) - taken).item())


def _excess(circuit: Circuit, silicon: Silicon) -> float:
    """What two inputs of a coincidence detector give more than it takes, A."""
    if silicon.process.effects == "ideal":
        share = 2.0 - latency_coincidence.SHARE
        return share * die_current(circuit, circuit.bias("i_exc"), silicon)
    d = standing(circuit, silicon)
    at = detector_threshold(silicon)
    seen = d.current("input0.me", d.below("v_exc"), d.v_dd - at)
    return (2.0 * seen - taken_at(d, d.below("v_exc"), at)).item()


def measured(
    block: Block, circuit: Circuit, silicon: Silicon, **stimuli: float | None
) -> Mapping[str, float]:
    """Return what a block measures on a silicon; asking for what is not in the run raises `SolverError`."""
    values = block.defaults | stimuli
    result = simulate(block.testbench(circuit, values, silicon.process.v_dd), silicon, rtol=RTOL)
    return Found({name: value for name, value in block.measures(result).items() if value is not None})


class Found(dict[str, float]):
    """Quantities that a run has; asking for another raises `SolverError`, which names it."""

    def __missing__(self, name: str) -> float:
        raise SolverError(f"latency_chip.{name}: not in the run; give it longer or stronger currents")


def _gradient(silicon: Silicon) -> F64:
    """Slopes d ln Q / dx of a timer by each parameter of its comparator, float64[PARAMETERS]."""
    block = latency_coincidence.BLOCK
    circuit = rebias(latency_coincidence.build(), {}, "ideal")
    values = block.defaults | {"second": None}
    machine = to_kernel(block.testbench(circuit, values, silicon.process.v_dd), silicon)
    return timer_slopes(machine, "input0.timer", lambda result: block.measures(result)["window_s"], RTOL)
