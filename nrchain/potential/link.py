"""C⁰e_a = Σ_m w_m e_a^m and C¹r = Σ_m w′_m r_m: the middle of a link between spheres i and i+1.

Inner links average over four spheres (weights −1, 9, 9, −1 over 16 and 1, −27, 27, −1 over 24d):
the relaxation of long bends is exact to fourth order in qd. The first and the last link of an open
chain average over two (½, ½ and −1, 1 over d). The paper's boundary terms have no ½ and a sum over
a = 1, 2: both are misprints.

The terms of the elastic energy share these kernels: strains of a link, derivatives of e × f, and
their positions in the Jacobian.
"""

from __future__ import annotations

from nrchain._compile import constants, kernel, part

REACH = 3
"""Number of neighbours on either side that elastic forces reach."""

E1, E2, E3 = constants(range(3))
"""The axes of a frame."""

# Frame weights (of i−1 and i+2, of i and i+1) and tangent weights, the latter times d.
_WIDE = (-1 / 16, 9 / 16, 1 / 24, 27 / 24)
_NARROW = (0.0, 0.5, 0.0, 1.0)


@part
def is_wide(link, count, periodic):
    """Whether the link has four spheres: all links but the first and last of an open chain."""
    return periodic or 0 < link < count - 2


@part
def link_weights(wide):
    """Weights (outer, inner) of C⁰ and of d C¹; outer weights are 0 for links of two spheres."""
    return _WIDE if wide else _NARROW


@part
def link_spheres(link, count, wide):
    """The spheres i−1, i, i+1, i+2 of a link; links of two spheres repeat them."""
    after = link + 1 if link + 1 < count else 0
    if not wide:
        return link, link, after, after
    before = link - 1 if link > 0 else count - 1
    return before, link, after, (after + 1 if after + 1 < count else 0)


@part
def link_tangent(positions, link, spheres, weights, spacing, period):
    """C¹r, with the images of a periodic chain."""
    count, outer, inner = positions.shape[0], weights[2] / spacing, weights[3] / spacing
    i, j, k, m = spheres
    shift = 0.0
    if period > 0.0:
        shift = inner * period if link + 1 >= count else 0.0
        shift -= outer * period if link == 0 else 0.0
        shift -= outer * period if link + 2 >= count else 0.0
    return (
        inner * (positions[k, 0] - positions[j, 0])
        - outer * (positions[m, 0] - positions[i, 0])
        + shift,
        inner * (positions[k, 1] - positions[j, 1]) - outer * (positions[m, 1] - positions[i, 1]),
        inner * (positions[k, 2] - positions[j, 2]) - outer * (positions[m, 2] - positions[i, 2]),
    )


@part
def mid_vector(frames, a, spheres, weights):
    """C⁰e_a."""
    outer, inner = weights[0], weights[1]
    i, j, k, m = spheres
    return (
        outer * (frames[i, a, 0] + frames[m, a, 0]) + inner * (frames[j, a, 0] + frames[k, a, 0]),
        outer * (frames[i, a, 1] + frames[m, a, 1]) + inner * (frames[j, a, 1] + frames[k, a, 1]),
        outer * (frames[i, a, 2] + frames[m, a, 2]) + inner * (frames[j, a, 2] + frames[k, a, 2]),
    )


@part
def dot(first, second):
    return first[0] * second[0] + first[1] * second[1] + first[2] * second[2]


@kernel
def cross(first, second):
    return (
        first[1] * second[2] - first[2] * second[1],
        first[2] * second[0] - first[0] * second[2],
        first[0] * second[1] - first[1] * second[0],
    )


@part
def axes_of(frames, i):
    """e₁, e₂ and e₃ of sphere i, by components."""
    return (
        (frames[i, 0, 0], frames[i, 0, 1], frames[i, 0, 2]),
        (frames[i, 1, 0], frames[i, 1, 1], frames[i, 1, 2]),
        (frames[i, 2, 0], frames[i, 2, 1], frames[i, 2, 2]),
    )


