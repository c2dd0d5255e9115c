"""Scenes whose right-hand sides and runs are timed."""

from __future__ import annotations

from nrchain import Scene, load_scene

MODES = {"slip.2s": 100.0, "slip.3a": 5000.0, "slip.3t": 1000.0, "slip.4a": 10000.0}
ALL_PAIRS = {"slip.neighbours": "all"}
LONG_RANGE = {"slip.neighbours": "all", "friction": "pairwise"}
PROJECT = "the project's bar"
"""Source of bounds that the project sets itself."""


def curved(count: int, **changes: object) -> Scene:
    """A free chain on a sine of five radii: no pair of spheres is like another."""
    table = {
        "chain.particles": count,
        "elasticity.stretch": 200.0,
        "elasticity.shear": 200.0,
        "start.shape": "sine",
        "start.amplitude": 5.0,
        "run.end": 1.0,
    }
    return load_scene(table | changes)


def buckling(count: int, **changes: object) -> Scene:
    """2s at V = 100 and R = 1e12, free ends, from a random tenth of a radius to t = 400."""
    table = {
        "chain.particles": count,
        "elasticity.ratio": 1e12,
        "slip.2s": 100.0,
        "start.shape": "random",
        "run.end": 400.0,
        "run.snapshots": 11,
    }
    return load_scene(table, **changes)
