"""Film files: whole or not there, read by programs that are not ours."""

import signal
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image
from support.films import read_gif, read_mp4

from nrchain.errors import MissingLibraryError, SceneError, TrajectoryError
from nrchain.view import film_files
from nrchain.view.film_files import check_film, film_file, write_png


def images(count=4, height=48, width=64):
    """A dark square that moves over a light ground."""
    for number in range(count):
        image = np.full((height, width, 3), 240, np.uint8)
        image[10:30, 4 + 8 * number : 14 + 8 * number] = 20
        yield image


def test_an_mp4_has_the_images(tmp_path):
    path = tmp_path / "film.mp4"
    with film_file(path, 10.0) as add:
        for image in images(height=49):
            add(image)
    frames, rate = read_mp4(path)
    assert rate == 10.0
    assert len(frames) == 4
    for frame, image in zip(frames, images(), strict=True):
        assert np.abs(frame.astype(int) - image).mean() < 5.0
    assert [one.name for one in tmp_path.iterdir()] == ["film.mp4"]


@pytest.mark.parametrize("fps", [10.0, 30.0])
def test_a_gif_has_the_images_and_the_rate(tmp_path, fps):
    path = tmp_path / "film.gif"
    with film_file(path, fps) as add:
        for image in images():
            add(image)
    frames, lasted = read_gif(path)
    assert len(frames) == 4
    for frame, image in zip(frames, images(), strict=True):
        assert np.abs(frame.astype(int) - image).max() < 8
    assert lasted == pytest.approx(4000 / fps, abs=5)


def interrupted(path, error):
    """Write some images of a film, and then raise an error if there is one."""
    with film_file(path, 10.0) as add:
        for image in images():
            add(image)
        if error:
            raise error


@pytest.mark.parametrize("name", ["film.mp4", "film.gif"])
def test_an_interrupted_film_leaves_no_file(tmp_path, name):
    with pytest.raises(KeyboardInterrupt):
        interrupted(tmp_path / name, KeyboardInterrupt())
    assert not list(tmp_path.iterdir())


def test_an_interrupted_film_keeps_the_one_it_would_replace(tmp_path):
    path = tmp_path / "film.mp4"
    path.write_bytes(b"dear")
    with pytest.raises(ValueError, match="no more"):
        interrupted(path, ValueError("no more"))
    assert path.read_bytes() == b"dear"


def test_a_signal_leaves_no_half_film(tmp_path):
    program = """
import sys, time, pathlib, numpy as np
from nrchain.run.interruption import leave_on_signals
from nrchain.view.film_files import film_file
leave_on_signals()
with film_file(pathlib.Path(sys.argv[1]), 10.0) as add:
    for _ in range(40):
        add(np.random.default_rng(0).integers(0, 255, (240, 320, 3)).astype(np.uint8))
    print("half", flush=True)
    time.sleep(60)
"""
    command = [sys.executable, "-c", program, str(tmp_path / "film.mp4")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        assert process.stdout.readline() == b"half\n"
        process.send_signal(signal.SIGTERM)
        assert process.wait(timeout=30) == 130
    assert not list(tmp_path.iterdir())


def test_what_ffmpeg_says_is_reported(tmp_path, monkeypatch):
    monkeypatch.setitem(film_files.ENCODERS, "libx264", ("-crf", "nonsense"))
    with pytest.raises(TrajectoryError, match=r"ffmpeg ended with code .*nonsense"):
        interrupted(tmp_path / "film.mp4", None)
    assert not list(tmp_path.iterdir())


def test_without_ffmpeg_an_mp4_is_refused_and_a_gif_is_not(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(MissingLibraryError, match=r"pip install imageio-ffmpeg.*ends in .gif"):
        check_film(tmp_path / "film.mp4", 25.0)
    check_film(tmp_path / "film.gif", 25.0)


@pytest.mark.parametrize(
    ("name", "fps", "message"),
    [
        ("film.mp4", 0.0, "fps = 0.0: must be a finite number, above 0 and at most 240"),
        ("film.gif", 60.0, "fps = 60.0: .*at most 50: a GIF has no shorter times"),
    ],
)
def test_rates_out_of_range_are_refused(tmp_path, name, fps, message):
    with pytest.raises(SceneError, match=message):
        check_film(tmp_path / name, fps)


def test_a_folder_that_does_not_exist_is_refused(tmp_path):
    with pytest.raises(TrajectoryError, match="No such file"):
        check_film(tmp_path / "no" / "film.gif", 25.0)


def test_a_png_has_the_image(tmp_path):
    path = tmp_path / "one.png"
    write_png(path, next(images()))
    with Image.open(path) as image:
        assert np.array_equal(np.asarray(image), next(images()))
    assert len(list(tmp_path.iterdir())) == 1
