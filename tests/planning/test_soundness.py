"""Random scenes judged sound hold in runs. A warning names each weakness and a remedy."""

import re
from itertools import product

import numpy as np
import pytest
from support.graded_chains import opposed
from support.plan_scenes import random_scene
from support.selection import few_of

import nrchain
from nrchain.outcome import Cause
from nrchain.planning.regime import warnings
from nrchain.planning.remedies import holds, remedy
from nrchain.planning.soundness import judge
from nrchain.planning.weaknesses import Weak

TORN = 0.5
"""A bond that has changed by this part of d is torn."""

SHARE = 0.05
"""The share of scenes judged sound that may still fail; the test lists them."""


def own_moduli(ends, **elasticity):
    """Pushers on a chain with soft springs of twist and bend."""
    soft = {"stretch": 5.0, "shear": 50.0, "twist": 10.0, "bend": 10.0} | elasticity
    return nrchain.load_scene(
        {
            "chain": {"particles": 20, "ends": ends},
            "elasticity": soft,
            "slip.2s": 100.0,
            "start.shape": "random",
            "run": {"end": 300.0, "snapshots": 2},
        }
    )


ELASTICITIES = [{}, {"shear": 4.0, "bend": 300.0}, {"bend": 100.0, "twist": 2e3}]


def gives_way(scene):
    """Whether a run tears a bond, turns a link over or lets spheres touch; and how."""
    loose = {"run.rtol": 1e-5, "run.atol": 1e-6, "run.max_steps": 30_000, "run.snapshots": 2}
    run = nrchain.simulate(nrchain.load_scene(scene, **loose))
    if run.cause in (Cause.TOUCH, Cause.TURN):
        return run.reason
    lengths = np.linalg.norm(np.diff(run.positions[-1], axis=0), axis=1) / scene.chain.spacing
    worst = lengths[np.argmax(np.abs(lengths - 1.0))]
    return f"a bond of {worst:.2g} d" if abs(worst - 1.0) > TORN else ""


def changes_of(text):
    """The keys and values that a remedy names."""
    return {key: float(value) for key, value in re.findall(r"(elasticity\.\w+) = ([\d.e+]+)", text)}


@pytest.mark.parametrize(
    "seeds",
    [
        range(6),
        pytest.param(range(1000, 1300), marks=pytest.mark.slow),
    ],
)
@pytest.mark.filterwarnings("ignore::nrchain.SceneWarning")
def test_chains_judged_sound_do_not_give_way(seeds):
    sound, broken = 0, {}
    for seed in seeds:
        scene = random_scene(seed)
        if judge(scene).sound:
            sound += 1
            if how := gives_way(scene):
                broken[seed] = how
    assert sound > 0.3 * len(seeds)
    assert len(broken) <= SHARE * sound, broken


@pytest.mark.filterwarnings("ignore::nrchain.SceneWarning")
def test_most_chains_that_are_warned_of_give_way():
    """Rules that warn of everything would pass the other tests."""
    warned = [scene for scene in map(random_scene, range(12)) if not judge(scene).sound]
    assert sum(bool(gives_way(scene)) for scene in warned) > 0.6 * len(warned) > 0


@pytest.mark.parametrize(
    "scene",
    [
        opposed(6.0, **{"start.shape": "random"}),
        opposed(
            20.0,
            **{"chain.particles": 40, "slip.3t": [500.0] * 20 + [-500.0] * 20},
            **{"start.shape": "random"},
        ),
    ],
)
def test_halves_that_swim_against_each_other_are_warned_of_and_the_remedy_holds(scene):
    found = judge(scene)
    kinds = {weakness.kind for weakness in found.weaknesses}
    assert {Weak.TOUCH, Weak.STRETCH} <= kinds
    assert "touch" in gives_way(scene)
    (warning,) = warnings(scene)
    assert warning.startswith("out of the beam limit: spheres")
    changes = changes_of(warning)
    assert set(changes) >= {"elasticity.stretch", "elasticity.shear"}
    held = nrchain.load_scene(scene, **changes)
    assert not warnings(held)
    assert not gives_way(held)


@pytest.mark.parametrize(
    ("ends", "elasticity"),
    few_of(
        product(["free", "clamped"], ELASTICITIES),
        [("free", ELASTICITIES[0]), *product(["clamped"], ELASTICITIES)],
    ),
)
def test_a_remedy_is_offered_only_if_the_scene_with_it_holds(ends, elasticity):
    """With stiffer bonds alone twist or bend would fail. The scene with the remedy is run."""
    scene = own_moduli(ends, **elasticity)
    assert not judge(scene).sound
    assert gives_way(scene)
    stiffer = nrchain.load_scene(scene, **{"elasticity.stretch": 17.0, "elasticity.shear": 50.0})
    if gives_way(stiffer):
        assert not judge(stiffer).sound
    text = remedy(scene)
    changes = changes_of(text)
    if not changes:
        part = float(re.search(r"([\d.]+) times these strengths", text)[1])
        changes = {"slip.2s": part * 100.0}
    assert holds(scene, changes)
    assert not gives_way(nrchain.load_scene(scene, **changes))


