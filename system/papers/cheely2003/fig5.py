"""Figure 5 of Cheely & Horiuchi 2003: the excitatory postsynaptic current after one echo.

The transistors of neuron 2 are simulated with an echo alone. The rate at which its current decays is compared
with the paper's equation (17), and the transients at the echo's edges with those of the paper's figure. The
current is that of me5 into the membrane node. It follows from the recorded voltages: the channel's by the
transistor's law, and with it the displacement through the gate-drain and drain-bulk capacitances,
`I = I_d + C_gd d(v_ex - v_mem)/dt + C_db d(V_dd - v_mem)/dt`.

I_max is the current while V_ex is at V_ex,max, at the end of the echo's pulse.

The decay rate is the slope of ln I_d, by least squares. Equation (17), corrected by the thermal voltage that
its second form lacks, gives `kappa_p I_ex_tau / (C U_T)`, with C all that I_ex_tau charges: C_ex and the
gates, overlaps and junctions at v_ex. It is the limit of weak inversion: in `I = I_S F(u)`,
`F(u) = e^u (1 - e^(u/2) + ...)`, and at I_max e^(u/2) is still 0.1. So it must hold within 1 % over the
decade from I_max/100 to I_max/1000, where e^(u/2) falls from 0.011 to 0.003, and within 10 % over the first
decade, which the paper's figure shows. The weak decade was chosen for its 1 % (between the two the rate
is 1.0 % low) and counts as fitted. With the drawn C_ex alone the same equation is 7 % fast.

Transients at the echo's edges depend on the edges' slope and on the layout's coupling capacitances, and the
paper gives neither; so only their order of magnitude is compared, a factor of ten either way: the
negative extreme, and the extent from the negative to the positive extreme.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from circuits.arrays import F64, Bools
from circuits.blocks.sonar import rebound_neuron
from circuits.circuit import Circuit
from circuits.devices import Capacitor, Transistor
from circuits.devices.transistor import capacitances, drain_current
from circuits.errors import TopologyError
from circuits.event import HALF_WIDTH, LENGTH
from circuits.silicon.process import at_temperature
from circuits.silicon.silicon import Silicon
from circuits.solver.transient import simulate
from system.experiment import Experiment, Progress, Report
from system.plot import COLOURS, INK
from system.rule import at_least, within_factor, within_share
from system.statement import Statement

RTOL = 1e-7  # displacement currents are differences of recorded voltages
ECHO_TIME = rebound_neuron.CALL_TIME  # s; the paper's transients are at 1 ms, too
FLAT_END, PULSE_END = ECHO_TIME + HALF_WIDTH, ECHO_TIME + LENGTH  # s, where the pulse begins and ends to fall
FIRST_DECADE, WEAK_DECADE = (1.0, 10.0), (100.0, 1000.0)  # below I_max
DESIGN_CURRENT = 1e-9  # A, for which V_ex,max was chosen
STRAIGHT = 0.05  # of ln I: points nearer to the line are on it
FACTOR = 10.0  # of the paper's transients
PAPER_LOW, PAPER_HIGH = -0.2e-6, 0.8e-6  # A


@dataclass(frozen=True, slots=True)
class Current:
    """Waveforms float64[T]: time (s), me5's channel current and its total current into v_mem (A)."""

    time: F64
    channel: F64
    total: F64

    @property
    def extremes(self) -> tuple[float, float]:
        """Smallest and largest total current, A."""
        return float(self.total.min()), float(self.total.max())


@dataclass(frozen=True, slots=True)
class Decay:
    """Rates (1/s) over the first and the weak decade; of the latter's line the start (A) and the decades."""

    first_rate: float
    weak_rate: float
    intercept: float
    decades: float


def run(progress: Progress) -> Report:
    """Simulate an echo alone, fit the decay of its current, and compare it with the paper's."""
    circuit, silicon = rebound_neuron.build(), Silicon()
    current = _current(circuit, silicon)
    progress(1.0)
    decay = _decay(current)
    drawn, loaded = _expected_rates(circuit, silicon)
    rows = (*_decay_rows(current, decay, drawn, loaded), *_transient_rows(current))
    low, high = current.extremes
    before, after = (1e9 * _at(current, time) for time in (FLAT_END, PULSE_END))
    ours, paper = (f"{1e6 * a:.3g} to {1e6 * b:.3g} uA" for a, b in ((low, high), (PAPER_LOW, PAPER_HIGH)))
    layout = (
        "The paper's positive transient is not reproduced: in the schematic an echo reaches V_mem only by"
        " v_ex, which it pulls down; edges and layout parasitics of its simulation are unknown."
    )
    notes = (
        f"When me3 switches off its overlap takes the current from {before:.3f} to {after:.3f} nA.",
        f"Transients at the echo's edges: {ours}; the paper's {paper}.",
        layout,
    )
    return Report(rows, lambda figure: _draw(current, decay, loaded, figure), notes)


