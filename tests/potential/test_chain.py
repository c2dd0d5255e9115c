"""The elastic chain: balance, the straight chain, measures of bend, and the forms as printed.

Its gradient, Jacobian and rigid motions are tested in motion/test_model.py.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from support.configurations import MODULI
from support.poses import dense, pose_derivative, random_chain

import nrchain
from nrchain.errors import SceneError
from nrchain.potential import chain as cosserat
from nrchain.potential.chain import TERMS, Elasticity

SPACING = 2.5
ENDS = ["free", "periodic"]
MEASURES = ["paper", "isotropic"]


def energy(positions, frames, ends="free", **moduli):
    return nrchain.elastic_energy(
        positions, frames, spacing=SPACING, ends=ends, **(MODULI | moduli)
    )


def wrenches(positions, frames, ends="free", **moduli):
    return np.concatenate(
        nrchain.elastic_wrenches(
            positions, frames, spacing=SPACING, ends=ends, **(MODULI | moduli)
        ),
        axis=1,
    )


def elasticity(count, ends, measure="paper", **moduli):
    period = count * SPACING if ends == "periodic" else 0.0
    values = tuple((MODULI | moduli).values())
    return Elasticity(SPACING, period, values, measure == "isotropic", cosserat.terms_of(values))


@given(st.integers(2, 12), st.integers(0, 10**6), st.sampled_from(MEASURES))
def test_open_chain_neither_pushes_nor_turns_itself(count, seed, measure):
    positions, frames = random_chain(count, seed=seed)
    wrench = wrenches(positions, frames, measure=measure)
    scale = np.abs(wrench).max()
    moment = np.cross(positions, wrench[:, :3]) + wrench[:, 3:]
    assert np.abs(wrench[:, :3].sum(axis=0)).max() <= 1e-13 * scale * count
    assert np.abs(moment.sum(axis=0)).max() <= 1e-13 * scale * count * positions[-1, 0]


@pytest.mark.parametrize("ends", ENDS)
def test_straight_chain_is_at_rest(ends):
    positions = SPACING * np.arange(8.0)[:, None] * [1.0, 0, 0]
    frames = np.broadcast_to(np.eye(3), (8, 3, 3)).copy()
    assert energy(positions, frames, ends) == pytest.approx(0, abs=1e-25)
    assert np.abs(wrenches(positions, frames, ends)).max() < 1e-12


@pytest.mark.parametrize("ends", ENDS)
def test_measures_have_the_same_linear_response(ends):
    # about the straight chain the Jacobians are equal; about a chain bent by β they differ by β
    def blocks(bend, measure):
        positions, frames = random_chain(6, noise=0.0, bend=bend)
        out = np.zeros((6, 7, 6, 6))
        elasticity(6, ends, measure).add_jacobian(positions, frames, out)
        return out

    gaps = [np.abs(blocks(b, "paper") - blocks(b, "isotropic")).max() for b in (0.0, 1e-4, 1e-2)]
    assert gaps[0] < 1e-13
    assert gaps[1] < 1e-2
    assert gaps[2] / gaps[1] == pytest.approx(100, rel=0.1)


def test_isotropic_measure_does_not_see_the_frames_turn_about_e1():
    positions, frames = random_chain(6)
    turned = frames.copy()
    turned[:, 1] = np.cos(0.7) * frames[:, 1] + np.sin(0.7) * frames[:, 2]
    turned[:, 2] = np.cos(0.7) * frames[:, 2] - np.sin(0.7) * frames[:, 1]
    here, there = (energy(positions, f, measure="isotropic") for f in (frames, turned))
    assert here == pytest.approx(there, rel=1e-13)
    assert energy(positions, turned) != pytest.approx(energy(positions, frames), rel=1e-3)


def printed_energy(positions, frames):
    """Appendix B link by link in plain NumPy, boundary terms with the ½ and a = 2, 3."""
    total, count = 0.0, len(positions)
    e = [frames[:, a] for a in range(3)]
    for i in range(count - 1):
        inner = 1 <= i <= count - 3
        step = positions[i + 1] - positions[i]
        if inner:
            tangent = (9 / 8 * step - (positions[i + 2] - positions[i - 1]) / 24) / SPACING
            mid = [9 / 16 * (v[i] + v[i + 1]) - (v[i - 1] + v[i + 2]) / 16 for v in e]
        else:
            tangent, mid = step / SPACING, [(v[i] + v[i + 1]) / 2 for v in e]
        total += MODULI["stretch"] * SPACING**2 / 2 * (mid[0] @ tangent - 1) ** 2
        total += MODULI["shear"] * SPACING**2 / 2 * sum((mid[a] @ tangent) ** 2 for a in (1, 2))
        total += MODULI["twist"] / 2 * (e[1][i] @ e[2][i + 1]) ** 2
        bends = (e[0][i] @ e[1][i + 1]) ** 2 + (e[2][i] @ e[0][i + 1]) ** 2
        total += MODULI["bend"] / 2 * bends
    return total


@pytest.mark.parametrize("count", [2, 3, 4, 5, 12])
def test_energy_as_printed(count):
    positions, frames = random_chain(count, seed=7)
    assert energy(positions, frames) == pytest.approx(printed_energy(positions, frames), rel=1e-13)


@pytest.mark.parametrize("kind", MODULI)
def test_moduli_are_separate(kind):
    positions, frames = random_chain(6)
    alone = dict.fromkeys(MODULI, 0.0) | {kind: 2.0}
    doubled = alone | {kind: 4.0}
    assert energy(positions, frames, **alone) > 0
    assert wrenches(positions, frames, **doubled) == pytest.approx(
        2 * wrenches(positions, frames, **alone)
    )
    blocks = np.zeros((6, 7, 6, 6))
    elasticity(6, "free", **alone).add_jacobian(positions, frames, blocks)
    numeric = pose_derivative(lambda r, e: wrenches(r, e, **alone), positions, frames)
    assert dense(blocks, False) == pytest.approx(numeric, abs=1e-7)


def test_terms_without_a_modulus_are_not_in_the_code():
    """Each set of terms has kernels of its own; those of four terms with moduli zero agree."""
    positions, frames = random_chain(6)
    held = elasticity(6, "free", twist=0.0, bend=0.0)
    assert held.terms == ("stretch", "shear")
    everything = Elasticity(SPACING, 0.0, held.moduli, False, TERMS)
    few, all_terms = np.zeros((2, 6, 6))
    held.add_wrenches(positions, frames, few)
    everything.add_wrenches(positions, frames, all_terms)
    assert few == pytest.approx(all_terms, rel=1e-14, abs=1e-14)
    kernels = [cosserat.wrench_kernel(e.terms, False) for e in (held, everything)]
    assert len({kernel.py_func.__qualname__ for kernel in kernels}) == 2
    nothing = elasticity(6, "free", **dict.fromkeys(MODULI, 0.0))
    assert not nothing
    assert not nothing.terms


def test_periodic_chain_does_not_know_where_it_is_cut():
    positions, frames = random_chain(7, seed=3)
    here = wrenches(positions, frames, "periodic")
    cut = np.roll(positions, -2, axis=0)
    cut[-2:, 0] += 7 * SPACING
    there = wrenches(cut, np.roll(frames, -2, axis=0), "periodic")
    assert there == pytest.approx(np.roll(here, -2, axis=0), abs=1e-11)


@settings(max_examples=10)
@given(st.floats(-1e-4, 1e-4))
def test_small_bend_costs_half_mu_beta_squared(angle):
    # one link bent by β about z and nothing else: V = μ⊥ β²/2, to fourth order
    positions = np.array([[0.0, 0, 0], [SPACING, 0, 0]])
    frames = np.array([np.eye(3), np.eye(3)])
    frames[1, :2, :2] = [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]
    bent = energy(positions, frames, stretch=0.0, shear=0.0)
    assert bent == pytest.approx(MODULI["bend"] * angle**2 / 2, rel=1e-7, abs=1e-30)


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"spacing": 0.0}, "spacing"),
        ({"bend": -1.0}, "bend"),
        ({"twist": float("nan")}, "twist"),
        ({"ends": "glued"}, "ends"),
        ({"positions": np.zeros((3, 2))}, "positions"),
        ({"frames": np.zeros((4, 3, 3))}, "frames"),
        ({"frames": -np.broadcast_to(np.eye(3), (4, 3, 3))}, "frames"),
    ],
)
def test_bad_arguments_are_named(changes, key):
    positions, frames = random_chain(4)
    arguments = {"positions": positions, "frames": frames, "spacing": 2.0} | MODULI | changes
    with pytest.raises(SceneError, match=key):
        nrchain.elastic_wrenches(**arguments)
