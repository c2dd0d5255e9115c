"""V = Σ_{i<j} φ(|r_i − r_j|): the energy of spheres that repel each other at short distances.

With ε the strength and c the range, the distance of centres at which repulsion begins,

    wca        φ = 4ε[(σ/r)¹² − (σ/r)⁶ + 1/4],  σ = c/2^(1/6)
    harmonic   φ = (ε/2)(1 − r/c)²

for r < c, and 0 beyond; φ and φ′ are continuous at c. Forces act along the line of centres,
F_i = −φ′ n with n = (r_i − r_j)/r. There are no torques.

Source: Weeks, Chandler, Andersen, J. Chem. Phys. 54, 5237 (1971).
"""

from __future__ import annotations

import numpy as np

from nrchain._addresses import (
    ROW,
    Term,
    carray,
    compile_term,
    cube_in,
    floats_at,
    integers_at,
    matrix_in,
    table_of,
    vector_in,
)
from nrchain._compile import kernel, part
from nrchain.geometry.near_pairs import list_pairs, near_pairs

KINDS = {"wca": 0, "harmonic": 1}

SKIN = 0.3
"""Pairs are listed up to this fraction beyond the range, and anew after moves of half of it."""


@kernel
def potential(kind, distance, strength, reach):
    """φ, φ′ and φ″ at a distance below the range."""
    if kind == 0:
        sixth = 0.5 * (reach / distance) ** 6
        energy = 4.0 * strength * (sixth * sixth - sixth + 0.25)
        slope = -24.0 * strength * (2.0 * sixth * sixth - sixth) / distance
        curvature = 24.0 * strength * (26.0 * sixth * sixth - 7.0 * sixth) / distance**2
        return energy, slope, curvature
    depth = 1.0 - distance / reach
    return 0.5 * strength * depth**2, -strength * depth / reach, strength / reach**2


@part
def _separation(positions, i, j, period, vector):
    """Fill ``vector`` with r_i − r_j to the nearest image; return its length."""
    for k in range(3):
        vector[k] = positions[i, k] - positions[j, k]
    if period > 0.0:
        vector[0] -= period * np.rint(vector[0] / period)
    return np.sqrt(vector[0] ** 2 + vector[1] ** 2 + vector[2] ** 2)


@kernel
def _add_forces(positions, pairs, kind, strength, reach, period, wrenches):
    """wrenches[:, :3] += the forces; returns the energy."""
    vector, total = np.empty(3), 0.0
    for p in range(pairs.shape[0]):
        i, j = pairs[p]
        distance = _separation(positions, i, j, period, vector)
        if distance >= reach:
            continue
        energy, slope, _ = potential(kind, distance, strength, reach)
        total += energy
        for k in range(3):
            force = -slope * vector[k] / distance
            wrenches[i, k] += force
            wrenches[j, k] -= force
    return total


@kernel
def _fill_stiffness(positions, pairs, kind, strength, reach, period, stiffness):
    """stiffness (M, 3, 3) = φ″ n nᵀ + (φ′/r)(I − n nᵀ) of each pair: −∂F_i/∂r_i."""
    vector = np.empty(3)
    for p in range(pairs.shape[0]):
        stiffness[p] = 0.0
        distance = _separation(positions, pairs[p, 0], pairs[p, 1], period, vector)
        if distance >= reach:
            continue
        _, slope, curvature = potential(kind, distance, strength, reach)
        across = slope / distance
        for k in range(3):
            stiffness[p, k, k] = across
            for m in range(3):
                along = (curvature - across) * vector[k] * vector[m] / distance**2
                stiffness[p, k, m] += along


@kernel
def _add_blocks(pairs, stiffness, periodic, blocks):
    """Add ∂F/∂r to the blocks (N, 2w + 1, 6, 6): of every sphere with itself, and near ones."""
    count, centre = blocks.shape[0], blocks.shape[1] // 2
    for p in range(pairs.shape[0]):
        i, j = pairs[p]
        places = j - i
        if periodic and 2 * places > count:
            places -= count
        for k in range(3):
            for m in range(3):
                blocks[i, centre, k, m] -= stiffness[p, k, m]
                blocks[j, centre, k, m] -= stiffness[p, k, m]
                if abs(places) <= centre:
                    blocks[i, centre + places, k, m] += stiffness[p, k, m]
                    blocks[j, centre - places, k, m] += stiffness[p, k, m]


