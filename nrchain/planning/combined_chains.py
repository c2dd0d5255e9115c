"""The charted chains of several scenes as one system of ODEs."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from nrchain.motion.charts import ChartedChain


class CombinedChains:
    """Several charted chains as one: each has its own part of y."""

    def __init__(self, chains: Sequence[ChartedChain]) -> None:
        self.chains = chains
        self.is_banded = all(chain.is_banded for chain in chains)
        ends = np.cumsum([0, *(chain.dimension for chain in chains)])
        self.dimension = int(ends[-1])
        self.parts = [slice(a, b) for a, b in pairwise(ends)]

    def rates(self, time: float, y: np.ndarray, out: np.ndarray) -> None:
        for chain, part in zip(self.chains, self.parts, strict=True):
            chain.rates(time, y[part], out[part])

    def linearise(self, time: float, y: np.ndarray) -> None:
        for chain, part in zip(self.chains, self.parts, strict=True):
            chain.linearise(time, y[part])

    def factorise(self, gamma: float) -> None:
        for chain in self.chains:
            chain.factorise(gamma)

    def solve(self, vector: np.ndarray, out: np.ndarray) -> None:
        for chain, part in zip(self.chains, self.parts, strict=True):
            chain.solve(vector[part], out[part])

    def product(self, vector: np.ndarray, out: np.ndarray) -> None:
        for chain, part in zip(self.chains, self.parts, strict=True):
            chain.product(vector[part], out[part])
