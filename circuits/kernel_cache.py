"""numba's cache of compiled kernels, which nothing that stands in its folder can break.

What cannot be read, or is not what was written, is compiled again; where nothing can be written nothing is
kept. Machine code is taken only with its digest, since a flipped bit of it would be run.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, final

from numba.core.caching import FunctionCache, IndexDataCacheFile, NullCache

from circuits.seal import sealed, unsealed


def kernel_cache(function: Callable[..., Any], stamp: bytes) -> Any:
    """Cache of a function whose code, with all that it calls, has the stamp; none where it cannot be kept."""
    try:
        cache = _KernelCache(function)  # type: ignore[no-untyped-call]
    except RuntimeError:  # no folder may be written
        return NullCache()
    cache.begin(stamp)
    return cache


@final
class _File(IndexDataCacheFile):
    """Data with their digest."""

    def _save_data(self, name: str, data: Any) -> None:
        text = self._dump(data)  # type: ignore[no-untyped-call]
        with self._open_for_write(self._data_path(name)) as file:  # type: ignore[no-untyped-call]
            file.write(sealed(text))

    def _load_data(self, name: str) -> Any:
        found = Path(self._data_path(name)).read_bytes()  # type: ignore[no-untyped-call]
        return pickle.loads(unsealed(found))  # noqa: S301 - numba's own form, in the user's own cache

    def discard(self) -> None:
        """Forget what is there."""
        with suppress(OSError):
            Path(self._index_path).unlink(missing_ok=True)


@final
class _KernelCache(FunctionCache):
    """A cache that compiles again where it fails."""

    def begin(self, stamp: bytes) -> None:
        """Take the stamp for the cached function's own file."""
        make: Any = _File
        self._cache_file: Any = make(self._cache_path, self._impl.filename_base, stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Machine code of a signature, None where there is none to be believed."""
        try:
            return super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except Exception:  # noqa: BLE001 - contents that are none raise anything
            self._cache_file.discard()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep machine code, where that is possible."""
        with suppress(Exception):  # a full or read-only disk, or an index that cannot be replaced
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]
