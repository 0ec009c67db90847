"""Names of a dialect lead back to ours, and no two of ours become the same."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from circuits.circuit import GROUND
from circuits.errors import TopologyError
from netlists.naming import element, make_naming

# few letters, so that escapes, marks and tags meet often
NAMES = st.from_regex(r"[au_r][au_rgb3]{0,5}", fullmatch=True) | st.sampled_from(["gnd", "time", "gnd_"])
REFERENCES = st.builds(element, NAMES, st.lists(st.integers(0, 12), max_size=2).map(tuple))
RESERVED = frozenset({"gnd", "time"})
TAGS = ("gb", "gd", "up", "down")


@pytest.mark.parametrize("style", ["hash", "underscore", "angle"])
def test_a_reference_comes_back(style: str) -> None:
    naming = make_naming(style, RESERVED)

    @given(REFERENCES)
    def round_trip(reference: str) -> None:
        name = naming.node(reference)
        assert naming.reference(name) == reference
        assert name.lower() not in RESERVED

    round_trip()
    assert naming.node(GROUND) == naming.reference(GROUND) == GROUND


@pytest.mark.parametrize("style", ["hash", "underscore", "angle"])
def test_a_device_s_parts_are_no_other_device(style: str) -> None:
    naming = make_naming(style, RESERVED)

    @given(NAMES, NAMES, st.sampled_from(TAGS))
    def apart(one: str, other: str, tag: str) -> None:
        assert naming.part(one, tag) != naming.node(other)
        assert one == other or naming.part(one, tag) != naming.part(other, tag)

    apart()


@pytest.mark.parametrize("style", ["hash", "underscore", "angle"])
def test_other_text_stays_apart(style: str) -> None:
    naming = make_naming(style)
    texts = st.text("a_ #<>[]0é", max_size=5)

    @given(texts, texts)
    def apart(one: str, other: str) -> None:
        assert one == other or naming.text(one) != naming.text(other)
        assert naming.text(one).isascii()

    apart()


def test_underscores_are_letters_digits_and_underscores() -> None:
    naming = make_naming("underscore", RESERVED)
    assert naming.node("v_mem[1,2]") == "v_mem__1__2"
    assert naming.node("Time") == "Time__r"
    assert naming.node("a__b_") == "a__u_b__u"
    assert naming.text("odd name!") == "odd__x20xname__x21x"


def test_what_is_no_reference_is_refused() -> None:
    with pytest.raises(TopologyError, match="not a node name"):
        make_naming("hash").node("odd name")
