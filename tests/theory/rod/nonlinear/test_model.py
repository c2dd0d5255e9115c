"""The twists of the nodes: virtual power, exact derivative, balance, symmetries, known states.

The reference is :meth:`CosseratRod.strains`, NumPy on the definition of the strains, and closed
forms.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nrchain import Material, rod
from nrchain.theory.rod.constants import cross

STEP = 1e-5


def any_material(seed=1, odd=True):
    rng = np.random.default_rng(seed)
    C, H, root = rng.normal(size=(3, 6, 6))
    drag = root @ root.T + np.eye(6)
    C = C if odd else C + C.T
    return Material.from_numbers(C, H, rng.normal(size=6), rng.normal(size=6), drag)


def any_rod(ends="free", **options):
    rng = np.random.default_rng(2)
    further = {"quadratic": rng.normal(size=(12, 6, 6)), "end_length": 0.1}
    further |= {"end_wrench": rng.normal(size=6), "elements": 3, "degree": 4} | options
    return rod.CosseratRod(any_material(), 1.7, ends=ends, **further)


def any_poses(shape, seed=3):
    """Rough poses, far from any uniform state."""
    rng = np.random.default_rng(seed)
    positions, frames = shape.bent(0.3 * rng.normal(size=6))
    if shape.ends == "periodic":
        positions = np.column_stack([shape.places, np.zeros((len(shape.places), 2))])
    left, _, right = np.linalg.svd(frames + 0.1 * rng.normal(size=frames.shape))
    return positions + 0.05 * rng.normal(size=positions.shape), left @ right


def moved(positions, frames, node, axis, step):
    r, e = positions.copy(), frames.copy()
    if axis < 3:
        r[node, axis] += step
    else:
        e[node] = e[node] @ Rotation.from_rotvec(step * np.eye(3)[axis - 3]).as_matrix().T
    return r, e


def differences(function, poses, count):
    """Central differences by displacements and rotations (…, N, 6)."""
    columns = [
        [
            (function(*moved(*poses, i, p, STEP)) - function(*moved(*poses, i, p, -STEP)))
            / (2 * STEP)
            for p in range(6)
        ]
        for i in range(count)
    ]
    return np.moveaxis(np.array(columns), (0, 1), (-2, -1))


def responses(shape, strains):
    c = shape.material.constants
    total = np.concatenate([c.prestress, c.presource]) + strains @ np.vstack([c.C, c.H]).T
    return total + np.einsum("rab,eka,ekb->ekr", shape.quadratic, strains, strains)


def dense(shape, positions, frames):
    model = shape.model
    blocks = np.empty((model.count, 2 * model.reach + 1, 6, 6))
    model.linearise(positions, frames, blocks)
    full = np.zeros((model.count, 6, model.count, 6))
    for i in range(model.count):
        for m in range(2 * model.reach + 1):
            j = i + m - model.reach
            if model.period or 0 <= j < model.count:
                full[i, :, j % model.count] += blocks[i, m]
    return full


@pytest.mark.parametrize("ends", ["free", "clamped", "periodic"])
def test_wrenches_do_the_virtual_work_of_stress_and_sources(ends):
    shape = any_rod(ends)
    positions, frames = any_poses(shape)
    count, nodes, weights = shape.model.count, shape.elements.nodes, shape.elements.weights
    response = responses(shape, shape.strains(positions, frames))
    change = differences(shape.strains, (positions, frames), count)
    wrenches = -np.einsum("k,ekr,ekrip->ip", weights, response[..., :6], change)
    for i, node in enumerate(nodes):
        for h in (0, 3):
            part = response[i, :, 6 + h : 9 + h]
            lab = np.einsum("k,kap,ka->kp", weights, frames[node], part)
            np.add.at(wrenches, (node, slice(h, h + 3)), lab)
    if ends == "free":
        push = np.random.default_rng(2)
        push.normal(size=(12, 6, 6))
        body = push.normal(size=6).reshape(2, 3)
        for i in (0, -1):
            wrenches[i] += (body @ frames[i]).ravel()
    expected = np.empty((count, 6))
    for i, e in enumerate(frames):
        turn = np.kron(np.eye(2), e.T)
        expected[i] = turn @ np.linalg.solve(shape.drags[i], turn.T @ wrenches[i])
    expected[shape.model.held] = 0.0
    found = shape.model.twists(positions, frames)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("ends", ["free", "clamped", "periodic"])
def test_derivative_is_that_of_the_twists(ends):
    shape = any_rod(ends)
    poses = any_poses(shape)
    expected = differences(lambda r, e: shape.model.twists(r, e).copy(), poses, shape.model.count)
    found = dense(shape, *poses)
    found[shape.model.held] = 0.0
    assert np.abs(found - expected).max() < 3e-9 * np.abs(expected).max()


def test_stress_without_an_energy_exerts_no_force_and_no_torque():
    C = np.random.default_rng(4).normal(size=(6, 6))
    shape = rod.CosseratRod(Material.from_numbers(C, prestress=np.ones(6), drag=np.eye(6)), 1.3)
    positions, frames = any_poses(shape)
    wrenches = np.einsum("nij,nj->ni", shape.drags, shape.model.twists(positions, frames))
    torque = wrenches[:, 3:] + np.cross(positions, wrenches[:, :3])
    size = np.abs(wrenches).sum()
    assert np.abs(wrenches[:, :3].sum(axis=0)).max() < 1e-14 * size
    assert np.abs(torque.sum(axis=0)).max() < 1e-14 * size


def test_uniform_strain_moves_inner_nodes_alike():
    """(∂_s + τ ×) F + f and (∂_s + τ ×) M + h × F + m of a helix, over Γ."""
    material, strain = any_material(), np.array([0.05, -0.03, 0.02, 0.4, -0.3, 0.5])
    shape = rod.CosseratRod(material, 1.3, elements=1, degree=20, ends="clamped")
    positions, frames = shape.bent(strain)
    F, M = material.stress(strain).reshape(2, 3)
    f, m = material.source(strain).reshape(2, 3)
    turn, along = cross(strain[3:]), cross(np.array([1.0, 0.0, 0.0]) + strain[:3])
    load = np.concatenate([turn @ F + f, turn @ M + along @ F + m])
    expected = np.linalg.solve(material.drag, load)
    twists = shape.model.twists(positions, frames).reshape(-1, 2, 3)
    found = np.einsum("nap,nhp->nha", frames, twists).reshape(-1, 6)[1:-1]
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


def test_error_of_a_known_motion_falls_exponentially_with_degree():
    """Twists on a curve with given strains, against stresses differentiated by Chebyshev series."""
    material = any_material(5)

    def poses_at(s):
        angles = np.stack([0.4 * np.sin(2 * s), 0.3 * np.cos(s), 0.5 * s], axis=-1)
        r = np.stack([s + 0.1 * np.sin(s), 0.2 * np.sin(3 * s), 0.1 * np.cos(2 * s)], axis=-1)
        return r, Rotation.from_euler("zyx", angles).as_matrix().swapaxes(-1, -2)

    fine = np.polynomial.chebyshev.chebpts2(64)
    vandermonde = np.polynomial.chebyshev.chebvander(fine, 63)
    derivative = np.linalg.solve(
        vandermonde.T,
        np.polynomial.chebyshev.chebval(
            fine, np.polynomial.chebyshev.chebder(np.eye(64), axis=0), tensor=True
        ),
    ).T
    r, e = poses_at(0.5 * (fine + 1.0))
    slope = np.einsum("kl,lp->kp", 2 * derivative, r)
    turned = np.einsum("kap,kl,lbp->kab", e, 2 * derivative, e)
    strain = np.einsum("kap,kp->ka", e, slope) - [1.0, 0.0, 0.0]
    twist = np.stack([turned[:, 2, 1], turned[:, 0, 2], turned[:, 1, 0]], axis=1)
    x = np.hstack([strain, twist])
    F, M, f, m = (
        np.einsum("ka,kap->kp", part, e)
        for part in np.hstack([material.stress(x), material.source(x)])
        .reshape(-1, 4, 3)
        .swapaxes(0, 1)
    )
    loads = np.hstack([2 * derivative @ F + f, 2 * derivative @ M + np.cross(slope, F) + m])
    errors = []
    for degree in (6, 10, 14, 18):
        shape = rod.CosseratRod(material, 1.0, elements=1, degree=degree, ends="clamped")
        positions, frames = poses_at(shape.places)
        at = np.polynomial.chebyshev.chebvander(2 * shape.places - 1, 63)
        exact = at @ np.linalg.solve(vandermonde, loads)
        found = shape.model.twists(positions, frames)
        for i in range(1, degree):
            turn = np.kron(np.eye(2), frames[i].T)
            exact[i] = turn @ np.linalg.solve(material.drag, turn.T @ exact[i])
        errors.append(np.abs(found - exact)[1:-1].max() / np.abs(exact).max())
    falls = np.diff(np.log10(errors)) / 4.0
    assert falls.max() < -0.5
    assert errors[-1] < 1e-8


@pytest.mark.parametrize("wave", [1, 2])
def test_waves_of_the_straight_rod_have_its_symbol(wave):
    """All six branches: J on cosines and sines, against :func:`rod.rod_symbol`."""
    from nrchain import load_scene

    scene = load_scene("spiral-left", **{"slip.2s": 20.0, "slip.3t": 30.0, "slip.3a": 300.0})
    material = Material.of(scene)
    shape = rod.CosseratRod(material, 2.0, elements=3, degree=14, ends="periodic")
    positions, frames = shape.bent(np.zeros(6))
    q = 2.0 * np.pi * wave / shape.length
    jacobian = dense(shape, positions, frames).reshape(6 * shape.model.count, -1)
    phases = np.exp(1j * q * shape.places)
    spin = shape.model.twists(positions, frames)[0, 3:]
    expected = rod.rod_symbol(material).operator(q)
    found = np.empty((6, 6), complex)
    for column in range(6):
        poses = np.zeros((len(phases), 6), complex)
        poses[:, column] = phases
        rates = (jacobian @ poses.ravel()).reshape(-1, 6) / phases[:, None]
        assert np.ptp(rates.real, axis=0).max() < 1e-5 * np.abs(rates).max()
        found[:, column] = rates.mean(axis=0)
    found[3:, 3:] += cross(spin)
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()
    gaps = np.abs(np.linalg.eigvals(found)[:, None] - np.linalg.eigvals(expected)).min(axis=1)
    assert gaps.max() < 1e-6 * np.abs(expected).max()
