"""The resolved reference against closed forms, classical series and tables of two spheres."""

import math
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from nrchain.errors import SceneError
from nrchain.hydrodynamics.resolved import (
    ResolvedSpheres,
    order_change,
    resolved_resistance,
    resolved_twists,
)
from nrchain.hydrodynamics.slip import Slip
from nrchain.hydrodynamics.slip_modes import find
from nrchain.hydrodynamics.surface_slip import slip_velocity

LABELS = ("2s", "3a", "3t", "4a")
PI6, PI8 = 6 * math.pi, 8 * math.pi
CLUSTER = np.array([[0.0, 0.0, 0.0], [2.9, 0.4, -0.3], [1.1, 2.8, 0.6]])
TURNS = Rotation.from_rotvec(np.random.default_rng(3).normal(size=(3, 3)))
FRAMES = TURNS.as_matrix().transpose(0, 2, 1)

# Per unit V of the printed slip (Table slip), with c = e·n, s = a/r: the flow about one sphere.
EXTERIOR = {
    "2s": lambda s, c, n, e: 5 / 2 * (s**2 - s**4) * (c**2 - 1 / 3) * n + s**4 * (c * e - n / 3),
    "3a": lambda s, c, n, e: s**3 / 9 * c * np.cross(e, n),
    "3t": lambda s, c, n, e: s**3 / 45 * (3 * c * n - e),
    "4a": lambda s, c, n, e: s**4 / 60 * (c**2 - 1 / 5) * np.cross(e, n),
}
PAPER_STRENGTH = {"2s": 7 / 5, "3a": 39 / 4, "3t": 9, "4a": -5445 / 2}
VELOCITY = {
    "2s": lambda s, c, n, e: 7 / 6 * s**2 * (3 * c**2 - 1) * n,
    "3a": lambda s, c, n, e: 13 / 12 * s**3 * c * np.cross(e, n),
    "3t": lambda s, c, n, e: -(s**3) / 5 * (e - 3 * c * n),
    "4a": lambda s, c, n, e: 363 / 40 * s**4 * (1 - 5 * c**2) * np.cross(e, n),
}
SPIN = {
    "2s": lambda s, c, n, e: 7 / 2 * s**3 * c * np.cross(e, n),
    "3a": lambda s, c, n, e: 13 / 24 * s**4 * ((5 * c**2 - 1) * n - 2 * c * e),
    "3t": lambda s, c, n, e: 0 * n,
    "4a": lambda s, c, n, e: 363 / 80 * s**5 * (-3 * e + 15 * (c * n + c**2 * e) - 35 * c**3 * n),
}


def pair(distance):
    return np.array([[0.0, 0.0, 0.0], [0.0, 0.0, distance]])


def printed_slip(label, e, normals, v_r=None):
    """Table slip of the paper in spherical coordinates about e, with 2/45 for its 1/45 in 3t."""
    c = normals @ e
    s = np.sqrt(1 - c**2)
    polar = (c[:, None] * normals - e) / s[:, None]
    azimuthal = np.cross(e, normals) / s[:, None]
    components = {
        "2s": (2 / 3 - s**2, -s * c, 0 * c),
        "3a": (0 * c, 0 * c, 2 * s * c / 18),
        "3t": ((2 / 45 if v_r is None else v_r) * c, s / 45, 0 * c),
        "4a": (0 * c, 0 * c, s * (c**2 - 1 / 5) / 60),
    }[label]
    return sum(
        part[:, None] * vector
        for part, vector in zip(components, (normals, polar, azimuthal), strict=True)
    )


def scattered(count, seed=0):
    points = np.random.default_rng(seed).normal(size=(count, 3))
    return points / np.linalg.norm(points, axis=1)[:, None]


# One sphere


@pytest.mark.parametrize("order", [1, 2, 5])
def test_drag_and_torque_of_one_sphere(order):
    matrix = resolved_resistance([[1.0, 2.0, 3.0]], radius=1.7, viscosity=0.6, order=order)
    expected = np.diag(np.repeat([PI6 * 0.6 * 1.7, PI8 * 0.6 * 1.7**3], 3))
    np.testing.assert_allclose(matrix[0, :, 0], expected, atol=1e-13 * expected.max())


