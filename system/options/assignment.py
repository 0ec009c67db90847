"""`NAME=VALUE` of the command line."""

from __future__ import annotations

from circuits.errors import ParameterError


def split_assignment(text: str, option: str, *, keep: bool = False) -> tuple[str, str]:
    """Split `NAME=VALUE`; a hyphen in a name stands for an underscore unless names are kept."""
    name, sign, value = (part.strip() for part in text.partition("="))
    if not (name and sign and value):
        raise ParameterError(f'{option}: "{text}", must be NAME=VALUE; write as in `{option}=name=1.5`')
    return name if keep else name.replace("-", "_"), value
