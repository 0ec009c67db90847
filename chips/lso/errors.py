"""Errors of the sonar head's model against the transistors of its parts, on dies that were not measured.

On each die an LSO neuron and a level unit, at places that follow from the die's number, at the chip's own
bias voltages; both kinds of bias and 0, 27 and 60 degC in turn. The neuron gets a draw of inputs of both
sides within 0.15 ms, as an echo makes them: how far the number of spikes is off, and the time of each spike,
relative to the time since the inputs. The level unit rests 50 mV below its threshold, where it must end the
refractory period after a spike (under the full law it can also rest as if it had), and gets ramps of two
slopes: whether it spikes, which not all do, and how far its spike is off. All of it again on dies whose
devices have a sixteenth of the area, so four times the mismatch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from chips.lso.measure import (
    AT,
    FROM,
    LEVELS,
    QUIET,
    RTOL,
    circuits,
    crossing,
    measure,
    ramp_bench,
)
from chips.lso.model import LEAST_AREA, SIDES, Head, head_on, level_times, side_spikes
from chips.lso.place import NAME, line_volts
from chips.lso.rest import THRESHOLD
from chips.measured.held_out import of_dies, rms_and_max, silicon_in_turn
from chips.model import plain_model
from circuits.arrays import F64
from circuits.blocks.latency.synapse import REFERENCE
from circuits.blocks.latency.tonic import START, reset_wave
from circuits.circuit import BiasKind, Circuit
from circuits.devices import Source
from circuits.devices.source import Constant, Pulse, Waveform
from circuits.event import EDGE, WIDTH
from circuits.silicon.process import AMI_1500_IDEAL, Process
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from circuits.testbench import Testbench

HELD_OUT = tuple(range(500, 524))  # dies; none is used to build
SMALL = tuple(range(524, 540))  # likewise, with devices of the least area
SPREAD = 0.15e-3  # s, of all inputs
RAMPS = 800.0, 10e3  # V/s, between those that the record is of and beyond


def held_out_errors(
    process: Process = AMI_1500_IDEAL, dies: Sequence[int] = HELD_OUT, small: Sequence[int] = SMALL
) -> dict[str, float]:
    """Return the model's errors by name, those of devices of `LEAST_AREA` with `small_` before it.

    dies, small: numbers of the dies for either. It takes some 30 s on one core.
    """
    tiny = judge(small, LEAST_AREA, process)
    return judge(dies, process=process) | {f"small_{name}": value for name, value in tiny.items()}


def judge(dies: Sequence[int], area: float = 1.0, process: Process = AMI_1500_IDEAL) -> dict[str, float]:
    """Return the model's errors by name on dies whose devices have `area` times the circuits' area."""
    counts: list[int] = []
    times: list[float] = []
    delays: list[float] = []
    wrong_units = 0
    for number, kind, plain in silicon_in_turn(dies, process):
        silicon = plain.of_area(area)
        head, side = head_on(plain, kind, area), number % SIDES
        ours, theirs = neuron_spikes(head, silicon, kind, side, inputs(number))
        counts.append(ours.size - theirs.size)
        both = min(ours.size, theirs.size)
        times += list((ours[:both] - theirs[:both]) / (theirs[:both] - AT))
        unit = side, number % LEVELS
        for slope in RAMPS:
            ours_s, theirs_s = level_delays(head, silicon, kind, unit, slope)
            if np.isfinite(theirs_s):
                delays.append(ours_s - theirs_s)
            wrong_units += int(np.isfinite(theirs_s) != (head.rest[unit] < -FROM))
    decisions = {
        "counts_wrong": float(np.count_nonzero(counts)),
        "count_max": float(np.abs(counts).max()),
        "spikes_compared": float(len(times)),
        "level_decisions": float(len(dies) * len(RAMPS)),
        "level_decisions_wrong": float(wrong_units),
    }
    errors = rms_and_max("spike", times, "relative") | rms_and_max("level", delays, "s")
    return of_dies(dies) | decisions | errors


def inputs(number: int) -> F64:
    """Return random times of level units' spikes, s, float64[SIDES, LEVELS], inf for those that do not spike.

    The die's `number` is the seed, and chooses the louder side.
    """
    random = np.random.default_rng(number)
    heard = np.sort(random.integers(0, LEVELS + 1, SIDES))[::-1]
    found = np.full((SIDES, LEVELS), np.inf)
    for side, n in enumerate(heard if number % SIDES == 0 else heard[::-1]):
        found[side, :n] = AT + np.sort(random.uniform(0.0, SPREAD, n))
    return found


def neuron_spikes(head: Head, silicon: Silicon, kind: BiasKind, side: int, level: F64) -> tuple[F64, F64]:
    """Return the spikes of an LSO neuron, s after the reset: the model's, and the circuit's.

    level: spikes of the level units, as of `inputs`.
    """
    lso = replace(circuits()[0], biases=())
    longest = max(float(head.excite_step.max()), float(head.inhibit_step.max()))
    bench = neuron_bench(lso, silicon, kind, (level[side], level[1 - side]), AT + SPREAD + 1.3 * longest)
    placed = replace(silicon, place=((NAME, ()), ("lso", (side,))))
    found = simulate(bench, placed, rtol=RTOL, record=()).spikes["spike"]
    return side_spikes(head, side, level), np.asarray(found) - START


def neuron_bench(
    lso: Circuit, silicon: Silicon, kind: BiasKind, sides: tuple[F64, F64], stop: float
) -> Testbench:
    """Return the testbench of an LSO neuron with the chip's bias voltages, and events of both ears.

    sides: times of the near and of the far ear's events, s, inf for none; stop: end of the run, s.
    """
    v_dd = silicon.process.v_dd
    lines = dict(line_volts(silicon, kind)) | {"v_ref": REFERENCE}
    names = [port.name for port in lso.ports if port.kind == "bias"]
    sources = [Source("vdd", "vdd", Constant(v_dd)), Source("reset", "reset", reset_wave(None, v_dd))]
    sources += [Source(name, name, Constant(lines[name])) for name in names]
    for name, times in zip(("excite", "inhibit"), sides, strict=True):
        for k, t in enumerate(times):
            on = Pulse(0.0, v_dd, (START + float(t),), WIDTH, EDGE, EDGE) if np.isfinite(t) else None
            wave: Waveform = on or Constant(0.0)
            sources.append(Source(f"{name}[{k}]", f"{name}[{k}]", wave))
    return Testbench("lso neuron", lso, tuple(sources), stop, watch=("spike",))


def level_delays(
    head: Head, silicon: Silicon, kind: BiasKind, place: tuple[int, int], slope: float
) -> tuple[float, float]:
    """Return the time from a ramp's crossing of the drawn threshold to a level unit's spike, s.

    It is that of the model, and that of the circuit, inf for no spike. place: side and number of the unit;
    slope: of the ramp, V/s.
    """
    side, k = place
    at = np.full(head.offset.shape, np.inf)
    at[place] = head.offset[place] / slope
    ours = float(level_times(head, at, np.full(at.shape, slope))[place])
    level = replace(circuits()[1], biases=())
    bench = ramp_bench(level, slope, silicon.process.v_dd, QUIET)
    lines = dict(line_volts(silicon, kind)) | {"v_threshold": THRESHOLD}
    held = tuple(Source(p.name, p.name, Constant(lines[p.name])) for p in level.ports if p.name in lines)
    placed = replace(silicon, place=((NAME, ()), ("ear", (side,)), ("level", (k,))))
    bench = replace(bench, sources=(*bench.sources, *held))
    spikes = simulate(bench, placed, rtol=RTOL, record=()).spikes["spike"]
    spikes = spikes[spikes > QUIET]
    return ours, float(spikes[0]) - QUIET - crossing(slope) if spikes.size else np.inf


MODEL = plain_model("lso-neuron", circuits, measure, held_out_errors, head_on)
