"""What tests of experiments share: the size of a picture that is drawn."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from system.plot import save_picture

Draw = Callable[[Figure], None]


@pytest.fixture
def drawn(tmp_path: Path) -> Callable[[Draw], int]:
    """Draws into a file, and gives its bytes; an empty figure has 3 kB."""

    def size_of(draw: Draw) -> int:
        picture = tmp_path / "figure.png"
        save_picture(str(picture), draw)
        return picture.stat().st_size

    return size_of
