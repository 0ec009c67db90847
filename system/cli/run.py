"""The verb `noctule run SYSTEM`: runs a system's scenario once, and prints, draws and writes the result."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import is_dataclass, replace
from typing import TYPE_CHECKING, Any

from circuits.errors import ParameterError
from circuits.silicon.die import NOMINAL as NOMINAL_DIE
from circuits.silicon.process import check_temperature
from circuits.units import parse_quantity
from system.animation.movie import check_animation, read_frames
from system.cli.option_names import as_options
from system.cli.output import print_json, print_line, progress_bar
from system.cli.run_output import print_cautions, print_run
from system.cli.study_verbs import Blame
from system.cli.verbs import FRAMES, Run
from system.cli.view import animate, check_page, check_run, leave, this_command
from system.options.block import describe_die, read_die
from system.options.die.edited import check_drawn, check_known
from system.options.silicon import USUAL_CELSIUS, SiliconChoice
from system.options.temperature import COURSE, read_course, temperature_fields
from system.plot import check_picture, save_picture
from system.registry import load_system
from system.scenario import read_texts
from system.system import DRAWN, System

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def run_system(name: str, asked: Run, options: Mapping[str, Any], said: Mapping[str, str]) -> None:
    """Run a system once, and print, draw and write the result.

    Parameters
    ----------
    name : name of the system.
    asked : options that all systems have.
    options : texts of the system's own options, and files of its outputs, by name.
    said : option of the command line that stands for each field, by its name.
    """
    system = load_system(name)
    files = {key: value for key, value in options.items() if key in system.outputs}
    texts = {key: value for key, value in options.items() if key not in files}
    check_picture(asked.plot)
    for key, path in files.items():
        system.outputs[key].check(path)
    scenario = scenario_of(system, asked, texts)
    for key in files:
        refuse = system.outputs[key].refuse
        if refuse is not None and (reason := refuse(scenario)):
            raise ParameterError(f"{key}: {reason}")
    _check_film(system, asked)
    other = _beside(system, asked, texts)
    with progress_bar(name) as progress:
        trace = system.run(scenario, progress)
    beside = None
    if other is not None:
        with progress_bar(f"{name} on {other.die}") as progress:
            beside = system.run(other, progress)
    for each in (scenario, other):
        check_drawn(getattr(each, "die", NOMINAL_DIE))
    summary = system.summarise(trace)
    save_picture(asked.plot, lambda figure: _draw(system, trace, beside, figure))
    for key, path in files.items():
        with progress_bar(path) as progress:
            system.outputs[key].write(path, trace, progress)
    _leave_film(system, trace, asked)
    if asked.as_json:
        entries = {**described(system, scenario), **system.document(trace)}
        print_json({"system": name, **entries, "summary": summary})
        return
    for line in system.before(trace):
        print_line(as_options(line, said))
    print_run(f"{name}, {system.title(trace)}", system, summary)
    for line in system.after(trace):
        print_line(as_options(line, said))
    print_cautions(summary)


def scenario_of(system: System[Any, Any], asked: Run | Blame, texts: Mapping[str, Any]) -> Any:
    """Give the scenario that is asked for.

    texts: texts of the system's own options, by name. Raises `ParameterError` for values that it cannot have,
    and for options of silicon where no chip is in the loop.
    """
    silicon, given = asked.silicon, read_texts(system.settings, texts)
    drawn = asked.die is None and not asked.ideal
    die = read_die(replace(silicon, die=DRAWN) if drawn else silicon)
    own = {"die": die} if not drawn or die != read_die(SiliconChoice(die=DRAWN)) else {}
    on_die = {**own, **_temperature(system, silicon.celsius)}
    known = {key: value for key, value in on_die.items() if key in system.settings}
    scenario = system.on_silicon(ideal=asked.ideal, seed=asked.seed, **known, **given)
    check_known(die, system.circuits())
    system.check_run(scenario)
    remedy = system.no_silicon(scenario)
    on_chip = {
        "die": asked.die is not None,
        "temperature": silicon.temperature != USUAL_CELSIUS,
    }
    about = {key for key in given if system.settings[key].option.needs_chip}
    for key in sorted(about | {k for k, v in on_chip.items() if v}) if remedy else ():
        raise ParameterError(f"{key}: no chip is in the loop; {remedy}, or leave it out")
    return scenario


def _check_film(system: System[Any, Any], asked: Run) -> None:
    """Refuse before the run what cannot be filmed, or written."""
    if asked.view is not None:
        check_page(asked.view)
    if asked.output is not None:
        check_run(asked.output)
    if asked.animate is not None:
        check_animation(asked.animate, read_frames(asked.frames))
    elif asked.frames != FRAMES:
        raise ParameterError(f"frames: {asked.frames}, no moving picture is made; give `animate`")
    if not _wanted(asked):
        if asked.inside is not None:
            raise ParameterError(f"inside: {asked.inside}, no page is made; give view, or leave it out")
    elif system.film is None:
        raise ParameterError(f"view: {system.name} has no film; give plot, or leave it out")


def _leave_film(system: System[Any, Any], trace: Any, asked: Run) -> None:
    """Write the page, the kept run and the moving picture, where they are asked for."""
    if not _wanted(asked):
        return
    names = None if asked.inside is None else asked.inside.split(",")
    film = system.filmed(trace, names, this_command())
    leave(film, asked.view, asked.output)
    if asked.animate is not None:
        animate(asked.animate, film, read_frames(asked.frames))


def _wanted(asked: Run) -> bool:
    """Whether a film is asked for, in any form."""
    return not (asked.view is asked.output is asked.animate is None)


def _beside(system: System[Any, Any], asked: Run, texts: Mapping[str, Any]) -> Any:
    """Scenario of the run on another die that is drawn beside; None where none is asked for."""
    if asked.beside is None:
        return None
    if asked.plot is None or system.draw_beside is None:
        room = f"no picture of {system.name} has room; leave it out"
        why = "no picture is drawn; give plot, or leave it out" if asked.plot is None else room
        raise ParameterError(f"beside: {asked.beside}, {why}")
    return scenario_of(system, replace(asked, die=asked.beside), texts)


def _draw(system: System[Any, Any], trace: Any, beside: Any, figure: Figure) -> None:
    system.draw(trace, figure)
    if beside is not None and system.draw_beside is not None:
        system.draw_beside(beside, figure)


def _temperature(system: System[Any, Any], text: str) -> dict[str, Any]:
    """Temperature (degC), or a course of it for a system that takes one."""
    if COURSE not in system.settings:
        celsius = parse_quantity(text, "degC", "temperature")
        check_temperature(celsius)
        return {"temperature_c": celsius}
    return temperature_fields(read_course(text))


def described(system: System[Any, Any], scenario: Any) -> dict[str, Any]:
    """Give a scenario by the names that its options have in JSON.

    The options of a chip are given only where a chip is in the loop.
    """
    chip = not system.no_silicon(scenario)
    found: dict[str, Any] = {}
    for one in system.settings.values():
        if (one.option.silicon and not chip) or one.part == "":
            continue
        value = getattr(scenario if one.part is None else getattr(scenario, one.part), one.field)
        if one.field == "die" and one.part is None:
            found |= describe_die(value)
        elif one.field == COURSE and value:
            found["temperature_C"] = value  # instead of that at its beginning
        elif one.key:
            found[one.key] = _shown(value)
    return found


def _shown(value: Any) -> Any:
    """A field's value as JSON has it: sets sorted, what is a thing of its own in words."""
    if isinstance(value, set | frozenset):
        return sorted(value)
    return str(value) if is_dataclass(value) else value
