"""Systems and experiments by command-line name, and blocks and chips as one.

Users add theirs under the entry points `noctule.systems` and `noctule.experiments`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from chips.registry import CHIPS, chip_names, load_chip
from circuits.catalogue import Catalogue
from circuits.errors import UnknownNameError, unknown_name
from circuits.registry import BLOCKS, block_names, load_block

if TYPE_CHECKING:
    from chips.registry import Chip
    from circuits.blocks.block import Block
    from system.experiment import Experiment
    from system.system import System

SYSTEMS: dict[str, str] = {
    "approach": "system.approach.run:SYSTEM",
    "rover": "system.rover.run:SYSTEM",
    "forest": "system.forest.run:SYSTEM",
    "spiking-bat": "system.spiking_bat.run:SYSTEM",
    "car": "system.car.run:SYSTEM",
    "head": "system.head.run:SYSTEM",
    "bug": "system.bug.run:SYSTEM",
    "pushbot": "system.pushbot.run:SYSTEM",
    "rolls": "system.rolls.run:SYSTEM",
}

LINES: dict[str, str] = {  # what each does, for a help that waits for none of them
    "approach": "A bat's sonar closes in on targets (Cheely & Horiuchi 2003).",
    "rover": "A rover plans on a delay-line chip and drives the way (Hwu et al. 2018).",
    "forest": "A bat flies through a dense forest by narrow pings (Wen & Horiuchi 2022).",
    "spiking-bat": "A bat flies through a dense forest by spike latencies (Wen & Horiuchi 2022).",
    "car": "A car with a narrow sonar drives through pipes (Wen & Horiuchi 2022).",
    "head": "A sonar head turns to a moving target by its two ears (Cheely & Horiuchi 2003).",
    "bug": "A robot with a compass and contact follows walls to its goal (Stöckel 2017).",
    "pushbot": "A robot avoids obstacles by an event camera and the ROLLS chip (Milde et al. 2017).",
    "rolls": "All neurons of a ROLLS die under equal input.",
}

FORMER = {"robot": "car"}  # names of systems that have another now

EXPERIMENTS: dict[str, str] = {
    "cheely2003-fig4": "system.papers.cheely2003.fig4:EXPERIMENT",
    "cheely2003-fig5": "system.papers.cheely2003.fig5:EXPERIMENT",
    "cheely2003-fig6": "system.papers.cheely2003.fig6:EXPERIMENT",
    "cheely2003-fig8": "system.papers.cheely2003.fig8:EXPERIMENT",
    "cheely2003-fig9": "system.papers.cheely2003.fig9:EXPERIMENT",
    "cheely2003-fig10": "system.papers.cheely2003.fig10:EXPERIMENT",
    "cheely2003-fig11": "system.papers.cheely2003.fig11:EXPERIMENT",
    "cheely2003-power": "system.papers.cheely2003.power:EXPERIMENT",
    "cheely2003-head": "system.papers.cheely2003.head:EXPERIMENT",
    "hwu2018-fig1": "system.papers.hwu2018.fig1:EXPERIMENT",
    "hwu2018-fig2": "system.papers.hwu2018.fig2:EXPERIMENT",
    "hwu2018-table1": "system.papers.hwu2018.table1:EXPERIMENT",
    "hwu2018-table2": "system.papers.hwu2018.table2:EXPERIMENT",
    "hwu2018-campaign": "system.papers.hwu2018.campaign:EXPERIMENT",
    "wen2022-fig5": "system.papers.wen2022.fig5:EXPERIMENT",
    "wen2022-fig10": "system.papers.wen2022.fig10:EXPERIMENT",
    "wen2022-fig11a": "system.papers.wen2022.fig11a:EXPERIMENT",
    "wen2022-fig11b": "system.papers.wen2022.fig11b:EXPERIMENT",
    "wen2022-fig11c": "system.papers.wen2022.fig11c:EXPERIMENT",
    "wen2022-fig11d": "system.papers.wen2022.fig11d:EXPERIMENT",
    "wen2022-fig11e": "system.papers.wen2022.fig11e:EXPERIMENT",
    "wen2022-fig12": "system.papers.wen2022.fig12:EXPERIMENT",
    "wen2022-fig12-chip": "system.papers.wen2022.fig12_chip:EXPERIMENT",
    "wen2022-fig13": "system.papers.wen2022.fig13:EXPERIMENT",
    "wen2022-fig15": "system.papers.wen2022.fig15:EXPERIMENT",
    "latency-equations": "system.papers.wen2022.equations:EXPERIMENT",
    "latency-agreement": "system.papers.checks.latency_agreement:EXPERIMENT",
    "latency-recall": "system.papers.checks.latency_recall:EXPERIMENT",
    "latency-forests": "system.papers.checks.latency_forests:EXPERIMENT",
    "latency-dies": "system.papers.checks.latency_dies:EXPERIMENT",
    "latency-loops": "system.papers.checks.latency_loops:EXPERIMENT",
    "forest-silicon": "system.papers.checks.forest_silicon:EXPERIMENT",
    "forest-weights": "system.papers.checks.forest_weights:EXPERIMENT",
    "stockel2017-fig5": "system.papers.stockel2017.fig5:EXPERIMENT",
    "stockel2017-fig6": "system.papers.stockel2017.fig6:EXPERIMENT",
    "stockel2017-fig7": "system.papers.stockel2017.fig7:EXPERIMENT",
    "stockel2017-fig8": "system.papers.stockel2017.fig8:EXPERIMENT",
    "stockel2017-chip": "system.papers.stockel2017.chip:EXPERIMENT",
    "stockel2017-campaign": "system.papers.stockel2017.campaign:EXPERIMENT",
    "nef-chip": "system.papers.checks.nef_chip:EXPERIMENT",
    "rolls-calibration": "system.papers.checks.rolls_calibration:EXPERIMENT",
    "rolls-field": "system.papers.checks.rolls_field:EXPERIMENT",
    "rolls-drift": "system.papers.checks.rolls_drift:EXPERIMENT",
    "rolls-forms": "system.papers.checks.rolls_forms:EXPERIMENT",
    "rolls-mismatch": "system.papers.checks.rolls_mismatch:EXPERIMENT",
    "rolls-learning": "system.papers.checks.rolls_learning:EXPERIMENT",
    "rolls-depression": "system.papers.checks.rolls_depression:EXPERIMENT",
    "milde2017-table1": "system.papers.milde2017.table1:EXPERIMENT",
    "milde2017-pairs": "system.papers.milde2017.pairs:EXPERIMENT",
    "milde2017-variability": "system.papers.milde2017.variability:EXPERIMENT",
    "milde2017-fig5": "system.papers.milde2017.fig5:EXPERIMENT",
    "milde2017-fig6": "system.papers.milde2017.fig6:EXPERIMENT",
    "milde2017-fig7": "system.papers.milde2017.fig7:EXPERIMENT",
    "milde2017-moving": "system.papers.milde2017.moving:EXPERIMENT",
    "milde2017-target": "system.papers.milde2017.target:EXPERIMENT",
    "milde2017-chase": "system.papers.milde2017.chase:EXPERIMENT",
    "milde2017-clutter": "system.papers.milde2017.clutter:EXPERIMENT",
    "milde2017-office": "system.papers.milde2017.office:EXPERIMENT",
    "milde2017-temperature": "system.papers.milde2017.temperature:EXPERIMENT",
    "agreement": "system.papers.checks.agreement:EXPERIMENT",
    "ngspice-dies": "system.papers.checks.ngspice_dies:EXPERIMENT",
    "device-noise": "system.papers.checks.device_noise:EXPERIMENT",
    "chip-noise": "system.papers.checks.chip_noise:EXPERIMENT",
}

_systems: Catalogue[System[Any, Any]] = Catalogue(
    "system", SYSTEMS, "noctule.systems", ("system.system:System",)
)
_experiments: Catalogue[Experiment] = Catalogue(
    "experiment", EXPERIMENTS, "noctule.experiments", ("system.experiment:Experiment",)
)

system_names = _systems.names
experiment_names, load_experiment = _experiments.names, _experiments.load


def load_system(name: str) -> System[Any, Any]:
    """Load the system that is called `name`.

    Raises
    ------
    UnknownNameError
        No system has the name.
    ParameterError
        It is an entry point that leads to no system.
    """
    _check_name("system", name)
    return _systems.load(name)


def system_line(name: str) -> str:
    """What a system does, in a line; a user's own, whose line is its summary, is loaded for it."""
    return LINES[name] if name in LINES else load_system(name).summary


def _check_name(kind: str, name: str) -> None:
    """Raise `UnknownNameError` for a name that another stands for now."""
    if name in FORMER:
        raise UnknownNameError(f"{kind} {name}: is called {FORMER[name]} now; take that name")


def load_block_or_chip(name: str) -> Block | Chip:
    """Load a block or a chip; raises `UnknownNameError` with near names."""
    if name in BLOCKS:
        return load_block(name)
    if name in CHIPS:
        return load_chip(name)
    blocks, chips = block_names(), chip_names()
    if name not in (*blocks, *chips):
        _check_name("block", name)
        raise unknown_name("block", name, [*blocks, *chips])
    return load_chip(name) if name in chips else load_block(name)
