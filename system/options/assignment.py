"""Options of the command line that set a named value, written as `NAME=VALUE`."""

from __future__ import annotations

from circuits.errors import ParameterError


def split_assignment(text: str, option: str, *, keep: bool = False) -> tuple[str, str]:
    """Split the text `NAME=VALUE` of an option into name and value.

    A hyphen in the name stands for an underscore, unless `keep` says that names stay as they are. Raises
    `ParameterError` for a text of another form.
    """
    name, sign, value = (part.strip() for part in text.partition("="))
    if not (name and sign and value):
        raise ParameterError(f'{option}: "{text}", must be NAME=VALUE; write as in `{option}=name=1.5`')
    return name if keep else name.replace("-", "_"), value
