"""A rigid sphere in a strain: its flow from its definition, from the sphere's surface and resolved.

The flow of the stresslet is one formula; all else follows from it by differences, by the boundary
condition on a rigid sphere, or is compared with spheres that are resolved to convergence.
"""

import numpy as np
import pytest
from support.poses import dense, pose_derivative, random_chain

from nrchain.hydrodynamics.disturbance import Disturbance
from nrchain.hydrodynamics.resolved import ResolvedSpheres

RADIUS = 0.7
GRADIENT = np.array([[0.2, 0.7, -0.3], [0.1, -0.5, 0.4], [0.6, -0.2, 0.3]])
STRAIN = 0.5 * (GRADIENT + GRADIENT.T)
PARTS = ("stresslet", "finite size")
POINT = np.array([1.5, -2.0, 1.2])


def felt(part, point, *, radius=RADIUS, gradient=GRADIENT):
    """(u, w) (6,) at a point, of a sphere in the origin."""
    twists = np.zeros((2, 6))
    pair = Disturbance(part, gradient, count=2, radius=radius, reach=None)
    pair.add_twists(np.array([[0.0, 0.0, 0.0], point]), twists)
    return twists[1]


def stresslet(x):
    """u = −(5a³/2) x (x·E·x)/r⁵, written out independently."""
    return -2.5 * RADIUS**3 * x * (x @ STRAIN @ x) / np.linalg.norm(x) ** 5


def slopes(flow, x, step=3e-3):
    """∂u_p/∂x_q by centred differences, to fourth order in the step."""
    units = step * np.eye(3)
    near = [flow(x + u) - flow(x - u) for u in units]
    far = [flow(x + 2 * u) - flow(x - 2 * u) for u in units]
    return (8 * np.array(near) - np.array(far)).T / (12 * step)


def test_the_stresslet_is_that_of_einstein_and_turns_by_half_its_curl():
    assert felt("stresslet", POINT)[:3] == pytest.approx(stresslet(POINT), rel=1e-13)
    gradient = slopes(stresslet, POINT)
    half_curl = [(gradient[k - 1, k - 2] - gradient[k - 2, k - 1]) / 2 for k in range(3)]
    assert felt("stresslet", POINT)[3:] == pytest.approx(half_curl, rel=1e-6)


def test_the_finite_size_is_the_laplacian_of_the_stresslet():
    """(1 + a²∇²/6)(1 + a²∇²/10) − 1 on it: ∇⁴u = 0, and ∇ × ∇²u = 0."""
    step = 1e-2
    laplacian = -3 * 30.0 * stresslet(POINT)
    for u in step * np.eye(3):
        laplacian += 16.0 * (stresslet(POINT + u) + stresslet(POINT - u))
        laplacian -= stresslet(POINT + 2 * u) + stresslet(POINT - 2 * u)
    laplacian /= 12.0 * step**2
    expected = (1 / 6 + 1 / 10) * RADIUS**2 * laplacian
    found = felt("finite size", POINT)
    assert found[:3] == pytest.approx(expected, rel=1e-5)
    assert not found[3:].any()


@pytest.mark.parametrize("part", PARTS)
def test_the_flow_is_incompressible(part):
    gradient = slopes(lambda x: felt(part, x)[:3], POINT)
    assert np.trace(gradient) == pytest.approx(0.0, abs=1e-8 * np.abs(gradient).max())


def test_the_flow_about_one_sphere_leaves_it_rigid():
    """(1 + a²∇²/10) of the stresslet is −E·x on the sphere: 3/8 of what both factors add."""
    normals = np.random.default_rng(0).standard_normal((20, 3))
    for x in RADIUS * normals / np.linalg.norm(normals, axis=1)[:, None]:
        flow = felt("stresslet", x) + 3 / 8 * felt("finite size", x)
        assert flow[:3] == pytest.approx(-STRAIN @ x, abs=1e-13)


@pytest.mark.parametrize("radius", [RADIUS, 1.0])
@pytest.mark.parametrize("rho", [2.5, 7.0, 30.0])
def test_a_pair_comes_apart_with_the_coefficients_of_batchelor_and_green(radius, rho):
    direction = np.array([2.0, 3.0, 6.0]) / 7.0
    separation, somewhere = rho * radius * direction, np.array([1.0, 2.0, 3.0])
    coefficients = {"stresslet": (5 / rho**3, 0.0), "finite size": (-8 / rho**5, 16 / 3 / rho**5)}
    for part, (along, across) in coefficients.items():
        twists = np.zeros((2, 6))
        pair = Disturbance(part, GRADIENT, count=2, radius=radius, reach=1)
        pair.add_twists(np.array([somewhere, somewhere + separation]), twists)
        pulled = STRAIN @ separation
        lengthwise = direction * (direction @ pulled)
        lost = along * lengthwise + across * (pulled - lengthwise)
        relative = twists[1, :3] - twists[0, :3]
        assert relative == pytest.approx(-lost, abs=1e-12 * np.abs(pulled).max() / rho**3)
        assert twists[1, 3:] == pytest.approx(twists[0, 3:], abs=1e-15)