def _current(circuit: Circuit, silicon: Silicon) -> Current:
    stimuli: dict[str, float | None] = {"delay": 0.0, "call": None, "echo": 1.0, "duration": 8e-3}
    bench = rebound_neuron.testbench(circuit, stimuli, silicon.process.v_dd)
    result = simulate(bench, silicon, rtol=RTOL, record=("v_mem", "excitation.v_ex"))
    output, v_dd, time = _transistor(circuit, "excitation.me5"), silicon.process.v_dd, result.time
    v_mem, v_ex = result["v_mem"], result["excitation.v_ex"]
    law = at_temperature(silicon.process.p, silicon.process, silicon.temperature_c)
    channel = -drain_current(law, "p", output.width, output.length, v_mem, v_ex, v_dd, v_dd)
    charge = (
        _capacitance(output, silicon, 0, 1) * (v_ex - v_mem) - _capacitance(output, silicon, 0, 3) * v_mem
    )
    # backward differences: a step that begins at an edge of the pulse shows nothing of it before
    displacement = np.diff(charge, prepend=charge[0]) / np.diff(time, prepend=time[0] - 1.0)
    return Current(time, channel, channel + displacement)


def _transistor(circuit: Circuit, name: str) -> Transistor:
    device = circuit.device(name)
    if not isinstance(device, Transistor):
        raise TopologyError(f"{circuit.name}.{name}: not a transistor; name one")
    return device


def _capacitance(device: Transistor, silicon: Silicon, first: int, second: int) -> float:
    """Capacitance between two terminals (0 drain, 1 gate, 2 source, 3 bulk) of a device, F."""
    pairs = _capacitances(device, silicon)
    return sum(c for pair, c in pairs.items() if set(pair) == {first, second})


def _capacitances(device: Transistor, silicon: Silicon) -> dict[tuple[int, int], float]:
    model = silicon.process.model(device.polarity)
    size = (np.array([x]) for x in (device.width, device.length, device.multiplicity))
    return {pair: float(c[0]) for pair, c in capacitances(model, *size).items()}


def _node_capacitance(circuit: Circuit, node: str, silicon: Silicon) -> float:
    """All capacitance between a node and the others of a flat circuit, F."""
    total = 0.0
    for device in circuit.devices:
        here = [terminal == node for terminal in device.terminals()]
        if isinstance(device, Capacitor):
            total += device.capacitance * (here[0] != here[1])
        elif isinstance(device, Transistor):
            total += sum(c for (a, b), c in _capacitances(device, silicon).items() if here[a] != here[b])
    return total


def _expected_rates(circuit: Circuit, silicon: Silicon) -> tuple[float, float]:
    """Decay rate by equation (17) corrected, with the drawn C_ex and with all capacitance at v_ex, 1/s."""
    synapse = rebound_neuron.excitatory_synapse(rebound_neuron.Params())
    i_ex_tau = float(np.asarray(circuit.bias("i_ex_tau").value))
    slope = silicon.process.p.kappa * i_ex_tau / silicon.thermal_voltage
    drawn = rebound_neuron.Params().excitation_capacitance
    return slope / drawn, slope / _node_capacitance(synapse, "v_ex", silicon)


def _decay(current: Current) -> Decay:
    after = current.time >= PULSE_END
    time, log = current.time[after] - PULSE_END, np.log(current.channel[after])
    first_rate, _ = _line(time, log, _decade(current, log, FIRST_DECADE))
    inside = _decade(current, log, WEAK_DECADE)
    rate, intercept = _line(time, log, inside)
    off = np.abs(log - (intercept - rate * time)) > STRAIGHT
    # the stretch around the fitted decade, up to the first point off the line on either side
    middle = int(np.flatnonzero(inside)[0])
    before, behind = np.flatnonzero(off[:middle]), np.flatnonzero(off[middle:])
    first = int(before[-1]) + 1 if before.size else 0
    last = middle + int(behind[0]) - 1 if behind.size else log.size - 1
    decades = float(log[first] - log[last]) / math.log(10.0)
    return Decay(first_rate, rate, math.exp(intercept), decades)


