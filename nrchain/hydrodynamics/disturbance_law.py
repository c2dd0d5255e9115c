"""u = −(5a³/2)(1 + a²∇²/6)(1 + a²∇²/10) x (x·E·x)/r⁵: a rigid sphere in a strain E.

A rigid sphere does not deform with the fluid. It disturbs the flow by its stresslet
S = (20/3)πηa³E and by a potential quadrupole. The exact flow about one sphere is (1 + a²∇²/10)
times that of the stresslet; a second sphere of the same size feels (1 + a²∇²/6) of it (Faxén). The
flow is biharmonic, so that the product of both is 1 + (4/15)a²∇². With f = x·E·x,

    stresslet     u = −(5a³/2) x f/r⁵,                      w = ½ ∇ × u = −(5a³/2)(E·x) × x/r⁵
    finite size   u = −(8a⁵/3) [E·x/r⁵ − (5/2) x f/r⁷],      w = 0
                    = −(4a⁵/3) ∇(f/r⁵)

x points from the acting to the feeling sphere. The relative velocity of two spheres is
E·r − [A n n + B (I − n n)]·E·r. With ρ = r/a the stresslet gives A = 5/ρ³ and B = 0, the finite
size A = −8/ρ⁵ and B = 16/3ρ⁵. Reflections, 25/ρ⁶ in A, are left out.

Sources: Batchelor & Green, J. Fluid Mech. 56, 375 (1972), for A and B; Kim & Karrila,
*Microhydrodynamics*, chapter 3, for the flow about one sphere and Faxén's laws.
"""

from __future__ import annotations

import numpy as np

from nrchain._compile import kernel


@kernel
def _pull(strain, x):
    """E·x."""
    return (
        strain[0, 0] * x[0] + strain[0, 1] * x[1] + strain[0, 2] * x[2],
        strain[1, 0] * x[0] + strain[1, 1] * x[1] + strain[1, 2] * x[2],
        strain[2, 0] * x[0] + strain[2, 1] * x[1] + strain[2, 2] * x[2],
    )


@kernel
def _dot(p, q):
    return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]


@kernel
def _cross(p, q):
    return (
        p[1] * q[2] - p[2] * q[1],
        p[2] * q[0] - p[0] * q[2],
        p[0] * q[1] - p[1] * q[0],
    )


@kernel
def between(points, i, j):
    """r_i − r_j."""
    return (
        points[i, 0] - points[j, 0],
        points[i, 1] - points[j, 1],
        points[i, 2] - points[j, 2],
    )


@kernel(alone=True)
def add_stresslet(x, strain, factor, out):
    """out (6,) += factor (x f, (E·x) × x)/r⁵."""
    pulled, square = _pull(strain, x), 1.0 / _dot(x, x)
    factor *= square**2 * np.sqrt(square)
    along, turn = _dot(pulled, x), _cross(pulled, x)
    for k in range(3):
        out[k] += factor * along * x[k]
        out[3 + k] += factor * turn[k]


@kernel(alone=True)
def add_stresslet_change(x, dx, strain, factor, out):
    """out (6,) += the change of :func:`add_stresslet` when x changes by dx."""
    square = 1.0 / _dot(x, x)
    factor *= square**2 * np.sqrt(square)
    pulled, moved = _pull(strain, x), _pull(strain, dx)
    along, stretch = _dot(pulled, x), 5.0 * square * _dot(x, dx)
    change = 2.0 * _dot(pulled, dx) - along * stretch
    turn, first, second = _cross(pulled, x), _cross(moved, x), _cross(pulled, dx)
    for k in range(3):
        out[k] += factor * (change * x[k] + along * dx[k])
        out[3 + k] += factor * (first[k] + second[k] - stretch * turn[k])


@kernel(alone=True)
def add_finite_size(x, strain, factor, out):
    """out (6,) += factor (E·x − (5/2) x f/r², 0)/r⁵."""
    pulled, square = _pull(strain, x), 1.0 / _dot(x, x)
    factor *= square**2 * np.sqrt(square)
    along = 2.5 * square * _dot(pulled, x)
    for k in range(3):
        out[k] += factor * (pulled[k] - along * x[k])


@kernel(alone=True)
def add_finite_size_change(x, dx, strain, factor, out):
    """out (6,) += the change of :func:`add_finite_size` when x changes by dx."""
    square = 1.0 / _dot(x, x)
    factor *= square**2 * np.sqrt(square)
    pulled, moved = _pull(strain, x), _pull(strain, dx)
    along, stretch = 2.5 * square * _dot(pulled, x), square * _dot(x, dx)
    change = 5.0 * square * _dot(pulled, dx) - 7.0 * along * stretch
    for k in range(3):
        out[k] += factor * (moved[k] - 5.0 * stretch * pulled[k] - along * dx[k] - change * x[k])
