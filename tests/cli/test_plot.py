"""``nrchain plot``: which picture it draws, where, and what it refuses."""

import h5py
import pytest
from support.command_line import assert_refused, call

from nrchain.cli.exits import REFUSED
from nrchain.cli.summary import PICTURE, PICTURE_IN_SPACE
from nrchain.trajectory.file import FILE_NAME


def test_plot_draws_the_view_and_the_file_asked_for(tmp_path, stub):
    assert call("run", "passive", "-o", tmp_path).exit_code == 0
    (tmp_path / PICTURE).unlink()
    result = call("plot", tmp_path, "--times", "2")
    assert result.exit_code == 0, result.stderr
    assert result.stdout.strip() == str(tmp_path / PICTURE)
    result = call("plot", tmp_path / FILE_NAME, "--view", "3d", "-o", tmp_path / "space.svg")
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "space.svg").read_text().startswith("<?xml")
    assert_refused(call("plot", tmp_path, "-o", tmp_path / "a.doc"), ".png, .pdf, .svg", ".mp4")
    assert_refused(call("plot", tmp_path, "-o", tmp_path / "no" / "a.png"), "No such file")
    assert call("plot", tmp_path, "--view", "top").exit_code == REFUSED
    with h5py.File(tmp_path / FILE_NAME, "r+") as file:
        file["nrchain/finished"][0] = 0
    assert_refused(call("plot", tmp_path), "no finished snapshot")


def test_a_named_picture_is_replaced_only_on_request(tmp_path, stub):
    assert call("run", "passive", "-o", tmp_path).exit_code == 0
    planes = (tmp_path / PICTURE).read_bytes()
    mine = tmp_path / "mine.png"
    mine.write_bytes(b"dear")
    assert_refused(call("plot", tmp_path, "-o", mine), mine, "--overwrite")
    assert mine.read_bytes() == b"dear"
    assert call("plot", tmp_path, "-o", mine, "--overwrite").exit_code == 0
    assert mine.read_bytes() == planes
    result = call("plot", tmp_path, "--view", "3d")
    assert result.stdout.strip() == str(tmp_path / PICTURE_IN_SPACE)
    assert (tmp_path / PICTURE).read_bytes() == planes
    assert call("plot", tmp_path).exit_code == 0
    assert (tmp_path / PICTURE).read_bytes() == planes


def test_effects_are_drawn_beside_the_picture_of_a_run(tmp_path):
    small = ("--set", "chain.particles=4", "--set", "run.end=1.0", "--set", "run.snapshots=3")
    answer = call("run", "buckling", "-o", tmp_path, *small)
    assert answer.stdout.startswith("effects     stretch, shear, twist, bend, slip 2s\n")
    before = (tmp_path / PICTURE).read_bytes()
    drawn = call("plot", tmp_path, "--effects")
    assert drawn.stdout.strip() == str(tmp_path / "effects.png")
    assert (tmp_path / PICTURE).read_bytes() == before
    refused = call("plot", tmp_path, "--effects", "-o", tmp_path / PICTURE)
    assert_refused(refused, "add --overwrite to replace it")


@pytest.mark.parametrize(
    "flag", [("--view", "3d"), ("--times", "3"), ("--spheres", "dots"), ("--frames",)]
)
def test_options_of_chain_pictures_are_refused_for_effects(tmp_path, stub, flag):
    assert call("run", "passive", "-o", tmp_path).exit_code == 0
    answer = call("plot", tmp_path, "--effects", *flag)
    assert_refused(answer, f"{flag[0]} = ", "applies to pictures of the chain", "--effects")
    assert not (tmp_path / "effects.png").exists()


def test_plot_draws_frames_and_spheres_at_logarithmic_times(tmp_path, stub):
    assert call("run", "passive", "-o", tmp_path).exit_code == 0
    before = (tmp_path / PICTURE).read_bytes()
    options = ("--frames", "--spheres", "scale", "--spacing", "logarithmic", "--no-title")
    assert call("plot", tmp_path, *options).exit_code == 0
    assert (tmp_path / PICTURE).read_bytes() != before
    assert call("plot", tmp_path, "--spheres", "big").exit_code == REFUSED
    assert call("plot", tmp_path, "--spacing", "cubic").exit_code == REFUSED


def test_the_flow_is_drawn_in_a_plane_at_a_time(tmp_path, stub):
    assert call("run", "passive", "-o", tmp_path, "--set", "slip.2s=10").exit_code == 0
    drawn = call("plot", tmp_path, "--flow")
    assert drawn.exit_code == 0, drawn.stderr
    assert drawn.stdout.strip() == str(tmp_path / "flow.png")
    before = (tmp_path / "flow.png").read_bytes()
    assert_refused(call("plot", tmp_path, "--flow", "-o", tmp_path / "flow.png"), "--overwrite")
    assert (tmp_path / "flow.png").read_bytes() == before
    options = ("--plane", "yz", "--at", "3", "--time", "0", "--part", "slip", "--no-title")
    assert call("plot", tmp_path, "--flow", *options).exit_code == 0
    assert (tmp_path / "flow.png").read_bytes() != before


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--plane", "xz"), ("--plane = ", "add --flow")),
        (("--flow", "--times", "3"), ("--times = 3", "remove it or --flow")),
        (("--flow", "--effects"), ("--flow", "--effects; remove one")),
        (("--flow", "--time", "1e9"), ("--time = ", "must be from 0 to")),
        (("--flow", "--frame", "900"), ("frame = 900", "snapshots")),
        (("--flow", "--frame", "0", "--time", "0"), ("--time", "--frame both")),
    ],
)
def test_options_of_the_flow_are_refused_where_they_have_no_effect(tmp_path, stub, options, words):
    assert call("run", "passive", "-o", tmp_path).exit_code == 0
    assert_refused(call("plot", tmp_path, *options), *words)
    assert not (tmp_path / "flow.png").exists()
