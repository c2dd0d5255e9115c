"""``nrchain run`` and ``nrchain resume``: what they write, print, keep and refuse."""

import pytest
from support.command_line import SMALL, assert_refused, call

import nrchain.run.simulation
from nrchain.analysis import measure
from nrchain.cli.exits import REFUSED, STOPPED
from nrchain.cli.summary import PICTURE
from nrchain.errors import TrajectoryError
from nrchain.planning import description, regime
from nrchain.run.interruption import INTERRUPTED
from nrchain.scene.loading import load_scene
from nrchain.trajectory.file import FILE_NAME
from nrchain.trajectory.trajectory import Trajectory

DRAWN = ("test_run_simulates_writes_and_draws", "test_a_run_completes_without_its_picture")
"""Tests of the picture; that of all others is blank."""


@pytest.fixture(autouse=True)
def _pictures(request):
    if request.function.__name__ not in DRAWN:
        request.getfixturevalue("blank_pictures")


def test_run_simulates_writes_and_draws(tmp_path):
    """A real run of a small scene, without the stub."""
    result = call(
        *("run", "buckling", "-o", tmp_path / "new" / "place"),
        *("--set", "chain.particles=4", "--set", "run.end=1.0", "--set", "run.snapshots=3", "-v"),
    )
    assert result.exit_code == 0, result.stderr
    trajectory = Trajectory.open(tmp_path / "new" / "place")
    assert trajectory.positions.shape == (3, 4, 3)
    assert trajectory.status == "completed"
    steps = trajectory.counters["steps"]
    for part in ("Jacobians", f" {steps} ", "simulated", "slip 2s", "left out", FILE_NAME, PICTURE):
        assert part in result.stdout
    assert {file.name for file in trajectory.path.parent.iterdir()} == {FILE_NAME, PICTURE}


def test_a_key_without_effect_is_named_before_the_run(tmp_path, stub):
    result = call("run", "passive", "-o", tmp_path, "--set", "slip.neighbours=2", "-v")
    assert "note: slip.neighbours has no effect: no mode has a strength" in result.stderr
    assert "without effect" in result.stdout


def test_a_run_judges_its_chain_once(tmp_path, monkeypatch):
    judged = []
    judge = regime.judge
    monkeypatch.setattr(regime, "judge", lambda scene: judged.append(scene) or judge(scene))
    result = call("run", "buckling", "-o", tmp_path, "--set", "run.max_steps=1", "-v")
    assert "left out" in result.stdout
    assert len(judged) == 1


def test_changes_reach_the_scene(tmp_path, stub):
    arguments = ["--set", "slip.2s=50", "--set", "chain.ends=free", "--set", "slip.3a=[1, 2, 3]"]
    result = call("run", "buckling", "-o", tmp_path, "--set", "chain.particles=3", *arguments)
    assert result.exit_code == 0, result.stderr
    changes = {"slip.2s": 50, "chain.ends": "free", "slip.3a": [1, 2, 3], "chain.particles": 3}
    assert stub.scene == load_scene("buckling", **changes)
    assert Trajectory.open(tmp_path).scene == stub.scene


