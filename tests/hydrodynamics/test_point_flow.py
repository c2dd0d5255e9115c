"""The flow of spheres at points of the fluid, against boundary conditions and averages."""

from __future__ import annotations

import math

import numpy as np
import pytest
from support.selection import few_of

from nrchain.errors import BackendError, SceneError
from nrchain.hydrodynamics import lamb, point_flow, pystokes, slip_modes
from nrchain.hydrodynamics.given_slips import given_slips
from nrchain.hydrodynamics.pairs import SlipFlow
from nrchain.hydrodynamics.point_flow import Spheres, sum_flows
from nrchain.hydrodynamics.resolved import ResolvedSpheres
from nrchain.hydrodynamics.surface_slip import slip_velocity

LABELS = ("2s", "3a", "3t", "4a")
RADIUS, VISCOSITY = 1.7, 0.6


def rotation(rng):
    found, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return found * np.sign(np.linalg.det(found))


def crooked(count, seed=1, period=0.0, slip=None, wrenches=True, strain=True, spacing=4.0):
    """A crooked chain of spheres, with all that can act on the fluid."""
    rng = np.random.default_rng(seed)
    positions = RADIUS * (
        spacing * np.arange(count)[:, None] * [1.0, 0, 0] + rng.uniform(-0.6, 0.6, (count, 3))
    )
    modes = {label: rng.normal(size=count) for label in LABELS} if slip is None else slip
    gradient = rng.normal(size=(3, 3)) * strain
    return Spheres(
        positions,
        np.array([rotation(rng) for _ in range(count)]),
        given_slips(modes, count),
        rng.normal(size=(count, 6)) * wrenches,
        gradient + gradient.T - 2 / 3 * np.trace(gradient) * np.eye(3),
        RADIUS,
        VISCOSITY,
        period,
    )


def surface(count=8):
    """Unit normals and weights of a quadrature of the unit sphere."""
    return lamb.sphere_grid(count)


@pytest.mark.parametrize("label", LABELS)
def test_on_the_surface_of_one_sphere_the_flow_of_a_mode_is_its_slip(label):
    axis = np.array([0.48, -0.6, 0.64])
    slips = given_slips({label: {"strength": 2.5, "axis": axis}}, 1)
    none = np.zeros((1, 6)), np.zeros((3, 3)), RADIUS, VISCOSITY
    one = Spheres(np.ones((1, 3)), np.eye(3)[None], slips, *none)
    normals, _ = surface()
    flow = sum_flows(one, 1.0 + RADIUS * normals)[:, :3]
    expected = 2.5 * slip_velocity(slip_modes.find(label), axis, normals)
    assert np.abs(flow - expected).max() <= 1e-13 * np.abs(expected).max()


def test_the_flow_of_one_sphere_is_the_resolved_solution():
    one = crooked(1, strain=False)
    solved = ResolvedSpheres(one.positions, radius=RADIUS, viscosity=VISCOSITY, order=6)
    modes = {slip.label: slip.strengths for slip in one.slips}
    wrenches = one.wrenches[:, :3], one.wrenches[:, 3:]
    resolved = solved.mobility_problem(one.frames, modes, wrenches=wrenches)
    normals, _ = surface()
    for distance in (1.0, 1.3, 2.0, 8.0):
        points = one.positions[0] + distance * RADIUS * normals
        flow, expected = sum_flows(one, points)[:, :3], resolved.velocity(points)
        assert np.abs(flow - expected).max() <= 1e-11 * np.abs(expected).max()


def test_on_the_surface_of_one_rigid_sphere_the_strain_and_its_flow_cancel():
    one = crooked(1, slip={}, wrenches=False)
    normals, _ = surface()
    flow = sum_flows(one, one.positions[0] + RADIUS * normals)[:, :3]
    assert np.abs(flow + RADIUS * normals @ one.strain).max() <= 1e-13 * np.abs(one.strain).max()


