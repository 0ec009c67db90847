"""The page and the kept run that `noctule simulate` leaves of a transient."""

from __future__ import annotations

from dataclasses import replace

from circuits.errors import ParameterError
from circuits.solver.transient import Result
from circuits.units import unit_of_name
from system.cli.output import quantity_cell
from system.cli.simulate_verb import Simulate
from system.cli.view import check_page, check_run, leave, this_command
from system.options.block import Choice, silicon_line
from system.options.target import deck_of
from system.schematic.film import film_of
from system.system import without_unit


def check_view(asked: Simulate) -> None:
    """Refuse before the run what cannot be written, and an engine whose currents are not the law's."""
    if asked.view is not None:
        check_page(asked.view)
    if asked.output is not None:
        check_run(asked.output)
    other = asked.engine if asked.engine != "native" else asked.verilog_a
    if other is not None:
        raise ParameterError(
            f"--view: of the native engine, whose currents of devices it shows, not of {other}; leave one out"
        )


def leave_view(target: str, choice: Choice, result: Result, page: str | None, run: str | None) -> None:
    """Write the page and the kept run that are asked for; target: of which the user speaks."""
    sources = () if deck_of(target) is None else choice.testbench().sources
    film = film_of(result, choice.block.plotted, sources)
    measured = choice.block.measured(result)
    told = {
        without_unit(name): quantity_cell(value, unit_of_name(name))
        for name, value in measured.items()
        if value is not None
    }
    film = replace(
        film,
        title=f"{choice.block.name}, {silicon_line(choice.silicon)}",
        headline=f"outcome: {choice.block.outcome(result)}",
        command=this_command(),
        facts={**told, **film.facts},
    )
    leave(film, page, run)