@kernel
def _add_product(pairs, stiffness, poses, wrenches):
    """wrenches += ∂F/∂r · displacements."""
    for p in range(pairs.shape[0]):
        i, j = pairs[p]
        for k in range(3):
            change = 0.0
            for m in range(3):
                change += stiffness[p, k, m] * (poses[i, m] - poses[j, m])
            wrenches[i, k] -= change
            wrenches[j, k] += change


@kernel
def _has_moved(listed, positions, limit):
    """Whether a sphere has moved farther than ``limit``, beside the motion of all."""
    count, mean = positions.shape[0], np.empty(3)
    mean[:] = 0.0
    for i in range(count):
        for k in range(3):
            mean[k] += (positions[i, k] - listed[i, k]) / count
    furthest = 0.0
    for i in range(count):
        square = 0.0
        for k in range(3):
            square += (positions[i, k] - listed[i, k] - mean[k]) ** 2
        if not square <= furthest:
            furthest = square
    return not furthest <= limit**2


# Places of arrays in the table of a term: the pairs listed, and where; the pairs beyond the last
# blocks, and the stiffness of pairs; how many of both, N and the kind; ε, c and the period.
PAIRS, LISTED, FAR, STIFFNESS, COUNTS, LAW = range(6)


@part
def _pairs_at(t, positions):
    """The pairs near these positions, from the list of a term; listed anew where that is old."""
    counts, law = vector_in(t, COUNTS, integers_at), vector_in(t, LAW, floats_at)
    pairs, listed, reach = matrix_in(t, PAIRS, integers_at), matrix_in(t, LISTED, floats_at), law[1]
    if counts[0] < 0 or _has_moved(listed, positions, 0.5 * SKIN * reach):
        counts[0] = list_pairs(positions, reach + SKIN * reach, law[2], pairs)
        for i in range(listed.shape[0]):
            for k in range(3):
                listed[i, k] = positions[i, k]
    return pairs[: counts[0]]


@part
def _acts(stiffness):
    """Whether an element of (3, 3) is not zero."""
    for k in range(3):
        for m in range(3):
            if stiffness[k, m] != 0.0:
                return True
    return False


def _add_at(context: int, positions: int, frames: int, out: int, width: int) -> int:
    """The term of :meth:`Repulsion.add_wrenches`."""
    t = carray(integers_at(context), (6, ROW))
    counts, law = vector_in(t, COUNTS, integers_at), vector_in(t, LAW, floats_at)
    n, kind = counts[2], counts[3]
    r, wrenches = carray(floats_at(positions), (n, 3)), carray(floats_at(out), (n, 6))
    _add_forces(r, _pairs_at(t, r), kind, law[0], law[1], law[2], wrenches)
    return 0


def _add_blocks_at(context: int, positions: int, frames: int, out: int, width: int) -> int:
    """The term of :meth:`Repulsion.add_blocks`; notes the pairs that do not fit in."""
    t = carray(integers_at(context), (6, ROW))
    counts, law = vector_in(t, COUNTS, integers_at), vector_in(t, LAW, floats_at)
    n, kind, far = counts[2], counts[3], matrix_in(t, FAR, integers_at)
    r = carray(floats_at(positions), (n, 3))
    pairs, stiffness = _pairs_at(t, r), cube_in(t, STIFFNESS, floats_at)
    _fill_stiffness(r, pairs, kind, law[0], law[1], law[2], stiffness)
    blocks = carray(floats_at(out), (n, 2 * width + 1, 6, 6))
    _add_blocks(pairs, stiffness, law[2] > 0.0, blocks)
    found = 0
    for p in range(pairs.shape[0]):
        i, j = pairs[p]
        places = min(j - i, n - j + i) if law[2] > 0.0 else j - i
        if places > width and _acts(stiffness[p]):
            far[found, 0], far[found, 1] = i, j
            for k in range(3):
                for m in range(3):
                    stiffness[found, k, m] = stiffness[p, k, m]
            found += 1
    counts[1] = found
    return 0


