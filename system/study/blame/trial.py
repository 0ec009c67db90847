"""Trials of a robot on a die some parts of which are healed: each is made once, and all are counted."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from hashlib import sha256
from typing import Any

from circuits.errors import CircuitError, DataError
from circuits.silicon.die import Die, Drawn, Family, drawn_for, noted
from circuits.silicon.edit import DEVIATIONS, Edit, overlap
from system.codes.find import quietly
from system.options.codes import CALIBRATED
from system.study.metrics.success import Wanted
from system.system import SUCCEEDED, System

ALL = ("*",)
CODED_ON = "coded_on"  # field of scenarios whose chips have codes


class SpentError(Exception):
    """All runs that were allowed are made."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """What a trial came to.

    Attributes
    ----------
    succeeded : bool
        Whether it did what the system is for; a chip that cannot be used does not.
    failed : str
        Why it was not run; empty where it was.
    """

    succeeded: bool
    failed: str = ""


@dataclass(frozen=True, slots=True)
class Case:
    """A robot on a die.

    Attributes
    ----------
    system : System
        What the robot is, by which every trial of it is run.
    scenario : dataclass
        Its first trial, on the die that is to be blamed.
    wanted : Wanted or None
        Success in the user's words; the system's own sentence unless given.
    recalibrated : bool
        Whether each edited die has codes of a calibration of its own, rather than those of the die to blame.
    """

    system: System[Any, Any]
    scenario: Any
    wanted: Wanted | None = None
    recalibrated: bool = False

    @property
    def definition(self) -> str:
        """When a run is a success, in words."""
        return self.system.success if self.wanted is None else self.wanted.text

    def success(self, summary: Mapping[str, Any]) -> bool:
        """Say whether a run is a success, from its summary."""
        return bool(summary[SUCCEEDED]) if self.wanted is None else self.wanted.met_by(summary)

    @property
    def die(self) -> Die:
        """The die that is to be blamed."""
        found: Die = self.scenario.die
        return found

    @property
    def coded(self) -> bool:
        """Whether its chips have codes."""
        return any(one.field == CODED_ON for one in self.system.settings.values())

    @property
    def calibrated(self) -> bool:
        """Whether its chips have codes of a calibration of the die."""
        s = self.scenario
        return self.coded and s.code_choice == CALIBRATED and s.coded_on is None

    def on(self, die: Die, seed: int, *, own_codes: bool | None = None, **given: Any) -> Any:
        """Return the scenario of a trial.

        Parameters
        ----------
        die
            The die, as edited.
        seed
            Seed of noise and world.
        own_codes
            Whether codes are those of that die, rather than those of the die to blame; as of the case unless
            given.
        given
            Fields that go over those of the first trial.
        """
        own_codes = self.recalibrated if own_codes is None else own_codes
        held = {CODED_ON: self.scenario.coded_on or self.die} if self.coded and not own_codes else {}
        return replace(self.scenario, **held, **given, die=die, seed=seed)

    def healed(self, paths: Sequence[str]) -> Die:
        """Return the die with parts healed, those that were set by hand too."""
        return healed(self.die, paths)

    def drawn(self) -> dict[Family, Drawn]:
        """Return what a trial draws on the die."""
        name = sha256(repr(replace(self.scenario, seed=0)).encode()).hexdigest()[:16]
        die = noted(self.die, f"{self.system.name} {name}")
        if not drawn_for(die):
            outcome_of(lambda: self.system.run(self.on(die, self.scenario.seed)))
        return drawn_for(die)


def healed(die: Die, paths: Sequence[str]) -> Die:
    """Return a die with parts healed; what was set by hand there is set to 0, which goes over what was."""
    if not paths:
        return die
    found = die.healed(*paths)
    told = [edit for edit in die.edits if edit.kind == "set"]
    for path in paths if told else ():
        owner, _, last = path.rpartition(".")
        whole = owner if last in DEVIATIONS else path
        names = {edit.parameter for edit in told if any(overlap(whole, one) for one in edit.paths)}
        for name in sorted(names & {last} if last in DEVIATIONS else names):
            found = replace(found, edits=(*found.edits, Edit("set", (whole,), name)))
    return found


def outcome_of(run: Callable[[], Any]) -> Any:
    """Return what a run leaves, or the `CircuitError` for which it was not made; a record's is raised."""
    try:
        with quietly():
            return run()
    except DataError:  # of a record: it would be that of every die
        raise
    except CircuitError as error:
        return error


@dataclass(slots=True)
class Trials:
    """Trials of a case, each made once.

    case : the robot on the die.
    most : trials that may be made.
    made : trials that were.
    told : told of the number that were made, after each.
    """

    case: Case
    most: int = 300
    made: int = 0
    told: Callable[[int], None] = lambda _: None
    _kept: dict[tuple[Die, int, bool, str], Outcome] = field(default_factory=dict)

    def succeeds(self, die: Die, seed: int, *, own_codes: bool | None = None, codes: str = "") -> bool:
        """Say whether a trial on an edited die succeeds; raises `SpentError` where no more may be made.

        own_codes : as of `Case.on`; codes : option that goes over that of the case; none for that.
        """
        key = self._key(die, seed, own_codes=own_codes, codes=codes)
        if key not in self._kept:
            if self.made >= self.most:
                raise SpentError
            given = {"codes": codes} if codes else {}
            self._kept[key] = trial(self.case, die, seed, own_codes=key[2], **given)
            self.made += 1
            self.told(self.made)
        return self._kept[key].succeeded

    def known(self, die: Die, seed: int) -> bool:
        """Say whether a trial was made."""
        return self._key(die, seed) in self._kept

    def failure(self, die: Die, seed: int) -> str:
        """Return why a trial that was asked for was not run; empty where it was."""
        return self._kept[self._key(die, seed)].failed

    def _key(
        self, die: Die, seed: int, *, own_codes: bool | None = None, codes: str = ""
    ) -> tuple[Die, int, bool, str]:
        """What tells a trial from others: codes of the die to blame are its own."""
        own = self.case.recalibrated if own_codes is None else own_codes
        return die, seed, own and (bool(codes) or die != self.case.die), codes


def trial(case: Case, die: Die, seed: int, *, own_codes: bool | None = None, **given: Any) -> Outcome:
    """Run a case once on a die; arguments as of `Case.on`."""
    trace = outcome_of(lambda: case.system.run(case.on(die, seed, own_codes=own_codes, **given)))
    if isinstance(trace, CircuitError):
        return Outcome(succeeded=False, failed=str(trace))
    return Outcome(case.success(case.system.summarise(trace)))
