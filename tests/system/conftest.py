"""The command line as tests call it: what it ends with, the JSON that it prints, what it refuses."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from circuits.errors import ParameterError
from system.cli.command_line import main
from system.codes import find
from system.files import kept
from system.options.rolls import power as rolls_power

CALIBRATING = "noctule: calibrating "  # begins the line that tells of a chip whose codes are not known yet
Run = Callable[..., tuple[int, str, str]]
RunJson = Callable[..., Any]


@pytest.fixture(autouse=True, scope="session")
def codes_kept(pytestconfig: pytest.Config) -> Iterator[None]:
    """Codes of chips and answers are kept from one session to the next, by all that they follow from."""
    with pytest.MonkeyPatch.context() as patch:
        if pytestconfig.pluginmanager.hasplugin("cacheprovider"):
            codes, answers = (Path(pytestconfig.cache.mkdir(name)) for name in ("codes", "answers"))
            patch.setattr(find, "codes_folder", lambda: codes)
            patch.setattr(kept, "answers_folder", lambda: answers)
        yield


@pytest.fixture
def unmeasured_power(monkeypatch: pytest.MonkeyPatch) -> None:
    """The power of a ROLLS chip is not told, as where it cannot be measured, for what is not about it."""

    def refuse(*_: Any) -> None:
        raise ParameterError("power: not measured in this test")

    monkeypatch.setattr(rolls_power, "run_power", refuse)


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Exit status, stdout and stderr of a command, by its words."""

    def call(*arguments: str) -> tuple[int, str, str]:
        status = main(arguments)
        return status, *capsys.readouterr()

    return call


@pytest.fixture
def run_json(run: Run) -> RunJson:
    """The document of a command that does what it is asked for, and says no more than what it calibrates."""

    def call(*arguments: str) -> Any:
        status, out, err = run(*arguments, "--json")
        said = [line for line in err.splitlines() if not line.startswith(CALIBRATING)]
        assert (status, said) == (0, [])
        return json.loads(out, parse_constant=pytest.fail)

    return call


@pytest.fixture
def refused(run: Run) -> Callable[..., str]:
    """The one line on stderr of a command that is refused, without the name before it."""

    def call(*arguments: str) -> str:
        status, out, err = run(*arguments)
        err = "".join(line for line in err.splitlines(keepends=True) if not line.startswith(CALIBRATING))
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert err.startswith("noctule: ")
        return err.removeprefix("noctule: ")

    return call
