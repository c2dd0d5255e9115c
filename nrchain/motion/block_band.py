"""out = J x, band = αI + βJ: a Jacobian of blocks (N, 2w + 1, 6, 6) as a banded matrix.

``blocks[i, w + m]`` couples sphere i to sphere i + m. Slot s of a vector holds the six components
of sphere ``order[s]``, and ``slot_of`` (N,) is the inverse, negative for spheres without
coordinates.
"""

from __future__ import annotations

from nrchain._compile import kernel


@kernel
def multiply(blocks, order, slot_of, periodic, vector, out):
    """out = J · vector."""
    count, width = blocks.shape[0], blocks.shape[1]
    centre = width // 2
    out[:] = 0.0
    for slot in range(order.shape[0]):
        i = order[slot]
        for m in range(width):
            j = i + m - centre
            if not periodic and (j < 0 or j >= count):
                continue
            other = slot_of[j % count]
            if other < 0:
                continue
            for p in range(6):
                for q in range(6):
                    out[6 * slot + p] += blocks[i, m, p, q] * vector[6 * other + q]


@kernel
def fill(blocks, order, slot_of, periodic, shift, scale, half, band):
    """band = shift · I + scale · J in LAPACK's layout for banded factors.

    Column by column, the order in memory. The first ``half`` rows are LAPACK's own.
    """
    count, width = blocks.shape[0], blocks.shape[1]
    centre = width // 2
    for slot in range(order.shape[0]):
        for column in range(6 * slot, 6 * slot + 6):
            for row in range(half, 3 * half + 1):
                band[row, column] = 0.0
            band[2 * half, column] = shift
        for m in range(width):
            i = order[slot] - m + centre
            if not periodic and (i < 0 or i >= count):
                continue
            i %= count
            other = slot_of[i]
            if other < 0:
                continue
            for q in range(6):
                column = 6 * slot + q
                for p in range(6):
                    band[2 * half + 6 * other + p - column, column] += scale * blocks[i, m, p, q]
