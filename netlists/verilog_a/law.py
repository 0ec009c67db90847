"""The laws of devices as Verilog-A modules: transistors of both polarities, diode, amplifier, linear devices.

A transistor's module has the process's figures as defaults of its parameters and applies the temperature laws
itself, at the simulator's `$temperature`, unless `temperature_c` (degC) holds one that is not below absolute
zero. Its noise is that of `circuits.devices.noise`: of the channel, white and, through the gate's
transconductance, flicker, and of both junctions; a resistor's is `4 k T / R`. `gamma` above 0 chooses the law
with body effect (`ekv-gamma`), 0 the one with a constant kappa. `delta_v_t0` and `delta_beta` are the
deviations of one device from the nominal. Equations:
`circuits.devices.transistor`, `circuits.devices.diode` and `circuits.devices.operational_amplifier`; every
charge stands under `ddt`. Breakdown's B is found by the fixed point of the diode's own file.
"""

from __future__ import annotations

import math

from circuits.devices.diode import FAR_CURRENT, ROUNDS, Diode
from circuits.devices.noise import CHANNEL_SHARE, CHANNEL_WEIGHT, noise_model
from circuits.devices.operational_amplifier import LEAST_HEADROOM
from circuits.devices.transistor import INDUCED_LIMIT
from circuits.silicon.process import BOLTZMANN, ELEMENTARY_CHARGE, ZERO_CELSIUS, Polarity
from circuits.silicon.silicon import Silicon
from netlists.write.bsim3 import refuse_sizes

TRANSISTORS: dict[Polarity, str] = {"n": "noctule_nfet", "p": "noctule_pfet"}
AMPLIFIER, CAPACITOR, DIODE, RESISTOR, TRANSCONDUCTOR = (
    "noctule_amplifier", "noctule_capacitor", "noctule_diode", "noctule_resistor", "noctule_transconductor",
)  # fmt: skip

_SOFTPLUS = """\
  analog function real softplus;
    input x;
    real x;
    if (x > {above})
      softplus = x;
    else if (x < -{below})
      softplus = {small};
    else
      softplus = ln(1.0 + exp(x));
  endfunction
"""

_TRANSISTOR = """\
module {name}(d, g, s, b);
  inout d, g, s, b;
  electrical d, g, s, b;
  parameter real w = 1e-6 from (0:inf); // m
  parameter real l = 1e-6 from (0:inf); // m
  parameter real m = 1 from (0:inf); // parallel devices
  parameter real delta_v_t0 = 0; // V, of the magnitude
  parameter real delta_beta = 0; // relative
  parameter real temperature_c = -1000; // degC; below absolute zero the simulator's temperature holds
{parameters}
  real t, rise, u_t, mobility, specific, threshold, v_g, v_s, v_d, v_x, v_p;
  real forward, backward, early, v_m, factor, channel, leakage, leak_d, leak_s;
  real spread, white, transconductance, flicker, shot_d, shot_s;

{softplus}
  analog function real junction;
    input y;
    real y;
    if (y > 20.0)
      junction = 1.0 - exp(20.0) * (y - 19.0);
    else
      junction = 1.0 - exp(y);
  endfunction

  analog function real share; // x^2 (1 - e^-x)
    input x;
    real x;
    if (x < 1e-4)
      share = x * x * x * (1.0 - 0.5 * x * (1.0 - x / 3.0));
    else
      share = x * x * (1.0 - exp(-x));
  endfunction

  analog function real induced;
    input v;
    real v;
    induced = gate_induced_leakage * exp(min((v - gate_induced_from) / gate_induced_slope, {limit}));
  endfunction

  analog begin
    t = temperature_c < -{zero} ? $temperature : temperature_c + {zero};
    rise = t - {zero} - nominal_temperature_c;
    u_t = {boltzmann} * t / {charge};
    threshold = v_t0 + v_t0_drift * rise + delta_v_t0;
    mobility = mu_cox * pow(t / (nominal_temperature_c + {zero}), mobility_exponent) * (1.0 + delta_beta);
    specific = 2.0 * mobility * u_t * u_t / kappa * m * w / l;
    v_g = {sign} * V(g, b);
    v_s = {sign} * V(s, b);
    v_d = {sign} * V(d, b);
    if (gamma > 0.0) begin
      v_x = max(v_g - threshold + surface_potential + gamma * sqrt(surface_potential), 0.0);
      v_p = v_x - surface_potential - gamma * (sqrt(v_x + 0.25 * gamma * gamma) - 0.5 * gamma);
    end else
      v_p = kappa * (v_g - threshold);
    forward = softplus(0.5 * (v_p - v_s) / u_t);
    backward = softplus(0.5 * (v_p - v_d) / u_t);
    early = 0.0;
    if (early_field > 0.0)
      early = abs(v_d - v_s) / (early_field * l * (1.0 + early_rise * (forward + backward)));
    v_m = 0.5 * (v_p + sqrt(v_p * v_p + 2.0 * u_t * u_t));
    factor = (1.0 + early) / (1.0 + mobility_reduction * v_m);
    channel = specific * (forward * forward - backward * backward) * factor;
    leakage = junction_leakage * pow(2.0, rise / leakage_doubling) * w * m;
    leak_d = leakage + w * m * induced(v_d - v_g);
    leak_s = leakage + w * m * induced(v_s - v_g);
    I(d, s) <+ {sign} * channel;
    I(d, b) <+ {sign} * leak_d * junction(-v_d / u_t);
    I(s, b) <+ {sign} * leak_s * junction(-v_s / u_t);

    // noise, A^2/Hz: the mean of x^2 (1 - e^-x) from backward to forward, by Gauss and Legendre
    spread = {spread};
    white = 8.0 * {charge} * specific * factor * spread / max(forward + backward, 1e-300);
    transconductance = ddx(channel, V(g));
    flicker = flicker_coefficient / (oxide_capacitance * w * l * m) * transconductance * transconductance;
    shot_d = 2.0 * {charge} * leak_d * (2.0 - junction(-v_d / u_t));
    shot_s = 2.0 * {charge} * leak_s * (2.0 - junction(-v_s / u_t));
    I(d, s) <+ white_noise(white, "channel");
    I(d, s) <+ flicker_noise(flicker, flicker_exponent, "flicker");
    I(d, b) <+ white_noise(shot_d, "drain_junction");
    I(s, b) <+ white_noise(shot_s, "source_junction");

    I(g, b) <+ ddt(gate_bulk_fraction * oxide_capacitance * w * l * m * V(g, b));
    I(g, d) <+ ddt(overlap_capacitance * w * m * V(g, d));
    I(g, s) <+ ddt(overlap_capacitance * w * m * V(g, s));
    I(d, b) <+ ddt(junction_capacitance * w * m * V(d, b));
    I(s, b) <+ ddt(junction_capacitance * w * m * V(s, b));
  end
endmodule
"""

