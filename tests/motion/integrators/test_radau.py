"""Radau IIA on SE(3): its order, its charts, and how it gives up."""

import numpy as np
import pytest
from support.stepping import Probe, distances, integrate, poses_at, prepare, small, tumbling

from nrchain.motion.chart_poses import TURN_LIMIT, room_to_turn
from nrchain.motion.integrators import radau_steps
from nrchain.motion.integrators.base import IntegrationError
from nrchain.motion.integrators.radau_steps import AT, ERROR, ITERATIONS, NEXT, RATE, ROOM

EXACT = 1e-9
"""Tolerance of Newton's iteration in fixed steps; it converges to 3e-5 of this."""


def slopes(steps, errors):
    """Least-squares slopes of log error over log step, one a column."""
    return -np.polyfit(np.log(steps), np.log(errors), 1)[0]


def test_order_on_a_chain_that_tumbles():
    """Global error ~ h⁵ in positions and in frames, on four spheres that turn 2.5 to 5 times.

    The reference takes 16 times as many steps as the coarsest run, and is itself held against
    CVODE, another method in other charts.
    """
    scene, steps = tumbling(), [192, 384, 768]
    end = scene.run.end
    reference = integrate(scene, "radau", EXACT, [end], fixed_step=end / 3072)
    assert reference.turned.min() > 2.5 * 2 * np.pi
    assert reference.turned.max() > 5.0 * 2 * np.pi
    assert max(distances(reference, integrate(scene, "cvode", 1e-12, [end]))) < 1e-7
    errors = [
        distances(integrate(scene, "radau", EXACT, [end], fixed_step=end / n), reference)
        for n in steps
    ]
    assert slopes(steps, errors) == pytest.approx([5.0, 5.0], abs=0.1)
    assert errors[-1][0] < 2e-7
    assert errors[-1][1] < 5e-8


def test_order_between_the_ends_of_steps():
    """The collocation polynomial errs by O(h⁴): halfway through a first step."""
    scene, steps = tumbling(), [64, 128, 256]
    errors = []
    for n in steps:
        halfway = 0.5 / n
        path = integrate(scene, "radau", EXACT, [halfway], fixed_step=1.0 / n)
        reference = integrate(scene, "radau", EXACT, [halfway], fixed_step=halfway / 8)
        errors.append(distances(path, reference))
    assert slopes(steps, errors) == pytest.approx([4.0, 4.0], abs=0.1)
    assert max(errors[-1]) < 1e-8


def test_fixed_steps_are_taken_whatever_their_error():
    _, integrator = prepare(tumbling(), "radau", 1e-12, fixed_step=0.0625)
    assert [integrator.step() for _ in range(8)] == [0.0625 * (n + 1) for n in range(8)]


def test_a_fixed_step_that_cannot_be_solved_is_refused():
    _, integrator = prepare(tumbling(), "radau", 1e-8, fixed_step=6.0)
    with pytest.raises(IntegrationError, match=r"Newton.*step of 6"):
        integrator.step()


def test_every_step_has_its_chart_and_stays_well_inside():
    chain, integrator = prepare(tumbling(), "radau", 1e-1)
    reached = 0.0
    for _ in range(30):
        before = poses_at(chain, integrator, reached)
        began, reached = reached, integrator.step()
        assert chain.time == began
        assert chain.base_positions == pytest.approx(before[0], abs=1e-13)
        # two kernels compute the same frames, each with its own rounding
        assert chain.base_frames == pytest.approx(before[1], abs=1e-14)
        y = integrator.at(reached)
        assert 0.0 < chain.largest_turn(y) <= TURN_LIMIT


@pytest.mark.parametrize("angle", [0.3, 1.2, 2.9])
def test_a_step_is_measured_against_a_quarter_turn(angle):
    """y of a rotation by α about n has θ = 2 tan(α/2) n, whatever the other spheres do."""
    y = np.zeros(24)
    y[3:6] = 0.1
    y[-3:] = 2.0 * np.tan(0.5 * angle) * np.array([2.0, -3.0, 6.0]) / 7.0
    assert room_to_turn(y) == pytest.approx(0.5 * np.pi / angle)


def test_the_predictor_and_the_kept_jacobian_save_work():
    """Smooth stretches take two iterations a step, and few Jacobians."""
    path = integrate(small("buckling", 12, 400.0), "radau", 1e-8, [400.0])
    assert path.integrator.steps > 80
    assert path.chain.evaluations < 8 * path.integrator.steps
    assert path.chain.jacobians < 0.2 * path.integrator.steps


@pytest.mark.parametrize(("first", "growth"), [(0.7, 3.0), (0.6, 5.0), (0.8, 2.0)])
def test_an_error_that_grows_from_step_to_step_is_foreseen(first, growth):
    """Errors C h⁴ with C growing by one factor a step: the third is what a constant C would give.

    As of the controller of Gustafsson; see Hairer and Wanner, Solving ODEs II, IV.8.
    """
    _, integrator = prepare(tumbling(), "radau", 1e-6)
    integrator.step()
    equation, step, errors = integrator.equation, first, []
    shared = equation.numbers, equation.counts, equation.vectors
    equation.numbers[[ERROR, RATE, ROOM]] = 0.0, 1.0, np.inf
    for k in range(3):
        errors.append(growth**k * step**4)
        radau_steps.accept(*shared, step, ITERATIONS, errors[-1], False)
        step = float(equation.numbers[NEXT])
    assert errors[2] == pytest.approx(errors[1] / growth, rel=1e-12)


def test_gives_up_when_steps_vanish():
    """Beyond a time, twists are no numbers: the last step reaches up to it."""
    scene, wall = tumbling(), 0.7
    probe = Probe(scene, lambda positions: 0.0 if numbers[AT] <= wall else np.nan)
    _, integrator = prepare(scene, "radau", 1e-6, probe)
    numbers = integrator.equation.numbers

    def go_on():
        for _ in range(1000):
            integrator.step()

    with pytest.raises(IntegrationError, match=r"too small: Newton's iteration does not"):
        go_on()
    assert integrator.reached == pytest.approx(wall, abs=1e-12)
