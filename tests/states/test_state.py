"""States from a guess or a nudge, against runs that settle, move and return."""

from __future__ import annotations

import numpy as np
import pytest
from support.poses import rigid_motion

import nrchain
from nrchain.comoving.motions import moved
from nrchain.errors import SceneError
from nrchain.states.state import _nudged

UNITS = {"chain.radius": 1.3, "chain.viscosity": 0.7, "chain.spacing": 9.0}
TIGHT = {"run.rtol": 1e-9, "run.atol": 1e-9}
MIX = {
    "slip.2s": 60.0,
    "slip.3t": 1000.0,
    "elasticity.ratio": 1e8,
    "elasticity.measure": "isotropic",
}


def pushers(**changes):
    """A clamped chain of eight that buckles."""
    keys = {"chain.particles": 8, "slip.2s": 300.0, "elasticity.ratio": 1e8}
    return nrchain.load_scene("buckling", **UNITS | keys | changes)


def settled(scene, state, end):
    """The state as a run leaves it that starts a little off, and the shift of its spheres."""
    rng = np.random.default_rng(2)
    shift = np.zeros((scene.chain.particles, 6))
    shift[1:-1] = 1e-2 * rng.standard_normal((scene.chain.particles - 2, 6))
    changed = nrchain.load_scene(scene, **TIGHT | {"run.end": end, "run.snapshots": 41})
    positions, frames = moved(*state.poses, shift)
    return nrchain.simulate(changed, positions=positions, frames=frames)


def test_a_nudge_leads_to_the_state_that_a_run_settles_in():
    scene = pushers()
    straight, bent = nrchain.find_state(scene), nrchain.find_state(scene, nudge=0.1)
    assert not straight.is_stable
    assert bent.is_stable
    assert bent.residual < 1e-10
    run = settled(scene, bent, 400.0)
    # a turn about the axis of the clamps decays more slowly than the run is long
    radii = np.linalg.norm(run.positions[-1][:, 1:], axis=1)
    assert radii == pytest.approx(np.linalg.norm(bent.positions[:, 1:], axis=1), abs=1e-6)


def test_a_run_returns_at_the_leading_rate():
    """The distance from the state decays as exp(Λ₁ t), within 1 %."""
    scene = pushers()
    bent = nrchain.find_state(scene, nudge=0.1)
    mode = bent.spectrum.leading
    run = settled(scene, bent, 6.0 / -mode.growth)
    away = moved_away(run, bent)
    amplitudes = np.abs(np.einsum("npq,tpq->tn", mode.left.conj()[:1].real, away)[:, 0])
    late = slice(15, 35)
    slope = np.polyfit(run.time[late], np.log(amplitudes[late]), 1)[0]
    assert slope == pytest.approx(mode.growth, rel=0.01)


def moved_away(run, state):
    """(u, φ) (T, N, 6) by which the poses of a run are displaced and rotated from a state."""
    turns = np.einsum("tnji,njk->tnik", run.frames, state.frames)
    axial = 0.5 * np.stack(
        [
            turns[..., 1, 2] - turns[..., 2, 1],
            turns[..., 2, 0] - turns[..., 0, 2],
            turns[..., 0, 1] - turns[..., 1, 0],
        ],
        axis=-1,
    )
    return np.concatenate([run.positions - state.positions, axial], axis=-1)


@pytest.mark.parametrize("nudge", [1e-5, 1.0])
def test_the_size_of_a_nudge_does_not_matter(nudge):
    """Steps are long beside 1/σ: one that goes backward would end in the straight state."""
    found, usual = (nrchain.find_state(pushers(), nudge=size) for size in (nudge, 0.1))
    assert found.is_stable
    assert found.positions == pytest.approx(usual.positions, abs=1e-6)


def test_a_nudge_is_a_displacement_in_radii_or_a_rotation():
    scene = pushers(**{"elasticity.measure": "isotropic"})
    straight = nrchain.find_state(scene).poses
    positions, frames = _nudged(scene, None, 0.2)
    moves = np.linalg.norm(positions - straight[0], axis=1) / scene.chain.radius
    cosines = 0.5 * (np.einsum("nap,nap->n", frames, straight[1]) - 1.0)
    turns = 2.0 * np.tan(0.5 * np.arccos(np.clip(cosines, -1.0, 1.0)))
    assert max(moves.max(), turns.max()) == pytest.approx(0.2, rel=1e-9)


