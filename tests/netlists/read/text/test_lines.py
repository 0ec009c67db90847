"""Lines to cards, and files inside their root."""

from pathlib import Path

import pytest

from circuits.errors import DataError
from netlists.read.limits import DEFAULT_LIMITS, Limits
from netlists.read.note import Notes
from netlists.read.text.lines import Text, read_text


def read(source: Path | str, root: Path | None = None, limits: Limits = DEFAULT_LIMITS) -> Text:
    return read_text(source, root, limits, Notes())


def texts(source: Path | str) -> list[str]:
    return [card.text for card in read(source).cards]


def test_the_first_line_is_the_title() -> None:
    text = read("r1 a b 1\nr2 a b 2\n")
    assert text.title == "r1 a b 1"
    assert [card.text for card in text.cards] == ["r2 a b 2"]


def test_a_title_that_looks_like_a_card_is_noted() -> None:
    notes = Notes()
    read_text(".subckt a b\nr1 b 0 1\n", None, Limits(), notes)
    assert "looks like a card" in notes.all()[0].what


def test_comments_and_continuations() -> None:
    assert texts("t\n* c\nr1 a b ; x\n\n  + 1k $ y\nc1 a b 1p // z\n+ic=0\n* end") == [
        "r1 a b 1k",
        "c1 a b 1p ic=0",
    ]


def test_a_card_has_the_line_where_it_begins() -> None:
    cards = read("t\n\nr1 a b\n* c\n+ 1k\nr2 a b 1\r\n").cards
    assert [(card.text, card.line) for card in cards] == [("r1 a b 1k", 3), ("r2 a b 1", 6)]


def test_a_structured_comment_is_a_card_and_continues_itself() -> None:
    assert texts("t\n*% port a\n*%+ kind=supply\nr1 a b 1") == ["*% port a kind=supply", "r1 a b 1"]


@pytest.mark.parametrize("text", ["t\n+ 1", "t\nr1 a b 1\n*%+ x", "t\n*% port a\n+ x"])
def test_a_continuation_of_nothing_is_refused(text: str) -> None:
    with pytest.raises(DataError, match=r"netlist:\d: \+ continues nothing"):
        read(text)


def test_what_stands_behind_the_end_is_noted() -> None:
    notes = Notes()
    text = read_text("t\nr1 a b 1\n.end\nr2 a b 1\nr3 a b 1", None, Limits(), notes)
    assert len(text.cards) == 1
    assert notes.all()[0].count == 2


def test_commands_are_never_run_but_noted() -> None:
    notes = Notes()
    text = read_text("t\n.control\nshell touch x\nrun\n.endc\nr1 a b 1", None, Limits(), notes)
    assert [card.text for card in text.cards] == ["r1 a b 1"]
    assert (notes.all()[0].count, "never run" in notes.all()[0].what) == (2, True)
    with pytest.raises(DataError, match=r"netlist:2: \.control without \.endc"):
        read("t\n.control\nrun")


@pytest.fixture
def root(tmp_path: Path) -> Path:
    folder = tmp_path / "root"
    (folder / "sub").mkdir(parents=True)
    (folder / "r.inc").write_text("r1 a b 1\n")
    (folder / "sub" / "s.inc").write_text(".include ../r.inc\n")
    (folder / "m.lib").write_text(".lib tt\nr2 a b 2\n.endl tt\n.lib ff\nr2 a b 3\n.endl\n")
    (tmp_path / "outside.inc").write_text("r9 a b 9\n")
    (folder / "link.inc").symlink_to(tmp_path / "outside.inc")
    (folder / "loop.inc").write_text(".include loop.inc\n")
    (folder / "round.inc").symlink_to(folder / "round.inc")
    return folder


def deck(root: Path, line: str) -> Path:
    path = root / "deck.cir"
    path.write_text(f"title\n{line}\nr0 a b 0\n")
    return path


@pytest.mark.parametrize(
    ("line", "first"),
    [
        (".include r.inc", "r1 a b 1"),
        (".INC 'r.inc'", "r1 a b 1"),
        ('.include "sub/s.inc"', "r1 a b 1"),
        (".include sub/../r.inc", "r1 a b 1"),
        (".lib m.lib tt", "r2 a b 2"),
        (".lib 'm.lib' FF", "r2 a b 3"),
    ],
)
def test_files_are_included_in_their_place(root: Path, line: str, first: str) -> None:
    assert texts(deck(root, line)) == [first, "r0 a b 0"]


def test_a_card_names_its_own_file(root: Path) -> None:
    card = read(deck(root, ".include r.inc")).cards[0]
    assert card.place == "r.inc:1"


@pytest.mark.parametrize(
    ("line", "says"),
    [
        (".include ../outside.inc", "outside the root folder"),
        (".include /etc/hostname", "outside the root folder"),
        (".include link.inc", "outside the root folder"),
        (".include loop.inc", "cycle of includes"),
        (".include deck.cir", "cycle of includes"),
        (".include round.inc", "no such file|outside|Symlink|Too many"),
        (".include sub", "is no file"),
        (".include none.inc", "No such file"),
        (".include", "must be one file"),
        (".include a b", "must be one file"),
        (".includes a", "unknown card"),
        (".lib m.lib ss", "section ss: not in the file"),
        (f".include {'a' * 300}", "too long"),
    ],
)
def test_a_file_that_cannot_be_included_is_refused(root: Path, line: str, says: str) -> None:
    with pytest.raises(DataError, match=rf"^(deck\.cir:2|loop\.inc:1): .*({says})"):
        read(deck(root, line))


