"""min |r_i − r_j| = 2a, and links turned by π/2: the events at which a run must end.

Both are sought within every step, on the integrator's own interpolant, and their time is found to
rounding. Spheres that meet and part again within one step are not missed: a step counts as clear
only if the closest pair is farther apart than the spheres moved in it, with a margin. Otherwise it
is divided until every part is clear, or has a contact.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nrchain.geometry.near_pairs import closest_pair, near_pairs, separations
from nrchain.motion.clearance import EXCURSION, Clearance, largest_move, margin
from nrchain.motion.contact import PoseLimits, least_aligned, least_alignment
from nrchain.outcome import Cause, Stop
from nrchain.types import Poses, PosesAt

DIVISIONS = 16
"""How often a step is divided in the search for a contact."""

STRAIGHT = 1e-3
"""Paths that deviate from a line by less than this, in radii, cross contact once."""


class Guard:
    """Looks for contacts and turned links in the steps of a run from ``positions`` (N, 3).

    ``clearance`` tells compiled code which steps need not be looked at.
    """

    def __init__(self, limits: PoseLimits, positions: np.ndarray) -> None:
        self._radius, self._contact = limits.radius, limits.contact
        self._period, self._rotational = limits.period, limits.rotational_springs
        self.clearance = Clearance.of(limits, len(positions))
        self._search(positions)

    def watch(
        self, begin: float, before: np.ndarray, end: float, reached: Poses, poses_at: PosesAt
    ) -> Stop | None:
        """The first event of the step from ``begin``, where positions were ``before``, to ``end``.

        ``reached`` are the poses at its end; ``poses_at(time)`` gives fresh arrays within it.
        """
        after, frames = reached
        if not (np.isfinite(after).all() and np.isfinite(frames).all()):
            return Stop(Cause.NOT_FINITE, begin, "the poses are not finite")
        stop = self._touching(begin, before, end, after, poses_at)
        if self._rotational and least_alignment(frames, self._period > 0.0) < 0.0:
            turned = self._turned(begin, end, poses_at)
            if stop is None or turned.time < stop.time:
                return turned
        return stop

    def _search(self, positions: np.ndarray) -> None:
        self.clearance.searched[:] = positions
        self.clearance.closest[0] = closest_pair(positions, self._period)[0]

    def _touching(
        self,
        begin: float,
        before: np.ndarray,
        end: float,
        after: np.ndarray,
        poses_at: PosesAt,
        divisions: int = DIVISIONS,
    ) -> Stop | None:
        if margin(self.clearance, before, after) > 0.0:
            return None
        self._search(after)
        if margin(self.clearance, before, after) > 0.0:
            return None
        moved = 2.0 * EXCURSION * largest_move(before, after)
        if self._period and divisions and 2.0 * (self._contact + moved) > self._period:
            # spheres may meet other images than those that are nearest at the end
            middle = 0.5 * (begin + end)
            between = poses_at(middle)[0]
            parts = ((begin, before, middle, between), (middle, between, end, after))
            found = (self._touching(*part, poses_at, divisions - 1) for part in parts)
            return next((stop for stop in found if stop is not None), None)
        pairs = near_pairs(after, self._contact + moved, self._period)
        shifts = separations(after, pairs, self._period) - separations(after, pairs)

        def vectors_at(time: float) -> np.ndarray:
            return separations(poses_at(time)[0], pairs) + shifts

        first, last = separations(before, pairs) + shifts, vectors_at(end)
        time = self._first_touch(begin, first, end, last, vectors_at, DIVISIONS)
        if time is None:
            return None
        distances = np.linalg.norm(vectors_at(time), axis=1)
        nearest = int(np.argmin(distances))
        i, j = pairs[nearest]
        distance = distances[nearest] / self._radius
        return Stop(Cause.TOUCH, time, f"spheres {i} and {j} touch (distance {distance:.4g} a)")

    def _first_touch(
        self,
        begin: float,
        first: np.ndarray,
        end: float,
        last: np.ndarray,
        vectors_at: Callable[[float], np.ndarray],
        divisions: int,
    ) -> float | None:
        """The earliest time in the interval at which a separation is as short as contact.

        The interval is divided where the straight lines between its ends come closest. The
        deviation of the separations from those lines there bounds their deviation elsewhere.
        """
        distances, parts = _chord_distances(first, last)
        part = float(np.clip(parts[np.argmin(distances)], 0.1, 0.9))
        middle = begin + part * (end - begin)
        between = vectors_at(middle)
        bulge = np.linalg.norm(between - first - part * (last - first), axis=1)
        bulge /= 4.0 * part * (1.0 - part)
        if (distances - EXCURSION * bulge).min() > self._contact:
            return None
        nearly_straight = divisions == 0 or bulge.max() < STRAIGHT * self._radius
        if nearly_straight and _shortest(last) <= self._contact:
            return _root(lambda time: _shortest(vectors_at(time)) - self._contact, begin, end)
        if divisions == 0:
            return middle if _shortest(between) <= self._contact else None
        earlier = self._first_touch(begin, first, middle, between, vectors_at, divisions - 1)
        if earlier is not None:
            return earlier
        return self._first_touch(middle, between, end, last, vectors_at, divisions - 1)

    def _turned(self, begin: float, end: float, poses_at: PosesAt) -> Stop:
        periodic = self._period > 0.0
        time = _root(lambda t: least_alignment(poses_at(t)[1], periodic), begin, end)
        link = least_aligned(poses_at(time)[1], periodic)[1]
        return Stop(Cause.TURN, time, f"link {link} has turned by a quarter turn")


def _chord_distances(first: np.ndarray, last: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The least |x| on the straight lines between the rows of two arrays, and at which part."""
    along = last - first
    length = np.einsum("ik,ik->i", along, along)
    parts = -np.einsum("ik,ik->i", first, along) / np.where(length > 0.0, length, 1.0)
    parts = np.clip(parts, 0.0, 1.0)
    return np.linalg.norm(first + parts[:, None] * along, axis=1), parts


def _shortest(vectors: np.ndarray) -> float:
    return float(np.linalg.norm(vectors, axis=1).min())


def _root(function: Callable[[float], float], begin: float, end: float) -> float:
    """Where a function that is not positive at the end, and was at the beginning, vanishes."""
    from scipy.optimize import brentq

    if function(begin) <= 0.0:
        return begin
    return brentq(function, begin, end, xtol=4.0 * np.spacing(end))
