"""`ln(1 + e^x)` and its derivative on packed lanes, with full relative accuracy in both tails.

numba's wheel carries no vector math library, so that `math.exp` in a loop is a scalar call. Here
`t = e^-|x|` comes from a Cody-Waite reduction and a minimax polynomial, and
`log1p(t) = 2 atanh(t / (2 + t))` from a second one; the loops have no branch and the compiler packs them.
Relative error below 1e-14 (tested) for |x| <= 340; beyond, x is taken at the limit.
`softplus_five` is made for few numbers that are waited for: its polynomials are summed by pairs, so that few
products follow each other, and its relative error stays below 1e-12 (tested) over the same range.
Coefficients: minimax fits of e^r on |r| <= ln(2)/2 (error 2.2e-16) and atanh(z)/z on z <= 1/3 (1.8e-15).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, final

import numpy as np

from circuits.arrays import F64
from circuits.catalogue import later
from circuits.compiled import compiled, instructions
from circuits.vectors.vector import bits_of, of_bits

ir, types = later("llvmlite.ir"), later("numba.core.types")
kinds = later("circuits.vectors.vector_types")

LIMIT = 340.0
_LOG2E = 1.4426950408889634
_LN2_HIGH = 6.93147180369123816490e-01
_LN2_LOW = 1.90821492927058770002e-10
# 1.5 * 2^52: adding it rounds to the nearest integer and leaves that integer in the low mantissa bits.
_ROUND = 6755399441055744.0
_LANES = 8
_FUSED = ("contract",)
# Minimax fits of e^r on |r| <= ln(2)/2 (relative error 1.4e-14) and of ln(1 + t) / t on t <= 1 (8e-14).
_EXP = (
    1.0000000000000127, 0.9999999999998928, 0.49999999999457895, 0.1666666666782712, 0.041666667032503636,
    0.008333333002787201, 0.0013888802822499447, 0.00019841596420258644, 2.488401304576375e-05,
    2.74821844407226e-06,
)  # fmt: skip
_LOG1P = (
    0.9999999999999213, -0.4999999999587827, 0.33333332973436647, -0.24999987513540073,
    0.19999771047448708, -0.16664107328279482, 0.14266732321514877, -0.12401301846324851,
    0.10737294723392482, -0.08938938281612602, 0.06780283020082599, -0.043833282705579055,
    0.022414487349865928, -0.008294413449972171, 0.0019442707940410197, -0.00021467263078661544,
)  # fmt: skip


def _five_lanes(typingctx: Any, a: Any, b: Any, c: Any, d: Any, e: Any) -> Any:
    """`ln(1 + e^x)` of five numbers, then their slopes `1 / (1 + e^-x)`, in the lanes of one vector."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        x = ir.Constant(ir.VectorType(ir.DoubleType(), _LANES), ir.Undefined)
        for lane in range(_LANES):
            x = builder.insert_element(x, args[min(lane, len(args) - 1)], _lane(lane))
        found = [
            builder.extract_element(y, _lane(k))
            for y in _Packed(builder, x).softplus(x)
            for k in range(len(args))
        ]
        return context.make_tuple(builder, signature.return_type, found)

    ten = types.UniTuple(types.float64, 10)
    return ten(*(types.float64,) * 5), codegen


