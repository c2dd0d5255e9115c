"""Every registered effect meets the contract of effects, as does one of a user."""

from dataclasses import dataclass, replace
from typing import Annotated, ClassVar

import numpy as np
import pytest
from support.configurations import each
from support.poses import dense, pose_derivative, random_chain, rigid_motion
from support.spring import Spring, SpringSpec

import nrchain
from nrchain.effects.base import Effect, OneBodyEffect, largest_velocity
from nrchain.effects.registry import acting, effects, find_effect
from nrchain.effects.shared.slip_flow import pairs_within
from nrchain.errors import SceneError, TrajectoryError
from nrchain.hydrodynamics.friction import PairFriction
from nrchain.inputs.rules import Section, number
from nrchain.motion.model import Model

WITHOUT_ENERGY = {"field"}
"""Effects whose forces are no gradient: a force along an axis of a sphere does work in a cycle."""


def make(changes=None, **more):
    """A chain with elasticity."""
    base = {
        "chain": {"particles": 6, "spacing": 4.0, "ends": "free"},
        "elasticity": {"stretch": 3.0, "shear": 5.0, "twist": 7.0, "bend": 11.0},
        "run.end": 1.0,
    }
    return nrchain.load_scene(nrchain.load_scene(base, **(changes or {})), **more)


each_effect = each(lambda c: c.effect is not None and c.ends == "free")
each_evaluated = each(
    lambda c: c.effect is not None and c.effect.gives != "mobility" and c.ends == "free"
)


def result(effect, positions, frames):
    out = np.zeros((len(positions), 6))
    (effect.add_wrenches if effect.gives == "wrench" else effect.add_twists)(positions, frames, out)
    return out


@each_effect
def test_it_says_what_it_is_and_can_be_taken_out(configuration):
    effect, scene = configuration.effect, configuration.scene()
    assert find_effect(effect.name) is effect
    assert effect in acting(scene)
    bare = effect.without(scene)
    assert effect not in acting(bare)
    assert {*acting(bare)} <= {*acting(scene)}
    cost = effect.cost(scene)
    assert cost.visits >= 0
    assert str(cost)
    assert effect.scale(scene) > 0
    for text in (effect.summary, effect.equation, effect.key, effect.detail(scene)):
        assert text
        assert "\n" not in text
    assert nrchain.Scene.from_toml(scene.to_toml()) == scene


def test_friction_is_as_large_as_the_flow_of_the_largest_wrench_at_a_neighbour():
    """Far apart the neighbour moves by what Rotne, Prager and Yamakawa give along the line."""
    a, d, force = 2.5, 500.0, 3.0
    chain = {"particles": 2, "radius": a, "spacing": d, "viscosity": 0.3, "ends": "free"}
    pull = {"field.force": [force, 0, 0], "friction": "pairwise", "run.end": 1.0}
    slack = dict.fromkeys(("stretch", "shear", "twist", "bend"), 0.0)
    scene = nrchain.load_scene({"chain": chain, "elasticity": slack, **pull})
    wrenches = np.zeros((2, 6))
    wrenches[0, 0] = force
    twists = np.zeros((2, 6))
    PairFriction(2, 1, a, 0.3).apply(d * np.array([[0.0, 0, 0], [1, 0, 0]]), wrenches, twists)
    found = find_effect("friction between spheres").scale(scene)
    assert found == pytest.approx(twists[1, 0], rel=(a / d) ** 2)


@each_evaluated
def test_wrenches_are_minus_the_gradient_of_its_energy(configuration):
    """By itself: beside the elasticity a small effect would hide in the rounding."""
    acting_one = configuration.effect(configuration.scene())
    poses = configuration.poses()
    if acting_one.energy is None:
        assert acting_one.gives == "twist" or acting_one.name in WITHOUT_ENERGY
    else:
        slope = pose_derivative(acting_one.energy, *poses)
        assert result(acting_one, *poses) == pytest.approx(-slope, rel=1e-6, abs=1e-6)


