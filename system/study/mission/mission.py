"""A mission: a robot that is run on dies, in worlds, with noise, at temperatures, in some ways.

Each way, a temperature and a kind of bias with or without a change, is a study of its own
(`system.study.manifest`): of the same dies, whose trials are the same worlds and the same noise in every way,
so that ways can be compared die by die. A die's worlds and noise are its own (`system.study.plan.seeds_of`).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from circuits.circuit import BiasKind
from circuits.errors import ParameterError
from system.option import Setting
from system.options.silicon import SiliconChoice
from system.reader import with_params
from system.registry import load_system
from system.study.manifest import Study, check_samples
from system.study.metrics.success import Wanted, read_success
from system.study.plan import WORLDS, Plan
from system.study.table import Condition
from system.study.target import Quantity, Subject
from system.system import SUCCEEDED, System

NOISE_SEED = "noise_seed"  # field of scenarios whose noise has a seed of its own
USUAL_CHANGES = "usual"  # in place of a change: those that `usual_changes` gives
AREA = 4.0  # of the usual change: half the mismatch
_NO_FOLDER = re.compile(r"[^\w.=+-]+")  # what the name of a folder has none of


@dataclass(frozen=True, slots=True)
class Asked:
    """What is asked of a mission, as options have it.

    Attributes
    ----------
    system : str
        Name of the robot, one of noctule's or a user's own.
    success : str or None
        When a run counts as a success (`system.study.metrics.success`); by the system's own definition
        unless given.
    first, dies, worlds, trials : int
        First die, how many there are, worlds that each of them meets, and runs in each world.
    temperatures_c : tuple of float
        Temperatures, degC.
    bias_kinds : tuple of str
        Kinds of bias; the system's own unless there are any.
    options : mapping
        Options of the system's scenarios, by name.
    level : str
        Level of its chips.
    changes : tuple of str
        Changes of options that are tried on the same dies, each as `area=4` or `area=4,codes=default`.
    silicon : SiliconChoice
        What all dies share.
    chunk : int
        Dies that are measured and kept together.
    until : float or None
        Half-width of the interval at which a way's yield is known well enough, a share.
    """

    system: str
    success: str | None = None
    first: int = 1000
    dies: int = 100
    worlds: int = 2
    trials: int = 2
    temperatures_c: tuple[float, ...] = (27.0,)
    bias_kinds: tuple[BiasKind, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    level: str = "behavioural"
    changes: tuple[str, ...] = ()
    silicon: SiliconChoice = field(default_factory=SiliconChoice)
    chunk: int = 8
    until: float | None = None


@dataclass(frozen=True, slots=True)
class Way:
    """One way of a mission.

    name : its name, which its folder has.
    temperature_c : temperature, degC.
    bias_kind : kind of bias; empty where the robot has no choice of one.
    change : what is changed of the robot, as `area=4`; empty for the robot as it was asked for.
    study : its dies, and what is measured of them.
    """

    name: str
    temperature_c: float
    bias_kind: str
    change: str
    study: Study

    @property
    def place(self) -> str:
        """Temperature and kind of bias in words."""
        kind = f", bias kind {self.bias_kind}" if self.bias_kind else ""
        return f"{self.temperature_c:g} degC{kind}"

    @property
    def base(self) -> tuple[float, str]:
        """Temperature and kind of bias, which it has in common with the way that it changes."""
        return self.temperature_c, self.bias_kind


@dataclass(frozen=True, slots=True)
class Mission:
    """A mission that can be run.

    asked : what was asked for, unchanged.
    ways : its ways, each one without a change before those that change it.
    wanted : success in the user's words; None for the system's own.
    definition : when a run is a success, in words.
    """

    asked: Asked
    ways: tuple[Way, ...]
    wanted: Wanted | None
    definition: str

    @property
    def runs(self) -> int:
        """Runs of all ways together."""
        return sum(way.study.samples for way in self.ways)


def mission_of(asked: Asked) -> Mission:
    """Make a mission; raises `ParameterError` or `UnknownNameError` naming the option that is wrong."""
    system = load_system(asked.system)
    wanted = None if asked.success is None else wanted_of(system, asked.success)
    _check_counts(system, asked)
    maker = _Maker(system, asked, wanted)
    kinds: tuple[BiasKind | None, ...] = asked.bias_kinds or (None,)
    ways = [way for kind in kinds for celsius in asked.temperatures_c for way in maker.ways(kind, celsius)]
    for name, count in Counter(way.name for way in ways).items():
        if count > 1:
            raise ParameterError(f"mission: {name} is there twice, must be once; leave one out")
    return Mission(asked, tuple(ways), wanted, system.success if wanted is None else wanted.text)


def usual_changes(system: System[Any, Any], options: Mapping[str, Any], celsius: float) -> tuple[str, ...]:
    """Give the changes that may raise a yield: area, calibration, and kind of bias.

    Parameters
    ----------
    system
        The robot.
    options
        Options of its scenarios, by field, before the change.
    celsius
        Temperature of the runs, degC.
    """
    known, scenario = system.settings, system.scenario(**options)
    found = []
    if "area" in known:
        found.append(f"area={AREA * _area(known['area'], scenario, options):g}")
    kind = getattr(scenario, "bias_kind", None)
    if "calibrated_at" in known and kind != "gate":
        if scenario.code_choice == "default":
            found.append("codes=calibrated")
        elif scenario.calibrated_c != celsius:
            found.append(f"calibrated-at={celsius:g}degC")
    if kind is not None:
        found += [f"bias-kind={other}" for other in ("generator", "ideal") if other != kind]
    return tuple(found)


def _area(setting: Setting, scenario: Any, options: Mapping[str, Any]) -> float:
    """Relative area of a robot's devices; 1 where its option sets no field and is not given."""
    if setting.part == "":
        return float(options.get("area", 1.0))
    return float(getattr(getattr(scenario, setting.part) if setting.part else scenario, setting.field))