def test_opposite_nudges_lead_to_mirror_images():
    scene = pushers(**{"elasticity.measure": "isotropic"})
    one, other = (nrchain.find_state(scene, nudge=sign * 0.1) for sign in (1.0, -1.0))
    assert one.positions[:, 1:] == pytest.approx(-other.positions[:, 1:], abs=1e-6)
    assert np.abs(one.positions[:, 1:]).max() > 0.5 * scene.chain.radius


def test_a_mix_of_2s_and_3t_goes_round_its_axis():
    """Radius 4.476 a and period 373.15: those of the run that oscillates by itself (N = 20)."""
    scene = nrchain.load_scene("buckling", **MIX)
    found = nrchain.find_state(scene, nudge=0.1)
    assert found.is_stable
    assert np.linalg.norm(found.positions[:, 1:], axis=1).max() == pytest.approx(4.476, abs=1e-3)
    rate = found.rotation[0]
    assert 2.0 * np.pi / abs(rate) == pytest.approx(373.15, abs=0.01)
    assert found.turn == pytest.approx(-rate, rel=1e-9)
    changed = nrchain.load_scene(scene, **TIGHT | {"run.end": 100.0, "run.snapshots": 2})
    run = nrchain.simulate(changed, positions=found.positions, frames=found.frames)
    angle = 100.0 * rate
    across = found.positions[:, 1] + 1j * found.positions[:, 2]
    expected = across * np.exp(1j * angle)
    reached = run.positions[-1][:, 1] + 1j * run.positions[-1][:, 2]
    assert reached == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("reach", [1, "all"])
def test_a_free_chain_swims_and_spins_as_found(reach):
    """A bent chain of graded strengths moves as a whole with V and Ω, whatever the frame."""
    strengths = np.linspace(0.5, 1.5, 6)
    table = {
        "chain": {"particles": 6, "ends": "free"},
        "elasticity": {"stretch": 30.0, "shear": 40.0, "twist": 900.0, "bend": 700.0},
        "slip": {"3t": (40.0 * strengths).tolist(), "4a": (60.0 * strengths).tolist()},
        "slip.neighbours": reach,
        "start.shape": "straight",
        "run": {"end": 5.0, "snapshots": 2},
    }
    scene = nrchain.load_scene(table | UNITS | TIGHT)
    found = nrchain.find_state(scene)
    assert found.spectrum.neutral.rates.size == 6
    run = nrchain.simulate(scene, positions=found.positions, frames=found.frames)
    moved_by = run.positions[-1] - found.positions
    assert moved_by == pytest.approx(np.broadcast_to(5.0 * found.velocity, (6, 3)), abs=1e-6)
    *turned, _ = rigid_motion(*found.poses)
    again = nrchain.find_state(scene, turned)
    assert np.linalg.norm(again.velocity) == pytest.approx(np.linalg.norm(found.velocity))


def test_a_far_guess_is_followed_to_the_state_that_attracts_it():
    """An arc more than d off, with frames that do not follow it, relaxes to the buckled state."""
    scene = pushers()
    bent = nrchain.find_state(scene, nudge=0.1)
    positions, frames = (array.copy() for array in nrchain.find_state(scene).poses)
    side = bent.positions[3, 1:] / np.linalg.norm(bent.positions[3, 1:])
    arc = 1.1 * scene.chain.spacing * np.sin(np.linspace(0.0, np.pi, 8))
    positions[:, 1:] += arc[:, None] * side
    found = nrchain.find_state(scene, (positions, frames))
    assert found.is_stable
    radii = [np.linalg.norm(one.positions[:, 1:], axis=1) for one in (found, bent)]
    assert radii[0] == pytest.approx(radii[1], abs=1e-6)


