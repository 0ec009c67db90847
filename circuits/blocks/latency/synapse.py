"""Step-current synapse, which answers an event by a current for a fixed time, and its comparator.

The event discharges the capacitor of a timer through `mr`, and the starved source `mt` charges it again. As
long as the capacitor is below the reference, the comparator keeps a switch at the foot of a current source
closed:

    T_syn = C_t V_ref / I_step

Another event during a step makes it last longer, not stronger: the synapse saturates, as the paper's do. The
switch is at the source of the current source, so that its edges reach the output only through a transistor in
saturation. `step_synapse` gives a current into its output, from pFETs; `step_inhibition` takes one out of it,
by nFETs, with the same timer.

Source: Wen & Horiuchi 2022, equations (9), (10) and (14), steps of 20 ms. The circuit and all numbers are
ours.
"""

from __future__ import annotations

from dataclasses import dataclass

from circuits.blocks.drive import Wave, elements
from circuits.blocks.mos import current_mirror, inverter, mos
from circuits.blocks.ports import SUPPLY, analog_in, analog_out, bias_in, event_in, event_out
from circuits.blocks.sizes import Sizes
from circuits.circuit import Bias, Circuit, Instance, Port
from circuits.devices import Capacitor
from circuits.devices.device import Device
from circuits.errors import ParameterError
from circuits.event import pulse
from circuits.units import quantity

REFERENCE = 2.0  # V, of every comparator


@dataclass(frozen=True, slots=True)
class MembraneSizes(Sizes):
    """Capacitors of a membrane and of each timer, F; ours."""

    membrane_capacitance: float = quantity(10e-12, "F")
    timer_capacitance: float = quantity(5e-12, "F")


def comparator() -> Circuit:
    """A comparator, whose output `above` is high where `plus` is above `v_ref`; v_cmp sets its current."""
    ports = (SUPPLY, *analog_in("plus"), *event_out("above"), *bias_in("v_ref", "v_cmp"))
    devices = (
        *comparator_stages("plus", 6),
        *inverter("mo", "y", "above", width=3.0, length=1.5),
    )
    return Circuit("comparator", ports, devices)


def comparator_stages(plus: str, width: float) -> tuple[Device, ...]:
    """The two stages of a comparator: the node `y` is low where the node `plus` is above `v_ref`.

    A differential pair, its nFETs `width` um wide, drives a second stage that is balanced with it.
    """
    return (
        mos("mc0", "n", "tail", "v_cmp", "0", 6, 6),
        mos("mc1", "n", "m", plus, "tail", width, 3),
        mos("mc2", "n", "x", "v_ref", "tail", width, 3),
        *current_mirror("mc3", "mc4", "p", "m", "x", (6, 3)),
        mos("mc5", "p", "y", "x", "vdd", 12, 3),
        mos("mc6", "n", "y", "v_cmp", "0", 6, 6),
    )


def compared(name: str, plus: str, above: str) -> Instance:
    """A comparator called `name`, at which node `above` is high where node `plus` is above `v_ref`."""
    return comparator().instance(name, plus=plus, above=above)


def comparator_biases(device: str) -> tuple[Bias, Bias]:
    """The current and the reference that all comparators of a block share.

    device: path of the tail `mc0` of one of the comparators.
    """
    return (
        Bias("i_cmp", "v_cmp", "gate", 50e-9, device),
        Bias("v_ref", "v_ref", "voltage", REFERENCE),
    )


def timer(reset: str, gate: str, capacitance: float) -> tuple[Device, ...]:
    """The counting part of a timer: an event at `reset` empties the node `timer`, a source fills it again.

    gate: gate of the source. capacitance: F.
    """
    return (
        mos("mr", "n", "timer", reset, "0", 6, 1.5),
        mos("mt", "p", "timer", gate, "vdd", 6, 24),
        Capacitor("ct", "timer", "0", capacitance),
    )


def step_synapse(timer_capacitance: float) -> Circuit:
    """A synapse that gives a current: ports event (in), v_mem (current out), biases.

    timer_capacitance: F.
    """
    return _stepped(
        "step_synapse",
        ("v_exc", "v_step"),
        timer_capacitance,
        mos("ms", "p", "foot", "off", "vdd", 6, 1.5),
        mos("me", "p", "v_mem", "v_exc", "foot", 6, 24),
    )


def step_inhibition(timer_capacitance: float) -> Circuit:
    """A synapse that takes a current: ports event (in), v_mem (current in), biases.

    timer_capacitance: F.
    """
    return _stepped(
        "step_inhibition",
        ("v_inh", "v_hold"),
        timer_capacitance,
        *inverter("mi", "off", "on", width=3.0, length=1.5),
        mos("ms", "n", "foot", "on", "0", 6, 1.5),
        mos("mk", "n", "v_mem", "v_inh", "foot", 6, 24),
    )


def _stepped(name: str, biases: tuple[str, str], capacitance: float, *switched: Device) -> Circuit:
    """A synapse of a timer and of what it switches; biases set current and time; capacitance: F."""
    _, time = biases
    ports = (SUPPLY, *event_in("event"), *analog_out("v_mem"), *bias_in(*biases, "v_cmp", "v_ref"))
    devices = (*timer("event", time, capacitance), *switched)
    return Circuit(name, ports, devices, (compared("timer", "timer", "off"),))


def events(port: Port, times: tuple[float | None, ...], ping: float, v_dd: float) -> dict[str, Wave]:
    """The waves of an event port, by node: an event at each of `times`, s after the ping; None is silent.

    ping: when the times count from, s. Raises `ParameterError` for a time before the ping.
    """
    waves: dict[int, Wave] = {}
    for k, after in enumerate(times[: len(port.elements())]):
        if after is not None and after < 0.0:
            raise ParameterError(f"{port.name} {k + 1}: {after:g} s, must be >= 0 s after the ping, or off")
        waves[k] = 0.0 if after is None else pulse((ping + after,), v_dd)
    return elements(port, waves)
