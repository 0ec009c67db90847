"""Packages that have kernels, ours and those of users: what others compile with numba is left alone."""

from __future__ import annotations

_PACKAGES: set[str] = set()


def package_of(module: str) -> str:
    """Name of the package that a module is of."""
    return module.partition(".")[0]


def note_kernel(module: str) -> None:
    """Note that a module has a kernel."""
    _PACKAGES.add(package_of(module))


def of_package_with_kernels(kind: type) -> bool:
    """Whether a class is of a package that has kernels."""
    return package_of(kind.__module__) in _PACKAGES
