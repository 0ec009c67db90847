"""What every system is: how a scenario is made, run, summed up and drawn; and what a run says of itself.

A run's summary begins with its account, which has the same entries for every system (`ENTRIES`). Numbers of
the system's own follow. `METRICS` are the entries that a study can measure.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar, final

from circuits.errors import ParameterError, meant
from circuits.units import unit_of_name
from system.meaning import Meaning, meanings, numbers_of
from system.option import Option, Setting, check_kind
from system.reader import shown
from system.scenario import Make, all_settings, keep, read_texts, scenario_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from circuits.arrays import F64
    from circuits.circuit import BiasKind, Circuit
    from system.live.robot import LiveRobot
    from system.view.film import Film

ENTRIES = meanings("""
succeeded        boolean   -  whether the run did what the system is for, by its own sentence `success`
reason           string    -  the one reason why the run ended, the same in text, JSON and picture
distance_m       number?   m  way travelled; null where nothing travels
emergency_share  number?   -  emergencies over decisions, 0 to 1; null where there are none to make
standing_share   number?   -  share of the time at rest, 0 to 1; null where nothing can come to rest
ran_on           object    -  what the run was on, as level, die, bias kind, ranges, selection, cells, brain
parts            string{}  -  what each part of the robot was: a chip, a model or a program, and why
cautions         string[]  -  sentences, where its chips are outside of what they were made or measured for
""")
DRAWN = 1000
"""Number of the die on which a robot runs unless another is asked for: the first beyond those of tuning."""
SUCCEEDED = "succeeded"
PROGRAMS = "programs; no chip does that"
"""What the parts of a robot are for which there is no chip."""
METRICS = (SUCCEEDED, "distance_m", "emergency_share", "standing_share")

S = TypeVar("S")
T = TypeVar("T")
S_contra = TypeVar("S_contra", contravariant=True)
T_co = TypeVar("T_co", covariant=True)
Progress = Callable[[float], None]
Summary = dict[str, Any]  # entries of an account, then numbers (None where not defined), by their names


@dataclass(frozen=True, slots=True)
class Account:
    """What a run says of itself; `ENTRIES` has the unit of each entry.

    Attributes
    ----------
    succeeded : bool
        Whether it has succeeded, by the system's own definition.
    reason : str
        Why it ended.
    ran_on : mapping
        What it ran on, by name, numbers in the unit that the name ends with: chip, die and the like.
    parts : mapping of str to str
        What each part of the robot was, by its name: which chip, or a program, and why.
    distance_m : float or None
        Length of the way, m; None for what does not move in metres.
    emergency_share : float or None
        Share of the decisions that were emergencies; None where there are none.
    standing_share : float or None
        Share of the time at rest; None where that means nothing.
    cautions : tuple of str
        What its chips warn of, a sentence each.
    outside : tuple of str
        Sides of its chips' validity boxes that it left, a sentence each; the summary has them as cautions.
    """

    succeeded: bool
    reason: str
    ran_on: Mapping[str, str | float | bool | None]
    parts: Mapping[str, str] = field(default_factory=dict)
    distance_m: float | None = None
    emergency_share: float | None = None
    standing_share: float | None = None
    cautions: tuple[str, ...] = ()
    outside: tuple[str, ...] = ()

    @property
    def headline(self) -> str:
        """Whether it succeeded and why it ended, in one line."""
        return headline(succeeded=self.succeeded, reason=self.reason)


@dataclass(frozen=True, slots=True, eq=False)
class RunTrace(Generic[S]):
    """What a run leaves, to which every system adds its own.

    scenario : what was asked for.
    outside : sides of its chips' validity boxes that it left, a sentence each.
    """

    scenario: S
    outside: tuple[str, ...] = field(default=(), kw_only=True)


class Run(Protocol[S_contra, T_co]):
    """Runs a scenario; `progress` is told the share that is done."""

    def __call__(self, scenario: S_contra, progress: Progress | None = None) -> T_co:
        """The run's trace."""


def _always(_: Any) -> str:
    return ""


def _nothing(_: Any) -> dict[str, Any]:
    return {}


def _no_lines(_: Any) -> tuple[str, ...]:
    return ()


def _unchecked(_: Any) -> None:
    pass


def _no_circuits() -> tuple[Circuit, ...]:
    return ()


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class Output(Generic[T]):
    """A file that `noctule run` leaves of a run, as an option of that name says.

    help, metavar : of the option.
    check : refuses a path before the run, by a `ParameterError`.
    write : writes the file, and tells the share that is done.
    refuse : says why a scenario's run has nothing to write, "" where it has; None: every run has.
    trains : spike trains that the file has, s, by the name of their address; None for another file.
    """

    help: str
    check: Callable[[str], None]
    write: Callable[[str, T, Progress], None]
    metavar: str = "FILE"
    refuse: Callable[[Any], str] | None = None
    trains: Callable[[T], Mapping[str, F64]] | None = None