def _decade(current: Current, log: F64, below: tuple[float, float]) -> Bools:
    top = math.log(_largest(current))
    return (log <= top - math.log(below[0])) & (log >= top - math.log(below[1]))


def _line(time: F64, log: F64, inside: Bools) -> tuple[float, float]:
    """Rate (1/s) and logarithm at time 0 of the exponential through the points inside."""
    slope, intercept = np.polyfit(time[inside], log[inside], 1)
    return -float(slope), float(intercept)


def _largest(current: Current) -> float:
    """I_max, A."""
    return _at(current, FLAT_END)


def _at(current: Current, time: float) -> float:
    return float(np.interp(time, current.time, current.channel))


def _decay_rows(current: Current, decay: Decay, drawn: float, loaded: float) -> tuple[Statement, ...]:
    return (
        _within("i_max_A", DESIGN_CURRENT, _largest(current), 0.05, fitted=True),
        _within("decay_rate_weak_decade_per_s", loaded, decay.weak_rate, 0.01, fitted=True),
        _within("decay_rate_first_decade_per_s", loaded, decay.first_rate, 0.1),
        _within("decay_rate_weak_decade_drawn_capacitance_per_s", drawn, decay.weak_rate, 0.1),
        Statement(
            "exponential_decades",
            None,
            decay.decades,
            at_least(1.0, f"at least {{limit:g}} within {100 * STRAIGHT:g} % of a line in ln I"),
        ),
    )


def _within(name: str, paper: float, ours: float, share: float, *, fitted: bool = False) -> Statement:
    return Statement(name, paper, ours, within_share(share), fitted)


def _transient_rows(current: Current) -> tuple[Statement, ...]:
    low, high = current.extremes
    pairs = (("transient_low_A", PAPER_LOW, low), ("transient_extent_A", PAPER_HIGH - PAPER_LOW, high - low))
    rule = within_factor(FACTOR, "same sign, within a factor of {limit:g}")
    return tuple(Statement(name, paper, ours, rule) for name, paper, ours in pairs)


def _draw(current: Current, decay: Decay, loaded: float, figure: Figure) -> None:
    """(a) the current as in the paper, (b) in logarithm with equation (17), (c) the transients."""
    figure.set_size_inches(7.5, 5.0)
    panels = figure.subplot_mosaic([["epsc", "epsc"], ["log", "edges"]])
    _draw_current(current, panels["epsc"])
    _draw_logarithm(current, decay, loaded, panels["log"])
    _draw_edges(current, panels["edges"])


def _draw_current(current: Current, ax: Axes) -> None:
    ax.plot(1e3 * current.time, 1e9 * current.total, color=COLOURS[0], linewidth=1.2)
    ax.set(xlim=(0.5, 3.0), ylim=(-0.15, 1.25), xlabel="time (ms)", ylabel="current into $V_{mem}$ (nA)")
    ax.set_title("(a) EPSC; its transients at 1 ms leave the axis, see (c)", fontsize=9, loc="left")


def _draw_logarithm(current: Current, decay: Decay, loaded: float, ax: Axes) -> None:
    after = current.time >= PULSE_END
    time = current.time[after]
    law = decay.intercept * np.exp(-loaded * (time - PULSE_END))
    ax.semilogy(1e3 * time, current.channel[after], color=COLOURS[0], linewidth=1.6, label="circuit")
    ax.semilogy(
        1e3 * time, law, color=COLOURS[1], linewidth=1.0, linestyle="--", label="equation (17), slope"
    )
    ax.set(xlim=(0.5, 6.0), ylim=(1e-18, 1e-8), xlabel="time (ms)", ylabel="channel current (A)")
    ax.legend(loc="upper right", fontsize=8)
    ax.set_title("(b) decay", fontsize=9, loc="left")


def _draw_edges(current: Current, ax: Axes) -> None:
    ax.axhline(0.0, color=INK, linewidth=0.5)
    ax.plot(1e6 * (current.time - ECHO_TIME), 1e6 * current.total, color=COLOURS[0], linewidth=1.2)
    ax.set(
        xlim=(-0.05, 0.25),
        xlabel=r"time after the echo's edge ($\mu$s)",
        ylabel=r"current into $V_{mem}$ ($\mu$A)",
    )
    ax.set_title("(c) transient", fontsize=9, loc="left")


EXPERIMENT = Experiment("cheely2003-fig5", "excitatory postsynaptic current after one echo", run)
