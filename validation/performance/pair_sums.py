"""Sums over all pairs against those of PyStokes, at the same poses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nrchain import Scene
from nrchain.motion.model import Model
from nrchain.scene.poses import initial_poses
from validation.performance.recipe import Recipe
from validation.performance.scenes import ALL_PAIRS, MODES, PROJECT, curved
from validation.performance.timing import in_turns
from validation.report.recorder import Recorder
from validation.report.threads import one_thread

AGREEMENT = 1e-10


def compare(recorder: Recorder) -> None:
    """Record the time of one sum over all pairs, N = 1024, for each routine of PyStokes."""
    count = 1024
    rows: list[tuple[str, dict, float]] = [
        ("slip, four modes", MODES, 15.0),
        ("slip, 2s alone", {"slip.2s": 100.0}, 7.0),
        ("friction", {"slip.2s": 100.0, "friction": "pairwise"}, 5.0),
    ]
    for name, effects, bar in rows:
        scene = curved(count, **ALL_PAIRS, **effects)
        mine, rival = _pair_tasks(scene, friction=name == "friction")
        error = np.abs(mine() - rival()).max() / np.abs(mine()).max()
        recorder.check(
            f"{name}: largest difference from PyStokes, N = {count}",
            0.0,
            error,
            AGREEMENT,
            source="the same output is compared",
        )
        rounds = 5 if recorder.quick else 25
        with one_thread():
            alone = in_turns({"ours": mine, "theirs": rival}, rounds=rounds)
        shared = in_turns({"ours": mine, "theirs": rival}, rounds=rounds)
        for found, how in ((shared, "all threads"), (alone, "one thread")):
            our, their = (float(np.median(found[side])) for side in ("ours", "theirs"))
            pairs = count * (count - 1)
            what = (
                f"all pairs, N = {count}, {how}: {1e9 * our / pairs:.2f} ns a pair against "
                f"{1e9 * their / pairs:.1f} ns with PyStokes, tensors ready"
            )
            recorder.benchmark(f"all pairs, {name}, {how}", our, their, what=what)
        recorder.bound(
            f"all pairs, {name}: times PyStokes' speed", their / our, least=bar, source=PROJECT
        )


def _pair_tasks(scene: Scene, friction: bool) -> tuple[Callable, Callable]:
    """Our sum and that of PyStokes; both return (2, 3, N)."""
    positions, frames = initial_poses(scene)
    model, recipe = Model(scene), Recipe(scene, positions, frames)
    centres, turned = recipe.poses(recipe.start)
    forces, torques = recipe.elasticity.wrenches(centres, turned)
    tensors = recipe.slip.tensors(turned[:, 0])
    wrenches = np.concatenate([forces, torques]).T.copy()

    def mine() -> np.ndarray:
        twists = np.zeros((model.count, 6))
        if friction:
            assert model.friction
            model.friction.apply(positions, wrenches, twists)
        else:
            model.slip.add_twists(positions, frames, twists)
        return twists.T.reshape(2, 3, -1)

    def rival() -> np.ndarray:
        out = np.zeros((2, 3, model.count))
        if friction:
            assert recipe.friction
            recipe.friction.add(centres, forces, torques, out)
        else:
            recipe.slip.add(centres, tensors, out)
        return out

    return mine, rival
