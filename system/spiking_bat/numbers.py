"""Every number of the spike-latency network of Wen & Horiuchi 2022, section 3, and which of them are ours.

The paper gives the forms of all equations, (7) to (14), and these: 33 motor choices in 5 groups, maps of 471
neurons, 2,931 integrate-and-fire and 2,078 Hodgkin-Huxley neurons, dt 0.02 ms, step currents of 20 ms, a
coincidence window of 3 ms, reversal potentials of 10 and -70 mV, sigma_c 1, ten pings a second in Figure 13.
Everything else in `Numbers` is ours.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace

from circuits.count import whole_number
from circuits.errors import ParameterError
from system.numbers import check_numbers

DIRECTION_PRIORITY = (2, 1, 3, 0, 4)  # middle, middle left, middle right, left, right; the paper's
PATHS = 33  # memories; the paper's motor choices
UNITS = 15  # latency units of a memory; the paper's figures need it, the text does not say it
SOUND = 343.0  # m/s


@dataclass(frozen=True, slots=True)
class Numbers:
    """Numbers of the network: times in s, conductances in S/m^2, currents of conductors in A/m^2.

    Thresholds of integrators are 1, so that their charges have no unit.

    Whatever the paper does not give is ours; "given" marks the paper's. suppression, goal, direction,
    sharp_turn_cost and emergency were chosen by the scene of Figure 12 and by the nominal chip's crossings of
    forests of seeds below 1000, 300 to 329 and 400 to 439 at last: a larger suppression makes emergencies of
    whatever is far away, and loops of them (`system.spiking_bat.circling`); the others so that each part of
    the network does what the paper says of it.

    ==================  ======================================================================================
    paths, taps         memories, and latency units of each: the delay line's neurons; 33 given
    ping_period         between pings; given, 10 Hz
    step_current        T_syn of the integrating neuron's synapse; given
    integration         C_mem0 V_th0 / E_0: from one input alone to the spike
    constant_delay      T_C
    tap_delay           between neurons of the delay line
    drive, tau_drive    peak and time constant of a synapse that makes its target spike
    drive_latency       how much later it does, at rest; measured, and checked by the tests
    coincidence,        of each of the coincidence detector's synapses: two spikes up to 3 ms apart, or less,
    tau_coincidence     make it spike, one never does
    tonic               current of the tonic neurons, 92 Hz
    block, tau_block    of a tonic neuron's inhibition
    hold, tau_hold      of the inhibition that keeps a tonic neuron silent, some 165 ms: CD on INH
    memory              pings further apart than this, less than that inhibition, would be forgotten
    recent, tau_recent  the same of a ping on its recency neuron, 109 ms: longer, it would outlive a reset
    reset               peak of the excitation of INH by the reset spike; its time constant is tau_hold
    leak                of the maps' neurons, 1/s; (9) and (10) allow the others none
    sensory, relay      current (1/s) and length of the box that makes a map's neuron spike, within 0.1 ms
    silence, silent     inhibiting current (1/s) on the maps that were not pinged, and how long
    race                passive current: to the spike of an uninhibited, straight motor choice
    sharp_turn_cost     share by which the passive current falls, with the square of the curvature
    goal, goal_sigma    Q_goal in thresholds at its peak; width in motor choices
    direction           Q_dir in thresholds
    pulse               how long these two charges flow
    goal_delay,         from the ping to the goal's charge, and to the ping-direction neurons' inputs
    direction_delay
    suppression         peak of a memory's step inhibition, as a share of the passive current
    suppression_sigma   sigma_c, motor choices; given; a standard deviation, cut off at 3
    inhibit             of a recurrent inhibitory neuron on its layer, 1/s
    recurrent           peak of the synapse that makes it spike
    first, between      delay of the second layer in the first group, and what every following group adds
    emergency           after which the emergency neuron spikes
    lif_tonic, lif_hold, of integrate-and-fire neurons alone: period of the tonic ones; how long CD silences
    lif_block,          INH, INH blocks B, a ping silences its recency neuron, and that one the body motors
    lif_recent, lif_gate
    reset_at            after the ping: the motors are read, and the reset is given if the body turned
    ==================  ======================================================================================
    """

    paths: int = PATHS
    taps: int = UNITS
    ping_period: float = 0.1
    step_current: float = 20e-3
    integration: float = 8e-3
    constant_delay: float = 3e-3
    tap_delay: float = 3e-3
    drive: float = 8.0
    tau_drive: float = 1e-3
    drive_latency: float = 1.08e-3
    coincidence: float = 0.68
    tau_coincidence: float = 0.5e-3
    tonic: float = 0.25
    block: float = 60.0
    tau_block: float = 8e-3
    hold: float = 12.0
    tau_hold: float = 25e-3
    memory: float = 0.15
    recent: float = 20.0
    tau_recent: float = 15e-3
    reset: float = 3.0
    leak: float = 100.0
    sensory: float = 2e4
    relay: float = 0.1e-3
    silence: float = 1e6
    silent: float = 45e-3
    race: float = 58e-3
    sharp_turn_cost: float = 0.1
    goal: float = 0.08
    goal_sigma: float = 8.0
    direction: float = 0.1
    pulse: float = 2e-3
    goal_delay: float = 5e-3
    direction_delay: float = 10e-3
    suppression: float = 0.21
    suppression_sigma: float = 1.0
    inhibit: float = 1e4
    recurrent: float = 3.0
    first: float = 2e-3
    between: float = 2.8e-3
    emergency: float = 68e-3
    lif_tonic: float = 10.5e-3
    lif_hold: float = 166e-3
    lif_block: float = 60e-3
    lif_recent: float = 98e-3
    lif_gate: float = 15e-3
    reset_at: float = 90e-3

    def __post_init__(self) -> None:
        """Raise `ParameterError` naming the number that breaks its rule."""
        check_numbers("numbers", self, from_zero=[each.name for each in fields(self)])
        for name, count in (("paths", self.paths), ("taps", self.taps)):
            whole_number(name, count)
        if self.integration >= self.step_current:
            raise ParameterError(
                f"numbers.integration: {self.integration:g} s, must be less than step_current"
                f" {self.step_current:g} s, or one obstacle alone would never be remembered"
            )


def numbers_at(rate: float, taps: int = UNITS, paths: int = PATHS) -> Numbers:
    """Numbers at so many pings a second (Hz): the reset stays at nine tenths of the period."""
    usual = Numbers()
    period = 1.0 / rate
    reset_at = usual.reset_at / usual.ping_period * period
    return replace(usual, ping_period=period, reset_at=reset_at, taps=taps, paths=paths)