@each(lambda c: c.effect is not None and c.effect.gives != "mobility")
def test_products_and_blocks_are_its_derivative(configuration):
    acting_one, count = configuration.effect(configuration.scene()), configuration.count
    poses = configuration.poses()
    numeric = pose_derivative(lambda r, e: result(acting_one, r, e), *poses)
    scale = np.abs(numeric).max() or 1.0
    acting_one.linearise(*poses)
    result(acting_one, *configuration.poses(seed=1, apart=5.0))
    moves, product = np.random.default_rng(2).normal(size=(count, 6)), np.zeros((count, 6))
    acting_one.add_product(moves, product)
    expected = np.einsum("npmq,mq->np", numeric, moves)
    assert product == pytest.approx(expected, abs=1e-7 * scale * count)
    if acting_one.places is not None:
        blocks = np.zeros((count, 2 * max(acting_one.places, 3) + 1, 6, 6))
        acting_one.add_blocks(blocks)
        found = dense(blocks, configuration.ends == "periodic")
        assert found == pytest.approx(numeric, abs=1e-7 * scale)


@each_evaluated
def test_a_rigid_motion_carries_it_along_if_it_says_so(configuration):
    acting_one, poses = configuration.effect(configuration.scene()), configuration.poses()
    positions, frames, turn = rigid_motion(*poses)
    here, there = result(acting_one, *poses), result(acting_one, positions, frames)
    turned = np.concatenate([here[:, :3] @ turn.T, here[:, 3:] @ turn.T], axis=1)
    follows = np.allclose(there, turned, rtol=0, atol=1e-11 * np.abs(here).max())
    assert follows == acting_one.covariant


@each_evaluated
def test_it_depends_on_places_in_the_lab_only_if_it_says_so(configuration):
    acting_one = configuration.effect(configuration.scene())
    positions, frames = configuration.poses()
    shift = np.array([16.0, -8.0, 32.0])
    here, there = (
        result(acting_one, positions, frames),
        result(acting_one, positions + shift, frames),
    )
    stays = np.allclose(there, here, rtol=0, atol=1e-11 * np.abs(here).max())
    assert stays == (not acting_one.placed)


@each_evaluated
def test_balanced_forces_sum_to_nothing_and_energies_give_symmetric_derivatives(configuration):
    effect, scene = configuration.effect, configuration.scene()
    acting_one, poses, count = effect(scene), configuration.poses(), configuration.count
    if effect.gives == "wrench" and effect.balanced(scene):
        forces = result(acting_one, *poses)[:, :3]
        assert np.abs(forces.sum(axis=0)).max() <= 1e-12 * np.abs(forces).max()
    if effect.energy is not None:
        acting_one.linearise(*poses)
        columns = np.zeros((3 * count, count, 6))
        for unit, out in zip(np.eye(3 * count), columns, strict=True):
            moves = np.zeros((count, 6))
            moves[:, :3] = unit.reshape(-1, 3)
            acting_one.add_product(moves, out)
        matrix = columns[:, :, :3].reshape(3 * count, 3 * count)
        assert matrix == pytest.approx(matrix.T, rel=1e-10, abs=1e-10 * np.abs(matrix).max())


@each_evaluated
def test_what_is_absent_is_not_there(configuration):
    """A scene with a zero in the place of the effect has the same model as one without it."""
    effect, scene = configuration.effect, configuration.scene()
    plain = replace(configuration, changes={}).scene()
    zero, bare = Model(effect.without(scene)), Model(plain)
    if effect.name in ("stretch", "shear", "twist", "bend"):
        assert effect.name not in zero.elasticity.terms
    elif effect.name not in ("finite size", "reach", "strain", "finite size of strain"):
        assert zero.effects == bare.effects
        assert (zero.reach, zero.is_banded) == (bare.reach, bare.is_banded)
    assert effect not in zero.effects


@pytest.mark.parametrize(("neighbours", "kept"), [(5, 5), (8, 8), ("all", None)])
def test_flows_of_a_few_neighbours_have_blocks_and_those_of_all_have_none(neighbours, kept):
    """Beyond eight neighbours blocks would cost more than they save."""
    scene = nrchain.load_scene(
        "buckling", **{"chain.particles": 14, "slip.neighbours": neighbours, "chain.ends": "free"}
    )
    assert find_effect("reach")(scene).places == kept
    model = Model(scene)
    assert model.is_banded == (kept is not None)
    assert kept is None or model.reach == kept


