"""Pseudo-arclength and events on curves that are known in closed form."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from nrchain.states.branches.curve import Corrected, Direction, unit
from nrchain.states.branches.events import events_between
from nrchain.states.branches.follow import END, Follower, Limits


@dataclass(frozen=True, eq=False)
class Point:
    x: np.ndarray
    value: float


class NormalForm:
    """ẋ = f(x, p) with the derivatives of f: solutions are its fixed points."""

    def __init__(self, f, jacobian, slope):
        self.f, self.jacobian, self.slope = f, jacobian, slope

    def inner(self, first, second):
        return float(first.change @ second.change) + first.value * second.value

    def moved(self, point, direction):
        return Point(point.x + direction.change, point.value + direction.value)

    def _border(self, point, across):
        top = np.column_stack(
            [self.jacobian(point.x, point.value), self.slope(point.x, point.value)]
        )
        return np.vstack([top, np.append(across.change, across.value)])

    def _solve(self, point, across, right):
        try:
            return np.linalg.solve(self._border(point, across), right)
        except np.linalg.LinAlgError as error:
            raise FloatingPointError(str(error)) from None

    def corrected(self, guess, direction):
        across, begin = unit(self, direction), guess
        for steps in range(10):
            right = np.append(-self.f(guess.x, guess.value), 0.0)
            step = self._solve(guess, across, right)
            guess = self.moved(guess, Direction(step[:-1], step[-1]))
            if np.abs(step).max() < 1e-13:
                return Corrected(guess, steps + 1, 0.0, self.distance(begin, guess))
        raise FloatingPointError("no convergence")

    def tangent(self, point, along):
        right = np.append(np.zeros(len(point.x)), 1.0)
        found = self._solve(point, along, right)
        return unit(self, Direction(found[:-1], found[-1]))

    def exponents(self, point):
        rates = np.linalg.eigvals(self.jacobian(point.x, point.value)).astype(complex)
        return rates[np.argsort(-rates.real)]

    def is_real(self, point, exponent):
        return abs(exponent.imag) < 1e-9

    def branching(self, point, exponents, multiplicity):
        return "branching"

    def oscillation(self, point, exponent):
        return "Hopf", 2

    def distance(self, first, second):
        return math.hypot(*(second.x - first.x), second.value - first.value)

    def noise(self, point):
        return 1e-12

    def gone(self, point):
        return "x is above 3" if point.x[0] > 3.0 else ""


def follow(curve, x, p, *, low=-5.0, high=5.0, steps=400, sense=1.0, largest=0.05):
    follower = Follower(curve, Limits(low, high, steps, largest))
    begin = follower.place(Point(np.array(x, float), p), Direction(np.zeros(len(x)), sense))
    places, events = [begin], []
    for place in follower.places(begin):
        events += events_between(follower, places[-1], place)
        places.append(place)
    return places, events, follower.reason


def circle(radius):
    """x² + p² = R², as the fixed points of ẋ = x² + p² − R²."""
    return NormalForm(
        lambda x, p: x * x + p * p - radius**2,
        lambda x, p: np.array([[2.0 * x[0]]]),
        lambda x, p: np.array([2.0 * p]),
    )


def test_a_closed_curve_is_passed_once_with_both_of_its_folds():
    places, events, reason = follow(circle(1.5), [-1.5], 0.0)
    assert reason == "the branch is closed"
    assert [event.kind for event in events] == ["fold", "fold"]
    assert [event.value for event in events] == pytest.approx([1.5, -1.5], abs=1e-10)
    # the error is stated, and holds
    assert all(abs(abs(event.value) - 1.5) <= 10.0 * event.error < 1e-6 for event in events)
    length = sum(place.length for place in places)
    assert length == pytest.approx(3.0 * math.pi, rel=0.02)
    radii = [math.hypot(place.solution.x[0], place.solution.value) for place in places]
    assert radii == pytest.approx([1.5] * len(places), abs=1e-12)


def test_stability_is_counted_between_folds():
    places, _, _ = follow(circle(1.5), [-1.5], 0.0)
    for place in places:
        assert place.unstable == (place.solution.x[0] > 0.0)


def test_a_branch_point_is_found_where_a_rate_vanishes():
    """ẋ = (p − 0.3) x − x³ on x = 0."""
    curve = NormalForm(
        lambda x, p: (p - 0.3) * x - x**3,
        lambda x, p: np.array([[p - 0.3 - 3.0 * x[0] ** 2]]),
        lambda x, p: x.copy(),
    )
    _, events, reason = follow(curve, [0.0], -1.0, low=-1.0, high=1.0)
    assert reason == END
    assert [event.kind for event in events] == ["branching"]
    assert events[0].value == pytest.approx(0.3, abs=1e-9)


def test_a_curve_that_meets_one_of_higher_symmetry_comes_back_as_its_image():
    """x² = p − 0.3, from above: p is least where x = 0, and no rate changes its sign."""
    curve = NormalForm(
        lambda x, p: (p - 0.3) * x - x**3,
        lambda x, p: np.array([[p - 0.3 - 3.0 * x[0] ** 2]]),
        lambda x, p: x.copy(),
    )
    _, events, _ = follow(curve, [math.sqrt(0.7)], 1.0, low=-1.0, high=1.0, sense=-1.0)
    assert [event.kind for event in events] == ["pitchfork"]
    assert events[0].value == pytest.approx(0.3, abs=1e-4)


def test_a_hopf_point_has_its_frequency():
    """ẋ = (p − 0.2) x − 1.7 y, ẏ = 1.7 x + (p − 0.2) y beside a mode that decays."""

    def matrix(p):
        return np.array([[p - 0.2, -1.7, 0.0], [1.7, p - 0.2, 0.0], [0.0, 0.0, -0.1]])

    curve = NormalForm(lambda x, p: matrix(p) @ x, lambda x, p: matrix(p), lambda x, p: np.zeros(3))
    places, events, _ = follow(curve, [0.0] * 3, -1.0, low=-1.0, high=1.0)
    assert [event.kind for event in events] == ["Hopf"]
    assert events[0].value == pytest.approx(0.2, abs=1e-9)
    assert events[0].frequency == pytest.approx(1.7, abs=1e-9)
    assert events[0].multiplicity == 1
    assert (places[0].unstable, places[-1].unstable) == (0, 2)


def test_two_rates_that_cross_on_one_step_are_two_events_and_equal_ones_are_one():
    def curve(second):
        rates = np.array([0.30, second])
        return NormalForm(
            lambda x, p: (p - rates) * x,
            lambda x, p: np.diag(p - rates),
            lambda x, p: x.copy(),
        )

    _, apart, _ = follow(curve(0.31), [0.0, 0.0], 0.0, low=0.0, high=1.0, largest=0.5)
    assert [event.value for event in apart] == pytest.approx([0.30, 0.31], abs=1e-9)
    _, equal, _ = follow(curve(0.30), [0.0, 0.0], 0.0, low=0.0, high=1.0, largest=0.5)
    assert [event.multiplicity for event in equal] == [2]


def test_the_last_place_is_on_the_limit_to_the_last_bit():
    places, _, reason = follow(circle(1.5), [-1.5], 0.0, low=-1.0, high=0.7)
    assert reason == END
    assert places[-1].solution.value == 0.7


def test_a_curve_ends_where_a_chain_does_not_get():
    line = NormalForm(
        lambda x, p: x - p, lambda x, p: np.array([[1.0]]), lambda x, p: np.array([-1.0])
    )
    places, _, reason = follow(line, [0.0], 0.0, high=5.0)
    assert reason == "x is above 3"
    assert places[-1].solution.x[0] <= 3.0


def test_steps_shorten_where_a_curve_turns():
    """A sharp bend, (x − tanh(50 p))."""
    bend = NormalForm(
        lambda x, p: x - np.tanh(50.0 * p),
        lambda x, p: np.array([[1.0]]),
        lambda x, p: np.array([-50.0 / np.cosh(50.0 * p) ** 2]),
    )
    places, _, reason = follow(bend, [math.tanh(-50.0)], -1.0, low=-1.0, high=1.0, largest=0.3)
    assert reason == END
    lengths = np.array([place.length for place in places[1:]])
    assert lengths.min() < 0.1 * lengths.max()
    for place in places:
        assert place.solution.x[0] == pytest.approx(
            math.tanh(50.0 * place.solution.value), abs=1e-9
        )