_OF_DIODE = "\n".join(
    f"  parameter real {name} = {value!r};" for name, value in Diode("d", "a", "c").parameters().items()
)

_OTHERS = {
    AMPLIFIER: f"""\
module {AMPLIFIER}(positive, negative, out, vdd, vss);
  inout positive, negative, out, vdd, vss;
  electrical positive, negative, out, vdd, vss;
  parameter real gain = 1e5 from (0:inf);
  parameter real resistance = 100 from (0:inf); // ohm
  parameter real offset = 0; // V
  real half, swing, into;
  analog begin
    half = max(0.5 * V(vdd, vss), {LEAST_HEADROOM!r});
    swing = tanh(gain * (V(positive, negative) + offset) / half);
    into = (V(out, vss) - 0.5 * V(vdd, vss) - half * swing) / resistance;
    I(out, vdd) <+ 0.5 * (1.0 + swing) * into;
    I(out, vss) <+ 0.5 * (1.0 - swing) * into;
  end
endmodule
""",
    CAPACITOR: f"""\
module {CAPACITOR}(a, b);
  inout a, b;
  electrical a, b;
  parameter real c = 1e-12; // F
  analog I(a, b) <+ ddt(c * V(a, b));
endmodule
""",
    DIODE: f"""\
module {DIODE}(anode, cathode);
  inout anode, cathode;
  electrical anode, cathode;
{_OF_DIODE}
  real t, t_0, u_t, u, u_b, saturation, b, reference, height, capacitance, rest, bend, at_bend, v, i, q;
  integer round;

  analog function real shift; // what the band gap of silicon adds to a junction's potential, V
    input at;
    real at;
    shift = -3.0 * {BOLTZMANN!r} * at / {ELEMENTARY_CHARGE!r} * ln(at / 300.15)
      + 1.16 - 7.02e-4 * at * at / (at + 1108.0) - 1.1150877 * at / 300.15;
  endfunction

  analog function real exponential; // beyond {FAR_CURRENT!r} A its tangent
    input x, current;
    real x, current, highest;
    begin
      highest = ln({FAR_CURRENT!r} / current);
      exponential = x > highest ? {FAR_CURRENT!r} / current * (1.0 + x - highest) : exp(x);
    end
  endfunction

  analog begin
    t = $temperature;
    t_0 = nominal_temperature_c + {ZERO_CELSIUS!r};
    u_t = {BOLTZMANN!r} * t / {ELEMENTARY_CHARGE!r};
    u = emission * u_t;
    u_b = breakdown_emission * u_t;
    saturation = area * saturation_current
      * exp((t / t_0 - 1.0) * energy_gap / u + current_exponent / emission * ln(t / t_0));
    b = breakdown_voltage;
    if (breakdown_voltage > 0.0 && breakdown_current >= saturation * breakdown_voltage / u_t)
      for (round = 0; round < {ROUNDS}; round = round + 1)
        b = breakdown_voltage - u_b * ln(max(breakdown_current / saturation + 1.0 - b / u_t, 1.0));
    reference = (junction_potential - shift(t_0)) * 300.15 / t_0;
    height = shift(t) + reference * t / 300.15;
    capacitance = area * junction_capacitance
      * (1.0 + grading * (4e-4 * (t - 300.15) - (height / reference - 1.0)))
      / (1.0 + grading * (4e-4 * (t_0 - 300.15) - (junction_potential / reference - 1.0)));
    rest = 1.0 - forward_coefficient;
    bend = forward_coefficient * height;
    at_bend = capacitance * pow(rest, -grading);
    v = V(anode, cathode);
    if (v >= -3.0 * u)
      i = saturation * (exponential(v / u, saturation) - 1.0);
    else if (breakdown_voltage == 0.0 || v >= -b)
      i = -saturation * (1.0 + pow(3.0 * u / (v * {math.e!r}), 3.0));
    else
      i = -saturation * exponential(-(v + b) / u_b, saturation);
    if (v < bend)
      q = capacitance * height * (1.0 - pow(1.0 - v / height, 1.0 - grading)) / (1.0 - grading);
    else
      q = capacitance * height * (1.0 - pow(rest, 1.0 - grading)) / (1.0 - grading)
        + (v - bend) * at_bend * (1.0 + 0.5 * grading * (v - bend) / (rest * height));
    I(anode, cathode) <+ i;
    I(anode, cathode) <+ ddt(q + transit_time * i);
    I(anode, cathode) <+ white_noise(2.0 * {ELEMENTARY_CHARGE!r} * abs(i), "shot");
  end
endmodule
""",
    RESISTOR: f"""\
module {RESISTOR}(a, b);
  inout a, b;
  electrical a, b;
  parameter real r = 1e3 from (0:inf); // ohm
  analog begin
    I(a, b) <+ V(a, b) / r;
    I(a, b) <+ white_noise(4.0 * {BOLTZMANN!r} * $temperature / r, "thermal");
  end
endmodule
""",
    TRANSCONDUCTOR: f"""\
module {TRANSCONDUCTOR}(positive, negative, control_positive, control_negative);
  inout positive, negative, control_positive, control_negative;
  electrical positive, negative, control_positive, control_negative;
  parameter real gm = 0; // S
  analog I(positive, negative) <+ gm * V(control_positive, control_negative);
endmodule
""",
}
MODULES = frozenset({*TRANSISTORS.values(), *_OTHERS})

