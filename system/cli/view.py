"""The verb `noctule view`: a page or a moving picture of a kept run, or a page of two beside each other."""

from __future__ import annotations

import shlex
import sys
import webbrowser
from pathlib import Path

from circuits.errors import ParameterError
from system.animation.movie import SUFFIXES as MOVING
from system.animation.movie import Frames, read_frames, save_animation
from system.cli.output import print_json, print_line, progress_bar
from system.cli.verbs import View
from system.files.writing import check_folder, checked_suffix
from system.view.film import Film
from system.view.kept import keep, kept
from system.view.page import write_page

PAGE, RUN = ".html", ".nc"


def view_command(asked: View) -> None:
    """Write the page of kept runs, and show it in the browser if asked to."""
    moving = Path(asked.output).suffix.lower() in MOVING
    frames = read_frames(asked.frames)
    if not moving:
        check_page(asked.output, (PAGE, *MOVING))
    elif asked.beside is not None:
        raise ParameterError(f"beside: {asked.beside}, no moving picture has two runs; write a {PAGE}")
    films = [kept(path) for path in (asked.run, asked.beside) if path is not None]
    if moving:
        animate(asked.output, films[0], frames)
    else:
        write_page(asked.output, films)
    size = Path(asked.output).stat().st_size
    if asked.as_json:
        runs = [{"title": f.title, "headline": f.headline, "duration_s": f.duration} for f in films]
        print_json({"page": asked.output, "bytes": size, "runs": runs})
    else:
        print_line(f"{asked.output}: {size / 1e6:.2f} MB")
    if asked.open and not webbrowser.open(Path(asked.output).resolve().as_uri()):
        raise ParameterError(f"open: there is no browser; open {asked.output} where there is one")


def check_page(path: str, suffixes: tuple[str, ...] = (PAGE,)) -> None:
    """Raise `ParameterError` or `DataError` for a path that no page, or nothing with `suffixes`, can have."""
    checked_suffix(path, suffixes)
    check_folder(path)


def check_run(path: str) -> None:
    """Raise `ParameterError` or `DataError` for what cannot be the path of a kept run."""
    checked_suffix(path, (RUN,))
    check_folder(path)


def animate(path: str, film: Film, frames: Frames) -> None:
    """Write a film as a moving picture, while a person at a terminal sees how far it is."""
    with progress_bar(path) as progress:
        save_animation(path, film, frames, progress)


def leave(film: Film, page: str | None, run: str | None) -> None:
    """Write the page and the kept run of a film where they are asked for."""
    if page is not None:
        write_page(page, [film])
    if run is not None:
        keep(run, film)


def this_command() -> str:
    """Return the command line that runs now."""
    return shlex.join(["noctule", *sys.argv[1:]])