@pytest.fixture(scope="module")
def resolved():
    """ρ, and A, B and C of two spheres resolved to 1e-7, with ω − ω∞ = C n × (E·n)."""
    rows = []
    strain = np.array([[0.4, 0.3, 0.0], [0.3, -0.1, 0.0], [0.0, 0.0, -0.3]])
    for rho in (3.0, 4.0, 5.0, 6.0, 8.0, 10.0):
        half = 0.5 * rho * RADIUS * np.array([1.0, 0.0, 0.0])
        places = np.array([-half, half])
        spheres = ResolvedSpheres(places, radius=RADIUS, viscosity=2.5, order=12)
        # on each surface the disturbance undoes the strain, up to the motion that is asked for
        flow = spheres.mobility_problem(None, lambda _, normals: -RADIUS * normals @ strain)
        lost = -np.diff(flow.velocities, axis=0)[0] / (rho * RADIUS)
        spin = flow.angular_velocities[1, 2]
        rows.append((rho, lost[0] / strain[0, 0], lost[1] / strain[0, 1], spin / strain[0, 1]))
    return np.array(rows).T


def test_resolved_spheres_have_these_coefficients_up_to_reflections(resolved):
    """Beyond 5/ρ³ − 8/ρ⁵, A has 25/ρ⁶, as published; beyond 16/3ρ⁵, B has what falls off as ρ⁻⁸."""
    rho, along, across, _ = resolved
    assert (along - 5 / rho**3 + 8 / rho**5) * rho**6 == pytest.approx(25.0, rel=0.03)
    rest = (across - 16 / 3 / rho**5) * rho**8
    assert np.all((rest > 0.0) & (rest < 4.0))
    assert rest[-1] == pytest.approx(rest[-2], rel=0.05)  # ρ⁻⁷ would give 1.25 times as much


def test_resolved_spheres_turn_as_the_stresslet_says(resolved):
    """½ curl of the stresslet is (5/2ρ³) n × (E·n); its finite size adds nothing, to ρ⁻⁶."""
    rho, _, _, spin = resolved
    rest = (spin - 2.5 / rho**3) * rho**6
    assert rest[-1] == pytest.approx(rest[-2], rel=0.01)
    assert np.abs(rest).max() < 7.0


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize(("reach", "period"), [(1, 0.0), (None, 0.0), (2, 12.0), (None, 12.0)])
def test_blocks_and_products_are_the_derivative(part, reach, period):
    count = 5
    gradient = GRADIENT if not period else GRADIENT * [0.0, 1.0, 1.0]
    flow = Disturbance(part, gradient, count=count, radius=RADIUS, reach=reach, period=period)
    poses = random_chain(count, spacing=2.4)

    def twists(positions, _):
        out = np.zeros((count, 6))
        flow.add_twists(positions, out)
        return out

    numeric = pose_derivative(twists, *poses)
    scale = np.abs(numeric).max()
    flow.linearise(poses[0])
    twists(random_chain(count, spacing=3.0, seed=3)[0], None)
    moves, product = np.random.default_rng(1).standard_normal((count, 6)), np.zeros((count, 6))
    flow.add_product(moves, product)
    expected = np.einsum("npmq,mq->np", numeric, moves)
    assert product == pytest.approx(expected, abs=1e-7 * scale)
    if flow.near is None:
        return
    blocks = np.zeros((count, 2 * flow.near + 1, 6, 6))
    flow.add_blocks(blocks)
    if flow.near < count:
        assert dense(blocks, period > 0) == pytest.approx(numeric, abs=1e-7 * scale)


@pytest.mark.parametrize("part", PARTS)
def test_all_pairs_of_a_periodic_chain_are_the_sum_over_its_images(part):
    """Images one by one, P on either side, extrapolated to P → ∞."""
    count, period, gradient = 4, 10.0, GRADIENT * [0.0, 1.0, 1.0]
    positions = random_chain(count, spacing=2.5, noise=0.4)[0]

    def up_to(images):
        shifts = period * np.arange(-images, images + 1)[:, None] * [1.0, 0.0, 0.0]
        everywhere = (positions + shifts[:, None]).reshape(-1, 3)
        whole = Disturbance(part, gradient, count=len(everywhere), radius=RADIUS, reach=None)
        twists = np.zeros((len(everywhere), 6))
        whole.add_twists(everywhere, twists)
        return twists[images * count : (images + 1) * count]

    found = np.zeros((count, 6))
    periodic = Disturbance(part, gradient, count=count, radius=RADIUS, reach=None, period=period)
    periodic.add_twists(positions, found)
    images = np.array([20, 40, 80, 160])
    # what is beyond P images is a series in 1/(P + ½)
    sums = np.array([up_to(p).ravel() for p in images])
    expected = np.polynomial.polynomial.polyfit(1 / (images + 0.5), sums, 3)[0].reshape(-1, 6)
    assert found == pytest.approx(expected, abs=1e-7 * np.abs(expected).max())
    cut = np.zeros((count, 6))
    Disturbance(part, gradient, count=count, radius=RADIUS, reach=2, period=period).add_twists(
        positions, cut
    )
    assert np.abs(found - cut).max() > 1e-3 * np.abs(found).max()


@pytest.mark.parametrize("part", PARTS)
def test_a_rigid_rotation_is_not_disturbed(part):
    rotation = GRADIENT - GRADIENT.T
    assert not felt(part, POINT, gradient=rotation).any()
