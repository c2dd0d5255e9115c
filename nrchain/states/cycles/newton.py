"""All stages, T and the drift of the axes at once: Newton's method for an orbit.

Steps are damped until the next correction with the same factors is shorter, as for states
(:mod:`nrchain.states.newton`).
"""

from __future__ import annotations

import math

import numpy as np

from nrchain.comoving.relative import RelativeChain
from nrchain.states.cycles.orbit import Orbit
from nrchain.states.cycles.system import Change, Condensed, System
from nrchain.states.newton import ACCEPTED, CONVERGED, LARGEST, LEAST_DAMPING

STEPS = 40
"""Most steps."""


def solve(chain: RelativeChain, orbit: Orbit) -> tuple[Condensed, float, bool]:
    """The orbit reached with its factors, its last correction, and whether it is found."""
    system, damping = System(chain, orbit), 1.0
    spacing = chain.scene.chain.spacing
    size = math.inf
    for _ in range(STEPS):
        condensed = Condensed(system)
        change = condensed.solve(system.defects)
        size = largest_change(system, change)
        extent = max(float(np.ptp(orbit.positions, axis=(0, 1, 2)).max()), spacing)
        if size <= CONVERGED * extent:
            return condensed, size, True
        damping = min(2.0 * damping, 1.0, LARGEST * spacing / size)
        reached = _damped(system, condensed, change, damping)
        if reached is None:
            return condensed, size, size <= ACCEPTED * spacing
        system, damping = reached
    return condensed, size, size <= ACCEPTED * spacing


def _damped(
    system: System, condensed: Condensed, change: Change, damping: float
) -> tuple[System, float] | None:
    """The next system and the damping that led there; None if no shorter correction is found."""
    while damping >= LEAST_DAMPING:
        try:
            trial = system.moved(change, damping)
            shorter = condensed.solve(trial.defects).size <= (1.0 - 0.25 * damping) * change.size
        except FloatingPointError:
            shorter = False
        if shorter:
            return trial, damping
        damping *= 0.5
    return None


def largest_change(system: System, change: Change) -> float:
    """The largest displacement of a sphere, or rotation times d, or that of the numbers."""
    parts = (change.stages / system.chain.units).reshape(-1, 2, 3)
    sizes = np.linalg.norm(parts, axis=2) * [1.0, system.chain.scene.chain.spacing]
    return max(float(sizes.max(initial=0.0)), float(np.abs(change.numbers).max()))