@pytest.mark.parametrize("label", LABELS)
def test_slip_is_the_printed_one_times_the_paper_strength(label):
    normals, e = scattered(40), TURNS[0].apply([1.0, 0.0, 0.0])
    expected = PAPER_STRENGTH[label] * printed_slip(label, e, normals)
    np.testing.assert_allclose(slip_velocity(find(label), e, normals), expected, atol=1e-13)


@pytest.mark.parametrize("label", LABELS)
def test_flow_of_the_printed_slip_about_one_sphere(label):
    e = TURNS[1].apply([1.0, 0.0, 0.0])
    sphere = ResolvedSpheres([[0.3, 0.1, -0.2]], radius=0.8, order=5)
    flow = sphere.mobility_problem(None, lambda i, normals: printed_slip(label, e, normals))
    normals, distances = scattered(30), np.linspace(0.8, 5, 30)[:, None]
    found = flow.velocity(sphere.positions + distances * normals)
    expected = EXTERIOR[label](0.8 / distances, (normals @ e)[:, None], normals, e)
    np.testing.assert_allclose(found, expected, atol=1e-14)
    assert np.abs(flow.velocities).max() < 1e-14
    assert np.abs(flow.angular_velocities).max() < 1e-14


@pytest.mark.parametrize("label", LABELS)
def test_far_field_of_a_mode_is_its_pair_law(label):
    sphere = ResolvedSpheres([[0.0, 0.0, 0.0]], order=5)
    flow = sphere.mobility_problem(FRAMES[:1], {label: 3.0})
    normals, e = scattered(30), FRAMES[0, 0]
    expected = 3.0 * VELOCITY[label](1e-3, (normals @ e)[:, None], normals, e)
    error = np.abs(flow.velocity(1e3 * normals) - expected).max()
    assert error < 1e-5 * np.abs(expected).max()


def test_the_misprinted_3t_slip_would_swim():
    # v_r = (1/45) cos θ has the mean −e/135 (times V); a force-free sphere moves at minus the mean.
    e = np.array([0.0, 0.0, 1.0])
    v, _ = resolved_twists(
        [[0.0, 0.0, 0.0]], None, lambda i, n: printed_slip("3t", e, n, v_r=1 / 45), order=4
    )
    np.testing.assert_allclose(v[0], e / 135, atol=1e-15)


def test_squirmer_swims_and_spins_by_the_mean_of_its_slip():
    # Lighthill: tangential slip sin θ gives 2/3; slip Ω × n turns the sphere by −Ω/a.
    e, turn = np.array([0.0, 0.6, 0.8]), np.array([0.3, -0.1, 0.2])

    def slip(sphere, normals):
        return (normals @ e)[:, None] * normals - e + np.cross(turn, normals)

    v, w = resolved_twists([[0.0, 0.0, 0.0]], None, slip, radius=2.0, order=3)
    np.testing.assert_allclose(v[0], 2 / 3 * e, atol=1e-14)
    np.testing.assert_allclose(w[0], -turn / 2, atol=1e-14)


# Two spheres: classical results


def stimson_jeffery(r):
    """Drag over 6πηaU of two spheres moving alike along their line (Stimson & Jeffery 1926)."""
    alpha, n = math.acosh(r / 2), np.arange(1, 120)
    a, b = (2 * n + 1) * alpha, 2 * n + 1
    inner = 4 * np.sinh(a / 2) ** 2 - b**2 * math.sinh(alpha) ** 2
    outer = 2 * np.sinh(a) + b * math.sinh(2 * alpha)
    terms = n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (1 - inner / outer)
    return 4 / 3 * math.sinh(alpha) * terms.sum()


