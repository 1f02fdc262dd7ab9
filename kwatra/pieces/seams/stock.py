"""What patches are cut from, as laying them sees it."""

from collections.abc import Iterable, Sequence
from typing import Any, Protocol

import numpy as np

Array = np.ndarray[Any, Any]
Matches = list[tuple[Array, Array]]


class Stock(Protocol):
    """Sources, numbered, that show a color at every place and go on from a place by a step along an axis.

    Places are arrays whose last axes are pixels: whole numbers in an exemplar (`Mosaic`), or coordinates between its
    pixels. Colors are (C, ...), in the units in which `distance` compares them.
    """

    def nowhere(self, shape: tuple[int, ...]) -> Array:
        """Places for pixels that have none yet."""

    def places(self, number: int, lines: Sequence[Array]) -> Array:
        """Places of the grid spanned by coordinates in a source, one array per axis, beyond its border by one too."""

    def colors(self, places: Array) -> Array:
        """What is shown at places."""

    def beyond(self, places: Array, axis: int, step: int) -> Array:
        """The places at which the sources go on one step (1 or -1) along an axis."""

    def same(self, one: Array, other: Array) -> Array:
        """Whether places are the same, so that a copy goes on where the next pixel's place is reached by a step."""

    def distance(self, one: Array, other: Array) -> Array:
        """How unlike colors are: a metric, in whole numbers."""

    def matches(self, old: Array, new: Array) -> Matches:
        """Per axis the matching cost M of seams between each pixel of a window and the next (kwatra.pieces.seams.cost).

        old, new: what the pixels show, and what they would show of a new patch. Of each pair first that where only the
        second goes over to the new patch, then that where only the first does.
        """
        show_new = self.colors(new)
        sides = [beside(axis, show_new.ndim - 1) for axis in range(show_new.ndim - 1)]
        ahead = [self.beyond(old[p], axis, 1) for axis, (p, _) in enumerate(sides)]
        back = [self.beyond(old[q], axis, -1) for axis, (_, q) in enumerate(sides)]
        show_old, *further = _shown(self, [old, *ahead, *back], len(sides))
        here, found = self.distance(show_old, show_new), []
        for (p, q), show_ahead, show_back in zip(sides, further[: len(sides)], further[len(sides) :], strict=True):
            over, under = self.distance(show_ahead, show_new[q]), self.distance(show_back, show_new[p])
            found.append((here[p] + over, here[q] + under))
        return found


def _shown(stock: Stock, places: Sequence[Array], axes: int) -> list[Array]:
    """The colors at each of some places, whose last so many axes are pixels: read at once, which takes half as long."""
    flat = [part.reshape(*part.shape[:-axes], -1) for part in places]
    ends = np.cumsum([part.shape[-1] for part in flat])[:-1]
    colors = np.split(stock.colors(np.concatenate(flat, -1)), ends, -1)
    return [shown.reshape(-1, *part.shape[-axes:]) for shown, part in zip(colors, places, strict=True)]


def beside(axis: int, axes: int) -> tuple[Any, Any]:
    """The indices of all pixels but the last along an axis, and of the one after each; of arrays (..., *shape)."""
    lines = [[slice(None)] * axes, [slice(None)] * axes]
    lines[0][axis], lines[1][axis] = slice(None, -1), slice(1, None)
    return (..., *lines[0]), (..., *lines[1])


def each(at: Iterable[Any]) -> Any:
    """The index of pixels into arrays that have further axes before those of the pixels."""
    return (..., *at)
