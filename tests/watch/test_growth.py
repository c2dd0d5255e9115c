"""A growing bend is resolved, or the run stops or warns, whatever makes the chain unstable."""

import math
import re
import warnings

import numpy as np
import pytest
from scipy.sparse.linalg import ArpackError, ArpackNoConvergence

import nrchain
from nrchain.motion.charts import ChartedChain
from nrchain.motion.model import Model
from nrchain.outcome import Cause
from nrchain.planning.checked_start import starting_poses
from nrchain.watch import growing_modes, growth
from nrchain.watch.growing_modes import growth_about_base

X = np.array([1.0, 0.0, 0.0])
OBLIQUE = np.array([[0.6, 0.64, 0.48], [-0.8, 0.48, 0.36], [0.0, -0.6, 0.8]])
"""A rotation by which motion along the chain has components along x, y and z."""

COLUMN = {
    "elasticity.ratio": 1e12,
    "field.force": [300.0, 0.0, 0.0],
    "start.shape": "sine",
    "run.end": 1.4,
}


def passive(**changes):
    return nrchain.load_scene("passive", **{"run.snapshots": 3} | changes)


def compressed(scene, bend):
    """Positions of a clamped chain compressed by 3 %, with a bend of ``bend`` radii."""
    places = np.arange(scene.chain.particles)
    positions = 0.97 * scene.chain.spacing * places[:, None] * X
    positions[:, 2] = bend * scene.chain.radius * np.sin(np.pi * places / places[-1])
    return positions


