"""The transistor's law without a branch, so that loops are packed, in the bits of `ekv.law` and `channel`.

`math.exp` and `math.log1p` in a loop are calls, one number each. What stands here follows the C library of
Linux (glibc, on processors with fused products) step for step, so that a kernel's answers are the same with
the one and the other (tested), in a quarter of the time:

* `e^x = 2^(k / 128) e^r`, `|r| <= ln(2) / 256`, by a table of `2^(i / 128)` and a polynomial of degree five;
* `ln(1 + t) = 2 atanh(t / (2 + t))` by a polynomial of degree seven, above `sqrt(2) - 1` that of half of
  `1 + t` and `ln 2`, with what `1 + t` was rounded by put back (after fdlibm, `s_log1p.c`).

Coefficients are those of the C library.
"""

from __future__ import annotations

from math import isqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from circuits.arrays import F64, I64
from circuits.catalogue import later
from circuits.compiled import compiled, instructions
from circuits.devices.channel import Terms, channel_between, channel_in, junction_at, leaked_at, pinched
from circuits.devices.ekv import interpolation
from circuits.devices.transistor import INDUCED_LIMIT

ir, types = later("llvmlite.ir"), later("numba.core.types")

LIMIT = 700.0
_TABLE, _TABLE_BITS = 128, 7
_PER_E = 1.4426950408889634 * _TABLE  # x in steps of the table
_STEP_HIGH, _STEP_LOW = -0.005415212348111709, -1.2864023111638344e-14  # -ln(2) / 128
_ROUND = 6755399441055744.0  # 1.5 * 2^52: adding it leaves the nearest integer in the low bits
_EXP = (0.49999999999996786, 0.16666666666665886, 0.0416666808410674, 0.008333335853059549)
_LOG = (
    6.666666666666735130e-01, 3.999999999940941908e-01, 2.857142874366239149e-01, 2.222219843214978396e-01,
    1.818357216161805012e-01, 1.531383769920937332e-01, 1.479819860511658591e-01,
)  # fmt: skip
_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
_HALVED = 0.4142136573791504  # from here on 1 + t is halved: sqrt(2) - 1
_NEAR_TWO = 1.9999971389770508  # 1 + t from which on what is left has one term
_FEW = 64  # numbers for which no kernel is called
_DIGITS = 200  # binary, of the table before it is rounded


def _table() -> tuple[F64, I64]:
    """Tables over i of what `2^(i / 128)` is beyond its float64, relative to it, and of that one's bits.

    Bits are less those of i steps, so that the bits of k steps may be added to them.
    """
    root = 2 << (2 * _DIGITS)  # of 2, in steps of 2^-_DIGITS
    for _ in range(_TABLE_BITS):
        root = isqrt(root) << _DIGITS
    root >>= _DIGITS
    beyond, bits, power = np.zeros(_TABLE), np.zeros(_TABLE, dtype=np.int64), 1 << _DIGITS
    for i in range(_TABLE):
        nearest = float(power / (1 << _DIGITS))
        exact = int(nearest * 2**52) << (_DIGITS - 52)
        beyond[i] = (power - exact) / exact
        bits[i] = np.float64(nearest).view(np.int64) - (i << (52 - _TABLE_BITS))
        power = (power * root) >> _DIGITS
    return beyond, bits


_BEYOND, _BITS = _table()


def _fused(typingctx: Any, x: Any, y: Any, plus: Any) -> Any:
    """`x y + plus`, rounded once."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.fma(*args)

    return types.float64(types.float64, types.float64, types.float64), codegen


def _whole(builder: Any, x: Any) -> Any:
    """Bits of a float64, as an int64."""
    return builder.bitcast(x, ir.IntType(64))


def _number(value: int) -> Any:
    return ir.Constant(ir.IntType(64), value)


def _place_of(typingctx: Any, rounded: Any) -> Any:
    """Place in the table of a number to which _ROUND was added."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.and_(_whole(builder, args[0]), _number(_TABLE - 1))

    return types.int64(types.float64), codegen


