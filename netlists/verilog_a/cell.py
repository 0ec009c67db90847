"""A chip's behavioural neurons as Verilog-A: the reduced equations as a module, a chip of its instances.

The module is `rebound_cell`: v_mem, v_r and v_ex with their EKV currents and capacitances, and what is held
or counted as continuous states, since compilers for circuit simulators (OpenVAF) know no events: `inhibit`
falls from 1 to 1/2 in t_inh after a call, `fill` is the share of the axon's charge above the threshold, 0 at
least, and at 1 `fire` rises and falls within a spike's width. With q(x) = ln(1 + e^x):

    I_m1 = I_S [q((v_p - v_rest)/2U_T)^2 - q((v_p - v_mem)/2U_T)^2],  v_p = kappa_n (v_r - V_T0)
    I_m2 = I_S q((kappa_p (V_dd - v_mem - V_T0) - V_dd + v_r)/2U_T)^2
    I_me5 = I_S q(kappa_p (V_dd - v_ex - V_T0)/2U_T)^2
    I_me4 = I_forward - I_S q((v_p4 - V_dd + v_ex)/2U_T)^2
    d fill/dt = (v_mem - v_threshold) / axon_charge

All numbers are of one die at one temperature. Slopes of switches, their conductances and the rates of the
spike's states are ours: fast against what they switch. The text has no analysis and no testbench.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from circuits.silicon.silicon import Silicon
from netlists.verilog_a.law import softplus_text
from netlists.verilog_a.text import format_list, format_node
from netlists.write.deck import format_position

_REMARK = "behavioural level; not run in a simulator here, compiled by OpenVAF in the tests"
MODULE = "noctule_rebound_cell"
PORTS = ("call", "echo", "v_ex_max", "v_mem", "spike")

FIGURES: Mapping[str, str] = {  # of a cell, with unit
    "v_dd": "V", "inverse_2ut": "1/V, 1 / (2 U_T)", "kappa_n": "", "kappa_p": "", "v_rest": "V",
    "m1_current": "A, specific", "m1_threshold": "V", "m2_current": "A, specific", "m2_threshold": "V",
    "me4_current": "A, specific", "me4_pinch": "V", "me4_forward": "A, in saturation",
    "me5_current": "A, specific", "me5_threshold": "V", "i_rslope": "A, off currents of resets taken away",
    "i_rtau": "A", "t_inh": "s, v_mem held from a call on", "v_threshold": "V, v_mem at balance",
    "axon_charge": "V s, that fires", "pulse_width": "s, of a spike", "v_held": "V, of v_mem held",
    "echo_step": "V, of v_ex when an echo's pulse ends", "call_width": "s, between half-supply crossings",
    "c_mem": "F, to ground", "c_r": "F, to ground", "c_ex": "F, to ground", "c_mem_r": "F", "c_mem_ex": "F",
    "c_r_ex": "F",
}  # fmt: skip

_MODULE = """\
module {name}({ports});
  inout {ports};
  electrical {ports}, v_r, v_ex, inhibit, fill, fire;
{parameters}
  real pinch, a, b, c, e, q, i_m1, i_m2, i_me4, i_me5;
  real called, echoed, fired, held, coupled, rate, begun, full;

