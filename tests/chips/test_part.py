"""Ports of a part have elements, and outputs may be empty."""

from __future__ import annotations

from dataclasses import replace

import pytest

from chips.part import port_index, quiet
from circuits.errors import UnknownNameError


def test_an_element_of_a_port_is_its_number() -> None:
    assert port_index("spike[12]", "spike", 13, "chip") == 12
    with pytest.raises(UnknownNameError, match=r"chip event port spike\[13\]"):
        port_index("spike[13]", "spike", 13, "chip")
    assert replace(quiet(1.0), events=(("a", 1.0),)).events
