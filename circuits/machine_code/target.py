"""The processor that kernels are compiled for: of a kind that most are, so that these agree to the bit.

Machine code for x86-64-v3 (AVX2 and fused products: Intel's processors since 2013, AMD's since 2015) runs on
all later ones too, and so it can come with the package. Where the processor is of another kind, where numba
has compiled something before, and where its user names a processor by `NUMBA_CPU_NAME`, kernels are compiled
for what is there.
"""

from __future__ import annotations

import llvmlite.binding as llvm  # type: ignore[import-untyped]
from numba.core import config
from numba.core.codegen import JITCPUCodegen
from numba.core.registry import cpu_target

PORTABLE = "x86-64-v3"
_CONFIG = vars(config)  # numba's settings, which it makes by their names
_NEEDED = {
    "cx16", "popcnt", "sahf", "sse3", "ssse3", "sse4.1", "sse4.2", "avx", "avx2", "bmi", "bmi2", "f16c",
    "fma", "lzcnt", "movbe", "xsave",
}  # fmt: skip


class PortableCodegen(JITCPUCodegen):
    """numba's code generator, for the portable processor."""

    def _get_host_cpu_name(self) -> str:
        return PORTABLE

    def _get_host_cpu_features(self) -> str:
        return ""  # those of the name


def _settle() -> None:
    """Have numba compile for the portable processor, where that is possible."""
    if _CONFIG["CPU_NAME"] or _CONFIG["CPU_FEATURES"] or not is_portable():
        return
    if "_toplevel_target_context" in vars(cpu_target):  # numba has compiled
        return
    cpu_target.target_context._internal_codegen = PortableCodegen("noctule.exec")  # noqa: SLF001 - no other way


def is_portable() -> bool:
    """Whether this processor runs code for the portable one."""
    try:
        features = llvm.get_host_cpu_features()
    except RuntimeError:  # LLVM knows no way to ask
        return False
    return "x86_64" in llvm.get_process_triple() and all(features.get(name) for name in _NEEDED)


_settle()  # on import, which one thread does
