"""A foundry's own silicon, gf180mcu: its statistics by our keys, and our law fitted to its cards.

No paper has it. In these rows `paper` is the foundry's figure, of its cards in ngspice. The foundry's cards,
corners and statistics come from its package; nothing but the extraction is fitted.

- Lone devices of 2 um by 1 um: the spread of our 20,000 draws of V_T beside the foundry's law; the spread of
  the current, in weak and in strong inversion, beside that of 20,000 of the foundry's sub-circuits whose
  `agauss` ngspice draws itself; and with what dies share, 400 dies of either.
- A die of a neuron: its spikes as a study measures them, alone, and from its netlist.
- Our law: how far its drain current is off the cards at sizes that were not fitted, and a neuron's period.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from circuits.arrays import F64
from circuits.devices import Transistor
from circuits.extraction.fit import distance
from circuits.silicon.die import Die
from circuits.silicon.process import POLARITIES, Polarity
from circuits.silicon.process_file import foundry_process
from circuits.silicon.silicon import Deviation, Silicon
from circuits.solver.transient import simulate
from netlists.foundry import engine
from netlists.foundry.die import law_of, own_deviation, unit_silicon
from netlists.foundry.extract import HELD_OUT_UM, RANGE, curves
from netlists.foundry.lone import currents, own_currents
from netlists.foundry.process import DeviceMapping, read_foundry
from netlists.ngspice import run as ngspice
from netlists.ngspice.engine import upward_crossings
from netlists.registry import Settings
from system.experiment import Experiment, Progress, Report
from system.options.block import Choice, choose
from system.options.silicon import SiliconChoice
from system.plot import COLOURS, entitle
from system.rule import at_most, exactly, unjudged, within_share
from system.statement import Statement
from system.study.table import Condition
from system.study.target import Subject, open_target

PROCESS = "gf180mcu"
DEVICES, DIES, FIRST_DIE = 20_000, 400, 1000
SIZE = (2e-6, 1e-6)  # m
VOLTS = {"n": (0.5, 1.5, 1.65), "p": (0.6, 1.5, 1.65)}  # gates in weak and strong inversion, drain
REGIONS = ("weak", "strong")
NEURON, ALONE = "tonic-neuron", ("inhibit=off",)
DURATIONS = {-20.0: "400ms", 27.0: "60ms", 85.0: "15ms"}  # some periods at each temperature, degC


@dataclass(frozen=True, slots=True)
class Spread:
    """Logarithms of currents of a polarity, by our draws and by the foundry's, float64[2, n] each."""

    polarity: Polarity
    ours: F64
    foundry: F64


def reproduce(progress: Progress, devices: int = DEVICES, dies: int = DIES) -> Report:
    """Draw devices and dies, run a die three ways, and hold our law against the cards.

    Parameters
    ----------
    progress
        Is told the share that is done.
    devices
        How many lone devices are drawn.
    dies
        How many dies are drawn of a lone device with what a die shares.
    """
    mapping = read_foundry(PROCESS)
    rows: list[Statement] = []
    spreads = []
    for k, polarity in enumerate(POLARITIES):
        rows.append(_threshold(mapping, polarity, devices))
        spreads.append(_spread(mapping, polarity, devices))
        rows += [*_mismatch_rows(spreads[-1]), *_both_rows(mapping, polarity, dies)]
        progress(0.35 * (k + 1))
    rows += _one_die()
    progress(0.75)
    for polarity in POLARITIES:
        rows += _law_rows(mapping, polarity)
    rows += _period_rows()
    progress(1.0)
    return Report(tuple(rows), lambda figure: draw(spreads, figure))


def _device(polarity: Polarity) -> Transistor:
    return Transistor("m", polarity, "d", "g", "s", "b", *SIZE)