def _two_of_lanes(typingctx: Any, a: Any, b: Any) -> Any:
    """`ln(1 + e^x)` of a and of b, then both slopes; of `circuits.vectors.vector`."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        count = args[0].type.count
        both = builder.shuffle_vector(*args, _places(range(2 * count)))
        nothing = ir.Constant(both.type, ir.Undefined)
        found = [
            builder.shuffle_vector(y, nothing, _places(range(k, k + count)))
            for y in _Packed(builder, both).softplus(both)
            for k in (0, count)
        ]
        return context.make_tuple(builder, signature.return_type, found)

    return types.UniTuple(kinds.lanes, 4)(kinds.lanes, kinds.lanes), codegen


def _places(numbers: range) -> Any:
    return ir.Constant(ir.VectorType(ir.IntType(32), len(numbers)), list(numbers))


def _power_of_lanes(typingctx: Any, x: Any) -> Any:
    """`e^x`, of `circuits.vectors.vector`; beyond LIMIT either way it is that of the limit."""

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        packed = _Packed(builder, args[0])
        return packed.power(packed.within(args[0], packed.number(-LIMIT), packed.number(LIMIT)))

    return kinds.lanes(kinds.lanes), codegen


@final
class _Packed:
    """Writes instructions for vectors as wide as one that is given."""

    def __init__(self, builder: Any, like: Any) -> None:
        self._builder, self._real = builder, like.type
        self._whole = ir.VectorType(ir.IntType(64), like.type.count)

    def number(self, value: float) -> Any:
        """The number in all lanes."""
        return ir.Constant(self._real, [value] * self._real.count)

    def _integer(self, value: int) -> Any:
        return ir.Constant(self._whole, [value] * self._real.count)

    def _sum(self, x: Any, y: Any, plus: Any) -> Any:
        """`x y + plus`, rounded once where the processor can."""
        return self._builder.fadd(self._builder.fmul(x, y, flags=_FUSED), plus, flags=_FUSED)

    def _polynomial(self, x: Any, coefficients: Sequence[float]) -> Any:
        """By pairs, pairs of pairs and so on, so that few products wait for each other.

        Of vectors that are wider than the processor's the parts wait for none of each other: there each
        coefficient takes one product.
        """
        terms = [self.number(c) for c in coefficients]
        if self._real.count > _LANES:
            total = terms.pop()
            while terms:
                total = self._sum(total, x, terms.pop())
            return total
        while len(terms) > 1:
            pairs = zip(terms[::2], terms[1::2], strict=False)
            odd = terms[-1:] if len(terms) % 2 else []
            terms = [self._sum(b, x, a) for a, b in pairs] + odd
            x = self._builder.fmul(x, x)
        return terms[0]

    def within(self, x: Any, low: Any, high: Any) -> Any:
        """The nearest number from `low` to `high`; `high` for what is no number."""
        b = self._builder
        below = b.select(b.fcmp_ordered("<", x, high), x, high)
        return b.select(b.fcmp_ordered(">", below, low), below, low)

    def power(self, x: Any) -> Any:
        """`e^x` where x is within LIMIT of 0."""
        b = self._builder
        y = self._sum(x, self.number(_LOG2E), self.number(_ROUND))
        k = b.fsub(y, self.number(_ROUND))
        r = self._sum(k, self.number(-math.log(2.0)), x)
        shifted = b.shl(b.bitcast(y, self._whole), self._integer(52))
        scale = b.bitcast(b.add(shifted, self._integer(1023 << 52)), self._real)
        return b.fmul(self._polynomial(r, _EXP), scale)

    def softplus(self, x: Any) -> tuple[Any, Any]:
        """Instructions of `softplus`: its values and slopes."""
        b = self._builder
        absolute = b.bitcast(b.and_(b.bitcast(x, self._whole), self._integer((1 << 63) - 1)), self._real)
        inside = b.fcmp_ordered("<", absolute, self.number(LIMIT))
        t = self.power(b.fneg(b.select(inside, absolute, self.number(LIMIT))))
        log = b.fmul(t, self._polynomial(t, _LOG1P))
        s = b.fdiv(self.number(1.0), b.fadd(t, self.number(1.0)))
        positive = b.fcmp_ordered(">=", x, self.number(0.0))
        above = b.select(positive, x, self.number(0.0))
        return b.fadd(above, log), b.select(positive, s, b.fmul(t, s))


def _lane(k: int) -> Any:
    return ir.Constant(ir.IntType(32), k)


def _sum_of(x: float, coefficients: tuple[float, ...]) -> float:
    total = coefficients[-1]
    for c in coefficients[-2::-1]:
        total = total * x + c
    return total


def _power_alone(x: float) -> float:
    """`_Packed.power` of one number, for a run that goes alone."""
    inside = max(-LIMIT, min(LIMIT, x))
    y = inside * _LOG2E + _ROUND
    r = (y - _ROUND) * -math.log(2.0) + inside
    scale: float = of_bits((bits_of(y) << 52) + (1023 << 52))
    return _sum_of(r, _EXP) * scale


def _alone(x: float) -> tuple[float, float]:
    t = _power_alone(-abs(x))
    s = 1.0 / (t + 1.0)
    return max(0.0, x) + t * _sum_of(t, _LOG1P), s if x >= 0.0 else t * s


def _two_alone(a: float, b: float) -> tuple[float, float, float, float]:
    """`_Packed.softplus` of two numbers, for a run that goes alone."""
    of_a, by_a = _alone(a)
    of_b, by_b = _alone(b)
    return of_a, of_b, by_a, by_b


softplus_five = instructions(_five_lanes)
softplus_of_two = instructions(_two_of_lanes, _two_alone)
power_of_lanes = instructions(_power_of_lanes, _power_alone)


@compiled(fastmath={"contract"})
def exp_negative(a: float) -> float:
    """`e^-a` for a within LIMIT of 0, without a branch."""
    y = -a * _LOG2E + _ROUND
    k = y - _ROUND
    r = (-a - k * _LN2_HIGH) - k * _LN2_LOW
    p = 2.7626357241447223e-07
    p = p * r + 2.764018079620985e-06
    p = p * r + 2.4801504346997686e-05
    p = p * r + 0.00019841170270440067
    p = p * r + 0.0013888888932488599
    p = p * r + 0.008333333385667782
    p = p * r + 0.04166666666657314
    p = p * r + 0.16666666666554406
    p = p * r + 0.5000000000000006
    p = p * r + 1.0000000000000067
    p = p * r + 1.0
    power: float = of_bits((bits_of(y) << 52) + (1023 << 52))
    return p * power


@compiled(fastmath={"contract"})
def softplus(x: F64, value: F64, slope: F64) -> None:
    """Fill `value` with `ln(1 + e^x)` and `slope` with its derivative `1 / (1 + e^-x)`.

    x, value, slope: float64[n], without dimension.
    """
    for i in range(x.size):
        xi = x[i]
        t = exp_negative(min(abs(xi), LIMIT))
        z = t / (2.0 + t)
        w = z * z
        p = 0.09379009800523844
        p = p * w + 0.05872488909779737
        p = p * w + 0.0778535360074072
        p = p * w + 0.09084666995946904
        p = p * w + 0.11111354877359586
        p = p * w + 0.14285708967377525
        p = p * w + 0.2000000005790726
        p = p * w + 0.33333333333091286
        p = p * w + 1.0000000000000016
        value[i] = max(xi, 0.0) + 2.0 * z * p
        s = 1.0 / (1.0 + t)
        slope[i] = s if xi >= 0.0 else t * s


@compiled(fastmath={"contract"})
def softplus_at(x: float) -> float:
    """`ln(1 + e^x)` of one number, by the standard library."""
    return max(x, 0.0) + math.log1p(math.exp(-abs(x)))


def inverse_softplus(y: float) -> float:
    """The x at which `ln(1 + e^x)` is y, for y above zero."""
    return y + math.log(-math.expm1(-y))


def inverse_softplus_of(y: F64) -> F64:
    """The x at which `ln(1 + e^x)` is y, float64 in the shape of y, every one of which is above zero."""
    return np.asarray(y + np.log(-np.expm1(-y)))
