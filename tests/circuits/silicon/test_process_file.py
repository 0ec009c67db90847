"""Processes by name, and a user's own from a file."""

from __future__ import annotations

import math
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import tomli_w

from circuits.errors import CircuitError
from circuits.silicon.process import (
    AMI_1500,
    AMI_1500_IDEAL,
    PROCESSES,
    ROLLS_180,
    DiodeVariation,
    Process,
)
from circuits.silicon.process_file import format_process, process_of, process_under, read_process
from circuits.silicon.size import SizeTerms
from tests.refusals import file_refusals

SIZED = replace(
    ROLLS_180,
    name="sized",
    n=replace(ROLLS_180.n, size=SizeTerms(1e-6, 2e-6, 1e-6, 3e-6, v_t0=(1e-8, 0, 0, 0))),
    diodes=DiodeVariation(0.04, 0.1),
)


@pytest.mark.parametrize(
    "process", [*PROCESSES.values(), AMI_1500_IDEAL, SIZED], ids=lambda p: f"{p.name}-{p.effects}"
)
def test_a_file_is_read_as_it_stands(process: Process, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(format_process(process))
    assert read_process(path) == process
    assert process_of(str(path)) == process


def with_text(old: str, new: str) -> str:
    """The file of a process, one text in which is another."""
    return format_process(ROLLS_180).replace(old, new, 1)


test_what_is_wrong_is_named = file_refusals(
    CircuitError,
    "mine.toml",
    lambda path: read_process(Path(path)),
    [
        (with_text("early_rise = 0.13", ""), "n: lacks early_rise"),
        (with_text("v_dd = 1.8", ""), "process: lacks v_dd"),
        (
            with_text("v_dd = 1.8", "v_dd = 1.8\nvdd = 1.8"),
            r"process\.vdd: no such term; did you mean v_dd\?",
        ),
        (with_text("v_dd = 1.8", 'v_dd = "high"'), r"rolls-180\.v_dd"),
        (with_text("[n]", "[q]"), "process: lacks n"),
        (with_text("v_dd = 1.8", "v_dd ="), "no TOML"),
        (with_text("wafer_share = 0.3", ""), "components: lacks wafer_share"),
        (
            with_text("wafer_share = 0.3", "wafer_share = 0.6"),
            r"components\.wafer_share: 0\.6 beside a lot_share of 0\.5",
        ),
        (
            with_text("correlation_beta = 0.6", "correlation_beta = 1.6"),
            r"components\.correlation_beta: 1\.6, must be",
        ),
    ],
)


def test_components_alone_may_be_left_out(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(format_process(ROLLS_180).partition("[components]")[0])
    assert read_process(path) == replace(ROLLS_180, components=None)


def test_a_missing_file_and_an_unknown_name_are_refused(tmp_path: Path) -> None:
    with pytest.raises(CircuitError, match="No such file"):
        process_of(str(tmp_path / "none.toml"))
    with pytest.raises(CircuitError, match="did you mean rolls-180"):
        process_of("rols-180")


def test_a_measured_process_is_the_one_of_the_evidence() -> None:
    kept = read_process(Path("evidence/coach/process.toml"))
    assert process_of("coach-180") == replace(kept, name="coach-180")


def test_a_block_s_process_goes_under_a_law() -> None:
    assert process_under(AMI_1500_IDEAL, None, "full") == AMI_1500
    assert process_under(AMI_1500_IDEAL, None, "ideal") == AMI_1500_IDEAL
    assert process_under(AMI_1500_IDEAL, "rolls-180", "ideal") == ROLLS_180.ideal()
    assert {p.effects for p in PROCESSES.values()} == {"full"}
    assert AMI_1500_IDEAL.effects == "ideal"


@pytest.mark.parametrize(
    ("place", "value", "said"),
    [
        (("n", "kappa"), math.nan, r"n\.kappa: nan, must be finite"),
        (("p", "overlap_capacitance"), math.inf, r"p\.overlap_capacitance: inf, must be finite"),
        (("n", "mobility_reduction"), -1.0, r"n\.mobility_reduction: -1, must be >= 0"),
        (("p", "mu_cox"), 0.0, r"p\.mu_cox: 0, must be > 0"),
        (("v_dd",), -1.8, r"v_dd: -1\.8, must be > 0"),
        (("pair_a_vt",), math.nan, r"pair_a_vt: nan, must be finite"),
        (("n", "surface_potential"), 0.0, r"n\.surface_potential: 0, must be > 0 with this law"),
        (("variation", "sigma_beta"), "x", r"variation\.sigma_beta: 'x', must be a number"),
        (("n", "size", "v_t0"), [0.0, math.nan, 0.0, 0.0], r"n\.size\.v_t0: nan, must be finite"),
    ],
)
def test_a_number_that_no_process_has_is_refused_with_its_term(
    tmp_path: Path, place: tuple[str, ...], value: object, said: str
) -> None:
    stated = tomllib.loads(format_process(process_of("coach-180")))
    table: dict[str, Any] = stated
    for name in place[:-1]:
        table = table[name]
    table[place[-1]] = value
    (tmp_path / "own.toml").write_text(tomli_w.dumps(stated), encoding="utf-8")
    with pytest.raises(CircuitError, match=rf"own\.toml: {said}"):
        read_process(tmp_path / "own.toml")