def obliquely_compressed(scene, bend):
    """The same chain with all compression in its middle link, along no axis of the lab."""
    positions, frames = compressed(scene, bend), starting_poses(scene)[1]
    places, whole = np.arange(len(positions)), scene.chain.spacing
    far = positions[-1, 0] - whole * places[::-1]
    positions[:, 0] = np.where(places < len(places) // 2, whole * places, far)
    return {"positions": positions @ OBLIQUE, "frames": frames @ OBLIQUE}


def squeezed(**changes):
    changes = {"chain.particles": 10, "elasticity.ratio": 1e9, "run.end": 5.0} | changes
    return passive(**{"start.shape": "straight"} | changes)


def largest_offset(trajectory):
    """The largest distance of a sphere from the line through the ends, at the end of the run."""
    offsets = trajectory.positions[-1] - trajectory.positions[-1, 0]
    axis = offsets[-1] / np.linalg.norm(offsets[-1])
    return float(np.linalg.norm(offsets - np.outer(offsets @ axis, axis), axis=1).max())


def advised(trajectory):
    """The tolerances that the reason of a stop recommends."""
    assert trajectory.cause is Cause.GROWTH
    remedy = r"rtol = [^;]*\); (.*) or finer, or a larger bend at the start resolves it"
    text = re.search(remedy, trajectory.reason)[1]
    return {key: float(value) for key, value in re.findall(r"(run\.[ar]tol) = (\S+)", text)}


def test_a_compressed_chain_stops_below_atol_and_buckles_with_the_tolerance_named():
    scene = squeezed()
    start = compressed(scene, 1e-10)
    changes = advised(nrchain.simulate(scene, positions=start))
    assert list(changes) == ["run.atol"]
    found = nrchain.simulate(squeezed(**changes), positions=start)
    for rtol in (1e-10, 1e-11, 1e-12):
        # the bend is a thousand times atol: no rtol hides it, and none is refused
        fine = {"run.atol": 1e-13, "run.rtol": rtol, "run.integrator": "radau"}
        truth = nrchain.simulate(squeezed(**fine), positions=start)
        assert truth.status == "completed"
        assert largest_offset(truth) > 1.0
        assert largest_offset(found) == pytest.approx(largest_offset(truth), rel=0.01)


@pytest.mark.parametrize("integrator", ["cvode", "radau"])
def test_a_bend_hidden_by_motion_along_the_chain_is_resolved_by_the_rtol_named(integrator):
    """The bend, 1e-8 a, is 1e5 atol. Spheres move by a: rtol = 1e-5 allows errors of 1e-5 a."""
    coarse = {"run.atol": 1e-13, "run.rtol": 1e-5, "run.integrator": integrator}
    scene = squeezed(**coarse)
    start = obliquely_compressed(scene, 1e-8)
    changes = advised(nrchain.simulate(scene, **start))
    assert list(changes) == ["run.rtol"]
    found = nrchain.simulate(squeezed(**coarse | changes), **start)
    assert found.status == "completed"
    upright = start["positions"] @ OBLIQUE.T
    truth = nrchain.simulate(squeezed(**coarse | {"run.rtol": 1e-10}), positions=upright)
    assert largest_offset(truth) > 1.0
    assert largest_offset(found) == pytest.approx(largest_offset(truth), rel=0.01)


@pytest.mark.parametrize("dense", [True, False])
@pytest.mark.parametrize(("integrator", "tolerance"), [("cvode", 2e-6), ("radau", 1e-6)])
def test_a_run_whose_steps_are_longer_than_a_growth_time_stops(
    monkeypatch, integrator, tolerance, dense
):
    """The column buckles at rate 143. Most of the sine is in modes that grow more slowly."""
    if not dense:
        monkeypatch.setattr(growing_modes, "DENSE", 0)
    changes = COLUMN | {"start.amplitude": 1e-5, "run.integrator": integrator}
    changes |= {"run.rtol": tolerance, "run.atol": tolerance}
    with pytest.warns(nrchain.SceneWarning, match=r"bends grow by up to e\^200"):
        stopped = nrchain.simulate(passive(**changes))
    assert 0.0 < stopped.time[-1] < 0.1 * COLUMN["run.end"]
    assert "rate 143" in stopped.reason
    for _ in range(3):
        # the finer run stops earlier, where the mode is smaller, or resolves it
        finer = nrchain.simulate(passive(**changes | advised(stopped)))
        if finer.status == "completed":
            break
        assert finer.time[-1] < stopped.time[-1]
        stopped = finer
    found = finer
    # a run at tolerances of 1e-12 gives 5.405
    assert largest_offset(found) == pytest.approx(5.405, rel=0.01)


@pytest.mark.parametrize("amplitude", [0.0, 1e-9, 1e-3])
def test_a_bend_that_decays_gives_no_warning(amplitude):
    scene = passive(**{"start.shape": "sine", "start.amplitude": amplitude, "slip.2s": -100.0})
    with warnings.catch_warnings(action="error", category=nrchain.SceneWarning):
        trajectory = nrchain.simulate(scene)
    assert trajectory.status == "completed"
    assert largest_offset(trajectory) < max(amplitude, 1e-15)


@pytest.mark.parametrize("integrator", ["cvode", "radau"])
def test_the_size_of_the_bend_of_a_bent_chain_is_computed_every_eighth_step(
    integrator, monkeypatch
):
    """Compiled steps do it themselves, and come back at most where a signal is looked for."""
    looks, bend = [], growth.bend_of
    monkeypatch.setattr(growth, "bend_of", lambda *given: looks.append(bend(*given)) or looks[-1])
    bent = {"start.shape": "sine", "start.amplitude": 10.0, "run.rtol": 1e-9, "run.atol": 1e-9}
    run = nrchain.simulate(passive(**bent, **{"run.integrator": integrator}))
    every_eighth = math.ceil(run.counters["steps"] / growth.BENT)
    assert min(map(max, looks)) >= growth.LARGEST
    assert every_eighth > 10
    assert len(looks) == every_eighth if integrator == "cvode" else len(looks) < every_eighth


def test_a_bend_that_is_large_needs_no_look_at_any_tolerance(monkeypatch):
    """Also one of fewer than ten thousand tolerances."""
    looks, bend = [], growth.bend_of
    monkeypatch.setattr(growth, "bend_of", lambda *given: looks.append(bend(*given)) or looks[-1])
    tolerance = {"run.rtol": 1e-3, "run.atol": 1e-3, "run.integrator": "cvode", "run.max_steps": 24}
    run = nrchain.simulate(passive(**{"start.shape": "sine", "start.amplitude": 0.1}, **tolerance))
    assert growth.LARGEST < max(looks[-1]) < growth.NEARLY * 1e-3
    assert len(looks) == math.ceil(run.counters["steps"] / growth.BENT)


def test_a_straight_unstable_chain_stays_straight_and_warns_once():
    scene = squeezed()
    with pytest.warns(nrchain.SceneWarning, match="straight to rounding at t = ") as warned:
        trajectory = nrchain.simulate(scene, positions=compressed(scene, 0.0))
    assert len(warned) == 1
    assert trajectory.status == "completed"
    assert largest_offset(trajectory) == 0.0


def found_both_ways(monkeypatch, chain, least, fast):
    """Growing modes from all eigenvalues, and from those near the given rates."""
    monkeypatch.setattr(growing_modes, "DENSE", 10**6)
    every = growth_about_base(chain, X, least, fast)
    monkeypatch.setattr(growing_modes, "DENSE", 0)
    return every, growth_about_base(chain, X, least, fast)


@pytest.mark.parametrize("slip", [{}, {"slip.2s": 40.0, "slip.3t": 400.0}, {"slip.4a": 5e3}])
def test_iterative_and_dense_eigenvalues_of_long_chains_agree(monkeypatch, slip):
    """Two independent methods: left eigenvectors of J, and iterations of a shifted inverse."""
    scene = squeezed(**{"chain.particles": 20, "run.end": 0.01} | slip)
    start = compressed(scene, 1e-6)
    start[:, 1] = 1e-6 * np.linspace(0.0, 1.0, 20) ** 2 * np.linspace(1.0, 0.0, 20)
    poses = nrchain.simulate(scene, positions=start)
    chain = ChartedChain(Model(scene))
    chain.rebase(0.0, poses.positions[-1], poses.frames[-1])
    every, near = found_both_ways(monkeypatch, chain, 0.2, 2.0)
    assert every.rates.max() > 1.0
    for rate, part in zip(every.rates, every.parts, strict=True):
        if rate < 0.5 * every.rates.max():
            continue
        nearest = int(np.argmin(np.abs(near.rates - rate)))
        assert near.rates[nearest] == pytest.approx(rate, rel=1e-4)
        np.testing.assert_allclose(near.parts[nearest], part, atol=1e-3 * part.max())


@pytest.mark.parametrize("ends", ["free", "clamped"])
@pytest.mark.parametrize("slip", [{}, {"slip.2s": 40.0, "slip.3t": 400.0}, {"slip.4a": 5e3}])
def test_nothing_grows_beyond_the_bound(slip, ends):
    """All eigenvalues are below it, and without slip it is the first power of two above them."""
    scene = squeezed(**{"chain.ends": ends} | slip)
    start = compressed(scene, 1e-3)
    chain = ChartedChain(Model(scene))
    chain.rebase(0.0, start, np.tile(np.eye(3), (len(start), 1, 1)))
    chain.linearise(0.0, np.zeros(chain.dimension))
    most = np.linalg.eigvals(chain.jacobian()).real.max()
    assert most > 1.0
    bound = growing_modes._bound(chain, 2.0**-10, 2.0**20)
    assert most <= bound < 2.0**20
    if not slip:
        assert bound == 2.0 ** np.ceil(np.log2(most))
    assert growing_modes._bound(chain, 2.0**-10, 0.25 * most) == math.inf


@pytest.mark.parametrize("dense", [10**6, 0])
def test_the_fastest_mode_becomes_the_whole_bend(monkeypatch, dense):
    """A mode of 2e-12 a at rate 67 is 2e-4 of the bend at t = 0 and nearly all at t = 0.25."""
    monkeypatch.setattr(growing_modes, "DENSE", dense)
    fine = {"run.atol": 1e-13, "run.rtol": 1e-9, "run.end": 0.25, "run.snapshots": 26}
    scene = squeezed(**fine)
    poses = nrchain.simulate(scene, positions=compressed(scene, 1e-10))
    chain = ChartedChain(Model(scene))

    def leading(frame):
        chain.rebase(0.0, poses.positions[frame], poses.frames[frame])
        found = growth_about_base(chain, X, 20.0, 70.0)
        first = int(np.argmax(found.rates))
        return found.rates[first], found.parts[first].reshape(-1, 6)[:, 2]

    rate, part = leading(-1)
    np.testing.assert_allclose(part, np.abs(poses.positions[-1, chain.order, 2]), rtol=1e-3)
    before = leading(-11)[1].max()
    assert math.log(part.max() / before) == pytest.approx(0.1 * rate, rel=1e-3)


@pytest.mark.parametrize(
    "failure",
    [
        ArpackNoConvergence("no convergence: %s", np.empty(0), np.empty((48, 0))),
        ArpackError(-9),
        FloatingPointError("the Newton matrix is singular"),
    ],
)
def test_a_run_goes_on_where_the_eigenvalues_do_not_converge(monkeypatch, failure):
    def fail(*_, **__):
        raise failure

    monkeypatch.setattr(growing_modes, "DENSE", 0)
    monkeypatch.setattr("scipy.sparse.linalg.eigs", fail)
    scene = squeezed(**{"run.end": 1e-3})
    found = nrchain.simulate(scene, positions=compressed(scene, 1e-10))
    assert found.status == "completed"


def test_growth_that_lasts_only_while_links_relax_gives_no_warning():
    """Two spheres 5e-4 d too far apart: steps overshoot and compress the link for t = 1e-11."""
    changes = {"chain.particles": 2, "elasticity.ratio": 1e7, "start.shape": "straight"}
    scene = nrchain.load_scene("passive", **{"chain.ends": "free", "run.end": 50.0} | changes)
    positions = np.array([[0.0, 0.0, 0.0], [10.005, 0.0, 0.0]])
    with warnings.catch_warnings(action="error", category=nrchain.SceneWarning):
        assert nrchain.simulate(scene, positions=positions).status == "completed"
