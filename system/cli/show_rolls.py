"""The verb `noctule show rolls`: f-I curves, time constants, weights, refractory periods and power."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from chips.rolls.circuit import CHIP
from chips.rolls.depression.power import DepressionEnergies, depression_energies
from chips.rolls.depression.program import STEP_BIAS, ShortTermDepression
from chips.rolls.plastic.power import PlasticEnergies, lacking, plastic_energies
from chips.rolls.portrait import MULTIPLES, Portrait, portrait
from chips.rolls.power import TYPICAL, Activity, Energies, chip_power, energies
from chips.rolls.program.address import NEURONS
from chips.rolls.program.bias_file import BiasTable
from circuits.arrays import F64
from circuits.circuit import BiasKind
from circuits.silicon.silicon import Silicon
from system.cli.output import print_json, print_line, print_table, quantity_cell, working
from system.cli.show_rolls_power import (
    RATES,
    depression_document,
    plastic_document,
    print_depression,
    print_plastic,
    rest_document,
    watts_cell,
)
from system.cli.verbs import Show
from system.files.kept import kept
from system.options.block import describe_silicon
from system.plot import check_picture, save_picture
from system.rolls.options import NAME, bias_table, refuse_block_options, silicon_of
from system.rolls.picture import draw_portrait

ALL_TO_ALL = 1  # level of the other case; ours


def show_rolls(asked: Show) -> None:
    """Measure a die of ROLLS, print its properties, and draw them where a picture is asked for."""
    values = asked.values
    check_picture(asked.plot)
    refuse_block_options(values.param, values.bias, values.bias_set)
    table, on, kind = bias_table(values.bias_file), silicon_of(asked.silicon), values.bias_kind or "generator"
    with working("measuring the die"):
        found = _portrait(table, on, kind)
        power, plastic, depression = _energies(table, on, kind, float(found.currents[0] / MULTIPLES[0]))
    save_picture(asked.plot, lambda figure: draw_portrait(found, figure))
    document = _document(found, power, plastic, values.bias_file)
    document["depression_power"] = depression_document(depression, table)
    if asked.as_json:
        print_json(document)
    else:
        _print(found, power, table, document)
        print_plastic(plastic, document["plastic_power"], table)
        print_depression(depression, table)


def _portrait(table: BiasTable, on: Silicon, kind: BiasKind) -> Portrait:
    """The portrait of a die, which is kept without the die: a plan of many dies may be behind it."""

    def measured() -> Portrait:
        return replace(portrait(table, on, kind), silicon=Silicon(on.process))

    return replace(kept("rolls-portrait", (table, on, kind), Portrait, measured), silicon=on)


def _energies(
    table: BiasTable, silicon: Silicon, kind: BiasKind, rheobase: float
) -> tuple[Energies, PlasticEnergies | None, DepressionEnergies | None]:
    """Energies of the parts, of the plastic array and of cells of depression; None of what the biases lack.

    rheobase: A, of a neuron without I_dc. They are kept for all dies that share what devices share.
    """
    on, cells = replace(silicon, die=silicon.die.without_mismatch()), ShortTermDepression()
    plastic = depression = None
    power = kept(
        "rolls-parts", (table, on, kind, rheobase), Energies, lambda: energies(table, on, rheobase, kind)
    )
    if not lacking(table):
        plastic = kept(
            "rolls-plastic", (table, on, kind), PlasticEnergies, lambda: plastic_energies(table, on, kind)
        )
    if STEP_BIAS in table.names:
        depression = kept(
            "rolls-depression", (table, on, kind, cells), DepressionEnergies,
            lambda: depression_energies(cells, table, on, kind),
        )  # fmt: skip
    return power, plastic, depression


def _document(
    p: Portrait, e: Energies, plastic: PlasticEnergies | None, bias_file: str | None
) -> dict[str, Any]:
    return {
        "chip": NAME,
        "summary": CHIP.summary,
        **describe_silicon(p.silicon),
        "bias_kind": p.kind,
        "bias_file": bias_file,
        "fi_current_A": p.currents,
        "fi_rate_Hz": p.rates.T,
        "fi_nominal_rate_Hz": p.nominal_rates,
        "rheobase_A": p.rheobase,
        "fires_without_input": np.flatnonzero(p.restless),
        "membrane_time_constant_s": p.tau,
        "refractory_period_s": p.refractory,
        "filter_time_constant_s": dict(p.filters),
        "pulse_length_s": p.pulses,
        "spread": {name: _statistics(values) for name, values in _quantities(p).items()},
        "weights": [
            {
                "level": w.level, "nominal_current_A": w.nominal, "current_A": w.current,
                "charge_C": w.charge, "charge_cv": w.charge_cv,
            }
            for w in p.weights
        ],
        "missing_levels": dict(p.missing),
        "cautions": p.cautions,
        "power": _power(e),
        "plastic_power": plastic_document(plastic),
    }  # fmt: skip


def _power(e: Energies) -> dict[str, Any]:
    latched = {ALL_TO_ALL: NEURONS * NEURONS} if ALL_TO_ALL in e.event else {}
    return {
        "paper_typical_W": TYPICAL,
        "biases_W": e.biases,
        "generator_W": e.generator,
        "rest_W": e.rest,
        **rest_document(e),
        "spike_rate_Hz": e.rates,
        "spike_energy_J": e.spike,
        "column_event_energy_J": e.column,
        "synaptic_event_energy_J": dict(e.event),
        "virtual_event_energy_J": dict(e.virtual),
        "at_rate": [
            {
                "rate_Hz": rate, "unconnected_W": e.power(rate, {}),
                "all_to_all_W": e.power(rate, latched) if latched else None,
            }
            for rate in RATES
        ],
    }  # fmt: skip


def _quantities(p: Portrait) -> dict[str, F64]:
    return {
        "rheobase_A": p.rheobase,
        "membrane_time_constant_s": p.tau,
        "refractory_period_s": p.refractory,
        **{f"{name}_time_constant_s": tau for name, tau in p.filters.items()},
        "pulse_length_s": p.pulses,
    }


def _statistics(values: F64) -> dict[str, float]:
    mean = float(values.mean())
    return {
        "mean": mean, "cv": float(values.std()) / mean if mean else float("nan"),
        "least": float(values.min()), "greatest": float(values.max()),
    }  # fmt: skip


def _print(p: Portrait, e: Energies, table: BiasTable, document: dict[str, Any]) -> None:
    print_line(f"{NAME}: {CHIP.summary}")
    print_line(f"at {p.silicon.temperature_c:g} degC, {p.silicon.die}, biases of kind {p.kind}\n")
    rows = []
    for name, s in document["spread"].items():
        label, _, unit = name.rpartition("_")
        cells = (quantity_cell(s[k], unit) for k in ("mean", "least", "greatest"))
        rows.append((label.replace("_", " "), *cells, f"{s['cv']:.1%}"))
    print_table("neurons and filters", ("quantity", "mean:", "least:", "greatest:", "CV:"), rows)
    own = quantity_cell(table.current("IF_DC_P"), "A")
    print_line(f"{int(p.restless.sum())} of {NEURONS} neurons fire by the bias I_dc of {own} alone\n")
    curve = [
        (
            quantity_cell(float(current), "A"), f"{nominal:.4g}", f"{rates.mean():.4g}",
            f"{rates.std() / rates.mean():.1%}" if rates.any() else "",
            int((rates == 0.0).sum()),
        )
        for current, rates, nominal in zip(p.currents, p.rates, p.nominal_rates, strict=True)
    ]  # fmt: skip
    print_table("f-I curve (Hz)", ("I_dc:", "nominal:", "mean:", "CV:", "silent:"), curve)
    weights = [
        (
            w.level, quantity_cell(w.nominal, "A"), quantity_cell(w.current, "A"),
            quantity_cell(w.charge, "C"), f"{w.charge_cv:.1%}",
        )
        for w in p.weights
    ]  # fmt: skip
    print_table("weights", ("level:", "codes:", "on the die:", "charge an event:", "CV:"), weights)
    for level, name in p.missing.items():
        print_line(f"level {level} is missing: {name} has fine code 0")
    for caution in p.cautions:
        print_line(f"outside of what the chip's step was measured for: {caution}")
    _print_power(e, document["power"])


def _print_power(e: Energies, power: dict[str, Any]) -> None:
    spikes = ", ".join(
        f"{quantity_cell(float(j), 'J')} at {rate:.3g} Hz" for rate, j in zip(e.rates, e.spike, strict=True)
    )
    events = ", ".join(f"{level}: {quantity_cell(j, 'J')}" for level, j in e.event.items())
    print_line(f"energy of a spike: {spikes}")
    print_line(
        f"of a column's event: {quantity_cell(e.column, 'J')}; of a latched synapse's, by level: {events}\n"
    )
    rows = [
        (f"{row['rate_Hz']:g}", *(watts_cell(row[k]) for k in ("unconnected_W", "all_to_all_W")))
        for row in power["at_rate"]
    ]
    rest = chip_power(e, Activity(np.zeros(NEURONS)))
    title = f"power; the paper's typical figure is {quantity_cell(TYPICAL, 'W')}"
    print_table(title, ("all neurons at (Hz):", "no synapses:", f"all to all, level {ALL_TO_ALL}:"), rows)
    print_line(
        f"at rest: static {quantity_cell(rest.parts['static'], 'W')}, bias"
        f" {quantity_cell(rest.parts['bias'], 'W')} ({quantity_cell(e.generator, 'W')} of it the generator's"
        f" splitters), together {quantity_cell(rest.total, 'W')}; without the generator's reference, the"
        " address-event circuits and the pads\n"
    )
