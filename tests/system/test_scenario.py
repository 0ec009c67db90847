"""Scenarios from Python, over the registry: each field and option is taken, any other name is refused."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest

from circuits.errors import ParameterError, UnknownNameError
from circuits.generator.ripple import Ripple
from circuits.silicon.die import Die
from system.car.numbers import OpenspaceNumbers, Robot
from system.head.numbers import Motion, SonarHead
from system.openspace.law import Bat
from system.openspace.senses import Sensing
from system.registry import SYSTEMS, load_system
from system.rover.body import Rover
from system.worlds.sound.targets import default_scene

DIE = {
    "die": Die(number=1003), "seed": 3, "law": "ideal", "bias_kind": "gate", "outside": "warn",
    "ripple": Ripple(10e-3, 50.0),
}  # fmt: skip
WARM = {**DIE, "temperature_c": 30.0, "course": ((0.0, 27.0), (60.0, 44.0))}
CODED = {**WARM, "codes": "default", "calibrated_c": 20.0, "coded_on": Die(number=5)}

# another value than the usual one for every field of each scenario; what it needs besides is NEEDED
FIELDS: dict[str, dict[str, Any]] = {
    "approach": {
        **CODED, "targets": default_scene()[:1], "duration": 1.0, "isolation": False, "amplitude_law": "d4",
        "noise_rms": 1e-3, "level": "behavioural", "transistors": frozenset({"chip"}),
        "silicon_noise": "white", "noise_seed": 6,
    },
    "rover": {
        **CODED, "map": "map2", "start": (3, 3), "goal": (4, 4), "planner": "dijkstra", "cells": "chip",
        "need": "speed", "learn": 0.5, "prior": 2.0, "trips": 2, "posts": True, "sonar": True,
        "unit": 2e-4, "silicon_noise": "white", "noise_seed": 6, "rover": Rover(reach=5.0),
    },
    "forest": {
        **CODED, "bat": Bat(max_speed=1.0), "sensing": Sensing(ranges="chip"), "map": "forest.csv",
        "obstacles": 900, "start": (1.0, 2.0), "pings": 7, "rows": 5, "escape": 3,
    },
    "car": {
        **CODED, "robot": Robot(max_speed=0.1), "openspace": OpenspaceNumbers(retreat=0.1), "forest": "open",
        "ranges": "chip", "occlusion": False, "multipath": False, "soft_pings": False,
        "silicon_noise": "white", "noise_seed": 4, "start": (-0.5, 0.1), "pings": 9,
    },
    "spiking-bat": {
        **WARM, "brain": "chip", "max_speed": 1.0, "ping_rate": 8.0, "paths": 30, "taps": 20,
        "map": "forest.csv", "obstacles": 900, "start": (1.0, 2.0), "pings": 7,
        "codes": "default", "calibrated_c": 30.0, "coded_on": Die(number=5), "area": 2.0, "units": ((16, 5),),
        "silicon_noise": "white", "noise_seed": 6,
    },
    "head": {
        **CODED, "head": SonarHead(ping_rate=5.0), "target": Motion(distance=2.0), "motion": "step",
        "wiring": "one-ear", "duration": 3.0, "area": 0.5, "silicon_noise": "white",
        "noise_seed": 2,
    },
    "bug": {
        **WARM, "agent": "bug0", "brain": "chip", "design": "improved", "neurons": 600, "map": "bug-open",
        "start": "2,2", "goal": "3,3", "duration": 5.0, "calibrated_c": 20.0, "codes": "default",
        "solved_c": 21.0, "coded_on": Die(number=5),
        "area": 2.0, "silicon_noise": "white", "noise_seed": 9,
    },
    "pushbot": {
        **WARM, "scene": "pair", "speed_factor": 1.0, "turn_factor": 1.0, "window": 0.1, "readout": "fixed",
        "modified": True, "dropped": 0.5, "colour": "red", "light": "dark", "target": True, "duration": 3.0,
        "way": 2.0, "exc": 12, "codes": "default", "calibrated_c": 20.0,
        "coded_on": Die(number=5), "frame": True, "raise_lateral": True,
        "silicon_noise": "white", "noise_seed": 8, "process": "coach-180",
    },
    "rolls": {
        **WARM, "bias_file": "rolls_parallella", "input_rate": 50.0, "step": 2e-4, "duration": 2.0,
        "silicon_noise": "white", "noise_seed": 6, "codes": "default", "calibrated_c": 30.0,
        "coded_on": Die(number=5), "process": "coach-180",
    },
}  # fmt: skip

# what must be there for a field's other value to make sense
NEEDED: dict[str, dict[str, Any]] = {
    "approach": {"level": "behavioural"},
    "rover": {"cells": "chip"},
    "forest": {"sensing": Sensing(ranges="chip")},
    "spiking-bat": {"brain": "chip"},
    "car": {"ranges": "chip"},
    "head": {},
    "bug": {"brain": "chip"},
    "pushbot": {},
    "rolls": {},
}
# a map has its own obstacles, a unit at transistor level no other area, and fixed gates no ripple
APART = {("forest", "obstacles"), ("spiking-bat", "obstacles"), ("spiking-bat", "units")}
APART |= {(name, "ripple") for name in FIELDS}
EACH = [(name, field) for name in FIELDS for field in FIELDS[name]]


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_name_that_is_not_taken_is_refused_with_those_that_are(name: str) -> None:
    system = load_system(name)
    with pytest.raises(UnknownNameError, match=rf"{name}\.scenario\.sensors: unknown.* taken are ") as caught:
        system.scenario(sensors=3)
    said = str(caught.value).partition(" taken are ")[2].split(", ")
    assert {f.name for f in fields(system.scenario())} <= set(said)
    assert not [word for word in said if word.isupper()]


@pytest.mark.parametrize("name", SYSTEMS)
def test_every_field_has_a_value_here(name: str) -> None:
    assert set(FIELDS[name]) == {f.name for f in fields(load_system(name).scenario())}


@pytest.mark.parametrize(("name", "field"), EACH)
def test_every_field_is_taken(name: str, field: str) -> None:
    system, value = load_system(name), FIELDS[name][field]
    assert getattr(system.scenario(), field) != value
    assert getattr(system.scenario(**{**NEEDED[name], field: value}), field) == value


@pytest.mark.parametrize("name", SYSTEMS)
def test_all_fields_together_are_those_of_the_dataclass(name: str) -> None:
    system = load_system(name)
    kind = type(system.scenario())
    given = {field: value for field, value in FIELDS[name].items() if (name, field) not in APART}
    assert system.scenario(**given) == kind(**given)
    assert system.scenario() == kind()


def test_options_of_the_command_line_are_taken_too() -> None:
    forest = load_system("forest").scenario(ranges="chip", vmax=1.0, start="3m,4m", azimuth_noise=2.0)
    assert forest.sensing == Sensing(ranges="chip", azimuth_noise=math.radians(2.0))
    assert (forest.bat, forest.start) == (Bat(max_speed=1.0), (3.0, 4.0))
    assert load_system("bug").scenario(brain="chip", calibrated_at="30degC").calibrated_c == 30.0
    assert load_system("rover").scenario(start="3,4").start == (3, 4)
    assert load_system("pushbot").scenario(window="100ms").window == 0.1
    assert load_system("head").scenario(distance=2.0).target == replace(Motion(), distance=2.0)


@pytest.mark.parametrize(
    ("name", "given", "says"),
    [
        (
            "forest",
            {"sensing": Sensing(), "ranges": "chip"},
            "forest.scenario.ranges: chip, not with sensing",
        ),
        ("forest", {"bat": Bat(), "vmax": 1.0}, "forest.scenario.vmax: 1.0, not with bat"),
        ("car", {"robot": Robot(), "ping_rate": 3.0}, "car.scenario.ping_rate: 3.0, not with robot"),
        ("head", {"target": Motion(), "swing": 0.1}, "head.scenario.swing: 0.1, not with target"),
        ("bug", {"calibrated_at": 30.0, "calibrated_c": 20.0}, "bug.scenario.calibrated_at: 30.0, not with"),
        ("forest", {"sensing": "chip"}, "forest.scenario.sensing: 'chip', must be a Sensing"),
        ("rover", {"die": 1003}, "rover.scenario.die: 1003, must be a Die"),
        ("rover", {"rover": 3.0}, "rover.scenario.rover: 3.0, must be a Rover"),
        ("forest", {"pings": 10.5}, "pings: 10.5, must be a whole number"),
        ("forest", {"pings": True}, "pings: True, must be a whole number"),
        ("rover", {"trips": 2.5}, "trips: 2.5, must be a whole number"),
        ("approach", {"duration": [1.0]}, "duration: [1.0], must be a number"),
        ("car", {"forest": 3}, "forest: 3, must be a text"),
        ("rover", {"map": 3}, "map: 3, must be a text"),
        ("pushbot", {"scene": None}, "scene: None, must be a text"),
        ("bug", {"start": 3}, "start: 3, must be a text"),
        ("rover", {"start": 3}, "start: 3, must be a tuple of 2 whole numbers"),
        ("rover", {"start": (0, 0, 0)}, "start: (0, 0, 0), must be a tuple of 2 whole numbers"),
        ("car", {"start": ("a", "b")}, "start: ('a', 'b'), must be a tuple of 2 numbers or None"),
        ("car", {"start": (math.nan, 0.0)}, "start: (nan, 0.0), must be finite numbers"),
        ("car", {"vmax": [1.0]}, "vmax: [1.0], must be a number"),
        ("car", {"vmax": None}, "vmax: None, must be a number"),
        ("head", {"azimuth": True}, "azimuth: True, must be a number"),
        ("approach", {"targets": 3}, "targets: 3, must be a tuple of Targets"),
        ("approach", {"codes": 3}, "codes: 3, must be a text or None"),
        ("approach", {"course": ((0.0,),)}, "course: ((0.0,),), must be a tuple of tuples of 2 numbers"),
        ("forest", {"obstacles": None}, "obstacles: None, must be a whole number"),
        ("forest", {"area": [1.0]}, "area: [1.0], must be a number"),
    ],
)
def test_what_does_not_fit_is_refused(name: str, given: dict[str, Any], says: str) -> None:
    with pytest.raises(ParameterError) as caught:
        load_system(name).scenario(**given)
    assert str(caught.value).startswith(says)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", SYSTEMS)
@pytest.mark.parametrize("value", [object(), {"a": 1}, [[]], b"27"])
def test_no_option_takes_what_is_no_value(name: str, value: object) -> None:
    """Every field and option is refused by its name, in whatever order a scenario looks at them."""
    system = load_system(name)
    for each in {*FIELDS[name], *system.settings}:
        with pytest.raises(ParameterError, match=rf"\b{each}: "):
            system.scenario(**{each: value})


def test_lists_and_paths_are_taken_as_the_tuples_and_texts_that_they_are() -> None:
    car = load_system("car").scenario(start=[-0.5, 0.1], forest=Path("own.csv"))
    assert (car.start, car.forest) == ((-0.5, 0.1), "own.csv")
    approach = load_system("approach").scenario(transistors="chip", course=[[0.0, 27.0], [1.0, 30.0]])
    assert approach.transistors == frozenset({"chip"})
    assert approach.course == ((0.0, 27.0), (1.0, 30.0))


def test_a_scenario_that_is_made_by_its_class_is_checked_too() -> None:
    car, forest = type(load_system("car").scenario()), type(load_system("forest").scenario())
    for made, told in (
        (lambda: car(forest=3), "forest: 3, must be a text"),
        (lambda: car(start=(0.0,)), r"start: \(0\.0,\), must be a tuple of 2 numbers or None"),
        (lambda: forest(seed=None), "seed: None, must be a whole number"),
    ):
        with pytest.raises(ParameterError, match=told):
            made()


CHOICES = [
    (name, field)
    for name in FIELDS
    for field in ("bias_kind", "silicon_noise", "level", "amplitude_law", "readout")
    if field in FIELDS[name]
]


@pytest.mark.parametrize(("name", "field"), CHOICES)
def test_a_word_that_is_none_of_a_few_is_refused(name: str, field: str) -> None:
    with pytest.raises(ParameterError, match=rf"{name}\.scenario\.{field}: loud, must be "):
        load_system(name).scenario(**{**NEEDED[name], field: "loud"})


@pytest.mark.parametrize(("name", "field"), [("car", "occlusion"), ("pushbot", "target"), ("rover", "posts")])
def test_what_is_yes_or_no_is_no_word(name: str, field: str) -> None:
    with pytest.raises(ParameterError, match=rf"{name}\.scenario\.{field}: 'maybe', must be True or False"):
        load_system(name).scenario(**{field: "maybe"})


STUDIED = {
    "level": ("transistor", None, "transistor", {"approach"}),
    "bias_kind": ("behavioural", "ideal", "ideal", set(SYSTEMS)),
}


@pytest.mark.parametrize("field", STUDIED)
@pytest.mark.parametrize("name", SYSTEMS)
def test_a_study_takes_level_and_kind_of_biases_or_refuses_them(name: str, field: str) -> None:
    system = load_system(name)
    level, kind, value, takers = STUDIED[field]
    if name in takers:
        found = system.scenario(**system.study_options(level, kind, {}))  # type: ignore[arg-type]
        assert getattr(found, field) == value
    else:
        with pytest.raises(ParameterError, match=f"{field}: "):
            system.study_options(level, kind, {})  # type: ignore[arg-type]


def test_a_near_name_is_guessed() -> None:
    with pytest.raises(UnknownNameError, match="did you mean sensing"):
        load_system("forest").scenario(sening=Sensing())