def test_bonds_of_pullers_that_stretch_by_themselves_tear_in_the_run():
    """Pullers draw the nearer of two neighbours nearer: −2γ_T(7a²/3d³)V beats λ∥ at some V."""
    stiff = {"twist": 2e3, "bend": 2e3, "shear": 500.0}
    scene = nrchain.load_scene(own_moduli("clamped", **stiff), **{"slip.2s": -100.0})
    assert Weak.STRETCH in {weakness.kind for weakness in judge(scene).weaknesses}
    assert gives_way(scene)


def test_links_without_springs_of_bend_turn_over_in_the_bend_that_grows():
    scene = own_moduli("clamped", stretch=500.0, shear=500.0, twist=2e3, bend=0.0)
    assert Weak.BEND in {weakness.kind for weakness in judge(scene).weaknesses}
    assert "turned" in gives_way(scene)


def test_soft_springs_of_twist_are_warned_of_where_bends_load_them():
    """Bonds and bends hold, and the links turn over about e₁ at t = 271."""
    scene = own_moduli("clamped", stretch=19.0, shear=15.0, twist=37.0, bend=1100.0)
    assert {weakness.kind for weakness in judge(scene).weaknesses} == {Weak.TWIST}
    assert "turned" in gives_way(scene)


def test_a_remedy_is_the_least_of_its_kind_to_a_tenth():
    scene = own_moduli("clamped", twist=2e3, bend=2e3, stretch=500.0, shear=5.0)
    (changes,) = (changes_of(remedy(scene)),)
    assert list(changes) == ["elasticity.shear"]
    assert not holds(scene, {key: 0.9 * value for key, value in changes.items()})


def test_a_warning_without_a_remedy_says_so():
    """A flow that pulls a chain without springs of stretch apart."""
    scene = nrchain.load_scene(
        {
            "chain.particles": 8,
            "elasticity": {"stretch": 0.0, "shear": 0.0},
            "flow": {"gradient": [[0.02, 0, 0], [0, -0.01, 0], [0, 0, -0.01]]},
            "run.end": 100.0,
        }
    )
    assert remedy(scene).startswith("no remedy was found")


def test_bends_cause_tensions_that_clamped_ends_keep_from_straight_links():
    """The straight chain of pushers between clamps has no tension; its bends stretch it."""
    soft = {"elasticity": {"ratio": None, "stretch": 5.0, "shear": 500.0}}
    scene = nrchain.load_scene("buckling", **soft, **{"run.end": 3000.0})
    found = judge(scene)
    assert not found.loads.tension.any()
    assert found.carried.tension == pytest.approx(np.full(19, 43.98), rel=1e-3)
    run = nrchain.simulate(nrchain.load_scene(scene, **{"run.snapshots": 2}))
    lengths = np.linalg.norm(np.diff(run.positions[-1], axis=0), axis=1)
    assert lengths.max() > 1.3 * 10.0
    assert judge(nrchain.load_scene(scene, **{"slip.2s": -50.0, "elasticity.stretch": 10.0})).sound
    assert judge(nrchain.load_scene(scene, **{"run.end": 5.0})).bends is False


def test_the_judgement_does_not_depend_on_units():
    """Lengths times 3 and times times 7: every judgement is of ratios."""
    scene = random_scene(5)
    chain, slip = scene.chain, scene.slip.modes
    longer, slower, thicker = 3.0, 7.0, 5.0
    force = thicker * longer**2 / slower
    changes = {
        "chain.radius": longer * chain.radius,
        "chain.spacing": longer * chain.spacing,
        "chain.viscosity": thicker * chain.viscosity,
        "elasticity.stretch": force / longer * scene.moduli.stretch,
        "elasticity.shear": force / longer * scene.moduli.shear,
        "elasticity.twist": force * longer * scene.moduli.twist,
        "elasticity.bend": force * longer * scene.moduli.bend,
        "start.amplitude": longer * scene.start.amplitude,
        "run.end": slower * scene.run.end,
    }
    for label, mode in slip.items():
        each = np.atleast_1d(mode.strength) * longer / slower
        changes[f"slip.{label}"] = each.tolist() if each.size > 1 else float(each[0])
    own, other = judge(scene), judge(nrchain.load_scene(scene, **changes))
    assert [one.kind for one in own.weaknesses] == [one.kind for one in other.weaknesses]
    assert other.loads.tension == pytest.approx(force * own.loads.tension, rel=1e-9, abs=1e-9)
    assert other.loads.spin * slower == pytest.approx(own.loads.spin, rel=1e-9)