@pytest.mark.parametrize("label", LABELS)
def test_the_average_of_the_flow_over_another_sphere_is_the_pair_law(label):
    """Faxén: v = ⟨u⟩ and ω = (3/2a)⟨n × u⟩ over the surface of the sphere that feels the flow."""
    two = crooked(2, slip={label: [0.0, 1.3]}, wrenches=False, strain=False)
    normals, weights = surface(16)
    flow = sum_flows(two, two.positions[0] + RADIUS * normals)[:, :3]
    v = weights @ flow
    w = 1.5 / RADIUS * weights @ np.cross(normals, flow)
    options = {"count": 2, "reach": None, "radius": RADIUS, "finite_size": True}
    law = SlipFlow([label], [np.array([0.0, 1.3])], [(1.0, 0.0, 0.0)], **options)
    twists = np.zeros((2, 6))
    law.add_twists(two.positions, two.frames, twists)
    scale = np.abs(twists[0] * np.repeat([1, RADIUS], 3)).max()
    assert np.abs(v - twists[0, :3]).max() <= 1e-10 * scale
    assert np.abs(w - twists[0, 3:]).max() <= 1e-10 * scale


@pytest.mark.parametrize("label", [*LABELS, "force", "torque"])
def test_pystokes_has_the_same_flow(label):
    wrench = label in ("force", "torque")
    chain = crooked(4, slip={} if wrench else {label: [1.0, -2.0, 0.5, 1.5]}, strain=False)
    chain.wrenches[:] *= np.repeat([label == "force", label == "torque"], 3)
    if wrench:
        vectors = chain.wrenches[:, :3] + chain.wrenches[:, 3:]
        strengths = np.linalg.norm(vectors, axis=1)
        axes = vectors / strengths[:, None]
    else:
        axes, strengths = chain.frames[:, 0], np.array([1.0, -2.0, 0.5, 1.5])
    points = RADIUS * np.random.default_rng(8).uniform([-6, 2, 2], [20, 8, 8], (30, 3))
    units = RADIUS, VISCOSITY
    theirs = pystokes.flow_at(label, points, chain.positions, axes, strengths, *units)
    ours = sum_flows(chain, points)[:, :3]
    assert np.abs(theirs - ours).max() <= 1e-12 * np.abs(ours).max()


@pytest.mark.parametrize("what", ["slip", "wrenches", "strain"])
def test_the_spin_is_half_the_curl_and_the_fluid_is_incompressible(what):
    slip = None if what == "slip" else {}
    chain = crooked(3, slip=slip, wrenches=what == "wrenches", strain=what == "strain")
    rng = np.random.default_rng(5)
    points = chain.positions[0] + RADIUS * rng.uniform(1.2, 5.0, (20, 3))
    step = 1e-4 * RADIUS
    slopes = np.stack(
        [
            (sum_flows(chain, points + h) - sum_flows(chain, points - h))[:, :3] / (2 * step)
            for h in step * np.eye(3)
        ],
        axis=1,
    )
    flow, size = sum_flows(chain, points), np.abs(slopes).max()
    curl = np.einsum("kij,pij->pk", levi_civita(), slopes)
    assert np.abs(curl - 2 * flow[:, 3:]).max() <= 1e-7 * size
    assert np.abs(np.trace(slopes, axis1=1, axis2=2)).max() <= 1e-7 * size


def levi_civita():
    table = np.zeros((3, 3, 3))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        table[k, i, j], table[k, j, i] = 1.0, -1.0
    return table


def test_points_inside_a_sphere_have_no_flow_and_points_on_it_have():
    chain = crooked(3)
    inside = chain.positions + np.array([0.0, 0.0, 0.999 * RADIUS])
    assert np.isnan(sum_flows(chain, inside)).all()
    on = chain.positions[1] + RADIUS * surface()[0]
    assert np.isfinite(sum_flows(chain, on)).all()


def test_points_inside_an_image_of_a_sphere_have_no_flow():
    chain = balanced(crooked(3, period=14.0 * RADIUS))
    shifts = 14.0 * RADIUS * np.array([[-3.0, 0, 0], [1.0, 0, 0]])
    for shift in shifts:
        assert np.isnan(sum_flows(chain, chain.positions + shift)).all()


def balanced(chain):
    """The chain without a net force."""
    wrenches = chain.wrenches.copy()
    wrenches[:, :3] -= wrenches[:, :3].mean(axis=0)
    return chain._replace(wrenches=wrenches)


