"""Lamb's solution is a Stokes flow that meets its slip, and known squirmers swim at their speed."""

import numpy as np
import pytest

from validation.pair_laws.exterior_flow import ExteriorFlow
from validation.report import paper

THETA = np.linspace(0.2, 2.9, 7)


@pytest.mark.parametrize("label", paper.LABELS)
def test_the_flow_meets_the_slip(label):
    flow = ExteriorFlow.of(paper.SLIP[label])
    moving = np.stack([np.cos(THETA), -np.sin(THETA), 0 * THETA]) * flow.swimming
    surface = flow.velocity(np.ones_like(THETA), THETA) - moving
    np.testing.assert_allclose(surface, paper.SLIP[label](THETA), atol=1e-14)


def test_a_squirmer_swims_at_two_thirds_of_its_slip():
    # v_θ = B₁ sin θ swims at 2B₁/3 against the slip's direction along the axis
    flow = ExteriorFlow.of(lambda t: (0 * t, np.sin(t), 0 * t))
    assert flow.swimming == pytest.approx(2 / 3)
    assert flow.coefficients[("potential", 1)] == pytest.approx(-1 / 3)


def test_a_sphere_with_swirl_of_degree_one_turns_and_leaves_no_flow():
    flow = ExteriorFlow.of(lambda t: (0 * t, 0 * t, np.sin(t)))
    assert flow.turning == pytest.approx(-1.0)
    assert not any(flow.coefficients.values())


def test_the_flow_has_no_divergence_and_a_harmonic_vorticity():
    def slip(t):
        c, s = np.cos(t), np.sin(t)
        return 0.3 * c - s * s * c, s * (0.7 - c + 0.4 * c * c), s * (0.2 + 0.9 * c - c * c)

    flow = ExteriorFlow.of(slip)

    def velocity(x):
        r = np.linalg.norm(x, axis=-1)
        theta = np.arccos(x[..., 2] / r)
        polar = flow.velocity(r, theta)
        n = x / r[..., None]
        phi = np.cross([0.0, 0.0, 1.0], n) / np.sin(theta)[..., None]
        return (
            polar[0][..., None] * n
            + polar[1][..., None] * np.cross(phi, n)
            + (polar[2][..., None] * phi)
        )

    def curl(field):
        return lambda x: 2 * paper.half_curl(field, x)

    points = np.array([[1.1, 0.7, 0.9], [-1.4, 0.5, 1.2], [0.6, -1.5, -1.1]])
    vorticity = curl(velocity)(points)
    # ∇ × ∇ × ω = −∇²ω, which is nothing: the vorticity has no divergence
    bending = curl(curl(curl(velocity)))(points)
    assert np.abs(vorticity).max() > 0.05
    assert np.abs(bending).max() < 1e-5 * np.abs(vorticity).max()
    h = 1e-3
    divergence = sum(
        (velocity(points + h * e) - velocity(points - h * e))[:, k] / (2 * h)
        for k, e in enumerate(np.eye(3))
    )
    assert np.abs(divergence).max() < 1e-5
