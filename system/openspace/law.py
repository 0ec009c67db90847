"""Curved Openspace: a bat chooses between arcs of flight by what narrow pings show of them.

The analog model of Wen & Horiuchi 2022, section 2: 33 arcs, 5 ping directions, a memory of the risk of each
arc, and a selection of the most desirable one, which directs the next ping and, where its direction was
sensed of late, the flight. `Bat` holds every number of the model, and says which of them the paper gives.

The field of view reaches `r(theta) = R_MAX exp(-(theta - psi)^2 / (2 sigma^2))` about a ping in the direction
psi. An arc belongs to the ping direction in whose field of view it stays for the longest length R_p; of two
with the same length to the one nearer the middle. Its speed is v_p = V_MAX gamma_p, gamma_p = R_p / R_MAX,
equations (1) and (2).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from circuits.arrays import F64, I64, Bools
from circuits.errors import ParameterError
from system.numbers import check_numbers
from system.openspace.choice import SIGNED, falling, grouped, ping_directions
from system.option import option

ARCS, DIRECTIONS = 33, 5  # the paper's; index 0 is the leftmost
MIDDLE = ARCS // 2
NO_ESCAPE = 0
_IMMEDIACIES = ("linear", "squared")  # equation (11), and the paper's "Squared"
_SAMPLES = 20_000  # of an arc, to see where it leaves a field of view


@dataclass(frozen=True, slots=True)
class Bat:
    """Numbers of the model. Lengths in m, times in s, angles in rad; risks and desirabilities have no unit.

    The paper's (its section 4.1): max_speed 2 m/s unless varied, ping_rate 5 Hz, max_range 5 m, view_sigma
    30 degrees, max_risk E_MAX 10, immediacy_range R_MAX0 5 m, the forms of all terms. All others are ours.
    Those from least_radius on were found by a search on seeds below 1000 (256 points of a Sobol design, then
    208 steps from the best of them, then 46 points of grids) for: each ping direction having arcs; more than
    300 avoided obstacles a collision at 2 m/s among 1,400; a way to the left of half the way flown, and few
    traps, so that the bat hardly circles in open places; an emergency where all arcs are barred near by; what
    the paper claims of P = 0 at 1 to 1.5, 2 and 3 m/s, of H = 0 and "Flat" at 2 to 3 m/s; and that decay and
    recency are counted in time steps, as equation (4) has the decay, which makes higher ping rates better (10
    and 20 Hz were tried). The experiments mark those claims as fitted.

    ===================  =====  ===========================================================================
    max_speed            m/s    V_MAX
    ping_rate            Hz     pings a second; one at every time step
    max_range            m      R_MAX
    view_sigma           rad    of the Gaussian field of view
    max_risk             -      E_MAX
    immediacy_range      m      R_MAX0 of equation (11); the immediacy is cut off at 0
    immediacy            -      `linear`, or `squared`
    zone                 m      R_C: wingspan of a big brown bat, about 0.3 m, is taken for its radius; ours
    least_radius         m      of the outermost arcs; curvatures are evenly spaced; ours
    direction_step       rad    between the ping directions; ours
    decay                -      I_d, a time step; ours
    inhibition           -      I_inh; ours
    default              -      D_0 of the straight arc; ours
    sharp_turn_cost      -      D_0 falls by it, with the square of the curvature, to the outermost; ours
    goal_gain            -      G; ours
    goal_sigma           arcs   sigma_g; ours
    goal_span            rad    bearing of a goal for which the outermost arc is p_g, linear between; ours
    ping_bias            -      P; ours
    hysteresis           -      H; ours
    hysteresis_sigma     arcs   sigma_h; ours
    suppression          -      W; ours
    suppression_sigma    arcs   sigma_m; ours
    recency              -      time steps that a ping in a direction counts as recent; ours
    emergency_below      -      desirability of the winner below which it turns round; ours
    ===================  =====  ===========================================================================
    """

    max_speed: float = option(2.0, "Straight ahead", name="vmax", unit="m/s", above=0.0, study=True)
    ping_rate: float = option(5.0, "Of pings", unit="Hz", above=0.0, study=True)
    max_range: float = 5.0
    view_sigma: float = math.radians(30.0)
    max_risk: float = 10.0
    immediacy_range: float = 5.0
    immediacy: str = "linear"
    zone: float = 0.3
    least_radius: float = 1.12
    direction_step: float = math.radians(36.8)
    decay: float = 2.0
    inhibition: float = 1.03
    default: float = 10.0
    sharp_turn_cost: float = 0.9
    goal_gain: float = 4.1
    goal_sigma: float = 14.5
    goal_span: float = math.radians(160.0)
    ping_bias: float = 2.45
    hysteresis: float = 0.65
    hysteresis_sigma: float = 3.6
    suppression: float = 0.74
    suppression_sigma: float = 1.13
    recency: float = 1.5
    emergency_below: float = 5.5

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the number that breaks its rule."""
        check_numbers("bat", self, signed=SIGNED)
        if self.immediacy not in _IMMEDIACIES:
            known = " or ".join(_IMMEDIACIES)
            raise ParameterError(f"bat.immediacy: {self.immediacy}, must be {known}")
        if self.zone >= self.least_radius:
            raise ParameterError(
                f"bat.zone: {self.zone:g} m, must be less than least_radius {self.least_radius:g} m, or arcs"
                " would circle inside their own zone of collision; choose a smaller one"
            )