def _scaled(typingctx: Any, rounded: Any, bits: Any) -> Any:
    """`2^(k / 128)` of a number k to which _ROUND was added; bits: what the table has of it."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        shifted = builder.shl(_whole(builder, args[0]), _number(52 - _TABLE_BITS))
        return builder.bitcast(builder.add(shifted, args[1]), ir.DoubleType())

    return types.float64(types.float64, types.int64), codegen


_fma, _place, _scale = instructions(_fused), instructions(_place_of), instructions(_scaled)


def interpolation_of(u: ArrayLike) -> F64:
    """F(u) in the shape of u, which may be large; the same as `ekv.interpolation`."""
    x = np.asarray(u, dtype=np.float64)
    if x.size < _FEW:
        return interpolation(x)
    found = np.empty(x.shape)
    _interpolate(np.ravel(x), found.reshape(-1))
    return found


@compiled()
def _interpolate(u: F64, out: F64) -> None:
    for k in range(u.size):
        out[k] = even_interpolation(u[k])


@compiled(forceinline=True)
def even_exp(x: float) -> float:
    """`e^x` for x within LIMIT of 0, for use in compiled kernels."""
    y = _fma(_PER_E, x, _ROUND)
    k = y - _ROUND
    r = _fma(k, _STEP_LOW, _fma(k, _STEP_HIGH, x))
    i, square = _place(y), r * r
    more = _fma(square, _fma(r, _EXP[1], _EXP[0]), _BEYOND[i] + r)
    more = _fma(square * square, _fma(r, _EXP[3], _EXP[2]), more)
    scale = _scale(y, _BITS[i])
    power: float = _fma(scale, more, scale)
    return power


@compiled(forceinline=True)
def even_log1p(t: float) -> float:
    """`ln(1 + t)` for t from 0 to 1, for use in compiled kernels."""
    grown = 1.0 + t
    halved = t >= _HALVED
    f = 0.5 * grown - 1.0 if halved else t
    half = 0.5 * f * f
    s = f / (2.0 + f)
    z = s * s
    z2 = z * z
    z4 = z2 * z2
    r = _fma(z, _LOG[0], z2 * _fma(z, _LOG[2], _LOG[1]))
    r = _fma(z4, _fma(z, _LOG[4], _LOG[3]), r)
    r = s * (half + _fma(z2 * z4, _fma(z, _LOG[6], _LOG[5]), r))
    lost = _LN2_LOW + (t - (grown - 1.0)) / grown
    near = half * _fma(-f, 0.66666666666666666, 1.0) - lost
    above = _LN2_HIGH - ((near if grown >= _NEAR_TWO else half - (r + lost)) - f)
    above = _LN2_HIGH + (_LN2_LOW + (1.0 - (grown - t))) if grown == 2.0 else above
    below = f - (half - r)
    below = t - t * t * 0.5 if t < 2.0**-29 else below
    return above if halved else below


@compiled(forceinline=True)
def even_law(u: float) -> tuple[float, float]:
    """F(u) and its derivative; the same bits as `ekv.law`, for use in compiled kernels."""
    q, slope = _root(0.5 * u)
    return q * q, q * slope


@compiled(forceinline=True)
def even_interpolation(u: float) -> float:
    """F(u) alone; the same bits as `ekv.law`, for use in compiled kernels."""
    x = 0.5 * u
    q = max(x, 0.0) + even_log1p(even_exp(-min(abs(x), LIMIT)))
    return q * q


@compiled(forceinline=True)
def _root(x: float) -> tuple[float, float]:
    """`ln(1 + e^x)` and its derivative."""
    e = even_exp(-min(abs(x), LIMIT))
    s = 1.0 / (1.0 + e)
    return max(x, 0.0) + even_log1p(e), s if x >= 0.0 else e * s


@compiled(forceinline=True)
def even_channel(t: Terms, v_d: float, v_g: float, v_s: float) -> tuple[float, float, float, float]:
    """What `channel.channel` gives, in the same bits."""
    pinch = pinched(t, v_g)
    forward, reverse = _root((pinch[0] - v_s) * t.half), _root((pinch[0] - v_d) * t.half)
    return channel_between(t, (v_d, v_s), pinch, forward, reverse)


@compiled(forceinline=True)
def even_channel_in(
    t: Terms, ends: tuple[float, float], pinch: tuple[float, float], field: tuple[float, float, float]
) -> tuple[float, float, float, float]:
    """What `even_channel` gives, of what holds while its gate stays: `pinched` and `field_at`.

    ends: v_d and v_s, V.
    """
    forward, reverse = _root((pinch[0] - ends[1]) * t.half), _root((pinch[0] - ends[0]) * t.half)
    return channel_in(t, ends, pinch, field, forward, reverse)


@compiled(forceinline=True)
def even_leaked(t: Terms, v_j: float, v_g: float) -> tuple[float, float, float]:
    """What `channel.leaked` gives, in the same bits."""
    u, y = junction_at(t, v_j, v_g)
    grown = even_exp(max(min(y, INDUCED_LIMIT), -LIMIT))
    return leaked_at(t, (u, y), even_exp(-min(max(u, -20.0), LIMIT)), grown)
