"""The verb `noctule gradient BLOCK`: what each device and parameter moves a metric by."""

from __future__ import annotations

import csv as comma_separated
import io
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from circuits.errors import ParameterError
from circuits.gradient.every import AnyMeasure, every_gradient
from circuits.gradient.gradient import Gradients
from circuits.gradient.measure import SpikeTime
from circuits.lowering.kernel import Machine, to_kernel
from circuits.measure.unit import value_text
from system.cli.block_choice import choose_block
from system.cli.deck_measures import own_cards, own_measures
from system.cli.output import print_json, print_line, print_table, working
from system.cli.over_dies import needed
from system.cli.simulate_verb import Simulate
from system.cli.spectrum_card import spectrum_cards
from system.cli.study_verbs import Gradient
from system.files.writing import write_text_atomic
from system.options.block import Choice, describe_silicon, silicon_line
from system.plot import check_picture, save_picture
from system.study.metrics.gradient import FORMS, draw_gradients, is_form, measures_of, moves_of
from system.study.metrics.measure import is_measure, measure_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LISTED = 12  # parameters of a printed table


def gradient_command(asked: Gradient) -> None:
    """Print the gradients of metrics by device and parameter, and write the files that are asked for."""
    check_picture(asked.plot)
    choice = choose_block(asked.block, asked.values, asked.silicon, asked.stimulus, asked.begin)
    machine = to_kernel(choice.testbench(), choice.silicon)
    with working(f"gradients of {asked.block}"):
        measures, moves = _measures(asked, choice, machine), moves_of(choice, machine)
        found = every_gradient(machine, measures, moves=moves, check=True)
    if asked.csv is not None:
        write_text_atomic(asked.csv, _csv(found))
    save_picture(asked.plot, lambda figure: _draw(found, figure))
    if asked.as_json:
        head = {"block": choice.block.name, **describe_silicon(choice.silicon)}
        print_json({**head, "metrics": [_document(found, k, choice) for k in range(len(found.measures))]})
        return
    for k in range(len(found.measures)):
        _print(found, k, choice)


def _measures(asked: Gradient, choice: Choice, machine: Machine) -> list[AnyMeasure]:
    """What is asked for, of a deck's cards too; the first spike of each watched port unless something is."""
    names = [
        name if is_form(name) or is_measure(name) or ":" in name else name.replace("-", "_")
        for name in asked.metric
    ]
    watched = [machine.names[n] for w in machine.testbench.watch for n in machine.flat.port_nodes(w)]
    if not (names or watched):
        raise ParameterError(f"--metric: none, and {choice.block.name} has no spikes; name one of {FORMS}")
    if not names:
        return [SpikeTime(port) for port in watched]
    cards = _cards(asked, choice, machine, names)
    others = [name for name in names if name not in cards]
    own = needed(own_measures(asked.block, asked.silicon, lambda: choice), others)
    found = dict(zip(others, measures_of(choice, others, own), strict=True))
    return [cards.get(name) or found[name] for name in names]


def _cards(
    asked: Gradient, choice: Choice, machine: Machine, names: Sequence[str]
) -> Mapping[str, AnyMeasure]:
    """Measures of a deck's cards of small signals, where names mean one.

    Raises `ParameterError` for a name of a card of an analysis that has no gradients.
    """
    for analysis in ("dc", "noise"):
        known = {measure_name(text) for text in own_cards(asked.block, choice, analysis)}
        for name in names:
            if name in known:
                raise ParameterError(
                    f"--metric: {name}, is of .measure {analysis}, must be of the transient, the operating"
                    f" point or small signals, which have gradients; simulate --analysis {analysis} measures"
                    " it on a die"
                )
    known = {measure_name(text) for text in own_cards(asked.block, choice, "ac")}
    if known.isdisjoint(names):
        return {}
    spectrum = Simulate(
        block=asked.block, analysis="ac", values=asked.values, silicon=asked.silicon,
        stimulus=asked.stimulus, begin=asked.begin,
    )  # fmt: skip
    found = spectrum_cards(spectrum, choice, machine)
    for name in names:
        if name in known and name not in found:
            raise ParameterError(f"--metric: {name}, is a .measure card that is left out; name another")
    return found


