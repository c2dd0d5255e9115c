"""Each command does what it says, and what a user can cause ends in one line and an exit code."""

import os
import signal
import subprocess
import sys
from io import StringIO
from pathlib import Path

import h5py
import numpy as np
import pytest
from typer.testing import CliRunner

import nrchain.run.simulation
from nrchain import __version__
from nrchain.accuracy.cost import Point, WorkPrecision
from nrchain.accuracy.timing import Measured
from nrchain.cli.app import app
from nrchain.cli.exits import BROKEN_PIPE, REFUSED, STOPPED
from nrchain.cli.summary import PICTURE, PICTURE_IN_SPACE
from nrchain.cli.tables import work_table
from nrchain.cli.terminal import TRANSLITERATE, print_output
from nrchain.errors import BackendError, TrajectoryError
from nrchain.planning import description
from nrchain.run.interruption import INTERRUPTED
from nrchain.run.recording import Progress
from nrchain.run.work import RunCost, Work
from nrchain.scene.scene import load_scene, scene_names
from nrchain.trajectory.file import FILE_NAME
from nrchain.trajectory.trajectory import Trajectory
from nrchain.trajectory.writer import TrajectoryWriter

HEAVY = ("numpy", "scipy", "numba", "matplotlib", "h5py", "pystokes", "sksundae")


def call(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def assert_refused(result, *parts, code=REFUSED):
    """The code, and one line on stderr that has the parts and is no traceback."""
    assert result.exit_code == code
    assert len(result.stderr.splitlines()) == 1
    assert result.stderr.startswith("nrchain: ")
    for part in parts:
        assert str(part) in result.stderr


class Stub:
    """A run that writes straight chains, up to the snapshot at which it ends as it is told to."""

    def __init__(self):
        self.scene = None
        self.error = None
        self.reason = ""
        self.reached = None

    def simulate(self, scene, *, output, overwrite=False, progress=None, choice=None):
        self.scene = scene
        times = np.linspace(0.0, scene.run.end, scene.run.snapshots)
        with TrajectoryWriter(output, scene, times, overwrite=overwrite, choice=choice) as writer:
            self.fill(writer, range(self.reached or len(times)), progress)
        return Trajectory.open(output)

    def resume(self, path, *, unwatched=False, progress=None):
        with TrajectoryWriter.reopen(path) as writer:
            self.scene = writer.scene
            begin = len(Trajectory.open(path).time)
            self.fill(writer, range(begin, len(writer.times)), progress)
        return Trajectory.open(path)

    def fill(self, writer, indices, progress):
        particles, count = writer.scene.chain.particles, len(writer.times)
        positions = np.zeros((particles, 3))
        positions[:, 0] = 10.0 * np.arange(particles)
        frames = np.broadcast_to(np.eye(3), (particles, 3, 3))
        for index in indices:
            time = float(writer.times[index])
            writer.write(index, time, positions, frames, index)
            counters = {"steps": 7 * index, "wall_time": 0.5}
            writer.update_counters(counters)
            progress(Progress(time, float(writer.times[-1]), index + 1, count, counters, 0.5))
        if self.error:
            raise self.error
        writer.close("stopped" if self.reason else "completed", self.reason)


@pytest.fixture
def stub(monkeypatch):
    stub = Stub()
    monkeypatch.setattr(nrchain.run.simulation, "simulate", stub.simulate)
    monkeypatch.setattr(nrchain.run.simulation, "resume", stub.resume)
    return stub


def test_run_simulates_writes_and_draws(tmp_path):
    """The real thing, on a small scene."""
    result = call(
        *("run", "buckling", "-o", tmp_path / "new" / "place"),
        *("--set", "chain.particles=4", "--set", "run.end=1.0", "--set", "run.snapshots=3"),
    )
    assert result.exit_code == 0, result.stderr
    trajectory = Trajectory.open(tmp_path / "new" / "place")
    assert trajectory.positions.shape == (3, 4, 3)
    assert trajectory.status == "completed"
    steps = trajectory.counters["steps"]
    for part in ("Jacobians", f" {steps} ", "simulated", "slip 2s", "left out", FILE_NAME, PICTURE):
        assert part in result.stdout
    assert {file.name for file in trajectory.path.parent.iterdir()} == {FILE_NAME, PICTURE}


def test_a_key_that_does_nothing_is_named_before_the_run(tmp_path, stub):
    result = call("run", "passive", "-o", tmp_path, "--set", "slip.neighbours=2")
    assert "note: slip.neighbours has no effect: no mode has a strength" in result.stderr
    assert "without effect" in result.stdout


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


def test_an_older_result_is_replaced_only_when_told(tmp_path, stub):
    assert call("run", "passive", "-o", tmp_path).exit_code == 0
    before = (tmp_path / FILE_NAME).read_bytes()
    assert_refused(call("run", "passive", "-o", tmp_path), tmp_path / FILE_NAME, "--overwrite")
    assert (tmp_path / FILE_NAME).read_bytes() == before
    assert call("run", "stable", "-o", tmp_path, "--overwrite").exit_code == 0
    assert Trajectory.open(tmp_path).scene == load_scene("stable")


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["bucklin"], ["bucklin", "did you mean 'buckling'"]),
        (["buckling", "--set", "chain.spacing=1"], ["chain.spacing = 1.0", "overlap"]),
        (["buckling", "--set", "slip.9z=1"], ["slip.9z"]),
        (["buckling", "--set", "chain"], ["chain", "key=value"]),
    ],
)
def test_a_scene_that_is_refused_leaves_nothing(tmp_path, stub, arguments, parts):
    assert_refused(call("run", *arguments, "-o", tmp_path / "out"), *parts)
    assert stub.scene is None
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("error", "part"),
    [
        (BackendError("PyStokes 9.9 is unknown"), "PyStokes 9.9 is unknown"),
        (PermissionError(13, "Permission denied", "some/file"), "some/file: Permission denied"),
    ],
)
def test_other_failures_are_one_line_too(tmp_path, stub, error, part):
    stub.error = error
    assert_refused(call("run", "passive", "-o", tmp_path), part)


