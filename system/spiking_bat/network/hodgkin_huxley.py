"""Compiled step of Hodgkin-Huxley neurons: the squid axon with an excitatory and an inhibitory conductance.

With v the membrane's voltage and u = v + 65 mV:

    C dv/dt = -g_Na m^3 h (v - E_Na) - g_K n^4 (v - E_K) - g_L (v - E_L) - g_e (v - E_e) - g_i (v - E_i) + I
    dx/dt = alpha_x (1 - x) - beta_x x,    x = m, h, n

    alpha_m = 0.1 (25 - u) / (e^((25 - u) / 10) - 1)    beta_m = 4 e^(-u / 18)
    alpha_h = 0.07 e^(-u / 20)                          beta_h = 1 / (e^((30 - u) / 10) + 1)
    alpha_n = 0.01 (10 - u) / (e^((10 - u) / 10) - 1)   beta_n = 0.125 e^(-u / 80)

with u in mV and rates in 1/ms. A conductance is the alpha function of equation (13) of Wen & Horiuchi 2022,
as two states that a step multiplies exactly: g' = x - g / tau, x' = -x / tau, and a spike adds g_syn e / tau
to x.

Method: exponential Euler, every variable relaxing over a step with the others as they were at its beginning.
The paper does not say its method.

All exponentials of a voltage are powers of p = e^(-u / 720 mV): 80 = 720 / 9, 20 = 720 / 36, 18 = 720 / 40,
10 = 720 / 72. u / 720 mV is so small that a polynomial gives p, and (1 - e^-z) / z is one too: there is no
branch and no call, so that the loop over the lanes of a block becomes vector instructions.

Sources: Hodgkin & Huxley (1952), their rates with the sign of the voltage turned; equations (12), (13).
"""

from __future__ import annotations

import math

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled

LANES = 64  # neurons of a block, side by side
# rows of a block: state, then constants of each neuron, then whether it has just spiked
(
    V, M, H, N, G_E, X_E, G_I, X_I, DECAY_E, DECAY_I, CURRENT, SPIKED,
) = range(12)  # fmt: skip
ROWS = 12
BLOCK = ROWS * LANES

_CAPACITANCE = 1e-2  # F/m^2
G_NA, G_K, G_L = 1200.0, 360.0, 3.0  # S/m^2
E_NA, E_K, E_L = 50e-3, -77e-3, -54.387e-3  # V
E_EXC, E_INH = 10e-3, -70e-3  # V, the paper's
REST = -65e-3  # V, at which u = 0
THRESHOLD = 0.0  # V, whose upward crossing is a spike; ours

_E10, _E25, _E30 = math.exp(1.0), math.exp(2.5), math.exp(3.0)
_NEAR = 1e-3  # |x| below which x / (e^x - 1) is its series, 1.4e-15 off

# kept from being reordered, so that a run is the same to the bit; a product and a sum may be one instruction
_compiled = compiled(fastmath={"contract"})
_inlined = compiled(fastmath={"contract"}, forceinline=True)


@_inlined
def exp_small(y: float) -> float:
    """e^y for |y| <= 0.2 within 2e-12, by its series to y^8."""
    y2 = y * y
    low = 1.0 + y + y2 * (0.5 + y * (1.0 / 6.0))
    high = 1.0 / 24.0 + y * (1.0 / 120.0) + y2 * (1.0 / 720.0 + y * (1.0 / 5040.0) + y2 * (1.0 / 40320.0))
    return low + y2 * y2 * high


@_inlined
def relaxation(z: float) -> float:
    """(1 - e^-z) / z for 0 <= z <= 0.3 within 3e-10, by its series to z^7."""
    z2 = z * z
    low = 1.0 - z * 0.5 + z2 * (1.0 / 6.0 - z * (1.0 / 24.0))
    high = 1.0 / 120.0 - z * (1.0 / 720.0) + z2 * (1.0 / 5040.0 - z * (1.0 / 40320.0))
    return low + z2 * z2 * high


@_inlined
def relaxation_wide(z: float) -> float:
    """(1 - e^-z) / z for 0 <= z <= 2.4 within 1e-9: f(2 z) = f(z) (1 - z f(z) / 2), three times."""
    y = 0.125 * z
    f = relaxation(y)
    f *= 1.0 - 0.5 * y * f
    f *= 1.0 - y * f
    return f * (1.0 - 2.0 * y * f)