def _order(found: Gradients, k: int) -> tuple[list[int], Any]:
    """Parameters, those that move a metric most over dies first, and the share of each."""
    power = np.nan_to_num((found.by[k] * found.sigma) ** 2)
    share = power / power.sum() if power.sum() > 0.0 else power
    order = np.lexsort((-np.abs(np.nan_to_num(found.by[k])), -share))
    return [int(i) for i in order if math.isfinite(found.by[k, i])], share


def _note(found: Gradients, k: int, choice: Choice) -> str:
    """What is to be said of a measure, and of its spread where dies have more than that has."""
    plain = choice.silicon.die.variation == "plain"
    more = "" if plain else "of lots, wafers, gradients and n with p the spread over dies has nothing"
    return "; ".join(filter(None, (found.notes[k], more)))


def _document(found: Gradients, k: int, choice: Choice) -> dict[str, Any]:
    order, share = _order(found, k)
    defined = math.isfinite(found.values[k])
    return {
        "metric": found.measures[k], "unit": found.units[k],
        "value": float(found.values[k]) if defined else None,
        "spread": float(found.spread[k]) if math.isfinite(found.spread[k]) else None,
        "error": float(found.error[k]) if found.error.size and math.isfinite(found.error[k]) else None,
        "note": _note(found, k, choice),
        "gradients": [
            {
                "parameter": found.labels[i], "unit": found.of_units[i], "gradient": float(found.by[k, i]),
                "sigma": float(found.sigma[i]), "share": float(share[i]),
            }
            for i in order
            if math.isfinite(found.by[k, i])
        ],
    }  # fmt: skip


def _csv(found: Gradients) -> str:
    text = io.StringIO()
    writer = comma_separated.writer(text, lineterminator="\n")
    writer.writerow(["metric", "unit", "parameter", "parameter_unit", "gradient", "sigma"])
    for k, metric in enumerate(found.measures):
        for i, label in enumerate(found.labels):
            if not math.isfinite(found.by[k, i]):
                continue
            numbers = (repr(float(x)) for x in (found.by[k, i], found.sigma[i]))
            writer.writerow([metric, found.units[k], label, found.of_units[i], *numbers])
    return text.getvalue()


def _print(found: Gradients, k: int, choice: Choice) -> None:
    name, unit, value = found.measures[k], found.units[k], float(found.values[k])
    if not math.isfinite(value):
        print_line(f"{name}: {found.notes[k]}")
        return
    told, spread = (value_text(x, unit) for x in (value, float(found.spread[k])))
    if not np.isfinite(found.by[k]).any():
        print_line(f"{name} {told}, at {silicon_line(choice.silicon)}; no gradient: {found.notes[k]}")
        return
    order, share = _order(found, k)
    rows = [
        (found.labels[i], _slope(found, k, i), _moved(found, k, i), f"{100.0 * share[i]:.1f} %")
        for i in order[:LISTED]
    ]
    title = f"{name} {told}, sigma over dies {spread}, at {silicon_line(choice.silicon)}"
    print_table(title, ("parameter", "gradient:", "by one sigma:", "share of the variance:"), rows)
    if note := _note(found, k, choice):
        print_line(f"{name}: {note}")
    print_line(f"{len(order) - len(rows)} more parameters; --csv FILE or --json has all")


def _slope(found: Gradients, k: int, i: int) -> str:
    over = f"/{found.of_units[i]}" if found.of_units[i] else ""
    return f"{found.by[k, i] + 0.0:.4g} {found.units[k] or '1'}{over}"


def _moved(found: Gradients, k: int, i: int) -> str:
    moved = float(found.by[k, i] * found.sigma[i])
    return value_text(moved, found.units[k]) if found.sigma[i] > 0.0 else ""


def _unmoved(found: Gradients, k: int) -> str:
    """What is to be said of a measure that no deviation moves; empty where one does."""
    return "" if np.nan_to_num(found.by[k] * found.sigma).any() else "no deviation of a die moves it"


def _draw(found: Gradients, figure: Figure) -> None:
    count = len(found.measures)
    figure.set_size_inches(7.5, 3.8 * count)
    for k, ax in enumerate(figure.subplots(count, 1, squeeze=False)[:, 0]):
        if np.isfinite(found.by[k]).any():
            draw_gradients(found, k, ax)
            ax.set_title(found.notes[k] or _unmoved(found, k), fontsize=8)
        else:  # nothing to draw, and no empty axes that look as if nothing moved it
            ax.set_axis_off()
            ax.text(0.5, 0.5, f"{found.measures[k]}\n{found.notes[k]}", ha="center", va="center", fontsize=8)