def test_a_flow_that_forbids_a_state_is_named():
    shear = [[0.0, 0.5, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]
    scene = nrchain.load_scene("wave", **{"flow.gradient": shear, "chain.particles": 6})
    guess = nrchain.simulate(nrchain.load_scene(scene, **{"run.end": 1.0}))
    with pytest.raises(SceneError, match=r"flow\.gradient.*no state of steady motion"):
        nrchain.find_state(scene, guess)


@pytest.mark.parametrize("nudge", [np.nan, "far", None])
def test_a_nudge_is_a_number(nudge):
    with pytest.raises(SceneError, match=r"nudge = .*finite number"):
        nrchain.find_state(pushers(), nudge=nudge)


@pytest.mark.parametrize("nudge", [1e-3, -0.3])
def test_a_nudge_along_a_twist_is_an_angle(nudge):
    """The slowest mode of soft twist displaces no sphere; a stable chain comes back."""
    soft = {"chain.particles": 6, "elasticity.twist": 10.0}
    found = nrchain.find_state(nrchain.load_scene("stable", **soft), nudge=nudge)
    assert np.abs(found.spectrum.leading.right[:, :, :3]).max() < 1e-9
    assert found.is_stable
    assert np.abs(found.positions[:, 1:]).max() < 1e-6


def test_a_free_chain_sediments_across_its_axis():
    """V = F/γ_T for every sphere, whichever way the force points."""
    changes = {"chain.particles": 8, "chain.ends": "free", "slip.2s": 50.0}
    scene = nrchain.load_scene("buckling", **UNITS | changes, **{"field.force": [0.0, 1.0, 0.0]})
    found = nrchain.find_state(scene)
    expected = [0.0, 1.0 / scene.drag.translation, 0.0]
    assert found.velocity == pytest.approx(expected, abs=1e-12)
    # the force moves all spheres alike: the chain keeps any orientation
    assert found.spectrum.neutral.names[3:] == tuple(f"rotation about {axis}" for axis in "xyz")
    assert found.is_stable


def test_a_force_on_clamped_spheres_or_with_friction_between_them_leaves_fewer_motions():
    """Rotations across the force change how fast spheres sediment beside each other."""
    force = {"field.force": [0.0, 1.0, 0.0], "chain.particles": 6, "slip.2s": 20.0}
    pairs = nrchain.load_scene(
        "buckling", **force, **{"chain.ends": "free", "friction": "pairwise"}
    )
    found = nrchain.find_state(pairs)
    assert found.spectrum.neutral.names[3:] == ("rotation about y",)
    isotropic = {"elasticity.measure": "isotropic"}
    clamped = nrchain.find_state(nrchain.load_scene("buckling", **force | isotropic))
    assert not clamped.spectrum.neutral.names
    assert clamped.positions[2, 1] > 0.0


def test_a_chain_that_does_not_stay_straight_is_followed_from_there():
    """Slip off the axis bends the chain; the state is that of the run that settles."""
    bent = {"slip.2s": {"strength": 20.0, "axis": [1.0, 1.0, 0.0]}, "chain.particles": 8}
    scene = nrchain.load_scene("buckling", **bent | {"run.end": 2000.0} | TIGHT)
    found, run = nrchain.find_state(scene), nrchain.simulate(scene)
    assert np.linalg.norm(run.positions[-1] - found.positions, axis=1).max() < 1e-4
    assert not found.spectrum.is_straight
    assert nrchain.find_state(pushers()).spectrum.is_straight


def test_a_chain_without_free_spheres_is_refused():
    with pytest.raises(SceneError, match=r"chain\.particles = 2: leaves no sphere free to move"):
        nrchain.find_state(nrchain.load_scene("buckling", **{"chain.particles": 2}))


def test_errors_of_a_guess_call_it_so():
    with pytest.raises(SceneError, match=r"guess = \(7, 3\)"):
        nrchain.find_state(pushers(), (np.zeros((7, 3)), np.broadcast_to(np.eye(3), (7, 3, 3))))


def test_a_long_stiff_chain_is_followed_until_rounding_is_left():
    """Rounding of stiff links keeps velocities far above those of the slow modes times 1e-8."""
    changes = {"chain.particles": 100, "slip.2s": 2.03, "elasticity.measure": "isotropic"}
    stiff = {"elasticity.ratio": None, "elasticity.stretch": 1e3, "elasticity.shear": 1e3}
    found = nrchain.find_state(nrchain.load_scene("buckling", **changes, **stiff), nudge=0.1)
    assert found.is_stable
    assert np.abs(found.positions[:, 1:]).max() > 1.0
    assert found.steps < 60


def test_a_search_without_a_state_names_the_argument_of_find_state():
    scene = nrchain.load_scene("wave", **{"chain.ends": "clamped"})
    with pytest.raises(SceneError, match="has no state: spheres touch") as refused:
        nrchain.find_state(scene)
    assert refused.value.key == "guess"
    with pytest.raises(SceneError, match="has no state: spheres touch") as refused:
        nrchain.spectrum(scene)
    assert refused.value.key == "at"


def test_a_forbidding_effect_is_named_with_its_value():
    shear = ((0.0, 0.5, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    for changes, value in (
        ({"flow.gradient": shear}, shear),
        ({"field.torque": (0.0, 0.0, 3.0)}, {"torque": (0.0, 0.0, 3.0)}),
    ):
        scene = nrchain.load_scene("wave", **changes)
        with pytest.raises(SceneError) as refused:
            nrchain.phases(scene, ("slip.2s", 0.0, 1.0, 2), ("slip.3t", 0.0, 1.0, 2))
        assert refused.value.value == value
