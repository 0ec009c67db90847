"""Nengo's own tests on the ideal die: what fails is refused in a line, or stands here with its reason."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import nengo
import pytest

ROOT = Path(__file__).parents[4]
FILES = (
    "connection", "ensemble", "learning_rules", "neurons", "node", "probe", "processes", "simulator",
    "synapses",
)  # fmt: skip
REFUSED = {
    "neurons": r"neuron_type: .*must be LIF",
    "step": r"dt: .* s, must be 0\.001 s",
    "internals": r"must be an output, or spikes of neurons",
    "learning": r"learning_rule: .*the chip does not learn",
    "weights": r"must not solve for weights",
    "noise": r"the chip has no injected noise",
    "transforms": r"transform: .*must be numbers|must be dense",
    "encoders": r"normalize_encoders: False",
    "thresholds": r"intercepts: .* by gain and bias, must be below 1",
    "built": r"a chip takes no model of nengo's|a chip has no signals and operators",
}
OTHERWISE = {
    "test_entry_point": "no back-end is found by an entry point",
    "test_warn_on_opensim_del": "an open simulator holds nothing that must be freed",
    "test_triangle": "fails on nengo's own simulator with numpy 2 too",
}
WORDS = "Regex pattern did not match"  # of pytest: the error that was expected, in words of ours


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[str, str, list[str], str]]:
    """Name, outcome, classes of the error and its text, of each of nengo's tests."""
    folder = tmp_path_factory.mktemp("own")
    tests = Path(nengo.__file__).parent / "tests"
    command = [
        sys.executable, "-m", "pytest", "-c", os.devnull, "--rootdir", str(folder), "-q", "--tb=no",
        "-p", "no:nengo", "-p", "no:cacheprovider", "-p", "tests.chips.nef.nengo.own", "-W", "ignore",
        # no words of a failed assertion are read here, and no test of nengo's draws examples
        "--assert=plain", "-p", "no:hypothesispytest", "-p", "no:xdist",
        *(str(tests / f"test_{name}.py") for name in FILES),
    ]  # fmt: skip
    found = folder / "rows.json"
    given = {name: value for name, value in os.environ.items() if name != "PYTEST_ADDOPTS"}  # of our own run
    environment = {**given, "PYTHONPATH": str(ROOT), "NENGO_OWN": str(found)}
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert found.exists(), done.stdout + done.stderr
    return [tuple(row) for row in json.loads(found.read_text())]


def test_what_fails_of_nengos_own_tests_is_refused_in_a_line(
    rows: list[tuple[str, str, list[str], str]],
) -> None:
    left = [
        (name, text)
        for name, outcome, kinds, text in rows
        if outcome == "failed"
        and not ({"CircuitError", "AttributeError"} & set(kinds) and _why(text))
        and not text.startswith(WORDS)
        and name not in OTHERWISE
    ]
    assert not left


def test_what_the_ideal_die_can_do_passes_nengos_own_tests(
    rows: list[tuple[str, str, list[str], str]],
) -> None:
    passed = {name for name, outcome, _, _ in rows if outcome == "passed"}
    assert len(passed) > 100
    refused = {_why(text) for _, outcome, _, text in rows if outcome == "failed"}
    assert refused >= REFUSED.keys()  # or a row of the table is of nothing


def _why(text: str) -> str | None:
    """Name of the refusal."""
    return next((name for name, says in REFUSED.items() if re.search(says, text)), None)