def test_a_bug_keeps_its_traceback(tmp_path, stub):
    stub.error = ZeroDivisionError("ours")
    assert isinstance(call("run", "passive", "-o", tmp_path).exception, ZeroDivisionError)


def test_a_run_that_stops_early_says_what_is_kept(tmp_path, stub):
    stub.reason, stub.reached = "at t = 41: spheres 2 and 3 touch", 11
    result = call("run", "passive", "-o", tmp_path)
    scene = load_scene("passive")
    parts = (stub.reason, f"11 of {scene.run.snapshots} snapshots", f"of {scene.run.end:g}")
    assert_refused(result, *parts, code=STOPPED)
    assert "simulated" in result.stdout
    assert (tmp_path / PICTURE).exists()


def test_an_interrupted_run_says_how_to_go_on_and_does(tmp_path, stub):
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


@pytest.mark.parametrize("command", ["resume", "plot"])
def test_a_missing_run_is_refused(tmp_path, command):
    assert_refused(call(command, tmp_path), tmp_path, "no such trajectory")


def test_plan_writes_nothing_and_warns(tmp_path, stub, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = call("plan", "buckling", "--set", "chain.particles=64")
    assert result.exit_code == 0, result.stderr
    for part in (
        "closest approach",
        "stretch",
        "growth",
        "reach",
        "slip 2s",
        "displaced, rotated:",
    ):
        assert part in result.stdout
    assert "warning: out of the beam limit" in result.stderr
    assert stub.scene is None
    assert not any(tmp_path.iterdir())
    early = call("plan", "buckling", "--set", "chain.particles=8", "--budget", "0.01")
    assert "where the probe ended; the end is not known" in early.stdout
    assert_refused(call("plan", "bucklin"), "did you mean 'buckling'")


def test_effects_chosen_for_a_tolerance_are_told(tmp_path, stub):
    changes = ["--set", "effects=auto", "--set", "tolerance=0.01", "--set", "run.end=4"]
    result = call("run", "passive", "-o", tmp_path, *changes)
    assert result.exit_code == 0, result.stderr
    assert "left out friction between spheres" in result.stdout
    assert "0.01 allowed" in result.stdout
    assert stub.scene.effects == "named"
    assert Trajectory.open(tmp_path).choice.left_out == ("friction between spheres",)
    assert "left out friction between spheres" in call("plan", "passive", *changes).stdout
    assert_refused(call("plan", "passive", "--set", "effects=auto"), "tolerance")


def test_scenes_lists_every_scene():
    result = call("scenes")
    assert result.exit_code == 0
    rows = result.stdout.splitlines()
    for name in scene_names():
        row = next(row for row in rows if row.strip().startswith(f"{name} "))
        scene = load_scene(name)
        assert scene.chain.ends in row
        assert str(scene.chain.particles) in row
        assert scene.title.split()[0] in row


def test_plot_draws_where_and_as_it_is_told(tmp_path, stub):
    assert call("run", "passive", "-o", tmp_path).exit_code == 0
    (tmp_path / PICTURE).unlink()
    result = call("plot", tmp_path, "--times", "2")
    assert result.exit_code == 0, result.stderr
    assert result.stdout.strip() == str(tmp_path / PICTURE)
    result = call("plot", tmp_path / FILE_NAME, "--view", "3d", "-o", tmp_path / "space.svg")
    assert result.exit_code == 0, result.stderr
    assert (tmp_path / "space.svg").read_text().startswith("<?xml")
    assert_refused(call("plot", tmp_path, "-o", tmp_path / "a.doc"), ".png, .pdf, .svg")
    assert_refused(call("plot", tmp_path, "-o", tmp_path / "no" / "a.png"), "No such file")
    assert call("plot", tmp_path, "--view", "top").exit_code == REFUSED
    with h5py.File(tmp_path / FILE_NAME, "r+") as file:
        file["nrchain/finished"][0] = 0
    assert_refused(call("plot", tmp_path), "no finished snapshot")


def test_a_picture_of_ones_own_is_replaced_only_when_told(tmp_path, stub):
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


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["frob"], ["frob", "nrchain --help"]),
        (["run"], ["SCENE", "nrchain run --help"]),
        (["run", "passive", "--foo"], ["--foo", "nrchain run --help"]),
        (["plot", ".", "--view", "top"], ["top", "planes"]),
        (["plot", ".", "--times", "0"], ["times"]),
        (["run", "passive", "--set"], ["--set"]),
        (["run", "passive", "--set", ".=1"], ["'.=1'", "key=value"]),
    ],
)
def test_a_command_line_that_is_not_understood_takes_one_line(
    tmp_path, monkeypatch, arguments, parts
):
    monkeypatch.chdir(tmp_path)
    result = call(*arguments)
    assert result.exit_code == REFUSED
    assert len(result.stderr.splitlines()) == 1
    assert result.stderr.startswith("nrchain: ")
    for part in parts:
        assert part.lower() in result.stderr.lower()


