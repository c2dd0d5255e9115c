"""What every integrator owes: the trajectory to its tolerance, its counts, the same bits again."""

from functools import cache
from itertools import product
from typing import get_args

import numpy as np
import pytest
from support.selection import few_of
from support.stepping import (
    Probe,
    distances,
    folded,
    integrate,
    periodic,
    poses_at,
    prepare,
    small,
    tumbling,
)

from nrchain.errors import SceneError
from nrchain.motion.chart_poses import TURN_LIMIT
from nrchain.motion.integrators import INTEGRATORS, find_integrator
from nrchain.motion.integrators.base import IntegrationError, Integrator
from nrchain.motion.integrators.linear import BandedJacobian
from nrchain.scene import chain_sections
from nrchain.scene.poses import initial_poses

NAMES = list(INTEGRATORS)
OTHERS = [name for name in NAMES if name != "cvode"]
SINE = {"start.shape": "sine", "start.amplitude": 2.0}

SCENES = {
    "buckling": lambda: small("buckling", 8, 300.0, **{"slip.2s": 600.0}, **SINE),
    "helix": lambda: small("helix-left", 10, 100.0, **SINE),
    "wave": lambda: small("wave", 8, 20.0),
    "spiral": lambda: small("spiral-left", 8, 4.0),
    "periodic": periodic,
    "all pairs": lambda: small("spiral-left", 10, 2.0, **{"slip.neighbours": "all"}),
    "tumbling": lambda: tumbling(end=2.0),
    "folded": lambda: folded(end=1.0),
    "friction": lambda: small(
        "spiral-left", 8, 2.0, **{"friction": {"kind": "pairwise", "neighbours": 2}}
    ),
}


@cache
def reference(scene: str):
    """A scene, five times of it, and its poses there by CVODE far below all tolerances used."""
    setup = SCENES[scene]()
    times = np.linspace(0.0, setup.run.end, 6)[1:]
    return setup, times, integrate(setup, "cvode", 1e-12, times)


@pytest.mark.parametrize(
    ("scene", "name"),
    few_of(
        product(SCENES, OTHERS),
        {*product(SCENES, ["radau"]), *product(["tumbling", "periodic"], OTHERS)},
    ),
)
def test_agrees_with_cvode(scene, name):
    setup, times, expected = reference(scene)
    path = integrate(setup, name, 1e-9, times)
    start = initial_poses(setup)[0]
    assert np.abs(expected.positions[-1] - start).max() > 0.2
    assert max(distances(path, expected)) < 2e-7


@pytest.mark.parametrize(("name", "share"), [("cvode", 500), ("radau", 10), ("scipy-bdf", 500)])
@pytest.mark.parametrize("scene", ["buckling", "wave", "tumbling"])
def test_error_falls_with_the_tolerance(scene, name, share):
    """The errors of many steps add up to ``share`` tolerances at most."""
    setup, times, expected = reference(scene)
    tolerances = np.array([1e-4, 1e-6, 1e-8])
    errors = np.array(
        [max(distances(integrate(setup, name, tol, times), expected)) for tol in tolerances]
    )
    assert (errors < share * tolerances).all()
    assert errors[2] < 0.05 * errors[0]


@pytest.mark.parametrize("name", NAMES)
def test_stiffness_does_not_cost_steps(name):
    scene = small("buckling", 8, 300.0, **{"elasticity.ratio": 1e12})
    times = [100.0, 300.0]
    path = integrate(scene, name, 1e-6, times)
    # the fastest mode decays 1e9 times within the run
    path.chain.linearise(300.0, path.integrator.at(300.0))
    fastest = -np.linalg.eigvals(path.chain.jacobian()).real.min()
    assert fastest * 300.0 > 1e6
    assert path.integrator.steps < 1000
    assert max(distances(path, integrate(scene, "cvode", 1e-11, times))) < 2e-5


@pytest.mark.parametrize("name", NAMES)
def test_counters_count(name):
    """A term in Python is asked for a twist at every right-hand side and every Jacobian."""
    scene = small("wave", 5, 10.0)
    probe = Probe(scene)
    chain, integrator = prepare(scene, name, 1e-6, probe)
    for _ in range(10):
        integrator.step()
    assert integrator.steps == 10
    assert chain.evaluations + chain.jacobians == probe.calls > 10
    assert chain.jacobians == probe.derivatives >= 1
    assert integrator.solves >= 10


@pytest.mark.parametrize("name", NAMES)
def test_interpolates_within_the_last_step(name):
    chain, integrator = prepare(tumbling(), name, 1e-6)
    reached = integrator.step()
    for _ in range(12):
        began, before = reached, poses_at(chain, integrator, reached)
        reached = integrator.step()
        times = began + np.array([0.0, 0.25, 0.5, 0.75, 1.0]) * (reached - began)
        after = [poses_at(chain, integrator, time) for time in times]
        for kind in (0, 1):
            assert after[0][kind] == pytest.approx(before[kind], abs=1e-12)
        curve = np.array([positions for positions, _ in after])
        # as smooth as the path: no more than the tolerance off a cubic
        assert np.abs(np.diff(curve, n=4, axis=0)).max() < 1e-4


