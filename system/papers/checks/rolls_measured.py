"""What the process that ROLLS' models assume is beside the one of a measured chip, and what that changes.

No figure of a paper. ROLLS' own process is not public, and `rolls-180` stands for it. The measurements of a
teaching chip of the same generation (`noctule reproduce coach`) fix the same numbers; `coach-180` is our law
fitted to them. In these rows `paper` is what `rolls-180` gives and `ours` what the measured process gives;
the rule tells by how much they differ, and none passes or fails.

Numbers of the law are those of the fit of today, of 4 um by 4 um and 1 um by 1 um; their standard errors are
those of draws from what it left. What follows is in `coach-180`: the spread of ROLLS' parts as in
`rolls-mismatch`, its currents the same in both processes, with the matching of `rolls-180` replaced alone
too, and the Pushbot, which drives past one block on dies that tuned nothing, with the codes of its own table
and with each die's own calibration. No weight, code table or goal is tuned to the measured process.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from chips.rolls.program.bias_file import default_biases
from chips.rolls.spread import parts_of, predicted
from circuits.arrays import F64
from circuits.blocks.mos import mos
from circuits.devices.transistor import drain_current
from circuits.extraction.coach.bench import process_of as drawn_process
from circuits.extraction.coach.chip import Chip, extract_chip
from circuits.extraction.coach.conditions import read_conditions
from circuits.extraction.coach.readings.converter import BITS, bit_weights
from circuits.extraction.coach.table import read_folder
from circuits.generator.voltage import Line, lines_at_rest, resistor_of
from circuits.silicon.die import NOMINAL, Die
from circuits.silicon.process import POLARITIES, ROLLS_180, Process
from circuits.silicon.process_file import process_of
from circuits.silicon.silicon import Silicon
from system.experiment import Experiment, Progress, Report
from system.options.codes import CALIBRATED, DEFAULT
from system.plot import COLOURS, INK
from system.pushbot.campaign import Drive, Runs, Summary, drive_repeats, mean_sd, share_of, summaries_of
from system.pushbot.scenario import Scenario
from system.rule import unjudged
from system.statement import Statement
from system.study.campaign import ALONE, Execution

MEASURED = "coach-180"
DRIVES, DIES = 20, 10  # of a cell; ours
DRAWS = 200  # from what the fit left; ours
GENERATORS = range(1000, 1020)  # dies whose code errors are looked at
SOURCES = (0.05, 1.04)  # V, between which the source of the measured nFET was moved
RANGE = 3  # coarse code whose current, 50 nA, is nearest to the 30 nA of the calibrations
_WEIGHED = slice(2, 5)  # bits that the others are put in relation to
_RATES = ("rate_OL_Hz", "rate_OR_Hz", "rate_DL_Hz", "rate_DR_Hz", "rate_sp_Hz")
_SHARES = ("collided", "crossed")
_UM = 1e-6  # m
_PLACE = (("chip", ()),)
_DIODE = mos("m", "n", "d", "g", "s", 6.0, 6.0)

_NAMES = (ROLLS_180.name, MEASURED)
_BASE = Scenario()

Groups = Mapping[tuple[str, str], Sequence[Summary]]


def reproduce(
    progress: Progress, execution: Execution = ALONE, drives: int = DRIVES, dies: int = DIES,
    names: Sequence[str] | None = None, parts: Sequence[str] | None = None,
    kinds: Sequence[str] = (DEFAULT, CALIBRATED), base: Scenario = _BASE,
) -> Report:  # fmt: skip
    """Compare both processes, the spread of ROLLS' parts in them, and the Pushbot's drives.

    Parameters
    ----------
    progress, execution
        Is told the share that is done; who makes the drives, and where they are kept.
    drives, dies
        How many of a cell, and on how many dies.
    names
        The chip's measurements that are fitted; all unless given.
    parts
        Parts of ROLLS whose spread is looked at; all unless given.
    kinds
        Which codes the Pushbot drives with.
    base
        Its drive.
    """
    known = read_conditions()
    data = {n: d for n, d in read_folder(None, "fit", known).items() if names is None or n in names}
    chip = extract_chip(data, known, ROLLS_180, MEASURED)
    progress(0.2)
    spreads = [_spread(process, parts) for process in _processes()]
    progress(0.3)
    cells = {(p, codes): Drive(replace(base, process=p, codes=codes)) for codes in kinds for p in _NAMES}
    driven = drive_repeats(
        execution, EXPERIMENT.name, cells, Runs(drives, dies), Runs(DRIVES, DIES),
        lambda share: progress(0.3 + 0.7 * share),
    )  # fmt: skip
    found = summaries_of(driven)
    progress(1.0)
    rows = (*_assumed(chip), *_codes(chip), *_spreads(spreads), *_pushbot(found, kinds))
    return Report(rows, lambda figure: draw(spreads, found, figure))


def _processes() -> tuple[Process, Process, Process]:
    """That of ROLLS' models, the same with the measured matching, and the measured one."""
    measured = process_of(MEASURED)
    return ROLLS_180, replace(ROLLS_180, pair_a_vt=measured.pair_a_vt), measured