def test_no_command_shows_the_commands():
    result = call()
    assert result.exit_code == 0
    assert "resume" in result.stdout


def test_brackets_in_a_title_are_no_markup(tmp_path, stub, monkeypatch):
    odd = description.Description([("[red]effect", ":smile: [/x]")], [], [])
    monkeypatch.setattr(description, "describe", lambda scene: odd)
    result = call("run", "passive", "-o", tmp_path)
    assert "[red]effect" in result.stdout
    assert ":smile: [/x]" in result.stdout


def test_effects_are_listed_with_their_keys():
    from nrchain.effects.registry import effects

    shown = call("effects").stdout
    for effect in effects():
        assert effect.name in shown
        assert effect.key in shown


def test_effects_of_a_run_are_drawn_beside_the_picture(tmp_path):
    small = ("--set", "chain.particles=4", "--set", "run.end=1.0", "--set", "run.snapshots=3")
    told = call("run", "buckling", "-o", tmp_path, *small)
    assert told.stdout.startswith("effects     stretch, shear, twist, bend, slip 2s\n")
    before = (tmp_path / PICTURE).read_bytes()
    drawn = call("plot", tmp_path, "--effects")
    assert drawn.stdout.strip() == str(tmp_path / "effects.png")
    assert (tmp_path / PICTURE).read_bytes() == before
    refused = call("plot", tmp_path, "--effects", "-o", tmp_path / PICTURE)
    assert_refused(refused, "add --overwrite to replace it")


def program(*arguments, **options):
    """A process of its own, as from a shell."""
    return subprocess.run(
        [sys.executable, "-m", "nrchain", *map(str, arguments)],
        **{"stderr": subprocess.PIPE, "text": True, "check": False} | options,
    )


