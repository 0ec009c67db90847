"""Bug 0 of 2,050 spiking neurons (Stöckel 2017, III.C and Figure 4).

Two behaviours run side by side: along the wall, each range ray represented by neurons of its own whose square
is decoded, and towards the goal. Basal ganglia select one by the low-passed contact sensor, and silence the
neurons of the other; an oscillator of 1 Hz silences the contact for a part of each period.

| ours | neurons |
|---|---|
| rays | 8 x 50 |
| along the wall, towards the goal | 100 each |
| motor | 150 |
| contact | 100 |
| oscillator | 200 |
| basal ganglia | 2 x 5 x 100 |
"""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any, Self

import numpy as np

from chips.nef.network.circuits import QUIET, basal_ganglia, oscillator, saliences, unless_selected
from chips.nef.network.network import Connection, Ensemble, EnsembleArray, Network, Neurons, Node, Probe, join
from circuits.arrays import F64
from system.bug.brain import CONTACT_FILTER, PULLS, TEST_RATE, TEST_SHARE

THRESHOLD = 0.5  # of the filtered contact, above which the wall is followed
_BASE = 0.2  # salience of the wall without contact; ours
_BEHAVIOURS = ("go", "follow")


@dataclass(frozen=True, slots=True)
class NetworkSize:
    """How many neurons each part has that the networks of Bug 0 and Bug 2 share.

    ray : neurons for each of the eight range rays.
    go : of the behaviour towards the goal.
    follow : of the behaviour along the wall.
    motor : of the motor.
    contact : of the contact sensor.
    """

    ray: int = 50
    go: int = 100
    follow: int = 100
    motor: int = 150
    contact: int = 100

    def scaled(self, share: float) -> Self:
        """All parts larger or smaller alike; constants stay."""
        found: Self = _scaled(self, share)
        return found


def _scaled(size: Any, share: float) -> Any:
    """Whole numbers, which are neurons, times a share; those of its parts too."""
    values = {f.name: getattr(size, f.name) for f in fields(size)}
    changed = {
        name: max(round(share * value), 1) if isinstance(value, int) else _scaled(value, share)
        for name, value in values.items()
        if isinstance(value, int) or is_dataclass(value)
    }
    return replace(size, **changed)


@dataclass(frozen=True, slots=True)
class Bug0Size(NetworkSize):
    """How many neurons each part of the network has; those of the paper are 2,050 together.

    oscillator : of the oscillator of 1 Hz.
    nucleus : of each nucleus of the basal ganglia, for each behaviour.
    """

    oscillator: int = 200
    nucleus: int = 100


PUBLISHED = Bug0Size()


def behaviours(ray: int, go: int, follow: int, motor: int) -> Network:
    """Both behaviours and the motor, as Bug 0 and Bug 2 share them; nodes `ranges` (nearness) and `ahead`."""
    rays = Ensemble("rays", ray, intercepts=(0.0, 0.9), encoders=((1.0,),))
    return Network(
        (
            EnsembleArray(rays, len(PULLS)),
            Ensemble("go", go, 2),
            Ensemble("follow", follow, 2, radius=1.2),
            Ensemble("motor", motor, 2, radius=1.2),
        ),
        (Node("ranges", len(PULLS)), Node("ahead", 2), Node("one", 1)),
        (
            Connection("ranges", "rays"),
            Connection("rays", "follow", np.square, PULLS.T),
            Connection("ahead", "go"),
            Connection("go", "motor"),
            Connection("follow", "motor"),
        ),
        (Probe("motor?", "motor"),),
    )


def bug0_network(s: Bug0Size = PUBLISHED) -> Network:
    """Return the network of Bug 0.

    Its nodes are `ranges` (nearness), `ahead`, `contact` and `one`, its probes `motor?` and `selected?`.
    """
    control = Network(
        (Ensemble("contact", s.contact, intercepts=(0.0, 0.9), encoders=((1.0,),)),),
        (Node("touch", 1),),
        (
            Connection("touch", "contact"),
            Connection("clock", Neurons("contact"), testing, -QUIET),
            *saliences("one", "choice", [[THRESHOLD + _BASE], [_BASE]], 0.0),
            *saliences("contact", "choice", [[0.0], [1.0]], CONTACT_FILTER),
            *(unless_selected("choice", k, 2, name) for k, name in enumerate(_BEHAVIOURS)),
        ),
        (Probe("selected?", "choice.gpi"),),
    )
    return join(
        (
            behaviours(s.ray, s.go, s.follow, s.motor),
            oscillator("clock", s.oscillator, TEST_RATE),
            basal_ganglia("choice", 2, s.nucleus),
            control,
        )
    )


def testing(x: F64) -> F64:
    """1 while the oscillator's phase is in the share of the period in which the goal is tried, else 0."""
    phase = np.arctan2(x[:, 1:], x[:, :1])
    return np.where(np.abs(phase) < np.pi * TEST_SHARE, 1.0, 0.0)
