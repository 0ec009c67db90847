"""The verb `noctule size`: the least area at which enough dies pass, and fresh dies tell whether they do."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from typing import Any

from circuits.arrays import F64
from circuits.errors import ParameterError
from circuits.units import parse_quantity
from system.cli.exit_status import DONE, NO
from system.cli.match_verb import Size
from system.cli.output import print_line, progress_bar
from system.cli.over_dies import subject_of
from system.cli.search_output import (
    FreshDies,
    Searched,
    check_search,
    percent,
    reports_on,
)
from system.notice import say
from system.options.block import Value, read_die
from system.registry import system_names
from system.study.campaign import thread_count
from system.study.search.centre import Bench, Problem
from system.study.search.knob import lengths_of, moved_subject, sizes_of
from system.study.search.size import Sized, size
from system.study.specification import check_form, limited_metrics
from system.study.statistics.summary import Yield
from system.study.table import Condition
from system.study.target import BlockTarget

SQUARE_MICROMETRE = 1e-12  # m^2


@dataclass(frozen=True, slots=True, kw_only=True)
class Result(Searched):
    """Finished search with the yield of fresh dies.

    Attributes
    ----------
    asked : options of the verb.
    wanted : share of dies that should pass.
    found : where the search ended.
    """

    asked: Size
    wanted: float
    found: Sized

    @property
    def after(self) -> Yield:
        """The yield of fresh dies at the sizes found, of all that varies as in the search."""
        return self.reports[-1].after

    @property
    def verdict(self) -> str:
        """Whether the wanted share of fresh dies passes: `met`, `missed`, or `undecided` by their number."""
        if self.after.estimate.value >= self.wanted:
            return "met"
        return "undecided" if self.after.estimate.interval.high >= self.wanted else "missed"


def size_command(asked: Size) -> int:
    """Search, report on fresh dies, and write the file that is asked for.

    Returns the exit status, `NO` where fresh dies tell that fewer pass than are wanted.
    """
    result = run(asked)
    result.give(asked.output, document(result), None if asked.as_json else lambda: _print(result))
    if result.verdict == "missed":
        share = percent(result.after.estimate.value)
        say(f"size: {share} of fresh dies pass, of {percent(result.wanted)}; let more sizes move, or farther")
        return NO
    return DONE


def run(asked: Size) -> Result:
    """Search on the tuning dies, and report on fresh ones.

    Whatever can fail is checked before the search. Raises `ParameterError` for options that contradict each
    other or the block.
    """
    wanted, fresh = _checked(asked), _fresh_of(asked)
    if asked.block not in system_names():
        check_form(asked.spec)
    subject = subject_of(asked.block, limited_metrics(asked.spec), asked.over, "size")
    target = BlockTarget(subject)
    specifications = target.specified(asked.spec)
    knobs = tuple(sizes_of(target.choice, asked.move_param or lengths_of(target.choice)))
    if not knobs:
        raise ParameterError(f"--move-param: none, and {asked.block} has no length that moves; name a size")
    condition = Condition("random", target.choice.silicon.temperature_c, 0)

    def values_at(coordinates: F64) -> tuple[Value, ...]:
        return tuple(k.at(u, asked.reach, 0.0) for k, u in zip(knobs, coordinates.tolist(), strict=True))

    def open_at(coordinates: F64) -> BlockTarget:
        made = BlockTarget(moved_subject(subject, knobs, values_at(coordinates)))
        made.machines(condition.temperature_c)  # lowered once, before threads share it
        return made

    problem = Problem(open_at, len(knobs), specifications, read_die(subject.silicon), condition)
    with (
        progress_bar(f"{subject.target}, search") as progress,
        ThreadPoolExecutor(thread_count(asked.over.threads)) as executor,
    ):
        bench = Bench(problem, asked.tuning_dies, executor, lambda _: None)
        found = size(problem, open_at, wanted, bench, asked.tuning_dies, asked.over.threads, progress)
    values = values_at(found.coordinates)
    designs = subject, moved_subject(subject, knobs, values)
    reports = reports_on(fresh, designs, asked.over.silicon, specifications, condition)
    units = {q.name: q.unit for q in target.quantities}
    return Result(
        asked=asked, start=subject, specifications=specifications, units=units, knobs=knobs, values=values,
        wanted=wanted, found=found, reports=reports,
    )  # fmt: skip


def _fresh_of(asked: Size) -> FreshDies:
    return FreshDies(asked.tuning_dies, asked.fresh_dies, asked.first_fresh_die, asked.over.threads)


def _checked(asked: Size) -> float:
    """The wanted share of dies, once all options are possible."""
    check_search(
        _fresh_of(asked), asked.spec, "t_inh_s in 5ms:8ms", asked.reach, asked.over.silicon, asked.output
    )
    text = asked.wanted.strip()
    wanted = parse_quantity(text.removesuffix("%"), "", "--yield") / (100.0 if text.endswith("%") else 1.0)
    if not 0.5 <= wanted < 1.0:
        raise ParameterError(f"--yield: {asked.wanted}, must be at least 50% and below 100%; write as in 99%")
    return wanted


def document(result: Result) -> dict[str, Any]:
    """Give the result of a search as members of a JSON document."""
    asked, found = result.asked, result.found
    return {
        **result.document(asked.block, asked.over.silicon, _fresh_of(asked)),
        "yield_wanted": result.wanted,
        "verdict": result.verdict,
        "area_before_m2": found.area_before,
        "area_after_m2": found.area_after,
        "search": {k: v for k, v in asdict(found).items() if k != "coordinates" and not k.startswith("area")},
    }


def _print(result: Result) -> None:
    asked, found = result.asked, result.found
    wanted = f"{' and '.join(map(str, result.specifications))} on {percent(result.wanted)} of dies"
    tuned = f"tuned on dies {asked.over.silicon.lot}/0 to {asked.tuning_dies - 1}"
    result.print_moved("sizes", f"{asked.block}, {wanted}; {tuned}")
    before, after = (x / SQUARE_MICROMETRE for x in (found.area_before, found.area_after))
    print_line(
        f"area of gates and capacitors {before:.4g} um^2, after {after:.4g} um^2, x {after / before:.3f}"
    )
    search = (
        f"gradients of {found.designs} sizes, {found.measurements} dies measured; of the tuning dies"
        f" {percent(found.yield_before)} pass before, {percent(found.yield_after)} after, in the linear"
        f" theory {percent(found.predicted)}"
    )
    result.print_found(
        search, (found.impossible, "sizes were no circuit, and were passed over"), _fresh_of(asked)
    )
    told = {"met": "passes", "missed": "does not pass", "undecided": "may pass: more dies would tell"}
    print_line(f"{percent(result.wanted)} of fresh dies wanted, which {told[result.verdict]}\n")
    result.print_options()
