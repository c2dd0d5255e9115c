"""The terms of a model by address: the twists and blocks of the model, and errors in Python."""

import numpy as np
import pytest
from support.configurations import each
from support.poses import dense
from support.stepping import Probe, prepare, small, tumbling

from nrchain._addresses import Callback, table_of
from nrchain._compile import kernel
from nrchain.motion.bend import BendCheck
from nrchain.motion.integrators.base import Samples
from nrchain.motion.model import Model
from nrchain.motion.moving_chart import empty_chart
from nrchain.motion.terms import ModelTerms, set_blocks, set_carrying_twists, set_twists


@kernel
def evaluate(table, positions, frames, twists, carrying, blocks):
    """Statuses of all that terms fill."""
    at = positions.ctypes.data, frames.ctypes.data
    return (
        set_twists(table, at[0], at[1], twists),
        set_carrying_twists(table, at[0], at[1], carrying),
        set_blocks(table, at[0], at[1], blocks),
    )


def differs(configuration):
    """One law of slip for all, and no effect that is summed with others: few kernels."""
    apart = configuration.effect is None or not configuration.effect.fused
    return apart and len(configuration.slip) != 1 and not configuration.finite_size


@each(differs)
def test_terms_are_the_model(configuration):
    """Twists, those that carry the chain, and blocks; with friction of near spheres in full."""
    scene = configuration.scene()
    model, terms = Model(scene), ModelTerms(Model(scene))
    positions, frames = configuration.poses()
    count, friction_is_near = configuration.count, model.is_near and bool(model.friction)
    twists, carrying = np.ones((2, count, 6))
    blocks = np.ones((count, 2 * model.near_reach + 1, 6, 6))
    table = table_of((*empty_chart(count), *terms.tables))
    assert evaluate(table, positions.copy(), frames.copy(), twists, carrying, blocks) == (0, 0, 0)
    given = np.ones((count, 2 * model.reach + 1, 6, 6))
    model.linearise(positions, frames, given)
    if friction_is_near:
        blocks = dense(blocks, configuration.ends == "periodic")
        given = np.zeros((count, 6, count, 6))
        for sphere, component in np.ndindex(count, 6):
            move, out = np.zeros((2, count, 6))
            move[sphere, component] = 1.0
            model.add_product(move, out)
            given[:, :, sphere, component] = out
    for found, expected in (
        (twists, model.twists(positions, frames)),
        (carrying, model.carrying_twists(positions, frames)),
        (blocks, given),
    ):
        scale = np.abs(expected).max()
        assert found == pytest.approx(expected, rel=0, abs=1e-12 * scale)


def test_an_error_of_a_term_in_python_reaches_the_caller():
    scene = tumbling()

    def broken(positions):
        if probe.calls > 20:
            raise LookupError("no field here")
        return 0.0

    probe = Probe(scene, broken)
    _, integrator = prepare(scene, "radau", 1e-6, probe)

    def go_on():
        for _ in range(100):
            integrator.step()

    with pytest.raises(LookupError, match="no field here"):
        go_on()
    probe.twist = lambda positions: 0.0
    reached = integrator.reached
    assert reached > 0.0
    assert integrator.step() > reached


def test_an_error_is_raised_once():
    callback = Callback(lambda *addresses: 1 / 0)
    assert callback._entry(0, 0, 0, 0, 0) == 1
    with pytest.raises(ZeroDivisionError):
        callback.raise_error()
    callback.raise_error()


def test_tables_need_contiguous_arrays():
    with pytest.raises(ValueError, match="contiguous"):
        table_of([np.zeros((4, 4))[:, 1]])
    array = np.zeros((2, 3, 4))
    assert table_of([array])[0].tolist() == [array.ctypes.data, 2, 3, 4, 0]


@pytest.mark.parametrize("name", ["buckling", "wave"])
def test_many_steps_at_once_are_the_same_steps(name):
    """Bits do not depend on how many steps compiled code takes in one go."""
    ends = []
    for most in (1, 7, 40):
        _, integrator = prepare(small(name, 6, 400.0), "radau", 1e-6)
        taken = 0
        while taken < 40:
            samples = wanting(np.inf)
            taken += integrator.advance(samples, min(most, 40 - taken), integrator.equation.checks)
        assert taken == integrator.steps == 40
        ends.append(integrator.poses_at(integrator.reached))
    for positions, frames in ends[1:]:
        assert np.array_equal(positions, ends[0][0])
        assert np.array_equal(frames, ends[0][1])


NEARLY_STRAIGHT = {"start.amplitude": 1e-4}


def test_steps_end_where_they_have_to_be_looked_at():
    """At a time, where spheres may touch, or where a chain that is not paused is straight."""
    _, integrator = prepare(small("buckling", 6, 400.0, **NEARLY_STRAIGHT), "radau", 1e-6)
    checks = integrator.equation.checks
    bend = BendCheck.of(6, 1.0, 0.0)
    bend.pause[0] = 4
    assert integrator.advance(wanting(np.inf), 100, checks._replace(bend=bend)) == 5
    before = integrator.reached
    integrator.advance(wanting(2.0 * before), 100, checks)
    assert integrator.begin < 2.0 * before <= integrator.reached
    near = checks.clearance._replace(limits=np.array([1e3, 0.0, 0.0]))
    assert integrator.advance(wanting(np.inf), 100, checks._replace(clearance=near)) == 1


def test_samples_are_the_poses_of_single_steps():
    """Steps that run on sample what single steps give at these times, up to the step to be seen."""
    _, probe = prepare(small("wave", 6, 400.0), "radau", 1e-6)
    _, alone = prepare(small("wave", 6, 400.0), "radau", 1e-6)
    _, integrator = prepare(small("wave", 6, 400.0), "radau", 1e-6)
    ends = [probe.step() for _ in range(30)]
    times = np.linspace(0.0, ends[-1], 41)[1:]
    samples = wanting(*times)
    assert integrator.advance(samples, 30, integrator.equation.checks) == 30
    assert samples.taken == np.count_nonzero(times <= ends[-2]) > 5
    for k in range(samples.taken):
        while alone.reached < times[k]:
            alone.step()
        positions, frames = alone.poses_at(times[k])
        assert samples.counted[k].tolist() == [alone.steps, alone.chain.evaluations]
        assert np.array_equal(samples.positions[k], positions)
        assert np.array_equal(samples.frames[k], frames)


def wanting(*times):
    samples = Samples(len(times), 6)
    samples.want(np.array(times))
    return samples
