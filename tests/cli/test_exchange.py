"""``export``, ``run --from`` and ``resume --until`` through their real entry point."""

import numpy as np
import pytest
from support.command_line import assert_refused, call

import nrchain

SHORT = ("--set", "chain.particles=5", "--set", "run.end=10", "--set", "run.snapshots=3")


@pytest.fixture
def runs(tmp_path, monkeypatch):
    """A folder with the run of a scene, in which the commands run."""
    monkeypatch.chdir(tmp_path)
    changes = dict(word.split("=") for word in SHORT[1::2])
    scene = nrchain.load_scene("wave", **{key: int(value) for key, value in changes.items()})
    nrchain.simulate(scene, output="one")
    return tmp_path


def test_a_run_is_exported_started_from_and_extended(runs):
    made = call("export", "one", "-o", "one.gsd")
    assert (made.exit_code, made.stdout.strip()) == (0, "one.gsd")
    begun = call("run", "wave", "--from", "one.gsd:1", "-o", "two", *SHORT)
    assert begun.exit_code == 0, begun.stderr
    assert "start       from one.gsd:1, t = 5, float32; 1 earlier step\n" in begun.stdout
    first, second = nrchain.Trajectory.open("one"), nrchain.Trajectory.open("two")
    assert second.positions[0] == pytest.approx(first.positions[1], abs=5e-6)
    longer = call("resume", "two", "--until", "15")
    assert longer.exit_code == 0, longer.stderr
    assert "start       extended from t = 10; 2 earlier steps\n" in longer.stdout
    assert nrchain.Trajectory.open("two").time.tolist() == [0.0, 5.0, 10.0, 15.0]
    drawn = call("plot", "two", "-o", "two.svg")
    assert drawn.stderr == ("nrchain: note: extended from t = 10; 2 earlier steps\n")
    onward = call("run", "wave", "--from", "two:-2", "-o", "three", *SHORT)
    assert onward.exit_code == 0
    third = nrchain.Trajectory.open("three")
    assert np.array_equal(third.positions[0], nrchain.Trajectory.open("two").positions[-2])
    assert len(third.provenance.steps) == 4


def test_every_second_snapshot_is_exported(runs):
    assert call("export", "one", "-o", "one.npz", "--every", "2").exit_code == 0
    with np.load("one.npz") as file:
        assert file["time"].tolist() == [0.0, 10.0]
    assert_refused(call("export", "one", "-o", "one.npz"), "one.npz: exists", "--overwrite")
    assert call("export", "one", "-o", "one.npz", "--overwrite").exit_code == 0


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["export", "one", "-o", "one.vtu"], [".gsd, .xyz, .pvd, .npz, .nc"]),
        (["export", "none", "-o", "one.gsd"], ["none", "no such trajectory"]),
        (["export", "one"], ["-o"]),
        (["run", "wave", "--from", "one:9", *SHORT], ["one", "frames 0 to 2"]),
        (["run", "wave", "--from", "one"], ["has 5 spheres, and chain.particles is"]),
        (["run", "wave", "--from", "none"], ["none", "no such trajectory"]),
        (["run", "wave", "--from", "none.gsd"], ["none.gsd", "no such file"]),
        (["resume", "one", "--until", "5"], ["until = 5.0", "later than run.end = 10"]),
        (["resume", "one", "--until", "12"], ["5 apart", "15"]),
    ],
)
def test_what_cannot_be_done_is_refused_in_one_line(runs, arguments, parts):
    assert_refused(call(*arguments), *parts)
    assert not (runs / "runs").exists()


def test_effects_are_chosen_at_the_poses_of_the_start(runs):
    auto = ("--set", "effects=auto", "--set", "tolerance=0.5")
    begun = call("run", "wave", "--from", "one", "-o", "two", *SHORT, *auto)
    assert begun.exit_code == 0, begun.stderr
    second = nrchain.Trajectory.open("two")
    assert np.array_equal(second.positions[0], nrchain.Trajectory.open("one").positions[-1])
    assert second.choice is not None
    assert second.provenance.line == "from one:2, t = 10"
