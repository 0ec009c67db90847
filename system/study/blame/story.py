"""How a deviation became a failure: device, its current, the chip's spikes, the run's numbers, in words.

The current is that of a device with fixed gate and source voltages in weak inversion, over the design's:

    I / I_0 = (1 + delta_beta) exp(-kappa delta_V_T0 / U_T)

with kappa of the process's nFET; in strong inversion less of V_T0 is seen.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from circuits.errors import CircuitError
from circuits.silicon.course import beginning_of
from circuits.silicon.die import Die
from circuits.silicon.edit import DEVIATIONS
from circuits.silicon.process import Process, thermal_voltage
from circuits.units import format_quantity
from system.study.blame.blame import Blame, Culprit
from system.study.blame.part import shared_by_all
from system.study.blame.trial import ALL, outcome_of
from system.system import SUCCEEDED

SHOWN = 8  # trains and numbers that are told
MOST_TOLD = 20  # devices that are
DIE, MENDED, HEALED = "the die", "the mended die", "the healed die"


@dataclass(frozen=True, slots=True)
class Told:
    """Three runs of one seed, on the die, the mended and the healed one.

    seed : seed of noise and world, the same in all three.
    traces : what each left, by `DIE`, `MENDED` and `HEALED`; those that could not be made are missing.
    summaries : summary of each.
    """

    seed: int
    traces: Mapping[str, Any]
    summaries: Mapping[str, Mapping[str, Any]]


def told_runs(found: Blame) -> Told:
    """Run the die, the mended and the healed one again, where the first fails and the last succeeds."""
    pairs, case = found.accused.pairs, found.case
    both = zip(pairs.seeds, pairs.first, pairs.second, strict=True)
    seed = next((s for s, one, other in both if other and not one), pairs.seeds[0])
    dies = {DIE: case.die, MENDED: found.mended, HEALED: case.healed(ALL)}
    if not found.culprits:
        del dies[MENDED]
    traces = {name: outcome_of(partial(case.system.run, case.on(die, seed))) for name, die in dies.items()}
    made = {name: trace for name, trace in traces.items() if not isinstance(trace, CircuitError)}
    return Told(seed, made, {name: case.system.summarise(trace) for name, trace in made.items()})


def current_ratio(deviations: Mapping[str, tuple[float, float]], process: Process, celsius: float) -> float:
    """Return a device's current over the design's, as the module says.

    deviations : as of `Culprit`; celsius : temperature, degC.
    """
    v_t0, beta = (deviations.get(name, (0.0, 0.0))[0] for name in ("v_t0", "beta"))
    return (1.0 + beta) * math.exp(-process.n.kappa * v_t0 / thermal_voltage(celsius))


def device_lines(found: Blame) -> list[str]:
    """A sentence on each culprit: its deviations, and its current."""
    celsius = beginning_of(found.case.scenario.temperature_c, getattr(found.case.scenario, "course", ()))
    more = [f"And {len(found.culprits) - MOST_TOLD} more."] if len(found.culprits) > MOST_TOLD else []
    return [*(_line(found, each, celsius) for each in found.culprits[:MOST_TOLD]), *more]


def _line(found: Blame, each: Culprit, celsius: float) -> str:
    if not each.deviations:
        return f"{each.path}: {found.counts[each.path]} devices together, which were not told apart."
    parts = [_deviation(each, name) for name in each.deviations]
    if not {*each.deviations} & {"v_t0", "beta"}:
        return f"{each.path}: {', '.join(parts)}."
    both = {n: (value + each.slopes.get(n, 0.0), sigma) for n, (value, sigma) in each.deviations.items()}
    ratio = current_ratio(both, found.processes[each.path.split(".", maxsplit=1)[0]], celsius)
    what = "their currents are" if shared_by_all(each.path) else "its current is"
    return (
        f"{each.path}: {', '.join(parts)}; at a fixed gate voltage in weak inversion {what} {ratio:.3g} times"
        " the design's."
    )


def _deviation(each: Culprit, name: str) -> str:
    """A deviation in words: `V_T0 12mV (1.3 sigma)`, of a gradient `V_T0 -4mV a mm in x (0.9 sigma)`."""
    value, sigma = each.deviations[name]
    axis, dot, parameter = name.rpartition(".")
    where, scale = (f" a mm in {axis}", 1e-3) if dot else ("", 1.0)
    sigmas = f" ({abs(value) / sigma:.1f} sigma)" if sigma > 0.0 else " (set)"
    more = each.slopes.get(name, 0.0)
    beside = f" and {_told(name, more)} by gradients" if more else ""
    return f"{_told(parameter, scale * value)}{where}{sigmas}{beside}"


def _told(parameter: str, value: float) -> str:
    if parameter == "v_t0":
        return f"V_T0 {format_quantity(value, 'V')}"
    return f"{parameter} {100.0 * value:+.2g} %"


def train_rows(found: Blame, told: Told) -> list[tuple[str, ...]]:
    """Spikes by address in the runs, those that differ most between the die and the healed one."""
    outputs = [o for o in found.case.system.outputs.values() if o.trains is not None]
    if not outputs or HEALED not in told.traces or DIE not in told.traces:
        return []
    if outputs[0].refuse is not None and outputs[0].refuse(found.case.scenario):
        return []
    trains = {name: outputs[0].trains(trace) for name, trace in told.traces.items() if outputs[0].trains}
    counts = {name: {key: times.size for key, times in each.items()} for name, each in trains.items()}
    order = sorted(counts[DIE], key=lambda key: -abs(counts[DIE][key] - counts[HEALED].get(key, 0)))
    differ = [key for key in order if counts[DIE][key] != counts[HEALED].get(key, 0)]
    return [(key, *(str(counts[name].get(key, 0)) for name in counts)) for key in differ[:SHOWN]]


def number_rows(told: Told) -> list[tuple[str, ...]]:
    """Numbers of the runs that differ, those that differ most first."""
    own = {
        key: [summary.get(key) for summary in told.summaries.values()]
        for key, value in told.summaries[DIE].items()
        if key != SUCCEEDED and _is_number(value)
    }
    differ = {key: values for key, values in own.items() if len({*values}) > 1}
    order = sorted(differ, key=lambda key: -_apart(differ[key]))
    return [(key, *("-" if x is None else f"{x:.4g}" for x in differ[key])) for key in order[:SHOWN]]


def caution_lines(told: Told) -> list[str]:
    """A caution where the mended robot is, by its numbers, nearer to the failing one; else none."""
    if len(told.summaries) < len((DIE, MENDED, HEALED)):
        return []
    own = [
        [float(told.summaries[name][key]) for name in (DIE, MENDED, HEALED)]
        for key, value in told.summaries[DIE].items()
        if not isinstance(value, bool) and all(_is_number(s.get(key)) for s in told.summaries.values())
    ]
    differ = [each for each in own if each[0] != each[2]]
    nearer = sum(abs(mended - die) < abs(mended - healed) for die, mended, healed in differ)
    if 2 * nearer <= len(differ):
        return []
    text = (
        f"Caution: in {nearer} of the {len(differ)} numbers in which the die and the healed die differ, the"
        f" mended robot of seed {told.seed} is nearer to the failing one: it meets what success asks for, and"
        " still does not do what the healed one does."
    )
    return [text]


def opening_lines(found: Blame, told: Told) -> list[str]:
    """The verdict, and the cautions that stand beside it."""
    return [*verdict_lines(found), *_undefined_lines(found, told), *caution_lines(told)]


def _undefined_lines(found: Blame, told: Told) -> list[str]:
    """A caution where a metric of success in the user's words is not defined in the runs; else none."""
    asked = () if found.case.wanted is None else found.case.wanted.metrics
    names = [name for name in asked if any(s[name] is None for s in told.summaries.values())]
    if not names:
        return []
    text = (
        f"Caution: {', '.join(names)}: not defined in runs of seed {told.seed}, and such a run counts as no"
        " success, whatever else it does."
    )
    return [text]


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _apart(values: Sequence[float | None]) -> float:
    known = np.array([x for x in (values[0], values[-1]) if x is not None], np.float64)
    return float(np.ptp(known) / max(np.abs(known).max(), 1e-300)) if known.size == 2 else math.inf


