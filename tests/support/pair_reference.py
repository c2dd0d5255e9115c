"""The printed pair laws, summed in plain loops: the reference for every implementation.

``c`` is e·n, n the unit vector from the acting to the feeling sphere and e the axis of the former.
"""

from __future__ import annotations

import numpy as np

LABELS = ("2s", "3a", "3t", "4a")
VELOCITY = {
    "2s": lambda a, r, c, n, e: 7 * a**2 / (6 * r**2) * (3 * c**2 - 1) * n,
    "3a": lambda a, r, c, n, e: 13 * a**3 / (12 * r**3) * c * np.cross(e, n),
    "3t": lambda a, r, c, n, e: -(a**3) / (5 * r**3) * (e - 3 * c * n),
    "4a": lambda a, r, c, n, e: 363 * a**4 / (40 * r**4) * (1 - 5 * c**2) * np.cross(e, n),
}
SPIN = {
    "2s": lambda a, r, c, n, e: 7 * a**2 / (2 * r**3) * c * np.cross(e, n),
    "3a": lambda a, r, c, n, e: 13 * a**3 / (24 * r**4) * ((5 * c**2 - 1) * n - 2 * c * e),
    "3t": lambda a, r, c, n, e: np.zeros(3),
    "4a": lambda a, r, c, n, e: (
        363 * a**4 / (80 * r**5) * (-3 * e + 15 * (c * n + c**2 * e) - 35 * c**3 * n)
    ),
}


def stresslet_of_finite_spheres(a, r, c, n, e):
    """(1 + a²∇²/6)(1 + a²∇²/10) u, where ∇² (3c² − 1) n/r² = [(6 − 30c²) n + 12c e]/r⁴."""
    correction = 7 * a**4 / (6 * r**4) * 4 / 15 * ((6 - 30 * c**2) * n + 12 * c * e)
    return VELOCITY["2s"](a, r, c, n, e) + correction


def law(laws, label, separation, axis, radius):
    r = np.linalg.norm(separation)
    n = separation / r
    return laws[label](radius, r, axis @ n, n, axis)


def pairs(count, reach, period=0.0):
    """(i, j, displacement of the image of j) of all pairs within reach along the chain."""
    for i in range(count):
        for j in range(i - reach, i + reach + 1):
            if j != i and (period or 0 <= j < count):
                yield i, j % count, np.array([j // count * period, 0.0, 0.0])


def sum_law(laws, label, positions, axes, strengths, reach, radius, period=0.0):
    total = np.zeros_like(positions)
    for i, j, shift in pairs(len(positions), reach, period):
        separation = positions[i] - positions[j] - shift
        total[i] += strengths[j] * law(laws, label, separation, axes[j], radius)
    return total


def slip_twists(labels, positions, axes, strengths, reach, radius, period=0.0):
    """(Σ u, Σ w) (N, 6); one array of axes (N, 3) and of strengths (N,) a mode."""
    twists = np.zeros((len(positions), 6))
    for label, axis, strength in zip(labels, axes, strengths, strict=True):
        state = positions, axis, strength, reach, radius, period
        twists[:, :3] += sum_law(VELOCITY, label, *state)
        twists[:, 3:] += sum_law(SPIN, label, *state)
    return twists


def pair_mobility(x, a, eta):
    """μ (6, 6) of a force and torque at the origin on a sphere at x: Rotne, Prager, Yamakawa.

    Wajnryb et al., J. Fluid Mech. 731 (2013) R3, with their overlap forms for r < 2a.
    """
    r = np.linalg.norm(x)
    unit = np.eye(3)
    if r == 0.0:
        return np.diag([1 / (6 * np.pi * eta * a)] * 3 + [1 / (8 * np.pi * eta * a**3)] * 3)
    nn, n_cross = np.outer(x, x) / r**2, np.cross(unit, x / r)
    if r > 2 * a:
        tt = ((1 + 2 * a**2 / (3 * r**2)) * unit + (1 - 2 * a**2 / r**2) * nn) / (8 * np.pi * r)
        rt = n_cross.T / (8 * np.pi * r**2)
        rr = -(unit - 3 * nn) / (16 * np.pi * r**3)
    else:
        tt = ((1 - 9 * r / (32 * a)) * unit + 3 * r / (32 * a) * nn) / (6 * np.pi * a)
        rt = (r / a - 3 * r**2 / (8 * a**2)) * n_cross.T / (16 * np.pi * a**2)
        isotropic = 1 - 27 * r / (32 * a) + 5 * r**3 / (64 * a**3)
        rr = isotropic * unit + (9 * r / (32 * a) - 3 * r**3 / (64 * a**3)) * nn
        rr /= 8 * np.pi * a**3
    return np.block([[tt, rt], [rt, rr]]) / eta


def mobility(positions, reach, radius, viscosity, period=0.0):
    """μ (6N, 6N) of all pairs within reach, each sphere by itself included."""
    count = len(positions)
    own = pair_mobility(np.zeros(3), radius, viscosity)
    matrix = np.kron(np.eye(count), own).reshape(count, 6, count, 6)
    for i, j, shift in pairs(count, reach, period):
        x = positions[i] - positions[j] - shift
        matrix[i, :, j] += pair_mobility(x, radius, viscosity)
    return matrix.reshape(6 * count, 6 * count)


def crooked_chain(rng, count, radius):
    """Positions of a crooked chain with spheres at least 2.5 radii apart, and random frames."""
    steps = rng.uniform([2.5, -1.0, -1.0], [4.0, 1.0, 1.0], (count, 3))
    frames = np.linalg.qr(rng.normal(size=(count, 3, 3)))[0]
    frames *= np.linalg.det(frames)[:, None, None]
    return radius * np.cumsum(steps, axis=0), frames


def assert_close(found, expected, tolerance=1e-12):
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=tolerance * scale)
