"""Things by name: ours from the table, users' own by entry point, and what is refused."""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib.metadata import EntryPoint, EntryPoints

import pytest

from circuits import catalogue
from circuits.catalogue import Catalogue, later, loaded
from circuits.errors import ParameterError, UnknownNameError

GROUP = "noctule.things"
HERE = "tests.circuits.test_catalogue"
OURS, THEIRS = 1, 2
TABLE = {"second": f"{HERE}:THEIRS", "first": f"{HERE}:OURS", "gone": "nowhere.at_all:THING"}
Registered = Callable[..., "Catalogue[int]"]


@pytest.fixture
def registered(monkeypatch: pytest.MonkeyPatch) -> Registered:
    """A catalogue of whole numbers with the entry points that are given."""

    def make(**entries: str) -> Catalogue[int]:
        found = [EntryPoint(name, value, GROUP) for name, value in entries.items()]
        monkeypatch.setattr(catalogue, "entry_points", lambda group: EntryPoints(found).select(group=group))
        return Catalogue("thing", TABLE, GROUP, ("builtins:int",))

    return make


def test_names_are_ours_in_order_then_the_users_sorted(registered: Registered) -> None:
    things = registered(zebra=f"{HERE}:THEIRS", ape=f"{HERE}:THEIRS", first=f"{HERE}:THEIRS")
    assert things.names() == [*TABLE, "ape", "zebra"]


def test_a_thing_of_a_user_is_loaded_and_takes_no_place_of_ours(registered: Registered) -> None:
    things = registered(ape=f"{HERE}:THEIRS", first=f"{HERE}:THEIRS")
    assert (things.load("ape"), things.load("first")) == (THEIRS, OURS)


def test_nothing_is_loaded_until_it_is_asked_for(registered: Registered) -> None:
    things = registered(ape="nowhere.at_all:THING")
    assert "gone" in things.names()
    assert things.load("second") == THEIRS
    with pytest.raises(ModuleNotFoundError, match="nowhere"):
        things.load("gone")
    with pytest.raises(
        ParameterError, match=r"noctule\.things\.ape: nowhere\.at_all:THING, cannot be loaded"
    ):
        things.load("ape")


@pytest.mark.parametrize("value", [f"{HERE}:MISSING", f"{HERE}:GROUP"])
def test_what_a_user_registers_must_be_of_the_kind(registered: Registered, value: str) -> None:
    with pytest.raises(ParameterError, match=r"must be a int|no attribute 'MISSING'"):
        registered(ape=value).load("ape")


def test_an_unknown_name_has_a_near_one(registered: Registered) -> None:
    things = registered(ape=f"{HERE}:THEIRS")
    with pytest.raises(
        UnknownNameError, match=r"^thing frist: unknown; did you mean first\? known are ape, "
    ):
        things.load("frist")


def test_a_place_is_a_module_and_its_attribute() -> None:
    assert loaded(f"{HERE}:OURS") == OURS


def test_a_library_is_imported_when_something_of_it_is_asked_for(monkeypatch: pytest.MonkeyPatch) -> None:
    library = later("wave")
    monkeypatch.delitem(sys.modules, "wave", raising=False)
    assert not hasattr(library, "__path__")
    assert "wave" not in sys.modules
    assert library.WAVE_FORMAT_PCM == 1
    assert "wave" in sys.modules
    with pytest.raises(AttributeError, match="nothing"):
        _ = library.nothing
