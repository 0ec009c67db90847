"""Power of a ROLLS chip in a run, as every system with such a chip tells it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from chips.rolls.chip import RollsChip
from chips.rolls.power import Energies, Power, activity_of, chip_power, energies_of
from circuits.arrays import I64
from circuits.errors import CircuitError
from system.files.kept import kept

TABLE = """
static_power_mW   number?  mW  leakage and rest currents of neurons, filters and synapses; null with the
                               three below where the neuron alone does not fire, so that it has no energy
bias_power_mW     number?  mW  of the biases' branches and the splitters of their generator
dynamic_power_mW  number?  mW  of spikes and of events at synapses
total_power_mW    number?  mW  sum of these three, at the temperature of the run's beginning; without the
                               address-event circuits, the pads, and a second chip
"""


def run_power(chip: RollsChip, spikes: I64, virtual: Mapping[int, int], duration: float) -> Power:
    """Return the mean power of a chip in a run at its silicon's temperature, that of a course's beginning.

    `chip` is without plastic synapses and cells of depression; `spikes` (int64[m]), `virtual` and `duration`
    (s) are those of `activity_of`. Raises `CircuitError` where the energies of its parts cannot be measured.
    """
    return chip_power(kept_energies(chip), activity_of(chip.program, spikes, virtual, duration))


def kept_energies(chip: RollsChip) -> Energies:
    """Return the energies of a chip's parts (`energies_of`), which are measured once a machine."""
    on = replace(chip.silicon, die=chip.silicon.die.without_mismatch())
    asked = chip.program.biases, on, chip.kind, chip.params
    return kept("rolls-energies", asked, Energies, lambda: energies_of(chip))


def power_numbers(
    chip: RollsChip, spikes: I64, virtual: Mapping[int, int], duration: float
) -> dict[str, float | None]:
    """Return what `run_power` finds by the names of `TABLE`, mW; None where it cannot be measured."""
    try:
        found = run_power(chip, spikes, virtual, duration)
    except CircuitError:
        return dict.fromkeys(f"{name}_power_mW" for name in (*Power({}, {}, {}).parts, "total"))
    return {f"{name}_power_mW": 1e3 * w for name, w in {**found.parts, "total": found.total}.items()}
