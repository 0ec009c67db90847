"""What pixels are made of: bandwidth by light, and room for events."""

from __future__ import annotations

import pytest

from system.worlds.camera.pixel import bandwidth, note_event, raw_of


def test_less_light_is_slower() -> None:
    # 1/f = 1/300 + 1/(3 lux)
    assert bandwidth(300.0, 3.0, 100.0) == pytest.approx(150.0)
    assert bandwidth(300.0, 3.0, 1.0) == pytest.approx(300.0 / 101.0)


def test_events_beyond_the_buffer_count_as_lost() -> None:
    raw = raw_of(4, 3)
    for k in range(5):
        note_event(raw, 0.1 * k, 2 * k)
    assert raw.used.tolist() == [3, 2]
    assert raw.code.tolist() == [0, 2, 4]
