"""What tests share: they read the package's records, not a user's, and run ngspice where its library is."""

from __future__ import annotations

import os
import tempfile

import pytest

from chips.record_file import ENVIRONMENT
from netlists.ngspice.library import find_library

os.environ[ENVIRONMENT] = tempfile.gettempdir() + "/no-records-of-tests"


@pytest.fixture(scope="session")
def ngspice_library() -> None:
    """Skip without the library on a desk; fail in CI, where the set-up must have installed it."""
    if find_library() is None:
        reason = "no ngspice library; install Debian's libngspice0 or set NGSPICE_LIBRARY_PATH"
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)
