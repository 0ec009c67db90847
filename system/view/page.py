"""A page that plays one film, or two beside each other: one file that asks no host for anything."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from importlib.resources import files
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from circuits.errors import ParameterError
from system.files.writing import replace_atomic
from system.view.arrays import Arrays
from system.view.film import Film

LARGEST = 15_000_000
"""Bytes that a page may have; ours, what a mail still takes."""
MOST = 2  # films of a page


def write_page(path: str, films: Sequence[Film]) -> None:
    """Write a page of one or two films.

    Parameters
    ----------
    path
        File to write, which ends with .html.
    films
        What it plays, at the same time where there are two.

    Raises
    ------
    ParameterError
        There is no film or more than two, or the page would be larger than `LARGEST`.
    """
    text = page(films)
    size = len(text.encode())
    if size > LARGEST:
        raise ParameterError(
            f"{path}: the page would have {size / 1e6:.3g} MB, must be at most {LARGEST / 1e6:.3g} MB;"
            " give a shorter duration"
        )
    with replace_atomic(path) as unfinished:
        unfinished.write_text(text, encoding="utf-8")


def tokens() -> str:
    """Return the colours of every page in CSS, as variables, in light and in dark."""
    return files("system.view").joinpath("tokens.css").read_text("utf-8")


def page(films: Sequence[Film]) -> str:
    """Return the page of one or two films as HTML text."""
    if not 1 <= len(films) <= MOST:
        raise ParameterError(f"films: {len(films)}, must be one or two")
    arrays = Arrays()
    document = json.dumps([plain(film, arrays) for film in films], allow_nan=False)
    environment = Environment(
        loader=PackageLoader("system.view", "."), autoescape=True, undefined=StrictUndefined
    )
    here = files("system.view")
    return environment.get_template("template.html").render(
        title=" and ".join(film.title for film in films),
        style=tokens() + here.joinpath("style.css").read_text("utf-8"),
        schematic=here.joinpath("schematic.js").read_text("utf-8"),
        player=here.joinpath("player.js").read_text("utf-8"),
        # a text in a script ends at the first "</"
        document=document.replace("</", "<\\/"),
        arrays=arrays.text(),
    )


def plain(value: Any, arrays: Arrays) -> Any:
    """Return what JSON holds of a film or a part of it; its arrays go into `arrays`."""
    if isinstance(value, np.ndarray):
        return arrays.add(value)
    if is_dataclass(value):
        return {f.name: plain(getattr(value, f.name), arrays) for f in fields(value)}
    if isinstance(value, tuple | list):
        return [plain(item, arrays) for item in value]
    if isinstance(value, dict):
        return {str(key): plain(item, arrays) for key, item in value.items()}
    return value
