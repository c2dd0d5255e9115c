"""What watching costs: runs with the guard, and the same with one that looks at nothing."""

from __future__ import annotations

from unittest.mock import patch

from nrchain import Scene, load_scene, simulate
from nrchain.watch.guard import Guard

ROUNDS = 3
"""Runs of each kind, in turn; the fastest counts."""


def scenes(quick: bool) -> dict[str, Scene]:
    """The scenes to be run, by the words for them."""
    long = load_scene("buckling", **{"chain.particles": 10**4, "run.end": 0.2})
    return {"N = 20": load_scene("buckling")} | ({} if quick else {"N = 10⁴": long})


def watching(scene: Scene) -> tuple[float, float]:
    """Seconds of a run with contacts and quarter turns looked for, and without."""
    simulate(scene)
    guarded, blind = [], []
    for _ in range(ROUNDS):
        guarded.append(_seconds(scene))
        with patch.object(Guard, "watch", lambda *_: None):
            blind.append(_seconds(scene))
    return min(guarded), min(blind)


def _seconds(scene: Scene) -> float:
    return float(simulate(scene).counters["wall_time"])
