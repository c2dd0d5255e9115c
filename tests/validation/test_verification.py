"""The study of estimates: its scenes, its errors, and an estimate that is off is found."""

import numpy as np
import pytest
from support.selection import few_of

import nrchain
from validation.report.random_scenes import random_scene
from validation.report.recorder import Recorder
from validation.verification import run as verification


def test_scenes_are_the_same_every_time_and_differ():
    assert random_scene(3) == random_scene(3)
    scenes = [random_scene(seed) for seed in range(40)]
    assert len({scene.to_toml() for scene in scenes}) == 40
    assert {scene.chain.ends for scene in scenes} == {"free", "clamped", "periodic"}
    tolerances = sorted({scene.run.rtol for scene in scenes})
    assert tolerances == pytest.approx([1e-7, 1e-6, 1e-5, 1e-4])


def test_errors_are_largest_distances_in_radii_and_angles():
    changes = {"chain.radius": 2.0, "run.end": 1.0, "run.snapshots": 3}
    run = nrchain.simulate(nrchain.load_scene("passive", **changes))
    turn = np.array([[np.cos(0.3), np.sin(0.3), 0.0], [-np.sin(0.3), np.cos(0.3), 0.0], [0, 0, 1]])
    positions, frames = run.positions.copy(), run.frames.copy()
    positions[1, 2] += [3.0, 0.0, 4.0]
    frames[2, 0] = frames[2, 0] @ turn
    moved = nrchain.Trajectory(run.time, positions, frames, run.scene)
    assert verification._errors(moved, run) == pytest.approx(
        np.array([[0.0, 2.5, 0.0], [0.0, 0.0, 0.3]])
    )


@pytest.mark.parametrize("factor", [0.3, 1.0, 2.9, 3.1])
def test_an_estimate_off_by_more_than_three_is_found(factor, monkeypatch):
    errors = np.outer([1.0, 2.0], np.linspace(0.0, 1e-5, 5))
    one = verification.Compared(0, 1e-6, factor * errors, errors, 1.5)
    monkeypatch.setattr(verification, "_compared", lambda: iter([one] * 6))
    monkeypatch.setattr(verification, "_time", lambda recorder: None)
    recorder = Recorder("verification", quick=True)
    verification.study(recorder)
    assert bool(recorder.failed) == (not 1.0 / 3.0 < factor < 3.0)


@pytest.mark.parametrize("integrator", few_of(["cvode", "radau"], {"radau"}))
def test_the_estimate_of_a_random_scene_is_near_its_error(integrator):
    scene = nrchain.load_scene(random_scene(9), **{"run.integrator": integrator})
    one = verification._compare(9, scene)
    assert one is not None
    assert verification._near(one.ratios).all()
    assert one.cost > 1.0
