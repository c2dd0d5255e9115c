"""Which modes bend a chain and grow, and how much of each is in its poses: J v = λ v.

The part of the poses in modes of one rate is δ = Σ_k v_k a_k, with W*V a = W*f/λ: f is the
velocity, J δ, and the columns of V and W are the right and left eigenvectors of J at λ. Modes of
one rate are taken together, because any mixture of them is a mode too: a chain that bends alike in
all planes has two of each. For chains too long to compute all eigenvalues, those nearest to given
rates are computed from the part of J near the diagonal, which omits what spheres farther apart do
to each other.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.motion.charts import ChartedChain

DENSE = 130
"""Coordinates up to which all eigenvalues are computed: 20 ms; 400 would take a second."""

NEAREST = 6
"""Eigenvalues found on longer chains for each of the rates that matter."""

LADDER = (1.0, 4.0, 16.0)
"""Rates about which they are computed, in units of the fastest rate that steps resolve."""

FINER = 2.0
"""Ratio of the rates at which growth beyond them is ruled out."""

ACROSS = 1e-3
"""A mode bends the chain if more than this part of it is neither along it nor a rigid motion."""

FROZEN = 2.0
"""Modes count as growing from a state if they are this many times as fast as it changes."""

ALIKE = 1e-6
"""Eigenvalues that differ by less than this fraction count as one."""

SAME = 1e-4
"""The same for eigenvalues that are found by iterations, and to be computed more accurately."""

BESIDE = 1e-3
"""Distance from an eigenvalue at which J − σ is inverted, as a fraction of it."""

POWER = 5
"""How many times that inverse is applied."""

TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True)
class Growth:
    """Rates μ (K,) of the modes that bend the chain and grow, and the size of each coordinate.

    ``parts`` (K, 6N): the largest, over its phase, of what is in the poses of each.
    """

    rates: np.ndarray
    parts: np.ndarray


def growth_about_base(chain: ChartedChain, axis: np.ndarray, least: float, fast: float) -> Growth:
    """The modes about the base of a chain, nearly straight along ``axis``, faster than ``least``.

    Also faster than ``FROZEN`` times the rate at which links stretch or shorten: offsets grow with
    a chain that is stretched, as it takes its direction from how it lay, and nothing bends.
    On a long chain those near the rate ``least``, near ``fast`` and beyond it, and near a bound of
    all rates; none where the Jacobian is not finite or its eigenvalues are not found.
    """
    from scipy.sparse.linalg import ArpackError

    try:
        return _growth(chain, axis, least, fast)
    except (ArpackError, ArithmeticError, np.linalg.LinAlgError):
        return Growth(np.empty(0), np.empty((0, chain.dimension)))


def _growth(chain: ChartedChain, axis: np.ndarray, least: float, fast: float) -> Growth:
    still = np.zeros(chain.dimension)
    bound = max(least, FROZEN * _stretching(chain, axis))
    velocity = np.empty(chain.dimension)
    chain.rates(chain.time, still, velocity)
    chain.linearise(chain.time, still)
    long = chain.dimension > DENSE
    most = _bound(chain, bound, LADDER[-1] * fast) if long or chain.is_banded else math.inf
    if most <= bound:
        return Growth(np.empty(0), np.empty((0, chain.dimension)))
    if long:
        ladder = [fast * step for step in LADDER if fast * step < most]
        rates = dict.fromkeys((least, *ladder), NEAREST)
        if most < math.inf:
            rates[most] = (len(LADDER) - len(ladder)) * NEAREST
        values, shapes = _nearest(chain, rates)
        grows = _grow(chain, values, shapes, axis, bound)
        found = [_part_near(chain, value, velocity) for value in _apart(values[grows])]
        parts = np.reshape([part for _, part in found], (len(found), chain.dimension))
        return Growth(np.array([rate for rate, _ in found]), parts)
    from scipy.linalg import eig

    matrix = chain.jacobian()
    if not np.isfinite(matrix).all():
        raise FloatingPointError("the Jacobian is not finite")
    values, duals, shapes = eig(matrix, left=True)
    grows = _grow(chain, values, shapes, axis, bound)
    return _parts(values[grows], duals[:, grows], shapes[:, grows], velocity)


def _bound(chain: ChartedChain, least: float, fast: float) -> float:
    """A rate from ``least`` to ``fast`` beyond which nothing grows; infinite if none is found.

    It is ``FINER`` times too large at most, for what the symmetric part of J shows.
    """
    from scipy.linalg import cholesky_banded

    band = chain.symmetric_band()
    if band is None:
        return math.inf
    if not np.isfinite(band).all():
        raise FloatingPointError("the Jacobian is not finite")

    def nothing_grows_beyond(rate: float) -> bool:
        definite = -band
        definite[0] += rate
        try:
            cholesky_banded(definite, overwrite_ab=True, lower=True, check_finite=False)
        except np.linalg.LinAlgError:
            return False
        return True

    low, high = -1, math.ceil(math.log(max(fast / least, 1.0), FINER))
    if not nothing_grows_beyond(least * FINER**high):
        return math.inf
    while high - low > 1:
        middle = (low + high) // 2
        if nothing_grows_beyond(least * FINER**middle):
            high = middle
        else:
            low = middle
    return least * FINER**high


def _grow(
    chain: ChartedChain, values: np.ndarray, shapes: np.ndarray, axis: np.ndarray, bound: float
) -> np.ndarray:
    """Which modes bend the chain and grow faster; of two that turn in opposite ways, one."""
    grows = (values.real > bound) & ((values.imag > 0.0) | ~_turn(values))
    grows[grows] = _bends(chain, shapes[:, grows], axis)
    return grows


def _apart(values: np.ndarray) -> list[complex]:
    """The eigenvalues without those that are found twice, or belong to modes of one rate."""
    kept: list[complex] = []
    for value in values:
        if all(abs(value - other) > SAME * abs(value) for other in kept):
            kept.append(value)
    return kept


def _turn(values: np.ndarray) -> np.ndarray:
    """Which modes have a frequency: two real ones of one rate may be found with a tiny one."""
    return np.abs(values.imag) > ALIKE * np.abs(values)


def _parts(
    values: np.ndarray, duals: np.ndarray, shapes: np.ndarray, velocity: np.ndarray
) -> Growth:
    """What a velocity holds of modes with these eigenvalues, left and right eigenvectors."""
    rates, parts, left = [], [], np.ones(len(values), bool)
    for value in values[np.argsort(-values.real, kind="stable")]:
        alike = left & (np.abs(values - value) <= ALIKE * abs(value))
        if not alike.any():
            continue
        left &= ~alike
        dual, shape = duals[:, alike].conj().T, shapes[:, alike]
        weights = np.linalg.lstsq(dual @ shape, dual @ velocity / value)[0]
        rates.append(value.real)
        parts.append(_size(shape @ weights, value))
    return Growth(np.array(rates), np.array(parts).reshape(len(rates), len(velocity)))


def _size(part: np.ndarray, value: complex) -> np.ndarray:
    """|v| of a real part; 2|v|, the largest of 2 Re(v exp iωt), of one that turns."""
    return 2.0 * np.abs(part) if _turn(np.asarray(value)) else np.abs(part.real)


def _stretching(chain: ChartedChain, axis: np.ndarray) -> float:
    """max |d ln l/dt| of the links, each of length l along the axis, about the base."""
    positions = chain.base_positions
    twists = chain.model.twists(positions, chain.base_frames)
    apart, parting = (np.diff(rows @ axis) for rows in (positions, twists[:, :3]))
    return float(np.abs(parting / np.where(apart == 0.0, TINY, apart)).max())


def _bends(chain: ChartedChain, shapes: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Which modes (6N, K) are more across the axis than a shift and a turn of the whole chain."""
    modes = shapes.T.reshape(shapes.shape[1], len(chain.order), 2, 3)
    across = modes - (modes @ axis)[..., None] * axis
    places = chain.base_positions[chain.order] @ axis
    places = places - places.mean()
    across[:, :, 0] -= across[:, :, 0].mean(axis=1, keepdims=True)
    turn = np.einsum("n,knc->kc", places, across[:, :, 0]) / max(float(places @ places), TINY)
    across[:, :, 0] -= places[:, None] * turn[:, None]
    across[:, :, 1] -= np.cross(axis, turn)[:, None]
    most = np.abs(modes).max(axis=(1, 2, 3), initial=0.0)
    return np.abs(across).max(axis=(1, 2, 3), initial=0.0) > ACROSS * most


