"""Programs (`circuits.programs.specialised`) on a graphics processor, a run a thread: the place of CuPy.

    on_gpu = compiled_program(program, private, constants.size)
    on_gpu.launch(arrays, numbers, constants, order, runs, threads(runs))

A thread does run after run: each takes the next one of a queue when its last one is over, so that runs may
be as different as they like. Text is compiled by NVIDIA's run-time compiler at the first call, and CuPy keeps
what it made. `there_is_one` says whether there is a graphics processor; without CuPy there is none.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, lru_cache
from importlib import import_module
from typing import Any, final

import numpy as np

from circuits.arrays import F64, I64
from circuits.errors import ParameterError
from circuits.programs.c_text import REAL, WHOLE, c_text, functions_text
from circuits.programs.program import Program

THREADS = 128  # of a block at most
BLOCKS = 1  # that a multiprocessor has at a time: what two have beside their registers fits no cache
_WARP = 32  # threads that go together
_CONSTANTS = 7000  # numbers that fit into the memory of constants
_HEAD = """
#define THREAD (blockIdx.x * blockDim.x + threadIdx.x)
__device__ __forceinline__ long long bits_of(double x) { return __double_as_longlong(x); }
__device__ __forceinline__ double of_bits(long long x) { return __longlong_as_double(x); }
#define INFINITY __longlong_as_double(0x7ff0000000000000LL)
#define NAN __longlong_as_double(0x7ff8000000000000LL)
__device__ long long next_run(
        const long long *order, unsigned long long *queue, long long left, long long runs) {
    const unsigned long long k = atomicAdd(queue, 1ULL);
    return k < (unsigned long long) left ? order[k] : runs;
}
#define take() next_run(order, queue, left, runs)
"""


def there_is_one() -> bool:
    """Whether there is a graphics processor that programs can run on."""
    found = _imported()
    if found is None:
        return False
    try:
        return int(found.cuda.runtime.getDeviceCount()) > 0
    except found.cuda.runtime.CUDARuntimeError:
        return False


def cupy() -> Any:
    """CuPy; ParameterError, with what is missing, where programs cannot run."""
    if not there_is_one():
        missing = (
            "CuPy; install noctule[gpu]" if _imported() is None else "a graphics processor, and CUDA has none"
        )
        raise ParameterError(f"device: gpu, needs {missing}; or leave the device out")
    return _imported()


@cache
def _imported() -> Any:
    try:
        return import_module("cupy")
    except ImportError:
        return None


def name() -> str:
    """What the graphics processor is called."""
    runtime = cupy().cuda.runtime
    return str(runtime.getDeviceProperties(runtime.getDevice())["name"].decode())


def stream() -> Any:
    """What is done inside goes on by itself, beside what other threads have the device do."""
    return cupy().cuda.Stream(non_blocking=True)


def threads(runs: int) -> int:
    """How many threads work on a number of runs."""
    return min(_at_once() * THREADS, -(-runs // _WARP) * _WARP)


def _at_once() -> int:
    """How many blocks the device has at a time."""
    return int(cupy().cuda.Device().attributes["MultiProcessorCount"]) * BLOCKS


def on_device(array: Any) -> Any:
    """An array on the device, in the order in which programs read it; CuPy alone keeps another one's."""
    return cupy().asarray(array, order="C")


def compiled_program(program: Program, private: Mapping[str, int], constants: int) -> GpuProgram:
    """What a program is for a graphics processor.

    private: names of shared arrays of which each thread has its own part, with the part's size. constants:
    how many numbers it has of the name `same`.
    """
    return GpuProgram(program, _text(program, private, constants), constants)


@final
class GpuProgram:
    """A program, and the function that is compiled of its text."""

    def __init__(self, program: Program, text: str, constants: int) -> None:
        self._program, self.text, self._in_constants = program, text, constants <= _CONSTANTS

    def launch(
        self, arrays: Mapping[str, Any], numbers: Mapping[str, float], constants: F64, order: I64, runs: int,
        count: int,
    ) -> None:  # fmt: skip
        """Have threads do the runs that are in `order`.

        arrays: on the device, by name. numbers: by name. runs: how many there are in all. count: of threads.
        """
        cp = cupy()
        module = _compiled(self.text, ())
        same = on_device(constants)
        if self._in_constants and constants.size:
            cp.ndarray(constants.shape, cp.float64, module.get_global("same"))[...] = same
        given = [arrays[s.name] for s in self._program.shared]
        given += [np.float64(numbers[name]) for name in self._program.arguments]
        given += [same, on_device(order), cp.zeros(1, cp.uint64), np.int64(order.size), np.int64(runs)]
        given.append(np.int64(count))
        own = -(-count // (_at_once() * _WARP)) * _WARP  # so that all multiprocessors have some
        size = min(THREADS, own)
        module.get_function("run")((-(-count // size),), (size,), tuple(given))


def function_of(text: str, name: str, *options: str) -> Any:
    """A function of a text of CUDA, compiled at the first call."""
    return _compiled(text, options).get_function(name)


@lru_cache(maxsize=64)
def _compiled(text: str, options: tuple[str, ...]) -> Any:
    return cupy().RawModule(code=text, options=("-std=c++14", *options))


def _text(program: Program, private: Mapping[str, int], constants: int) -> str:
    """CUDA's text of a program."""
    declared, body = c_text(program, ("runs", "take"))
    kinds = {s.name: WHOLE if s.whole else REAL for s in program.shared}
    arguments = [f"{kind} * __restrict__ {name}" for name, kind in kinds.items()]
    arguments += [f"const {REAL} {name}" for name in program.arguments]
    held = "same_in_memory" if constants <= _CONSTANTS else "same"
    arguments += [
        f"const {REAL} * __restrict__ {held}", f"const {WHOLE} *order", f"unsigned {WHOLE} *queue",
        f"const {WHOLE} left", f"const {WHOLE} runs", f"const {WHOLE} threads",
    ]  # fmt: skip
    own = [f"{name} += ({WHOLE}) THREAD * {size};" for name, size in private.items() if name in kinds]
    begun = [
        f"for (int k = 0; k < {m.size}; k++) {m.name}[k] = 0;"
        for m in program.memory if m.size <= 1
    ]  # fmt: skip
    leave = ["if (THREAD >= threads) return;"]  # of the last block, which have no part of their own
    lines = [*declared, *leave, *own, *begun, *body]
    constant = [f"__constant__ {REAL} same[{max(constants, 1)}];"] if constants <= _CONSTANTS else []
    signature = (
        f'extern "C" __global__ void __launch_bounds__({THREADS}, {BLOCKS}) run({", ".join(arguments)}) {{'
    )
    functions = functions_text(program, "__device__ __noinline__")
    return "\n".join([_HEAD, *functions, *constant, signature, *lines, "}", ""])