def test_the_directory_is_named_after_the_scene(tmp_path, stub, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(load_scene("wave").to_toml())
    assert call("run", "passive").exit_code == 0
    assert call("run", "mine.toml").exit_code == 0
    for name in ("passive", "mine"):
        assert {file.name for file in (tmp_path / "runs" / name).iterdir()} == {FILE_NAME, PICTURE}
    assert stub.scene == load_scene("wave")


def test_a_run_says_what_the_chain_has_settled_in(tmp_path):
    few = ["--set", "chain.particles=6", "--set", "run.end=500"]
    result = call("run", "passive", "-o", tmp_path, *few)
    found = measure.attractor(Trajectory.open(tmp_path))
    assert f"settled in a steady state at t = {found.since:g}: straight" in result.stdout


def test_a_run_that_ends_early_is_done(tmp_path):
    few = ["--set", "chain.particles=6", "--set", "run.end=500", "--set", "run.until=settled"]
    result = call("run", "passive", "-o", tmp_path, *few)
    assert result.exit_code == 0
    run = Trajectory.open(tmp_path)
    assert f"complete    at t = {run.time[-1]:g}: settled in a steady state" in result.stdout
    assert run.time[-1] < 500.0
    assert "nothing to resume" in call("resume", tmp_path).stderr


def test_an_existing_result_is_replaced_only_on_request(tmp_path, stub):
    assert call("run", "passive", "-o", tmp_path).exit_code == 0
    before = (tmp_path / FILE_NAME).read_bytes()
    assert_refused(call("run", "passive", "-o", tmp_path), tmp_path / FILE_NAME, "--overwrite")
    assert (tmp_path / FILE_NAME).read_bytes() == before
    assert call("run", "stable", "-o", tmp_path, "--overwrite").exit_code == 0
    assert Trajectory.open(tmp_path).scene == load_scene("stable")


def test_effects_chosen_by_tolerance_are_printed(tmp_path, stub):
    changes = ["--set", "effects=auto", "--set", "tolerance=0.01", "--set", "run.end=4"]
    result = call("run", "passive", "-o", tmp_path, *changes)
    assert result.exit_code == 0, result.stderr
    shown = " ".join(result.stdout.split())
    assert "left out friction between spheres" in shown
    assert "0.01 is allowed" in shown
    assert stub.scene.effects == "named"
    assert Trajectory.open(tmp_path).choice.left_out == ("friction between spheres",)
    assert "left out friction between spheres" in call("plan", "passive", *changes).stdout
    assert_refused(call("plan", "passive", "--set", "effects=auto"), "tolerance")


def test_brackets_are_not_markup(tmp_path, stub, monkeypatch):
    odd = [("[red]effect", ":smile: [/x]")]
    monkeypatch.setattr(description, "effect_rows", lambda scene: (odd, []))
    result = call("run", "passive", "-o", tmp_path, "-v")
    assert "[red]effect" in result.stdout
    assert ":smile: [/x]" in result.stdout


def test_a_run_completes_without_its_picture(tmp_path, stub):
    (tmp_path / PICTURE).mkdir()
    result = call("run", "passive", "-o", tmp_path)
    assert_refused(result, "note: no picture is drawn", "Is a directory", code=0)
    assert "trajectory" in result.stdout
    stub.reason = "at t = 41: spheres touch"
    result = call("run", "passive", "-o", tmp_path, "--overwrite")
    assert result.exit_code == STOPPED


def test_output_may_name_a_file(tmp_path, stub):
    """As with nrchain.simulate. Its picture is named after it: a folder may hold many runs."""
    for name in ("one.h5", "two.HDF5"):
        done = call("run", "passive", "-o", tmp_path / name)
        assert done.exit_code == 0, done.stderr
        assert Trajectory.open(tmp_path / name).path == tmp_path / name
    found = {"one.h5", "one-chain.png", "two.HDF5", "two-chain.png"}
    assert {file.name for file in tmp_path.iterdir()} == found
    drawn = call("plot", tmp_path / "one.h5", "--effects")
    assert drawn.stdout.strip() == str(tmp_path / "one-effects.png")


def test_a_dot_and_a_number_are_not_a_file_ending(tmp_path, stub):
    assert call("run", "passive", "-o", tmp_path / "R1e7.5").exit_code == 0
    assert Trajectory.open(tmp_path / "R1e7.5").path == tmp_path / "R1e7.5" / FILE_NAME


@pytest.mark.parametrize("name", ["a.png", "b.toml", "c.txt"])
def test_other_file_endings_are_refused(tmp_path, stub, name):
    assert_refused(call("run", "passive", "-o", tmp_path / name), name, ".h5, .hdf5, .h5md")
    assert stub.scene is None
    assert not any(tmp_path.iterdir())
    with pytest.raises(TrajectoryError, match=r"ends in \.h5"):
        nrchain.run.output.output_file(tmp_path / name)
    (tmp_path / name).mkdir()
    assert call("run", "passive", "-o", tmp_path / name).exit_code == 0


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["bucklin"], ["bucklin", "did you mean 'buckling'"]),
        (["buckling", "--set", "chain.spacing=1"], ["chain.spacing = 1.0", "overlap"]),
        (["buckling", "--set", "slip.9z=1"], ["slip.9z"]),
        (["buckling", "--set", "chain"], ["chain", "key=value"]),
    ],
)
def test_a_refused_scene_leaves_nothing(tmp_path, stub, arguments, parts):
    assert_refused(call("run", *arguments, "-o", tmp_path / "out"), *parts)
    assert stub.scene is None
    assert not (tmp_path / "out").exists()


