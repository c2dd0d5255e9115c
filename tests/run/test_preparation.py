"""Preparation of a run: its watches and its warnings."""

import numpy as np
import pytest

import nrchain
from nrchain.motion.charts import ChartedChain
from nrchain.motion.model import Model
from nrchain.notices import ignore
from nrchain.outcome import Cause, Stop
from nrchain.planning.auto import choose
from nrchain.planning.choice import Choice
from nrchain.planning.integrator import integrator_of
from nrchain.run import preparation
from nrchain.run.preparation import Start, check_start, make_integrator, make_watches
from nrchain.scene.poses import initial_poses


def watches_of(scene, choice=None):
    start = Start(scene, initial_poses(scene), choice)
    integrator = make_integrator(scene, ChartedChain(Model(scene)))
    return make_watches(start, start.begin, integrator, ignore)


@pytest.mark.parametrize(
    ("friction", "watched"),
    [("one-body", False), ("pairwise", False), ({"kind": "pairwise", "neighbours": 1}, True)],
)
def test_only_friction_that_is_cut_is_watched(friction, watched):
    scene = nrchain.load_scene({"chain.particles": 10, "run.end": 1.0, "friction": friction})
    assert (watches_of(scene).friction is not None) == watched


@pytest.mark.parametrize(
    ("left_out", "until", "watched"),
    [((), np.inf, False), (("pairs",), 2.0, False), (("pairs",), np.inf, True)],
)
def test_effects_are_watched_where_some_are_left_out_and_the_run_is_not_unwatched(
    left_out, until, watched
):
    scene = nrchain.load_scene("stable")
    choice = Choice(0.1, left_out, 0.0, 0.0, (0.0,), (0.0,), "no reason", watched_until=until)
    assert (watches_of(scene, choice).neglected is not None) == watched


def test_growth_is_reported_where_no_warning_of_the_start_said_so(monkeypatch):
    """A run repeats no warning of its start."""
    seen = []
    real = preparation.GrowthWatch

    def watch(*arguments, warned_of_straight, **options):
        seen.append(warned_of_straight)
        return real(*arguments, warned_of_straight=warned_of_straight, **options)

    monkeypatch.setattr(preparation, "GrowthWatch", watch)
    nrchain.simulate(nrchain.load_scene("stable", **{"run.end": 1.0}))
    with pytest.warns(nrchain.SceneWarning, match="straight"):
        nrchain.simulate(nrchain.load_scene("buckling", **{"start.shape": "straight"}))
    assert seen == [False, True]


def test_a_start_names_its_effects_and_holds_the_poses_given():
    scene = nrchain.load_scene("stable", effects="auto", tolerance=0.1)
    positions, frames = initial_poses(scene)
    start = check_start(scene, positions + 1.0, frames)
    assert start.scene.effects == "named"
    assert start.scene.start.shape == "given"
    np.testing.assert_array_equal(start.begin[0], positions + 1.0)
    assert start.choice.tolerance == 0.1


def test_a_run_that_bends_more_than_its_probe_breaks_the_bound():
    """A passive chain that straightens leaves friction between its spheres out."""
    changes = {"run.end": 4.0, "run.snapshots": 81, "effects": "auto", "tolerance": 0.02}
    scene, choice = choose(nrchain.load_scene("passive", **changes))
    positions, frames = initial_poses(scene)
    watch = watches_of(scene, choice).neglected
    watch.check(0.0, (positions, frames))
    bent = positions + np.sin(np.arange(20))[:, None] * [0.0, 2.0, 0.0]
    with pytest.raises(Stop, match="effects left out move a sphere") as stop:
        watch.check(scene.run.end, (bent, frames))
    assert stop.value.cause is Cause.NEGLECTED


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({}, "radau"),
        ({"slip.neighbours": 8}, "radau"),
        ({"slip.neighbours": "all"}, "cvode"),
        ({"friction": "pairwise"}, "cvode"),
        ({"flow.gradient": [[0, 0, 1e-3], [0, 0, 0], [0, 0, 0]]}, "cvode"),
        (
            {"flow.gradient": [[0, 0, 1e-3], [0, 0, 0], [0, 0, 0]], "flow.disturbance": False},
            "radau",
        ),
        ({"field.force": [0, 0, -1.0]}, "radau"),
        ({"run.integrator": "scipy-bdf"}, "scipy-bdf"),
    ],
)
def test_the_integrator_follows_from_the_reach_of_interactions(changes, name):
    keys = {"chain.ends": "free", "chain.particles": 24}
    scene = nrchain.load_scene("buckling", **(keys | changes))
    assert make_integrator(scene, ChartedChain(Model(scene))).name == name
    assert integrator_of(scene) == name


@pytest.mark.parametrize(("name", "part"), [("radau", 1.0), ("cvode", 0.05), ("scipy-bdf", 1 / 30)])
def test_steps_have_a_share_of_the_tolerance_of_the_run(name, part):
    keys = {"chain.radius": 0.5, "run.rtol": 1e-5, "run.atol": 1e-7, "run.integrator": name}
    scene = nrchain.load_scene("buckling", **keys)
    integrator = make_integrator(scene, ChartedChain(Model(scene)))
    assert integrator.rtol == pytest.approx(part * 1e-5)
    # in units of length for positions, in radians for rotations
    assert integrator.atol[:6] == pytest.approx(part * 1e-7 * np.repeat([0.5, 1.0], 3))
    finest = nrchain.load_scene(scene, **{"run.rtol": 1e-14, "run.atol": 1e-14})
    assert make_integrator(finest, ChartedChain(Model(finest))).atol[5] == 1e-14
