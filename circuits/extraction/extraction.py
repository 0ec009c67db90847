"""A process that was fitted to drain currents, and how far it is off them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any

from circuits.extraction.fit import Distance, Fitted, distance, fit
from circuits.extraction.points import Points
from circuits.silicon.process import POLARITIES, Polarity, Process, TransistorModel
from circuits.silicon.size import SizeTerms

_DIGITS = 7  # of a number of a fitted model, far below its standard error; ours


@dataclass(frozen=True, slots=True, eq=False)
class Extraction:
    """A process fitted to drain currents.

    process: the process. fitted: the fit of each polarity that there are points of. points: the currents that
    were fitted, by polarity. held_out: currents of sizes that were not fitted, by polarity; empty where there
    are none. notes: what the process leaves out, and numbers at a limit of what is sought, in lines.
    """

    process: Process
    fitted: Mapping[Polarity, Fitted]
    points: Mapping[Polarity, Points]
    held_out: Mapping[Polarity, Points]
    notes: tuple[str, ...] = ()

    def distances(self, polarity: Polarity) -> Iterator[tuple[str, tuple[float, float], Distance]]:
        """Give `fitted` or `held out`, width and length (m), and how far the law is off, of each size."""
        model = self.process.model(polarity)
        for role, given in (("fitted", self.points), ("held out", self.held_out)):
            points = given.get(polarity)
            if points is None:
                continue
            for size in points.sizes():
                yield role, size, distance(model, self.process, points.of_size(size))

    def judged(self, polarity: Polarity) -> Distance:
        """How far the law is off at the sizes that were not fitted, or at the fitted ones if all were."""
        points = self.held_out.get(polarity, self.points[polarity])
        return distance(self.process.model(polarity), self.process, points)


def extract_from(
    points: Mapping[Polarity, Points], base: Process, held_out: Mapping[Polarity, Points] | None = None
) -> Extraction:
    """Fit a process to drain currents.

    Parameters
    ----------
    points
        Currents by polarity; a polarity without any stays as in `base`.
    base
        What the fit begins with, and what it keeps where the points fix nothing.
    held_out
        Currents of other sizes, by which the law is judged.

    Raises
    ------
    ParameterError
        Too few points for the numbers that they would fix.
    """
    fitted = {p: fit(points[p], base.model(p), base) for p in POLARITIES if p in points}
    models = {p: rounded(fitted[p].model) if p in fitted else base.model(p) for p in POLARITIES}
    process = replace(base, n=models["n"], p=models["p"])
    notes = tuple(
        f"{p}FETs, at a limit of what is sought: {', '.join(each.limited)}"
        for p, each in fitted.items()
        if each.limited
    )
    return Extraction(process, fitted, points, held_out or {}, notes)


def rounded(model: TransistorModel) -> TransistorModel:
    """The model with its numbers in seven digits."""
    plain = {f.name: _short(getattr(model, f.name)) for f in fields(model) if f.name not in {"law", "size"}}
    size = model.size
    if size is not None:
        terms: dict[str, Any] = {f.name: _short(getattr(size, f.name)) for f in fields(SizeTerms)}
        size = SizeTerms(**terms)
    return replace(model, **plain, size=size)


def _short(value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(map(_short, value))
    return float(f"{value:.{_DIGITS}g}")
