"""Systems, experiments and calibrations by command-line name, and blocks and chips as one.

Calibrations are of chips, and of the networks that robots have on theirs. Users add theirs under the entry
points `noctule.systems`, `noctule.experiments` and `noctule.calibrations`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from chips.registry import CHIPS, chip_names, load_chip
from circuits.catalogue import Catalogue, loaded
from circuits.errors import UnknownNameError, unknown_name
from circuits.registry import BLOCKS, block_names, load_block
from netlists.registry import dialect_line, dialect_names

if TYPE_CHECKING:
    from chips.codes import Calibration
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

# What each is, as its own summary says: `noctule list` and a shell's completion load none of them.
SYSTEM_LINES: dict[str, str] = {
    "approach": "bat's sonar that closes in on a target, from transistors up (Cheely & Horiuchi 2003)",
    "rover": "rover that plans by a wave of spikes on a cost map, drives by GPS (Hwu et al. 2018)",
    "forest": "bat in a dense forest by pings in five directions and arcs (Wen & Horiuchi 2022)",
    "spiking-bat": "bat in a dense forest by spike latencies, network or chip (Wen & Horiuchi 2022)",
    "car": "car with a narrow sonar among pipes, by a choice of 15 arcs (Wen & Horiuchi 2022)",
    "head": "sonar head that turns to a moving target by its two ears (Cheely & Horiuchi 2003)",
    "bug": "robot with compass and contact: Bug 0, 1, 2 as programs and neurons (Stöckel 2017)",
    "pushbot": "robot with an event camera, steered by the ROLLS chip (Milde et al. 2017)",
    "rolls": "rates of all neurons of a ROLLS die under equal input",
}

WITHIN: dict[str, str] = {"program": "system.mapping.certify.system:SYSTEM"}
"""What other verbs run as they run systems, and is none of them: no list has it."""

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
    "nef-law": "system.papers.checks.nef_law:EXPERIMENT",
    "rolls-mapping": "system.papers.checks.rolls_mapping:EXPERIMENT",
    "rolls-calibration": "system.papers.checks.rolls_calibration:EXPERIMENT",
    "rolls-field": "system.papers.checks.rolls_field:EXPERIMENT",
    "rolls-drift": "system.papers.checks.rolls_drift:EXPERIMENT",
    "rolls-forms": "system.papers.checks.rolls_forms:EXPERIMENT",
    "rolls-mismatch": "system.papers.checks.rolls_mismatch:EXPERIMENT",
    "rolls-learning": "system.papers.checks.rolls_learning:EXPERIMENT",
    "rolls-depression": "system.papers.checks.rolls_depression:EXPERIMENT",
    "rolls-measured": "system.papers.checks.rolls_measured:EXPERIMENT",
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
    "milde2017-power": "system.papers.milde2017.power:EXPERIMENT",
    "milde2017-temperature": "system.papers.milde2017.temperature:EXPERIMENT",
    "second-order": "system.papers.checks.second_order:EXPERIMENT",
    "ranging-law": "system.papers.checks.ranging_law:EXPERIMENT",
    "wavefront-law": "system.papers.checks.wavefront_law:EXPERIMENT",
    "latency-law": "system.papers.checks.latency_law:EXPERIMENT",
    "choice-law": "system.papers.checks.choice_law:EXPERIMENT",
    "rolls-law": "system.papers.checks.rolls_law:EXPERIMENT",
    "defaults": "system.papers.checks.defaults:EXPERIMENT",
    "variation": "system.papers.checks.variation:EXPERIMENT",
    "mission-yield": "system.papers.checks.mission_yield:EXPERIMENT",
    "blame": "system.papers.checks.blame:EXPERIMENT",
    "blame-robots": "system.papers.checks.blame_robots:EXPERIMENT",
    "agreement": "system.papers.checks.agreement:EXPERIMENT",
    "ngspice-dies": "system.papers.checks.ngspice_dies:EXPERIMENT",
    "random-circuits": "system.papers.checks.random_circuits:EXPERIMENT",
    "foundry-dies": "system.papers.checks.foundry_dies:EXPERIMENT",
    "coach": "system.papers.checks.coach:EXPERIMENT",
    "foundry-blocks": "system.papers.checks.foundry_blocks:EXPERIMENT",
    "coach-synthetic": "system.papers.checks.coach_synthetic:EXPERIMENT",
    "device-noise": "system.papers.checks.device_noise:EXPERIMENT",
    "chip-noise": "system.papers.checks.chip_noise:EXPERIMENT",
}

EXPERIMENT_LINES: dict[str, str] = {
    "cheely2003-fig4": "rebound neuron: delay shorter, longer, and facilitative",
    "cheely2003-fig5": "excitatory postsynaptic current after one echo",
    "cheely2003-fig6": "tuning curves of the 13 neurons from their bias chains",
    "cheely2003-fig8": "envelope board, onset and high-threshold spikes after a vocalization",
    "cheely2003-fig9": "centroid voltage against target distance, linear look-up",
    "cheely2003-fig10": "rate and amplitude of the vocalization against proximity voltage",
    "cheely2003-fig11": "call amplitude and rate while a target approaches, all at transistor level",
    "cheely2003-power": "power of the array with its bias chain",
    "cheely2003-head": "the sonar head follows a moving target by two ears, on 20 dies",
    "hwu2018-fig1": "spike wave at time steps 3 and 18 and paths, without and with a road",
    "hwu2018-fig2": "a collision of waves and its remedy by a second pass",
    "hwu2018-table1": "lengths and costs of paths: spike wave against A* on four maps",
    "hwu2018-table2": "Frechet distances between planned and driven routes: 6 routes, 4 trials, 4 maps",
    "hwu2018-campaign": "regret of the wavefront chip's paths over dies, area, temperature, speed, bias",
    "wen2022-fig5": "two pings among six obstacles: head first, then body",
    "wen2022-fig10": "paths through a dense forest: most of the gaps are taken",
    "wen2022-fig11a": "avoided obstacles against density",
    "wen2022-fig11b": "terms of the desirability against speed",
    "wen2022-fig11c": "immediacy functions against distance",
    "wen2022-fig11d": "immediacy functions against speed",
    "wen2022-fig11e": "ping rates against speed",
    "wen2022-fig12": "the spike-latency network between two pings",
    "wen2022-fig12-chip": "Figure 12 on the latency chip",
    "wen2022-fig13": "flights steered by the spike-latency network and chip",
    "wen2022-fig15": "the sonar robot in three forests of pipes",
    "latency-equations": "(9) and (10): transistors, chip's model, closed form",
    "latency-agreement": "the latency chip's winners against the network's",
    "latency-recall": "recall error of latency chips on dies",
    "latency-forests": "many forests: network, chip and analog model",
    "latency-dies": "crossings by latency chips on dies",
    "latency-loops": "loops of the latency chip, and who repeats them",
    "forest-silicon": "avoided obstacles with chips against area and temperature",
    "forest-weights": "weights by speed against fixed ones",
    "stockel2017-fig5": "state machine of Bug 2: one transition a rising edge",
    "stockel2017-fig6": "Bug 0 repeats its way where Bug 2 reaches the goal, programs and neurons",
    "stockel2017-fig7": "states of Bug 2 over time: neurons take time to memorise",
    "stockel2017-fig8": "a large map: Bug 0 reaches, neural Bug 2 gets stuck, a finer one less often",
    "stockel2017-chip": "Bug 0 and Bug 2 on the NEF chip, on a hundred dies",
    "stockel2017-campaign": "Bug robots on the NEF chip over dies, neurons, area and temperature",
    "nef-chip": "neurons of the NEF chip beside their circuit, errors, decoders",
    "nef-law": "the NEF chip under the full law beside its transistors",
    "rolls-mapping": "ROLLS: rates of drawn networks that are mapped on its dies",
    "rolls-calibration": "ROLLS: eight populations at three rates on 50 dies, and their drift",
    "rolls-field": "ROLLS: a neural field chooses the stronger of two inputs",
    "rolls-drift": "drift of ROLLS with temperature, fixed gates and ideal currents",
    "rolls-forms": "published forms of ROLLS' circuits, and by how much each is off",
    "rolls-mismatch": "spread of ROLLS' neurons and synapses, and what makes it",
    "rolls-learning": "ROLLS: two patterns of mean rates learned by plastic synapses",
    "rolls-depression": "short-term depression of ROLLS over rates, dies, temperature",
    "rolls-measured": "ROLLS in a measured process: what it assumes, its spread, the Pushbot",
    "milde2017-table1": "distance at the obstacle line by speed, turn factor and colour",
    "milde2017-pairs": "two and three blocks at 0.35 m/s",
    "milde2017-variability": "sides taken by one die and by other dies",
    "milde2017-fig5": "matrix of weights on the chip",
    "milde2017-fig6": "populations and commands round one obstacle",
    "milde2017-fig7": "success by light and colour",
    "milde2017-moving": "a cup moved into the way, against a standing one, by speed factor",
    "milde2017-target": "towards a standing robot with a blinking LED",
    "milde2017-chase": "after a robot with a blinking LED",
    "milde2017-clutter": "plain and modified network among many blocks",
    "milde2017-office": "crashes a minute in an office",
    "milde2017-power": "power of ROLLS as the Pushbot drives, by block",
    "milde2017-temperature": "avoidance against temperature, by kind of bias",
    "second-order": "what second-order effects of silicon do to every block",
    "ranging-law": "the ranging chip's neuron under the full law against its transistors",
    "wavefront-law": "the wavefront chip under the full law against its transistors",
    "latency-law": "the latency chip under the full law against its transistors",
    "choice-law": "selection and head's neurons under the full law against their transistors",
    "rolls-law": "what the full law moves in a ROLLS chip",
    "defaults": "what the full law and the bias generator make of every robot",
    "variation": "what gradients, wafers and lots make of a neuron and of the approach",
    "mission-yield": "dies on which every robot does what it is for, calibrated or not",
    "blame": "devices that mend failing dies of the approach, and planted faults",
    "blame-robots": "devices that mend failing dies of a Pushbot, a forest's bat and a spiking bat",
    "agreement": "solver against ngspice: every block at three temperatures, and the ranging chip",
    "ngspice-dies": "20 dies of the rebound neuron, class and edges in the solver and in ngspice",
    "random-circuits": "random circuits of up to 12 devices in the solver and in ngspice",
    "foundry-dies": "a foundry's dies by our keys, and our law beside its cards",
    "coach": "a process and a die from a teaching chip's measurements, each left out in turn",
    "foundry-blocks": "every block on a foundry's cards, its class and its first number",
    "coach-synthetic": "measurements of known dies of the teaching chip, each fitted alone",
    "device-noise": "k T / C, small signals and noise beside ngspice, jitter of the rebound neuron",
    "chip-noise": "jitter of ROLLS, NEF, latency and sonar chips beside that of their transistors",
}

CALIBRATIONS: dict[str, str] = {
    "nef-chip": "chips.nef.calibration:CALIBRATION",
    "latency-chip": "system.spiking_bat.chip_brain:CALIBRATION",
    "lso-chip": "system.head.scenario:CALIBRATION",
    "hearing": "chips.hearing.calibration:CALIBRATION",
    "ranging-chip": "chips.ranging.calibration.calibrate:CALIBRATION",
    "pushbot": "system.pushbot.network.codes:CALIBRATION",
    "pushbot-modified": "system.pushbot.network.codes:MODIFIED_CALIBRATION",
    "rolls": "system.rolls.codes:CALIBRATION",
    "selection-chip": "system.openspace.selecting:CALIBRATION",
    "wavefront-chip": "chips.wavefront.calibration:CALIBRATION",
}

# What each is, as its own summary says: `noctule list` and a shell's completion load none of them.
CALIBRATION_LINES: dict[str, str] = {
    "nef-chip": "rates of neurons, time constants and outputs of filters, the reference",
    "pushbot": "rates of the Pushbot's populations on ROLLS, plain network",
    "pushbot-modified": "rates of obstacle and drive populations of the modified network",
    "latency-chip": "times of taps, integrating neurons, cells and pulses of the latency chip",
    "lso-chip": "spikes a decibel of the sonar head's two neurons, and where left and right agree",
    "hearing": "level by which the hearing's onset neuron hears after silence",
    "ranging-chip": "windows of the ranging chip's neurons: their width, and where they stand",
    "rolls": "mean rate of a ROLLS die's neurons, and those that cannot be used",
    "selection-chip": "tail of the selection, and what the board gives its cells so that equals tie",
    "wavefront-chip": "unit of delay of the wavefront chip, and the codes of its cells",
}

_systems: Catalogue[System[Any, Any]] = Catalogue(
    "system", SYSTEMS, "noctule.systems", ("system.system:System",), SYSTEM_LINES
)
_experiments: Catalogue[Experiment] = Catalogue(
    "experiment", EXPERIMENTS, "noctule.experiments", ("system.experiment:Experiment",), EXPERIMENT_LINES
)
_calibrations: Catalogue[Calibration] = Catalogue(
    "calibration", CALIBRATIONS, "noctule.calibrations", ("chips.codes:Calibration",), CALIBRATION_LINES
)

system_names, system_line = _systems.names, _systems.line
experiment_names, experiment_line = _experiments.names, _experiments.line
calibration_names, load_calibration = _calibrations.names, _calibrations.load
calibration_line = _calibrations.line
_OF_FILE = ".py:"  # in a name in a user's file

XSCHEM = "xschem"  # a drawing, and no netlist's dialect
XSCHEM_LINE = "a schematic with xschem's own symbols; not run here"


def load_experiment(name: str) -> Experiment:
    """Load the experiment that is called `name`, or that `FILE.py:NAME` names.

    Raises
    ------
    UnknownNameError
        No experiment has the name.
    ParameterError
        It is an entry point, or a file, that leads to no experiment.
    """
    own = _of_file(name, "system.experiment:Experiment")
    found: Experiment = _experiments.load(name) if own is None else own
    return found


def _of_file(name: str, kind: str) -> Any:
    """What `FILE.py:NAME` names, which is of a kind, as `"module:class"`; None for another name."""
    if _OF_FILE not in name:
        return None
    return loaded("system.options.code:load_as")(name, loaded(kind))


def load_system(name: str) -> System[Any, Any]:
    """Load the system that is called `name`, or that `FILE.py:NAME` names.

    Raises
    ------
    UnknownNameError
        No system has the name.
    ParameterError
        It is an entry point, or a file, that leads to no system.
    """
    if name in WITHIN:
        within: System[Any, Any] = loaded(WITHIN[name])
        return within
    _check_name("system", name)
    own = _of_file(name, "system.system:System")
    found: System[Any, Any] = _systems.load(name) if own is None else own
    return found


def _check_name(kind: str, name: str) -> None:
    """Raise `UnknownNameError` for a name that another stands for now, and for one of the other kind."""
    if name in FORMER:
        raise UnknownNameError(f"{kind} {name}: is called {FORMER[name]} now; take that name")
    if kind == "block" and name in system_names():
        raise UnknownNameError(f"{name}: is a system, must be a block or chip; noctule run {name} runs it")
    if kind == "system" and name not in system_names() and name in block_and_chip_names():
        raise UnknownNameError(f"{name}: is a block or chip, must be a system; noctule show {name} shows it")


def written_names() -> list[str]:
    """Names of all that a circuit is written as: dialects of netlists, and the drawing of xschem."""
    return [*dialect_names(), XSCHEM]


def written_line(name: str) -> str:
    """Say what a dialect, or the drawing, is in a line."""
    return XSCHEM_LINE if name == XSCHEM else dialect_line(name)


def block_and_chip_names() -> list[str]:
    """Names of all blocks and of all chips."""
    return [*block_names(), *chip_names()]


def target_names() -> list[str]:
    """Names of all that a study can be of: blocks, chips and systems; a name that two have is given once."""
    return [*dict.fromkeys((*block_and_chip_names(), *system_names()))]


def check_target(name: str) -> None:
    """Raise `UnknownNameError`, which suggests near names, for what is no block, chip or system."""
    if name not in target_names():
        _check_name("system", name)
        raise unknown_name("block, chip or system", name, target_names())


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
