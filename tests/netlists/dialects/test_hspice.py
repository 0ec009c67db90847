r"""HSPICE: expressions in quotes go on after `\\`, within the simulator's longest line."""

from __future__ import annotations

from dataclasses import replace

from circuits.devices import OperationalAmplifier, Transistor
from circuits.silicon.process import AMI_1500_IDEAL
from circuits.silicon.silicon import Silicon
from netlists.dialects import ngspice as ngspice_text
from netlists.dialects.hspice import DIALECT

LONGEST = 1024
format_device = DIALECT.devices["ekv"]
GAMMA = Silicon(replace(AMI_1500_IDEAL, n=replace(AMI_1500_IDEAL.n, law="ekv-gamma", early_field=15e6)))
EARLY = Silicon(replace(AMI_1500_IDEAL, n=replace(AMI_1500_IDEAL.n, early_field=15e6)))


def test_a_long_expression_is_continued_and_is_the_same_expression() -> None:
    """In one expression the law is long only between long names."""
    ends = (f"a_{end}_with_a_rather_long_name" for end in ("drain", "gate", "source", "bulk"))
    device = Transistor("a_rather_long_name", "n", *ends, 3e-6, 3e-6)
    lines = format_device(device, EARLY)
    pieces = lines[: next(k for k, line in enumerate(lines) if not line.endswith("\\\\")) + 1]
    assert len(pieces) > 1
    assert max(map(len, lines)) <= LONGEST
    assert all(line.endswith("\\\\") for line in pieces[:-1])
    assert not any(line.startswith("*") for line in pieces)
    assert "".join(line.removesuffix("\\\\") for line in pieces).endswith(
        f"cur='{of_ngspice(device, EARLY)[0]}'"
    )


def test_every_node_that_a_law_holds_has_the_same_expression() -> None:
    device = Transistor(
        "a_rather_long_name", "n", "drain_node", "gate_node", "source_node", "bulk_node", 3e-6, 3e-6
    )
    found = [line.partition("cur=")[2].replace("__", "#") for line in format_device(device, GAMMA)]
    expected = of_ngspice(device, GAMMA)
    assert len(expected) == 6  # current, vp, fx, f, rx, r
    assert [line for line in found if line] == [f"'{each}'" for each in expected]


def of_ngspice(device: Transistor, silicon: Silicon) -> list[str]:
    """The expressions of ngspice's currents, in HSPICE's words."""
    lines = (line for line in ngspice_text.format_device(device, silicon) if line.startswith("b"))
    return [line.partition("i=")[2].replace("^", "**").replace("ln(", "log(") for line in lines]


def test_a_short_one_is_one_line() -> None:
    up, down = format_device(OperationalAmplifier("u", "p", "n", "y", "vdd"), Silicon(AMI_1500_IDEAL))
    assert up.startswith("gu__up y vdd cur='")
    assert down.startswith("gu__down y 0 cur='")
    assert up.endswith("'")