def numbers_of(process: Process) -> dict[str, float]:
    """Numbers of a process by names that end with their unit, as the rows have them.

    Parameters
    ----------
    process
        A process with all its second-order effects.
    """
    found = {"pair_a_vt_mV_um": 1e9 * process.pair_a_vt}
    for polarity in POLARITIES:
        law = Silicon(process).law(polarity)
        square = law.of_size(4.0 * _UM, 4.0 * _UM)
        for um in (4.0, 1.0):
            own, size = law.of_size(um * _UM, um * _UM), f"{polarity}_{um:g}_um"
            found[f"kappa_{size}"] = own.kappa
            found[f"threshold_{size}_V"] = own.v_t0
            found[f"early_voltage_{size}_V"] = own.early_field * um * _UM
            fold = own.kappa * own.v_t0 / own.u_t
            found[f"current_without_gate_{size}_pA"] = 1e12 * own.square_current * math.exp(-fold)
        for volts in SOURCES:
            root = math.sqrt(square.surface_potential + volts)
            found[f"source_over_gate_{polarity}_4_um_at_{volts:g}_V"] = 1.0 / (
                1.0 + square.gamma / (2.0 * root)
            )
        found[f"mobility_reduction_{polarity}_per_V"] = law.mobility_reduction
    return found


def _assumed(chip: Chip) -> Iterator[Statement]:
    """Numbers of the process, each with the standard error that draws from the fit give it."""
    posterior, base = chip.fit.posterior, replace(ROLLS_180, pair_a_vt=chip.process.pair_a_vt)
    normals = np.random.default_rng(0).standard_normal((DRAWS, len(posterior.names)))
    drawn = [numbers_of(drawn_process(values, base)) for values in posterior.draws(normals)]
    ours = numbers_of(chip.process)
    for name, value in numbers_of(ROLLS_180).items():
        error = float(np.std([each[name] for each in drawn]))
        if name.startswith("pair_a_vt"):
            error = 0.0 if chip.a_vt is None else 1e9 * chip.a_vt[1]
        yield _beside(name, value, ours[name], f", {_errors(ours[name] - value, error)}", fitted=True)


def _beside(name: str, theirs: float, ours: float, more: str = "", *, fitted: bool = False) -> Statement:
    off = f"off by {100.0 * (ours / theirs - 1.0):+.3g} %" if theirs else f"off by {ours:.3g}"
    return Statement(name, theirs, ours, unjudged(f"{off}{more}"), fitted=fitted)


def _errors(off: float, error: float) -> str:
    return f"{abs(off) / error:.2g} standard errors of {error:.2g}" if error > 0.0 else "of no known error"


def _codes(chip: Chip) -> Iterator[Statement]:
    """What bits of the fine codes are worth, over bits 2 to 4: the chip's lines, and ROLLS' dies."""
    values = chip.fit.posterior.values()
    lines = sorted({n.removesuffix(" bit 0") for n in values if n.endswith(("_N bit 0", "_P bit 0"))})
    if not lines:
        return
    measured = np.array([bit_weights(values, line) for line in lines])
    dies = code_weights(ROLLS_180, [Die(number=k, process=False) for k in GENERATORS])
    nominal = code_weights(ROLLS_180, [NOMINAL])[0]
    ours = _related(measured)
    for k in range(BITS):
        lines_sd, dies_sd = (float(each[:, k].std(ddof=1)) for each in (ours, dies))
        said = f"; lines of the chip spread by {100 * lines_sd:.2g} %, dies of ROLLS by {100 * dies_sd:.2g} %"
        yield _beside(f"bit_{k}_weight", float(nominal[k]), float(ours[:, k].mean()), said, fitted=True)