def brenner(r):
    """The same for spheres that approach each other (Brenner 1961, free plane midway)."""
    alpha, n = math.acosh(r / 2), np.arange(1, 120)
    a, b = (2 * n + 1) * alpha, 2 * n + 1
    inner = 4 * np.cosh(a / 2) ** 2 + b**2 * math.sinh(alpha) ** 2
    outer = 2 * np.sinh(a) - b * math.sinh(2 * alpha)
    terms = n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (inner / outer - 1)
    return 4 / 3 * math.sinh(alpha) * terms.sum()


def jeffery(r, sign):
    """Torque over 8πηa³Ω of two spheres turning alike (−) or oppositely (+) about their line."""
    alpha, n = math.acosh(r / 2), np.arange(1, 80)
    return (sign ** (n + 1.0) * (math.sinh(alpha) / np.sinh(n * alpha)) ** 3).sum()


@pytest.mark.parametrize(("r", "order", "error"), [(2.5, 12, 2e-6), (3, 11, 1e-8), (5, 9, 1e-11)])
def test_motion_along_and_about_the_line_of_centres(r, order, error):
    matrix = resolved_resistance(pair(r), order=order)
    own, other = np.diag(matrix[0, :, 0]), np.diag(matrix[0, :, 1])
    assert (own + other)[2] / PI6 == pytest.approx(stimson_jeffery(r), rel=error)
    assert (own - other)[2] / PI6 == pytest.approx(brenner(r), rel=error)
    assert (own + other)[5] / PI8 == pytest.approx(jeffery(r, -1), rel=error)
    assert (own - other)[5] / PI8 == pytest.approx(jeffery(r, 1), rel=error)


@cache
def jeffrey_onishi(kind, n, p, q):
    """P_npq, V_npq, Q_npq of the transverse problem: Jeffrey & Onishi 1984, Eqs. (4.6)–(4.11)."""
    if p == 0 and q == 0:
        return float(n == 1 and kind in "PV")
    if min(n, p, q) < 0 or n == 0:
        return 0.0
    if kind == "V":
        tail = sum(math.comb(n + s, n + 1) * _p(s, q - s, p - n - 1) for s in range(1, q + 1))
        return _p(n, p, q) + 2 * n / ((n + 1) * (2 * n + 3)) * tail
    total = 0.0
    for s in range(1, q + 1):
        if kind == "Q":
            term = s / (n + 1) * jeffrey_onishi("Q", s, q - s - 1, p - n)
            term -= 3 / (2 * n * s * (n + 1)) * _p(s, q - s, p - n)
        else:
            first = 3 * (n + s) - (n * s + 1) * (2 * n * s - s - n + 2)
            term = (2 * n + 1) / 2 * first / (s * (n + s) * (2 * s - 1)) * _p(s, q - s, p - n + 1)
            term += n * (2 * n - 1) / 2 * _p(s, q - s, p - n - 1)
            last = jeffrey_onishi("V", s, q - s - 2, p - n + 1)
            term += n * (4 * n * n - 1) / (2 * (2 * s + 1)) * last
            term -= 2 * (4 * n * n - 1) / 3 * jeffrey_onishi("Q", s, q - s - 1, p - n + 1)
            term /= n + 1
        total += math.comb(n + s, n + 1) * term
    return total


def _p(n, p, q):
    return jeffrey_onishi("P", n, p, q)


def test_motion_across_the_line_of_centres():
    # Y^A = Σ_k f_k (a/2r)^k, even k for the force on the moving sphere, odd k for the other.
    f = [2.0**k * sum(_p(1, k - q, q) for q in range(k + 1)) for k in range(26)]
    assert f[:6] == [1, 3 / 2, 9 / 4, 59 / 8, 465 / 16, 2259 / 32]
    matrix = resolved_resistance(pair(6.0), order=9) / PI6
    powers = np.array(f) * 12.0 ** -np.arange(26)
    assert matrix[0, 0, 0, 0] == pytest.approx(powers[::2].sum(), rel=1e-12)
    assert matrix[0, 0, 1, 0] == pytest.approx(-powers[1::2].sum(), rel=1e-11)


