"""Calibrations of the Pushbot's networks: codes of a die, and neurons that are left out by their address.

The bench sends events to the chip and counts spikes (`calibration`, `modified_calibration`). On the nominal
die at 27 degC nothing is searched: there the table of `biases`, which has codes of either law, is what other
dies are brought to.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from chips import codes
from chips.codes import Codes, Measured, attempted, left_off
from chips.rolls.calibration import MEASURE, SETTLE, Calibration, Task, population_rates
from chips.rolls.program.bias_file import BiasTable, default_biases
from chips.rolls.program.network import Network
from chips.rolls.validity import require_temperature
from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL
from circuits.silicon.process import ROLLS_180
from circuits.silicon.silicon import Silicon
from system.codes.find import codes_found
from system.pushbot.network import modified_calibration
from system.pushbot.network.biases import LEVELS, STEP, modified_biases, modified_table, pushbot_biases
from system.pushbot.network.calibration import (
    RATES,
    TURN_RATE,
    calibrate_pushbot,
    calibration_task,
    loop_task,
    turn,
)
from system.pushbot.network.modified import field_network, modified_network
from system.pushbot.network.modified_calibration import calibrate_modified, modified_task
from system.pushbot.network.plain import PAPER, PushbotLayout

PLAIN, MODIFIED = "pushbot", "pushbot-modified"  # of the calibrations
USUAL_C = 27.0  # degC, at which the nominal die has its tables
OFF = 0.25  # share of a rate beyond which it is told to stay off; ours
NEURON = "neuron"  # of what is off
WANTED = {**RATES, **{turn(name): TURN_RATE for name in ("DL", "DR")}}  # Hz


def network_of(name: str, layout: PushbotLayout) -> Network:
    """Return the whole network of a calibration."""
    if name == PLAIN:
        return field_network(layout, LEVELS)
    return modified_network(LEVELS, modified_biases(pushbot_biases()), layout)


def table_of(name: str, silicon: Silicon) -> BiasTable:
    """Return the table of the nominal die under the silicon's law."""
    law = silicon.process.effects
    return pushbot_biases(law=law) if name == PLAIN else modified_table(law)


def calibrate_plain(silicon: Silicon, kind: BiasKind, layout: PushbotLayout) -> Codes:
    """Calibrate the plain network on a silicon, at its temperature; kind: of the biases."""
    network, table = network_of(PLAIN, layout), table_of(PLAIN, silicon)

    def found() -> Calibration:
        if not _is_usual(silicon):
            return calibrate_pushbot(network, table, silicon, kind)
        tasks = {"{}": calibration_task(network, table), turn("{}"): loop_task(network, table)}
        return _as_it_is(tasks, silicon, kind)

    return attempted(PLAIN, silicon, kind, layout, lambda begun: _codes(begun, found(), WANTED))


def calibrate_graded(silicon: Silicon, kind: BiasKind, layout: PushbotLayout) -> Codes:
    """Calibrate the modified network on a silicon, at its temperature, from the plain one's codes there."""
    network, table = network_of(MODIFIED, layout), table_of(MODIFIED, silicon)

    def found() -> Calibration:
        if _is_usual(silicon):
            return _as_it_is({"{}": modified_task(network, table)}, silicon, kind)
        plain = codes_found(PLAIN, silicon, kind, layout)
        if plain.failed:
            raise ParameterError(plain.failed)
        return calibrate_modified(network, biases_of(plain), silicon, kind)

    return attempted(
        MODIFIED, silicon, kind, layout, lambda begun: _codes(begun, found(), modified_calibration.RATES)
    )


def biases_of(found: Codes) -> BiasTable:
    """Return the table of a calibration's codes."""
    table = default_biases()
    for name, ((coarse, fine),) in found.biases.items():
        table = table.with_code(name, coarse, fine)
    return table


def gone_of(found: Codes) -> frozenset[int]:
    """Return the neurons that a calibration leaves out."""
    return frozenset(found.off.get(NEURON, ()))


def _is_usual(silicon: Silicon) -> bool:
    return silicon.die == NOMINAL and silicon.temperature_c == USUAL_C


def _as_it_is(tasks: Mapping[str, Task], silicon: Silicon, kind: BiasKind) -> Calibration:
    """What tasks measure of the nominal die, whose table stays; their keys name a population's rate."""
    rates: dict[str, float] = {}
    for form, task in tasks.items():
        measured = population_rates(task, silicon, kind, STEP)
        rates |= {form.format(name): rate for name, rate in measured.items()}
    biases = next(iter(tasks.values())).program.biases
    return Calibration(biases, {}, rates, rates, len(tasks))


def _codes(begun: Codes, found: Calibration, wanted: Mapping[str, float]) -> Codes:
    """What was found, as codes."""
    measured = tuple(_measured(found, wanted))
    silent = [m.name for m in measured if m.after == 0.0]
    return replace(
        begun,
        biases={bias: (code,) for bias, code in found.biases.codes().items()},
        off={NEURON: tuple(sorted(k for gone in found.blacklist.values() for k in gone))},
        measured=measured, bench_s=found.runs * (SETTLE + MEASURE), unmended=left_off(measured, OFF),
        failed=f"{', '.join(silent)}: no spikes at any code that was tried" if silent else "",
    )  # fmt: skip


def _measured(found: Calibration, wanted: Mapping[str, float]) -> Iterator[Measured]:
    """Mean rates of the neurons of each population, before and after."""
    for name, after in found.rates.items():
        own = wanted[name.partition("[")[0]]
        yield Measured(f"rate[{name}]", "Hz", own, found.before[name], after)


CALIBRATION = codes.Calibration(
    name=PLAIN,
    summary="rates of the Pushbot's populations on ROLLS, plain network",
    process=ROLLS_180,
    calibrate=calibrate_plain,
    setup=PAPER,
    require_temperature=require_temperature,
)
MODIFIED_CALIBRATION = replace(
    CALIBRATION,
    name=MODIFIED,
    summary="rates of obstacle and drive populations of the modified network",
    calibrate=calibrate_graded,
)