@pytest.mark.parametrize("across", [0.3, 2.0, 30.0])
def test_a_periodic_chain_is_the_sum_over_its_images(across):
    """The sum over ±P images misses C/P²: the limit is taken from P and 2P."""
    period = 14.0 * RADIUS
    chain = balanced(crooked(3, period=period))
    rng = np.random.default_rng(2)
    points = rng.uniform([-period, -across * period, 0], [period, across * period, period], (6, 3))
    flow = sum_flows(chain, points)
    sums = [sum_flows(copies(chain, most), points) for most in (2000, 4000)]
    expected = (4 * sums[1] - sums[0]) / 3
    chosen = ~np.isnan(flow[:, 0])
    for columns in (slice(0, 3), slice(3, 6)):
        off = np.abs(flow - expected)[chosen, columns].max()
        assert off <= 2e-7 * np.abs(expected[chosen, columns]).max()


def copies(chain, most):
    """An open chain of all images from −most to most."""
    count = 2 * most + 1
    shifts = np.repeat(chain.period * np.arange(-most, most + 1), len(chain.positions))
    positions = np.tile(chain.positions, (count, 1))
    positions[:, 0] += shifts
    slips = [slip._replace(strengths=np.tile(slip.strengths, count)) for slip in chain.slips]
    tiled = np.tile(chain.frames, (count, 1, 1)), slips, np.tile(chain.wrenches, (count, 1))
    return Spheres(positions, *tiled, chain.strain, RADIUS, VISCOSITY)


ONE_THREAD = math.inf
"""Pairs from which a sum takes several threads, whose kernels take four times as long to compile
as those for one, which other trees have too."""


@pytest.mark.parametrize(
    ("accuracy", "spheres", "shared"),
    few_of(
        [
            (1e-5, 3000, ONE_THREAD),
            (1e-9, 3000, ONE_THREAD),
            (1e-5, 200, ONE_THREAD),
            (1e-5, 3000, point_flow.PARALLEL_PAIRS),
        ],
        {(1e-5, 3000, ONE_THREAD), (1e-5, 200, ONE_THREAD)},
    ),
)
def test_the_tree_is_as_accurate_as_it_says(accuracy, spheres, shared, monkeypatch):
    """Of an open chain, and of 200 spheres of a periodic one with their images."""
    monkeypatch.setattr(point_flow, "TREE_PAIRS", 1)
    monkeypatch.setattr(point_flow, "PARALLEL_PAIRS", shared)
    chain = crooked(spheres)
    if spheres == 200:
        chain = balanced(chain)._replace(period=4.0 * RADIUS * spheres)
    rng = np.random.default_rng(3)
    least, most = chain.positions.min(axis=0), chain.positions.max(axis=0)
    points = rng.uniform(least - 20.0, most + 20.0, (3000, 3))
    tree, direct = sum_flows(chain, points, accuracy), sum_flows(chain, points)
    assert np.array_equal(np.isnan(tree), np.isnan(direct))
    assert np.nanmax(np.abs(tree - direct)) > 0.0  # a tree did sum
    for columns in (slice(0, 3), slice(3, 6)):
        off, largest = tree[:, columns] - direct[:, columns], np.nanmax(np.abs(direct[:, columns]))
        assert np.nanmax(np.abs(off)) <= accuracy * largest


def test_no_points_are_no_flow():
    assert sum_flows(crooked(2), np.zeros((0, 3))).shape == (0, 6)


def test_any_number_of_threads_gives_the_same_bits(monkeypatch):
    chain, points = crooked(40), np.random.default_rng(6).uniform(-50.0, 300.0, (300, 3))
    alone = sum_flows(chain, points)
    monkeypatch.setattr(point_flow, "PARALLEL_PAIRS", 1)
    assert np.array_equal(sum_flows(chain, points), alone, equal_nan=True)


def test_points_very_far_from_a_periodic_chain_are_refused():
    chain = balanced(crooked(3, period=10.0))
    with pytest.raises(SceneError, match="within 1000 periods"):
        sum_flows(chain, np.array([[0.0, 2e4, 0.0]]))


def test_a_release_of_pystokes_without_factors_is_refused(monkeypatch):
    monkeypatch.setattr(pystokes, "FLOWS", {"0.1": {}})
    one = np.zeros((1, 3)), np.ones((1, 3)), np.ones(1)
    with pytest.raises(BackendError, match=r"unknown factors; install 0\.1"):
        pystokes.flow_at("2s", np.ones((1, 3)), *one, RADIUS, VISCOSITY)
