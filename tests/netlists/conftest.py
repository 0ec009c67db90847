"""What the tests of netlists share."""

from __future__ import annotations

import os

import pytest

from netlists.ngspice.library import find_library


@pytest.fixture
def ngspice_library() -> None:
    """Skip without the library on a desk; fail in CI, where the set-up must have installed it."""
    if find_library() is None:
        reason = "no ngspice library; install Debian's libngspice0 or set NGSPICE_LIBRARY_PATH"
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
