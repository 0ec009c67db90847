"""Files inside their root, and the limits on what they hold."""

from pathlib import Path

import pytest

from circuits.errors import DataError
from netlists.read.limits import Limits
from netlists.read.note import Notes
from netlists.read.text.files import Files, contents, count, inside, root_folder


def files(limits: Limits) -> Files:
    return Files(None, limits, Notes())


def test_a_link_is_resolved_before_it_is_judged(tmp_path: Path) -> None:
    root = root_folder(tmp_path)
    (root / "in").mkdir()
    (root / "in" / "a").write_text("x")
    (root / "out").symlink_to("/")
    (root / "back").symlink_to(root / "in")
    assert inside(root / "back" / "a", root, "back/a", "d:1") == root / "in" / "a"
    for name in ("out/etc", "in/../../x", "/etc/hostname"):
        with pytest.raises(DataError, match=r"^d:1: .* lies outside the root folder"):
            inside(root / name, root, name, "d:1")


def test_a_root_may_itself_be_a_link(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    root = root_folder(tmp_path / "link")
    assert inside(tmp_path / "link" / "a", root, "a", "d:1") == tmp_path / "real" / "a"


def test_all_files_count_together(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_text("0123456789")
    own = files(Limits(size=25))
    assert [contents(own, path, "d:1") for _ in range(2)] == ["0123456789"] * 2
    with pytest.raises(DataError, match="d:1: more than 25 bytes, the limit"):
        contents(own, path, "d:1")
    assert own.size == 20


def test_a_device_is_no_file() -> None:
    with pytest.raises(DataError, match="d:1: zero is no file"):
        contents(files(Limits()), Path("/dev/zero"), "d:1")


def test_a_byte_order_mark_is_no_text(tmp_path: Path) -> None:
    path = tmp_path / "a"
    path.write_bytes(b"\xef\xbb\xbftitle")
    assert contents(files(Limits()), path, "d:1") == "title"


def test_lines_are_counted() -> None:
    own = files(Limits(lines=4))
    count(own, "a\nb", "x")
    with pytest.raises(DataError, match="y:2: more than 4 lines, the limit"):
        count(own, "a\nb\nc", "y")
