"""Definitions with their notes to circuits."""

import pytest

from circuits.circuit import Instance, InstanceArray
from circuits.devices import Resistor
from circuits.errors import DataError
from netlists.read.card import Card
from netlists.read.limits import Limits
from netlists.read.notes.rebuild import Build, Called, Definition
from netlists.write.annotation import ArrayNote, InstanceNote, ParameterNote

CARD = Card("x", "a.cir", 4)


def leaf(name: str, value: float) -> Definition:
    return Definition(CARD, name, "leaf", devices=[Resistor("r", "a", "0", value)])


def test_an_array_has_the_circuit_of_its_first_call_with_its_own_values() -> None:
    called = Called(CARD, ArrayNote("x", (2,), ()), [ParameterNote("r.resistance", (5.0, 6.0), 1.0, (2,))])
    called.calls += [("xx1", "leaf"), ("xx2", "leaf_2")]
    top = Definition(CARD, "top", "top", called=[called])
    definitions = {"top": top, "leaf": leaf("leaf", 5.0), "leaf_2": leaf("leaf_2", 6.0)}
    array = Build(definitions, Limits()).circuit("top", CARD).instances[0]
    assert isinstance(array, InstanceArray)
    assert array.circuit.devices == (Resistor("r", "a", "0", 1.0),)
    assert array.parameters == {"r.resistance": (5.0, 6.0)}


def test_a_dotted_key_reaches_into_instances() -> None:
    inner = Called(CARD, InstanceNote("y", ()), [])
    inner.calls.append(("xy", "leaf"))
    outer = Called(CARD, InstanceNote("x", ()), [ParameterNote("y.r.resistance", (5.0,), 1.0)])
    outer.calls.append(("xx", "middle"))
    definitions = {
        "top": Definition(CARD, "top", "top", called=[outer]),
        "middle": Definition(CARD, "middle", "middle", called=[inner]),
        "leaf": leaf("leaf", 5.0),
    }
    instance = Build(definitions, Limits()).circuit("top", CARD).instances[0]
    assert isinstance(instance, Instance)
    assert instance.circuit.instances[0].circuit.devices == (Resistor("r", "a", "0", 1.0),)
    assert instance.parameters == {"y.r.resistance": 5.0}


@pytest.mark.parametrize(
    ("calls", "says"),
    [
        ([], "0 calls after its note, must be 1"),
        ([("x", "none")], "none: definition is not there"),
        ([("x", "top")], "top: calls itself"),
    ],
)
def test_refused(calls: list[tuple[str, str]], says: str) -> None:
    called = Called(CARD, InstanceNote("x", ()), [], calls)
    with pytest.raises(DataError, match=rf"a\.cir:4: .*{says}"):
        Build({"top": Definition(CARD, "top", "top", called=[called])}, Limits()).circuit("top", CARD)
