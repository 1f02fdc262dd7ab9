"""Seams along the gaps between elements, where a texture has any."""

from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from kwatra.elements import find_ground
from kwatra.exemplar import Exemplar
from kwatra.pieces.keeping import cheaper
from kwatra.pieces.mosaic import Mosaic
from kwatra.pieces.seams import Depth, SeamCost

SURE = 0.1
"""Ground that is less sure is taken for none."""

AROUND = 1.2
"""Blocks overlap by so many elements: with less there often is no way around one."""

THROUGH = 0.1
"""What a seam through an element costs at least, in standard deviations of the exemplar: a cut is seen even where
colors are alike. Tuned, with AROUND, on made stones and coins."""


class Gaps(NamedTuple):
    """What seams of a mosaic cost that are hidden in gaps, and by how many pixels blocks overlap to reach one."""

    mosaic: Mosaic
    cost: SeamCost
    overlap: int

    def cheaper(self, before: Tensor, after: Tensor) -> Tensor:
        """Where (boolean, *S) to go over from a source map (n, *S) to a later one, so that seams cost least."""
        places = (self.mosaic.places_of(list(where.cpu().numpy())) for where in (before, after))
        return torch.from_numpy(cheaper(self.cost, *places)).to(before.device)


def gaps(exemplar: Exemplar, mosaic: Mosaic, deviation: float) -> Gaps | None:
    """The gaps of an exemplar of still images, None without any.

    mosaic: its canvas; deviation: the standard deviation of its colors, in the mosaic's units.
    """
    ground = find_ground(exemplar)
    if ground.sure < SURE:
        return None
    depth = (1 - ground.sure * (1 - ground.depth)).astype(np.float32)
    cost = SeamCost(mosaic, depth=Depth(mosaic.spread(depth), THROUGH * ground.sure * deviation))
    return Gaps(mosaic, cost, round(AROUND * ground.sure * ground.size))