def test_an_effect_of_ones_own_runs_is_written_and_resumed(spring, tmp_path):
    assert spring in effects()
    scene = make(spring.example, elasticity={"stretch": 0.0, "shear": 0.0})
    trajectory = nrchain.simulate(scene, output=tmp_path / "run.h5")
    assert trajectory.status == "completed"
    decay = np.exp(-2.0 / scene.drag.translation)
    anchor = np.array([1.0, 2.0, 3.0])
    expected = anchor + decay * (trajectory.positions[0] - anchor)
    assert trajectory.positions[-1] == pytest.approx(expected, abs=1e-5)
    assert ("spring", "stiffness 2, anchor [1, 2, 3]") in nrchain.describe(scene).simulated
    found = nrchain.contributions(scene, trajectory.positions[0], trajectory.frames[0])
    assert found["spring"].wrench[0] == pytest.approx([2.0, 4.0, 6.0, 0, 0, 0])
    assert nrchain.Trajectory.open(tmp_path / "run.h5").scene == scene
    nrchain.unregister_effect(spring)
    with pytest.raises(TrajectoryError, match=r"spring .* nrchain\.register_effect"):
        nrchain.Trajectory.open(tmp_path / "run.h5")
    with pytest.raises(SceneError, match="not a known key"):
        make({"spring.stiffness": 1.0})
    # as in a process that has not registered the effect
    with pytest.raises(SceneError, match=r"not a known key.* nrchain\.register_effect"):
        nrchain.simulate(scene)
    nrchain.register_effect(spring)


def test_keys_of_an_effect_of_ones_own_are_checked(spring):
    with pytest.raises(SceneError, match=r"spring\.stiffness = -1: .* at least 0"):
        make({"spring.stiffness": -1})
    with pytest.raises(SceneError, match=r"spring\.stifness .* did you mean 'stiffness'"):
        make({"spring.stifness": 1})
    endless = {"chain.ends": "periodic", "friction": "pairwise"}
    with pytest.raises(SceneError, match=r"may have a net force.* define Spring\.balanced"):
        make(spring.example, **endless)
    assert make(spring.example, **endless, **{"friction.neighbours": 2}).spring.stiffness
    assert make({"spring.anchor": [1, 0, 0]}).spring.anchor == (1.0, 0.0, 0.0)
    assert make().spring == SpringSpec()
    with pytest.raises(SceneError, match=r"Spring\.straight is not defined"):
        nrchain.lattice_rates(make(spring.example), [0.1])


class Nameless(Effect):
    Section = SpringSpec


class Unmoved(Effect):
    name, summary, equation, Section = "unmoved", "nothing", "0", SpringSpec


@dataclass(frozen=True, slots=True, kw_only=True)
class RunAgain(Section):
    path: ClassVar[str] = "run"


@dataclass(frozen=True, slots=True, kw_only=True)
class Long(Section):
    path: ClassVar[str] = "length"


@dataclass(frozen=True, slots=True, kw_only=True)
class Demanding(Section):
    path: ClassVar[str] = "demanding"
    strength: Annotated[float, number()]


@pytest.mark.parametrize(
    ("effect", "message"),
    [
        (5, "derived from nrchain.Effect"),
        (Nameless, r"Nameless\.name is not given: must be one line of text"),
        (Unmoved, r"unmoved\.add_wrenches is not given: must be defined by the class"),
        (type("A", (Spring,), {"Section": RunAgain}), "key or attribute of every scene"),
        (type("B", (Spring,), {"Section": Demanding}), "default for each key"),
        (
            type("C", (Spring,), {"Section": None}),
            r"Section is not given: must be the section",
        ),
        (type("I", (Spring,), {"summary": 5}), r"I\.summary = 5: must be one line of text"),
        (type("D", (Spring,), {"name": "bend"}), "taken by another effect"),
        (type("E", (Spring,), {"gives": "mobility"}), "wrench, twist"),
        (type("F", (Spring,), {"name": "total"}), "reserved row of decompositions"),
        (type("G", (Spring,), {"Section": Long}), "key or attribute of every scene"),
        (type("H", (Spring,), {"derivative": OneBodyEffect.derivative}), "derivative"),
    ],
)
def test_what_is_no_effect_is_refused(effect, message):
    before = effects()
    with pytest.raises(SceneError, match=message):
        nrchain.register_effect(effect)
    assert effects() == before


def test_what_is_registered_again_says_how_to_replace_it(spring):
    again = type("Spring", (Spring,), {})
    with pytest.raises(SceneError, match=r"nrchain\.unregister_effect\('spring'\) first"):
        nrchain.register_effect(again)
    nrchain.unregister_effect("spring")
    nrchain.register_effect(again)
    assert find_effect("spring") is again
    nrchain.unregister_effect(again)
    nrchain.register_effect(spring)
    for name, message in (("sprung", "not registered"), ("bend", "part of nrchain")):
        with pytest.raises(SceneError, match=message):
            nrchain.unregister_effect(name)


