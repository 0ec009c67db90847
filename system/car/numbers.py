"""Every number of the wheeled sonar robot of Wen & Horiuchi 2022, "Robot Implementation", Figures 14, 15.

`Robot` is body, steering, sonar and neck; `OpenspaceNumbers` what it chooses with. The tables say which of
them the paper gives; the others are ours. Lengths in m, times in s, angles in rad, voltages in V; risks and
desirabilities have no unit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from circuits.errors import ParameterError
from system.numbers import check_numbers
from system.openspace.choice import SIGNED
from system.option import option

ARCS, DIRECTIONS = 15, 5  # the paper's; index 0 is the leftmost
MIDDLE = ARCS // 2
PIPE_RADIUS = 0.025  # m; the paper's pipes are 5 cm wide


@dataclass(frozen=True, slots=True)
class Robot:
    """Numbers of the vehicle and its sonar.

    The neck's speed follows from the paper's rates: 1/12 s without and 1/3 s with a turn from one end to the
    other, 120 degrees here, leave 0.25 s for it. The body is a disc, as the paper's zone of collision is.

    ================  =====  ==========================================================================
    radius            m      of the body's disc; ours: the electronics are 9 cm long, the gaps 25 cm
    wheelbase         m      ours
    most_steering     rad    of the front wheels, outermost arcs; ours
    steering_step     rad    of the steering servo: angles of the table are whole steps; ours
    head_ahead        m      of the sonar before the body's middle; the paper: at the front
    max_speed         m/s    straight ahead; ours
    ping_rate         Hz     without a turn of the head, 12, the paper's
    direction_step    rad    between the five ping directions, 30 degrees; ours
    neck_speed        rad/s  480 degrees a second, from the paper's 3 to 12 Hz and direction_step
    beam              rad    half-power width of each transducer, to send and to hear, 60 degrees; the paper's
    squint            rad    between the transducers, 45 degrees; the paper's
    call              s      length of the tone; ours
    blanking          s      3e-3 after the call's begin nothing is measured; the paper's. 0.51 m
    soft_blanking     s      of a soft ping; ours. 0.10 m
    max_range         m      of what is kept of a ping; ours
    scatter           m      what a pipe scatters to 1 m, of a sphere half its radius; ours
    volts_per_decade  V      of the logarithmic envelope; ours
    noise             -      rms of the envelope's quadratures, of an echo from 1 m straight ahead; ours
    threshold         -      of an echo's peak, in the same unit; ours
    sample_rate       Hz     of the analog-to-digital converter, a channel; ours
    ================  =====  ==========================================================================
    """

    radius: float = 0.08
    wheelbase: float = 0.12
    most_steering: float = math.radians(30.0)
    steering_step: float = math.radians(1.0)
    head_ahead: float = 0.06
    max_speed: float = option(0.08, "Straight ahead", name="vmax", unit="m/s", above=0.0, study=True)
    ping_rate: float = option(12.0, "Head at rest", unit="Hz", above=0.0, study=True)
    direction_step: float = math.radians(30.0)
    neck_speed: float = math.radians(480.0)
    beam: float = math.radians(60.0)
    squint: float = math.radians(45.0)
    call: float = 0.3e-3
    blanking: float = 3e-3
    soft_blanking: float = 0.6e-3
    max_range: float = 1.5
    scatter: float = 0.0125
    volts_per_decade: float = 0.5
    noise: float = 0.01
    threshold: float = 0.2
    sample_rate: float = 20e3

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the number that breaks its rule."""
        check_numbers("robot", self)
        if self.soft_blanking >= self.blanking:
            raise ParameterError(
                f"robot.soft_blanking: {self.soft_blanking:g} s, must be below blanking, {self.blanking:g} s;"
                " a soft ping is there to die out sooner"
            )
        if self.most_steering >= 0.5 * math.pi:
            raise ParameterError(
                f"robot.most_steering: {math.degrees(self.most_steering):g} degrees, must be below 90;"
                " front wheels turn up to about 45"
            )

    @property
    def zone(self) -> float:
        """Radius R_C of the zone of collision, m: that of the body and that of a pipe together."""
        return self.radius + PIPE_RADIUS


@dataclass(frozen=True, slots=True)
class OpenspaceNumbers:
    """Numbers of Curved Openspace on the car, equations (1) to (6), whose forms are the paper's.

    max_risk is the paper's; all others are ours, chosen on seeds below 1000 for few collisions in the two
    forests and few side pings in the corridor, by a dozen steps of a random search and single numbers by
    hand; so were the robot's max_speed and soft_blanking.

    ===================  =====  ===========================================================================
    view_sigma           rad    of the Gaussian field of view, for lengths of arcs and speeds
    view_range           m      R_MAX, of the same
    margin               m      beyond the zone of collision that a pipe counts as blocking
    max_risk             -      E_MAX
    decay                1/s    I_d over the time step: pings come at 3 to 12 Hz
    inhibition           -      I_inh
    default              -      D_0 of the straight arc
    sharp_turn_cost      -      D_0 falls by it, with the square of the steering angle, to the outermost
    goal_gain            -      G
    goal_sigma           arcs   sigma_g
    goal_span            rad    bearing of a goal for which the outermost arc is p_g, linear between
    ping_bias            -      P
    hysteresis           -      H
    hysteresis_sigma     arcs   sigma_h
    suppression          -      W
    suppression_sigma    arcs   sigma_m
    recency              s      for which a ping in a direction counts as recent
    emergency_below      -      desirability of the winner below which it backs up
    retreat              m      that it backs up then, the way that it came
    ===================  =====  ===========================================================================
    """

    view_sigma: float = math.radians(30.0)
    view_range: float = 0.6
    margin: float = 0.02
    max_risk: float = 10.0
    decay: float = 4.0
    inhibition: float = 0.5
    default: float = 10.0
    sharp_turn_cost: float = 0.9
    goal_gain: float = 4.5
    goal_sigma: float = 6.0
    goal_span: float = math.radians(80.0)
    ping_bias: float = 1.0
    hysteresis: float = 0.68
    hysteresis_sigma: float = 1.7
    suppression: float = 0.74
    suppression_sigma: float = 1.15
    recency: float = 0.5
    emergency_below: float = 8.3
    retreat: float = 0.18

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the number that breaks its rule."""
        check_numbers("robot_openspace", self, signed=SIGNED)
