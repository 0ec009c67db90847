"""Power of the plastic array of ROLLS and of its depression cells, as `noctule show rolls` shows it."""

from __future__ import annotations

from typing import Any

import numpy as np

from chips.rolls.depression.power import DepressionEnergies
from chips.rolls.depression.program import STEP_BIAS
from chips.rolls.plastic.power import PlasticEnergies, lacking
from chips.rolls.power import Activity, Energies, chip_power
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable
from system.cli.output import print_line, print_table, quantity_cell

RATES = (0.0, 10.0, 100.0, 1000.0)  # Hz, of all neurons, for which power is told
WEIGHTS = NEURONS * NEURONS  # of the plastic array


def rest_document(e: Energies) -> dict[str, Any]:
    """Give the power of a chip without spikes and events for JSON, by its parts."""
    found = chip_power(e, Activity(np.zeros(NEURONS)))
    return {
        "at_rest": {**{f"{name}_W": watts for name, watts in found.parts.items()}, "total_W": found.total},
        "static_W": dict(found.static),
    }


def plastic_document(e: PlasticEnergies | None) -> dict[str, Any] | None:
    """Give the power of the plastic array for JSON; None where its energies were not measured."""
    if e is None:
        return None
    return {
        "learning_circuits_rest_W": e.rest,
        "weight_rest_W": {"low": e.low_rest, "high": e.high_rest},
        "column_event_energy_J": e.extender,
        "weight_event_energy_J": {"low": e.low, "high": e.high},
        "spike_rate_Hz": e.rates,
        "spike_energy_J": e.spike,
        "at_rate": [
            {"rate_Hz": rate, "all_low_W": e.power(rate), "all_high_W": e.power(rate, WEIGHTS)}
            for rate in RATES
        ],
    }


def depression_document(e: DepressionEnergies | None, table: BiasTable) -> dict[str, Any] | None:
    """Give the power of the depression cells for JSON; None where their energies were not measured."""
    if e is None:
        return None
    return {
        "step_current_A": table.current(STEP_BIAS),
        "rest_W": e.power(0.0),
        "event_energy_J": e.event,
    }


def print_plastic(e: PlasticEnergies | None, power: dict[str, Any], table: BiasTable) -> None:
    """Print the power of the plastic array, or what the biases lack for it.

    power: document of that power; table: biases of the chip.
    """
    if e is None:
        print_line(f"power of the plastic array: not told, the bias file lacks {', '.join(lacking(table))}")
        return
    rows = [
        (f"{row['rate_Hz']:g}", *(watts_cell(row[k]) for k in ("all_low_W", "all_high_W")))
        for row in power["at_rate"]
    ]
    print_table(
        "power of the plastic array, beside the above",
        ("all neurons at (Hz):", f"{WEIGHTS} low weights:", "high weights:"),
        rows,
    )
    print_line(
        f"at rest: learning circuits {quantity_cell(e.rest, 'W')}, a low weight"
        f" {quantity_cell(e.low_rest, 'W')}, a high one {quantity_cell(e.high_rest, 'W')}"
    )
    spikes = ", ".join(
        f"{quantity_cell(float(j), 'J')} at {rate:.3g} Hz" for rate, j in zip(e.rates, e.spike, strict=True)
    )
    print_line(
        f"energy of an event: of a column {quantity_cell(e.extender, 'J')}, of a low weight"
        f" {quantity_cell(e.low, 'J')}, of a high one {quantity_cell(e.high, 'J')}; of a neuron's spike in"
        f" its learning circuit {spikes}"
    )


def print_depression(e: DepressionEnergies | None, table: BiasTable) -> None:
    """Print the power of the depression cells, or what the biases of `table` lack for it."""
    if e is None:
        print_line(f"power of cells of depression: not told, the bias file lacks {STEP_BIAS}")
        return
    print_line(
        f"\ncells of depression, where a program has them: rest {quantity_cell(e.power(0.0), 'W')} with"
        f" {STEP_BIAS} at {quantity_cell(table.current(STEP_BIAS), 'A')}, an exciting event of a synapse"
        f" {quantity_cell(e.event, 'J')}"
    )


def watts_cell(value: float | None) -> str:
    """Write a power, W, as the cell of a table; it is empty for None."""
    return "" if value is None else quantity_cell(value, "W")
