"""Films as pages and as files: nothing is lost on the way, and what cannot be is refused."""

import base64
import json
import re
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from circuits.errors import DataError, ParameterError, UnknownNameError
from system.view import page as pages
from system.view.arrays import Arrays
from system.view.film import busiest, merged
from system.view.kept import keep, kept
from system.view.page import page, write_page
from tests.system.view.films import film


def read(entry: dict[str, Any], block: bytes) -> np.ndarray[Any, np.dtype[Any]]:
    """An array of a page, as the page reads it."""
    kind = np.dtype(f"<{entry['type']}")
    raw = np.frombuffer(block, np.uint8, entry["length"] * kind.itemsize, entry["at"])
    values = np.ascontiguousarray(raw.reshape(kind.itemsize, -1).T).reshape(-1).view(kind)
    return entry["from"] + np.cumsum(values) * entry["quantum"] if "quantum" in entry else values


@pytest.mark.parametrize(
    ("values", "within"),
    [
        (np.array([True, False, True]), 0.0),
        (np.array([0, 255, 3]), 0.0),
        (np.array([0, 70_000]), 0.0),
        (np.array([0.1, np.nan, -1e-12]), 1e-8),
        (np.sort(np.random.default_rng(1).uniform(0.0, 60.0, 5000)), 60e-8),
        (np.zeros(0), 0.0),
    ],
)
def test_an_array_of_a_page_is_what_it_was(values: np.ndarray[Any, np.dtype[Any]], within: float) -> None:
    arrays = Arrays()
    arrays.add(np.arange(300))  # what stands before it
    entry = arrays.add(values)
    found = read(entry, zlib.decompress(base64.b64decode(arrays.text())))
    assert found == pytest.approx(values.astype(np.float64), abs=within, nan_ok=True)


def test_a_kept_film_is_the_film(tmp_path: Path) -> None:
    path, before = tmp_path / "run.nc", film()
    keep(str(path), before)
    after = kept(str(path))
    assert page([after]) == page([before])
    assert after.neurons[0].devices == before.neurons[0].devices
    assert after.panels[0].lines[0].value == pytest.approx(before.panels[0].lines[0].value, rel=0.0, abs=0.0)


def test_what_is_no_kept_run_is_said(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no such file"):
        kept(str(tmp_path / "none.nc"))
    (tmp_path / "text.nc").write_text("hello")
    with pytest.raises(DataError, match=r"nc: not a kept run; noctule run SYSTEM -o RUN.nc makes one$"):
        kept(str(tmp_path / "text.nc"))


def test_a_page_has_one_film_or_two_and_asks_no_host() -> None:
    text = page([film(), replace(film(), title="</script><b>another")])
    assert (
        len(json.loads(re.findall(r'id="films">(.*?)</script>', text, re.DOTALL)[0].replace("<\\/", "</")))
        == 2
    )
    assert "default-src 'none'" in text
    assert not re.search(r"https?://", text)
    assert "</script><b>" not in text
    with pytest.raises(ParameterError, match="films: 3, must be one or two"):
        page([film()] * 3)


def test_a_page_that_is_too_large_is_refused_and_nothing_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pages, "LARGEST", 1000)
    with pytest.raises(ParameterError, match=r"must be at most 0.001 MB; give a shorter duration"):
        write_page(str(tmp_path / "page.html"), [film()])
    assert not list(tmp_path.iterdir())


def test_two_million_events_of_a_minute_fit_into_a_page() -> None:
    assert len(page([film(events=2_000_000, spikes=200_000, duration=60.0)])) < pages.LARGEST


def test_neurons_to_look_into_are_those_asked_for_or_the_busiest() -> None:
    names = [f"neuron[{k}]" for k in range(20)]
    rows = np.repeat(np.arange(20), np.arange(20))
    assert busiest(names, rows, None) == names[12:]
    assert busiest(names, rows, ["neuron[3]"]) == ["neuron[3]"]
    with pytest.raises(UnknownNameError, match="neuron"):
        busiest(names, rows, ["nobody"])


def test_trains_are_merged_in_the_order_of_time() -> None:
    times, rows = merged([np.array([1.0, 3.0]), np.array([2.0]), np.zeros(0)])
    assert times.tolist() == [1.0, 2.0, 3.0]
    assert rows.tolist() == [0, 1, 0]
