"""Straight chains whose strengths change along them."""

import numpy as np

import nrchain

HALVES = [500.0] * 8 + [-500.0] * 8
UNITS = {"chain.radius": 1.3, "chain.viscosity": 0.7, "chain.spacing": 8.0}


def opposed(stiffness, **changes):
    """Two halves of sources that swim against each other."""
    table = {
        "chain.particles": 16,
        "elasticity": {"stretch": stiffness, "shear": stiffness},
        "slip.3t": HALVES,
        "start.shape": "straight",
        "run": {"end": 300.0, "snapshots": 2},
    }
    return nrchain.load_scene(table | changes)


def graded(ends, friction, stiffness, **changes):
    """A straight chain whose strengths change along it, pushed and spun, long enough to settle."""
    return nrchain.load_scene(
        {
            "chain": {"particles": 12, "ends": ends},
            "friction": friction,
            "slip.3t": np.linspace(-300.0, 500.0, 12).tolist(),
            "slip.4a": np.linspace(400.0, -300.0, 12).tolist(),
            "slip.2s": [40.0] * 5 + [-20.0] * 7,
            "slip.neighbours": 3,
            "elasticity": {
                "stretch": stiffness,
                "shear": stiffness,
                "twist": 60.0 * stiffness,
                "bend": 2e4,
            },
            "start.shape": "straight",
            "run": {"end": 300.0 / stiffness * 1e3, "snapshots": 2, "rtol": 1e-9, "atol": 1e-11},
        }
        | UNITS
        | changes
    )