def own_deviations(mapping: DeviceMapping, die: Die, polarity: Polarity, count: int) -> list[Deviation]:
    """Deviations of the devices of an array on a die.

    Parameters
    ----------
    mapping
        The foundry's process.
    die
        The die.
    polarity
        `n` or `p`.
    count
        How many devices the array has.
    """
    silicon = Silicon(foundry_process(PROCESS), die=die)
    path = (("array", (count,)), ("m", ()))
    unit = unit_silicon(silicon).deviation("lone", path, np.full(count, SIZE[0] * SIZE[1]), polarity)
    pairs = zip(np.asarray(unit.v_t0), np.asarray(unit.beta), strict=True)
    return [own_deviation(mapping, silicon, _device(polarity), Deviation(v, b)) for v, b in pairs]


def _threshold(mapping: DeviceMapping, polarity: Polarity, count: int) -> Statement:
    """Spread of our draws of V_T beside the foundry's law."""
    own = own_deviations(mapping, Die(number=FIRST_DIE, process=False), polarity, count)
    found = float(np.std(np.array([float(each.v_t0) for each in own])))
    law = law_of(mapping, polarity).sigma(*SIZE)[0]
    rule = within_share(0.03, f"within {{percent:g}} % of the foundry's law, {count} draws")
    return Statement(f"{polarity}fet_threshold_sigma_V", law, found, rule)


def _spread(mapping: DeviceMapping, polarity: Polarity, count: int) -> Spread:
    die = Die(number=FIRST_DIE, process=False)
    own = own_deviations(mapping, die, polarity, count)
    device, volts = _device(polarity), VOLTS[polarity]
    ours = np.log(currents(device, mapping, volts, die, own))
    theirs = np.log(own_currents(device, mapping, volts, count, seed=FIRST_DIE))
    return Spread(polarity, ours, theirs)


def _mismatch_rows(spread: Spread) -> Iterator[Statement]:
    """Spread of the current of lone devices by mismatch alone."""
    for region, ours, theirs in zip(REGIONS, spread.ours, spread.foundry, strict=True):
        rule = within_share(0.03, f"within {{percent:g}} % of ngspice's own, {spread.ours.shape[1]} devices")
        yield Statement(f"{spread.polarity}fet_{region}_current_sigma", _sigma(theirs), _sigma(ours), rule)


def _both_rows(mapping: DeviceMapping, polarity: Polarity, dies: int) -> Iterator[Statement]:
    """Spread of the current of one device over dies, mismatch and process together."""
    device, volts = _device(polarity), VOLTS[polarity]
    ours, theirs = [], []
    for number in range(FIRST_DIE, FIRST_DIE + dies):
        die = Die(number=number)
        ours.append(currents(device, mapping, volts, die, own_deviations(mapping, die, polarity, 1)))
        theirs.append(own_currents(device, mapping, volts, 1, seed=number, process=True))
    both = (np.log(np.concatenate(found, axis=1)) for found in (ours, theirs))
    for region, one, other in zip(REGIONS, *both, strict=True):
        # three standard errors of the ratio of two deviations of so many dies
        rule = within_share(0.15, f"within {{percent:g}} % of ngspice's own, {dies} dies of either")
        yield Statement(f"{polarity}fet_{region}_current_sigma_of_dies", _sigma(other), _sigma(one), rule)


def _sigma(logarithms: F64) -> float:
    return float(np.std(logarithms))


def _one_die() -> list[Statement]:
    """The period of a neuron on a die: in a study's batch, in a run by itself, from its netlist."""
    number = FIRST_DIE + 3
    stimuli = (*ALONE, f"duration={DURATIONS[27.0]}")
    silicon = SiliconChoice(process=PROCESS)
    subject = Subject(NEURON, ("period_s",), stimuli=stimuli, silicon=silicon, engine="ngspice")
    target = open_target(subject)
    condition = Condition("random", 27.0, 0)
    measured = [target.measure(Die(number=n), condition) for n in (number + 1, number)]
    batch = measured[-1].values[0]  # after another die
    choice = _neuron(number)
    alone = engine.simulate(choice.testbench(), choice.silicon)
    period = choice.block.measured(alone)["period_s"]
    first, exported = alone.spikes["spike"], _exported(choice)
    apart = float(np.abs(first - exported).max()) if first.size == exported.size else float("inf")
    return [
        Statement("period_in_a_batch_less_alone_s", None, batch - float(period or np.nan), exactly(0.0)),
        Statement("spikes_alone_less_netlist_s", None, apart, at_most(0.0, "at most {limit:g} s apart")),
    ]


