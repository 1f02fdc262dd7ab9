"""What patches are cut from, as laying them sees it."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

Array = np.ndarray[Any, Any]


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
