"""A stand-in for CuPy without a graphics processor: a C++ compiler, and threads one by one."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from contextlib import nullcontext
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

COMPILER = shutil.which("c++") or shutil.which("g++")

_HEAD = """
#include <math.h>
#include <string.h>
#define __device__ static
#define __forceinline__ inline
#define __noinline__ inline
#define __global__
#define __constant__
#define __launch_bounds__(...)
struct Three { unsigned x; } blockIdx, blockDim, threadIdx;
static unsigned long long atomicAdd(unsigned long long *p, unsigned long long k) {
    const auto v = *p;
    *p += k;
    return v;
}
static long long __double_as_longlong(double x) { long long y; memcpy(&y, &x, 8); return y; }
static double __longlong_as_double(long long x) { double y; memcpy(&y, &x, 8); return y; }
#undef INFINITY
#undef NAN
extern "C" void be(unsigned block, unsigned size, unsigned thread) {
    blockIdx.x = block; blockDim.x = size; threadIdx.x = thread;
}
"""

_OPTIONS = {"-std=c++14": "-std=c++14", "-fmad=false": "-ffp-contract=off"}


class Array(np.ndarray):
    """An array that is on no device."""

    def get(self) -> np.ndarray:
        """A copy of it."""
        return np.array(self)


def _asarray(x: Any, order: Any = None) -> Any:
    return np.asarray(x, order=order).view(Array)  # in whatever order its elements are, unless told


@cache
def _library_of(code: str, options: tuple[str, ...]) -> ctypes.CDLL:
    """A text's library: several tests have the same, as runs of one process have on a device."""
    with tempfile.TemporaryDirectory() as folder:
        source, made = Path(folder, "text.cpp"), Path(folder, "text.so")
        source.write_text(_HEAD + code)
        command = [str(COMPILER), "-O1", "-w", "-shared", "-fPIC", "-o", str(made), str(source)]
        subprocess.run([*command, *(_OPTIONS[o] for o in options)], check=True)
        return ctypes.CDLL(str(made))


class RawModule:
    """A text, compiled."""

    def __init__(self, code: str, options: tuple[str, ...]) -> None:
        self._library = _library_of(code, tuple(options))

    def get_function(self, name: str) -> Any:
        """A function that is called with numbers of blocks and threads, and with what it takes."""
        function = self._library[name]

        def call(blocks: tuple[int], size: tuple[int], given: tuple[Any, ...]) -> None:
            for block in reversed(range(blocks[0])):
                for thread in reversed(range(size[0])):
                    self._library.be(block, size[0], thread)
                    function(*map(_argument, given))

        return call

    def get_global(self, name: str) -> Any:
        """Where a name's numbers are."""
        return ctypes.addressof(ctypes.c_double.in_dll(self._library, name))


def _argument(x: Any) -> Any:
    if isinstance(x, np.ndarray):
        return ctypes.c_void_p(x.ctypes.data)
    return ctypes.c_double(x) if isinstance(x, np.float64) else ctypes.c_longlong(int(x))


def _there(shape: tuple[int, ...], _kind: Any, place: int) -> Any:
    size = int(np.prod(shape))
    return np.ctypeslib.as_array((ctypes.c_double * size).from_address(place)).reshape(shape)


def stand_in(multiprocessors: int = 1) -> SimpleNamespace:
    """What `circuits.programs.gpu.cupy` gives, of a device of so many multiprocessors."""
    device = SimpleNamespace(attributes={"MultiProcessorCount": multiprocessors})
    return SimpleNamespace(
        asarray=_asarray,
        zeros=lambda shape, kind: np.zeros(shape, kind).view(Array),
        arange=lambda n: np.arange(n).view(Array),
        where=np.where, nonzero=np.nonzero, ndarray=_there, RawModule=RawModule,
        uint64=np.uint64, int64=np.int64, float64=np.float64,
        cuda=SimpleNamespace(Device=lambda: device, Stream=lambda **_: nullcontext()),
    )  # fmt: skip
