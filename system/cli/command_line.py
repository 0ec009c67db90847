"""The command `noctule`: its arguments, and one line on stderr for whatever goes wrong.

What a command does is in `system/cli/`, loaded when it is called, so that `noctule --help` does not wait
for numerical libraries; where a verb is named, the options of others are not made either. Exit status
(`system.cli.exit_status`): 0 done; 1 done, and the answer is no: an experiment disagrees, netlists differ, no
die of a study could be measured or passes, a sample is not the one that was kept, a piece is missing; also
where the output's reader went away; 2 bad input, or a file, simulator or solver that fails; 130 interrupted.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Annotated, Any

import typer

from circuits.catalogue import loaded
from circuits.errors import CircuitError, meant
from system.cli.completion import VARIABLE, Shell, answer, install, script_of
from system.cli.examples import epilog_of
from system.cli.exit_status import BAD_INPUT, DONE, INTERRUPTED, NO
from system.cli.given_once import App, Commands
from system.cli.guide import guide
from system.cli.mend import measured_again
from system.cli.verb import verb
from system.notice import say, warnings_in_a_line

# What typer raises for a wrong option: click's ClickException, which some releases of typer carry inside.
_UsageError: Any = typer.BadParameter.__mro__[1]

# What typer says of a name that it does not know, before the names that are near, or may stand there.
_SUGGESTED = re.compile(
    r"(?P<said>No such \w+:? '?(?P<name>[^' ]+)'?)(?: \(Possible options: |\.? Did you mean )(?P<known>.*)"
)
_ONE_OF = re.compile(r"(?P<said>.*'(?P<name>[^']*)' is not one of (?P<known>.*))")
_WORD = re.compile(r"[\w-]+")

_ABOUT = "Model mixed-signal neuromorphic hardware at circuit level: from transistors to robots."

_VERBS: dict[str, Callable[[], Any]] = {
    "list": lambda: verb("listing:list_command", loaded("system.cli.verbs:List")),
    "show": lambda: verb("show:show_command", loaded("system.cli.verbs:Show")),
    "op": lambda: verb("op:op_command", loaded("system.cli.verbs:Op")),
    "simulate": lambda: verb("simulate:simulate_command", loaded("system.cli.simulate_verb:Simulate")),
    "export": lambda: verb("export:export_command", loaded("system.cli.verbs:Export")),
    "import": lambda: verb("import_netlist:import_command", loaded("system.cli.verbs:Import")),
    "compare": lambda: verb("compare:compare_command", loaded("system.cli.verbs:Compare")),
    "view": lambda: verb("view:view_command", loaded("system.cli.verbs:View")),
    "map": lambda: verb("map:map_command", loaded("system.cli.map_verb:Map")),
    "sweep": lambda: verb("sweep:sweep_command", loaded("system.cli.sweep_verb:Sweep")),
    "montecarlo": lambda: _of_study(
        verb("montecarlo:montecarlo_command", loaded("system.cli.study_verbs:Montecarlo"))
    ),
    "gradient": lambda: verb("gradient:gradient_command", loaded("system.cli.study_verbs:Gradient")),
    "match": lambda: verb("match:match_command", loaded("system.cli.match_verb:Match")),
    "worst": lambda: verb("worst:worst_command", loaded("system.cli.match_verb:Worst")),
    "corners": lambda: verb("corners:corners_command", loaded("system.cli.match_verb:Corners")),
    "certify": lambda: verb("certify:certify_command", loaded("system.cli.certify_verb:Certify")),
    "train": lambda: verb("train:train_command", loaded("system.cli.train_verb:Train")),
    "mission": lambda: verb("mission:mission_command", loaded("system.cli.mission_verb:Mission")),
    "merge": lambda: verb("mission:merge_command", loaded("system.cli.mission_verb:Merge")),
    "replay": lambda: verb("replay:replay_command", loaded("system.cli.study_verbs:Replay")),
    "centre": lambda: verb("centre:centre_command", loaded("system.cli.study_verbs:Centre")),
    "size": lambda: verb("size:size_command", loaded("system.cli.match_verb:Size")),
    "characterise": lambda: verb(
        "characterise:characterise_command", loaded("system.cli.verbs:Characterise")
    ),
    "extract": lambda: verb("extract:extract_command", loaded("system.cli.verbs:Extract")),
    "identify": lambda: verb("identify:identify_command", loaded("system.cli.verbs:Identify")),
    "predict": lambda: verb("predict:predict_command", loaded("system.cli.verbs:Predict")),
    "calibrate": lambda: verb("calibrate:calibrate_command", loaded("system.cli.verbs:Calibrate")),
    "reproduce": lambda: verb("reproduce:reproduce_command", loaded("system.cli.verbs:Reproduce")),
    "serve": lambda: verb("serve:serve_command", loaded("system.cli.serve_verb:Serve")),
    "labs": lambda: verb("labs:labs_command", loaded("system.cli.labs_verb:Labs")),
    "new": lambda: verb("new:new_command", loaded("system.cli.verbs:New")),
    "doctor": lambda: verb("doctor:doctor_command", loaded("system.cli.verbs:Doctor")),
}
_OF_SYSTEMS = ("run", "blame")  # verbs with a command for each system


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line on `arguments`, those of the process unless given; returns the exit status."""
    try:
        with warnings_in_a_line():
            if os.environ.get(VARIABLE):
                answer(app())
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
        command = _commands(arguments[0] if arguments[0] in {*_VERBS, *_OF_SYSTEMS} else None)
        with command.make_context("noctule", arguments) as context:
            command.invoke(context)
    except typer.Exit as done:
        return done.exit_code
    except _UsageError as error:
        return _refuse(_told(error))
    return DONE


def _of_study(command: Any) -> Any:
    """A verb whose errors name the fields of a study's system as its options say them."""
    command.said = _names_in_study
    return command


def _names_in_study(given: Mapping[str, Any]) -> dict[str, str]:
    found: dict[str, str] = loaded("system.cli.run_command_line:names_in_study")(given)
    return found


@cache
def app(alone: str | None = None) -> App:
    """Give all commands, or that of one verb alone; the options of others are not made then."""
    found = App(
        cls=Commands,
        name="noctule",
        help=_ABOUT,
        add_completion=False,
        pretty_exceptions_enable=False,
        rich_markup_mode=None,
    )
    found.callback(invoke_without_command=True, help=_ABOUT)(_noctule)
    for name in [name for name in _VERBS if alone in {name, None}]:
        found.command(name, epilog=epilog_of(name))(_VERBS[name]())
    if alone not in _VERBS:
        add_systems: Any = loaded("system.cli.run_command_line:add_to")
        add_systems(found)
    return found


@cache
def _commands(alone: str | None) -> Any:
    """What typer makes of them, once a process; those of systems are found when they are called."""
    return typer.main.get_command(app(alone))


def _noctule(
    context: typer.Context,
    *,
    show_version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False,
    install_completion: Annotated[
        Shell | None, typer.Option(help="Let a shell complete noctule's commands, options and names.")
    ] = None,
    show_completion: Annotated[Shell | None, typer.Option(help="Print the script that does so.")] = None,
) -> None:
    """Answer the options of `noctule` itself."""
    if show_version:
        typer.echo(f"noctule {_version()}")
    elif install_completion is not None:
        typer.echo(install(install_completion))
    elif show_completion is not None:
        typer.echo(script_of(show_completion))
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help())


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
