"""Set-ups that show what a calibrated ROLLS chip does: eight populations at three rates, and a neural field.

Every number is ours. Populations: 16 neurons each, driven by 250 events/s through a synapse of level 1, 2 or
3, so that three biases set three target rates at once; `NPA_WEIGHT_EXC` those of level 1, and with it
`..EXC0` and `..EXC1` those of levels 2 and 3. Field: 128 neurons on virtual synapses, with `neural_field`
between them; its calibration brings 16 groups of eight to one rate without recurrence.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from chips.population import Population
from chips.rolls_address import NEURONS, NONPLASTIC
from chips.rolls_bias_file import BiasTable, default_biases
from chips.rolls_calibration import Calibration, Knob, Target, Task, code_for, neuron_rates
from chips.rolls_chip import Inputs, RollsChip
from chips.rolls_program import Program
from circuits.circuit import BiasKind
from circuits.silicon import Silicon

F64 = NDArray[np.float64]

POPULATIONS, SIZE = 8, 16
RATES = (20.0, 50.0, 100.0)  # Hz, of levels 1, 2, 3; the populations take them in turn
EVENTS = 250.0  # Hz, to every neuron
SOURCE = 248  # presynaptic neuron of level 1; the next two have levels 2 and 3
_LEVEL_BIASES = ("NPA_WEIGHT_EXC_P", "NPA_WEIGHT_EXC0_P", "NPA_WEIGHT_EXC1_P")
_FAST = (7, 150)  # code of a filter's leak and gain: 8.8 pA, 4.5 ms
QUIET = {"IF_DC_P": (7, 0)} | dict.fromkeys(
    (f"{name}_P" for name in ("NPDPIE_TAU", "NPDPIE_THR", "VDPIE_TAU", "VDPIE_THR")), _FAST
)


def table(codes: dict[str, tuple[int, int]], currents: dict[str, float]) -> BiasTable:
    """The control software's biases with other codes, and with those of some currents, A."""
    found = default_biases()
    for name, code in (codes | {name: code_for(i) for name, i in currents.items()}).items():
        found = found.with_code(name, *code)
    return found


def populations_task() -> Task:
    """Eight populations that are to fire at 20, 50 and 100 Hz."""
    levels = np.zeros((NEURONS, NEURONS), dtype=np.int8)
    targets: list[Target] = []
    names: tuple[list[str], ...] = ([], [], [])
    for k in range(POPULATIONS):
        which = k % len(RATES)
        group = Population(f"p{k}", tuple(range(SIZE * k, SIZE * (k + 1))))
        levels[list(group.neurons), SOURCE + which] = which + 1
        targets.append(Target(group, RATES[which]))
        names[which].append(group.name)
    biases = table(QUIET, dict(zip(_LEVEL_BIASES, (10e-9, 3e-9, 8e-9), strict=True)))
    knobs = tuple(Knob(bias, tuple(each)) for bias, each in zip(_LEVEL_BIASES, names, strict=True))
    return Task(Program(levels, biases), tuple(targets), knobs, populations_drive)


def populations_drive(duration: float, phase: float = 0.0) -> Inputs:
    """Regular events to every neuron's source, beginning `phase` s late."""
    times = np.arange(1e-3 + phase, duration, 1.0 / EVENTS)
    neurons = np.arange(POPULATIONS * SIZE)
    columns = NONPLASTIC + SOURCE + (neurons // SIZE) % len(RATES)
    return Inputs(
        np.repeat(times, neurons.size), np.tile(neurons, times.size), np.tile(columns, times.size)
    )


def population_errors(
    task: Task, found: Calibration, silicon: Silicon, kind: BiasKind, duration: float = 2.0
) -> dict[str, float]:
    """Mean rate over its target, less one, by population, of a calibrated chip on `silicon`.

    Another run than the calibration's: twice as long, events at another phase.
    """
    chip = RollsChip(replace(task.program, biases=found.biases), silicon, kind)
    rates = neuron_rates(chip, lambda d: populations_drive(d, 1.7e-3), duration)
    return {
        t.population.name: float(np.mean(rates[list(found.kept(t.population))])) / t.rate - 1.0
        for t in task.targets
    }
