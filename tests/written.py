"""Files that tests write."""

from pathlib import Path


def written(path: Path, text: str) -> Path:
    """Write a text to a file, and give the file back."""
    path.write_text(text)
    return path
