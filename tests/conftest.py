"""Floating-point trouble in NumPy raises in every test."""

import numpy as np
import pytest
from hypothesis import settings

# The first example of a test may compile a kernel: how long an example takes says nothing. The
# examples are the same in every run.
settings.register_profile("nrchain", deadline=None, derandomize=True)
settings.load_profile("nrchain")


@pytest.fixture(autouse=True)
def _strict_arithmetic():
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield
