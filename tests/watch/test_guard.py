"""Contacts and turned links are found at their time, also when a step jumps across them."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import nrchain
from nrchain.errors import SceneError
from nrchain.motion.contact import PoseLimits, most_turned_link
from nrchain.outcome import Cause
from nrchain.watch.guard import Guard


def scene_of(count=3, **changes):
    return nrchain.load_scene({"chain.particles": count, "run.end": 1.0}, **changes)


def watch(scene, path, begin, end):
    """The result of the guard for a step in which ``path(time)`` gives positions and frames."""
    before = path(begin)[0]
    return Guard(PoseLimits.of(scene), before).watch(begin, before, end, path(end), path)


def straight_line(velocity, offset=0.0):
    """Sphere 2 moves along x past sphere 0, at the distance ``offset``."""

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


def twisting(count, rate):
    """Frames turned about x by ``rate`` t more from each sphere to the next."""

    def path(time):
        frames = np.tile(np.eye(3), (count, 1, 1))
        angles = rate * time * np.arange(count)
        frames[:, 1, 1], frames[:, 1, 2] = np.cos(angles), np.sin(angles)
        frames[:, 2, 1], frames[:, 2, 2] = -np.sin(angles), np.cos(angles)
        return 7.0 * np.arange(count)[:, None] * [1.0, 0.0, 0.0], frames

    return path


@pytest.mark.parametrize("count", [3, 8])
def test_the_link_that_closes_a_periodic_chain_is_watched_too(count):
    """The other links turn by little, and this one by their sum."""
    shape = {"chain.spacing": 7.0, "chain.radius": 2.0}
    path = twisting(count, 2.0 / (count - 1))
    stop = watch(scene_of(count, **shape, **{"chain.ends": "periodic"}), path, 0.0, 1.0)
    assert (stop.cause, stop.time) == (Cause.TURN, pytest.approx(np.pi / 4))
    assert f"link {count - 1} has" in str(stop)
    assert watch(scene_of(count, **shape), path, 0.0, 1.0) is None
    angle, link = most_turned_link(path(1.0)[1], True)
    assert (angle, link) == (pytest.approx(2.0), count - 1)
    scene = scene_of(count, **shape, **{"chain.ends": "periodic"})
    with pytest.raises(SceneError, match=f"= link {count - 1}: turned by 2 rad"):
        nrchain.simulate(scene, frames=path(1.0)[1])


WIDE = {"chain.radius": 1.5, "chain.spacing": 40.0}
CONTACT = 3.0


def meeting(nearest, step, swing):
    """Two spheres that each move by ``step`` along y, and on the way towards each other."""

    def path(time):
        apart = nearest + 2.0 * swing * step * (1.0 - 4.0 * time * (1.0 - time))
        x, y = 0.5 * apart, step * time
        positions = np.array([[-x, y, 0.0], [x, -y, 0.0], [0.0, 0.0, 300.0]])
        return positions, np.tile(np.eye(3), (3, 1, 1))

    return path


@pytest.mark.parametrize("swing", [0.6, 1.0, 1.2])
def test_two_spheres_that_swing_to_each_other_within_a_step_are_caught(swing):
    """Each swings sideways by ``swing`` times its displacement, towards the other."""
    step = 1.0
    stop = watch(scene_of(**WIDE), meeting(0.8 * CONTACT, step, swing), 0.0, 1.0)
    assert stop.cause is Cause.TOUCH
    positions = meeting(0.8 * CONTACT, step, swing)(stop.time)[0]
    assert np.linalg.norm(positions[0] - positions[1]) == pytest.approx(CONTACT)
    assert stop.time < 0.5
    assert watch(scene_of(**WIDE), meeting(1.05 * CONTACT, step, swing), 0.0, 1.0) is None


@pytest.mark.parametrize("skew", [-0.5, 0.0, 0.5])
def test_a_swing_that_is_deepest_late_or_early_in_a_step_is_caught(skew):
    """At the point where the step is divided, the deviation may be half of the largest one."""

    def path(time):
        swing = 4.0 * time * (1.0 - time) * (1.0 + skew * (2.0 * time - 1.0))
        x = 0.5 * (CONTACT + 0.9 - swing)
        positions = np.array([[-x, time, 0.0], [x, time, 0.0], [0.0, -2.0 * time, 300.0]])
        return positions, np.tile(np.eye(3), (3, 1, 1))

    stop = watch(scene_of(**WIDE), path, 0.0, 1.0)
    assert stop.cause is Cause.TOUCH
    positions = path(stop.time)[0]
    assert np.linalg.norm(positions[0] - positions[1]) == pytest.approx(CONTACT)
    deepest = np.linspace(0.0, 1.0, 1001)
    shape = 4.0 * deepest * (1.0 - deepest) * (1.0 + skew * (2.0 * deepest - 1.0))
    assert stop.time == pytest.approx(deepest[np.argmax(shape >= 0.9)], abs=2e-3)


@pytest.mark.parametrize("vertex", [0.2, 0.5, 0.8])
def test_a_sphere_that_swings_past_another_is_caught_wherever_the_swing_is_deepest(vertex):
    """A parabola that touches the other sphere although its ends and its chord do not."""

    def path(time):
        swing = 0.95 * CONTACT + 8.0 * (time - vertex) ** 2
        positions = np.array([[0.0, 0, 0], [0, 0, 300.0], [swing, 2.0 * (time - vertex), 0]])
        return positions, np.tile(np.eye(3), (3, 1, 1))

    stop = watch(scene_of(**WIDE), path, 0.0, 1.0)
    assert stop.cause is Cause.TOUCH
    assert np.linalg.norm(path(stop.time)[0][2]) == pytest.approx(CONTACT)
    assert stop.time < vertex


@pytest.mark.parametrize("steps", [3, 7, 40, 1000])
def test_spheres_that_come_from_far_in_many_steps_touch_in_time(steps):
    """A search is repeated only once the spheres may have met since the last one."""
    scene, speed = scene_of(**WIDE), 20.0

    def path(time):
        x = 21.0 - speed * time
        positions = np.array([[-x, 0.0, 0.0], [x, 0.0, 0.0], [0.0, 0.0, 300.0]])
        return positions, np.tile(np.eye(3), (3, 1, 1))

    times = np.linspace(0.0, 1.5, steps)
    guard = Guard(PoseLimits.of(scene), path(0.0)[0])
    for begin, end in itertools.pairwise(times):
        stop = guard.watch(begin, path(begin)[0], end, path(end), path)
        if stop:
            break
    assert stop.time == pytest.approx((21.0 - 0.5 * CONTACT) / speed, rel=1e-9)


@settings(deadline=None, max_examples=200)
@given(st.integers(0, 10**6), st.sampled_from(["free", "periodic"]), st.floats(0.1, 30.0))
def test_every_contact_of_a_random_step_is_found_at_its_time(seed, ends, size):
    """Parabolas that deviate by at most the displacement of the step, against fine sampling."""
    rng = np.random.default_rng(seed)
    scene = scene_of(4, **{"chain.radius": 1.5, "chain.spacing": 8.0, "chain.ends": ends})
    start = 8.0 * np.arange(4)[:, None] * [1.0, 0.0, 0.0] + rng.uniform(-1.5, 1.5, (4, 3))
    moves = rng.uniform(-1.0, 1.0, (4, 3))
    moves *= size / np.linalg.norm(moves - moves.mean(axis=0), axis=1).max()
    bends = rng.uniform(-0.5, 0.5, (4, 3)) * size / np.sqrt(3.0)

    def path(time):
        swing = bends * 4.0 * time * (1.0 - time)
        return start + moves * time + swing, np.tile(np.eye(3), (4, 1, 1))

    def nearest(times):
        r = path(times[:, None, None])[0]
        images = range(-12, 13) if ends == "periodic" else [0]
        i, j = np.triu_indices(4, 1)
        apart = r[:, i] - r[:, j]
        shifted = apart[..., 0] + 32.0 * np.array(images)[:, None, None]
        beside = (apart[..., 1:] ** 2).sum(axis=-1)
        return np.sqrt((shifted**2).min(axis=0) + beside).min(axis=-1)

    times = np.linspace(0.0, 1.0, 1001)
    distances = nearest(times)
    stop = watch(scene, path, 0.0, 1.0)
    slack = 0.02 * size
    if distances.min() > CONTACT + slack:
        assert stop is None
    elif distances.min() < CONTACT - slack and distances[0] > CONTACT:
        first = int(np.argmax(distances <= CONTACT))
        assert stop.cause is Cause.TOUCH
        assert stop.time <= times[first]
        assert nearest(np.array([stop.time])) == pytest.approx(CONTACT, abs=1e-6)


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
