"""Points where a target changes most, by the package ``adaptive``, in one or two keys.

Points are chosen in rounds of fixed size, and a round begins when all of the last one are done. So
they follow from the targets alone, whatever the executor and the order in which runs end.

For numbers the loss of an interval or a triangle is that of ``adaptive``: its size with the rise of
the target. For words, such as kinds of attractors, it is its size, reduced where all corners agree:
boundaries are bisected.

B. Nijholt, J. Weston, J. Hoofwijk, A. Akhmerov, *Adaptive: parallel active learning of mathematical
functions* (2019), doi:10.5281/zenodo.1182437.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from nrchain.errors import SceneError
from nrchain.inputs.optional import optional
from nrchain.scene.scene import Scene
from nrchain.sweeps.axes import Ends, read_ends, whole_numbers
from nrchain.sweeps.points import Site, Values, sites

BATCH = 8
"""Points of a round, unless another number is given."""

INSIDE = {1: 0.05, 2: 0.1}
"""Loss of an interval, or a triangle, whose corners agree, relative to one of equal size whose
corners differ."""

MIDDLE = 0.5 * (3.0 - 5.0**0.5)
"""A part of the range at which a scene is tried beside its corners."""

Target = float | int | str | None


class AdaptivePoints:
    """Rounds of points over the ranges of one or two keys.

    Raises :class:`~nrchain.errors.SceneError` for other numbers of keys, for ends that are none,
    for a key that takes whole numbers, and for a scene that is refused at a corner or inside.
    """

    def __init__(self, scene: Scene, ranges: Mapping[str, Any]) -> None:
        if not isinstance(ranges, Mapping) or len(ranges) not in INSIDE:
            allowed = 'must name one or two keys and their ends, as {"slip.2s": (0, 100)}'
            raise SceneError("adaptive", ranges, allowed)
        self._scene = scene
        self._ends: dict[str, Ends] = {
            str(key): read_ends("adaptive", str(key), given) for key, given in ranges.items()
        }
        for key, ends in self._ends.items():
            if isinstance(whole_numbers(scene, {key: float(round(ends.low))})[key], int):
                raise SceneError(f"adaptive {key}", ranges[key], "takes whole numbers; use a grid")
        corners = [np.full(len(ranges), part) for part in (0.0, MIDDLE, 1.0)]
        sites(scene, [self._values(corner) for corner in corners])

    def rounds(
        self, samples: int, batch: int, measured: Callable[[Sequence[Site]], Sequence[Target]]
    ) -> Iterator[list[Site]]:
        """The points of each round, until there are ``samples`` of them.

        ``measured`` gives the targets of a round, once it is done.
        """
        learner, codes = _Learner(len(self._ends)), _Codes()
        places: list[np.ndarray] = []
        told: list[Target] = []
        while len(told) < samples:
            # the last round is the beginning of a whole one: more samples begin with the same
            asked = learner.ask(batch if told else 2 ** len(self._ends))[: samples - len(told)]
            found = sites(self._scene, [self._values(place) for place in asked])
            yield found
            places += asked
            told += measured(found)
            learner.tell(places, codes.numbers(places, told), words=codes.are_words(told))

    def _values(self, place: np.ndarray) -> Values:
        parts = zip(self._ends.items(), place, strict=True)
        return {key: ends.at(float(part)) for (key, ends), part in parts}


class _Codes:
    """Targets as numbers: each word has one, and what has no target takes that of the nearest."""

    def are_words(self, told: Sequence[Target]) -> bool:
        return any(isinstance(one, str) for one in told)

    def numbers(self, places: Sequence[np.ndarray], told: Sequence[Target]) -> list[float]:
        words = sorted({str(one) for one in told if isinstance(one, str)})
        known = [one is not None and one == one for one in told]
        numbers = np.array(
            [float(words.index(one)) if isinstance(one, str) else float(one or 0.0) for one in told]
        )
        if any(known) and not all(known):
            at = np.array(places)
            have = np.flatnonzero(known)
            for k in np.flatnonzero(np.logical_not(known)):
                numbers[k] = numbers[have[np.argmin(((at[have] - at[k]) ** 2).sum(axis=1))]]
        return numbers.tolist()


class _Learner:
    """A learner of ``adaptive`` over the unit interval or square, made anew from all targets."""

    def __init__(self, dimension: int) -> None:
        self._dimension = dimension
        self._adaptive = optional("adaptive", "sweep", "adaptive sampling")
        self._learner = self._new(words=False)

    def ask(self, count: int) -> list[np.ndarray]:
        points, _ = self._learner.ask(count)
        return [np.atleast_1d(np.asarray(point, float)) for point in points]

    def tell(self, places: Sequence[np.ndarray], numbers: Sequence[float], words: bool) -> None:
        # the numbers of words change as new words appear
        self._learner = self._new(words)
        for place, number in zip(places, numbers, strict=True):
            self._learner.tell(float(place[0]) if len(place) == 1 else tuple(place), number)

    def _new(self, words: bool) -> Any:
        if self._dimension == 1:
            loss = _interval_loss if words else None
            return self._adaptive.Learner1D(None, (0.0, 1.0), loss)
        square = ((0.0, 1.0), (0.0, 1.0))
        return self._adaptive.Learner2D(None, square, _triangle_loss if words else None)


def _interval_loss(x: Sequence[float], y: Sequence[float]) -> float:
    return float(x[1] - x[0]) * (1.0 if y[0] != y[1] else INSIDE[1])


def _triangle_loss(interpolator: Any) -> np.ndarray:
    triangles = interpolator.tri
    corners = triangles.points[triangles.simplices]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2.0
    differ = np.ptp(interpolator.values[triangles.simplices], axis=1).max(axis=1) > 0.0
    return np.sqrt(area) * np.where(differ, 1.0, INSIDE[2])
