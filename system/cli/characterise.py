"""`noctule characterise`: a block's behavioural model, measured from its own circuit."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory

from chips.measurement import characterise_board
from chips.ranging.record import Record, write_record
from chips.record_file import cached_file, shipped_file
from chips.wavefront.measure import characterise_wavefront
from circuits.errors import DataError, ParameterError, unknown_name
from circuits.registry import load_block
from system.cli.output import print_json, print_line, print_table, progress_bar
from system.files.writing import write_bytes_atomic
from system.options.block import read_bias_set

# Blocks with a characteriser, `module:function`; a record is named after its block.
CHARACTERISERS: dict[str, str] = {"rebound-neuron": "chips.ranging.measure:characterise"}
# Blocks whose record is of the boards' kind, all measured by `chips.measurement`.
BOARDS = (
    "centroid-board",
    "vocalization-controller",
    "hearing",
    "first-target-isolation",
    "winner-take-all",
    "latency-chip",
    "lso-neuron",
)
# Blocks of the wavefront chip, measured by `chips.wavefront.measure`.
WAVEFRONT = ("axon-delay", "wavefront-cell")


def characterise_command(
    block: str, *, output: str | None, bias_set: str | None, update_package: bool, as_json: bool
) -> None:
    """Characterise `block`, write its record and print its errors.

    output: where to, the cache folder unless given, whose records are read before the package's;
    update_package: the package's own record, in a checkout; bias_set: the set of biases at which the errors
    on other dies are measured, the block's own unless given.
    """
    known = (*CHARACTERISERS, *BOARDS, *WAVEFRONT)
    if block not in known:
        raise unknown_name("characterised block", block, known)
    biases = _biases(block, bias_set, output)
    path = _path(block, output, update_package=update_package)
    start = time.perf_counter()
    with TemporaryDirectory() as folder, progress_bar(f"characterise {block}") as progress:
        made = Path(folder) / path.name
        described, errors, note = _measured(block, made, biases, progress)
        write_bytes_atomic(path, made.read_bytes())
    seconds = time.perf_counter() - start
    if as_json:
        print_json(
            {"block": block, "file": str(path), **described, "errors": dict(errors), "seconds": seconds}
        )
        return
    rows = [(name, f"{value:.3g}") for name, value in errors.items()]
    print_table(f"{block}: errors on dies that were not used", ["error", "value:"], rows)
    read = ", which is read before the package's" if path == cached_file(block) else ""
    print_line(f"{note}written to {path}{read}, in {seconds:.0f} s")


def _measured(
    block: str, path: Path, biases: Mapping[str, float] | None, progress: Callable[[float], None]
) -> tuple[dict[str, object], Mapping[str, float], str]:
    """Write the record to `path`; what JSON says of it, its errors, and a note on it."""
    if block not in CHARACTERISERS:
        measure = characterise_wavefront if block in WAVEFRONT else characterise_board
        return {}, measure(block.replace("-", "_"), path), ""
    module, function = CHARACTERISERS[block].split(":")
    characterise: Callable[..., Record] = getattr(import_module(module), function)
    record = characterise(progress=progress, biases=biases)
    write_record(record, path)
    note = f"threshold decided beyond {record.margin * 1e3:.2g} mV; "
    return {"key": record.key, "margin_V": record.margin}, record.errors, note


def _path(block: str, output: str | None, *, update_package: bool) -> Path:
    """Where the record goes, which is found out to be possible before anything is measured."""
    if update_package and output is not None:
        raise ParameterError(f"--update-package: writes the package's record, not {output}; leave one out")
    path = Path(output) if output else cached_file(block)
    if update_package:
        path = shipped_file(block)
        if not (path.parents[2] / "pyproject.toml").is_file():
            where = f"{path.parents[2]} is an installed package"
            raise ParameterError(f"--update-package: {where}, must be a checkout; leave it out")
    elif output is None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise DataError(f"{path.parent}: cannot be made, {error.strerror}; give a file with -o") from None
    if path.is_dir() or not path.parent.is_dir():
        raise DataError(f"{path}: must be a file in a folder that exists; give another with -o")
    if not os.access(path.parent, os.W_OK):
        raise DataError(f"{path.parent}: cannot be written, permission denied; give another file with -o")
    return path


def _biases(block: str, bias_set: str | None, output: str | None) -> Mapping[str, float] | None:
    if bias_set is None:
        return None
    if block not in CHARACTERISERS:
        raise ParameterError(f"--bias-set: {bias_set}, {block} has no named sets; leave it out")
    if output is None:
        rule = "a record that is read by itself has the errors at the block's own"
        raise ParameterError(f"--bias-set: {bias_set}, {rule}; give -o FILE")
    return read_bias_set(load_block(block), bias_set)
