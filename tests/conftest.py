"""What tests share: the package's records and not a user's, examples without a clock, ngspice where it is."""

from __future__ import annotations

import gc
import os
from functools import lru_cache

import pytest
from hypothesis import settings

from chips.record_file import ENVIRONMENT
from chips.rolls import tables
from netlists.ngspice import run as ngspice
from netlists.ngspice.library import find_library
from tests.agreement.kept import KeptRuns

os.environ[ENVIRONMENT] = os.devnull + "/no-records-of-tests"  # where nothing can be kept either
settings.register_profile("untimed", deadline=None)  # first calls compile, and speed is the benchmarks' claim
settings.load_profile("untimed")


RARELY = 50_000, 20, 20  # new objects, and collections of the younger ones, between two of each kind; ours
gc.disable()  # until tests are collected: of eight thousand of them nothing is garbage


def pytest_collection_finish() -> None:
    """Collect garbage from now on, but not in what stays to the end, and less often than a small program."""
    gc.freeze()
    gc.set_threshold(*RARELY)
    gc.enable()


# Tests of a chip alternate between some of its dies and programs: the tables of the last four are kept.
tables._built = lru_cache(maxsize=4)(tables._built.__wrapped__)


def pytest_addoption(parser: pytest.Parser) -> None:
    """How much of the documents is run."""
    parser.addoption(
        "--documents",
        choices=("sample", "all"),
        default="sample",
        help="what is run of the pages, and of the forms of --json: a sample, or all",
    )


@pytest.fixture(scope="session")
def ngspice_library() -> None:
    """Skip without the library on a desk; fail in CI, where the set-up must have installed it."""
    if find_library() is None:
        reason = "no ngspice library; install Debian's libngspice0 or set NGSPICE_LIBRARY_PATH"
        if os.environ.get("CI") == "true":
            pytest.fail(reason)
        pytest.skip(reason)


@pytest.fixture(scope="session")
def ngspice_runs(ngspice_library: None, pytestconfig: pytest.Config) -> KeptRuns | None:
    """Runs of ngspice that pytest's cache has, where there is one."""
    if not pytestconfig.pluginmanager.hasplugin("cacheprovider"):
        return None
    found = KeptRuns(pytestconfig.cache.mkdir("ngspice"), ngspice.run)
    found.drop_unused()
    return found


@pytest.fixture
def kept_ngspice(ngspice_runs: KeptRuns | None, monkeypatch: pytest.MonkeyPatch) -> None:
    """A deck that ngspice has run before is not run again (`tests.agreement.kept`)."""
    if ngspice_runs is not None:
        monkeypatch.setattr(ngspice, "run", ngspice_runs)
