"""Code that Python calls: what is kept of it is its machine code, with what that needs of others.

numba keeps LLVM's code beside it, which nobody takes in: kernels that call the same function have one of
their own (`circuits.machine_code.linked`). And before it loads anything it learns all that it can compile,
which takes longer than many a run. Here it does so only for machine code that needs something that is not
there otherwise, since LLVM ends the process that looks for that in vain.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import llvmlite.binding as llvm  # type: ignore[import-untyped]
from numba.core.runtime.nrt import rtsys

from circuits.machine_code.linked import result_of


def reduced(result: Any) -> Any:
    """What is kept of a compiled function, for `rebuilt`."""
    (name, _, (code, _)), *rest = result._reduce()  # noqa: SLF001 - no other way
    module = result.library._final_module  # noqa: SLF001 - no other way
    others = {each.name for each in (*module.functions, *module.global_variables) if each.is_declaration}
    return (name, code, {each for each in others if not each.startswith("llvm.")}), *rest


def rebuilt(target_context: Any, payload: Any) -> Any:
    """What numba keeps of a compiled function; raises `LookupError` where what its code needs is nowhere."""
    (name, code, needed), fndesc, *_ = payload
    for make in (partial(rtsys.initialize, target_context), target_context.refresh, partial(_refuse, name)):
        if not all(map(llvm.address_of_symbol, needed)):
            make()
    library = target_context.codegen().create_library(name)
    library.enable_object_caching()
    library._set_compiled_object(code)  # noqa: SLF001 - no other way
    library._finalize_final_module()  # noqa: SLF001 - no other way
    entries = {fndesc.llvm_func_name, fndesc.llvm_cpython_wrapper_name}
    library.codegen._engine._defined_symbols.update(entries)  # noqa: SLF001 - no other way
    return result_of(target_context, library, *payload[1:])


def _refuse(name: str) -> None:
    raise LookupError(f"{name}: it needs what is not here")