@final
@dataclass(frozen=True, slots=True, kw_only=True)
class System(Generic[S, T]):
    """A robot in its world, as the command line, studies and Python see it.

    Attributes
    ----------
    name, summary : str
        Name on the command line, and a line of what it is.
    success : str
        A sentence that says when a run of it has succeeded.
    kind : type
        Dataclass of its scenarios, whose fields carry their options (`system.option`); it has `seed`,
        and `die` and `temperature_c` (degC) where it runs on silicon.
    run : Run
        Runs a scenario; what it leaves is the trace that the rest takes.
    account, numbers : callable
        What a run says of itself, and its other numbers by name in SI units, None where not defined.
    draw : callable
        Fills a figure with a run; its title has the reason.
    draw_beside : callable or None
        Draws over the picture of a run what another run's differs in, with the name of its die; None for a
        system whose pictures have no room for it.
    film : callable or None
        What a run shows over time, with what is inside the neurons of the names that are given, None for
        those that it chooses; title, headline and facts are added (`filmed`). None for a system without.
    metrics : tuple of str
        Names of the numbers that a study can ask of a run, `METRICS` among them; all numbers that `meanings`
        tells of, unless given.
    yes_no : tuple of str
        Metrics that are 1 or 0, for yes or no, `SUCCEEDED` among them.
    usual : callable
        Options with which every decision and every sense that has a chip is on that chip, beside those that
        are given; it sees the latter.
    ideal : mapping of str to object
        Options with which a program or the nominal die under the papers' equations stands in place of every
        chip.
    study_metrics : tuple of str
        Metrics that a study measures unless asked for others.
    study : callable
        Options of a study's scenarios over which those that are given go; it sees the latter.
    check_study : callable
        Refuses a study's scenario that the scenario's own rules let pass, as for a missing file.
    check_run : callable
        Refuses what is of no use in a scenario that is asked for at the command line.
    no_silicon : callable
        Says of a scenario without a chip in the loop what puts one there; empty where there is one.
    more : mapping of str to Option
        Options that set no single field.
    make : callable
        Makes fields of what these are given.
    document : callable
        Entries of a run's JSON besides those of its scenario and its summary.
    meanings : mapping of str to Meaning
        Type, unit and words of what `numbers` and `document` give (`system.meaning.of_run`).
    title, before, after : callable
        Heading of a run's table, and lines over and under it.
    outputs : mapping of str to Output
        Files that a run can leave, by the name of their option.
    circuits : callable
        What it is made of; a study's identity has them.
    open : callable or None
        Makes the robot of a scenario that goes on by one action at a time; None for a system that has none.
    """

    name: str
    summary: str
    success: str
    kind: type[S]
    run: Run[S, T]
    account: Callable[[T], Account]
    numbers: Callable[[T], Mapping[str, float | None]]
    draw: Callable[[T, Figure], None]
    metrics: tuple[str, ...] = ()
    draw_beside: Callable[[T, Figure], None] | None = None
    film: Callable[[T, tuple[str, ...] | None], Film] | None = None
    yes_no: tuple[str, ...] = (SUCCEEDED,)
    usual: Callable[[Mapping[str, Any]], Mapping[str, Any]] = _nothing
    ideal: Mapping[str, Any] = field(default_factory=dict)
    study_metrics: tuple[str, ...] = ()
    study: Callable[[Mapping[str, Any]], Mapping[str, Any]] = _nothing
    check_study: Callable[[S], None] = _unchecked
    check_run: Callable[[S], None] = _unchecked
    no_silicon: Callable[[S], str] = _always
    more: Mapping[str, Option] = field(default_factory=dict)
    make: Make = keep
    document: Callable[[T], Mapping[str, Any]] = _nothing
    meanings: Mapping[str, Meaning] = field(default_factory=dict)
    title: Callable[[T], str] = _always
    before: Callable[[T], Iterable[str]] = _no_lines
    after: Callable[[T], Iterable[str]] = _no_lines
    outputs: Mapping[str, Output[T]] = field(default_factory=dict)
    circuits: Callable[[], tuple[Circuit, ...]] = _no_circuits
    open: Callable[[S], LiveRobot] | None = None

    def __post_init__(self) -> None:
        """Take the metrics that `meanings` tells of, unless there are others."""
        if not self.metrics:
            object.__setattr__(self, "metrics", metrics_with(numbers_of(self.meanings)))

    @property
    def settings(self) -> dict[str, Setting]:
        """Its options by the names that users have for them, with underscores."""
        return all_settings(self.kind, self.more)

    def scenario(self, **given: Any) -> S:
        """Return a scenario with the fields and options `given` by name (`system.scenario.scenario_of`)."""
        return scenario_of(self.name, self.kind, given, self.more, self.make)

    def on_silicon(self, *, ideal: bool = False, **given: Any) -> S:
        """Return the scenario of a run as `noctule run` has it: on chips of a drawn die.

        Parameters
        ----------
        ideal
            Whether programs stand in place of all chips instead.
        given
            Fields and options by name, which go over these.

        Raises
        ------
        ParameterError
            An option puts a chip into the loop, and all are to be programs.
        """
        check_kind("ideal", bool, ideal)
        for name, value in self.ideal.items() if ideal else ():
            if given.get(name, value) != value:
                raise ParameterError(
                    f"{name}: {given[name]}, not with `ideal`, which is {value}; leave one out"
                )
        chosen = self.ideal if ideal else self.usual(given)
        scenario = self.scenario(**{**chosen, **given})
        if ideal or "die" in given or "die" not in self.settings or self.no_silicon(scenario):
            return scenario
        drawn = replace(self.settings["die"].default, number=DRAWN)
        return self.scenario(**{**chosen, **given, "die": drawn})

    def summarise(self, trace: T) -> Summary:
        """Return the entries of the account of the run `trace`, and its numbers, by their names."""
        return summary_of(self.account(trace), self.numbers(trace))

    def filmed(self, trace: T, inside: Sequence[str] | None = None, command: str = "") -> Film:
        """Return the film of a run, with what the run says of itself.

        Parameters
        ----------
        trace
            What the run left.
        inside
            Names of neurons to look into; those that the system chooses unless given.
        command
            The command that makes the run again.

        Raises
        ------
        ParameterError
            The system has no film, or no neuron of a name.
        """
        if self.film is None:
            raise ParameterError(f"{self.name}: it has no film; draw a picture of it")
        account = self.account(trace)
        facts = {spoken(name): told(value) for name, value in account.ran_on.items()}
        return replace(
            self.film(trace, None if inside is None else tuple(inside)),
            title=f"{self.name}, {self.title(trace)}",
            headline=account.headline,
            command=command,
            facts={**facts, **account.parts},
        )

    def study_options(
        self, level: str, bias_kind: BiasKind | None, given: Mapping[str, Any]
    ) -> dict[str, Any]:
        """Options of a study's scenarios.

        Parameters
        ----------
        level
            `behavioural` or `transistor`.
        bias_kind
            Kind of the chip's biases; the scenario's own where None.
        given
            Options by name, texts or values.

        Raises
        ------
        ParameterError
            A study of the system does not take an option, or its text is none.
        """
        options = {name: one for name, one in self.settings.items() if one.option.study}
        names = {one.field: name for name, one in options.items() if one.part is None}
        asked: dict[str, Any] = {}
        for name, value in given.items():
            one = options.get(names.get(name, name))
            if one is None:
                known = [shown(n) for n in options]
                advice = meant(shown(name), known) or "; leave it out"
                raise ParameterError(
                    f"{name}: not an option of {self.name}, its study has {', '.join(known)}{advice}"
                )
            asked[name if one.part else one.field] = _kept(
                one.option, read_texts({name: one}, {name: value})[name]
            )
        for name, value, usual in (("bias_kind", bias_kind, None), ("level", level, "behavioural")):
            if name in self.settings:
                asked |= {} if value is None else {name: value}
            elif value != usual:
                raise ParameterError(f"{name}: {value}, is no choice of {self.name}; leave it out")
        on_chips = {**self.usual(asked), **asked}
        found = {**on_chips, **self.study(on_chips), **asked}
        self.check_study(self.scenario(**found))
        return found