# Resistance functions over 6πηa^k of equal spheres, computed with the program of H. J. Wilson
# (J. Comput. Phys. 245, 302, 2013) and tabulated with A. K. Townsend's Stokesian dynamics: forces
# of translation along and across the line (XA, YA), torque of translation (YB), torques of rotation
# (XC, YC), on the moving sphere and on the other. The series above put its digits right to 2e-6.
TABLE = {
    2.5: ((1.72266492, 1.16486474, -0.0827660438, 1.34268751, 1.40365025),
          (-1.04974951, -0.401078941, 0.198020641, -0.0864623805, 0.0556205916)),
    3.0: ((1.36847902, 1.09210175, -0.0378309879, 1.33594554, 1.35731422),
          (-0.670174540, -0.297175857, 0.123592085, -0.0495271369, 0.0288862269)),
    4.0: ((1.16947007, 1.04330302, -0.0135542800, 1.33372854, 1.33896764),
          (-0.427211758, -0.204476858, 0.0654348510, -0.0208409285, 0.0112773649)),
}  # fmt: skip


@pytest.mark.parametrize(("r", "order"), [(2.5, 12), (3.0, 10), (4.0, 7)])
def test_all_resistance_functions_of_two_spheres(r, order):
    matrix = resolved_resistance(pair(r), order=order) / PI6
    for other, row in enumerate(TABLE[r]):
        block = matrix[0, :, other]
        found = block[2, 2], block[0, 0], block[4, 0], block[5, 5], block[3, 3]
        signs = np.sign([1, 1, found[2] * row[2], 1, 1])  # the sign of YB is one of convention
        np.testing.assert_allclose(signs * found, row, rtol=3e-6)


# Convergence


@pytest.mark.parametrize(("r", "cap"), [(2.5, 4e-5), (3.0, 2e-7)])
def test_convergence_is_geometric_at_the_bispherical_rate(r, cap):
    slip = {"2s": [1.0, 0.7], "3a": 0.5, "3t": 1.5, "4a": 0.05}
    orders = [4, 6, 8, 10]
    runs = [np.hstack(resolved_twists(pair(r), FRAMES[:2], slip, order=n)) for n in (*orders, 12)]
    errors = np.array([np.abs(run - runs[-1]).max() for run in runs[:-1]]) / np.abs(runs[-1]).max()
    slope = np.polyfit(orders, np.log(errors), 1)[0]
    assert slope == pytest.approx(-2 * math.acosh(r / 2), rel=0.15)
    assert errors[-1] < cap


def squeezed(r, order):
    """Velocity over the exact one of two spheres pressed together, and what order_change says."""
    push = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    wrenches = (push, 0 * push)
    v, _ = resolved_twists(pair(r), None, {}, wrenches=wrenches, order=order)
    change = order_change(pair(r), None, {}, wrenches=wrenches, order=order)
    exact = 1 / (PI6 * brenner(r))
    return v[0, 2] / exact - 1, change / exact


def test_lubrication_is_out_of_reach_and_the_estimates_say_so():
    error, change = squeezed(2.02, 8)
    assert error > 0.5
    assert change > 0.3
    error, change = squeezed(3.0, 8)
    assert abs(error) < 1e-6
    assert change == pytest.approx(abs(squeezed(3.0, 6)[0]), rel=0.1)


def test_residual_is_of_the_boundary_condition_and_falls_with_the_order():
    residuals = [
        ResolvedSpheres(CLUSTER, order=order).mobility_problem(FRAMES, {"2s": 1.0}).residual()
        for order in (4, 7, 10)
    ]
    assert 1e-3 < residuals[0] < 0.1
    assert residuals[2] < 0.1 * residuals[1] < 0.01 * residuals[0]


# What holds for any number of spheres


@pytest.fixture(scope="module")
def cluster():
    return ResolvedSpheres(CLUSTER, radius=1.1, viscosity=0.7, order=9)


