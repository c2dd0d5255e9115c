"""max_i |r_i(t) − r′_i|, least over the motions of the chain as a whole that a scene allows."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nrchain.comoving.motions import TURN, span
from nrchain.comoving.relative import RelativeChain

LOOKS = 200
"""Snapshots that are looked at together in a search for the last one outside."""


def first_inside(count: int, is_outside: Callable[[np.ndarray], np.ndarray]) -> int:
    """Index after the last of ``count`` snapshots that is outside; ``count`` if that is the last.

    Up to :data:`LOOKS` are looked at, spread over all, and again between the last one of them that
    is outside and the next. A shorter excursion before may be missed.
    """
    low, high = -1, count
    while high - low > 1:
        places = np.unique(np.linspace(low + 1, high - 1, LOOKS).astype(int))
        outside = np.flatnonzero(is_outside(places))
        if not len(outside):
            high = int(places[0])
            continue
        last = int(outside[-1])
        low = int(places[last])
        high = int(places[last + 1]) if last + 1 < len(places) else high
    return high


def distances(chain: RelativeChain, positions: np.ndarray, target: np.ndarray) -> np.ndarray:
    """(T,) largest distance of a sphere at positions (T, N, 3) from target (N, 3).

    The positions are translated and rotated as the scene of the chain allows, by what fits the
    target best in the mean square over the spheres.
    """
    shifts, turns = span(chain.allowed[:3]), span(chain.allowed[3:TURN])
    here = positions - positions.mean(axis=1, keepdims=True) @ shifts.T @ shifts
    there = target - target.mean(axis=0) @ shifts.T @ shifts
    about = chain.origin - chain.origin @ shifts.T @ shifts
    turned = _turned(here - about, there - about, turns)
    return np.linalg.norm(turned + about - there, axis=2).max(axis=1, initial=0.0)


def _turned(here: np.ndarray, there: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Positions (T, N, 3) rotated to fit (N, 3): about any axis, about one, or not at all."""
    if len(axes) == 3:
        # Kabsch, Acta Cryst. A 32, 922 (1976)
        left, _, right = np.linalg.svd(np.einsum("tni,nj->tij", here, there))
        sign = np.ones((len(here), 1, 3))
        sign[:, 0, 2] = np.linalg.det(left @ right)
        return here @ (left * sign @ right)
    if len(axes) != 1:
        return here
    axis = axes[0]
    across = here - (here @ axis)[..., None] * axis
    cosine = np.einsum("tni,ni->t", across, there)
    sine = np.einsum("tni,ni->t", np.cross(axis, across), there)
    angle = np.arctan2(sine, cosine)[:, None, None]
    return here + (np.cos(angle) - 1.0) * across + np.sin(angle) * np.cross(axis, here)
