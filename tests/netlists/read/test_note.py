"""Notes on what was not taken over."""

from netlists.read.note import Note, Notes


def test_equal_notes_are_counted_under_the_first_place() -> None:
    notes = Notes()
    notes.add("option gmin", "a.cir:3")
    notes.add(".save card", "a.cir:4")
    notes.add("option gmin", "a.cir:9", 2)
    notes.add("nothing", "a.cir:9", 0)
    assert notes.all() == (Note("option gmin", "a.cir:3", 3), Note(".save card", "a.cir:4"))
    assert [str(note) for note in notes.all()] == ["a.cir:3: option gmin (3 times)", "a.cir:4: .save card"]
