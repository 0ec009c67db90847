"""What `match`, `worst` and `corners` share: a block as a target, and a metric's gradient over its dies."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import partial

from circuits.errors import ParameterError
from system.cli.block_choice import choose_block
from system.cli.deck_measures import own_measures
from system.cli.match_verb import OverDies
from system.options.block import read_die
from system.registry import system_names
from system.study.metrics.measure import measure_name, named_measures
from system.study.metrics.metric import with_named
from system.study.search.slope import Slopes
from system.study.table import Condition
from system.study.target import BlockTarget, Quantity, Subject, hashed

_WORD = re.compile(r"\w+")


def target_of(block: str, metrics: Sequence[str], over: OverDies, verb: str) -> BlockTarget:
    """Give a block with its metrics; arguments and errors are those of `subject_of`."""
    return BlockTarget(subject_of(block, metrics, over, verb))


def subject_of(block: str, metrics: Sequence[str], over: OverDies, verb: str) -> Subject:
    """Give what a block with the metrics that are measured of it is made from.

    verb: who asks. Raises `ParameterError` for a system, and for no metric.
    """
    if block in system_names():
        raise ParameterError(f"{verb}: {block} is a system, must be a block or chip; name one of its chips")
    values, named = over.values, [name.replace("-", "_") for name in metrics]
    chosen = partial(choose_block, block, values, over.silicon, over.stimulus)
    own = needed(own_measures(block, over.silicon, chosen), (*named, *over.measure))
    names = with_named(named_measures((*own, *over.measure)), named)
    if not names:
        raise ParameterError(
            f"{verb}: no metric, must name one, as t_inh_s; see noctule show BLOCK --metrics"
        )
    return hashed(
        Subject(
            block, names, values.param, values.bias, values.bias_set, values.bias_kind, over.stimulus,
            over.silicon,
        )
    )  # fmt: skip


def needed(cards: Sequence[str], named: Sequence[str]) -> tuple[str, ...]:
    """Give the measures of a deck's cards that metrics or other measures name, and those that these name."""
    words, found = set(_WORD.findall(" ".join(named))), []
    for text in reversed(cards):
        if measure_name(text) in words:
            found.append(text)
            words.update(_WORD.findall(text))
    return tuple(reversed(found))


def quantity_of(target: BlockTarget, metric: str) -> Quantity:
    """Give what is measured by the name of a metric, as `t_inh_s` or `MODULE:FUNCTION`.

    Raises `ParameterError` for a metric that is a word.
    """
    name = metric.rpartition(":")[2].replace("-", "_")
    numbers = {q.name for q in target.quantities}
    if not numbers or name in {m.name for m in target.metrics} - numbers:
        known = ", ".join(sorted(numbers)) or "those with a unit in noctule show BLOCK --metrics"
        raise ParameterError(f"--metric: {metric}, is a word, must be a number; name one of {known}")
    return next((q for q in target.quantities if q.name == name), target.quantities[-1])


def slopes_of(target: BlockTarget, metric: str, over: OverDies) -> Slopes:
    """Give a metric of the target with its gradient over dies."""
    condition = Condition("random", target.choice.silicon.temperature_c, 0)
    return Slopes(target, read_die(over.silicon), condition, metric, over.threads)


def by_what(slopes: Slopes) -> str:
    """Say where gradients come from."""
    return "one run backwards" if slopes.by_gradient else "two dies a draw"