def _add_far_at(context: int, poses: int, frames: int, out: int, width: int) -> int:
    """wrenches[i] += ∂F_i/∂r_j · u_j for the pairs that the last blocks do not hold."""
    t = carray(integers_at(context), (6, ROW))
    counts, far = vector_in(t, COUNTS, integers_at), matrix_in(t, FAR, integers_at)
    n, found, stiffness = counts[2], counts[1], cube_in(t, STIFFNESS, floats_at)
    if out == 0 or found == 0:
        return 1 if found else 0
    moves, wrenches = carray(floats_at(poses), (n, 6)), carray(floats_at(out), (n, 6))
    for p in range(found):
        i, j = far[p]
        for k in range(3):
            for m in range(3):
                wrenches[i, k] += stiffness[p, k, m] * moves[j, m]
                wrenches[j, k] += stiffness[p, k, m] * moves[i, m]
    return 1


class Repulsion:
    """F_i = −Σ_j φ′(r_ij) n_ij: the forces between near spheres, and their derivative.

    Sums run over pairs in lexical order: results do not depend on when the pairs were listed.

    Parameters
    ----------
    kind
        A key of :data:`KINDS`.
    strength
        ε, an energy.
    reach
        c, the distance of centres at which the repulsion begins; less than half the period.
    period
        Length along x after which the chain repeats; 0 for an open chain.
    """

    def __init__(self, kind: str, strength: float, reach: float, period: float = 0.0) -> None:
        self._law = KINDS[kind], float(strength), float(reach), float(period)
        self._reach, self._period = float(reach), float(period)
        self._listed = np.empty((0, 3))
        self._pairs = np.empty((0, 2), np.int64)
        self._stiff_pairs, self._stiffness = self._pairs, np.empty((0, 3, 3))

    def pairs(self, positions: np.ndarray) -> np.ndarray:
        """Pairs (M, 2), i < j: all within the range, and some beyond."""
        if len(self._listed) != len(positions) or _has_moved(
            self._listed, positions, 0.5 * SKIN * self._reach
        ):
            skin = SKIN * self._reach
            self._pairs = near_pairs(positions, self._reach + skin, self._period)
            self._listed = positions.copy()
        return self._pairs

    def add_wrenches(self, positions: np.ndarray, wrenches: np.ndarray) -> float:
        """wrenches (N, 6) += (F, 0) at these positions (N, 3); returns the energy V."""
        return float(_add_forces(positions, self.pairs(positions), *self._law, wrenches))

    def linearise(self, positions: np.ndarray) -> None:
        """Take the derivative here, for :meth:`add_blocks` and :meth:`add_product`."""
        self._stiff_pairs = self.pairs(positions)
        self._stiffness = np.empty((len(self._stiff_pairs), 3, 3))
        _fill_stiffness(positions, self._stiff_pairs, *self._law, self._stiffness)

    def add_blocks(self, blocks: np.ndarray) -> None:
        """blocks[i, w + m] += ∂F_i/∂r_{i+m}, for up to w neighbours on either side.

        The diagonal block of a sphere sums over all its pairs.
        """
        _add_blocks(self._stiff_pairs, self._stiffness, self._period > 0.0, blocks)

    def add_product(self, poses: np.ndarray, wrenches: np.ndarray) -> None:
        """wrenches (N, 6) += the change of the forces with ``poses`` (N, 6)."""
        _add_product(self._stiff_pairs, self._stiffness, poses, wrenches)

    def term(self, count: int) -> Term:
        """The forces on ``count`` spheres as a term by address, with a list of pairs of its own.

        There is room for all pairs, of which a system gives memory to those that are written.
        """
        entries = tuple(compile_term(f) for f in (_add_at, _add_blocks_at, _add_far_at))
        kind, *law = self._law
        most = count * (count - 1) // 2
        arrays = (
            np.empty((most, 2), np.int64),
            np.empty((count, 3)),
            np.empty((most, 2), np.int64),
            np.empty((most, 3, 3)),
            np.array([-1, 0, count, kind]),
            np.array(law),
        )
        add, add_blocks, add_far = (entry.address for entry in entries)
        return Term(add, add_blocks, table_of(arrays), (*arrays, *entries), add_far)
