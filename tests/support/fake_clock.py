"""A processor whose clock advances with counted work alone."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from nrchain import work
from nrchain.motion.charts import ChartedChain

PRICES = {"rates": 1.0, "linearise": 2.0, "factorise": 0.5, "solve": 0.25, "product": 0.125}
"""Seconds of what a chain does, in powers of two: sums of them are exact in any order."""


class Processor:
    """Counts operations. Its clock shows their price, as changed by ``busy``."""

    def __init__(self, busy: Callable[[float], float] = lambda price: price) -> None:
        self.now, self.busy, self.done = 0.0, busy, Counter[str]()

    def clock(self) -> float:
        return self.now

    def do(self, name: str) -> None:
        self.done[name] += 1
        self.now += self.busy(PRICES[name])

    @property
    def truth(self) -> float:
        """The price of all that was done, by count."""
        return sum(PRICES[name] * count for name, count in self.done.items())


@contextmanager
def fake_processor(processor: Processor) -> Iterator[Processor]:
    """Every chain works, and every work is timed, on this processor."""

    def priced(name: str) -> Callable[..., None]:
        method = getattr(ChartedChain, name)

        def call(*arguments: object) -> None:
            processor.do(name)
            method(*arguments)

        return call

    with pytest.MonkeyPatch.context() as patch:
        for name in PRICES:
            patch.setattr(ChartedChain, name, priced(name))
        patch.setattr(work, "clock", processor.clock)
        yield processor