@pytest.mark.parametrize("name", NAMES)
def test_repeats_itself_bit_for_bit_after_a_restart(name):
    scene = tumbling()
    chain, integrator = prepare(scene, name, 1e-6)
    for _ in range(15):
        reached = integrator.step()
    chain.rebase(reached, *poses_at(chain, integrator, reached))
    base = chain.base_positions.copy(), chain.base_frames.copy(), chain.drift.copy(), chain.spin
    still = np.zeros(chain.dimension)
    integrator.start(reached, still)

    again_chain, again = prepare(scene, name, 1e-6)
    again_chain.set_base(reached, *base)
    again.start(reached, still)
    for _ in range(15):
        reached = integrator.step()
        assert again.step() == reached
        for mine, yours in zip(
            poses_at(chain, integrator, reached),
            poses_at(again_chain, again, reached),
            strict=True,
        ):
            assert np.array_equal(mine, yours)


@pytest.mark.parametrize("name", OTHERS)
def test_steps_do_not_depend_on_where_the_run_ends(name):
    reached = []
    for end in (10.0, 1000.0):
        _, integrator = prepare(small("wave", 5, end), name, 1e-6)
        reached.append([integrator.step() for _ in range(60)])
    early, late = reached
    assert early == late


@pytest.mark.parametrize("name", NAMES)
def test_frames_stay_orthonormal_over_thousands_of_steps(name):
    chain, integrator = prepare(tumbling(), name, 1e-7)
    for _ in range(2000):
        reached = integrator.step()
        positions, frames = poses_at(chain, integrator, reached)
        if chain.largest_turn(integrator.at(reached)) > TURN_LIMIT:
            chain.rebase(reached, positions, frames)
            integrator.start(reached, np.zeros(chain.dimension))
    gram = np.einsum("nak,nbk->nab", frames, frames)
    assert np.abs(gram - np.eye(3)).max() < 1e-13


@pytest.mark.parametrize(("name", "share"), [("cvode", 300.0), ("radau", 0.1), ("scipy-bdf", 3.0)])
def test_centre_of_mass_of_a_passive_chain(name, share):
    """Kept to the tolerance, not to rounding: it is not a linear function of the coordinates."""
    scene = small("passive", 6, 100.0, **{"chain.ends": "free", "start.amplitude": 1.0})
    centre = initial_poses(scene)[0].mean(axis=0)
    for tolerance in (1e-5, 1e-8):
        path = integrate(scene, name, tolerance, [30.0, 60.0, 100.0])
        assert np.abs(path.positions.mean(axis=1) - centre).max() < share * tolerance


@pytest.mark.parametrize("name", NAMES)
def test_velocities_that_are_not_finite_are_refused(name):
    scene = small("wave", 5, 10.0)
    probe = Probe(scene)
    _, integrator = prepare(scene, name, 1e-6, probe)
    integrator.step()
    probe.twist = lambda positions: np.nan
    with pytest.raises(IntegrationError, match="not finite"):
        integrator.step()


@pytest.mark.parametrize("name", NAMES)
def test_a_chain_at_rest_stays(name):
    scene = small("passive", 4, 1e3, **{"start.shape": "straight", "chain.ends": "free"})
    path = integrate(scene, name, 1e-8, [500.0, 1e3])
    assert path.positions[-1] == pytest.approx(initial_poses(scene)[0], abs=1e-9)
    assert path.integrator.steps < 100


@pytest.mark.parametrize("name", NAMES)
def test_registry(name):
    cls = find_integrator(name)
    assert issubclass(cls, Integrator)
    assert cls.name == name
    assert cls.order == 5


def test_unknown_integrator():
    with pytest.raises(SceneError, match=r"run.integrator = 'radua'.*cvode.*'radau'") as error:
        find_integrator("radua")
    assert error.value.key == "run.integrator"


@pytest.mark.parametrize("name", OTHERS)
def test_where_all_spheres_act_on_all_the_jacobian_is_never_built(name, monkeypatch):
    far = {"slip.neighbours": "all", "friction": "pairwise"}
    scene = small("buckling", 8, 20.0, **far)
    exact = integrate(scene, "cvode", 1e-10, [10.0, 20.0])
    monkeypatch.setattr(BandedJacobian, "matrix", None)
    path = integrate(scene, name, 1e-7, [10.0, 20.0])
    assert path.positions == pytest.approx(exact.positions, abs=1e-5)


def test_scenes_take_every_integrator_by_name():
    assert set(get_args(chain_sections.Integrator)) == {"auto", *INTEGRATORS}
