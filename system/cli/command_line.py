"""The command `noctule`: its arguments, and one line on stderr for whatever goes wrong.

What a command does is in `system/cli/`, loaded when it is called, so that `noctule --help` does not wait
for numerical libraries. Exit status (`system.cli.exit_status`): 0 done; 1 done, and the answer is no: an
experiment disagrees, netlists differ, no die of a study could be measured or passes, a sample is not the one
that was kept, a piece is missing; also where the output's reader went away; 2 bad input, or a file, simulator
or solver that fails; 130 interrupted.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Sequence
from functools import cache
from typing import Annotated, Any

import typer

from circuits.catalogue import loaded
from circuits.errors import CircuitError, meant
from system.cli import run_command_line
from system.cli.certify_verb import Certify
from system.cli.completion import VARIABLE, Shell, answer, install, script_of
from system.cli.examples import epilog_of
from system.cli.exit_status import BAD_INPUT, DONE, INTERRUPTED, NO
from system.cli.given_once import App
from system.cli.guide import guide
from system.cli.labs_verb import Labs
from system.cli.map_verb import Map
from system.cli.match_verb import Corners, Match, Size, Worst
from system.cli.mend import measured_again
from system.cli.mission_verb import Merge, Mission
from system.cli.run_command_line import names_in_study
from system.cli.serve_verb import Serve
from system.cli.simulate_verb import Simulate
from system.cli.study_verbs import Centre, Gradient, Montecarlo, Replay
from system.cli.sweep_verb import Sweep
from system.cli.train_verb import Train
from system.cli.verb import verb
from system.cli.verbs import (
    Calibrate,
    Characterise,
    Compare,
    Doctor,
    Export,
    Extract,
    Identify,
    Import,
    List,
    New,
    Op,
    Predict,
    Reproduce,
    Show,
    View,
)
from system.notice import say, warnings_in_a_line

# What typer raises for a wrong option: click's ClickException, which some releases of typer carry inside.
_UsageError: Any = typer.BadParameter.__mro__[1]

# What typer says of a name that it does not know, before the names that are near, or may stand there.
_SUGGESTED = re.compile(
    r"(?P<said>No such \w+:? '?(?P<name>[^' ]+)'?)(?: \(Possible options: |\.? Did you mean )(?P<known>.*)"
)
_ONE_OF = re.compile(r"(?P<said>.*'(?P<name>[^']*)' is not one of (?P<known>.*))")
_WORD = re.compile(r"[\w-]+")

app = App(
    name="noctule",
    help="Model mixed-signal neuromorphic hardware at circuit level: from transistors to robots.",
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


@app.callback(invoke_without_command=True)
def noctule(
    context: typer.Context,
    *,
    show_version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
    install_completion: Annotated[
        Shell | None, typer.Option(help="Let a shell complete noctule's commands, options and names.")
    ] = None,
    show_completion: Annotated[Shell | None, typer.Option(help="Print the script that does so.")] = None,
) -> None:
    """Model mixed-signal neuromorphic hardware at circuit level: from transistors to robots."""
    if show_version:
        typer.echo(f"noctule {_version()}")
    elif install_completion is not None:
        typer.echo(install(install_completion))
    elif show_completion is not None:
        typer.echo(script_of(show_completion))
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help())


_VERBS = {
    "list": verb("listing:list_command", List),
    "show": verb("show:show_command", Show),
    "op": verb("op:op_command", Op),
    "simulate": verb("simulate:simulate_command", Simulate),
    "export": verb("export:export_command", Export),
    "import": verb("import_netlist:import_command", Import),
    "compare": verb("compare:compare_command", Compare),
    "view": verb("view:view_command", View),
    "map": verb("map:map_command", Map),
    "sweep": verb("sweep:sweep_command", Sweep),
    "montecarlo": verb("montecarlo:montecarlo_command", Montecarlo),
    "gradient": verb("gradient:gradient_command", Gradient),
    "match": verb("match:match_command", Match),
    "worst": verb("worst:worst_command", Worst),
    "corners": verb("corners:corners_command", Corners),
    "certify": verb("certify:certify_command", Certify),
    "train": verb("train:train_command", Train),
    "mission": verb("mission:mission_command", Mission),
    "merge": verb("mission:merge_command", Merge),
    "replay": verb("replay:replay_command", Replay),
    "centre": verb("centre:centre_command", Centre),
    "size": verb("size:size_command", Size),
    "characterise": verb("characterise:characterise_command", Characterise),
    "extract": verb("extract:extract_command", Extract),
    "identify": verb("identify:identify_command", Identify),
    "predict": verb("predict:predict_command", Predict),
    "calibrate": verb("calibrate:calibrate_command", Calibrate),
    "reproduce": verb("reproduce:reproduce_command", Reproduce),
    "serve": verb("serve:serve_command", Serve),
    "labs": verb("labs:labs_command", Labs),
    "new": verb("new:new_command", New),
    "doctor": verb("doctor:doctor_command", Doctor),
}
_VERBS["montecarlo"].said = names_in_study  # type: ignore[attr-defined]
for _name, _verb in _VERBS.items():
    app.command(_name, epilog=epilog_of(_name))(_verb)
run_command_line.add_to(app)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line on `arguments`, those of the process unless given; returns the exit status."""
    try:
        with warnings_in_a_line():
            if os.environ.get(VARIABLE):
                answer(app)
            status = _run(sys.argv[1:] if arguments is None else list(arguments))
        sys.stdout.flush()
    except CircuitError as error:
        return _refuse(measured_again(str(error)))
    except ImportError as error:
        return _refuse(f"{error}; see noctule doctor")
    except KeyboardInterrupt:
        return _refuse("interrupted", INTERRUPTED)
    except BrokenPipeError:
        _drop_output()
        return NO
    except OSError as error:
        _drop_output()
        return _refuse(f"{error.filename or 'output'}: {error.strerror or error}")
    return status


def _run(arguments: list[str]) -> int:
    """Parse and run. typer's own `main` would print usage errors in several lines."""
    if not arguments:
        typer.echo(guide())
        return DONE
    try:
        command = _commands()
        with command.make_context("noctule", arguments) as context:
            command.invoke(context)
    except typer.Exit as done:
        return done.exit_code
    except _UsageError as error:
        return _refuse(_told(error))
    return DONE


@cache
def _commands() -> Any:
    """All commands, made once a process; those of systems are found when they are called."""
    return typer.main.get_command(app)


def _told(error: Any) -> str:
    """A wrong option, command or word as typer says it, with the nearest of the names that it lists."""
    text = str(error.format_message()).replace("Value error, ", "").rstrip(".")
    listed = _SUGGESTED.match(text) or _ONE_OF.match(text)
    if listed is None:
        return text
    return f"{listed['said']}{meant(listed['name'], _WORD.findall(listed['known']))}"


def _version() -> str:
    try:  # what knows of versions is slow to import
        return str(loaded("importlib.metadata:version")("noctule"))
    except ImportError:
        return "(not installed)"


def _refuse(text: str, status: int = BAD_INPUT) -> int:
    """Say what is wrong in one line."""
    say(text)
    return status


def _drop_output() -> None:
    """Let stdout lead nowhere, so that the interpreter's last flush does not fail a second time."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
