"""Films by matplotlib: the frames asked for, a chain that moves, a process left as it was."""

import numpy as np
import pytest
from support import process_state
from support.films import assert_film, growing, read_gif, read_mp4
from support.pictures import assert_looks_like

import nrchain
from nrchain.errors import NrchainError, SceneError, TrajectoryError
from nrchain.view.film_files import write_png
from nrchain.view.film_panels import planes_panels


@pytest.mark.parametrize("view", ["planes", "3d"])
def test_a_film_has_the_frames_asked_for(tmp_path, view):
    seen = []
    path = nrchain.film(
        growing(),
        tmp_path / "film.gif",
        view=view,
        times=5,
        fps=10.0,
        progress=lambda done, total: seen.append((done, total)),
    )
    frames, lasted = read_gif(path)
    assert_film(frames, 5)
    assert frames.shape[2] == 1000
    assert lasted == 500
    assert seen == [(n, 5) for n in range(1, 6)]
    write_png(tmp_path / "last.png", frames[-1])
    assert_looks_like(tmp_path / "last.png", f"film-{view}")


@pytest.mark.parametrize(("width", "words"), [(1.0, ["start", "e₂"]), (1e-3, ["start"])])
def test_the_key_names_what_is_drawn(width, words):
    """Lines along e₂ are drawn where the chain is not stretched."""
    chain = growing().positions * np.array([1.0, width, 1.0])
    panels = planes_panels(chain, 4.0)
    panels.write_key()
    (key,) = panels.figure.legends
    assert [text.get_text() for text in key.get_texts()] == words


def test_an_mp4_is_as_wide_as_asked_for(tmp_path):
    path = nrchain.film(growing(), tmp_path / "film.mp4", width=480, fps=5.0, spacing="logarithmic")
    frames, rate = read_mp4(path)
    assert_film(frames, 6)
    assert frames.shape[2] == 480
    assert rate == 5.0


def test_the_chain_is_where_its_poses_are(tmp_path):
    """The middle sphere of three is the highest of the plane xy, and half way along it."""
    path = nrchain.film(growing(particles=3), tmp_path / "film.gif", times=1)
    last = read_gif(path)[0][-1].astype(int)
    chain = (last[..., 2] - last[..., 0] > 60)[:, :600]
    rows, columns = np.nonzero(chain)
    top = columns[rows == rows.min()].mean()
    assert top == pytest.approx((columns.min() + columns.max()) / 2, abs=8)


@pytest.mark.parametrize(
    "example",
    [
        growing(particles=2),
        growing(particles=300, snapshots=2),
        growing(snapshots=1),
        growing(title="鎖 $5"),
    ],
    ids=["two spheres", "long", "one snapshot", "title that fonts lack"],
)
def test_any_chain_gives_a_film(tmp_path, example):
    frames, _ = read_gif(nrchain.film(example, tmp_path / "film.gif", width=400))
    assert len(frames) == len(example)


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [
        ("film.gif", {"view": "top"}, "view = 'top': must be one of planes, 3d"),
        ("film.gif", {"width": 10}, "width = 10: must be a whole number of pixels from 320"),
        ("film.gif", {"times": 7}, "times = 7: there are 6 snapshots"),
        ("film.gif", {"fps": 100.0}, "fps = 100.0"),
        ("film.avi", {}, "must end in one of .mp4, .gif"),
    ],
)
def test_what_cannot_be_drawn_is_refused(tmp_path, name, options, message):
    with pytest.raises(SceneError, match=message):
        nrchain.film(growing(), tmp_path / name, **options)
    assert not list(tmp_path.iterdir())


def test_an_existing_film_is_replaced_only_on_request(tmp_path):
    path = tmp_path / "film.gif"
    path.write_bytes(b"dear")
    with pytest.raises(TrajectoryError, match="exists"):
        nrchain.film(growing(), path)
    assert path.read_bytes() == b"dear"
    nrchain.film(growing(), path, width=400, times=2, overwrite=True)
    assert len(read_gif(path)[0]) == 2


def test_a_snapshot_is_no_film(tmp_path):
    with pytest.raises(NrchainError, match="must be a Trajectory"):
        nrchain.film(growing()[-1], tmp_path / "film.gif")


def test_the_process_stays_as_it_is(tmp_path):
    before = process_state.state()
    nrchain.film(growing(), tmp_path / "film.mp4", width=400, times=2)
    assert not process_state.changes(before, process_state.state())
