"""`noctule characterise`: a block's behavioural model, measured from its own circuit."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from importlib import import_module
from importlib.resources import files
from pathlib import Path

from chips.board_measurement import characterise_board
from chips.record import Record, write_record
from chips.wavefront_measurement import characterise_wavefront
from circuits.errors import DataError, ParameterError, unknown_name
from circuits.registry import load_block
from system.commands.output import print_json, print_line, print_table, progress_bar
from system.options import read_bias_set

# Blocks with a characteriser, `module:function`; a record is named after its block.
CHARACTERISERS: dict[str, str] = {"rebound-neuron": "chips.characterise:characterise"}
# Blocks whose record is of the boards' kind, all measured by `chips.board_measurement`.
BOARDS = (
    "centroid-board",
    "vocalization-controller",
    "hearing",
    "first-target-isolation",
    "winner-take-all",
    "latency-chip",
    "lso-neuron",
)
# Blocks of the wavefront chip, measured by `chips.wavefront_measurement`.
WAVEFRONT = ("axon-delay", "wavefront-cell")


def characterise_command(block: str, *, output: str | None, bias_set: str | None, as_json: bool) -> None:
    """Characterise `block`, write its record to `output` or into the package, print its errors.

    bias_set: the set of biases at which the errors on other dies are measured, the block's own unless given.
    """
    known = (*CHARACTERISERS, *BOARDS, *WAVEFRONT)
    if block not in known:
        raise unknown_name("characterised block", block, known)
    biases = _biases(block, bias_set, output)
    path = Path(output) if output else shipped_path(block)
    if path.is_dir() or not path.parent.is_dir():
        raise DataError(f"{path}: must be a file in a folder that exists; give another with -o")
    if block not in CHARACTERISERS:
        _board(block, path, as_json=as_json)
        return
    module, function = CHARACTERISERS[block].split(":")
    measure: Callable[..., Record] = getattr(import_module(module), function)
    start = time.perf_counter()
    with progress_bar(f"characterise {block}") as progress:
        record = measure(progress=progress, biases=biases)
    write_record(record, path)
    seconds = time.perf_counter() - start
    if as_json:
        print_json(
            {
                "block": block,
                "file": str(path),
                "key": record.key,
                "margin_V": record.margin,
                "errors": record.errors,
                "seconds": seconds,
            }
        )
        return
    rows = [(name, f"{value:.3g}") for name, value in record.errors.items()]
    print_table(f"{block}: errors on dies that were not used", ["error", "value:"], rows)
    print_line(f"threshold decided beyond {record.margin * 1e3:.2g} mV; written to {path} in {seconds:.0f} s")


def _biases(block: str, bias_set: str | None, output: str | None) -> Mapping[str, float] | None:
    if bias_set is None:
        return None
    if block not in CHARACTERISERS:
        raise ParameterError(f"--bias-set: {bias_set}, {block} has no named sets; leave it out")
    if output is None:
        raise ParameterError(
            f"--bias-set: {bias_set}, the package's record has the errors at the block's own; -o FILE"
        )
    return read_bias_set(load_block(block), bias_set)


def _board(block: str, path: Path, *, as_json: bool) -> None:
    start = time.perf_counter()
    measure = characterise_wavefront if block in WAVEFRONT else characterise_board
    with progress_bar(f"characterise {block}"):
        errors = measure(block.replace("-", "_"), path)
    seconds = time.perf_counter() - start
    if as_json:
        print_json({"block": block, "file": str(path), "errors": errors, "seconds": seconds})
        return
    rows = [(name, f"{value:.3g}") for name, value in errors.items()]
    print_table(f"{block}: errors on dies that were not used", ["error", "value:"], rows)
    print_line(f"written to {path} in {seconds:.0f} s")


def shipped_path(block: str) -> Path:
    """Where the package keeps the record of a block."""
    return Path(str(files("chips"))) / "records" / f"{block.replace('-', '_')}.nc"
