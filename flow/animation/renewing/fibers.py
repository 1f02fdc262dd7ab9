"""Textures that run along an axis, as wood, bark and brushed metal do, and how they are renewed.

Where a copy ends across the grain that is seen, for hardly a fiber goes on beyond it; beside a fiber it is not. If
both cost the same a cut goes straight across, and where a flow brings more of the same two copies to light their
border is continued, as a straight line. So seams between fibers cost as many times less as the exemplar changes faster
there: then cuts follow each fiber to where it goes on best (thesis equation 5 divides what a seam costs by the
gradients beside it; here it is by those of all). Blocks are long, so that fibers have a choice of such places, and
windows are long and slim: each is of a few fibers, and tells whether they go on.
"""

from collections.abc import Sequence

from kwatra.elements import drawn_sides

_LENGTH, _WIDTH = 2.0, 0.75
"""Blocks are so many times as long and as wide as others. The steepest row across the grain, beside the exemplar's own:
two woods and brushed metal made in code that move across their grain or turn, 75 frames, 1.1, 2.5, 3.2 (across) and
1.3, 2.7, 4.2 (turning); with .5 in place of .75 1.1, 2.7, 2.6 and 1.2, 3.4, 3.7; with squares, and seams of one price,
1.7, 7.3, 11 and 2.7, 6.8, 9.2. With .25 one wood was covered by one bright block after another."""


def block_sides(size: int, along: int | None, most: Sequence[int]) -> tuple[int, int]:
    """The height and width of blocks that are `size` px wide where texture runs along no axis, at most so many px."""
    height, width = drawn_sides(size, along, _LENGTH, _WIDTH)
    return min(height, most[0]), min(width, most[1])
