"""Pictures and films in three dimensions, drawn by VTK in a process of its own.

VTK ends its process where OpenGL fails, and takes seconds to start: one process draws everything
that the tests look at.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from support.films import assert_film, growing, read_gif, read_mp4
from support.pictures import assert_looks_like

import nrchain
from nrchain.errors import MissingLibraryError, SceneError, TrajectoryError
from nrchain.view.space import opengl
from nrchain.view.space.colouring import colouring
from nrchain.view.space.opengl import require_display, require_opengl

PROGRAM = """
import json, sys
from support import process_state
from support.films import growing
import pyvista
import nrchain
from nrchain.cli.app import main
from nrchain.trajectory.block import Block
from nrchain.trajectory.writer import TrajectoryWriter

folder = sys.argv[1]
theme = json.dumps(pyvista.global_theme.to_dict(), default=str)
chain = growing()
# the libraries are loaded, which add to the filters of warnings
nrchain.render(chain, f"{folder}/plain.png", size=(320, 180))
ranges = {}


class Recorded(pyvista.Plotter):
    def close(self):
        bars = [bar.GetLookupTable().GetRange() for bar in self.scalar_bars.values()]
        ranges.setdefault("all", []).append(bars)
        super().close()


before = process_state.state()
plotter, pyvista.Plotter = pyvista.Plotter, Recorded
for name, options in {
    "first.png": {"snapshot": 0},
    "tracers.png": {"tracers": 60, "colour": "effect:slip 2s", "tube": False},
    "above.png": {"view": "z", "frames": False, "tube": False},
    "bend.png": {"colour": "bend"},
        "slip.png": {"colour": "effect:slip 2s"},
    "spin.gif": {"times": 4, "fps": 5.0, "colour": "spin", "follow": True},
}.items():
    nrchain.render(chain, f"{folder}/{name}", size=(320, 180), **options)
pyvista.Plotter = plotter
json.dump(ranges["all"], open(f"{folder}/ranges.json", "w"))
after = process_state.state()
assert not process_state.changes(before, after), process_state.changes(before, after)
assert json.dumps(pyvista.global_theme.to_dict(), default=str) == theme
with TrajectoryWriter(f"{folder}/run.h5", chain.scene, chain.time) as writer:
    for index, time in enumerate(chain.time):
        writer.write(index, Block.of_one(time, chain.positions[index], chain.frames[index], index))
    writer.close("completed", "")
