"""The verb `noctule worst BLOCK --spec ...`: the most probable failing die of each specification."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from circuits.errors import ParameterError, SolverError
from circuits.units import format_quantity
from system.cli.exit_status import DONE, NO
from system.cli.match_verb import Worst
from system.cli.output import print_json, print_line, print_table, progress_bar
from system.cli.over_dies import by_what, slopes_of, target_of
from system.notice import say
from system.registry import system_names
from system.study.search.corner import write_dies
from system.study.search.slope import Slopes
from system.study.search.worst_case import FAR, WorstCase, beyond, checked_there, failure_of, worst_cases
from system.study.specification import Limits, limited_metrics
from system.study.statistics.mean_shift import LEAST_EFFECTIVE
from system.study.statistics.rare import RareFailure


@dataclass(frozen=True, slots=True, eq=False)
class Found:
    """A specification, its worst cases, runs, files of their dies, and the check or why there is none."""

    limits: Limits
    slopes: Slopes
    cases: tuple[WorstCase, ...]
    runs: int
    files: tuple[Path, ...]
    check: RareFailure | None
    why: str


def worst_command(asked: Worst) -> int:
    """Print the worst cases; the exit status is `NO` where a worst die did not behave as it was found."""
    if not asked.spec:
        raise ParameterError("worst: of which specification, must come with spec; as `spec=t_inh_s in :8ms`")
    if asked.check and asked.check < LEAST_EFFECTIVE:
        raise ParameterError(
            f"check: {asked.check}, must be 0 or at least {LEAST_EFFECTIVE:g} dies; take more"
        )
    if not limited_metrics(asked.spec) and asked.block not in system_names():
        raise ParameterError(f'spec: "{asked.spec[0]}", must limit a metric; write as in "t_inh_s in :8ms"')
    target = target_of(asked.block, limited_metrics(asked.spec), asked.over, "worst")
    specs = target.specified(asked.spec)
    for text, spec in zip(asked.spec, specs, strict=True):
        if not isinstance(spec, Limits):
            raise ParameterError(f'spec: "{text}", a class has no gradient; limit a metric')
    found: list[Found] = []
    with progress_bar(f"worst dies of {asked.block}") as progress:
        for k, limits in enumerate(specs):
            if isinstance(limits, Limits):
                again = sum(each.limits.metric == limits.metric for each in found)
                slopes = slopes_of(target, limits.metric, asked.over)
                found.append(_found(asked, limits, slopes, f"-{again + 1}" if again else ""))
            progress((k + 1) / len(specs))
    if asked.as_json:
        print_json({"block": asked.block, "specifications": [_document(each) for each in found]})
    else:
        _print(found)
    doubted = [case for each in found for case in each.cases if not case.verified]
    for case in doubted:
        say(f"worst: the die at {case.distance:.2f} sigma of {case.metric} does not pass or fail as found")
    return NO if doubted else DONE


def _found(asked: Worst, limits: Limits, slopes: Slopes, which: str) -> Found:
    """The worst cases of a limit; which: what tells its files from those of other limits of the metric."""
    cases = worst_cases(slopes, limits)
    runs, check, why = slopes.runs, None, ""
    if asked.check:
        try:
            check = checked_there(slopes, limits, cases, asked.check, asked.seed)
        except SolverError as error:  # what was found stands without the check
            why = str(error)
    files: tuple[Path, ...] = ()
    if asked.output is not None:
        files = write_dies(Path(asked.output), slopes, [(_name(case) + which, case.point) for case in cases])
    return Found(limits, slopes, cases, runs, files, check, why)


def _name(case: WorstCase) -> str:
    return f"{case.metric}-{case.side}"


def _document(found: Found) -> dict[str, Any]:
    files: list[Path | None] = list(found.files) or [None] * len(found.cases)
    return {
        "specification": str(found.limits),
        "unit": found.limits.unit,
        "by": by_what(found.slopes),
        "runs": found.runs,
        "failing": failure_of(found.cases),
        "beyond": beyond(found.limits, found.cases),
        "cases": [
            {
                "side": case.side, "limit": case.limit, "distance": case.distance, "failing": case.failing,
                "value": case.value, "verified": case.verified,
                "die_file": None if path is None else str(path),
                "moves": [{"draw": name, "sigma": z} for name, z in _moves(found.slopes, case)],
            }
            for case, path in zip(found.cases, files, strict=True)
        ],
        "check": None if found.check is None else asdict(found.check),
        "check_note": found.why,
    }  # fmt: skip


def _moves(slopes: Slopes, case: WorstCase, most: int | None = None) -> list[tuple[str, float]]:
    """Draws of the worst die, the largest first."""
    pairs = [(name, float(z)) for name, z in zip(slopes.labels, case.point, strict=True) if z]
    return sorted(pairs, key=lambda pair: (-abs(pair[1]), pair[0]))[:most]


def _print(found: Sequence[Found]) -> None:
    heads = (
        "specification",
        "side",
        "distance, sigma:",
        "fails:",
        "measured there:",
        "verified",
        "moved most",
    )
    rows = []
    for each in found:
        for case in each.cases:
            moved = ", ".join(f"{name} {z:+.2f}" for name, z in _moves(each.slopes, case, 2))
            told = format_quantity(case.value, each.limits.unit)
            sure = "yes" if case.verified else "no"
            row = (f"{case.distance:.2f}", f"{case.failing:.3g}", told, sure, moved)
            rows.append((str(each.limits), case.side, *row))
    print_table("worst dies", heads, rows)
    for each in found:
        share = failure_of(each.cases)
        print_line(
            f"{each.limits}: {100.0 * (1.0 - share):.4g} % of dies pass, {share:.3g} fail, {each.runs} runs"
        )
        for side in beyond(each.limits, each.cases):
            print_line(f"{each.limits}: as far as {FAR:g} sigma no die is {side}")
        if each.check is not None:
            ends = each.check.interval
            told = f"{each.check.probability:.3g} fail, 95 % interval {ends.low:.3g} to {ends.high:.3g}"
            print_line(f"{each.limits}: by {each.check.samples} dies about the worst: {told}")
        if each.why:
            print_line(f"{each.limits}: not checked, {each.why}")
        for path in each.files:
            print_line(f"die: {path}")