_FIGURES = (
    "v_t0", "kappa", "mu_cox", "surface_potential", "early_field", "early_rise", "mobility_reduction",
    "oxide_capacitance", "gate_bulk_fraction", "overlap_capacitance", "junction_capacitance",
    "junction_leakage", "gate_induced_leakage", "gate_induced_slope", "leakage_doubling", "v_t0_drift",
    "mobility_exponent",
)  # fmt: skip


def _transistor_module(silicon: Silicon, polarity: Polarity) -> str:
    """Module of a polarity's transistors, with the process's figures."""
    refuse_sizes(silicon, "modules of Verilog-A")
    model = silicon.process.model(polarity)
    figures = {name: getattr(model, name) for name in _FIGURES}
    figures["gamma"] = model.gamma if model.law == "ekv-gamma" else 0.0
    figures["gate_induced_from"] = silicon.process.v_dd
    figures["nominal_temperature_c"] = silicon.process.nominal_temperature_c
    noise = noise_model(silicon.process)
    figures |= {"flicker_coefficient": noise.flicker(polarity), "flicker_exponent": noise.exponent}
    return _TRANSISTOR.format(
        name=TRANSISTORS[polarity],
        parameters="\n".join(f"  parameter real {name} = {value!r};" for name, value in figures.items()),
        zero=repr(ZERO_CELSIUS),
        limit=repr(INDUCED_LIMIT),
        boltzmann=repr(BOLTZMANN),
        charge=repr(ELEMENTARY_CHARGE),
        spread=_spread(),
        sign="1.0" if polarity == "n" else "-1.0",
        softplus=softplus_text(37.0, 12.0, "exp(x) * (1.0 - 0.5 * exp(x))"),
    )


def _spread() -> str:
    """Text of the mean of `share` between `backward` and `forward`."""
    terms = (
        f"{float(weight)!r} * share(backward + (forward - backward) * {float(at)!r})"
        for at, weight in zip(CHANNEL_SHARE, CHANNEL_WEIGHT, strict=True)
    )
    return "\n      + ".join(terms)


def softplus_text(above: float, below: float, small: str) -> str:
    """Text of `softplus`, ln(1 + e^x): x itself where x > `above`, and `small` where x < -`below`."""
    return _SOFTPLUS.format(above=above, below=below, small=small)


def module_text(name: str, silicon: Silicon) -> str:
    """Text of one of `MODULES`."""
    polarity = next((p for p, module in TRANSISTORS.items() if module == name), None)
    return _OTHERS[name] if polarity is None else _transistor_module(silicon, polarity)
