"""The verb `noctule labs`, with its options."""

from __future__ import annotations

from dataclasses import dataclass

from system.cli import shared_options as shared
from system.option import option


@dataclass(frozen=True, slots=True, kw_only=True)
class Labs:
    """Give dies of the teaching chip to students. Check what one has extracted."""

    students: int | None = option(None, "Write a die and a sheet of answers for so many, into `output`")
    output: str | None = option(None, "Folder that is written", short="o", metavar="FOLDER")
    first: int = option(1000, "Die of the first student")
    check: str | None = shared.file_option("Check the die and the numbers in this TOML file")
    as_json: bool = shared.json_option()
