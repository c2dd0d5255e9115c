"""A, c and the eigenvectors of A⁻¹: the coefficients of the Radau IIA method of order 5.

Hairer & Wanner, *Solving Ordinary Differential Equations II* (2nd ed., 1996): coefficients from
Sec. IV.5; the decoupling of Newton's iteration and the error estimate from Sec. IV.8. Stages are
increments Z_i = Y_i − y_n = h Σ_j a_ij f(Y_j), and y_{n+1} = y_n + Z_3.
"""

from __future__ import annotations

import numpy as np

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
FROM_REAL, TO_REAL = (_COLUMNS[:, 0] / _PHASE).real.copy(), (_ROWS[0] * _PHASE).real.copy()
FROM_COMPLEX, TO_COMPLEX = _COLUMNS[:, 1].copy(), _ROWS[1].copy()
"""Columns of S and rows of S⁻¹, of the real eigenvalue and of the complex one."""

ESTIMATE = np.array([-13.0 - 7.0 * _S6, -13.0 + 7.0 * _S6, -1.0]) / (3.0 * REAL)
"""(e_1, e_2, e_3) of the error estimate, with γ_0 = 1/λ_r."""


def cubics(nodes: np.ndarray) -> np.ndarray:
    """C (3, 3): Σ_k C_jk x^(k+1) is 1 at node j, and 0 at the other two and at x = 0."""
    return np.linalg.inv(nodes ** np.array([[1], [2], [3]]))
