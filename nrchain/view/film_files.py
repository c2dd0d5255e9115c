"""Films as files: MP4 by ffmpeg, GIF by Pillow; whole under their name, or not there at all."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from nrchain.errors import MissingLibraryError, SceneError, TrajectoryError
from nrchain.inputs.rules import number
from nrchain.run.interruption import cleanup_on_exit
from nrchain.trajectory.file import file_errors

FILMS = (".mp4", ".gif")

ENCODERS = {
    "libx264": ("-crf", "17", "-preset", "medium"),
    "libopenh264": ("-b:v", "6M"),
    "mpeg4": ("-q:v", "2"),
}
"""Encoders of MP4 by preference, with their options for good quality."""

FASTEST_GIF = 50.0
"""Most frames per second of a GIF: its times are in hundredths, and viewers slow down one."""

Add = Callable[[np.ndarray], None]
"""Appends an image (height, width, 3) of bytes to a film."""


def is_film(path: str | Path) -> bool:
    """Whether the ending of a path is that of a film."""
    return Path(path).suffix.lower() in FILMS


def check_film(path: Path, fps: float) -> None:
    """Raise an error if a film of that rate cannot be written, before any time is spent.

    :class:`~nrchain.errors.SceneError` for a rate out of range,
    :class:`~nrchain.errors.MissingLibraryError` for an MP4 where no ffmpeg is found, and
    :class:`~nrchain.errors.TrajectoryError` for a folder that does not exist.
    """
    gif = path.suffix.lower() == ".gif"
    most = FASTEST_GIF if gif else 240.0
    number(above=0, most=most, reason="a GIF has no shorter times" if gif else "")("fps", fps)
    if not gif:
        find_ffmpeg()
    check_folder(path)


def check_folder(path: Path) -> None:
    """Raise :class:`~nrchain.errors.TrajectoryError` if the folder of a file does not exist."""
    with file_errors(path, "cannot be drawn"):
        os.stat(path.parent)


def find_ffmpeg() -> str:
    """The program ffmpeg: the one on the path, or that of the package imageio-ffmpeg."""
    if found := shutil.which("ffmpeg"):
        return found
    try:
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    except (ImportError, RuntimeError) as error:
        raise MissingLibraryError(
            "an MP4 film needs the program ffmpeg: pip install imageio-ffmpeg, or apt install"
            " ffmpeg; a film that ends in .gif needs neither"
        ) from error


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A path beside ``path`` to write to; it gets its name at the end, and is removed on errors."""
    partial = path.with_name(f".{path.stem}.partial{path.suffix}")

    def remove() -> None:
        partial.unlink(missing_ok=True)

    with cleanup_on_exit(remove):
        try:
            yield partial
            os.replace(partial, path)
        except OSError:
            with file_errors(path, "cannot be drawn"):
                raise
        finally:
            remove()


def write_png(path: Path, image: np.ndarray) -> None:
    """Write an image (height, width, 3) of bytes; the file is whole, or not there at all."""
    from PIL import Image

    with whole_file(path) as partial:
        Image.fromarray(np.ascontiguousarray(image)).save(partial, format="PNG")


@contextmanager
def film_file(path: Path, fps: float) -> Iterator[Add]:
    """Write a film image by image; it is a whole file at the end, or none.

    Images of an MP4 lose a last row or column where their number is odd.
    """
    with whole_file(path) as partial:
        writer = (_gif if path.suffix.lower() == ".gif" else _mp4)(partial, fps)
        with writer as add:
            yield add


@contextmanager
def _mp4(path: Path, fps: float) -> Iterator[Add]:
    ffmpeg = find_ffmpeg()
    encoder = _encoder(ffmpeg)
    running: list[subprocess.Popen[bytes]] = []

    def end() -> None:
        for process in running:
            process.kill()
            process.wait()

    with tempfile.TemporaryFile() as words, cleanup_on_exit(end):

        def add(image: np.ndarray) -> None:
            height, width = (side - side % 2 for side in image.shape[:2])
            if not running:
                command = [
                    *(ffmpeg, "-y", "-loglevel", "error"),
                    *("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}"),
                    *("-r", f"{fps:g}", "-i", "-", "-an", "-c:v", encoder, *ENCODERS[encoder]),
                    *("-pix_fmt", "yuv420p", "-movflags", "+faststart", str(path)),
                ]
                streams: Any = {"stdout": subprocess.DEVNULL, "stderr": words}
                # no buffer: what an interrupted film has not written needs no reader
                process = subprocess.Popen(command, stdin=subprocess.PIPE, bufsize=0, **streams)
                running.append(process)
            rest = memoryview(image[:height, :width].tobytes())
            stream: Any = running[0].stdin
            try:
                while rest:
                    rest = rest[stream.write(rest) :]
            except BrokenPipeError as error:
                raise _failure(running[0], words) from error

        try:
            yield add
            for process in running:
                process.communicate()
                if process.returncode:
                    raise _failure(process, words)
        finally:
            end()
            for process in running:
                if process.stdin is not None:
                    process.stdin.close()


def _failure(process: subprocess.Popen[bytes], words: Any) -> TrajectoryError:
    process.wait()
    words.seek(0)
    said = " ".join(words.read().decode(errors="replace").split())
    return TrajectoryError(f"ffmpeg ended with code {process.returncode}: {said[:300]}")


def _encoder(ffmpeg: str) -> str:
    """The best encoder of MP4 that this ffmpeg has."""
    asked = [ffmpeg, "-hide_banner", "-loglevel", "error", "-encoders"]
    listed = subprocess.run(asked, capture_output=True, text=True, check=False).stdout.split()
    for name in ENCODERS:
        if name in listed:
            return name
    raise MissingLibraryError(
        f"{ffmpeg} has none of the encoders {', '.join(ENCODERS)}: pip install imageio-ffmpeg,"
        " or write a .gif"
    )


@contextmanager
def _gif(path: Path, fps: float) -> Iterator[Add]:
    from PIL import Image

    images: list[Any] = []

    def add(image: np.ndarray) -> None:
        whole = Image.fromarray(np.ascontiguousarray(image))
        images.append(
            whole.quantize(256, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
        )

    yield add
    if not images:
        raise SceneError("frames", 0, "must be at least 1")
    # the times of frames add up to the rate asked for: each is a whole number of hundredths
    ends = np.rint(100 * np.arange(len(images) + 1) / fps).astype(int)
    durations = [10 * int(one) for one in np.diff(ends)]
    images[0].save(
        path, format="GIF", save_all=True, append_images=images[1:], duration=durations, loop=0
    )
