"""Z = h (A ⊗ I) F(Z): the stages of the Radau IIA method of order 5, by simplified Newton.

Hairer & Wanner, *Solving Ordinary Differential Equations II* (2nd ed., 1996): coefficients from
Sec. IV.5; the iteration, its decoupling and the error estimate from Sec. IV.8. Stages are
increments Z_i = Y_i − y_n, and y_{n+1} = y_n + Z_3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nrchain._compile import kernel
from nrchain.motion.integrators.linear import Jacobian, Solve

_S6 = np.sqrt(6.0)

NODES = np.array([(4.0 - _S6) / 10.0, (4.0 + _S6) / 10.0, 1.0])
"""c: the collocation points of a step."""

RUNGE_KUTTA = np.array(
    [
        [(88 - 7 * _S6) / 360, (296 - 169 * _S6) / 1800, (-2 + 3 * _S6) / 225],
        [(296 + 169 * _S6) / 1800, (88 + 7 * _S6) / 360, (-2 - 3 * _S6) / 225],
        [(16 - _S6) / 36, (16 + _S6) / 36, 1 / 9],
    ]
)
"""A, whose last row is b: the method is stiffly accurate."""

ITERATIONS = 7
"""Newton iterations after which a step is shortened (Sec. IV.8, k_max)."""


def _decoupled() -> tuple[float, complex, np.ndarray, np.ndarray]:
    """λ_r, λ_c of A⁻¹ = S diag(λ) S⁻¹ and the columns of S and rows of S⁻¹ that go with them.

    The third eigenvalue and its vectors are conjugates.
    """
    values, vectors = np.linalg.eig(np.linalg.inv(RUNGE_KUTTA))
    pair = [int(np.argmin(np.abs(values.imag))), int(np.argmax(values.imag))]
    real, complex_ = values[pair]
    return float(real.real), complex(complex_), vectors[:, pair], np.linalg.inv(vectors)[pair]


REAL, COMPLEX, _COLUMNS, _ROWS = _decoupled()
# An eigenvector is known up to a factor: make the real one real.
_PHASE = _COLUMNS[0, 0] / abs(_COLUMNS[0, 0])
_FROM_REAL, _TO_REAL = (_COLUMNS[:, 0] / _PHASE).real, (_ROWS[0] * _PHASE).real
_FROM_COMPLEX, _TO_COMPLEX = _COLUMNS[:, 1].copy(), _ROWS[1]

_ESTIMATE = np.array([-13.0 - 7.0 * _S6, -13.0 + 7.0 * _S6, -1.0]) / (3.0 * REAL)
"""(e_1, e_2, e_3) of the error estimate, with γ_0 = 1/λ_r."""

Rates = Callable[[float, np.ndarray, np.ndarray], None]


def cubics(nodes: np.ndarray) -> np.ndarray:
    """C (3, 3): Σ_k C_jk x^(k+1) is 1 at node j, and 0 at the other two and at x = 0."""
    return np.linalg.inv(nodes ** np.array([[1], [2], [3]]))


def powers(x: np.ndarray | float) -> np.ndarray:
    """x, x², x³."""
    return np.array([x, x**2, x**3])


def scaled_norm(vectors: np.ndarray, scale: np.ndarray) -> float:
    """√mean((v/scale)²) over all components of all vectors."""
    return float(np.sqrt(np.mean((vectors / scale) ** 2)))


@kernel
def _decouple(slopes, stages, real_step, pair_step, to_real, to_pair, real, pair):
    """The right-hand sides (h/λ) S⁻¹F − S⁻¹Z of the real and of one complex system."""
    for m in range(real.shape[0]):
        real[m], pair[m] = 0.0, 0.0
        for i in range(3):
            real[m] += to_real[i] * (real_step * slopes[i, m] - stages[i, m])
            pair[m] += to_pair[i] * (pair_step * slopes[i, m] - stages[i, m])


@kernel
def _couple(real, pair, from_real, from_pair, change):
    """ΔZ = S ΔW, with the conjugate of the complex part."""
    for i in range(3):
        for m in range(real.shape[0]):
            change[i, m] = from_real[i] * real[m] + 2.0 * (from_pair[i] * pair[m]).real


@dataclass
class Outcome:
    """The result of a Newton iteration: stages (3, dimension) if it converged, and its rate."""

    stages: np.ndarray
    converged: bool
    iterations: int
    rate: float


class StageSystem:
    """Z = h (A ⊗ I) F(Z): solves for the stages of a step, with one Jacobian at a time.

    ``solves`` counts the linear systems, real and complex; ``patience`` is the largest number of
    Newton iterations of a step.
    """

    def __init__(
        self, rates: Rates, jacobian: Jacobian, dimension: int, patience: int = ITERATIONS
    ) -> None:
        self._rates_at, self._jacobian, self._patience = rates, jacobian, patience
        self._slopes, self._change = np.empty((3, dimension)), np.empty((3, dimension))
        self._real, self._pair = np.empty(dimension), np.empty(dimension, complex)
        self.solves = 0
        self.reset()

    def reset(self) -> None:
        """Discard the convergence rate of earlier iterations."""
        self._rate, self._eta = 1.0, np.inf

    def factorise(self, step: float) -> None:
        """Take I − h/λ J for both eigenvalues λ."""
        self.step = step
        self._solve_real: Solve = self._jacobian.shifted_inverse(step / REAL)
        self._solve_complex: Solve = self._jacobian.shifted_inverse(step / COMPLEX)

    def solve(
        self, time: float, guess: np.ndarray, scale: np.ndarray, tolerance: float, rounding: float
    ) -> Outcome:
        """Iterate until the error of Z is below ``tolerance``, in units of ``scale``.

        The error is η ‖ΔZ‖ with η = θ/(1 − θ), θ the rate of convergence. Before θ is known, the
        last η^0.8 is used, which grows with every step without a measured rate. Changes below
        ``rounding`` end the iteration.
        """
        stages, last = guess.copy(), 0.0
        self._eta = max(self._eta, np.finfo(float).eps) ** 0.8
        for iteration in range(1, self._patience + 1):
            change = self._newton_change(time, stages)
            if change is None:
                break
            size = scaled_norm(change, scale)
            if iteration > 1:
                self._rate = rate = size / last
                self._eta = rate / (1.0 - rate) if rate < 1.0 else np.inf
                left = self._patience - iteration
                expected = min(rate, 1.0) ** left * (1.0 + self._eta) * size
                if expected > tolerance and size > rounding:
                    break
            stages += change
            if size <= rounding or self._eta * size <= tolerance:
                return Outcome(stages, True, iteration, self._rate)
            last = size
        self.reset()
        return Outcome(stages, False, self._patience, 1.0)

    def _newton_change(self, time: float, stages: np.ndarray) -> np.ndarray | None:
        """ΔZ = S ΔW, (I − h/λ J) ΔW = (h/λ) S⁻¹F − S⁻¹Z; none where the rates are not finite."""
        for node, stage, slope in zip(NODES, stages, self._slopes, strict=True):
            self._rates_at(time + node * self.step, stage, slope)
        if not np.isfinite(self._slopes).all():
            return None
        real, pair = self._real, self._pair
        steps = self.step / REAL, self.step / COMPLEX
        _decouple(self._slopes, stages, *steps, _TO_REAL, _TO_COMPLEX, real, pair)
        real, pair = self._solve_real(real), self._solve_complex(pair)
        self.solves += 2
        _couple(real, pair, _FROM_REAL, _FROM_COMPLEX, self._change)
        return self._change if np.isfinite(self._change).all() else None

    def error(self, slope: np.ndarray, stages: np.ndarray) -> np.ndarray:
        """(I − h γ_0 J)⁻¹ (h γ_0 f(t_n, y_n) + Σ e_i Z_i): of order h⁴, and bounded as hλ → ∞.

        ``slope`` is f(t_n, y_n).
        """
        self.solves += 1
        return self._solve_real(self.step / REAL * slope + _ESTIMATE @ stages)

    def filtered_error(self, time: float, stages: np.ndarray, error: np.ndarray) -> np.ndarray:
        """That estimate with f(t_n, y_n + error): 0 as hλ → ∞, at one further evaluation."""
        slope = np.empty_like(error)
        self._rates_at(time, error, slope)
        return self.error(slope, stages) if np.isfinite(slope).all() else error
