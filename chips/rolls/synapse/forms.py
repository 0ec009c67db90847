"""Published equations of silicon synapses and neurons in software models, beside the circuits' own.

Currents in A, times in s. All forms are rates of ln I, of a filter's output I or of I_mem, with an input that
a differential pair divides. Published (teili and dynapse-sim, after Chicca et al. 2014; rockpool):

    synapse   (1 + I_th/I) tau dI/dt = (I_th/I_tau) I_w - I - I_th           `synapse_full`
              tau dI/dt = (I_th/I_tau) I_w - I                               `synapse_linear`, I >> I_th
              a spike adds I_w I_th / (I_tau (1 + I_th/I)), whatever its pulse's length   `synapse_jump`
    neuron    (1 + I_th/I) tau dI/dt = (I_th/I_tau)(I_in + I_a - I_ahp) - I_th - I (1 + (I_ahp - I_a)/I_tau)
              I_a = I_again / (1 + e^(-(I - I_ath) / I_anorm))               `feedback_sigmoid`
              I_a = I_0^(1/(kappa+1)) I^(kappa/(kappa+1))                    `feedback_power`
              a form without the term -I_th; one that counts I_ahp twice (rockpool's code)

In the circuits here the pair and the device that I is read with have kappas of their own; in weak inversion

    synapse   tau dlnI/dt = (I_w/I_tau) / (1 + (I/I_th)^(kappa_n/kappa_p)) - 1,          tau with kappa_p
    neuron    tau dlnI/dt = (I_in/I_tau) / (1 + (I/I_th)^(kappa_p/kappa_n)) - 1 + (I_a - I_ahp)/I_tau,
              I_a = alpha I,   alpha = e^(-v_shift/U_T) times the ratio of sizes,        tau with kappa_n

which is the published form where the kappas are equal: -I_th belongs there, and I_ahp once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from circuits.arrays import F64
from circuits.blocks.rolls import dpi_synapse
from circuits.blocks.rolls import neuron as rolls_neuron
from circuits.blocks.rolls.bias import default_current
from circuits.silicon.process import ROLLS_180_IDEAL, thermal_voltage

Growth = Callable[[F64], F64]  # tau dlnI_mem/dt over I_mem

POINTS = 20_001  # of ln I in a period
STEPS = 400  # of a pulse
# published constants that the circuit has no counterpart of: teili's
AGAIN, ATH, ANORM = 50e-12, 0.5e-9, 10e-12


@dataclass(frozen=True, slots=True)
class SynapseForm:
    """A filter by its currents: weight, threshold, leak and rest, A; tau, s; ratio of the kappas."""

    i_w: float
    i_th: float
    i_tau: float
    tau: float
    rest: float
    power: float = 1.0  # kappa of the pair over that of the output


@dataclass(frozen=True, slots=True)
class NeuronForm:
    """A neuron by its currents, A, and times, s; power: kappa of the pair over that of I_mem."""

    i_th: float
    i_tau: float
    tau: float
    spike: float
    reset: float
    refractory: float
    alpha: float
    i_0: float
    kappa: float
    power: float = 1.0


Pulse = Callable[[SynapseForm, float, float], float]


def synapse_full(s: SynapseForm, i: float, width: float) -> float:
    """Return the current after a pulse of `width` s from `i`, A, by the published form with its -I_th."""
    return _grown(s, i, width, 1.0)


def synapse_pair(s: SynapseForm, i: float, width: float) -> float:
    """Return what `synapse_full` does, by the circuit's form with both kappas."""
    return _grown(s, i, width, s.power)


def synapse_linear(s: SynapseForm, i: float, width: float) -> float:
    """Return what `synapse_full` does, by the form for I >> I_th."""
    end = s.i_th * s.i_w / s.i_tau
    return end + (i - end) * math.exp(-width / s.tau)


def _grown(s: SynapseForm, i: float, width: float, power: float) -> float:
    """`tau dx/dt = (I_w/I_tau) / (1 + e^(power x)) - 1` with x = ln(I/I_th), by the midpoint rule."""
    x, gain, h = math.log(i / s.i_th), s.i_w / s.i_tau, width / STEPS / s.tau
    for _ in range(STEPS):
        middle = x + 0.5 * h * (gain / (1.0 + math.exp(power * x)) - 1.0)
        x += h * (gain / (1.0 + math.exp(power * middle)) - 1.0)
    return s.i_th * math.exp(x)


def synapse_train(s: SynapseForm, form: Pulse, width: float, rate: float, events: int) -> tuple[float, float]:
    """Return peak and mean of a train's last period, from pulses of `width` s at `rate` Hz, A."""
    i = s.rest
    peak = charge = 0.0
    for _ in range(events):
        peak = max(form(s, i, width), s.rest)
        # between pulses every form falls with tau, down to rest
        gap = 1.0 / rate - width
        after = max(peak * math.exp(-gap / s.tau), s.rest)
        charge = 0.5 * width * (i + peak) + s.tau * (peak - after)
        i = after
    return peak, charge * rate