def test_a_picture_that_cannot_be_drawn_is_told_of_and_the_run_is_done(tmp_path, stub):
    (tmp_path / PICTURE).mkdir()
    result = call("run", "passive", "-o", tmp_path)
    assert_refused(result, "note: no picture is drawn", "Is a directory", code=0)
    assert "simulated" in result.stdout
    stub.reason = "at t = 41: spheres touch"
    result = call("run", "passive", "-o", tmp_path, "--overwrite")
    assert result.exit_code == STOPPED


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_output_that_cannot_be_written_is_told_of(tmp_path):
    small = ("--set", "chain.particles=3", "--set", "run.end=0.1", "--set", "run.snapshots=2")
    with open("/dev/full", "w") as full:
        done = program("run", "passive", "-o", tmp_path, *small, stdout=full)
        listed = program("effects", stdout=full)
    told = "standard output: No space left on device\n"
    assert (done.returncode, done.stderr) == (0, f"nrchain: note: {told}")
    assert Trajectory.open(tmp_path).status == "completed"
    assert (listed.returncode, listed.stderr) == (REFUSED, f"nrchain: {told}")


SMALL = ("--set", "chain.particles=3", "--set", "run.end=0.1", "--set", "run.snapshots=2")


@pytest.mark.parametrize("command", [["effects"], ["scenes"], ["--help"], ["--version"]])
def test_a_reader_that_has_gone_away_ends_a_command_without_a_word(command):
    """As ``nrchain effects | head`` does: 128 and the number of SIGPIPE, which shells expect."""
    reader, writer = os.pipe()
    os.close(reader)
    listed = program(*command, stdout=writer)
    os.close(writer)
    assert (listed.returncode, listed.stderr) == (BROKEN_PIPE, "")
    assert BROKEN_PIPE == 128 + signal.SIGPIPE


def test_a_run_whose_reader_has_gone_away_is_done_without_a_word(tmp_path):
    reader, writer = os.pipe()
    os.close(reader)
    done = program("run", "passive", "-o", tmp_path, *SMALL, stdout=writer)
    os.close(writer)
    assert (done.returncode, done.stderr) == (0, "")
    assert Trajectory.open(tmp_path).status == "completed"
    assert (tmp_path / PICTURE).exists()


def test_a_file_is_made_where_one_is_named(tmp_path, stub):
    """As nrchain.simulate does; its picture is named after it, so that runs may lie together."""
    for name in ("one.h5", "two.HDF5"):
        done = call("run", "passive", "-o", tmp_path / name)
        assert done.exit_code == 0, done.stderr
        assert Trajectory.open(tmp_path / name).path == tmp_path / name
    found = {"one.h5", "one-chain.png", "two.HDF5", "two-chain.png"}
    assert {file.name for file in tmp_path.iterdir()} == found
    drawn = call("plot", tmp_path / "one.h5", "--view", "3d")
    assert drawn.stdout.strip() == str(tmp_path / "one-chain-3d.png")


def test_a_dot_and_a_number_are_no_ending(tmp_path, stub):
    assert call("run", "passive", "-o", tmp_path / "R1e7.5").exit_code == 0
    assert Trajectory.open(tmp_path / "R1e7.5").path == tmp_path / "R1e7.5" / FILE_NAME


@pytest.mark.parametrize("name", ["a.png", "b.toml", "c.txt"])
def test_the_ending_of_another_kind_of_file_is_refused(tmp_path, stub, name):
    assert_refused(call("run", "passive", "-o", tmp_path / name), name, ".h5, .hdf5, .h5md")
    assert stub.scene is None
    assert not any(tmp_path.iterdir())
    with pytest.raises(TrajectoryError, match=r"ends in \.h5"):
        nrchain.run.output.output_file(tmp_path / name)
    (tmp_path / name).mkdir()
    assert call("run", "passive", "-o", tmp_path / name).exit_code == 0


def test_resuming_what_is_complete_says_so(tmp_path):
    assert call("run", "passive", "-o", tmp_path, *SMALL).exit_code == 0
    before = (tmp_path / FILE_NAME).read_bytes()
    told = f"note: {tmp_path / FILE_NAME} is complete; there is nothing to resume"
    assert_refused(call("resume", tmp_path), told, code=0)
    assert (tmp_path / FILE_NAME).read_bytes() == before


