"""Tracers move with the fluid: at its velocity where frames are close, and around spheres."""

from types import SimpleNamespace

import numpy as np
import pytest
from support.films import growing

from nrchain.view.space import tracers
from nrchain.view.space.tracers import STRIDE, TRAIL, trace

SPIN = np.array([0.0, 0.0, 1.0])


def rotate(places, angle):
    """Places turned about z through the middle of the chain."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y, z = np.moveaxis(places, -1, 0)
    x = x - 25.0
    return np.stack([25.0 + cosine * x - sine * y, sine * x + cosine * y, z], axis=-1)


@pytest.fixture
def turning(monkeypatch):
    """A fluid that turns about z as a rigid body, at a rate that a test sets, 0.01 at first."""
    fluid = SimpleNamespace(rate=lambda time: 0.01)

    def flow(trajectory, points, *, frame):
        turned = np.cross(SPIN, points - np.array([25.0, 0.0, 0.0]))
        return SimpleNamespace(velocity=fluid.rate(trajectory.time[frame]) * turned)

    monkeypatch.setattr(tracers, "flow", flow)
    # the whole fluid is near the chain
    monkeypatch.setattr(tracers, "REACH", 1e3)
    return fluid


def straight(snapshots, end):
    """A chain at rest, away from the fluid that the tests look at."""
    chain = growing(snapshots=snapshots, particles=6)
    positions = np.repeat(chain.positions[:1], snapshots, axis=0)
    return SimpleNamespace(
        time=np.linspace(0.0, end, snapshots), positions=positions, scene=chain.scene
    )


def never_put_again(paths):
    """(M,) whether the path of a tracer is whole: none of its steps is longer than a stride."""
    steps = np.linalg.norm(np.diff(paths[:, :, -1], axis=0), axis=-1)
    return steps.max(axis=0) < 5 * STRIDE


def test_tracers_keep_pace_where_frames_are_close(turning):
    found = trace(straight(40, 20.0), 60)
    assert found.slowed == 1.0
    assert found.words == ""
    assert found.paths.shape == (40, 60, TRAIL, 3)
    whole = never_put_again(found.paths)
    assert whole.sum() > 10
    first, last = found.paths[0, whole, -1], found.paths[-1, whole, -1]
    assert last == pytest.approx(rotate(first, 0.01 * 20.0), abs=2e-3)


def test_the_flow_changes_linearly_between_frames(turning):
    turning.rate = lambda time: 0.002 * time
    found = trace(straight(11, 10.0), 60)
    whole = never_put_again(found.paths)
    first, last = found.paths[0, whole, -1], found.paths[-1, whole, -1]
    assert last == pytest.approx(rotate(first, 0.001 * 10.0**2), abs=2e-3)


def test_fast_fluid_is_slowed_and_the_film_says_so(turning):
    turning.rate = lambda time: 100.0
    found = trace(straight(4, 3.0), 60)
    steps = np.linalg.norm(np.diff(found.paths[:, :, -1], axis=0), axis=-1)
    assert np.mean(steps <= 1.01 * STRIDE) > 0.7
    assert found.slowed > 100.0
    assert found.words == f"tracers {float(f'{found.slowed:.2g}'):g} times slower"


def test_tracers_of_a_real_flow_are_in_the_fluid():
    trajectory = growing()
    found = trace(trajectory, 50)
    assert np.isfinite(found.paths).all()
    for frame in range(len(trajectory)):
        apart = found.paths[frame, :, None, -1] - trajectory.positions[frame]
        assert np.linalg.norm(apart, axis=-1).min() > 1.0
    assert np.array_equal(found.paths, trace(trajectory, 50).paths)


def test_a_still_picture_has_paths_in_its_flow():
    found = trace(growing(snapshots=1), 30)
    assert found.paths.shape[:2] == (1, 30)
    lengths = np.linalg.norm(np.diff(found.paths[0], axis=1), axis=-1).sum(axis=1)
    assert np.median(lengths) > STRIDE
    assert found.words == ""


@pytest.mark.parametrize("snapshots", [1, 3])
def test_fluid_at_rest_carries_nothing(turning, snapshots):
    turning.rate = lambda time: 0.0
    found = trace(straight(snapshots, 1.0), 10)
    assert np.ptp(found.paths, axis=2).max() == 0.0
    assert found.slowed == 1.0