def test_resistance_is_symmetric_and_positive(cluster):
    matrix = cluster.resistance().reshape(18, 18)
    assert np.abs(matrix - matrix.T).max() < 1e-6 * np.abs(matrix).max()
    assert np.linalg.eigvalsh(matrix).min() > 0


def test_mobility_problem_undoes_the_resistance_problem(cluster):
    rng = np.random.default_rng(5)
    twists = rng.normal(size=(3, 3)), rng.normal(size=(3, 3))
    slip = {"2s": 1.0, "3t": [2.0, 0.0, -1.0]}
    driven = cluster.resistance_problem(twists, FRAMES, slip)
    back = cluster.mobility_problem(FRAMES, slip, wrenches=(driven.forces, driven.torques))
    np.testing.assert_allclose(back.velocities, twists[0], atol=1e-5)
    np.testing.assert_allclose(back.angular_velocities, twists[1], atol=1e-5)
    free = cluster.mobility_problem(FRAMES, slip)
    held = cluster.resistance_problem((free.velocities, free.angular_velocities), FRAMES, slip)
    assert np.abs(held.forces).max() < 1e-5 * np.abs(driven.forces).max()
    assert np.abs(held.torques).max() < 1e-5 * np.abs(driven.torques).max()


def test_far_away_only_the_total_force_is_felt(cluster):
    forces = np.random.default_rng(6).normal(size=(3, 3))
    normals, far = scattered(20), 1e6
    for wrench in ((forces, 0 * forces), None):
        flow = cluster.mobility_problem(FRAMES, {"2s": 1.0, "4a": 0.1}, wrenches=wrench)
        total = np.zeros(3) if wrench is None else forces.sum(axis=0)
        stokeslet = (total + (normals @ total)[:, None] * normals) / (PI8 * 0.7 * far)
        np.testing.assert_allclose(flow.velocity(far * normals), stokeslet, atol=1e-11)


def test_rigid_motions_carry_the_answer_along():
    slip, turn = {"2s": 1.0, "3a": [1.0, -2.0, 0.5], "4a": 0.1}, TURNS[2].as_matrix()
    v, w = resolved_twists(CLUSTER, FRAMES, slip, order=10)
    v_moved, w_moved = resolved_twists(
        CLUSTER @ turn.T + [3.0, -5.0, 2.0], FRAMES @ turn.T, slip, order=10
    )
    np.testing.assert_allclose(v_moved, v @ turn.T, atol=2e-6)
    np.testing.assert_allclose(w_moved, w @ turn.T, atol=2e-6)


def test_mirrors_turn_chiral_slip_and_angular_velocities_over():
    mirror = np.diag([1.0, 1.0, -1.0])
    frames = FRAMES @ mirror * np.array([1, 1, -1])[:, None]
    v, w = resolved_twists(CLUSTER, FRAMES, {"2s": 1.0, "3a": 2.0}, order=6)
    v_seen, w_seen = resolved_twists(CLUSTER @ mirror, frames, {"2s": 1.0, "3a": -2.0}, order=6)
    np.testing.assert_allclose(v_seen, v @ mirror, atol=1e-13)
    np.testing.assert_allclose(w_seen, -w @ mirror, atol=1e-13)


def test_units_of_length_and_viscosity():
    forces, slip = np.random.default_rng(7).normal(size=(3, 3)), {"3t": 1.0}
    v, w = resolved_twists(CLUSTER, FRAMES, slip, wrenches=(forces, 2 * forces), order=5)
    scaled = (3 * 0.5 * forces, 9 * 0.5 * 2 * forces)
    v_scaled, w_scaled = resolved_twists(
        3 * CLUSTER, FRAMES, slip, wrenches=scaled, radius=3.0, viscosity=0.5, order=5
    )
    np.testing.assert_allclose(v_scaled, v, atol=1e-13)
    np.testing.assert_allclose(3 * w_scaled, w, atol=1e-13)