def code_weights(process: Process, dies: Sequence[Die]) -> F64:
    """What bits of a line's fine code are worth over bits 2 to 4, in ROLLS' generator, float64[dies, bits].

    Parameters
    ----------
    process
        Its process.
    dies
        Each die's line `line[0]` is looked at, of which all bits share mirror and output device.
    """
    resistance, found = resistor_of(process), np.empty((len(dies), BITS))
    law = Silicon(process).law("n")
    for k, die in enumerate(dies):
        silicon = Silicon(process, die=die, place=_PLACE)
        for bit in range(BITS):
            line = Line(_PLACE, "line", (1,), (0,), _DIODE)
            gate = lines_at_rest(line, ((RANGE, 1 << bit),), silicon, resistance).voltages[line.node]
            found[k, bit] = drain_current(law, "n", 6.0 * _UM, 6.0 * _UM, 1.0, gate, 0.0)[0] / 2.0**bit
    return _related(found)


def _related(weights: F64) -> F64:
    return np.asarray(weights / weights[:, _WEIGHED].mean(axis=1, keepdims=True))


def _spread(process: Process, names: Sequence[str] | None) -> dict[str, float]:
    """CV of each quantity of ROLLS' parts by mismatch alone."""
    silicon = Silicon(process)
    found: dict[str, float] = {}
    for part in [p for p in parts_of(default_biases(), silicon) if names is None or p.name in names]:
        found |= {name: spread.cv for name, spread in predicted(part, process, silicon).items()}
    return found


def _spreads(found: Sequence[Mapping[str, float]]) -> Iterator[Statement]:
    assumed, matching, measured = found
    for name, cv in assumed.items():
        more = f", of which the matching alone {100.0 * (matching[name] / cv - 1.0):+.3g} %"
        yield _beside(f"{name.replace(' ', '_')}_cv", cv, measured[name], more)


def _pushbot(groups: Groups, kinds: Sequence[str]) -> Iterator[Statement]:
    for codes in kinds:
        theirs, ours = (groups[name, codes] for name in _NAMES)
        for name in _SHARES:
            one, other = share_of(theirs, name), share_of(ours, name)
            text = f"{other.passed} of {other.of} drives, for {one.passed} of {one.of}"
            yield Statement(f"{codes}_codes_{name}_share", one.value, other.value, unjudged(text))
        for name in (*_RATES, "total_power_mW"):
            one_mean, other_mean = mean_sd(theirs, name), mean_sd(ours, name)
            text = f"; spread {one_mean[1]:.3g} and {other_mean[1]:.3g}"
            yield _beside(f"{codes}_codes_{name}", one_mean[0], other_mean[0], text)


def draw(spreads: Sequence[Mapping[str, float]], groups: Groups, figure: Figure) -> None:
    """Fill a figure with the spread of ROLLS' parts in three processes, and the Pushbot's rates in two.

    Parameters
    ----------
    spreads
        CV of each quantity: in `rolls-180`, with the measured matching alone, in the measured process.
    groups
        What was kept of the drives, by process and codes.
    figure
        The figure, empty.
    """
    figure.set_size_inches(9.0, 5.0)
    left, right = figure.subplots(1, 2, width_ratios=(1.4, 1))
    names = list(spreads[0])
    labels = (ROLLS_180.name, "its matching alone as measured", MEASURED)
    for each, marker, label in zip(spreads, "o|d", labels, strict=True):
        left.plot([100.0 * each[name] for name in names], range(len(names)), marker, label=label)
    left.set_yticks(range(len(names)), names, fontsize=7)
    left.invert_yaxis()
    left.set_xlabel("CV of ROLLS' parts on a die (%)")
    left.legend(fontsize=7)
    for k, (cell, runs) in enumerate(groups.items()):
        means = [mean_sd(runs, name)[:2] for name in _RATES]
        right.errorbar(
            np.arange(len(_RATES)) + 0.15 * (k - 1.5), [m for m, _ in means], [sd for _, sd in means],
            fmt="o", color=(INK, *COLOURS)[k], markersize=4, label=", ".join(cell),
        )  # fmt: skip
    right.set_xticks(range(len(_RATES)), [name.split("_")[1] for name in _RATES])
    right.set_ylabel("mean rate of the Pushbot's populations (Hz)")
    if groups:
        right.legend(fontsize=7)


EXPERIMENT = Experiment(
    "rolls-measured", "ROLLS in a measured process: what it assumes, its spread, the Pushbot",
    reproduce, {"drives": DRIVES, "dies": DIES},
)  # fmt: skip
