"""What every system is: how a scenario is made, run, summed up and drawn; and what a run says of itself.

A run's summary begins with its account, which has the same entries for every system (`ENTRIES`):

================  ====  ==============================================================================
succeeded         -     whether the run did what the system is for, by its own sentence `success`
reason            text  the one reason why the run ended, the same in text, JSON and picture
distance_m        m     way travelled; None where nothing travels
emergency_share   -     emergencies over decisions, 0 to 1; None where there are none to make
standing_share    -     share of the time at rest, 0 to 1; None where nothing can come to rest
ran_on            -     level, lot, die, bias kind, ranges, selection, cells, brain: what the run was on
cautions          text  sentences, where its chips are outside of what they were made or measured for
================  ====  ==============================================================================

Numbers of the system's own follow. `METRICS` are the entries that a study can measure.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from matplotlib.figure import Figure

from circuits.circuit import BiasKind, Circuit

ENTRIES = ("succeeded", "reason", "distance_m", "emergency_share", "standing_share", "ran_on", "cautions")
SUCCEEDED = "succeeded"
METRICS = (SUCCEEDED, "distance_m", "emergency_share", "standing_share")

Summary = dict[str, Any]  # entries of an account, then numbers (None where not defined), by their names


@dataclass(frozen=True, slots=True)
class Account:
    """What a run says of itself; see `ENTRIES`."""

    succeeded: bool
    reason: str
    ran_on: Mapping[str, str | float | bool | None]
    distance_m: float | None = None
    emergency_share: float | None = None
    standing_share: float | None = None
    cautions: tuple[str, ...] = ()

    @property
    def headline(self) -> str:
        """Success and reason in one line."""
        return headline(succeeded=self.succeeded, reason=self.reason)


class System(Protocol):
    """A robot in its world, as the command line and studies see it.

    summary: a line of what it is; success: a sentence, when a run of it has succeeded; metrics: names of the
    numbers that a study can ask of a run, those of `METRICS` among them; yes_no: those that are 1 or 0, for
    yes or no, `SUCCEEDED` among them; study_metrics: those it measures unless asked for others.
    """

    @property
    def name(self) -> str:
        """Name on the command line."""

    @property
    def summary(self) -> str:
        """A line of what it is."""

    @property
    def success(self) -> str:
        """When a run has succeeded."""

    @property
    def metrics(self) -> tuple[str, ...]:
        """Numbers that a study can ask for."""

    @property
    def yes_no(self) -> tuple[str, ...]:
        """Those that are 1 or 0, for yes or no."""

    @property
    def study_metrics(self) -> tuple[str, ...]:
        """Those that it measures unless asked for others."""

    def scenario(self, **options: Any) -> Any:
        """A scenario; raises `UnknownNameError` for an option that is not taken."""

    def study_options(
        self, level: str, bias_kind: BiasKind | None, route: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Options of a study's scenarios; raises `ParameterError` for those that it does not take."""

    def circuits(self) -> tuple[Circuit, ...]:
        """What it is made of."""

    def run(self, scenario: Any, progress: Callable[[float], None] | None = None) -> Any:
        """Run a scenario; returns what `account`, `summarise` and `draw` take."""

    def account(self, trace: Any) -> Account:
        """What a run says of itself."""

    def summarise(self, trace: Any) -> Summary:
        """The account's entries, and the numbers of a run."""

    def draw(self, trace: Any, figure: Figure) -> None:
        """Fill a figure with a run; its title has the reason."""


def headline(*, succeeded: bool, reason: str) -> str:
    """Success and reason in one line, as `failed: collided with a pipe`."""
    return f"{'succeeded' if succeeded else 'failed'}: {reason}"


def summary_of(account: Account, numbers: Mapping[str, float | None]) -> Summary:
    """Summary of a run: its account, then the system's own numbers."""
    return {**{name: getattr(account, name) for name in ENTRIES}, **numbers}


def metrics_with(numbers: Iterable[str]) -> tuple[str, ...]:
    """What a study can ask for: entries of the account, then the system's own numbers, each once."""
    return tuple(dict.fromkeys((*METRICS, *numbers)))
