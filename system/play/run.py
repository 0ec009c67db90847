"""A run of any system step by step, with a controller of one's own in place of noctule's, or over it.

    for step in open_run("forest", map="own.csv", seed=1000):
        step.observation, step.action              what the bat hears, and what noctule would do
        step.action = [16, 2, 0]                   what it does instead

A step is handed out before its action is taken, so that the loop's body can look at it and change it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import wraps
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import ArrayLike

from chips.validity import outside_boxes
from circuits.arrays import F64
from circuits.errors import ParameterError
from system.option import check_kind
from system.options.code import code_of, guarded, load_code
from system.registry import load_system, system_names
from system.system import System

if TYPE_CHECKING:
    from system.live.robot import LiveRobot
    from system.live.signals import Array

Controller = Callable[[Any], ArrayLike]
Maker = Callable[[Mapping[str, Any]], "LiveRobot"]


@dataclass(slots=True, eq=False)
class Step:
    """What a run step by step shows before each step is taken.

    Attributes
    ----------
    time : float
        Time since the start, s.
    observation : array
        What the robot senses, in the shape that the robot's `senses` say.
    readings : object
        What the observation was made of: events, echoes or spikes as the robot has them.
    action : array
        What it will do, in the shape of the robot's `actions`; another one may be put here.
    reward : float
        Reward of the step before, in the unit that the system's page says.
    """

    time: float
    observation: Array
    readings: Any
    action: ArrayLike
    reward: float


class LiveRun:
    """A run that goes on by one step at a time; iterate over it, or call `step`.

    Parameters
    ----------
    robot
        The robot at its start, as `System.open` makes it.
    controller
        Makes an action of an observation; noctule's own controller where None.
    name
        What errors call it.

    Attributes
    ----------
    robot : LiveRobot
        The robot.
    path : list of (float, float, float)
        Time (s) and place, in the unit of the world, at the start and after each step.
    """

    def __init__(self, robot: LiveRobot, controller: Controller | None = None, name: str = "run") -> None:
        self.robot, self._controller, self._name = robot, controller, name
        self.path: list[tuple[float, float, float]] = [(robot.time, *robot.place)]

    @property
    def over(self) -> str:
        """Why the run is over, empty while it goes on."""
        return self.robot.ended or self.robot.late

    @property
    def succeeded(self) -> bool:
        """Whether the robot has done what the system is for."""
        return self.robot.succeeded

    @property
    def cautions(self) -> tuple[str, ...]:
        """What was left of the boxes of its chips' models, a sentence each, where `outside` is `warn`."""
        return tuple(text for _, text in self.robot.found.values()) if isinstance(self.robot, Warned) else ()

    @property
    def way(self) -> F64:
        """The path as an array, float64[steps + 1, 3]: time (s), and place in the unit of the world."""
        return np.array(self.path)

    def look(self) -> Step:
        """Return the next step before it is taken, with the controller's action."""
        robot = self.robot
        seen = robot.sense()
        chosen = robot.own() if self._controller is None else self._controller(seen)
        return Step(robot.time, seen, robot.readings(), chosen, robot.reward)

    def take(self, action: ArrayLike) -> float:
        """Take a step with an `action`, in the shape and units of the robot's `actions`; return its reward.

        Raises
        ------
        ParameterError
            The action is not one of the robot's, or the run is over.
        """
        if self.over:
            raise ParameterError(f"{self._name}: is over, {self.over}; open another run")
        given = self.robot.actions.checked(action, f"{self._name}.action")
        self.robot.act(given)
        self.path.append((self.robot.time, *self.robot.place))
        return self.robot.reward

    def __iter__(self) -> Iterator[Step]:
        while not self.over:
            step = self.look()
            yield step
            self.take(step.action)


def open_run(system: str, controller: Controller | None = None, **given: Any) -> LiveRun:
    """Open a run of a system that goes on step by step, on the silicon that `noctule run` takes.

    Parameters
    ----------
    system
        Its name, or `FILE.py:NAME` of one's own: a `System`, or what makes a `LiveRobot` of options.
    controller
        Makes an action of an observation; noctule's own controller where None.
    given
        Options and fields of its scenario by name, as `seed`, `map` or `duration`; texts have their unit.
        `ideal=True` puts programs in the place of all chips.

    Raises
    ------
    UnknownNameError
        There is no such system or option.
    ParameterError
        An option breaks its rule, or the system has no runs step by step.
    """
    name, make = maker_of(system)
    return LiveRun(make(given), controller, name)


def maker_of(system: str, *, ideal: bool = False) -> tuple[str, Maker]:
    """Return the name of a system, or of a function of one's own, and what makes a robot of options by name.

    ideal : whether programs stand in place of all chips. Raises as `load_system`.
    """
    check_kind("system", str, system)
    code = code_of(system)
    own = None if code is None else load_code(code)
    if code is not None and callable(own):
        make = guarded(own, code.path)
        return code.name, lambda given: make(**given)
    found = load_system(system)
    return found.name, lambda given: open_robot(found, scenario_of_run(found, given, ideal=ideal))


def scenario_of_run(system: System[Any, Any], given: Mapping[str, Any], *, ideal: bool = False) -> Any:
    """Return the scenario that `noctule run` makes of options by name; `die` may be no more than a number."""
    number = given.get("die")
    numbered = isinstance(number, int) and not isinstance(number, bool)
    die = {"die": replace(system.settings["die"].default, number=given["die"])} if numbered else {}
    return system.on_silicon(**{"ideal": ideal, **given, **die})


def open_robot(system: System[Any, Any], scenario: Any) -> LiveRobot:
    """Return the robot of a scenario at its start, whose chips leave their boxes as the scenario asks.

    Raises `ParameterError` for a system without any.
    """
    if system.open is None:
        able = ", ".join(name for name in system_names() if load_system(name).open is not None)
        raise ParameterError(f"{system.name}: has no runs step by step, those that have are {able}")
    if getattr(scenario, "outside", "refuse") == "refuse":
        return system.open(scenario)
    return cast("LiveRobot", Warned(system.open, scenario))


class Warned:
    """A robot whose chips' models go on outside of their boxes, which is remembered.

    make, scenario : what makes the robot, and of what.
    """

    def __init__(self, make: Callable[[Any], LiveRobot], scenario: Any) -> None:
        self.found: dict[str, tuple[float, str]] = {}  # sides that were left, as `chips.validity` has them
        self.robot: LiveRobot = self._held(make)(scenario)

    def __getattr__(self, name: str) -> Any:
        found = getattr(self.robot, name)
        return self._held(found) if callable(found) else found

    def _held(self, function: Callable[..., Any]) -> Callable[..., Any]:
        @wraps(function)
        def call(*values: Any) -> Any:
            with outside_boxes("warn") as left:
                result = function(*values)
            self.found |= left.found
            return result

        return call
