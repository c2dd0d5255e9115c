"""effects = "auto" keeps its tolerance, says what it left out, and stops when that grows."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import nrchain
from nrchain.accuracy.timing import distance
from nrchain.errors import SceneError, TrajectoryError
from nrchain.outcome import Cause
from nrchain.planning.auto import _subsets, candidate_sets, choose, full_scene
from nrchain.planning.checked_start import starting_poses
from nrchain.planning.choice import BREACH, WINDOW, Choice
from nrchain.planning.counted_work import evaluation_work
from nrchain.planning.description import describe
from nrchain.planning.estimate import estimate_effects
from nrchain.planning.hydrodynamic_set import HydrodynamicSet
from nrchain.planning.probe import CLOSE, MARGIN, _left_out, extrapolate, run_probe
from nrchain.scene.scene import Scene

QUIET = {"run.end": 4.0, "run.snapshots": 81, "effects": "auto", "tolerance": 0.02}


@pytest.fixture(scope="module")
def quiet():
    """A passive clamped chain that straightens: friction between spheres matters little."""
    return nrchain.load_scene("passive", **QUIET)


def test_the_keys_survive_a_file_and_are_checked(quiet):
    assert Scene.from_toml(quiet.to_toml()) == quiet
    with pytest.raises(SceneError, match="tolerance"):
        nrchain.load_scene(quiet, tolerance=None)
    with pytest.raises(SceneError, match="effects"):
        nrchain.load_scene(quiet, effects="named")
    for taken in ({"slip.neighbours": 2}, {"slip.finite_size": True}, {"friction": "pairwise"}):
        with pytest.raises(SceneError, match="set by effects"):
            nrchain.load_scene(quiet, **taken)


def test_auto_keeps_its_tolerance_and_says_what_it_leaves_out(quiet, tmp_path):
    trajectory = nrchain.simulate(quiet, output=tmp_path / "auto.h5")
    choice = trajectory.choice
    assert choice.left_out == ("friction between spheres",)
    assert trajectory.scene.friction.kind == "one-body"
    assert trajectory.scene.effects == "named"
    full = nrchain.simulate(full_scene(quiet))
    found = max(distance(trajectory, full))
    assert found <= quiet.tolerance
    assert choice.bound == pytest.approx(found, rel=0.2)
    assert nrchain.Trajectory.open(tmp_path / "auto.h5").choice == choice


def test_a_tolerance_too_small_for_less_gives_the_full_model(quiet):
    scene, choice = choose(nrchain.load_scene(quiet, tolerance=1e-4))
    assert scene == full_scene(quiet)
    assert choice.left_out == ()
    told = choice.lines()[0]
    assert "full model" in told
    assert "every cheaper set is 0.0001 radii or radians off, or more, by t = " in told


def test_a_set_tried_costs_clearly_less_than_any_fuller_one():
    full = full_scene(nrchain.load_scene("buckling", **{"chain.particles": 300}))
    sets = candidate_sets(full)
    costs = [evaluation_work(full, one) for one in sets]
    assert len(sets) > 3
    assert costs == sorted(costs)
    assert all(
        a >= 1.5 * b
        for one, a in zip(sets, costs, strict=True)
        for other, b in zip(sets, costs, strict=True)
        if one != other and one.contains(other) and other != sets[0]
    )
    assert all(HydrodynamicSet.of_scene(one.apply_to(full)) == one for one in sets)


def test_a_run_stops_when_what_is_left_out_grows(quiet):
    scene, choice = choose(quiet)
    small = replace(choice, tolerance=1e-9, velocities=tuple(np.zeros(len(choice.times))))
    stopped = nrchain.simulate(scene, choice=small)
    assert stopped.cause is Cause.NEGLECTED
    assert stopped.status == "stopped"
    assert "left out" in stopped.reason
    assert "friction.kind = 'pairwise' includes them" in stopped.reason


def test_a_run_whose_bound_broke_goes_on_only_unwatched_and_says_so(quiet, tmp_path):
    scene, choice = choose(quiet)
    small = replace(choice, tolerance=1e-9, velocities=tuple(np.zeros(len(choice.times))))
    path = tmp_path / "auto.h5"
    stopped = nrchain.simulate(scene, choice=small, output=path)
    with pytest.raises(TrajectoryError, match=r"'pairwise' .* unwatched"):
        nrchain.resume(path)
    done = nrchain.resume(path, unwatched=True)
    assert done.status == "completed"
    assert done.choice.watched_until == stopped.time[-1]
    assert f"not watched from t = {stopped.time[-1]:.4g}" in done.choice.lines()[-1]
    assert np.array_equal(done.positions, nrchain.simulate(scene).positions)


def test_a_run_that_goes_on_keeps_its_choice(quiet, tmp_path):
    short = nrchain.load_scene(quiet, **{"run.max_steps": 10})
    begun = nrchain.simulate(short, output=tmp_path / "auto.h5")
    assert begun.cause is Cause.BUDGET
    assert nrchain.resume(tmp_path / "auto.h5").choice == begun.choice
    assert begun.choice.left_out


def test_a_choice_is_read_from_the_text_it_writes():
    choice = Choice(0.1, (), 0.0, 0.0, (), (), "no reason")
    assert Choice.from_json(choice.to_json()) == choice


def cut_short(scene):
    """Choices by probes that end before the run does, at two tolerances."""
    for tolerance in (2e-2, 1e-2, 5e-3, 2e-3, 1e-3):
        for budget in 0.02 / 2.0 ** np.arange(6):
            choice = choose(nrchain.load_scene(scene, tolerance=tolerance), budget=budget)[1]
            if 0.0 < choice.probed < scene.run.end:
                yield choice


def test_a_choice_states_the_keys_that_it_sets_and_the_time_of_its_probe(quiet):
    stated = nrchain.load_scene(quiet, friction="one-body", **{"slip.neighbours": 1})
    _, choice = choose(nrchain.load_scene(stated, tolerance=1e-4))
    assert (
        choice.lines()[-1]
        == "keys that the choice sets: friction.kind from 'one-body' to 'pairwise'"
    )
    _, choice = choose(quiet)
    assert choice.sets == ()
    assert f"(to t = {quiet.run.end:g})" in choice.lines()[-1]
    early = next(choice for choice in cut_short(quiet) if choice.left_out)
    assert "an estimate beyond t =" in early.lines()[-1]


def test_a_probe_that_sees_nothing_leaves_nothing_out(quiet):
    scene, choice = choose(quiet, budget=0.0)
    assert scene == full_scene(quiet)
    assert not choice.left_out


def test_a_net_force_on_a_periodic_chain_leaves_out_the_friction_it_cannot_have():
    pulled = {"chain.ends": "periodic", "field.force": [0.0, 0.0, -1.0], "slip.2s": 20.0}
    scene = nrchain.load_scene("passive", **QUIET, **pulled)
    full = full_scene(scene)
    assert full.friction.kind == "one-body"
    assert full.slip.neighbours == "all"
    assert all(one.friction == 0.0 for one in candidate_sets(full))
    chosen, choice = choose(scene)
    assert chosen.friction.kind == "one-body"
    assert "no part of it: field" in choice.lines()[0]
    bare = nrchain.load_scene(scene, **{"slip.2s": None})
    assert candidate_sets(full_scene(bare)) == []
    assert choose(bare)[1].left_out == ()


def test_the_full_model_has_the_disturbance_of_a_flow_by_all_spheres():
    sheared = {"flow.gradient": [[0.0, 0.01, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]}
    scene = nrchain.load_scene("passive", **QUIET, **sheared)
    full = full_scene(scene)
    assert (full.flow.neighbours, full.flow.finite_size) == ("all", True)
    assert full.slip == scene.slip  # no mode has a strength
    near = candidate_sets(nrchain.load_scene(full, **{"chain.particles": 300}))
    assert min(one.strain for one in near) < 300
    assert all(one.slip == 0.0 for one in near)
    assert evaluation_work(full) > evaluation_work(full, near[0])
    described = describe(scene)
    assert not described.without_effect
    assert not described.warnings  # a passive chain has no slip to warn of


def test_a_set_cuts_all_flows_alike_and_names_what_it_leaves_out():
    sheared = {"flow.gradient": [[0.0, 0.01, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]}
    full = full_scene(nrchain.load_scene("passive", **QUIET, **sheared, **{"slip.2s": 1.0}))
    sets = _subsets(full)
    assert HydrodynamicSet.of_scene(full) not in sets
    assert all(HydrodynamicSet.of_scene(one.apply_to(full)) == one for one in sets)
    assert all(one.slip == one.strain for one in sets)
    chosen = HydrodynamicSet(0.0, 2.0, 2.0, False).apply_to(full)
    assert list(_left_out(full, chosen)) == [
        "slip beyond 2 neighbours a side",
        "strain beyond 2 neighbours a side",
        "finite size",
        "finite size of strain",
        "friction between spheres",
    ]


def test_the_cost_of_a_disturbed_flow_grows_with_its_reach_and_its_finite_size():
    sheared = {"flow.gradient": [[0.0, 0.01, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]}
    full = full_scene(nrchain.load_scene("passive", **QUIET, **sheared, **{"slip.2s": 1.0}))
    whole = HydrodynamicSet.of_scene(full)
    costs = [
        evaluation_work(full, whole._replace(**changes))
        for changes in ({"strain": 0.0}, {"strain": 2.0}, {"strain": 12.0}, {})
    ]
    assert costs == sorted(costs)
    assert len(set(costs)) == len(costs)
    alone = nrchain.load_scene(full, **{"slip.2s": None})
    leading = nrchain.load_scene(alone, **{"flow.finite_size": False})
    assert evaluation_work(leading) < evaluation_work(alone) < evaluation_work(full)
    cut = nrchain.load_scene(leading, **{"slip.2s": 1.0, "slip.neighbours": 3})
    cut = nrchain.load_scene(cut, **{"flow.neighbours": 5, "slip.finite_size": False})
    assert HydrodynamicSet.of_scene(cut) == (math.inf, 3.0, 5.0, False)


@pytest.mark.parametrize(
    ("time", "velocity"), [(0.0, 8.0), (1.0, 6.0), (3.0, 7.0), (4.0, 3.0), (7.0, 7.0)]
)
def test_what_is_allowed_is_what_the_probe_found_about_that_time(time, velocity):
    """After the probe: the maximum of its second half, and at least tolerance over run time."""
    end, velocities = 8.0, (8.0, 6.0, 1.0, 7.0, 3.0)
    choice = Choice(0.1, ("friction",), 0.05, 4.0, tuple(np.arange(5.0)), velocities, "")
    assert WINDOW * end < 1.0
    assert choice.allowed(time, end) == pytest.approx(BREACH * velocity)
    assert replace(choice, tolerance=100.0).allowed(time, end) == pytest.approx(BREACH * 12.5)


def test_a_difference_is_carried_on_by_its_own_law():
    times = np.linspace(0.0, 10.0, 41)
    growing = 1e-3 * np.exp(0.5 * times)
    assert extrapolate(times, growing, 20.0) == pytest.approx(1e-3 * math.exp(10.0))
    assert extrapolate(times, 0.3 * times, 20.0) == pytest.approx(6.0)
    assert extrapolate(times, np.exp(-times), 20.0) == math.exp(-10.0)
    assert extrapolate(times, 0.3 * np.sqrt(times), 40.0) == pytest.approx(0.3 * math.sqrt(40.0))
    assert extrapolate(times, 0.3 * times**2, 20.0) == pytest.approx(2.0 * 0.3 * 10.0**2)


OWN_UNITS = {"chain.radius": 0.5, "chain.viscosity": 2.0, "chain.spacing": 7.0}
TIGHT = {"run.rtol": 1e-9, "run.atol": 1e-9}


def difference(scene, other, end, snapshots=2):
    """max |r − r′|/a, or max angle between frames, of two separate runs."""
    keys = TIGHT | {"run.end": end, "run.snapshots": snapshots}
    runs = [nrchain.simulate(nrchain.load_scene(one, **keys)) for one in (scene, other)]
    far = np.linalg.norm(runs[0].positions - runs[1].positions, axis=-1)
    cosine = (np.einsum("tnak,tnak->tn", runs[0].frames, runs[1].frames) - 1.0) / 2.0
    angle = np.arccos(np.clip(cosine, -1.0, 1.0))
    return max(far.max() / scene.chain.radius, angle.max())


@pytest.fixture(scope="module")
def small():
    """A passive clamped chain in other units, and its distance from the full model."""
    scene = nrchain.load_scene("passive", **QUIET, **OWN_UNITS)
    chosen, _ = choose(scene)
    assert chosen.friction.kind == "one-body"
    return scene, difference(chosen, full_scene(scene), scene.run.end, 2001)


def test_the_bound_is_the_distance_and_a_tenth_in_radii(small):
    scene, found = small
    _, choice = choose(scene)
    assert choice.bound == pytest.approx(1.1 * found, abs=2.0 * CLOSE * scene.tolerance)


@pytest.mark.parametrize(("allowed", "left_out"), [(1.05, False), (1.2, True)])
def test_what_comes_within_a_tenth_of_the_tolerance_is_not_left_out(small, allowed, left_out):
    scene, found = small
    _, choice = choose(nrchain.load_scene(scene, tolerance=allowed * found))
    assert bool(choice.left_out) == left_out


@pytest.fixture(scope="module")
def strays():
    """Two sets: the cheapest leaves the tolerance late, the costlier one stays within it."""
    keys = {"slip.2s": 10.0, "run.integrator": "cvode"}
    scene = nrchain.load_scene("passive", **QUIET, **OWN_UNITS, **keys)
    full, begin = full_scene(scene), starting_poses(scene)
    alone = [run_probe(1e3, full, [one], begin, 20.0).distances[1] for one in candidate_sets(full)]
    cheap, dear = (far[-1] for far in alone)
    tolerance = 1.05 * MARGIN * dear
    assert tolerance < 0.95 * MARGIN * cheap
    return nrchain.load_scene(scene, tolerance=tolerance), full, begin


def test_costlier_sets_are_followed_until_the_cheapest_is_well_within_tolerance(strays):
    scene, full, begin = strays
    chosen, choice = choose(scene)
    dear = candidate_sets(full)[1]
    assert choice.left_out == tuple(_left_out(full, dear.apply_to(full)))
    assert difference(chosen, full, scene.run.end) < scene.tolerance
    loose = run_probe(1e3, full, candidate_sets(full), begin, 20.0)
    assert loose.run.members == [0, 1]


def test_a_probe_ended_by_its_budget_has_compared_all_sets(strays):
    """Also where the cheapest set is no longer followed."""
    scene, full, begin = strays
    whole = run_probe(scene.tolerance, full, candidate_sets(full), begin, 20.0)
    assert whole.run.members == [0, 2]
    between = 0
    for part in np.linspace(0.6, 0.98, 12):
        probe = run_probe(scene.tolerance, full, candidate_sets(full), begin, part * whole.run.work)
        assert probe.reached[-1] == probe.run.time
        between += probe.run.members == [0, 2] and probe.run.time not in whole.reached
    assert between


def rotne_prager(scene, positions, forces, torques):
    """v and ω that forces and torques on the other spheres give each sphere, pair by pair."""
    a, eta = scene.chain.radius, scene.chain.viscosity
    velocities, spins = np.zeros_like(positions), np.zeros_like(positions)
    for i, j in itertools.permutations(range(len(positions)), 2):
        n = positions[i] - positions[j]
        r = np.linalg.norm(n)
        n = n / r
        f, t, ratio = forces[j], torques[j], (a / r) ** 2
        along = (1 + 2 / 3 * ratio) * f + (1 - 2 * ratio) * (n @ f) * n
        velocities[i] += along / (8 * math.pi * eta * r)
        velocities[i] += np.cross(t, n) / (8 * math.pi * eta * r**2)
        spins[i] += np.cross(f, n) / (8 * math.pi * eta * r**2)
        spins[i] += (3 * (n @ t) * n - t) / (16 * math.pi * eta * r**3)
    return velocities, spins


def test_neglected_velocities_are_those_of_rotne_and_prager_in_radii():
    """At the start, of a choice and of an estimate, with a, η and d other than 1 and 10."""
    keys = {"chain.ends": "free", "chain.particles": 20, "tolerance": 3.0, "run.end": 1.0}
    scene = nrchain.load_scene("passive", **(QUIET | keys | OWN_UNITS))
    positions, frames = starting_poses(scene)
    moduli = scene.moduli
    wrenches = nrchain.elastic_wrenches(
        positions,
        frames,
        spacing=scene.chain.spacing,
        stretch=moduli.stretch,
        shear=moduli.shear,
        twist=moduli.twist,
        bend=moduli.bend,
    )
    velocities, spins = rotne_prager(scene, positions, *wrenches)
    expected = max(
        np.linalg.norm(velocities, axis=1).max() / scene.chain.radius,
        np.linalg.norm(spins, axis=1).max(),
    )
    probe = run_probe(
        3.0, full_scene(scene), [HydrodynamicSet(0.0, 0.0, 0.0, False)], (positions, frames), 0.0
    )
    assert probe.velocities[1][0] == pytest.approx(expected, rel=1e-6)
    named = nrchain.load_scene(scene, effects="named", tolerance=None)
    estimated = {e.change.effect: e for e in estimate_effects(named, budget=1e-3).estimates}
    assert estimated["friction between spheres"].velocity == pytest.approx(expected, rel=1e-6)


def test_the_full_model_states_the_saving_and_the_error_of_the_cheapest_set():
    keys = {"effects": "auto", "tolerance": 0.1, "slip.neighbours": None}
    scene = nrchain.load_scene("wave", **keys, **OWN_UNITS)
    full, choice = choose(scene)
    assert full == full_scene(scene)
    assert choice.left_out == ()
    forgone = choice.forgone
    # two neighbours take no more work than one: elasticity couples three
    assert forgone.left_out == ("slip beyond 2 neighbours a side", "friction between spheres")
    near = nrchain.load_scene(full, friction="one-body", **{"slip.neighbours": 2})
    # to what steps of a probe are followed with, of both runs
    found = difference(near, full, forgone.until)
    assert forgone.error == pytest.approx(1.1 * found, abs=2.0 * CLOSE * scene.tolerance)
    assert scene.tolerance < forgone.error
    lines = [line for line in choice.lines() if "the cheapest set" in line]
    assert lines == [
        "the cheapest set of effects leaves out slip beyond 2 neighbours a side, friction between "
        f"spheres: a right-hand side takes {forgone.work:.2g} of the work, and poses are "
        f"{forgone.error:.2g} radii or radians off by t = {forgone.until:.4g}; 0.1 is allowed"
    ]
    assert Choice.from_json(choice.to_json()) == choice


def test_a_set_that_saves_too_little_is_reported_with_its_error():
    keys = {"chain.ends": "free", "chain.particles": 4, "run.integrator": "cvode"}
    scene = nrchain.load_scene("passive", **(QUIET | keys | OWN_UNITS))
    whole = full_scene(scene)
    found = difference(nrchain.load_scene(whole, friction="one-body"), whole, 4.0, 2001)
    scene = nrchain.load_scene(scene, tolerance=2.0 * found)
    full, choice = choose(scene)
    assert full == full_scene(scene)
    assert candidate_sets(full) == []
    forgone = choice.forgone
    assert 1.0 / 1.5 < forgone.work < 1.0
    assert forgone.error == pytest.approx(1.1 * found, abs=2.0 * CLOSE * scene.tolerance)
    assert "(to t = 4)" in forgone.line(scene.tolerance, 4.0)


def test_an_error_beyond_the_probe_is_an_estimate_or_not_known(quiet):
    tight = nrchain.load_scene(quiet, tolerance=1e-3)
    none = choose(tight, budget=0.0)[1]
    assert none.forgone.error is None
    assert none.lines()[1].endswith("its error is not known")
    assert Choice.from_json(none.to_json()) == none
    forgone = [choice.forgone for choice in cut_short(quiet) if choice.forgone]
    early = next(one for one in forgone if one.carried)
    assert "an estimate beyond t =" in early.line(5e-3, quiet.run.end)


def test_the_stated_work_falls_with_the_pairs_that_are_left_out():
    """The full model has N² pairs and the cheapest set 2N: twice the chain, half its share."""

    direct = {"slip.accuracy": "direct"}

    def share(count):
        scene = nrchain.load_scene("buckling", **OWN_UNITS, **direct | {"chain.particles": count})
        full = full_scene(scene)
        return evaluation_work(full, candidate_sets(full)[0]) / evaluation_work(full)

    assert share(8000) / share(4000) == pytest.approx(0.5, rel=0.05)


def test_the_stated_work_is_that_of_the_cheapest_set_and_of_the_chosen_one(quiet):
    full = full_scene(quiet)
    expected = evaluation_work(nrchain.load_scene(full, friction="one-body"))
    expected /= evaluation_work(full)
    assert choose(quiet)[1].work == expected
    refused = choose(nrchain.load_scene(quiet, tolerance=1e-4))[1]
    assert refused.forgone.work == expected
    assert refused.work == 1.0
    assert f"at {expected:.2g} of the work of a right-hand side" in choose(quiet)[1].lines()[0]
