"""What commands print: JSON that is short to read, and the same document."""

import json
import math

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from system.cli.output import json_text, plain

NAMES = st.text(max_size=3)
LEAVES = st.none() | st.booleans() | st.integers() | st.floats() | NAMES
VALUES = st.recursive(
    LEAVES,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(NAMES, inner, max_size=3),
    max_leaves=8,
)


@settings(suppress_health_check=[HealthCheck.too_slow], deadline=None)  # it may run beside others
@given(st.dictionaries(NAMES, VALUES, max_size=3))
def test_the_text_is_the_document(document: dict[str, object]) -> None:
    assert json.loads(json_text(document)) == plain(document)


def test_arrays_of_numbers_stand_on_one_line() -> None:
    path = np.linspace(0.0, 1.0, 2000).reshape(1000, 2)
    document = {"path": path, "at": (1, math.nan), "runs": [{"times": [0.1, 0.2]}, {}], "none": [], "in": {}}
    assert json_text({k: v for k, v in document.items() if k != "path"}) == (
        '{\n  "at": [1, null],\n  "runs": [\n    {\n      "times": [0.1, 0.2]\n    },\n    {}\n  ],\n'
        '  "none": [],\n  "in": {}\n}\n'
    )
    text = json_text(document)
    assert len(text.splitlines()) == 12
    assert json.loads(text)["path"] == path.tolist()
