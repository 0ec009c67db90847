"""Options of silicon in the place of a command's parameter, and declarations that run a system."""

from typing import Annotated, Any

import pytest
import typer
from typer.testing import CliRunner

from system.cli import silicon_options
from system.cli.command_options import Json, Kind, Plot, Seed
from system.cli.silicon_options import OPTIONS, runs, with_silicon
from system.options.silicon import SiliconChoice


def invoke(command: Any, *arguments: str) -> int:
    app = typer.Typer()
    app.command()(command)
    return CliRunner().invoke(app, arguments).exit_code


def test_the_options_make_the_choice_and_those_left_out_are_refused() -> None:
    got: list[tuple[str, SiliconChoice]] = []

    @with_silicon("at")
    def command(block: str, *, silicon: SiliconChoice) -> None:
        got.append((block, silicon))

    assert invoke(command, "x", "--die", "3", "--no-process", "--corner", "ss", "--temperature", "60") == 0
    assert got == [("x", SiliconChoice("60", die=3, corner="ss", process=False))]
    assert invoke(command, "x", "--at", "ranging-chip/neuron[2]") == 2


def test_every_field_of_the_choice_has_an_option_with_its_default() -> None:
    got: list[SiliconChoice] = []

    @with_silicon()
    def command(*, silicon: SiliconChoice) -> None:
        got.append(silicon)

    assert invoke(command) == 0
    assert got == [SiliconChoice()]
    assert set(OPTIONS) == set(SiliconChoice.__dataclass_fields__)


def test_a_declaration_hands_on_what_was_given_under_the_names_it_is_called(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    got: dict[str, Any] = {}

    @runs("car", pipes="forest")
    def car(
        *,
        pipes: Annotated[str | None, typer.Option("--forest")] = None,
        unit: Annotated[list[str] | None, typer.Option()] = None,
        gain: float | None = None,
        bias_kind: Kind = None,
        silicon: SiliconChoice,
        seed: Seed = 0,
        plot: Plot = None,
        as_json: Json = False,
    ) -> None:
        """Drive."""

    monkeypatch.setattr(silicon_options, "call", lambda *a, **k: got.update(k, path=a[0], rest=a[1:]))
    assert invoke(car, "--forest", "dense", "--bias-kind", "gate", "--seed", "7") == 0
    assert got == {
        "path": "run_car:run_car", "rest": ("car", SiliconChoice(), 7, None), "as_json": False,
        "forest": "dense", "bias_kind": "gate",
    }  # fmt: skip
