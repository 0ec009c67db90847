"""The processor that kernels are compiled for: the wider of two kinds that it may be.

Machine code for x86-64-v4 (vectors of 512 bits) or x86-64-v3 (of 256 bits, fused products: Intel's processors
since 2013, AMD's since 2015) runs on every processor that has as much, and so it can come with the package.
Where the processor is of no such kind, where numba has compiled something before, and where its user names a
processor by `NUMBA_CPU_NAME`, kernels are compiled for what is there.
"""

from __future__ import annotations

import llvmlite.binding as llvm  # type: ignore[import-untyped]
from numba.core import config
from numba.core.codegen import JITCPUCodegen
from numba.core.registry import cpu_target

_V3 = {
    "cx16", "popcnt", "sahf", "sse3", "ssse3", "sse4.1", "sse4.2", "avx", "avx2", "bmi", "bmi2", "f16c",
    "fma", "lzcnt", "movbe", "xsave",
}  # fmt: skip
_V4 = _V3 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl"}
KINDS = {"x86-64-v4": _V4, "x86-64-v3": _V3}
"""Features of each kind of processor, as LLVM calls them; the widest first."""
_CONFIG = vars(config)  # numba's settings, which it makes by their names


class PortableCodegen(JITCPUCodegen):
    """numba's code generator, for a kind of processor."""

    def __init__(self, module: str, kind: str) -> None:
        self._kind = kind
        super().__init__(module)

    def _get_host_cpu_name(self) -> str:
        return self._kind

    def _get_host_cpu_features(self) -> str:
        return ""  # those of the name


def kinds_here() -> list[str]:
    """The kinds of which this processor is, the widest first."""
    try:
        features = llvm.get_host_cpu_features()
    except RuntimeError:  # LLVM knows no way to ask
        features = {}
    has = {name for name, there in features.items() if there}
    return [kind for kind, needed in KINDS.items() if needed <= has]


def _settle() -> None:
    """Have numba compile for the kind of this processor, where that is possible."""
    kinds = kinds_here()
    if _CONFIG["CPU_NAME"] or _CONFIG["CPU_FEATURES"] or not kinds:
        return
    if "_toplevel_target_context" in vars(cpu_target):  # numba has compiled
        return
    codegen = PortableCodegen("noctule.exec", kinds[0])
    cpu_target.target_context._internal_codegen = codegen  # noqa: SLF001 - no other way


_settle()  # on import, which one thread does