def verdict_lines(found: Blame) -> list[str]:
    """What was found, a sentence each."""
    pairs, name = found.accused.pairs, found.case.system.name
    anew = " and calibrated anew" if found.case.recalibrated else ""
    first = (
        f"The die succeeds in {pairs.first_share} of its trials, healed of all deviations{anew} in"
        f" {pairs.second_share}"
    )
    low, high = (100.0 * x for x in (found.accused.interval.low, found.accused.interval.high))
    gain = f"a difference of {low:.0f} to {high:.0f} points"
    if not found.accused.guilty:
        told = f"as far as {len(pairs.seeds)} pairs of trials tell"
        return [f"{first}: {gain}. It is not the die that makes {name} fail, {told}.", *_held(found)]
    lines = [f"{first}: {gain}. The die is to blame.", *_held(found)]
    count = len(found.culprits)
    what = "one part of it" if count == 1 else f"{count} parts of it"
    least = "" if found.finished else ", where the search ended since its trials were over"
    paths = "; ".join(each.path for each in found.culprits)
    lines.append(f"The fewest whose healing mends are {what}{least}: {paths}.")
    return [*lines, *_sure(found), *_else(found)]


def _held(found: Blame) -> list[str]:
    """What the healed die does with codes that are right for the die alone, where it was calibrated anew."""
    if not found.case.recalibrated:
        return []
    share = "cannot run" if found.held is None else f"succeeds in {found.held.pairs.second_share}"
    anew = "every edited die is" if found.accused.guilty else "it was"
    text = f"With the codes of the die, which are not right for it, the healed die {share}. So {anew}"
    return [f"{text} calibrated anew."]


