"""What grows is followed, or the run says that it is not, whatever makes the chain unstable."""

import re
import warnings

import numpy as np
import pytest
from scipy.sparse.linalg import ArpackError, ArpackNoConvergence

import nrchain
from nrchain import growing_modes
from nrchain.charts import ChartedChain
from nrchain.growing_modes import growth_about_base
from nrchain.model import Model
from nrchain.outcome import Cause
from nrchain.start import starting_poses

X = np.array([1.0, 0.0, 0.0])
COLUMN = {
    "elasticity.ratio": 1e12,
    "field.force": [300.0, 0.0, 0.0],
    "start.shape": "sine",
    "run.end": 1.4,
}


def passive(**changes):
    return nrchain.load_scene("passive", **{"run.snapshots": 3} | changes)


def compressed(scene, bend):
    """A clamped chain 3 % too short for its links, bent by so many radii."""
    places = np.arange(scene.chain.particles)
    positions = 0.97 * scene.chain.spacing * places[:, None] * X
    positions[:, 2] = bend * np.sin(np.pi * places / places[-1])
    return positions


def squeezed(**changes):
    changes = {"chain.particles": 10, "elasticity.ratio": 1e9, "run.end": 5.0} | changes
    return passive(**{"start.shape": "straight"} | changes)


def largest_offset(trajectory):
    return float(np.abs(trajectory.positions[-1, :, 1:]).max())


def advised(trajectory):
    assert trajectory.cause is Cause.GROWTH
    return float(re.search(r"run.atol = (\S+), or a larger start", trajectory.reason)[1])


def test_a_compressed_chain_is_not_left_straight_and_the_tolerance_named_follows_it():
    scene = squeezed()
    start = compressed(scene, 1e-10)
    atol = advised(nrchain.simulate(scene, positions=start))
    found = nrchain.simulate(squeezed(**{"run.atol": atol}), positions=start)
    fine = {"run.atol": 1e-13, "run.rtol": 1e-12, "run.integrator": "radau"}
    truth = nrchain.simulate(squeezed(**fine), positions=start)
    assert largest_offset(truth) > 1.0
    assert largest_offset(found) == pytest.approx(largest_offset(truth), rel=0.01)


@pytest.mark.parametrize("integrator", ["cvode", "radau"])
def test_steps_that_pass_over_a_growth_end_the_run(integrator):
    """The load bends a column at rate 143, and most of a sine is in modes that grow slower."""
    changes = COLUMN | {"start.amplitude": 1e-5, "run.integrator": integrator}
    stopped = nrchain.simulate(passive(**changes))
    assert 0.0 < stopped.time[-1] < 0.1
    assert "rate 143" in stopped.reason
    found = nrchain.simulate(passive(**changes, **{"run.atol": advised(stopped)}))
    # a run at tolerances of 1e-12 gives 5.405
    assert largest_offset(found) == pytest.approx(5.405, rel=0.01)


@pytest.mark.parametrize("amplitude", [0.0, 1e-9, 1e-3])
def test_a_chain_that_decays_completes_and_warns_of_nothing(amplitude):
    scene = passive(**{"start.shape": "sine", "start.amplitude": amplitude, "slip.2s": -100.0})
    with warnings.catch_warnings(action="error", category=nrchain.SceneWarning):
        trajectory = nrchain.simulate(scene)
    assert trajectory.status == "completed"
    assert largest_offset(trajectory) < max(amplitude, 1e-15)


def test_an_unstable_chain_that_is_straight_stays_so_and_says_it_once():
    scene = squeezed()
    with pytest.warns(nrchain.SceneWarning, match="straight to rounding at t = ") as told:
        trajectory = nrchain.simulate(scene, positions=compressed(scene, 0.0))
    assert len(told) == 1
    assert trajectory.status == "completed"
    assert largest_offset(trajectory) == 0.0


def test_long_chains_have_the_rates_of_all_eigenvalues(monkeypatch):
    scene = squeezed(**{"chain.particles": 20})
    chain = ChartedChain(Model(scene))
    chain.rebase(0.0, compressed(scene, 1e-10), starting_poses(scene)[1])
    every = growth_about_base(chain, X, 0.2, 2.0, 1e-10).rates
    monkeypatch.setattr(growing_modes, "DENSE", 0)
    nearest = growth_about_base(chain, X, 0.2, 2.0, 1e-10).rates
    assert every.max() > 1.0
    assert nearest.max() == pytest.approx(every.max(), rel=1e-3)


@pytest.mark.parametrize(
    "failure",
    [
        ArpackNoConvergence("no convergence: %s", np.empty(0), np.empty((48, 0))),
        ArpackError(-9),
        FloatingPointError("the Newton matrix is singular"),
    ],
)
def test_rates_that_are_not_found_leave_the_run_as_it_is(monkeypatch, failure):
    def fail(*_, **__):
        raise failure

    monkeypatch.setattr(growing_modes, "DENSE", 0)
    monkeypatch.setattr("scipy.sparse.linalg.eigs", fail)
    scene = squeezed(**{"run.end": 1e-3})
    found = nrchain.simulate(scene, positions=compressed(scene, 1e-10))
    assert found.status == "completed"
