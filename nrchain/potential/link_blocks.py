"""Derivatives of the wrenches of a link with the displacements and rotations of its spheres.

The wrenches are those of :mod:`nrchain.potential.link`. ``blocks[i, w + m]`` of the blocks (N,
2w + 1, 6, 6) is the derivative of the wrench on sphere i with the pose of sphere i + m.
"""

from __future__ import annotations

from nrchain._compile import part
from nrchain.potential.link import cross, dot


@part
def set_strain_parts(
    frames,
    first,
    last,
    spheres,
    weights,
    tangent,
    roots,
    tensions,
    pulls,
    levers,
    ties,
    tensile,
    blocks,
):
    """Set what :func:`add_strain_blocks` needs of a link with strains s_a and stiffness K_a.

    With ``roots`` √K_a, ``tensions`` τ_a = K_a s_a and ``pulls`` p_a = √K_a C⁰e_a, sphere m of the
    link with weight w_m in C⁰ has

        levers[m, a] = l_a = w_m √K_a e_a × C¹r,   ties[m] = S^ − Σ_a p_a l_aᵀ,

    where S = w_m Σ_a τ_a e_a, S^ is the matrix of v ↦ S × v, and ``tensile`` is Σ_a p_a p_aᵀ.
    ``levers`` (4, 3, 3) are zero for absent terms. The change of S × C¹r with the rotation of the
    sphere goes to the sphere's own block.
    """
    centre = blocks.shape[1] // 2
    frame = (weights[0], weights[1], weights[1], weights[0])
    t0, t1, t2 = tangent
    for m in range(4):
        i, weight = spheres[m], frame[m]
        s0 = s1 = s2 = 0.0
        for a in range(first, last):
            e0, e1, e2 = frames[i, a, 0], frames[i, a, 1], frames[i, a, 2]
            tension, root = weight * tensions[a], weight * roots[a]
            s0, s1, s2 = s0 + tension * e0, s1 + tension * e1, s2 + tension * e2
            levers[m, a, 0] = root * (e1 * t2 - e2 * t1)
            levers[m, a, 1] = root * (e2 * t0 - e0 * t2)
            levers[m, a, 2] = root * (e0 * t1 - e1 * t0)
        for p in range(3):
            for q in range(3):
                ties[m, p, q] = -(
                    pulls[0, p] * levers[m, 0, q]
                    + pulls[1, p] * levers[m, 1, q]
                    + pulls[2, p] * levers[m, 2, q]
                )
        ties[m, 0, 1] -= s2
        ties[m, 0, 2] += s1
        ties[m, 1, 0] += s2
        ties[m, 1, 2] -= s0
        ties[m, 2, 0] -= s1
        ties[m, 2, 1] += s0
        # ∂(S × C¹r) = (S C¹rᵀ − S·C¹r) φ
        along = s0 * t0 + s1 * t1 + s2 * t2
        for q in range(3):
            blocks[i, centre, 3, 3 + q] -= s0 * tangent[q]
            blocks[i, centre, 4, 3 + q] -= s1 * tangent[q]
            blocks[i, centre, 5, 3 + q] -= s2 * tangent[q]
            blocks[i, centre, 3 + q, 3 + q] += along
    for p in range(3):
        for q in range(3):
            tensile[p, q] = (
                pulls[0, p] * pulls[0, q] + pulls[1, p] * pulls[1, q] + pulls[2, p] * pulls[2, q]
            )


@part
def add_strain_blocks(spheres, wide, weights, spacing, levers, ties, tensile, blocks):
    """blocks −= Σ_a (g_a g_aᵀ + τ_a ∂²s_a), with √K_a ∂s_a = g_a.

    g_a has the parts w′_m p_a for the displacement and l_a for the rotation of sphere m, with the
    weights w′_m of C¹ and the parts of :func:`set_strain_parts`.
    """
    centre = blocks.shape[1] // 2
    far, near = weights[2] / spacing, weights[3] / spacing
    along = (far, -near, near, -far)
    begin, end = (0, 4) if wide else (1, 3)
    for m in range(begin, end):
        i, along_m = spheres[m], along[m]
        for n in range(begin, end):
            along_n = along[n]
            both, c = along_m * along_n, centre + n - m
            for p in range(3):
                l0, l1, l2 = levers[m, 0, p], levers[m, 1, p], levers[m, 2, p]
                for q in range(3):
                    blocks[i, c, p, q] -= both * tensile[p, q]
                    blocks[i, c, p, 3 + q] += along_m * ties[n, p, q]
                    blocks[i, c, 3 + p, q] += along_n * ties[m, q, p]
                    blocks[i, c, 3 + p, 3 + q] -= (
                        l0 * levers[n, 0, q] + l1 * levers[n, 1, q] + l2 * levers[n, 2, q]
                    )


@part
def add_turned_cross(e, f, factor, turning):
    """turning (3, 3) += ∂/∂φ of factor (e × f): factor (e fᵀ − e·f)."""
    along = factor * dot(e, f)
    for q in range(3):
        turning[0, q] += factor * e[0] * f[q]
        turning[1, q] += factor * e[1] * f[q]
        turning[2, q] += factor * e[2] * f[q]
        turning[q, q] -= along


@part
def add_outer(vector, factor, turning):
    """turning (3, 3) += factor v vᵀ."""
    for q in range(3):
        turning[0, q] += factor * vector[0] * vector[q]
        turning[1, q] += factor * vector[1] * vector[q]
        turning[2, q] += factor * vector[2] * vector[q]


@part
def add_product_blocks(e, f, modulus, turning):
    """turning += ∂/∂φ of :func:`add_product_moment`."""
    add_turned_cross(e, f, -modulus * dot(e, f), turning)
    add_outer(cross(e, f), -modulus, turning)


@part
def add_turning_blocks(turning, i, j, blocks):
    """blocks += the derivatives of the moment M of a link on its spheres i and j.

    ``turning`` (3, 3) is ∂M/∂φ. Moments are of the form Σ_ab V_ab(e_a·f_b) e_a × f_b, whose
    derivative ∂M/∂φ′ is the transpose of −∂M/∂φ.
    """
    c = blocks.shape[1] // 2
    for p in range(3):
        for q in range(3):
            own, other = turning[p, q], turning[q, p]
            blocks[i, c, 3 + p, 3 + q] += own
            blocks[i, c + 1, 3 + p, 3 + q] -= other
            blocks[j, c - 1, 3 + p, 3 + q] -= own
            blocks[j, c, 3 + p, 3 + q] += other
