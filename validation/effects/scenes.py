"""Random scenes with fixed seeds: modes and mixes, lengths, ends, starts, reach and friction."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain import Scene, SceneError, load_scene, simulate
from nrchain.planning.weaknesses import Load, bond_loads
from nrchain.theory.line_loads import line_loads

MIXES = (
    ("2s",),
    ("3a",),
    ("3t",),
    ("4a",),
    ("2s", "3t"),
    ("2s", "4a"),
    ("3a", "4a"),
    (),
)
STRENGTHS = {
    "2s": (10.0, 120.0),
    "3a": (300.0, 5000.0),
    "3t": (50.0, 1500.0),
    "4a": (300.0, 10000.0),
}
"""Least and largest strength of each mode; the sign is random."""

SPINNING_END = 6.0
"""End of runs with 4a, which turn hundreds of times in the time that others need to bend."""

SNAPSHOTS = 129
SHORTENED = 0.8
"""A scene whose run stops is run again to this fraction of the time reached."""

LONG = (64, 160)
"""Least and largest number of spheres of the long chains."""


def random_scene(seed: int) -> Scene:
    """A scene in the beam limit, of 8 to 24 spheres."""
    random = np.random.default_rng([seed, 2022])
    modes = MIXES[seed % len(MIXES)]
    table: dict[str, Any] = {
        "chain.particles": int(random.integers(8, 25)),
        "chain.ends": str(random.choice(["free", "clamped"])),
        "elasticity.ratio": 1e7,
        "start.shape": str(random.choice(["random", "sine", "helix-left", "helix-right"])),
        "start.amplitude": float(10 ** random.uniform(-1.5, 0.4)),
        "start.wavenumber": float(random.integers(1, 4)),
        "start.seed": int(random.integers(1000)),
        "slip.neighbours": (1, 2, 4, "all")[int(random.integers(4))],
        "slip.finite_size": bool(random.integers(2)),
        "friction.kind": "pairwise" if random.random() < 0.4 else "one-body",
        "run.end": float(10 ** random.uniform(1.0, 2.5)),
        "run.snapshots": SNAPSHOTS,
    }
    for label in modes:
        least, most = STRENGTHS[label]
        size = float(np.exp(random.uniform(np.log(least), np.log(most))))
        table[f"slip.{label}"] = round(size * random.choice([-1.0, 1.0]), 3)
    if table["start.shape"] == "random":
        table["start.amplitude"] = min(table["start.amplitude"], 0.3)
    if "4a" in modes:
        table["run.end"] = min(table["run.end"], SPINNING_END)
    return _held(table)


def long_scene(seed: int) -> Scene:
    """A long chain over a short time; its pairs cost more than its links."""
    random = np.random.default_rng([seed, 4044])
    label = tuple(STRENGTHS)[seed % len(STRENGTHS)]
    size = {"2s": 5.0, "3a": 300.0, "3t": 100.0, "4a": 200.0}[label]
    return load_scene(
        {
            "chain.particles": int(random.integers(*LONG)),
            "elasticity.stretch": 20.0,
            "elasticity.shear": 20.0,
            "start.shape": "sine",
            "start.amplitude": 2.0,
            "start.wavenumber": 4.0,
            "run.end": 5.0,
            "run.snapshots": SNAPSHOTS,
            f"slip.{label}": size,
        }
    )


def _held(table: dict[str, Any]) -> Scene:
    """The scene, with links stiff enough for the beam limit."""
    while True:
        scene = load_scene(table)
        if all(load.holds for load in _bond_loads(scene)) or table["elasticity.ratio"] > 1e11:
            return scene
        table["elasticity.ratio"] *= 10.0


def _bond_loads(scene: Scene) -> tuple[Load, Load]:
    """Loads on the links, also those with free ends as a bend grows."""
    return bond_loads(scene, line_loads(load_scene(scene, **{"chain.ends": "free"})))


def completed(scene: Scene, **changes: Any) -> Scene:
    """The scene, shortened until its run with ``changes`` completes."""
    for _ in range(5):
        run = simulate(load_scene(scene, **changes, **{"run.rtol": 1e-5, "run.atol": 1e-5}))
        if run.status == "completed":
            return scene
        scene = load_scene(scene, **{"run.end": SHORTENED * float(run.time[-1])})
    raise SceneError("scene", scene.title, "stops however short it is")