@dataclass(frozen=True, slots=True)
class _Maker:
    """Makes the ways of a mission."""

    system: System[Any, Any]
    asked: Asked
    wanted: Wanted | None

    def ways(self, kind: BiasKind | None, celsius: float) -> Iterator[Way]:
        """The way without a change, then those with one, but for a kind of bias that is asked for anyway."""
        study = self._study(kind, celsius, {})
        scenario = self.system.scenario(**study.subject.system)
        own = str(getattr(scenario, "bias_kind", ""))
        yield Way(_name(own, celsius, ""), celsius, own, "", study)
        for change in self._changes(study, celsius):
            text = with_params({}, change.split(","))
            other = text.pop("bias_kind", None)
            if other is None or other not in self.asked.bias_kinds:
                study = self._study(other or kind, celsius, text)
                yield Way(_name(own, celsius, change), celsius, own, change, study)

    def _changes(self, base: Study, celsius: float) -> tuple[str, ...]:
        asked = self.asked.changes
        if USUAL_CHANGES not in asked:
            return asked
        usual = usual_changes(self.system, base.subject.system, celsius)
        return tuple(dict.fromkeys((*usual, *(change for change in asked if change != USUAL_CHANGES))))

    def _study(self, kind: BiasKind | None, celsius: float, changed: Mapping[str, Any]) -> Study:
        asked, own = self.asked, self.system.study_metrics
        options = self.system.study_options(asked.level, kind, {**asked.options, **changed})
        self._check_noise(options)
        remedy = self.system.no_silicon(self.system.scenario(**options))
        if remedy:
            raise ParameterError(f"mission: no chip is in the loop, so that all dies are alike; {remedy}")
        metrics = dict.fromkeys((SUCCEEDED, *own, *(self.wanted.metrics if self.wanted else ())))
        subject = Subject(
            asked.system, tuple(metrics), silicon=asked.silicon, system=options, noises=asked.trials
        )
        conditions = tuple(Condition("random", celsius, k) for k in range(asked.worlds * asked.trials))
        return Study(subject, Plan("random", 0, asked.first, asked.dies), conditions, asked.chunk)

    def _check_noise(self, options: Mapping[str, Any]) -> None:
        """Refuse several runs in a world where the noise, in which alone they differ, is off."""
        if self.asked.trials > 1:
            try:
                self.system.scenario(**options, **{NOISE_SEED: 0})
            except ParameterError as error:
                if not str(error).startswith(NOISE_SEED):
                    raise
                raise ParameterError(f"trials: {self.asked.trials}, there is no noise; take 1") from None


def _name(kind: str, celsius: float, change: str) -> str:
    return "-".join(filter(None, (kind, f"{celsius:g}C", _NO_FOLDER.sub("-", change))))


def wanted_of(system: System[Any, Any], text: str) -> Wanted:
    """Read a success in the user's words; raises as of `read_success`."""
    units = {name: Quantity(name, "").limit_unit for name in system.metrics}
    return read_success(text, units)


def _check_counts(system: System[Any, Any], asked: Asked) -> None:
    """Refuse counts that no mission has."""
    for name, most in (("dies", None), ("worlds", WORLDS), ("trials", WORLDS)):
        value = getattr(asked, name)
        if value < 1 or (most is not None and value > most):
            limit = "" if most is None else f" and at most {most}"
            raise ParameterError(f"{name}: {value}, must be at least 1{limit}")
    if asked.until is not None and not 0.0 < asked.until < 0.5:
        raise ParameterError(f"until: {asked.until:g}, must be above 0 and below 50 %; write as in 2%")
    if asked.trials > 1 and NOISE_SEED not in system.settings:
        raise ParameterError(
            f"trials: {asked.trials}, noise of {system.name} has no seed of its own; take 1, and more worlds"
        )
    if asked.dies > 1 and not (asked.silicon.mismatch or asked.silicon.process_variation):
        raise ParameterError("mismatch: none, and no process varies either, so all dies are one; leave it on")
    check_samples(asked.dies, asked.worlds * asked.trials)
