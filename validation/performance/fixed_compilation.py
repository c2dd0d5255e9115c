"""Compilation of the same few functions, whatever the package: the measure of a cold start.

``python -m validation.performance.fixed_compilation`` imports Numba and compiles them. They are
what kernels of chains are made of: short vectors, loops over pairs, blocks of six.
"""

from __future__ import annotations

import math

import numba
import numpy as np

FAST = {"contract", "reassoc", "nsz", "arcp"}


@numba.njit(error_model="numpy", fastmath=FAST)
def cross(a, b, out):
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        out[k] = a[i] * b[j] - a[j] * b[i]


@numba.njit(error_model="numpy", fastmath=FAST)
def stokeslets(positions, forces, velocities):
    """u_i = Σ_j (I/r + r r/r³)·F_j."""
    for i in range(len(positions)):
        for k in range(3):
            velocities[i, k] = 0.0
        for j in range(len(positions)):
            if i == j:
                continue
            x = positions[i, 0] - positions[j, 0]
            y = positions[i, 1] - positions[j, 1]
            z = positions[i, 2] - positions[j, 2]
            inverse = 1.0 / math.sqrt(x * x + y * y + z * z)
            along = x * forces[j, 0] + y * forces[j, 1] + z * forces[j, 2]
            along *= inverse**2
            velocities[i, 0] += inverse * (forces[j, 0] + along * x)
            velocities[i, 1] += inverse * (forces[j, 1] + along * y)
            velocities[i, 2] += inverse * (forces[j, 2] + along * z)


@numba.njit(error_model="numpy", fastmath=FAST)
def multiply(a, b, out):
    for i in range(6):
        for j in range(6):
            total = a[i, 0] * b[0, j]
            for k in range(1, 6):
                total += a[i, k] * b[k, j]
            out[i, j] = total


@numba.njit(error_model="numpy", fastmath=FAST)
def eliminate(lower, middle, upper, right):
    """Block elimination of a tridiagonal system of 6 × 6 blocks, without pivots."""
    factor, product = np.empty_like(middle[0]), np.empty_like(middle[0])
    for n in range(len(middle)):
        if n > 0:
            multiply(lower[n], upper[n - 1], product)
            for i in range(6):
                for j in range(6):
                    middle[n, i, j] -= product[i, j]
                for k in range(6):
                    right[n, i] -= lower[n, i, k] * right[n - 1, k]
        factor[:] = middle[n]
        for p in range(6):
            for i in range(6):
                if i == p:
                    continue
                scale = factor[i, p] / factor[p, p]
                for j in range(6):
                    factor[i, j] -= scale * factor[p, j]
                    upper[n, i, j] -= scale * upper[n, p, j]
                right[n, i] -= scale * right[n, p]
        for p in range(6):
            for j in range(6):
                upper[n, p, j] /= factor[p, p]
            right[n, p] /= factor[p, p]
    for n in range(len(middle) - 2, -1, -1):
        for i in range(6):
            for k in range(6):
                right[n, i] -= upper[n, i, k] * right[n + 1, k]


@numba.njit(error_model="numpy", fastmath=FAST)
def turn(frames, spins, time, out):
    """Frames after a turn by their angular velocities, by Rodrigues' formula."""
    first, second = np.empty(3), np.empty(3)
    for i in range(len(frames)):
        rate = math.sqrt(spins[i, 0] ** 2 + spins[i, 1] ** 2 + spins[i, 2] ** 2)
        sine, cosine = math.sin(rate * time), math.cos(rate * time)
        for a in range(3):
            cross(spins[i], frames[i, a], first)
            cross(spins[i], first, second)
            for k in range(3):
                out[i, a, k] = frames[i, a, k] + sine / rate * first[k]
                out[i, a, k] += (1.0 - cosine) / rate**2 * second[k]


def compile_all() -> None:
    """Call each function once."""
    vectors, frames = np.eye(3), np.ones((3, 3, 3))
    stokeslets(vectors, vectors, np.empty_like(vectors))
    turn(frames, vectors, 0.1, np.empty_like(frames))
    blocks = np.stack([np.eye(6)] * 3)
    eliminate(0.0 * blocks, blocks, 0.0 * blocks, np.ones((3, 6)))


if __name__ == "__main__":
    compile_all()
