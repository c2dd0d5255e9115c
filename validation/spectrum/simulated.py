"""x_{k+2} = αx_{k+1} − βx_k: growth of a small bend in runs, and the strength at which it is zero.

A straight clamped chain starts with a bend of 1e-5 a that has no symmetry. Once faster decaying
modes are gone, the displacements of all spheres obey the recurrence of the two slowest rates; α and
β are fitted, and its roots are exp(Λ Δt). Nothing here knows the spectrum but the time in which
other modes decay, and the strengths that are tried.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

import nrchain

HEIGHT = 1e-5
"""Of the bend, in radii."""

SNAPSHOTS = 61

OFF = (-0.04, -0.02, 0.02, 0.04)
"""Strengths that are tried, relative to the one that is expected."""


def growth(scene: nrchain.Scene, end: float) -> complex:
    """Λ of the leading mode, with Im Λ ≥ 0, from the last half of a run."""
    run = {"run.end": end, "run.snapshots": SNAPSHOTS, "run.rtol": 1e-9, "run.atol": 1e-12}
    positions, frames = _bent(scene)
    changed = nrchain.load_scene(scene, **run)
    found = nrchain.simulate(changed, positions=positions, frames=frames)
    if found.status != "completed":
        raise ArithmeticError(f"the run ends {found.status} at t = {found.time[-1]:g}")
    across = found.positions[SNAPSHOTS // 2 :, :, 1:].reshape(-1, 2 * len(positions))
    step = found.time[1] - found.time[0]
    columns = np.stack([across[1:-1].ravel(), -across[:-2].ravel()], axis=1)
    (alpha, beta), *_ = np.linalg.lstsq(columns, across[2:].ravel(), rcond=None)
    roots = np.log(np.roots([1.0, -alpha, beta]).astype(complex)) / step
    leading = roots[np.argmax(roots.real)]
    return complex(leading.real, abs(leading.imag))


def critical(scene: nrchain.Scene, key: str, expected: float, end: float) -> tuple[float, float]:
    """The value of a key at which the growth in runs is zero, and the frequency there.

    A polynomial of third degree through the growth at four values near the expected one.
    """
    values = expected * (1.0 + np.array(OFF))
    found = [growth(nrchain.load_scene(scene, **{key: float(v)}), end) for v in values]
    shares = np.array(OFF)
    curve = np.polyfit(shares, [rate.real for rate in found], 3)
    roots = np.roots(curve)
    real = roots[np.abs(roots.imag) < 1e-9].real
    share = float(real[np.argmin(np.abs(real))])
    turns = np.polyfit(shares, [rate.imag for rate in found], 3)
    return expected * (1.0 + share), abs(float(np.polyval(turns, share)))


def _bent(scene: nrchain.Scene) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The straight chain with a small bend at which both ends keep place and direction."""
    count, spacing = scene.chain.particles, scene.chain.spacing
    share = np.arange(count) / (count - 1)
    positions = np.zeros((count, 3))
    positions[:, 0] = spacing * np.arange(count)
    bump = HEIGHT * scene.chain.radius * np.sin(np.pi * share) ** 2
    positions[:, 1] = bump * (1.0 + 0.7 * share)
    positions[:, 2] = bump * (0.6 - 0.8 * share)
    return positions, np.broadcast_to(np.eye(3), (count, 3, 3)).copy()