def synapse_jumps(s: SynapseForm, rate: float, events: int) -> tuple[float, float]:
    """Return what `synapse_train` does, each spike adding its increment at once."""
    i = s.rest
    peak = mean = 0.0
    for _ in range(events):
        peak = i + s.i_w * s.i_th / (s.i_tau * (1.0 + s.i_th / i))
        i = max(peak * math.exp(-1.0 / (rate * s.tau)), s.rest)
        mean = s.tau * (peak - i) * rate
    return peak, mean


def feedback_sigmoid(_: NeuronForm) -> Growth:
    """Return the published feedback: a sigmoid of I_mem with teili's constants."""
    return lambda i: AGAIN / (1.0 + np.exp(-np.clip((i - ATH) / ANORM, -500.0, 500.0)))


def feedback_power(n: NeuronForm) -> Growth:
    """Return the published feedback: a power of I_mem."""
    return lambda i: n.i_0 ** (1.0 / (n.kappa + 1.0)) * i ** (n.kappa / (n.kappa + 1.0))


def feedback_linear(n: NeuronForm) -> Growth:
    """Return the circuit's feedback, in proportion to I_mem."""
    return lambda i: n.alpha * i


def neuron_published(n: NeuronForm, feedback: Growth, i_in: float, i_ahp: float = 0.0) -> Growth:
    """Return the published form over I_mem."""
    return lambda i: i_in / n.i_tau * n.i_th / (i + n.i_th) - 1.0 + (feedback(i) - i_ahp) / n.i_tau


def neuron_without_threshold(n: NeuronForm, feedback: Growth, i_in: float, i_ahp: float = 0.0) -> Growth:
    """Return the published form without its term -I_th."""
    whole = neuron_published(n, feedback, i_in, i_ahp)
    return lambda i: whole(i) + n.i_th / (i + n.i_th)


def neuron_pair(n: NeuronForm, feedback: Growth, i_in: float, i_ahp: float = 0.0) -> Growth:
    """Return the circuit's form, with both kappas."""
    return lambda i: i_in / n.i_tau / (1.0 + (i / n.i_th) ** n.power) - 1.0 + (feedback(i) - i_ahp) / n.i_tau


def rate_of(n: NeuronForm, growth: Growth) -> float:
    """Return the rate of a form, Hz: `1 / (t_ref + tau int dlnI / growth)` up to the spike, 0 at rest."""
    log = np.linspace(math.log(n.reset), math.log(n.spike), POINTS)
    found = growth(np.exp(log))
    if found.min() <= 0.0:
        return 0.0
    return 1.0 / (n.refractory + n.tau * float(np.trapezoid(1.0 / found, log)))


def circuit_synapse(level_current: float, capacitance: float, temperature_c: float = 27.0) -> SynapseForm:
    """Return the circuit's excitatory filter with its default biases; capacitance: at v_syn, F."""
    p, n = ROLLS_180_IDEAL.p, ROLLS_180_IDEAL.n
    params = dpi_synapse.Params()
    i_tau = default_current("NPDPIE_TAU_P")
    tau = capacitance * thermal_voltage(temperature_c) / (p.kappa * i_tau)
    rest = off_current(p.mu_cox, p.kappa, p.v_t0) * params.output_width / params.output_length
    return SynapseForm(level_current, default_current("NPDPIE_THR_P"), i_tau, tau, rest, n.kappa / p.kappa)


def circuit_neuron(capacitance: float, temperature_c: float = 27.0) -> NeuronForm:
    """Return the circuit's neuron with its default biases, its faster leak and no I_dc; capacitance: F."""
    p, n, u_t = ROLLS_180_IDEAL.p, ROLLS_180_IDEAL.n, thermal_voltage(temperature_c)
    params = rolls_neuron.Params()
    i_tau, square = default_current("IF_TAU2_N"), params.pair_width / params.pair_length
    feedback = params.feedback_width / params.feedback_length / square
    shift = next(float(np.ravel(b.value)[0]) for b in rolls_neuron.BIASES if b.name == "v_shift")
    i_0 = off_current(n.mu_cox, n.kappa, n.v_t0)
    refractory = params.refractory_capacitance * 0.5 * ROLLS_180_IDEAL.v_dd / default_current("IF_RFR2_N")
    return NeuronForm(
        default_current("IF_THR_N"), i_tau, capacitance * u_t / (n.kappa * i_tau),
        default_current("IF_BUF_P") * square, i_0 * square, refractory,
        feedback * math.exp(-shift / u_t), i_0, n.kappa, p.kappa / n.kappa,
    )  # fmt: skip


def off_current(mu_cox: float, kappa: float, v_t0: float, temperature_c: float = 27.0) -> float:
    """Return I_0 of a square device, A: `2 mu Cox U_T^2 / kappa e^(-kappa V_T0 / U_T)`."""
    u_t = thermal_voltage(temperature_c)
    return 2.0 * mu_cox * u_t**2 / kappa * math.exp(-kappa * v_t0 / u_t)