def _sure(found: Blame) -> list[str]:
    lines = []
    if found.verified is not None:
        v = found.verified
        word = "mends" if v.mends else "is not shown to mend"
        low, high = (100.0 * x for x in (v.interval.low, v.interval.high))
        few = "" if len(v.pairs.seeds) >= v.wanted else f"; {v.wanted} were wanted, trials were over"
        lines.append(
            f"Healing these {word}: on {len(v.pairs.seeds)} trials that the search has not used the mended"
            f" die succeeds in {v.pairs.second_share}, the healed one in {v.pairs.first_share}, a difference"
            f" of {low:.1f} to {high:.1f} points at 90 %{few}."
        )
    if found.random is not None:
        lines.append(
            f"As many at random, of the same circuits and spreads, mend in {found.random.passed} of"
            f" {found.random.of} sets."
        )
    return lines


def _else(found: Blame) -> list[str]:
    lines = []
    if found.area is not None:
        lines.append(f"It would be mended too if they were {found.area:g} times as large.")
    for each in found.remedies:
        share = "could not be tried" if each.share is None else f"succeeds in {each.share}"
        lines.append(f"Beside: {each.name} {share}.")
    return lines


def _set_last(die: Die) -> dict[str, str]:
    """What is set of a die by hand, in order: of what is set twice the last, which goes over the first."""
    found: dict[str, str] = {}
    for edit in die.edits:
        if edit.kind == "set":
            at = f"{edit.paths[0]}.{edit.parameter}"
            found.pop(at, None)
            found[at] = f"{edit.value!r}{DEVIATIONS[edit.parameter]}"
    return found


def mended_options(found: Blame) -> list[tuple[str, str]]:
    """Options by name that edit the die as the mended one is, and hold its codes."""
    die: Die = found.mended
    options = [("only", path) for edit in die.edits if edit.kind == "only" for path in edit.paths]
    options += [("heal", path) for edit in die.edits if edit.kind == "heal" for path in edit.paths]
    options += [("deviate", f"{at}={value}") for at, value in _set_last(die).items()]
    case = found.case
    if case.coded and not case.recalibrated and getattr(case.scenario, "code_choice", "default") != "default":
        options.append(("codes_of", str(found.case.die.number)))
    return options
