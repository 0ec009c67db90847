"""Systems and experiments by command-line name, and everything that the command line can list.

Users add theirs under the entry points `noctule.systems` and `noctule.experiments`.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping
from importlib import import_module
from importlib.metadata import entry_points
from typing import TYPE_CHECKING, Any

from chips.registry import CHIPS, load_chip
from circuits.errors import UnknownNameError, shown_name
from circuits.registry import block_names, load_block

if TYPE_CHECKING:
    from circuits.blocks.block import Block
    from system.experiment import Experiment

SYSTEMS: dict[str, str] = {
    "approach": "system.approach:SYSTEM",
    "rover": "system.rover:SYSTEM",
    "forest": "system.forest:SYSTEM",
    "robot": "system.robot:SYSTEM",
    "head": "system.sonar_head:SYSTEM",
    "bug": "system.bug:SYSTEM",
    "pushbot": "system.pushbot:SYSTEM",
    "rolls": "system.rolls:SYSTEM",
}

EXPERIMENTS: dict[str, str] = {
    "cheely2003-fig4": "system.experiments.cheely2003_fig4:EXPERIMENT",
    "cheely2003-fig5": "system.experiments.cheely2003_fig5:EXPERIMENT",
    "cheely2003-fig6": "system.experiments.cheely2003_fig6:EXPERIMENT",
    "cheely2003-fig8": "system.experiments.cheely2003_fig8:EXPERIMENT",
    "cheely2003-fig9": "system.experiments.cheely2003_fig9:EXPERIMENT",
    "cheely2003-fig10": "system.experiments.cheely2003_fig10:EXPERIMENT",
    "cheely2003-fig11": "system.experiments.cheely2003_fig11:EXPERIMENT",
    "cheely2003-power": "system.experiments.cheely2003_power:EXPERIMENT",
    "cheely2003-head": "system.experiments.cheely2003_head:EXPERIMENT",
    "hwu2018-fig1": "system.experiments.hwu2018_fig1:EXPERIMENT",
    "hwu2018-fig2": "system.experiments.hwu2018_fig2:EXPERIMENT",
    "hwu2018-table1": "system.experiments.hwu2018_table1:EXPERIMENT",
    "hwu2018-table2": "system.experiments.hwu2018_table2:EXPERIMENT",
    "hwu2018-campaign": "system.experiments.hwu2018_campaign:EXPERIMENT",
    "wen2022-fig5": "system.experiments.wen2022_fig5:EXPERIMENT",
    "wen2022-fig10": "system.experiments.wen2022_fig10:EXPERIMENT",
    "wen2022-fig11a": "system.experiments.wen2022_fig11a:EXPERIMENT",
    "wen2022-fig11b": "system.experiments.wen2022_fig11b:EXPERIMENT",
    "wen2022-fig11c": "system.experiments.wen2022_fig11c:EXPERIMENT",
    "wen2022-fig11d": "system.experiments.wen2022_fig11d:EXPERIMENT",
    "wen2022-fig11e": "system.experiments.wen2022_fig11e:EXPERIMENT",
    "wen2022-fig12": "system.experiments.wen2022_fig12:EXPERIMENT",
    "wen2022-fig12-chip": "system.experiments.wen2022_fig12_chip:EXPERIMENT",
    "wen2022-fig13": "system.experiments.wen2022_fig13:EXPERIMENT",
    "wen2022-fig15": "system.experiments.wen2022_fig15:EXPERIMENT",
    "latency-equations": "system.experiments.latency_equations:EXPERIMENT",
    "latency-agreement": "system.experiments.latency_agreement:EXPERIMENT",
    "latency-recall": "system.experiments.latency_recall:EXPERIMENT",
    "latency-forests": "system.experiments.latency_forests:EXPERIMENT",
    "latency-dies": "system.experiments.latency_dies:EXPERIMENT",
    "latency-loops": "system.experiments.latency_loops:EXPERIMENT",
    "forest-silicon": "system.experiments.forest_silicon:EXPERIMENT",
    "forest-weights": "system.experiments.forest_weights:EXPERIMENT",
    "stockel2017-fig5": "system.experiments.stockel2017_fig5:EXPERIMENT",
    "stockel2017-fig6": "system.experiments.stockel2017_fig6:EXPERIMENT",
    "stockel2017-fig7": "system.experiments.stockel2017_fig7:EXPERIMENT",
    "stockel2017-fig8": "system.experiments.stockel2017_fig8:EXPERIMENT",
    "stockel2017-chip": "system.experiments.stockel2017_chip:EXPERIMENT",
    "stockel2017-campaign": "system.experiments.stockel2017_campaign:EXPERIMENT",
    "nef-chip": "system.experiments.nef_chip:EXPERIMENT",
    "rolls-calibration": "system.experiments.rolls_calibration:EXPERIMENT",
    "rolls-field": "system.experiments.rolls_field:EXPERIMENT",
    "rolls-drift": "system.experiments.rolls_drift:EXPERIMENT",
    "rolls-forms": "system.experiments.rolls_forms:EXPERIMENT",
    "rolls-mismatch": "system.experiments.rolls_mismatch:EXPERIMENT",
    "rolls-learning": "system.experiments.rolls_learning:EXPERIMENT",
    "rolls-depression": "system.experiments.rolls_depression:EXPERIMENT",
    "milde2017-table1": "system.experiments.milde2017_table1:EXPERIMENT",
    "milde2017-pairs": "system.experiments.milde2017_pairs:EXPERIMENT",
    "milde2017-variability": "system.experiments.milde2017_variability:EXPERIMENT",
    "milde2017-fig5": "system.experiments.milde2017_fig5:EXPERIMENT",
    "milde2017-fig6": "system.experiments.milde2017_fig6:EXPERIMENT",
    "milde2017-fig7": "system.experiments.milde2017_fig7:EXPERIMENT",
    "milde2017-moving": "system.experiments.milde2017_moving:EXPERIMENT",
    "milde2017-target": "system.experiments.milde2017_target:EXPERIMENT",
    "milde2017-chase": "system.experiments.milde2017_chase:EXPERIMENT",
    "milde2017-clutter": "system.experiments.milde2017_clutter:EXPERIMENT",
    "milde2017-office": "system.experiments.milde2017_office:EXPERIMENT",
    "milde2017-temperature": "system.experiments.milde2017_temperature:EXPERIMENT",
    "agreement": "system.experiments.agreement:EXPERIMENT",
    "ngspice-dies": "system.experiments.ngspice_dies:EXPERIMENT",
    "device-noise": "system.experiments.device_noise:EXPERIMENT",
    "chip-noise": "system.experiments.chip_noise:EXPERIMENT",
}


def system_names() -> list[str]:
    """Names of all systems, the users' own included, in the table's order."""
    return _names(SYSTEMS, "noctule.systems")


def experiment_names() -> list[str]:
    """Names of all experiments, the users' own included, in the table's order."""
    return _names(EXPERIMENTS, "noctule.experiments")


def load_system(name: str) -> Any:
    """Load a system, whose `summary` is a line and whose `run(**options)` runs it."""
    return _load("system", name, SYSTEMS, "noctule.systems")


def load_experiment(name: str) -> Experiment:
    """Load an experiment; raises `UnknownNameError`."""
    experiment: Experiment = _load("experiment", name, EXPERIMENTS, "noctule.experiments")
    return experiment


def load_block_or_chip(name: str) -> Block:
    """Load a block, or a chip, which is a block too; raises `UnknownNameError` with near names."""
    if name in CHIPS:
        return load_chip(name)
    known = block_names()
    if name not in known:
        raise unknown("block", name, [*known, *CHIPS])
    return load_block(name)


def unknown(kind: str, name: str, known: Iterable[str]) -> UnknownNameError:
    """Build the error for `name`: the nearest known names, then all of them unless they are many."""
    names = sorted(known)
    name = shown_name(name)  # near names are sought in quadratic time
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.6) or [n for n in names if name in n]
    guess = f"; did you mean {near[0]}?" if near else ""
    if not names:
        return UnknownNameError(f"{kind} {name}: unknown; there is none to choose")
    listed = ", ".join(names) if len(names) <= 20 else f"{', '.join(names[:20])} and {len(names) - 20} more"
    return UnknownNameError(f"{kind} {name}: unknown{guess or ';'} known are {listed}")


def _names(table: Mapping[str, str], group: str) -> list[str]:
    return [*table, *sorted({e.name for e in entry_points(group=group)} - set(table))]


def _load(kind: str, name: str, table: Mapping[str, str], group: str) -> Any:
    if name in table:
        module, attribute = table[name].split(":")
        return getattr(import_module(module), attribute)
    for entry in entry_points(group=group):
        if entry.name == name:
            return entry.load()
    raise unknown(kind, name, _names(table, group))