def _nearest(chain: ChartedChain, rates: dict[float, int]) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues and eigenvectors about these rates, of the Jacobian near its diagonal.

    ``rates`` says how many about each.
    """
    from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigs

    size = chain.dimension
    begin = np.random.default_rng(0).standard_normal(size)
    found = []
    for rate, number in rates.items():
        try:
            chain.factorise(1.0 / rate)
        except FloatingPointError:
            continue

        def inverse(vector: np.ndarray, rate=rate) -> np.ndarray:
            """(J − μ)⁻¹ v = −(I − J/μ)⁻¹ v/μ."""
            out = np.empty(size)
            chain.solve(vector, out)
            return out / -rate

        operator = LinearOperator((size, size), matvec=inverse, dtype=float)
        try:
            values, shapes = eigs(operator, k=number, v0=begin, tol=1e-3, maxiter=20)
        except ArpackNoConvergence as short:
            values, shapes = short.eigenvalues, short.eigenvectors
        found.append((rate + 1.0 / values, shapes))
    if not found:
        return np.empty(0), np.empty((size, 0))
    return np.concatenate([f[0] for f in found]), np.hstack([f[1] for f in found])


def _part_near(
    chain: ChartedChain, value: complex, velocity: np.ndarray
) -> tuple[float, np.ndarray]:
    """The rate, and what a velocity holds of the modes at an eigenvalue λ that is known roughly.

    (J − σ)⁻ᵐ f tends to (λ − σ)⁻ᵐ P f where σ is much nearer to λ than to any other eigenvalue: P
    takes out what f holds of these modes, however many there are.
    """
    shift = value * (1.0 + BESIDE)
    chain.factorise(1.0 / complex(shift))
    part, nearer = np.empty((2, chain.dimension), complex)
    nearer[:] = velocity
    for _ in range(POWER):
        part[:] = nearer
        chain.solve(part, nearer)
        nearer /= -shift
    square = np.vdot(nearer, nearer).real
    if square == 0.0:
        return value.real, np.zeros(chain.dimension)
    apart = np.vdot(nearer, part) / square
    rate = shift + apart
    return float(rate.real), _size(nearer * apart**POWER / rate, value)
