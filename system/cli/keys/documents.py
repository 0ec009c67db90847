"""All documents that `--json` prints: each verb's, by its forms, with the meanings of their keys.

`noctule run SYSTEM` has what its system says (`run_keys`).
"""

from __future__ import annotations

from typing import Any

from system.cli.keys.bench import BENCH, LABS
from system.cli.keys.block import OP, SHOW, SHOW_CHIP, SHOW_ROLLS
from system.cli.keys.installed import (
    CALIBRATE,
    CHARACTERISE,
    DOCTOR,
    EXTRACT,
    EXTRACT_FIT,
    IDENTIFY,
    LIST,
    NEW,
    PREDICT,
    REPRODUCE,
)
from system.cli.keys.mapping import (
    MAP,
    MAP_NEF,
    RUN_PROGRAM,
    RUN_PROGRAM_NEF,
    SHOW_PROGRAM,
    SHOW_PROGRAM_NEF,
    TRAIN,
)
from system.cli.keys.mission import CERTIFY, MISSION
from system.cli.keys.netlist import COMPARE, EXPORT, EXPORT_ROLLS, IMPORT
from system.cli.keys.over_dies import CORNERS, MATCH, WORST
from system.cli.keys.serve import SERVE
from system.cli.keys.study import BLAME, CENTRE, GRADIENT, MONTECARLO, RARE, REPLAY, SIZE
from system.cli.keys.sweep import SWEEP
from system.cli.keys.transient import AC, DECK, NOISE, SIMULATE, TRAN_NOISE
from system.cli.keys.view import VIEW
from system.cli.option_names import option_of
from system.meaning import SUMMARY, Meaning, Meanings, kind_of, meanings
from system.options.block import DIE_KEYS
from system.options.noise import NOISELESS
from system.options.temperature import COURSE
from system.system import ENTRIES, System

DOCUMENTS: dict[str, Meanings] = {
    "list": LIST,
    "show BLOCK": SHOW,
    "show CHIP": SHOW_CHIP,
    "show rolls": SHOW_ROLLS,
    "show PROGRAM.toml": SHOW_PROGRAM,
    "show PROGRAM.toml (nef)": SHOW_PROGRAM_NEF,
    "map": MAP,
    "map --chip nef": MAP_NEF,
    "op": OP,
    "simulate": SIMULATE,
    "simulate --analysis dc": DECK,
    "simulate --analysis ac": AC,
    "simulate --analysis noise": NOISE,
    "simulate --analysis tran-noise": TRAN_NOISE,
    "sweep": SWEEP,
    "view": VIEW,
    "export": EXPORT,
    "export rolls": EXPORT_ROLLS,
    "import": IMPORT,
    "compare": COMPARE,
    "montecarlo": MONTECARLO,
    "montecarlo --rare": RARE,
    "gradient": GRADIENT,
    "match": MATCH,
    "worst": WORST,
    "corners": CORNERS,
    "mission": MISSION,
    "certify": CERTIFY,
    "train": TRAIN,
    "merge": MISSION,
    "replay": REPLAY,
    "centre": CENTRE,
    "size": SIZE,
    "blame SYSTEM": BLAME,
    "characterise": CHARACTERISE,
    "extract": EXTRACT,
    "extract --fit": EXTRACT_FIT,
    "identify": IDENTIFY,
    "predict": PREDICT,
    "calibrate": CALIBRATE,
    "reproduce": REPRODUCE,
    "labs": LABS,
    "serve": SERVE,
    "new": NEW,
    "doctor": DOCTOR,
    "run bench": BENCH,
    "run PROGRAM.toml": RUN_PROGRAM,
    "run PROGRAM.toml (nef)": RUN_PROGRAM_NEF,
}
EVERY_RUN = meanings("""
system   string  -  name of the system
summary  object  -  how the run went
""")
SHARED = {  # of options that all systems have
    "seed": "of noise and worlds",
    "temperature_C": "of the chips; of a course, pairs of time (s) and temperature",
}


def scenario_keys(system: System[Any, Any]) -> dict[str, Meaning]:
    """Return the keys that a run's document has of its scenario: those of its options."""
    found: dict[str, Meaning] = {}
    for one in system.settings.values():
        if not one.key or one.part == "":
            continue
        if one.field == "die" and one.part is None:
            found |= DIE_KEYS
        elif one.key not in system.meanings:
            unit = "rad" if one.option.unit == "deg" else one.option.unit or ""
            words = one.option.help or SHARED.get(one.key, "")
            if one.option.run and words:  # the help of an option leaves out what its name says
                words = f"{words}; option `{option_of(one.name)}`"
            kind = kind_of(one.kind, nullable=one.default is None)
            if one.key == "temperature_C":
                unit, kind = "degC", "number|number[][]" if COURSE in system.settings else kind
            found[one.key] = Meaning(kind, unit, words[:1].lower() + words[1:])
    return found


def run_keys(system: System[Any, Any]) -> dict[str, Meaning]:
    """Return all keys of the document of a run of `system`.

    What a run was on is named as in its scenario, and means the same there, where nothing else is said.
    """
    document = {**scenario_keys(system), **system.meanings}
    within = f"{SUMMARY}.ran_on"
    on = {f"{within}.{key}": each for key, each in document.items() if "." not in key}
    on |= meanings(
        f"{NOISELESS}  string?  -  parts at transistor level, whose devices make no noise here", within
    )
    if COURSE in system.settings:
        on |= meanings("temperature_C  number|string  degC  of the chips; of a course in words", within)
    account = {f"{SUMMARY}.{key}": each for key, each in ENTRIES.items()}
    return {**EVERY_RUN, **account, **on, **document}
