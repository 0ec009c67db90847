"""Shells complete commands, options and names: what each is answered, its script, and how fast."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from chips.registry import CHIPS
from circuits.registry import BLOCKS, METRICS
from netlists.registry import DIALECTS
from system.bug.map import MAPS
from system.cli.command_line import main
from system.cli.completion import VARIABLE, Shell, script_of
from system.registry import EXPERIMENTS, SYSTEMS
from tests.refusals import command_refusals
from tests.system.cli.test_command_line import HEAVY, ROOT, process
from tests.system.conftest import Run

Ask = Callable[[str], list[str]]
COMMAND = "import sys; from system.cli.command_line import main; status = main();"


@pytest.fixture
def bash(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Ask:
    """What bash is answered for a line, whose cursor is at its end."""

    def ask(line: str) -> list[str]:
        words = {"COMP_WORDS": line, "COMP_CWORD": str(line.count(" ")), VARIABLE: "complete_bash"}
        for name, value in words.items():
            monkeypatch.setenv(name, value)
        with suppress(SystemExit):
            main(())
        return capsys.readouterr().out.splitlines()

    return ask


def _told(environment: dict[str, str], code: str = COMMAND) -> tuple[list[str], str]:
    done = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, **environment}, cwd=ROOT,
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.stdout.splitlines(), done.stderr


NAMES = {
    "noctule show ": {*BLOCKS, *CHIPS},
    "noctule show re": {"rebound-neuron"},
    "noctule simulate axon": {"axon-delay", "axon-hillock"},
    "noctule montecarlo ro": {"rover", "rolls", "rolls-neuron"},
    "noctule montecarlo rebound-neuron --metric ": {*METRICS},
    "noctule export rebound-neuron --dialect ": {*DIALECTS, "xschem"},
    "noctule import a.cir --dialect x": {"xyce"},
    "noctule reproduce ": {*EXPERIMENTS},
    "noctule run ": {*SYSTEMS, "bench"},
    "noctule run s": {"spiking-bat"},
    "noctule characterise w": {"wavefront-cell", "winner-take-all"},
    "noctule simulate rebound-neuron --engine ": {"native", "ngspice"},
    "noctule simulate rebound-neuron --engine native --engine n": {"native", "ngspice"},
    "noctule mo": {"montecarlo"},
    "noctule show rebound-neuron --bias-f": {"--bias-file"},
    "noctule run forest --ranges ": {"exact", "sonar", "chip"},
    "noctule run bug --map bug-": {*MAPS},
    "noctule run pushbot --scene s": {"single-block"},
    "noctule run forst --ranges ": set(),
    "noctule --v": {"--version"},
}


@pytest.mark.parametrize(("line", "words"), NAMES.items())
def test_what_bash_is_answered(line: str, words: set[str], bash: Ask) -> None:
    found = bash(line)
    assert len(found) == len(set(found))
    assert set(found) == words


@pytest.mark.parametrize("line", ["", "show re", "montecarlo x --metric ", "export a --dialect ", "run s"])
def test_names_are_completed_without_anything_heavy(line: str) -> None:
    code = (
        "import atexit, sys; from system.cli.command_line import main;"
        f"atexit.register(lambda: print([m for m in {HEAVY} if m in sys.modules], file=sys.stderr)); main()"
    )
    words = f"noctule {line}"
    cursor = str(len(words.split(" ")) - 1)
    out, err = _told({"COMP_WORDS": words, "COMP_CWORD": cursor, VARIABLE: "complete_bash"}, code)
    assert out
    assert err == "[]\n"


def test_what_zsh_and_fish_are_answered() -> None:
    asked = {"_TYPER_COMPLETE_ARGS": "noctule show rebound", "_TYPER_COMPLETE_FISH_ACTION": "get-args"}
    out, err = _told({**asked, VARIABLE: "complete_zsh"})
    assert ("\n".join(out), err) == ("_arguments '*: :((\"rebound-neuron\"))'", "")
    assert _told({**asked, VARIABLE: "complete_fish"}) == (["rebound-neuron"], "")


@pytest.mark.parametrize("shell", Shell)
def test_the_script_is_shown_and_installed(
    shell: Shell, run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    shown = run("--show-completion", shell.value)
    assert shown == (0, f"{script_of(shell)}\n", "")
    assert f"{VARIABLE}=complete_{shell.value}" in shown[1]
    status, out, err = run("--install-completion", shell.value)
    assert (status, err) == (0, "")
    path = Path(out.partition(": ")[0])
    assert path.is_relative_to(tmp_path)
    assert path.read_text().strip() == script_of(shell)


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash here")
def test_bash_completes_by_the_script(tmp_path: Path) -> None:
    command = tmp_path / "noctule"
    command.write_text(
        f'#!/bin/sh\nPYTHONPATH="{ROOT}" exec "{sys.executable}" -m system.cli.command_line "$@"\n'
    )
    command.chmod(0o755)
    script = tmp_path / "script"
    script.write_text(
        f"{script_of(Shell.BASH)}\nCOMP_WORDS=(noctule show reb)\nCOMP_CWORD=2\n"
        f'_noctule_completion {command}\necho "${{COMPREPLY[@]}}"\n'
    )
    done = subprocess.run(["bash", str(script)], capture_output=True, text=True, check=True)
    assert done.stdout == "rebound-neuron\n"


REFUSED = [
    ("--show-completion tcsh", "'tcsh' is not one of 'bash', 'zsh', 'fish'"),
    ("--install-completion", "requires an argument"),
]


test_another_shell_is_refused = command_refusals(rows=REFUSED)


def test_a_home_that_cannot_be_written_is_one_line() -> None:
    child = process("--install-completion", "bash", env={**os.environ, "HOME": "/proc/nowhere"})
    out, err = child.communicate()
    assert (child.returncode, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("noctule: /proc/nowhere")
