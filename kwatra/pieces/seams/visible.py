"""How much of the seams is seen where an exemplar was copied together, and where less is of two ways to do that."""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from kwatra.base import continued
from kwatra.exemplar import Exemplar
from kwatra.pieces.seams.cost import SeamCost
from kwatra.pieces.seams.keeping import cheaper
from kwatra.pieces.seams.mosaic import Mosaic

HARDLY = 0.1
"""Seams are hardly seen that cost less than this part of one between unrelated pixels."""


def visible_seams(exemplar: Exemplar, where: Tensor) -> float:
    """The cost of visible seams per pixel of a source map (n, *S), 0 for none.

    1 is what a seam between unrelated pixels costs: twice the deviation of each channel.
    """
    mosaic = _mosaic(exemplar)
    unrelated = max(2 * mosaic.deviation, 1.0)
    costs = SeamCost(mosaic).within(mosaic.places_of(list(where.cpu().numpy())))
    return sum(float(np.maximum(cost / unrelated - HARDLY, 0).sum()) for cost in costs) / where[0].numel()


def less_seen(exemplar: Exemplar, before: Tensor, after: Tensor, wraps: Sequence[bool] = ()) -> Tensor:
    """Where (boolean, *S) to go over from a source map (n, *S) to a later one, so that seams cost least.

    wraps: along which axes they are periodic; none by default. Memory: some arrays of the output's size.
    """
    mosaic = _mosaic(exemplar)
    earlier, later = (mosaic.places_of(list(where.cpu().numpy())) for where in (before, after))
    return torch.from_numpy(cheaper(SeamCost(mosaic), earlier, later, wraps)).to(before.device)


def _mosaic(exemplar: Exemplar) -> Mosaic:
    """The exemplar's colors, each channel by its share."""
    return Mosaic([(continued(exemplar.canvas, exemplar.owner).cpu() * exemplar.share.cpu()).numpy()])