class Arcs(NamedTuple):
    """A bat's numbers as the compiled loop takes them. Directions are rad to the left of straight ahead.

    curvature (1/m, positive to the left), length R_p (m), end (x, y of each arc's last point, m), speed
    (m/s), group (ping direction), bias D_0: [ARCS]; direction: [DIRECTIONS]; spread: float64[ARCS, ARCS],
    W exp(-(p - q)^2 / sigma_m^2); hold: the same of hysteresis, H and sigma_h; escape: emergency turns in a
    row after which it turns round no more (`system.openspace.kernel`), `NO_ESCAPE` for the paper's law.
    """

    curvature: F64
    length: F64
    end: F64
    speed: F64
    group: I64
    bias: F64
    direction: F64
    spread: F64
    hold: F64
    curvature_step: float
    max_range: float
    view_sigma: float
    view_half_width: float
    view_behind: float
    max_risk: float
    immediacy_range: float
    power: int
    zone: float
    step: float  # s between pings
    decay: float  # a time step
    inhibition: float
    goal_gain: float
    goal_sigma: float
    arcs_per_rad: float  # of the goal's bearing
    ping_bias: float
    recency: float
    emergency_below: float
    escape: int


@lru_cache(maxsize=8)
def arcs_of(bat: Bat) -> Arcs:
    """Return geometry and weights of a bat's arcs, with all its numbers; nothing writes into its arrays."""
    place = np.arange(ARCS, dtype=np.float64)
    share = (MIDDLE - place) / MIDDLE
    curvature = share / bat.least_radius
    direction = ping_directions(bat.direction_step, DIRECTIONS)
    reach = np.array([[length_in_view(bat, k, psi) for psi in direction] for k in curvature])
    length, group = grouped(reach, direction)
    return Arcs(
        curvature=curvature,
        length=length,
        end=np.stack(arc_point(curvature, length), axis=1),
        speed=bat.max_speed * length / bat.max_range,
        group=group,
        bias=bat.default - bat.sharp_turn_cost * share**2,
        direction=direction,
        spread=falling(bat.suppression, bat.suppression_sigma, ARCS),
        hold=falling(bat.hysteresis, bat.hysteresis_sigma, ARCS),
        curvature_step=1.0 / (MIDDLE * bat.least_radius),
        max_range=bat.max_range,
        view_sigma=bat.view_sigma,
        view_half_width=bat.max_range * _widest(bat.view_sigma),
        view_behind=float(detectable(bat, np.array(0.5 * math.pi))),
        max_risk=bat.max_risk,
        immediacy_range=bat.immediacy_range,
        power=1 + _IMMEDIACIES.index(bat.immediacy),
        zone=bat.zone,
        step=1.0 / bat.ping_rate,
        decay=bat.decay,
        inhibition=bat.inhibition,
        goal_gain=bat.goal_gain,
        goal_sigma=bat.goal_sigma,
        arcs_per_rad=MIDDLE / bat.goal_span,
        ping_bias=bat.ping_bias,
        recency=bat.recency / bat.ping_rate,
        emergency_below=bat.emergency_below,
        escape=NO_ESCAPE,
    )


def detectable(bat: Bat, bearing: F64) -> F64:
    """Farthest range (m) that is seen at a bearing (rad) from the direction of the ping."""
    return np.asarray(bat.max_range * np.exp(-(bearing**2) / (2.0 * bat.view_sigma**2)))


def length_in_view(bat: Bat, curvature: float, direction: float) -> float:
    """Length of an arc (m) from the bat to where it first leaves the field of view of a ping direction.

    At most R_MAX, so that gamma_p is at most 1, and at most half a circle: beyond, an arc comes back.
    """
    last = bat.max_range if curvature == 0.0 else min(bat.max_range, math.pi / abs(curvature))

    def inside(s: F64) -> Bools:
        bearing = 0.5 * curvature * s
        chord = s * np.sinc(bearing / math.pi)
        return np.asarray(chord <= detectable(bat, bearing - direction))

    return _first_exit(inside, last)


def arc_point(curvature: F64, length: F64) -> tuple[F64, F64]:
    """Place (x ahead, y to the left, m) after a length (m) of an arc."""
    half = 0.5 * curvature * length
    chord = length * np.sinc(half / math.pi)
    return np.asarray(chord * np.cos(half)), np.asarray(chord * np.sin(half))


def _first_exit(inside: Callable[[F64], Bools], last: float) -> float:
    """Where `inside` first fails between 0 and `last`, to a part in 1e12."""
    s = np.linspace(0.0, last, _SAMPLES)
    out = np.flatnonzero(~inside(s))
    if not len(out):
        return last
    low, high = float(s[out[0] - 1]), float(s[out[0]])
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if inside(np.array([middle]))[0] else (low, middle)
    return low


def _widest(sigma: float) -> float:
    """Half width of a field of view across its direction, in units of its range; rounded up."""
    bearing = np.linspace(0.0, math.pi, _SAMPLES)
    return float((np.exp(-(bearing**2) / (2.0 * sigma**2)) * np.sin(bearing)).max()) * (1.0 + 1e-6)
