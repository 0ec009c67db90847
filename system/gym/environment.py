"""Any robot with runs step by step as an environment of Gymnasium.

    environment = gymnasium.make("system.gym:noctule/Forest-v0", obstacles=900)
    observation, info = environment.reset(seed=1000)
    observation, reward, terminated, truncated, info = environment.step(action)

`reset(seed=N)` makes the world that `noctule run` makes of that seed; without a seed the next one is drawn.
Programs stand in place of all chips unless `ideal=False`, with which the senses are on the die that is asked
for. Real actions are shares of their bounds, from -1 to 1. A run that ended is terminated, one whose time,
way or pings are over is truncated.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from circuits.errors import ParameterError
from system.live.robot import LiveRobot
from system.live.signals import Array, Signals
from system.play.run import maker_of

_SEEDS = 1 << 31
_INCHES, _DOTS = 4.8, 100


class Environment(gymnasium.Env[Any, Any]):
    """A robot in its world, for libraries that learn.

    Parameters
    ----------
    system
        Name of the system, or `FILE.py:NAME` of one's own, as of `open_run`.
    render_mode
        `rgb_array` for pictures of the world, None for none.
    ideal
        Whether programs stand in place of all chips.
    given
        Options of its scenario by name, as `map` or `die`; `reset(options=...)` goes over them.

    Raises
    ------
    ParameterError
        An option breaks its rule, or the system has no runs step by step.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012 - as Gymnasium has it

    def __init__(
        self, system: str, *, render_mode: str | None = None, ideal: bool = True, **given: Any
    ) -> None:
        if render_mode not in {None, *self.metadata["render_modes"]}:
            raise ParameterError(f"render_mode: {render_mode}, must be rgb_array, or None for no pictures")
        self.render_mode, self._given = render_mode, given
        self._called, self._open = maker_of(system, ideal=ideal)
        self.robot: LiveRobot = self._opened(0, {})
        self.observation_space = space_of(self.robot.senses)
        self._actions = normal_of(self.robot.actions)
        self.action_space = space_of(self._actions)
        self._over = True

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Array, dict[str, Any]]:
        """Put the robot at the start of the world of a seed, and return what it senses.

        Parameters
        ----------
        seed
            Seed of world and noise, a whole number from 0; drawn where None.
        options
            Options of this run's scenario by name.
        """
        super().reset(seed=seed)
        number = int(self.np_random.integers(_SEEDS)) if seed is None else seed
        self.robot, self._over = self._opened(number, options or {}), False
        return self.robot.sense(), self._told()

    def step(self, action: ArrayLike) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Go on by a step with an `action`, whole numbers or shares of the bounds, in the space's shape.

        Raises
        ------
        ParameterError
            The action is outside of its space, or the run is over.
        """
        if self._over:
            raise ParameterError(f"{self._name}: the run is over; call reset")
        given = self._actions.checked(action, f"{self._name}.action")
        self.robot.act(in_units(self.robot.actions, given))
        terminated, truncated = bool(self.robot.ended), bool(self.robot.late)
        self._over = terminated or truncated
        return self.robot.sense(), float(self.robot.reward), terminated, truncated, self._told()

    def render(self) -> Array | None:
        """Return a picture of world, way and robot, uint8[480, 480, 3]; None without `render_mode`."""
        if self.render_mode is None:
            return None
        figure = Figure(figsize=(_INCHES, _INCHES), dpi=_DOTS, layout="constrained")
        self.robot.draw(figure.subplots())
        raw = io.BytesIO()
        figure.savefig(raw, format="rgba")
        side = round(_INCHES * _DOTS)
        return np.frombuffer(raw.getvalue(), np.uint8).reshape(side, side, 4)[:, :, :3].copy()

    @property
    def _name(self) -> str:
        return self._called if self.spec is None else self.spec.id

    def _opened(self, seed: int, options: Mapping[str, Any]) -> LiveRobot:
        return self._open({**self._given, **options, "seed": seed})

    def _told(self) -> dict[str, Any]:
        """What is said of a step beside its observation: the time, s, and at the end why and whether well."""
        told: dict[str, Any] = {"time_s": float(self.robot.time)}
        if over := self.robot.ended or self.robot.late:
            told |= {"ended": over, "succeeded": self.robot.succeeded}
        return told


def space_of(signals: Signals) -> spaces.Space[Any]:
    """Return the space of observations or actions."""
    if signals.kind == "whole":
        return spaces.MultiDiscrete((signals.high - signals.low + 1).astype(np.int64))
    if signals.kind == "frame":
        return spaces.Box(0, int(signals.high.max()), signals.shape, dtype=np.uint8)
    return spaces.Box(signals.low, signals.high, dtype=np.float64)


def normal_of(signals: Signals) -> Signals:
    """Return real actions as shares of their bounds, from -1 for the least to 1 for the greatest value."""
    shares = [
        replace(
            c,
            name=f"{c.name}, -1 for {c.low:g} to 1 for {c.high:g} {c.unit}".strip(),
            unit="",
            low=-1,
            high=1,
        )
        for c in signals.channels
    ]
    return Signals(tuple(shares)) if signals.kind == "real" else signals


def in_units(signals: Signals, shares: Array) -> Array:
    """Return real actions, given as shares of their bounds, in the units of their channels."""
    if signals.kind != "real":
        return shares
    middle, reach = 0.5 * (signals.low + signals.high), 0.5 * (signals.high - signals.low)
    return np.asarray((middle + reach * shares).clip(signals.low, signals.high))
