"""Failures of CVODE are exceptions of the integrator and print nothing."""

from collections import deque

import numpy as np
import pytest

from nrchain.motion.integrators.base import IntegrationError
from nrchain.motion.integrators.cvode import Cvode


class Equation:
    """ẏ = f(t, y) in one dimension, with ∂f/∂y, in place of a charted chain."""

    dimension = 1

    def __init__(self, rate, slope, is_banded=True):
        self._rate, self._slope, self.is_banded = rate, slope, is_banded

    def rates(self, t, y, out):
        out[:] = self._rate(t, y)

    def linearise(self, t, y):
        self._jacobian = self._slope(t, y)

    def factorise(self, gamma):
        self._factor = 1.0 - gamma * self._jacobian

    def solve(self, right, out):
        out[:] = right / self._factor

    def product(self, vector, out):
        out[:] = self._jacobian * vector


class Erratic:
    """−y, and after a hundred evaluations another number at every time."""

    def __init__(self):
        self._calls = 0

    def __call__(self, t, y):
        self._calls += 1
        return -y if self._calls < 100 else 1e12 * np.sin(1e17 * t) + 0.0 * y


CASES = {
    # y = 1/(1 − τ), τ = (t − 1e16)/1e7, where the next number after t is t + 2
    "t + h = t": (1e16, lambda t, y: 1e-7 * y**2, lambda t, y: 2e-7 * y, "advance the time"),
    "error test": (0.0, Erratic(), lambda t, y: -1.0 + 0.0 * y, "misses the tolerance at every"),
    "Newton": (0.0, lambda t, y: -1e9 * y**3, lambda t, y: 1e12 + 0.0 * y, "misses the tolerance"),
}


@pytest.mark.parametrize("case", CASES)
def test_a_failure_of_cvode_is_an_exception_and_prints_nothing(case, capfd, monkeypatch):
    monkeypatch.delenv("SUNLOGGER_WARNING_FILENAME", raising=False)
    begin, rate, slope, words = CASES[case]
    solver = Cvode(Equation(rate, slope), 1e18, 1e-5, np.full(1, 1e-5))
    solver.start(begin, np.ones(1))
    steps = iter(solver.step, None)
    with pytest.raises(IntegrationError, match=words), np.errstate(all="ignore"):
        deque(steps, maxlen=0)
    assert capfd.readouterr() == ("", "")


def test_a_start_that_rounding_has_brought_to_the_end_takes_a_step(capfd):
    solver = Cvode(Equation(lambda t, y: -y, lambda t, y: -1.0 + 0.0 * y), 2.0, 1e-8, np.ones(1))
    begin = float(np.nextafter(2.0, 0.0))
    solver.start(begin, np.ones(1))
    assert solver.step() > begin
    assert capfd.readouterr() == ("", "")


def test_factors_of_the_whole_matrix_are_used_once_for_each_newton_iteration():
    """With products as with the promise that factors are exact; ẏ = −y³ has y = 1/√(1 + 2t)."""
    found = {}
    for is_banded in (True, False):
        equation = Equation(lambda t, y: -(y**3), lambda t, y: -3.0 * y**2, is_banded)
        solver = Cvode(equation, 10.0, 1e-8, np.full(1, 1e-8))
        solver.start(0.0, np.ones(1))
        while solver.step() < 10.0:
            pass
        found[is_banded] = solver.at(10.0)[0], solver.steps, solver.solves
    (direct, steps, solves), (confirmed, their_steps, their_solves) = found[True], found[False]
    assert direct == pytest.approx(21.0**-0.5, rel=1e-6)
    assert confirmed == pytest.approx(direct, rel=1e-12)
    assert steps == their_steps
    assert 2 * solves == their_solves