@_inlined
def rates(v: float) -> tuple[float, float, float, float, float, float]:
    """Rates alpha of m, h and n at v (V), then alpha + beta of each, 1/s."""
    y = (v - REST) * (-1.0 / 0.72)
    p = exp_small(y)
    p2 = p * p
    p4 = p2 * p2
    p8 = p4 * p4
    p9 = p8 * p  # e^(-u / 80)
    p18 = p9 * p9
    p36 = p18 * p18  # e^(-u / 20)
    p40 = p36 * p4  # e^(-u / 18)
    p72 = p36 * p36  # e^(-u / 10)
    x1, x2 = 2.5 + 72.0 * y, 1.0 + 72.0 * y
    near1, near2 = abs(x1) < _NEAR, abs(x2) < _NEAR
    d1 = 1.0 if near1 else _E25 * p72 - 1.0
    d2 = 1.0 if near2 else _E10 * p72 - 1.0
    d3 = _E30 * p72 + 1.0
    d12 = d1 * d2
    share = 1.0 / (d12 * d3)  # one division for all three
    b_h = 1e3 * share * d12
    share *= d3
    a_m = 1e3 * (1.0 - x1 * (0.5 - x1 * (1.0 / 12.0)) if near1 else x1 * share * d2)
    a_n = 1e2 * (1.0 - x2 * (0.5 - x2 * (1.0 / 12.0)) if near2 else x2 * share * d1)
    a_h = 70.0 * p36
    return a_m, a_h, a_n, a_m + 4e3 * p40, a_h + b_h, a_n + 125.0 * p9


@_compiled
def step_blocks(blocks: F64, step: float) -> None:
    """Advance all neurons by `step` s; blocks: float64[count * BLOCK], block after block, row after row.

    SPIKED becomes 1 where v has crossed the threshold upwards in this step, else 0.
    """
    rate = step / _CAPACITANCE
    for b in range(blocks.size // BLOCK):
        at = b * BLOCK
        for k in range(at, at + LANES):
            v = blocks[k + V * LANES]
            a_m, a_h, a_n, s_m, s_h, s_n = rates(v)
            m, h, n = blocks[k + M * LANES], blocks[k + H * LANES], blocks[k + N * LANES]
            g_e, g_i = blocks[k + G_E * LANES], blocks[k + G_I * LANES]
            sodium = G_NA * (m * m) * (m * h)
            n2 = n * n
            potassium = G_K * (n2 * n2)
            total = sodium + potassium + G_L + g_e + g_i
            drive = sodium * E_NA + potassium * E_K + (G_L * E_L) + g_e * E_EXC + g_i * E_INH
            drive += blocks[k + CURRENT * LANES]
            new = v + rate * (drive - total * v) * relaxation_wide(rate * total)
            blocks[k + V * LANES] = new
            blocks[k + M * LANES] = m + step * (a_m - s_m * m) * relaxation(step * s_m)
            blocks[k + H * LANES] = h + step * (a_h - s_h * h) * relaxation(step * s_h)
            blocks[k + N * LANES] = n + step * (a_n - s_n * n) * relaxation(step * s_n)
            x_e, x_i = blocks[k + X_E * LANES], blocks[k + X_I * LANES]
            e, i = blocks[k + DECAY_E * LANES], blocks[k + DECAY_I * LANES]
            blocks[k + G_E * LANES] = (g_e + step * x_e) * e
            blocks[k + G_I * LANES] = (g_i + step * x_i) * i
            blocks[k + X_E * LANES] = x_e * e
            blocks[k + X_I * LANES] = x_i * i
            blocks[k + SPIKED * LANES] = 1.0 if v < THRESHOLD <= new else 0.0


def rest_gates(v: float = REST) -> tuple[float, float, float]:
    """m, h and n at rest at a voltage (V)."""
    u = 1e3 * (v - REST)
    x1, x2 = 0.1 * (25.0 - u), 0.1 * (10.0 - u)
    pairs = (
        (x1 / math.expm1(x1) if x1 else 1.0, 4.0 * math.exp(-u / 18.0)),
        (0.07 * math.exp(-u / 20.0), 1.0 / (math.exp(0.1 * (30.0 - u)) + 1.0)),
        (0.1 * x2 / math.expm1(x2) if x2 else 0.1, 0.125 * math.exp(-u / 80.0)),
    )
    m, h, n = (a / (a + b) for a, b in pairs)
    return m, h, n


def new_blocks(count: int) -> F64:
    """Blocks of `count` neurons at -65 mV with their gates at rest there, without synapses or current."""
    blocks = np.zeros((-(-count // LANES), ROWS, LANES))
    blocks[:, V] = REST
    for row, gate in zip((M, H, N), rest_gates(), strict=True):
        blocks[:, row] = gate
    return blocks.reshape(-1)