def test_a_trajectory_or_a_folder_is_not_a_scene(tmp_path, stub):
    assert call("run", "passive", "-o", tmp_path).exit_code == 0
    trajectory = call("run", tmp_path / FILE_NAME, "-o", tmp_path / "again")
    assert_refused(trajectory, "is a trajectory", "nrchain resume", "nrchain plot")
    folder = call("run", tmp_path, "-o", tmp_path / "again")
    assert_refused(folder, "is neither a file nor a shipped scene")


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        ("steric=wca", ["steric = 'wca'", "did you mean steric.kind = 'wca'?"]),
        ("slip.2S=60", ["slip.2S = 60", "did you mean '2s'?"]),
        ("slip.2s", ["slip.2s is not given", "key=value, such as slip.2s=50"]),
        ("chain.particles=1e1", ["chain.particles = 10.0", "did you mean 10?"]),
        ("slip.finite_size=True", ["did you mean true?"]),
    ],
)
def test_a_refused_change_says_what_to_write(tmp_path, stub, change, parts):
    answer = call("run", "passive", "-o", tmp_path / "out", "--set", change)
    assert_refused(answer, *parts)
    assert "assignment" not in answer.stderr
    assert "registered" not in answer.stderr


def test_a_refused_run_leaves_no_folder(tmp_path):
    result = call("run", "passive", "-o", tmp_path / "a" / "b", "--set", "start.shape=random",
                  "--set", "start.amplitude=1e200")  # fmt: skip
    assert result.exit_code == REFUSED
    assert list(tmp_path.iterdir()) == []


def test_a_run_that_stops_early_says_what_is_kept(tmp_path, stub):
    stub.reason, stub.reached = "at t = 41: spheres 2 and 3 touch", 11
    result = call("run", "passive", "-o", tmp_path)
    scene = load_scene("passive")
    parts = (stub.reason, f"11 of {scene.run.snapshots} snapshots", f"of {scene.run.end:g}")
    assert_refused(result, *parts, code=STOPPED)
    assert "reached     t = 40, 11 snapshots" in result.stdout
    assert (tmp_path / PICTURE).exists()


def test_an_interrupted_run_says_how_to_continue_and_does(tmp_path, stub):
    stub.error, stub.reached = KeyboardInterrupt(), 5
    result = call("run", "passive", "-o", tmp_path)
    assert result.exit_code == INTERRUPTED
    assert f"nrchain resume {tmp_path}" in result.stderr
    assert "interrupted" in result.stderr
    kept = Trajectory.open(tmp_path)
    assert (len(kept.time), kept.reason) == (5, "interrupted")

    stub.error = None
    result = call("resume", tmp_path)
    assert result.exit_code == 0, result.stderr
    whole = Trajectory.open(tmp_path)
    assert (len(whole.time), whole.status) == (whole.scene.run.snapshots, "completed")
    assert (tmp_path / PICTURE).exists()


def test_resuming_a_complete_run_says_so(tmp_path):
    assert call("run", "passive", "-o", tmp_path, *SMALL).exit_code == 0
    before = (tmp_path / FILE_NAME).read_bytes()
    answer = f"note: {tmp_path / FILE_NAME} is complete; there is nothing to resume"
    assert_refused(call("resume", tmp_path), answer, code=0)
    assert (tmp_path / FILE_NAME).read_bytes() == before


def test_a_verified_run_shows_its_errors(tmp_path):
    """A real run of a small scene: the last row has the errors of the last snapshot, in radii."""
    result = call(
        "run", "passive", "-o", tmp_path, "--verify", *SMALL, "--set", "chain.radius=2", "-v"
    )
    assert result.exit_code == 0, result.stderr
    trajectory = Trajectory.open(tmp_path)
    assert trajectory.scene.run.verify
    assert "positions (a)" in result.stdout
    errors = trajectory.position_error[-1] / 2.0, trajectory.frame_error[-1]
    rows = [line.split() for line in result.stdout.splitlines()]
    assert [f"{trajectory.time[-1]:g}", *(f"{error:.1e}" for error in errors)] in rows
    assert ["0", "0", "0"] in rows


def test_a_run_that_is_not_verified_shows_no_errors(tmp_path):
    assert "positions (a)" not in call("run", "passive", "-o", tmp_path, *SMALL, "-v").stdout