@pytest.mark.parametrize("flag", [("--view", "3d"), ("--view", "planes"), ("--times", "3")])
def test_flags_that_do_nothing_for_effects_are_refused(tmp_path, stub, flag):
    assert call("run", "passive", "-o", tmp_path).exit_code == 0
    told = call("plot", tmp_path, "--effects", *flag)
    assert_refused(told, f"{flag[0]} = ", "applies to pictures of the chain", "--effects")
    assert not (tmp_path / "effects.png").exists()


@pytest.mark.parametrize("command", ["plot", "resume"])
def test_a_run_that_lies_in_runs_is_offered(tmp_path, stub, monkeypatch, command):
    monkeypatch.chdir(tmp_path)
    assert call("run", "passive").exit_code == 0
    meant = Path("runs") / "passive"
    assert_refused(call(command, "passive"), f"did you mean {meant}?")
    assert call(command, meant).exit_code == 0
    assert_refused(call(command, "other"), "there is no such trajectory")


def test_what_is_no_scene_is_refused_with_what_it_is(tmp_path, stub):
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
def test_a_change_that_is_refused_says_what_to_write(tmp_path, stub, change, parts):
    told = call("run", "passive", "-o", tmp_path / "out", "--set", change)
    assert_refused(told, *parts)
    assert "assignment" not in told.stderr
    assert "registered" not in told.stderr


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_symbols_that_a_terminal_lacks_are_spelt(encoding):
    environment = os.environ | {"PYTHONIOENCODING": encoding, "COLUMNS": "200"}
    shown = program("effects", stdout=subprocess.PIPE, env=environment, encoding=encoding)
    assert (shown.returncode, shown.stderr) == (0, "")
    assert "slip 2s" in shown.stdout
    rows = [line for line in shown.stdout.splitlines() if line.startswith("|") and "+-" not in line]
    assert len({row.index("|", 1) for row in rows}) == 1


def test_symbols_are_spelt_as_they_are_read():
    shown = "λ∥d σ Ω₀ ½ (a/r)² … 字".encode("ascii", TRANSLITERATE).decode()
    assert shown == "lambdapard sigma Omega0 12 (a/r)2 ... ?"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_while_libraries_are_loaded_takes_one_line(tmp_path, number):
    child = f"""
import os, sys
from nrchain.__main__ import main

class Loading:
    def find_spec(self, name, *rest):
        if name == "nrchain.planning.regime":
            os.kill(os.getpid(), {int(number)})

sys.meta_path.insert(0, Loading())
sys.argv = ["nrchain", "run", "passive"]
main()
"""
    command = [sys.executable, "-c", child]
    done = subprocess.run(command, capture_output=True, text=True, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (INTERRUPTED, "nrchain: interrupted\n")


def test_a_run_that_is_refused_leaves_no_folder(tmp_path):
    result = call("run", "passive", "-o", tmp_path / "a" / "b", "--set", "start.shape=random",
                  "--set", "start.amplitude=1e200")  # fmt: skip
    assert result.exit_code == REFUSED
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["x" * 300, "d/" * 3000 + "x.h5"])
def test_paths_that_no_file_can_have_are_refused(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_refused(call("run", "passive", "-o", name), "cannot be made")
    for command in ("resume", "plot"):
        assert_refused(call(command, name))


def test_the_table_of_costs_is_shown_whole(monkeypatch):
    monkeypatch.setenv("COLUMNS", "60")
    counts = Work(12345678, 23456789, 34567890, 45678901)
    measured = Measured(1e-3, 1e-3, counts, (0.0123,), 0.5, 1.0)
    points = [Point("model", "… and pairwise friction", {}, measured)]
    own = RunCost(counts, 0.0123, 1.0, 400.0)
    found = WorkPrecision(load_scene("passive"), 1.0, own, points, "cvode", 1e-9)
    shown = StringIO()
    monkeypatch.setattr(sys, "stdout", shown)
    assert print_output(work_table(found), whole=True) is None
    for number in ("1.0e-03", "0.012", *map(str, counts), "not known"):
        assert number in shown.getvalue()


def test_version():
    assert call("--version").stdout.strip() == f"nrchain {__version__}"


def test_help_loads_nothing_heavy():
    program = f"""
import sys
from nrchain.cli.app import main
sys.argv = ["nrchain", "--help"]
try:
    main()
finally:
    loaded = [name for name in {HEAVY} if name in sys.modules]
    assert not loaded, loaded
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    for command in ("run", "plan", "resume", "scenes", "plot"):
        assert command in done.stdout