sys.argv = ["nrchain", "render", f"{folder}/run.h5", "-o", f"{folder}/film.mp4", "--times", "5"]
sys.argv += ["--size", "320x180", "--spacing", "logarithmic", "--fps", "10"]
sys.argv += ["--json"]
main()
"""


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """The folder of all pictures and films."""
    try:
        require_opengl()
    except MissingLibraryError as error:
        pytest.skip(str(error))
    folder = tmp_path_factory.mktemp("drawn")
    command = [sys.executable, "-c", PROGRAM, str(folder)]
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    environment["PYTHONPATH"] = str(Path(__file__).parents[2])
    ended = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert ended.returncode == 0, ended.stderr
    assert json.loads(ended.stdout) == {"picture": str(folder / "film.mp4")}
    assert ended.stderr == ""
    return folder


def picture(folder, name):
    with Image.open(folder / name) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def is_ink(image):
    return image.min(axis=-1) < 200


def test_pictures_have_their_size_and_are_not_blank(drawn):
    names = [path.name for path in drawn.glob("*.png")]
    assert len(names) == 6
    for name in names:
        image = picture(drawn, name)
        assert image.shape == (180, 320, 3)
        assert 0.005 < is_ink(image).mean() < 0.5


def test_what_is_asked_for_is_seen(drawn):
    plain = picture(drawn, "plain.png")
    for name in ("first.png", "above.png", "bend.png", "tracers.png"):
        assert np.mean(np.abs(picture(drawn, name) - plain).max(axis=-1) > 60) > 2e-3, name


@pytest.mark.parametrize("name", ["plain", "slip", "above", "first"])
def test_pictures_look_as_they_did(drawn, name):
    assert_looks_like(drawn / f"{name}.png", f"space-{name}")


def test_the_chain_is_drawn_to_scale(drawn):
    """Seen from above, six spheres of radius 1 stand at every 10 along x."""
    image = picture(drawn, "above.png")
    blue = (image[..., 2] - image[..., 0] > 15)[20:150]
    columns = np.flatnonzero(blue.any(axis=0))
    groups = np.split(columns, np.flatnonzero(np.diff(columns) > 2) + 1)
    assert len(groups) == 6
    middles = np.array([(group[0] + group[-1]) / 2 for group in groups])
    gaps = np.diff(middles)
    assert gaps == pytest.approx(np.full(5, gaps.mean()), rel=0.06)
    sizes = np.array([len(group) for group in groups])
    assert sizes.mean() / gaps.mean() == pytest.approx(2.0 / 10.0, rel=0.2)


def test_a_colour_is_that_of_its_map(drawn):
    """The chain moves and does not bend: slip is coloured, bends have the lowest colour."""
    for name, most in (("bend.png", 0.0), ("slip.png", 1.0)):
        image = picture(drawn, name)[20:140]
        yellow = (image[..., 0] > 150) & (image[..., 1] > 130) & (image[..., 2] < 100)
        assert (yellow.mean() > 1e-4) == (most == 1.0), name


def test_the_bar_shows_the_limits_of_the_quantity(drawn):
    shown = json.loads((drawn / "ranges.json").read_text())
    chain = growing()
    last = [colouring(chain[-1:], name).limits for name in ("bend", "effect:slip 2s")]
    expected = [[], [last[1]], [], [last[0]], [last[1]]]
    for bars, limits in zip(shown[:5], expected, strict=True):
        assert [tuple(bar) for bar in bars] == [pytest.approx(one) for one in limits]


def test_films_have_their_frames(drawn):
    frames, lasted = read_gif(drawn / "spin.gif")
    assert frames.shape == (4, 180, 320, 3)
    assert lasted == 800
    assert_film(frames, 4)
    frames, rate = read_mp4(drawn / "film.mp4")
    assert frames.shape == (5, 180, 320, 3)
    assert rate == 10.0
    assert_film(frames, 5)


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("a.pdf", {}, "must end in one of .png, .mp4, .gif"),
        ("a.png", {"view": "top"}, "view = 'top'"),
        ("a.png", {"size": (10, 10)}, "size = .*from 64 to 8192 each"),
        ("a.png", {"size": 300}, "size = 300"),
        ("a.png", {"snapshot": 6}, "snapshot = 6: must be a whole number from -6 to 5"),
        ("a.gif", {"times": 7}, "times = 7: there are 6 snapshots"),
        ("a.gif", {"fps": 0}, "fps = 0"),
        ("a.png", {"colour": "red"}, "colour = 'red'"),
        ("a.png", {"colour": "bend", "tube": False}, "colour = 'bend': colours the centreline"),
    ],
)
def test_what_cannot_be_drawn_is_refused(tmp_path, name, options, message):
    with pytest.raises(SceneError, match=message):
        nrchain.render(growing(), tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_an_existing_picture_is_kept(tmp_path):
    (tmp_path / "a.png").write_bytes(b"dear")
    with pytest.raises(TrajectoryError, match="exists"):
        nrchain.render(growing(), tmp_path / "a.png")
    assert (tmp_path / "a.png").read_bytes() == b"dear"


def test_without_opengl_an_error_names_the_packages(tmp_path, monkeypatch):
    monkeypatch.setattr(opengl, "_egl_works", lambda: False)
    monkeypatch.setattr(opengl, "_loads", lambda library: False)
    with pytest.raises(MissingLibraryError, match="apt install libegl1 libgl1-mesa-dri"):
        nrchain.render(growing(), tmp_path / "a.png")


def test_without_pyvista_an_error_names_the_extra(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(MissingLibraryError, match=r"pip install 'nrchain\[view\]'"):
        nrchain.render(growing(), tmp_path / "a.png")


def test_without_a_display_no_window_opens(monkeypatch):
    monkeypatch.setattr(opengl, "_display_opens", lambda: False)
    monkeypatch.delenv("DISPLAY", raising=False)
    with pytest.raises(MissingLibraryError, match="DISPLAY is not set; without one, write a file"):
        require_display()
    monkeypatch.setenv("DISPLAY", ":77")
    with pytest.raises(MissingLibraryError, match="DISPLAY = ':77' is none"):
        require_display()
