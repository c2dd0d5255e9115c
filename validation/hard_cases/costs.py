"""The cost of watching: runs with the guard, and with the guard switched off."""

from __future__ import annotations

from unittest.mock import patch

from nrchain import Scene, load_scene, simulate
from nrchain.watch.guard import Guard

ROUNDS = 3
"""Runs of each kind, in turns; the fastest counts."""


def scenes(quick: bool) -> dict[str, Scene]:
    """The scenes to run, by name."""
    long = load_scene("buckling", **{"chain.particles": 10**4, "run.end": 0.2})
    return {"N = 20": load_scene("buckling")} | ({} if quick else {"N = 10⁴": long})


def watching(scene: Scene) -> tuple[float, float]:
    """Seconds of a run that watches for contacts and quarter turns, and of one that does not."""
    simulate(scene)
    guarded, blind = [], []
    for _ in range(ROUNDS):
        guarded.append(_seconds(scene))
        with patch.object(Guard, "watch", lambda *_: None):
            blind.append(_seconds(scene))
    return min(guarded), min(blind)


def _seconds(scene: Scene) -> float:
    return float(simulate(scene).counters["wall_time"])
