"""Code that only other kernels call: it is put into theirs, and needs no machine code of its own."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, final

import llvmlite.binding as llvm  # type: ignore[import-untyped]
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, compile_result


@final
class LinkedLibrary(JITCodeLibrary):
    """LLVM's code of a kernel that other kernels take in, which optimise it where it is."""

    def _optimize_final_module(self) -> None:
        """Leave it as it is: who takes it in optimises all."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Nothing, since it cannot be called."""
        self._ensure_finalized()
        return 0

    def take(self, bitcode: bytes) -> None:
        """Be what was kept."""
        self._shared_module = llvm.parse_bitcode(bitcode)
        self._finalized = True

    @property
    def codegen(self) -> Any:
        """What has no room for the environment of code that cannot be called."""
        return SimpleNamespace(set_env=_ignored)

    def serialize_using_object_code(self) -> Any:
        """Its name and bit code."""
        return self.name, self._get_module_for_linking().as_bitcode()


@final
class LinkedCompiler(Compiler):
    """numba's compiler, into a `LinkedLibrary`."""

    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *rest: Any) -> None:
        super().__init__(typingctx, targetctx, library or _empty(targetctx, "linked"), *rest)


def rebuilt(target_context: Any, payload: Any) -> Any:
    """What numba keeps of a compiled function, from what was kept of it on disk."""
    (name, bitcode), *rest = payload
    library = _empty(target_context, name)
    library.take(bitcode)
    return result_of(target_context, library, *rest)


def result_of(target_context: Any, library: Any, fndesc: Any, environment: Any, *rest: Any) -> Any:
    """What numba keeps of a compiled function, from its library and what else numba keeps on disk."""
    signature, objectmode, lifted, typeann, reload_init, envs = rest
    for function in reload_init:
        function()
    result = compile_result(
        target_context=target_context, typing_context=target_context.typing_context, library=library,
        environment=environment, entry_point=target_context.get_executable(library, fndesc, environment),
        fndesc=fndesc, type_annotation=typeann, signature=signature, objectmode=objectmode, lifted=lifted,
        reload_init=reload_init, referenced_envs=envs,
    )  # fmt: skip
    for each in envs:
        library.codegen.set_env(each.env_name, each)
    return result


def _ignored(name: str, environment: object) -> None:
    """Set nothing."""


def _empty(target_context: Any, name: str) -> Any:
    library = LinkedLibrary(target_context.codegen(), name)
    library.enable_object_caching()
    return library