def test_a_text_includes_nothing_without_a_root(root: Path) -> None:
    with pytest.raises(DataError, match="without a root folder"):
        read("t\n.include r.inc")
    assert [card.text for card in read("t\n.include r.inc", root).cards] == ["r1 a b 1"]


def test_the_file_itself_must_lie_in_the_root(root: Path) -> None:
    with pytest.raises(DataError, match="outside the root folder"):
        read(root.parent / "outside.inc", root)


def test_no_file(root: Path) -> None:
    with pytest.raises(DataError, match=r"^sub is no file"):
        read(root / "sub")
    with pytest.raises(DataError, match=r"^none\.cir: No such file or directory; check the file$"):
        read(root / "none.cir")
    with pytest.raises(DataError, match="no folder"):
        read(root / "deck.cir", root / "none")


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "bad.cir:1: empty"),
        (b" \n\n", "bad.cir:1: empty"),
        (b"t\nr1 a\x00b 1\n", "bad.cir:2: control character"),
        (b"t\nr1 a 0 1\n\x1ar2 b 0 1\n", "bad.cir:3: control character"),
    ],
)
def test_what_is_no_text_is_refused(tmp_path: Path, data: bytes, says: str) -> None:
    path = tmp_path / "bad.cir"
    path.write_bytes(data)
    with pytest.raises(DataError, match=says):
        read(path)


def test_the_character_that_ends_a_file_of_dos_ends_it(tmp_path: Path) -> None:
    path = tmp_path / "vendor.lib"
    path.write_bytes(b"a library\r\nr1 a 0 1\r\n.ENDS\r\n\x1a\r\n")
    assert [card.text for card in read(path).cards] == ["r1 a 0 1", ".ENDS"]


@pytest.mark.parametrize(
    ("limits", "says"),
    [
        (Limits(lines=3), r"bad.cir:3: more than 3 lines, the limit"),
        (Limits(size=20), r"bad.cir:1: more than 20 bytes, the limit"),
        (Limits(card=10), r"bad.cir:2: more than 10 characters, a card's limit"),
    ],
)
def test_limits_are_named(tmp_path: Path, limits: Limits, says: str) -> None:
    path = tmp_path / "bad.cir"
    path.write_text("t\nr1 a b\n+ 1000000\nr2 a b 1\n")
    with pytest.raises(DataError, match=says):
        read(path, limits=limits)


def test_files_and_their_depth_have_a_limit(tmp_path: Path) -> None:
    for k in range(30):
        (tmp_path / f"f{k}.inc").write_text(f".include f{k + 1}.inc\n")
    path = tmp_path / "deep.cir"
    path.write_text("t\n.include f0.inc\n")
    with pytest.raises(DataError, match="deeper than 16, the limit"):
        read(path)
    path.write_text("t\n" + ".include r.inc\n" * 300)
    (tmp_path / "r.inc").write_text("* nothing\n")
    with pytest.raises(DataError, match=r"deep\.cir:201: more than 200 files, the limit"):
        read(path)


def test_a_text_in_latin_1_is_read_and_told(tmp_path: Path) -> None:
    path = tmp_path / "deck.cir"
    path.write_bytes(b"t\nr1 a b 1\n* 5 \xb5A\n")
    notes = Notes()
    assert [card.text for card in read_text(path, None, Limits(), notes).cards] == ["r1 a b 1"]
    assert str(notes.all()[0]) == "deck.cir:3: text that is no UTF-8, read as Latin-1"


def test_sections_of_a_library_that_call_each_other(tmp_path: Path) -> None:
    path = tmp_path / "deck.cir"
    path.write_text(
        "t\n.lib deck.cir fast\n.lib slow\n.include none\n.endl\n.lib fast\n.lib 'deck.cir' common\n"
        ".endl fast\n"
        ".lib common\nr1 a 0 1\n.endl\n.lib empty\n.endl\n"
    )
    assert [card.text for card in read(path).cards] == ["r1 a 0 1"]
    path.write_text("t\n.lib deck.cir a\n.lib a\n.lib deck.cir a\n.endl\n")
    with pytest.raises(DataError, match="a cycle of includes"):
        read(path)
    path.write_text("t\n.lib a\nr1 a 0 1\n")
    with pytest.raises(DataError, match=r"deck\.cir:2: .* no \.endl"):
        read(path)


def test_analyses_between_control_and_endc_are_cards_unless_a_script_makes_them() -> None:
    assert texts("t\n.control\nset x=1\ntran 1u 1m\nop\nac dec $x 1 1k\nplot v(a)\n.endc\nr1 a 0 1") == [
        ".tran 1u 1m",
        ".op",
        "r1 a 0 1",
    ]
