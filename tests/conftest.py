"""Floating-point trouble in NumPy raises in every test."""

import numpy as np
import pytest


@pytest.fixture(autouse=True)
def _strict_arithmetic():
    with np.errstate(divide="raise", over="raise", invalid="raise"):
        yield
