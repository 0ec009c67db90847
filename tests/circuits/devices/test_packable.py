"""The law without a branch against the one by the standard library, and against long arithmetic."""

import platform
from decimal import Decimal, localcontext

import numpy as np

from circuits.arrays import F64
from circuits.compiled import compiled
from circuits.devices.ekv import law
from circuits.devices.packable import LIMIT, even_exp, even_interpolation, even_law, even_log1p
from circuits.machine_code.target import kinds_here

DRAW = np.random.default_rng(1000)
U = np.concatenate((
    DRAW.uniform(-120.0, 120.0, 40_000), DRAW.normal(size=20_000), 10.0 ** DRAW.uniform(-20.0, 3.5, 10_000),
    -(10.0 ** DRAW.uniform(-20.0, 3.5, 10_000)), np.log(2.0**0.5 - 1.0) + 1e-6 * DRAW.normal(size=10_000),
    [0.0, -0.0, 2.0 * LIMIT, -2.0 * LIMIT, 1e9, -1e9],
))  # fmt: skip


@compiled()
def both(u: F64, plain: F64, even: F64) -> None:
    """F and its derivative by the one and the other, float64[2, n] each."""
    for k in range(u.size):
        plain[0, k], plain[1, k] = law(u[k])
    for k in range(u.size):
        even[0, k], even[1, k] = even_law(u[k])


@compiled()
def parts(x: F64, power: F64, logarithm: F64, value: F64) -> None:
    """`e^-x`, `ln(1 + e^-x)` and `F(-x)`."""
    for k in range(x.size):
        power[k], value[k] = even_exp(-x[k]), even_interpolation(-x[k])
        logarithm[k] = even_log1p(power[k])


def test_bits_are_those_of_the_law_by_the_c_library() -> None:
    plain, even = np.empty((2, 2, U.size))
    both(U, plain, even)
    np.testing.assert_allclose(even, plain, rtol=1e-15, atol=0.0)  # two units of the last place
    name, version = platform.libc_ver()
    if name == "glibc" and (2, 28) <= tuple(map(int, version.split("."))) <= (2, 40) and kinds_here():
        np.testing.assert_array_equal(even, plain)


def test_power_and_logarithm_are_rounded_nearly_once() -> None:
    x = np.concatenate((10.0 ** DRAW.uniform(-12.0, 2.8, 300), [0.0, 0.8814, 0.8813]))
    power, logarithm, value = np.empty((3, x.size))
    parts(x, power, logarithm, value)
    with localcontext() as context:
        context.prec = 320
        for k, each in enumerate(x):
            assert abs(Decimal(power[k]) / Decimal(-each).exp() - 1) < Decimal("2e-16")
            assert abs(Decimal(logarithm[k]) / (1 + Decimal(power[k])).ln() - 1) < Decimal("3e-16")
    half, _, _ = np.empty((3, x.size))
    parts(0.5 * x, half, logarithm, value)
    parts(x, power, np.empty(x.size), value)
    np.testing.assert_array_equal(value, logarithm**2)