def _neuron(number: int | None, celsius: float = 27.0) -> Choice:
    """The neuron, which nothing inhibits, on a die at a temperature, degC."""
    silicon = SiliconChoice(process=PROCESS, die=number, temperature=f"{celsius:g}")
    return choose(NEURON, silicon=silicon, stimuli=(*ALONE, f"duration={DURATIONS[celsius]}"))


def _exported(choice: Choice) -> F64:
    """Spikes of the netlist that is exported, run by ngspice from its file, s."""
    bench = engine.on_cards(choice.testbench(), choice.silicon)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "die.cir"
        path.write_text(engine.deck_of(bench, choice.silicon, Settings(reltol=engine.RELTOL)))
        found = ngspice.run(path.read_text(), vectors=("spike",))
    return upward_crossings(found.axis, found.values["spike"], 0.5 * choice.silicon.process.v_dd)


def _law_rows(mapping: DeviceMapping, polarity: Polarity) -> Iterator[Statement]:
    """How far our law's drain current is off at sizes that were not fitted."""
    process = foundry_process(PROCESS)
    points = curves(mapping, polarity, HELD_OUT_UM).between(*RANGE)
    away = distance(process.model(polarity), process, points)
    where = f"{away.points} currents of {len(HELD_OUT_UM)} sizes, {RANGE[0]:g} to {RANGE[1]:g} A"
    text = f"at most {{percent:g}} %, {where}"
    yield Statement(f"{polarity}fet_law_off_median", None, away.median, at_most(0.10, text))
    where = f"worst, {away.where['current']:.2g} A at {away.where['temperature_c']:g} degC"
    yield Statement(f"{polarity}fet_law_off_worst", None, abs(away.worst), unjudged(where))


def _period_rows() -> Iterator[Statement]:
    """Period of the neuron by our law in the solver, beside the cards in ngspice."""
    for celsius in DURATIONS:
        choice = _neuron(None, celsius)
        bench = choice.testbench()
        cards = choice.block.measured(engine.simulate(bench, choice.silicon))["period_s"]
        ours = choice.block.measured(simulate(bench, choice.silicon))["period_s"]
        name = f"period_at_{'minus_' if celsius < 0 else ''}{abs(celsius):g}_degC_s"
        yield Statement(name, cards, ours, within_share(0.10))


def draw(spreads: list[Spread], figure: Figure) -> None:
    """Fill `figure` with the spread of currents of lone devices, ours and the foundry's.

    Parameters
    ----------
    spreads
        Of both polarities.
    figure
        The figure.
    """
    figure.set_size_inches(9.0, 6.0)
    grid = figure.subplots(len(spreads), len(REGIONS), squeeze=False)
    for axes, spread in zip(grid, spreads, strict=True):
        for ax, region, ours, theirs in zip(axes, REGIONS, spread.ours, spread.foundry, strict=True):
            middle = np.median(theirs)
            bins = np.linspace(-4.0, 4.0, 61) * _sigma(theirs)
            ax.hist(theirs - middle, bins, color=COLOURS[1], alpha=0.5, label="ngspice's own")
            ax.hist(ours - middle, bins, histtype="step", color=COLOURS[0], label="our keys")
            ax.set_xlabel("ln(current / median)")
            entitle(f"{spread.polarity}FET, {region} inversion", ax)
    grid[0, 0].legend(fontsize=8)


EXPERIMENT = Experiment(
    "foundry-dies", "a foundry's dies by our keys, and our law beside its cards", reproduce
)
