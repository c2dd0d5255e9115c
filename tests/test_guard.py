"""Contacts and turned links are found at their time, also when a step jumps across them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import nrchain
from nrchain.guard import Guard
from nrchain.outcome import Cause, Stop


def scene_of(count=3, **changes):
    return nrchain.load_scene({"chain.particles": count, "run.end": 1.0}, **changes)


def watch(scene, path, begin, end):
    """What the guard says of a step in which ``path(time)`` gives positions and frames."""
    before = path(begin)[0]
    return Guard(scene, before).watch(begin, before, end, path(end), path)


def straight_line(velocity, offset=0.0):
    """Sphere 2 flies along x through the place of sphere 0, ``offset`` beside it."""

    def path(time):
        positions = np.array([[0.0, 0, 0], [0, 50, 0], [-30.0 + velocity * time, 0, offset]])
        return positions, np.tile(np.eye(3), (3, 1, 1))

    return path


@settings(deadline=None)
@given(st.floats(35.0, 1e6), st.floats(0.0, 1.999))
def test_spheres_that_pass_through_each_other_in_one_step_are_caught(velocity, offset):
    stop = watch(scene_of(), straight_line(velocity, offset), 0.0, 1.0)
    assert stop.cause is Cause.TOUCH
    assert "spheres 0 and 2 touch (distance 2 a)" in str(stop)
    assert stop.time == pytest.approx((30 - np.sqrt(4 - offset**2)) / velocity, rel=1e-9)


@given(st.floats(0.0, 1e6), st.floats(2.001, 20.0))
def test_spheres_that_pass_each_other_are_not(velocity, offset):
    assert watch(scene_of(), straight_line(velocity, offset), 0.0, 1.0) is None


def test_a_curved_step_that_grazes():
    # sphere 2 swings in on a parabola whose ends are clear and whose vertex is at ``least``
    def path_to(least):
        def path(time):
            swing = least + 40.0 * (time - 0.37) ** 2
            positions = np.array([[0.0, 0, 0], [0, 50, 0], [swing, 3.0 * (time - 0.37), 0]])
            return positions, np.tile(np.eye(3), (3, 1, 1))

        return path

    assert watch(scene_of(), path_to(2.01), 0.0, 1.0) is None
    stop = watch(scene_of(), path_to(1.99), 0.0, 1.0)
    reached = np.linalg.norm(path_to(1.99)(stop.time)[0][2])
    assert reached == pytest.approx(2.0, abs=1e-9)
    assert stop.time < 0.37


def test_the_image_of_a_periodic_chain_is_met():
    scene = scene_of(**{"chain.ends": "periodic"})

    def path(time):
        positions = np.array([[0.0, 0, 0], [14.0, 0, 0], [20.0 + 20.0 * time, 0, 0]])
        return positions, np.tile(np.eye(3), (3, 1, 1))

    # sphere 0 has an image at x = 30
    assert watch(scene, path, 0.0, 1.0).time == pytest.approx(8.0 / 20.0)


def test_a_link_is_stopped_at_a_quarter_turn():
    def path(time):
        frames = np.tile(np.eye(3), (3, 1, 1))
        angle = 2.0 * time
        frames[2, 1:, 1:] = [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]
        return np.array([[0.0, 0, 0], [10, 0, 0], [20, 0, 0]]), frames

    stop = watch(scene_of(), path, 0.0, 1.0)
    assert (stop.cause, stop.time) == (Cause.TURN, pytest.approx(np.pi / 4))
    assert "link 1" in str(stop)
    assert watch(scene_of(elasticity={"twist": 0, "bend": 0}), path, 0.0, 1.0) is None
    assert watch(scene_of(), path, 0.0, 0.7) is None


def test_poses_that_are_not_numbers():
    def path(time):
        positions, frames = straight_line(1.0)(time)
        return positions * (np.nan if time > 0 else 1.0), frames

    assert watch(scene_of(), path, 0.0, 1.0).cause is Cause.NOT_FINITE


def test_with_a_repulsion_spheres_may_come_closer():
    steric = {"kind": "wca", "strength": 1.0}
    assert watch(scene_of(steric=steric), straight_line(100.0, 1.5), 0.0, 1.0) is None
    stop = watch(scene_of(steric=steric), straight_line(100.0, 0.5), 0.0, 1.0)
    assert stop.cause is Cause.TOUCH


def test_a_run_stops_where_friction_that_is_cut_no_longer_damps():
    """Ten spheres in a line: twice their diameter apart the cut holds, at contact it does not."""
    cut = {"chain.spacing": 4.0, "friction": {"kind": "pairwise", "neighbours": 1}}
    line = np.arange(10.0)[:, None] * [1.0, 0.0, 0.0]
    guard = Guard(scene_of(10, **cut), 4.0 * line)
    guard.judge_friction(1.0, 4.0 * line)
    with pytest.raises(Stop, match="cut at 1 neighbours is no longer positive definite") as stop:
        guard.judge_friction(2.5, 2.01 * line)
    assert stop.value.cause is Cause.FRICTION
    assert stop.value.time == 2.5
    every = scene_of(10, friction="pairwise", **{"chain.spacing": 4.0})
    Guard(every, 4.0 * line).judge_friction(2.5, 2.01 * line)