@part
def add_cross(first, second, factor, out):
    """out += factor (a × b)."""
    out[0] += factor * (first[1] * second[2] - first[2] * second[1])
    out[1] += factor * (first[2] * second[0] - first[0] * second[2])
    out[2] += factor * (first[0] * second[1] - first[1] * second[0])


@part
def stress_vector(frames, i, first, last, tensions):
    """Σ_a τ_a e_a of sphere i, over first ≤ a < last."""
    g0 = g1 = g2 = 0.0
    for a in range(first, last):
        g0 += tensions[a] * frames[i, a, 0]
        g1 += tensions[a] * frames[i, a, 1]
        g2 += tensions[a] * frames[i, a, 2]
    return g0, g1, g2


@part
def _add_strain_wrench(frame, along, stress, pull, tangent, wrench):
    """wrench −= ∂/∂(u, φ) of Σ_a τ_a C⁰e_a·C¹r for a sphere with these weights."""
    wrench[0] -= along * pull[0]
    wrench[1] -= along * pull[1]
    wrench[2] -= along * pull[2]
    wrench[3] -= frame * (stress[1] * tangent[2] - stress[2] * tangent[1])
    wrench[4] -= frame * (stress[2] * tangent[0] - stress[0] * tangent[2])
    wrench[5] -= frame * (stress[0] * tangent[1] - stress[1] * tangent[0])


@part
def add_strain_wrenches(
    frames, first, last, spheres, wide, weights, spacing, tangent, tensions, wrenches
):
    """wrenches −= Σ_a τ_a ∂(C⁰e_a·C¹r) over the spheres of a link with tensions τ_a."""
    outer, inner, far, near = weights
    h, i, j, k = spheres
    of_i = stress_vector(frames, i, first, last, tensions)
    of_j = stress_vector(frames, j, first, last, tensions)
    if not wide:
        pull = inner * (of_i[0] + of_j[0]), inner * (of_i[1] + of_j[1]), inner * (of_i[2] + of_j[2])
    else:
        of_h = stress_vector(frames, h, first, last, tensions)
        of_k = stress_vector(frames, k, first, last, tensions)
        pull = (
            inner * (of_i[0] + of_j[0]) + outer * (of_h[0] + of_k[0]),
            inner * (of_i[1] + of_j[1]) + outer * (of_h[1] + of_k[1]),
            inner * (of_i[2] + of_j[2]) + outer * (of_h[2] + of_k[2]),
        )
        _add_strain_wrench(outer, far / spacing, of_h, pull, tangent, wrenches[h])
        _add_strain_wrench(outer, -far / spacing, of_k, pull, tangent, wrenches[k])
    _add_strain_wrench(inner, -near / spacing, of_i, pull, tangent, wrenches[i])
    _add_strain_wrench(inner, near / spacing, of_j, pull, tangent, wrenches[j])


@part
def product_energy(e, f):
    """½ (e·f)²."""
    return 0.5 * dot(e, f) ** 2


@part
def add_product_moment(e, f, modulus, moment):
    """moment −= modulus (e·f) e × f, from ½ modulus (e·f)²."""
    add_cross(e, f, -modulus * dot(e, f), moment)


@part
def add_turning_moment(moment, i, j, wrenches):
    """wrenches += the moment of a link on its first sphere i, and minus it on the second, j."""
    for k in range(3):
        wrenches[i, 3 + k] += moment[k]
        wrenches[j, 3 + k] -= moment[k]


@kernel
def add_block_product(blocks, poses, periodic, wrenches):
    """wrenches[i] += Σ_m blocks[i, w + m] · poses[i + m]: the change of (F, T) with the poses."""
    count, centre = blocks.shape[0], blocks.shape[1] // 2
    for i in range(count):
        for m in range(blocks.shape[1]):
            j = i + m - centre
            if not periodic and (j < 0 or j >= count):
                continue
            for p in range(6):
                for q in range(6):
                    wrenches[i, p] += blocks[i, m, p, q] * poses[j % count, q]
