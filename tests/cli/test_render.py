"""``nrchain render`` and films by ``nrchain plot``: what they write, and what they refuse.

Pictures in three dimensions are drawn, through this command too, in ``tests/view/space``.
"""

import pytest
from support.command_line import SMALL, assert_refused, call
from support.films import read_gif

from nrchain.view.space import opengl


@pytest.fixture
def run(tmp_path, stub, blank_pictures):
    assert call("run", "passive", "-o", tmp_path / "run", *SMALL).exit_code == 0
    return tmp_path / "run"


def test_plot_draws_a_film(run, tmp_path):
    path = tmp_path / "film.gif"
    done = call("plot", run, "-o", path, "--times", "2", "--width", "400", "--fps", "5")
    assert done.exit_code == 0, done.stderr
    assert done.stdout.strip() == str(path)
    frames, lasted = read_gif(path)
    # the two snapshots differ by their time
    assert frames.shape[0] == 2
    assert lasted == 400
    assert_refused(call("plot", run, "-o", path), path, "--overwrite")
    assert call("plot", run, "-o", path, "--overwrite", "--no-title").exit_code == 0


@pytest.mark.parametrize(
    ("options", "parts"),
    [
        (("-o", "a.gif", "--spheres", "scale"), ("--spheres = 'scale'", "pictures")),
        (("-o", "a.gif", "--effects"), ("--effects", "pictures")),
        (("-o", "a.gif", "--times", "3"), ("times = 3", "there are 2 snapshots")),
        (("--fps", "5"), ("--fps = 5.0", ".mp4 or .gif")),
        (("-o", "a.png", "--width", "500"), ("--width = 500", ".mp4 or .gif")),
    ],
)
def test_options_of_films_and_of_pictures_are_not_mixed(run, options, parts, monkeypatch):
    monkeypatch.chdir(run)
    assert_refused(call("plot", run, *options), *parts)


@pytest.mark.parametrize(
    ("options", "parts"),
    [
        (("-o", "a.png", "--times", "2"), ("--times = 2", ".mp4 or .gif")),
        (("-o", "a.gif", "--snapshot", "0"), ("--snapshot = 0", "a PNG")),
        (("-o", "a.gif", "--show"), ("--show", "a window and a file are two commands")),
        (("--size", "big"), ("--size = 'big'", "WIDTHxHEIGHT")),
        (("--size", "10x10"), ("size = (10, 10)", "64 to 8192")),
        (("--view", "top"), ("view = 'top'", "slant, x, y, z")),
        (("--colour", "effect:wind"), ("colour = 'effect:wind'", "effect:bend")),
        (("-o", "a.svg"), (".png, .mp4, .gif",)),
    ],
)
def test_render_refuses_what_it_cannot_draw(run, options, parts, monkeypatch):
    monkeypatch.chdir(run)
    assert_refused(call("render", run, *options), *parts)
    assert not (run / "space.png").exists()


def test_render_does_not_replace_a_named_picture(run, tmp_path):
    mine = tmp_path / "mine.png"
    mine.write_bytes(b"dear")
    assert_refused(call("render", run, "-o", mine), mine, "--overwrite")
    assert mine.read_bytes() == b"dear"


def test_render_says_which_packages_are_missing(run, monkeypatch):
    monkeypatch.setattr(opengl, "_egl_works", lambda: False)
    monkeypatch.setattr(opengl, "_loads", lambda library: False)
    assert_refused(call("render", run), "apt install libegl1 libgl1-mesa-dri")
    monkeypatch.setattr(opengl, "_display_opens", lambda: False)
    assert_refused(call("render", run, "--show"), "needs a display")
