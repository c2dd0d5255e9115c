"""(I − hJ/λ) x = b with J of all pairs: the linear systems of Radau IIA, by GMRES.

J is not formed: products with it sum over pairs, in Python, and the factors of the part of J near
the diagonal are the preconditioner. Compiled steps call this solver by address.
"""

from __future__ import annotations

import numpy as np

from nrchain._addresses import Callback, array_at
from nrchain.motion.chart_jacobian import to_poses, to_rates
from nrchain.motion.charts import ChartedChain
from nrchain.motion.integrators.chain_equation import ChainEquation
from nrchain.motion.integrators.linear import gmres_solution
from nrchain.motion.integrators.radau_steps import (
    SCALE,
    SOLVE_PAIR,
    SOLVE_REAL,
    STEP,
)
from nrchain.motion.integrators.radau_tableau import COMPLEX, REAL


class KrylovSolver:
    """Solves in place of the direct functions of an ``equation``, whose factors precondition."""

    def __init__(self, chain: ChartedChain, equation: ChainEquation) -> None:
        self._chain, self._equation = chain, equation
        self._units = equation.vectors[SCALE]
        self._callbacks = [Callback(f) for f in (self._real, self._pair)]
        places = SOLVE_REAL, SOLVE_PAIR
        for place, callback in zip(places, self._callbacks, strict=True):
            equation.functions[place] = callback.address

    def raise_error(self) -> None:
        """Raise the exception of the call that failed last."""
        for callback in self._callbacks:
            callback.raise_error()

    def _scale(self, eigenvalue: complex) -> complex:
        """h/λ, of the type of λ."""
        return float(self._equation.numbers[STEP]) / eigenvalue

    def _real(self, source: int, target: int, flag: int, width: int) -> None:
        vector = array_at(source, (6 * self._chain.model.count,))
        vector[:] = self._solution(vector.copy(), self._scale(REAL), SOLVE_REAL)

    def _pair(self, source: int, target: int, flag: int, width: int) -> None:
        vector = array_at(source, (6 * self._chain.model.count,), complex)
        vector[:] = self._solution(vector.copy(), self._scale(COMPLEX), SOLVE_PAIR)

    def _solution(self, right: np.ndarray, scale: complex, which: int) -> np.ndarray:
        def precondition(vector: np.ndarray) -> np.ndarray:
            near = vector.copy()
            self._equation.call(which, near.ctypes.data)
            return near

        return gmres_solution(self._product, precondition, self._units, scale, right)

    def _product(self, vector: np.ndarray) -> np.ndarray:
        """J · vector, for a real vector (6N)."""
        chart, model = self._chain.chart, self._chain.model
        poses, changes, out = np.zeros((3, model.count, 6))
        to_poses(vector, chart.maps, chart.order, poses)
        poses[model.held] = 0.0
        model.add_product(poses, changes)
        flat = out.ravel()
        to_rates(changes, poses, chart.turning, vector, chart.maps, chart.order, flat)
        out[model.held] = 0.0
        return flat
