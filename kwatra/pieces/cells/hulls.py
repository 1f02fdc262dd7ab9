"""Elements with bays, as the convex hulls by which they are moved and squeezed whole.

A cell is warped along rays from its middle, on which its element has to lie in one piece: letters do not. The hull of
one does, and what there is of the ground in it goes with the element.
"""

import numpy as np
from scipy import ndimage

from kwatra.pieces.seams import Array, Parts

MANY, BAYS = 0.25, 0.76
"""Elements have bays if so many of them fill no more of their hulls. Of letters made in code that quarter fills .60 to
.73, of print .74, of moons and crosses .61 and .72; of woven cloth and of nuts that touch, which score worse and become
smaller with hulls, .78 and .85."""


def hulls(parts: Parts, inside: Array) -> Parts | None:
    """Parts, those that are whole grown to their hulls, of what is `inside` (*S); None if they have no bays.

    Without what is nearer to another part.
    """
    from skimage.morphology import convex_hull_image  # takes a fifth of a second; few pictures have such elements

    whole, nearest, made, filled = parts.whole(inside), parts.nearest, parts.number.copy(), list[float]()
    for part, box in enumerate(ndimage.find_objects(parts.number.clip(min=0)), 1):
        if whole[part]:
            own = parts.number[box] == part
            hull = own | (convex_hull_image(own) & (nearest[box] == part) & inside[box])
            made[box][hull] = part
            filled.append(np.count_nonzero(own) / np.count_nonzero(hull))
    return parts._replace(number=made) if filled and np.quantile(filled, MANY) <= BAYS else None
