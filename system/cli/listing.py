"""The verb `noctule list`: shows all blocks, chips, systems and so on, with a line on each."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from chips.registry import chip_names, load_chip
from circuits.errors import CircuitError
from circuits.registry import block_names, load_block, load_metric, metric_names
from netlists.registry import dialect_names, load_dialect
from system.cli.exit_status import DONE, NO
from system.cli.output import print_json, print_table
from system.cli.verbs import List
from system.notice import say
from system.registry import experiment_names, load_experiment, load_system, system_names

_BROKEN = "cannot be loaded: "


def list_command(asked: List) -> int:
    """Print all that has a name, by its kind; returns `NO` where one of them cannot be loaded."""
    groups = {
        "blocks": _summaries(block_names(), load_block),
        "chips": _summaries(chip_names(), load_chip),
        "systems": _summaries(system_names(), load_system),
        "experiments": _summaries(experiment_names(), load_experiment),
        "metrics": _summaries(metric_names(), load_metric),
        "dialects": _summaries(dialect_names(), load_dialect),
    }
    if asked.as_json:
        print_json(groups)
    else:
        for title, entries in groups.items():
            print_table(title, ("name", "summary"), [(e["name"], e["summary"]) for e in entries])
    broken = [e["name"] for entries in groups.values() for e in entries if e["summary"].startswith(_BROKEN)]
    if broken:
        say(f"list: {', '.join(broken)} cannot be loaded; see the summary, mend or uninstall what brings it")
    return NO if broken else DONE


def _summaries(names: Iterable[str], load: Callable[[str], Any]) -> list[dict[str, str]]:
    return [{"name": name, "summary": _summary(name, load)} for name in names]


def _summary(name: str, load: Callable[[str], Any]) -> str:
    """One entry that cannot be loaded must not hide the others."""
    try:
        return str(load(name).summary)
    except (ImportError, CircuitError) as error:
        return f"{_BROKEN}{error}"
