"""Joints between large elements: mortar between bricks, what parts roof tiles and slabs, and how seams use them.

In a still a seam along ground that is a texture of its own is seen, and blocks that agree in colors have no need of it
(`kwatra.elements.find_ground`). In a flow no block agrees for long: columns of a wall move past each other, so that
seams there must be, and one through a brick is seen more than one along its mortar. What is within bricks is alike,
too: to the colors alone a block without any mortar fits best, which lets the mortar beside it end in nothing. So seams
are hidden in joints as well, blocks hold whole elements, and where their joints lie counts more than their colors.
"""

from kwatra import Exemplar, element_size
from kwatra.elements import find_ground
from kwatra.pieces import Hidden, found_coarser, hidden_along, hidden_seams

_SURE = 0.6
"""Less sure ground is no joints. Walls of large bricks have .69 and more, radishes, which lie on leaves, .22: they move
worse with it (epe .48 px for .28) and are no more whole."""

_LARGE = 20.0
"""Elements of fewer px are left alone: blocks hold many of them whole, and their walls bend rather than break. Bricks
of 9 and 10 px are cut half as often with joints, but breaks line up, and flicker by .210 for .193."""

_PLAIN = 0.5
"""Ground that is at least as plain hides seams as it does in stills, but for thin lines between long elements."""

_ALIGNED = 2.0
"""What it counts beside the colors that joints lie on joints. Three seeds of skimage's brick and of roof tiles, in a
pair of vortices and turning by 2 px, are off by .58 .40 .42 .24 px with it, by .70 .45 .50 .28 with the .5 that plain
ground has, by .64 .53 .49 .34 without joints (a seam through them as dear as through stones)."""

_DEARER = 2.0
"""How many times as much as of stones a seam costs more through such elements. Of bricks made in code of 32 and 40 px,
in vortices and turning, .57 .53 are cut with 1, .50 .44 with 2, .46 .41 with 3 and .41 .39 with 10, .86 .85 without
joints. The above are then off by .63 .39 .53 .24 px, and with 3 by .59 .32 .37 .43; stones of a wall of 22 px by .29
.19, .31 .18 and .32 .21, without joints by .27 .17."""


def joints(exemplar: Exemplar) -> Hidden | None:
    """Where seams of what flows are hidden in a picture: in the gaps of stills, and in joints; None where nowhere."""
    if element_size(exemplar) < _LARGE:
        return hidden_seams(exemplar)
    return found_coarser(_joints, exemplar)


def _joints(exemplar: Exemplar) -> Hidden | None:
    ground = find_ground(exemplar)
    if ground.sure < _SURE or (ground.plain >= _PLAIN and not ground.long):
        return hidden_seams(exemplar)
    return hidden_along(ground, ground.sure, _ALIGNED, _DEARER)