def test_axes_and_strengths_of_each_sphere():
    slip = {"2s": Slip(strength=(1.0, 2.0, 3.0), axis=(0.0, 0.0, 2.0))}
    turned = FRAMES[:, [2, 0, 1]]
    for found, expected in zip(
        resolved_twists(CLUSTER, FRAMES, slip, order=4),
        resolved_twists(CLUSTER, turned, {"2s": [1.0, 2.0, 3.0]}, order=4),
        strict=True,
    ):
        np.testing.assert_allclose(found, expected, atol=1e-14)


# The pair laws as limits


@pytest.mark.parametrize("label", LABELS)
def test_pair_laws_are_the_far_limit(label):
    e, n = FRAMES[0, 0], np.array([0.0, 0.0, 1.0])
    v, w = resolved_twists(pair(30.0), FRAMES[:2], {label: [2.0, 0.0]}, order=6)
    velocity, spin = (2 * law[label](1 / 30, e @ n, n, e) for law in (VELOCITY, SPIN))
    # of the size of the law in all directions: in some it vanishes, and what it leaves out does not
    around = np.linspace(0.0, np.pi, 20)
    axes = np.stack([np.sin(around), 0 * around, np.cos(around)], axis=1)
    largest = max(np.linalg.norm(2 * VELOCITY[label](1 / 30, a @ n, n, a)) for a in axes)
    assert np.linalg.norm(v[1] - velocity) < 3e-3 * largest
    assert np.linalg.norm(w[1] - spin) < 1e-6 * largest


def test_true_error_of_the_2s_law_is_second_order_and_of_finite_size_sixth():
    e, n, distances = FRAMES[0, 0], np.array([0.0, 0.0, 1.0]), np.array([6.0, 8.0, 11.0])
    c = e @ n
    leading, corrected = [], []
    for r in distances:
        v, _ = resolved_twists(pair(r), FRAMES[:2], {"2s": [1.0, 0.0]}, order=10)
        law = VELOCITY["2s"](1 / r, c, n, e)
        # (a²/6 + a²/10)∇² of the law: −28/15 (a/r)⁴ [2c e + (1 − 5c²) n] × (−1)
        finite = law + 28 / 15 / r**4 * (2 * c * e + (1 - 5 * c**2) * n)
        leading.append(np.linalg.norm(v[1] - law) / np.linalg.norm(law))
        corrected.append(np.linalg.norm(v[1] - finite) / np.linalg.norm(law))
    slopes = [np.polyfit(np.log(distances), np.log(error), 1)[0] for error in (leading, corrected)]
    assert slopes[0] == pytest.approx(-2, abs=0.1)
    assert slopes[1] == pytest.approx(-6, abs=0.3)
    assert corrected[0] < 1e-3


# Refusals


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"positions": pair(2.0)}, "positions"),
        ({"positions": np.zeros(3)}, "positions"),
        ({"positions": pair(np.nan)}, "positions"),
        ({"positions": [[0.0], [1.0, 2.0]]}, "positions"),
        ({"order": 0}, "order"),
        ({"radius": -1.0}, "radius"),
        ({"viscosity": math.inf}, "viscosity"),
        ({"slip": {"2z": 1.0}}, "slip mode"),
        ({"slip": {"2s": [1.0, 2.0, 3.0]}}, "slip['2s']"),
        ({"frames": FRAMES}, "frames"),
        ({"frames": [FRAMES[0], 1.1 * FRAMES[1]]}, "frames[1]"),
        ({"wrenches": (np.zeros((3, 3)), np.zeros((2, 3)))}, "wrenches"),
    ],
)
def test_what_cannot_be_solved_is_refused(change, named):
    given = {"positions": pair(3.0), "frames": FRAMES[:2], "slip": {"2s": 1.0}, "order": 2}
    with pytest.raises(SceneError) as refused:
        resolved_twists(**(given | change))
    assert refused.value.key == named


def test_order_change_needs_an_order_to_compare_with():
    with pytest.raises(SceneError, match="at least 3"):
        order_change(pair(3.0), None, {}, order=2)
