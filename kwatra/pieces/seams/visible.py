"""How much of the seams is seen where an exemplar was copied together."""

import numpy as np
from torch import Tensor

from kwatra.base import continued
from kwatra.exemplar import Exemplar
from kwatra.pieces.seams.cost import SeamCost
from kwatra.pieces.seams.mosaic import Mosaic

HARDLY = 0.1
"""Seams are hardly seen that cost less than this part of one between unrelated pixels."""


def visible_seams(exemplar: Exemplar, where: Tensor) -> float:
    """The cost of visible seams per pixel of a source map (n, *S), 0 for none.

    1 is what a seam between unrelated pixels costs: twice the deviation of each channel.
    """
    mosaic = Mosaic([(continued(exemplar.canvas, exemplar.owner).cpu() * exemplar.share.cpu()).numpy()])
    unrelated = max(2 * mosaic.deviation, 1.0)
    costs = SeamCost(mosaic).within(mosaic.places_of(list(where.cpu().numpy())))
    return sum(float(np.maximum(cost / unrelated - HARDLY, 0).sum()) for cost in costs) / where[0].numel()
