"""((r + r′)/D)^p < τ(accuracy): degrees of multipoles, and how many spheres make a tree faster.

An interval of radius r acts on one of radius r′ at the distance D. What multipoles beyond degree p
would add is at most of the order of ((r + r′)/D)^(p + 1) of their flow. It is smaller where spheres
are spread over their intervals, and smaller still over the sum of all pairs, in which near pairs
count most. τ is fitted to errors measured on chains.
"""

from __future__ import annotations

import math

import numpy as np

LEAST_DEGREE = 3
"""Lowest degree of the multipoles by which far intervals act."""

WIDEST = 0.29
"""(r + r′)/D of the nearest far intervals: wider ones cost more degrees than they save pairs."""

CLOSEST = 0.5
"""Largest (r + r′)/D whatever the accuracy: multipoles converge slowly beyond."""

FEWEST = 200
"""Spheres from which on a tree is faster than the direct sum, for each degree of its multipoles:
measured on straight, coiled and randomly walking chains, of which the last take the longest."""


def far_ratios(accuracy: float, degree: int, own_degree: int) -> np.ndarray:
    """The largest (r + r′)/D of far intervals, (degree + 1,) for each degree; 0 where none is."""
    lowest = max(LEAST_DEGREE, own_degree)
    ratios = np.zeros(degree + 1)
    ratios[lowest:] = truncation(accuracy) ** (1.0 / np.arange(lowest, degree + 1))
    return np.minimum(ratios, CLOSEST)


def truncation(accuracy: float) -> float:
    """The ((r + r′)/D)^p at which sums have a given accuracy.

    Fitted, with a margin, to the errors of slip, friction and their derivatives on straight,
    coiled, folded and randomly walking chains: sums are more accurate than this power, because
    multipoles beyond p come from the ends of intervals alone.
    """
    return 2.0 * accuracy**0.73


def highest_degree(accuracy: float, own_degree: int) -> int:
    """The highest degree of the multipoles."""
    degree = math.ceil(math.log(truncation(accuracy)) / math.log(WIDEST))
    return max(degree, LEAST_DEGREE, own_degree + 1)


def break_even(accuracy: float) -> float:
    """The number of spheres from which on a tree sums all pairs; infinite for an accuracy of 0."""
    if accuracy <= 0.0:
        return math.inf
    return FEWEST * highest_degree(accuracy, 0)
