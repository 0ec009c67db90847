"""A verb's options come from the fields of its dataclass, and reach its function as a value of it."""

from dataclasses import dataclass, fields
from types import SimpleNamespace
from typing import Any, Literal

import pytest
import typer
from typer.testing import CliRunner

from system.cli import verb
from system.cli.shared_options import silicon_part
from system.cli.verb import argument, like, part, required
from system.option import option
from system.options.silicon import SiliconChoice


@dataclass(frozen=True, slots=True, kw_only=True)
class Inner:
    count: int = option(2, "How many", short="n")
    hidden: str = option("x", "Left out where it is a part")


@dataclass(frozen=True, slots=True, kw_only=True)
class Other:
    tens: int = option(2, "How many tens")


@dataclass(frozen=True, slots=True, kw_only=True)
class Build:
    """Build a thing."""

    thing: str = argument("THING", "What is built")
    size: str = required("How large", metavar="SIZE")
    words: tuple[str, ...] = option((), "Said, repeatable", metavar="WORD")
    grain: Literal["fine", "coarse"] | None = option(None, "Of its surface")
    dry: bool = option(default=False, about="Do nothing")
    paint: bool = option(default=True, about="Paint it")
    mat: bool | None = option(None, "Or glossy", opposite="glossy")
    low: str | None = option(None, "With `paint` alone", name="from")
    inner: Inner = part(Inner, "hidden")
    total: int = part(Other, made=lambda other: 10 * other.tens)
    shade: str = like(Inner, "hidden")


def run(options: type, *arguments: str, status: int | None = None) -> tuple[Any, int, str]:
    """What the verb's function got, the exit status and the output."""
    got: list[Any] = []

    def function(asked: Any) -> int | None:
        got.append(asked)
        return status

    app = typer.Typer(rich_markup_mode=None)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(verb, "loaded", lambda place: {"system.cli.build:build": function}[place])
        app.command()(verb.verb("build:build", options))
        done = CliRunner().invoke(app, arguments, terminal_width=200)
    return got[0] if got else None, done.exit_code, done.output


def test_every_option_reaches_its_field() -> None:
    words = "--size 3m --words a --words b --grain fine --dry --no-paint --glossy --from 1Hz".split()  # noqa: SIM905
    asked, status, _ = run(Build, "house", *words, "-n", "4", "--tens", "5", "--shade", "red")
    assert status == 0
    assert asked == Build(
        thing="house", size="3m", words=("a", "b"), grain="fine", dry=True, paint=False, mat=False,
        low="1Hz", inner=Inner(count=4), total=50, shade="red",
    )  # fmt: skip
    assert type(asked.grain) is str


def test_what_is_not_given_is_the_default() -> None:
    asked, _, _ = run(Build, "house", "--size", "3m")
    assert asked == Build(thing="house", size="3m")
    assert asked.total == 20


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--size", "3m"), "THING"),
        (("house",), "--size"),
        (("house", "--size", "3m", "--grain", "rough"), "'rough' is not one of 'fine', 'coarse'"),
        (("house", "--size", "3m", "--inner", "y"), "--inner"),
    ],
)
def test_what_is_missing_or_unknown_is_refused(arguments: tuple[str, ...], words: str) -> None:
    asked, status, output = run(Build, *arguments)
    assert (asked, status) == (None, 2)
    assert words in output


def test_the_help_is_that_of_the_fields_in_their_order() -> None:
    said = run(Build, "--help")[2]
    wanted = [
        "{THING}", "Build a thing.", "--size SIZE", "--words WORD", "--grain <fine|coarse>", "--dry ",
        "--paint / --no-paint", "--mat / --glossy", "With --paint alone.", "-n, --count",
    ]  # fmt: skip
    places = [said.index(text) for text in wanted]
    assert places == sorted(places)


@pytest.mark.parametrize("status", [None, 0, 1])
def test_the_command_ends_with_the_status_of_the_function(status: int | None) -> None:
    assert run(Build, "house", "--size", "3m", status=status)[1] == (status or 0)


@dataclass(frozen=True, slots=True, kw_only=True)
class OnSilicon:
    """Run on silicon."""

    silicon: SiliconChoice = silicon_part("at")


def test_silicon_is_asked_for_by_its_fields() -> None:
    words = ["--die", "3", "--no-process-variation", "--corner", "ss", "--temperature", "60"]
    assert run(OnSilicon, *words)[0].silicon == SiliconChoice(
        "60", die=3, corner="ss", process_variation=False
    )
    assert run(OnSilicon)[0].silicon == SiliconChoice()
    assert run(OnSilicon, "--at", "ranging-chip/neuron[2]")[1] == 2


def test_every_option_has_a_line_of_help() -> None:
    bare = SimpleNamespace(help="")
    assert [f.name for f in fields(SiliconChoice) if not f.metadata.get("option", bare).help] == []
