"""CVODE and SciPy's BDF: their error falls with the fifth power of the number of steps."""

import numpy as np
import pytest
from integrators.stepping import distances, integrate, tumbling

TOLERANCES = (1e-6, 1e-7, 1e-8, 1e-9, 1e-10)


@pytest.fixture(scope="module")
def reference():
    """Radau IIA in steps so short that its error is below 1e-10."""
    scene = tumbling()
    return integrate(scene, "radau", 1e-9, [scene.run.end], fixed_step=scene.run.end / 3072)


@pytest.mark.parametrize("name", ["cvode", "scipy-bdf"])
def test_order(name, reference):
    """Steps and order vary, so that the slope is that of the whole: 5, and up to a half more.

    Tighter tolerances spend less of the run at the low orders it starts with, and the error falls
    a little faster than the highest order alone would have it.
    """
    scene = tumbling()
    paths = [integrate(scene, name, tolerance, [scene.run.end]) for tolerance in TOLERANCES]
    steps = [path.integrator.steps for path in paths]
    errors = [max(distances(path, reference)) for path in paths]
    slope = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 4.9 < slope < 5.6
    assert errors[-1] < 5e-7
    assert steps[-1] < 2500
