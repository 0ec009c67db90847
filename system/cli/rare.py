"""The verb `noctule montecarlo TARGET --rare METHOD`: the probability of a rare failure."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from circuits.errors import ParameterError
from system.cli.output import print_json, print_line, progress_bar
from system.study.manifest import Study
from system.study.search.rare_die import METHODS, rare_failure
from system.study.specification import Specification
from system.study.statistics.rare import RareFailure
from system.study.table import place_text
from system.study.target import SystemTarget, open_target


def check_rare(method: str, study: Study, specs: Sequence[str], others: Mapping[str, object]) -> None:
    """Check before the work that the probability of a rare failure can be estimated.

    others: values of options that only a study with kept samples has, by option. Raises `ParameterError` for
    an unknown method, a system, no specification, several conditions, and any of the other options.
    """
    if method not in METHODS:
        raise ParameterError(f"--rare: {method}, must be {' or '.join(METHODS)}")
    if isinstance(open_target(study.subject), SystemTarget):
        raise ParameterError(f"--rare: {study.subject.target} is a system; study its blocks or chips")
    if not specs:
        raise ParameterError("--rare: of which failure, must come with --spec")
    if len(study.conditions) != 1:
        raise ParameterError(f"--rare: {len(study.conditions)} corners and temperatures, must be one")
    for option, given in others.items():
        if given:
            raise ParameterError(f"--rare: draws its own dies and keeps none, so not with {option}")


def print_rare(
    method: str,
    study: Study,
    specifications: Sequence[Specification],
    threads: int | None,
    *,
    as_json: bool,
) -> None:
    """Estimate the probability of a failure by the method, and print it as text or as JSON."""
    condition, samples = study.conditions[0], study.plan.count
    with progress_bar(f"{study.subject.target}, {method}, {samples} samples") as progress:
        found = rare_failure(study, specifications, method, threads, progress)
    if as_json:
        print_json(_document(study, specifications, found))
        return
    where = place_text(condition.corner, condition.temperature_c)
    ends = found.interval
    print_line(f"{study.subject.target} at {where}: failure of {' and '.join(map(str, specifications))}")
    print_line(f"probability {found.probability:.3g}, 95 % interval {ends.low:.3g} to {ends.high:.3g}")
    effective = found.effective_samples
    size = f"effective sample size {effective:.0f}" if math.isfinite(effective) else "an extrapolation"
    print_line(f"{found.method}, {found.samples} samples, {size}; {found.detail}")


def _document(study: Study, specifications: Sequence[Specification], found: RareFailure) -> dict[str, Any]:
    return {
        "target": study.subject.target,
        "temperature_C": study.conditions[0].temperature_c,
        "corner": study.conditions[0].corner,
        "specifications": [str(s) for s in specifications],
        "seed": study.plan.seed,
        "rare": asdict(found),
    }
