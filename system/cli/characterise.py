"""The verb `noctule characterise`: a block's behavioural model is measured from its own circuit."""

from __future__ import annotations

import os
import time
from collections.abc import Mapping
from pathlib import Path
from tempfile import TemporaryDirectory

from chips.model import Model, characterise, load_model
from chips.record import write_record
from chips.record_file import cached_file, shipped_file
from circuits.errors import DataError, ParameterError
from circuits.registry import block_names, load_block
from circuits.silicon.process import AMI_1500, PROCESSES, Effects, Process
from circuits.silicon.process_file import process_under
from system.cli.mend import require_checkout
from system.cli.output import print_json, print_line, print_table, progress_bar
from system.cli.verbs import Characterise
from system.files.writing import write_bytes_atomic
from system.options.block import read_bias_set
from system.options.code import load_as


def characterise_command(asked: Characterise) -> None:
    """Characterise a block, write its record and print its errors.

    The record goes to the cache folder, whose records are read before those of the package, unless another
    file or the package's own is asked for; a record of another process or law has a file of its own there.
    Where a set of biases is named, the errors on other dies are measured at that set.
    """
    model = _model(asked.block)
    block = model.name
    biases = _biases(block, asked.bias_set, asked.output)
    process = _process(asked.process, asked.law)
    path = _path(block, process, asked.output, update_package=asked.update_package)
    start = time.perf_counter()
    with TemporaryDirectory() as folder, progress_bar(f"characterise {block}") as progress:
        record = characterise(model, progress, biases, process)
        made = Path(folder) / path.name
        write_record(record, made)
        write_bytes_atomic(path, made.read_bytes())
    seconds = time.perf_counter() - start
    figures = model.figures(record)
    if asked.as_json:
        made_in = {"process": process.name, "law": process.effects}
        document = {"block": block, **made_in, "file": str(path), "key": record.key, **figures}
        print_json({**document, "errors": dict(record.errors), "seconds": seconds})
        return
    rows = [(name, f"{value:.3g}") for name, value in (*record.errors.items(), *figures.items())]
    print_table(f"{block}: errors on dies that were not used", ["error", "value:"], rows)
    read = ", which is read before the package's" if path == cached_file(block, process) else ""
    print_line(f"written to {path}{read}, in {seconds:.0f} s")


def _model(target: str) -> Model:
    """The model of a block, or one in a user's file."""
    return load_as(target, Model) or load_model(target)


def _process(text: str | None, effects: Effects) -> Process:
    """The process of the record: the models' own, or another one that does not bear the name of one."""
    process = process_under(AMI_1500, text, effects)
    stated = PROCESSES.get(process.name)
    if stated is not None and process != stated.under(effects):
        raise ParameterError(
            f"{text}: name {process.name}, must not be that of a process of noctule's; give it another"
        )
    return process


def _path(block: str, process: Process, output: str | None, *, update_package: bool) -> Path:
    """Where the record goes, which is found out to be possible before anything is measured."""
    if update_package and output is not None:
        raise ParameterError(f"--update-package: writes the package's record, not {output}; leave one out")
    path = Path(output) if output else cached_file(block, process)
    if update_package:
        if process.name != AMI_1500.name:
            kept = f"keeps records of {AMI_1500.name} alone"
            raise ParameterError(f"--update-package: {process.name}, the package {kept}; leave it out")
        path = shipped_file(block, process)
        require_checkout(path)
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
    if block not in block_names() or not load_block(block).bias_sets:
        raise ParameterError(f"--bias-set: {bias_set}, {block} has no named sets; leave it out")
    if output is None:
        rule = "a record that is read by itself has the errors at the block's own"
        raise ParameterError(f"--bias-set: {bias_set}, {rule}; give -o FILE")
    return read_bias_set(load_block(block), bias_set)