def _kept(option: Option, value: Any) -> Any:
    """A value as a manifest can have it: its text where it is data of a kind of its own."""
    return value if option.write is None or value is None else option.write(value)


def spoken(name: str) -> str:
    """A key as a reader is told it, with its unit in brackets."""
    unit = unit_of_name(name)
    return without_unit(name) + (f" ({unit})" if unit else "")


def without_unit(name: str) -> str:
    """Words of a key without the unit that it ends with."""
    unit = unit_of_name(name)
    ending = unit.replace("degC", "C").replace("/", "_per_")
    return (name.removesuffix(f"_{ending}") if unit else name).replace("_", " ")


def told(value: object) -> str:
    """A number, a name, or a yes or no, as a reader is told it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, float) else "none" if value is None else str(value)


def headline(*, succeeded: bool, reason: str) -> str:
    """Say whether a run succeeded and why it ended, as `failed: collided with a pipe`."""
    return f"{'succeeded' if succeeded else 'failed'}: {reason}"


def part(choice: str, chip: str, instead: Mapping[str, str]) -> str:
    """Return what a part of a robot was: its `chip`, or what a `choice` of an option has `instead` of it."""
    return f"{instead[choice]}, as asked for" if choice in instead else chip


def summary_of(account: Account, numbers: Mapping[str, float | None]) -> Summary:
    """Return the summary of a run: its account, then the system's own numbers."""
    found = {name: getattr(account, name) for name in ENTRIES}
    return {**found, "cautions": (*account.cautions, *account.outside), **numbers}


def metrics_with(numbers: Iterable[str]) -> tuple[str, ...]:
    """Return what a study can ask for: entries of the account, then the system's own numbers, each once."""
    return tuple(dict.fromkeys((*METRICS, *numbers)))
