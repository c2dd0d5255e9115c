"""Keys whose entries are drawn by the functions that draw what they name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from nrchain.view.style import INK, TEXT

SCALE = 3.6
"""Points per unit of length in a key."""


class _Entry:
    """A place in a key that takes the lines and patches of axes, in units about its middle."""

    def __init__(self, box: Any, scale: float) -> None:
        from matplotlib.transforms import Affine2D

        self._box = box
        middle = (box.width / 2 - box.xdescent, box.height / 2 - box.ydescent)
        self._place = Affine2D().scale(scale).translate(*middle) + box.get_transform()

    def plot(self, x: Any, y: Any, **look: Any) -> None:
        from matplotlib.lines import Line2D

        self._add(Line2D(x, y, **look))

    def add_patch(self, patch: Any) -> None:
        self._add(patch)

    def _add(self, artist: Any) -> None:
        artist.set_transform(self._place)
        self._box.add_artist(artist)


class Glyph:
    """An entry of a key; ``draw`` draws it on axes about the origin, ``scale`` points per unit."""

    def __init__(self, draw: Callable[[Any], None], scale: float = SCALE) -> None:
        self._draw, self._scale = draw, scale

    def legend_artist(self, legend: Any, handle: Any, size: float, box: Any) -> None:
        """Draw the entry: what a legend of matplotlib asks of its handlers."""
        self._draw(_Entry(box, self._scale))


def write_glyphs(
    place: Any, entries: Sequence[tuple[str, Any]], columns: int, **options: Any
) -> None:
    """Write a key of glyphs, lines and marks on axes or a figure."""
    handles = [handle for _, handle in entries]
    look: dict[str, Any] = {"frameon": False, "fontsize": TEXT, "labelcolor": INK}
    look |= {"handlelength": 2.2, "handletextpad": 0.6, "columnspacing": 1.0}
    place.legend(
        handles,
        [words for words, _ in entries],
        ncols=columns,
        handler_map={handle: handle for handle in handles if isinstance(handle, Glyph)},
        **look | options,
    )
