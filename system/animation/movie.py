"""Files of moving pictures: a .gif by Pillow, a .mp4 or .webm by ffmpeg through imageio-ffmpeg."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from PIL import Image

from circuits.catalogue import extra
from circuits.errors import DataError, ParameterError
from system.animation.frame import Pixels, begin_reel
from system.files.writing import check_folder, checked_suffix, replace_atomic
from system.system import Progress
from system.view.film import Film

GIF = ".gif"
SUFFIXES = (GIF, ".mp4", ".webm")
LEAST = 5.0  # s that a film takes at its own speed; a shorter run is shown more slowly. Ours
_FORM = re.compile(r"(\d{2,4})x(\d{2,4})@(\d{1,3})(?:x(\d+(?:\.\d+)?))?")
_SMALLEST = 480, 360  # pixels in which world, camera and five panels have room
_COLOURS = 128  # of a .gif
_CODECS = {  # and what makes them quick enough
    ".mp4": ("libx264", ["-preset", "veryfast"]),
    ".webm": ("libvpx-vp9", ["-deadline", "realtime", "-cpu-used", "8", "-row-mt", "1"]),
}


@dataclass(frozen=True, slots=True)
class Frames:
    """Size of frames in pixels, how many there are in a second, and how much faster than the run they go.

    speed: None for that of the run, or a slower one where it is shorter than `LEAST`.
    """

    width: int = 960
    height: int = 720
    rate: int = 20
    speed: float | None = None

    def speed_of(self, film: Film) -> float:
        """How much faster than the run a film goes."""
        return self.speed or min(1.0, film.duration / LEAST)


def read_frames(text: str) -> Frames:
    """Read `WIDTHxHEIGHT@RATE`, or `WIDTHxHEIGHT@RATExSPEED`; raises `ParameterError` for another text."""
    found = _FORM.fullmatch(text)
    if found is None:
        raise ParameterError(f'frames: "{text}", must be WIDTHxHEIGHT@RATE, as 960x720@20, or 960x720@20x4')
    width, height, rate = (int(each) for each in found.groups()[:3])
    speed = None if found[4] is None else float(found[4])
    for name, value, least in (("width", width, _SMALLEST[0]), ("height", height, _SMALLEST[1])):
        if value % 2 or value < least:
            raise ParameterError(f"frames: {name} {value}, must be even and at least {least}")
    if not 1 <= rate <= 60 or speed == 0.0:
        raise ParameterError(f'frames: "{text}", must have 1 to 60 frames a second and a speed above 0')
    return Frames(width, height, rate, speed)


def check_animation(path: str, frames: Frames) -> None:
    """Raise before anything is computed if no animation can be written to `path`.

    Raises `ParameterError` for another suffix and for a rate that its format cannot have, `DataError` where
    there is no such folder, `SimulatorError` where ffmpeg is needed and is not there.
    """
    suffix = checked_suffix(path, SUFFIXES)
    check_folder(path)
    if suffix == GIF and 100 % frames.rate:
        raise ParameterError(
            f"frames: {frames.rate} a second, a .gif counts in hundredths of one; give 10, 20, 25 or 50"
        )
    if suffix != GIF:
        _ffmpeg(path)


def save_animation(path: str, film: Film, frames: Frames, progress: Progress) -> int:
    """Write a film as a moving picture; returns how many frames there are.

    progress: is told the share of the frames that are written. Raises as `check_animation`, and `DataError`
    where ffmpeg fails.
    """
    check_animation(path, frames)
    speed = frames.speed_of(film)
    count = max(1, math.ceil(film.duration / speed * frames.rate)) + 1
    reel = begin_reel(film, frames.width, frames.height, speed)

    def pictures() -> Iterator[Pixels]:
        for k in range(count):
            yield reel.frame(min(film.duration, k * speed / frames.rate))
            progress((k + 1) / count)

    with replace_atomic(path) as unfinished:
        (_write_gif if unfinished.suffix.lower() == GIF else _write_video)(unfinished, pictures(), frames)
    return count


def _write_gif(path: Path, pictures: Iterator[Pixels], frames: Frames) -> None:
    first = Image.fromarray(next(pictures))
    palette = first.quantize(_COLOURS, dither=Image.Dither.NONE)
    rest = (Image.fromarray(p).quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures)
    palette.save(path, format="GIF", save_all=True, append_images=rest, duration=1000 // frames.rate, loop=0)


def _write_video(path: Path, pictures: Iterator[Pixels], frames: Frames) -> None:
    codec, options = _CODECS[path.suffix.lower()]
    writer = _ffmpeg(str(path)).write_frames(
        str(path), (frames.width, frames.height), fps=frames.rate, codec=codec, quality=7,
        macro_block_size=2, ffmpeg_log_level="error", output_params=options,
    )  # fmt: skip
    try:
        writer.send(None)
        for picture in pictures:
            writer.send(picture.tobytes())
        writer.close()
    except OSError as error:
        raise DataError(f"{path.name}: ffmpeg failed ({' '.join(str(error).split())[:200]})") from None


def _ffmpeg(path: str) -> Any:
    told = f"imageio-ffmpeg: not installed, {path} needs it; pip install imageio-ffmpeg, or write a .gif"
    return extra("imageio_ffmpeg", told)
