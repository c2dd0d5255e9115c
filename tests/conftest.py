"""Floating-point errors in NumPy raise in every test, and Ctrl-C ends the tests."""

import os
import signal
from pathlib import Path

# Tests run side by side, one on each core. Threads that wait for each other in a loop would take
# the cores of other tests: a second of eigenvalues, or of PyStokes, then takes up to a minute.
# Libraries read this when they are first imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_WAIT_POLICY", "passive")

import numpy as np
import pytest
from hypothesis import settings

# The first example of a test may compile a kernel: how long an example takes says nothing. The
# examples are the same in every run.
settings.register_profile("nrchain", deadline=None, derandomize=True)
settings.load_profile("nrchain")

# A shell starts what it runs in the background with SIGINT ignored, and children inherit that.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


WITHOUT_RUNS = Path(__file__).parent / "hydrodynamics"
"""Tests that compile no integrator, and last about as long as its compilation."""


def pytest_collection_modifyitems(config, items):
    """One worker compiles the kernels of a run, and the others find them on disk.

    Workers begin with equal parts of all tests. All parts but the first begin with tests without
    runs.
    """
    workers = getattr(config, "workerinput", {"workercount": 1})["workercount"]
    if workers == 1:
        return
    without = [item for item in items if WITHOUT_RUNS in item.path.parents]
    others = [item for item in items if WITHOUT_RUNS not in item.path.parents]
    ordered = []
    for worker in range(workers):
        begin = without[_part(without, worker - 1, workers - 1)] if worker else []
        more = max(0, len(items) // workers - len(begin))
        ordered += begin + others[:more]
        del others[:more]
    items[:] = ordered + others


def _part(items, index, count):
    """One of ``count`` equal parts of a list."""
    return slice(len(items) * index // count, len(items) * (index + 1) // count)


@pytest.fixture(autouse=True)
def _strict_arithmetic():
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield


@pytest.fixture
def spring():
    """The effect of a user, registered while the test runs."""
    from support.spring import Spring

    import nrchain

    nrchain.register_effect(Spring)
    yield Spring
    nrchain.unregister_effect(Spring)


@pytest.fixture
def configuration(request):
    """One of ``support.configurations``; an effect of a user is registered while the test runs."""
    effect = request.param.effect
    if effect is not None and effect.name == "spring":
        request.getfixturevalue("spring")
    return request.param