{softplus}
  analog function real past; // 0 below 0, 1 above it, within +- 3 widths
    input x, width;
    real x, width;
    past = 0.5 + 0.5 * tanh(x / width);
  endfunction

  analog begin
    // currents of the devices
    pinch = kappa_n * (V(v_r) - m1_threshold);
    a = softplus((pinch - v_rest) * inverse_2ut);
    b = softplus((pinch - V(v_mem)) * inverse_2ut);
    i_m1 = m1_current * (a - b) * (a + b);
    c = softplus((kappa_p * (v_dd - V(v_mem) - m2_threshold) - v_dd + V(v_r)) * inverse_2ut);
    i_m2 = m2_current * c * c;
    e = softplus(kappa_p * (v_dd - V(v_ex) - me5_threshold) * inverse_2ut);
    i_me5 = me5_current * e * e;
    q = softplus((me4_pinch - v_dd + V(v_ex)) * inverse_2ut);
    i_me4 = me4_forward - me4_current * q * q;

    // what is on: the call, the echo, a spike; v_mem held by inhibition or by a spike's reset
    called = past(V(call) / v_dd - 0.5, 1e-3);
    echoed = past(V(echo) / v_dd - 0.5, 1e-3);
    fired = past(V(fire) - 0.5, 1e-3);
    held = 1.0 - (1.0 - past(V(inhibit) - 0.5, 1e-6)) * (1.0 - fired);
    I(v_mem) <+ i_m1 - i_rslope - i_me5 + held * (V(v_mem) - v_held); // held by 1 S
    I(v_r) <+ i_m2 - i_rtau;
    I(v_ex) <+ 1e-3 * echoed * (V(v_ex) - V(v_ex_max)) - i_me4;

    // capacitances; the end of an echo's pulse moves v_ex alone, by echo_step
    coupled = echo_step * min(2.0 * V(echo) / v_dd, 1.0);
    I(v_mem) <+ ddt(c_mem * V(v_mem) - c_mem_ex * coupled);
    I(v_r) <+ ddt(c_r * V(v_r) - c_r_ex * coupled);
    I(v_ex) <+ ddt(c_ex * V(v_ex) + (c_ex + c_mem_ex + c_r_ex) * coupled);
    I(v_mem, v_r) <+ ddt(c_mem_r * V(v_mem, v_r));
    I(v_mem, v_ex) <+ ddt(c_mem_ex * V(v_mem, v_ex));
    I(v_r, v_ex) <+ ddt(c_r_ex * V(v_r, v_ex));

    // inhibition: 1 during the call's pulse, then a ramp through 1/2 at t_inh after the pulse's begin
    rate = 0.5 / (t_inh - call_width);
    I(inhibit) <+ 1e-12 * (rate * min(V(inhibit) / 0.1, 1.0) - 1e9 * called * (1.0 - V(inhibit)));
    I(inhibit) <+ ddt(1e-12 * V(inhibit));

    // axon: at fill = 1 both states run away, fire to 1; that empties fill, and fire falls through 1/2
    rate = 1000.0 / pulse_width;
    begun = past(V(fill) - 1.0, 1e-3);
    full = past(V(fire) - 0.99, 1e-4);
    I(fill) <+ 1e-12 * ((v_threshold - V(v_mem)) / axon_charge - 1e7 * softplus(-V(fill) / 1e-3));
    I(fill) <+ 1e-12 * rate * (full * V(fill) - begun * (1.0 - full) * (3.0 - V(fill)));
    I(fill) <+ ddt(1e-12 * V(fill));
    I(fire) <+ 1e-12 * (0.5 / pulse_width * min(V(fire) / 0.1, 1.0) - rate * begun * (1.0 - V(fire)));
    I(fire) <+ ddt(1e-12 * V(fire));
    I(spike) <+ 1e-3 * (V(spike) - v_dd * fired);
  end
endmodule
"""


@dataclass(frozen=True, slots=True)
class CellArray:
    """Behavioural neurons of a circuit on one die.

    `name`: of the circuit. `shape`: () for a lone neuron. `figures`: of each neuron, by the names of
    `FIGURES`, SI units. `remarks`: lines about validity and measured error.
    """

    name: str
    shape: tuple[int, ...]
    figures: Sequence[Mapping[str, float]]
    remarks: Sequence[str]


def format_cells(cells: CellArray, silicon: Silicon, title: str) -> str:
    """Text of the neurons' module, with the first one's figures as defaults, and of the chip."""
    head = [f"// {format_position(title, cells.name, silicon)}", f"// verilog-a: {_REMARK}"]
    head += [f"// {line}" for line in cells.remarks]
    chip = _chip(cells)
    return "\n".join([*head, '`include "disciplines.vams"', cell_module(cells.figures[0]), *chip]) + "\n"


def cell_module(figures: Mapping[str, float]) -> str:
    """Text of the module of a neuron, with these figures as the defaults of its parameters."""
    parameters = (
        f"  parameter real {name} = {float(figures[name])!r};{f' // {unit}' if unit else ''}"
        for name, unit in FIGURES.items()
    )
    return _MODULE.format(
        name=MODULE,
        ports=", ".join(PORTS),
        parameters="\n".join(parameters),
        softplus=softplus_text(36.0, 36.0, "exp(x)"),
    )


def _chip(cells: CellArray) -> list[str]:
    shared = ["call", "echo", "v_ex_max"]
    places = [f"[{k}]" for k in range(cells.shape[0])] if cells.shape else [""]
    own = {place: [format_node(f"{port}{place}") for port in ("v_mem", "spike")] for place in places}
    ports = [*shared, *(nodes[k] for k in (0, 1) for nodes in own.values())]
    lines = [
        *format_list(f"module {format_node(cells.name)}(", ports, ");", ""),
        *format_list("inout ", ports, ";"),
        *format_list("electrical ", ports, ";"),
    ]
    for (place, nodes), figures in zip(own.items(), cells.figures, strict=True):
        given = [f".{name}({float(figures[name])!r})" for name in FIGURES]
        lines += format_list(f"{MODULE} #(", given, ")")
        lines.append(f"    x{format_node(f'neuron{place}')}({', '.join([*shared, *nodes])});")
    return [*lines, "endmodule"]