@each_effect
def test_it_passes_the_check_that_users_have(configuration):
    effect, scene = configuration.effect, configuration.scene()
    positions, frames = configuration.poses()
    found = nrchain.check_effect(effect, scene, positions=positions, frames=frames)
    if effect.gives == "mobility":
        assert found == {}
        return
    assert found["product"] < 1e-7
    assert ("rigid motion" in found) == effect.covariant
    assert ("shift" in found) == (not effect.placed)
    assert max(found.get(name, 0.0) for name in ("rigid motion", "shift")) < 1e-10
    assert ("energy" in found) == (effect.energy is not None)


@pytest.mark.parametrize("effect", [e for e in effects() if e.gives != "mobility"])
def test_the_example_of_an_effect_exerts_something_where_it_is_checked(effect):
    assert nrchain.check_effect(effect)["product"] < 1e-7


def test_a_check_where_an_effect_exerts_nothing_is_refused():
    apart = {"steric": {"kind": "harmonic", "strength": 100.0, "range": 2.5}}
    with pytest.raises(SceneError, match="steric repulsion exerts nothing there"):
        nrchain.check_effect(find_effect("steric repulsion"), apart)


def test_poses_to_check_at_are_whole(spring):
    positions, frames = random_chain(6)
    with pytest.raises(SceneError, match="frames is not given: positions and frames must be given"):
        nrchain.check_effect(spring, positions=positions)
    with pytest.raises(SceneError, match="positions"):
        nrchain.check_effect(spring, positions=positions[:2], frames=frames[:2])


def twisting(self, positions, frames, wrenches):
    Spring.add_wrenches(self, positions, frames, wrenches)
    wrenches[:, 3:] += 1.0


def wrong(**attributes):
    return type("Spring", (Spring,), attributes)


@pytest.mark.parametrize(
    ("effect", "message"),
    [
        (wrong(derivative=lambda self, r, e: 0.9 * Spring.derivative(self, r, e)), "add_product"),
        (wrong(energy=lambda self, r, e: 1.1 * Spring.energy(self, r, e)), "energy"),
        (wrong(covariant=True), "covariant"),
        (wrong(placed=False), "placed"),
        (wrong(balanced=classmethod(lambda cls, scene: True)), "net force"),
        (wrong(torque_free=True, energy=None, add_wrenches=twisting), "torque_free"),
        (wrong(add_blocks=lambda self, blocks: None), "add_blocks"),
        (wrong(example={}), "example"),
        (wrong(derivative=lambda self, r, e: np.zeros((2, 6, 6))), r"spring\.\w+ = 'ValueError'"),
        (
            wrong(add_wrenches=lambda self, r, e, out: r.__imul__(2.0)),
            "must not change the given poses",
        ),
    ],
)
def test_the_check_finds_what_is_wrong(effect, message):
    nrchain.register_effect(effect)
    try:
        with pytest.raises(SceneError, match=message):
            nrchain.check_effect(effect)
    finally:
        nrchain.unregister_effect(effect)
    with pytest.raises(SceneError, match="registered first"):
        nrchain.check_effect(effect)


def test_the_order_of_the_list():
    assert [e.name for e in effects()][:5] == ["stretch", "shear", "twist", "bend", "slip 2s"]


@pytest.mark.parametrize("axis", range(3))
def test_the_largest_velocity_is_that_of_a_surface(axis):
    """|v| of the centres and a|ω| of the surfaces, each by its own components alone."""
    twists = np.zeros((2, 6))
    twists[0, 3 + axis] = -7.0
    assert largest_velocity(twists, 0.3) == pytest.approx(0.3 * 7.0)
    twists[1, axis] = -5.0
    assert largest_velocity(twists, 0.3) == 5.0
    assert largest_velocity(twists, 2.0) == 14.0


@pytest.mark.parametrize("ends", ["free", "periodic"])
def test_the_pairs_of_a_reach_are_counted_one_by_one(ends):
    scene = nrchain.load_scene("buckling", **{"chain.particles": 7, "chain.ends": ends})
    images = 3 if ends == "periodic" else 0
    for reach in (1, 2, 3, 6):
        apart = [
            j + 7 * image - i
            for i in range(7)
            for j in range(7)
            for image in range(-images, images + 1)
        ]
        assert pairs_within(scene, reach) == sum(0 < abs(m) <= reach for m in apart)
    assert ends == "periodic" or pairs_within(scene, "all") == 7 * 6
