"""Tests read the package's records, not those that a user may have measured."""

from __future__ import annotations

import os
import tempfile

from chips.record_file import ENVIRONMENT

os.environ[ENVIRONMENT] = tempfile.gettempdir() + "/no-records-of-tests"
