"""Copies that the flow drives together overlap: the one that ends there in a gap between elements lies above.

A carried pixel keeps the copy that is nearest, so where two copies meet head on both lose their rims, and what was a
gap becomes a seam through two elements. So a pixel beside a seam goes over to the other copy if that makes

    sum_pq min(d(p), d(q)) + length

less, over all pairs of neighbors p and q of two copies; d is how deep in its element a pixel lies, 0 in the gaps. So
a seam near a gap moves there, a pixel at most in a frame, and stays: one of two elements is whole and slides over the
other, as things do, until that is gone or renewed. Of made stones of 20 and 32 px in a pair of vortices (seeds 0 and 1;
frames 60, 100 and 150) .52 are cut without this, .44 with it; motion is off by .213 and .195 px, frames flicker by .092
and .085, and a fifth less is renewed.
"""

from collections.abc import Callable

import numpy as np
import torch
from torch import Tensor

from flow.animation.carrying.copies import BESIDE, JUMP, NEIGHBORS

_LENGTH = 0.1
"""What a pixel of a seam costs wherever it lies, so that seams do not fray. Of made stones as many are cut with
.3, .48 for .49 (seed 0; two rounds a frame)."""


def overlapped(
    source: Tensor, free: Tensor, inside: Tensor, depth: Tensor, usable: Callable[[Tensor], Tensor]
) -> Tensor:
    """Source coordinates (2, H, W), x first, with seams moved into gaps where free (H, W).

    inside (H, W): where there is texture; what is elsewhere has no influence. depth (h, w): how deep in its element
    each place of the exemplar lies, 0 to 1. usable: where (*S) coordinates (2, *S) lie in the exemplar; nothing goes
    over to what does not.
    """
    from flow.animation.carrying.edges import hide, tell_turns

    there, may = (values.contiguous() for values in (inside, free))
    after, turn = source.clone(memory_format=torch.contiguous_format), torch.empty(source.shape, dtype=torch.float32)
    tell_turns(len(there), after, there, NEIGHBORS, turn)
    for odd in range(2):  # of a checkerboard, on which no two neighbors go over at once
        hide(len(there), after, turn, there, may, depth.contiguous(), np.array(BESIDE), JUMP, _LENGTH, odd)
    return torch.where(usable(after), after, source)
