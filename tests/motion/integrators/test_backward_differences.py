"""CVODE and SciPy's BDF: their error falls with the fifth power of the number of steps."""

import numpy as np
import pytest
from support.stepping import distances, integrate, prepare, tumbling

TOLERANCES = 10.0 ** -np.arange(6.0, 10.1, 0.25)


@pytest.fixture(scope="module")
def reference():
    """Radau IIA in steps so short that its error is below 1e-10."""
    scene = tumbling()
    return integrate(scene, "radau", 1e-9, [scene.run.end], fixed_step=scene.run.end / 3072)


class UsedMemory:
    """NumPy, whose empty arrays hold signalling NaNs: arithmetic with one of them is an error."""

    def __getattr__(self, name):
        return getattr(np, name)

    def empty(self, shape, dtype=float):
        return np.full(shape, 0x7FF0000000000001, np.uint64).view(dtype)


def test_the_first_step_of_scipy_does_not_depend_on_what_memory_held(monkeypatch):
    monkeypatch.setattr("scipy.integrate._ivp.bdf.np", UsedMemory())
    _, integrator = prepare(tumbling(), "scipy-bdf", 1e-6)
    for _ in range(10):
        assert np.isfinite(integrator.at(integrator.step())).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cvode", "scipy-bdf"])
def test_order(name, reference):
    """Steps and order vary, so that the slope is that of the whole.

    Where orders switch, the error at one tolerance is off the line by a factor of up to three
    (a standard deviation of 0.5 in its logarithm). Over these seventeen, whose steps differ by a
    factor of four, a slope is then known to ± 0.25: it is 5 to within three times that.
    """
    scene = tumbling()
    paths = [integrate(scene, name, tolerance, [scene.run.end]) for tolerance in TOLERANCES]
    steps = [path.integrator.steps for path in paths]
    errors = [max(distances(path, reference)) for path in paths]
    slope = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert abs(slope - 5.0) < 0.75
    assert errors[-1] < 5e-7
    assert steps[-1] < 2500
