import itertools

import numpy as np
import pytest
import torch

from kwatra.pieces import Box, Mosaic, Patch, SeamCost, Sheet
from kwatra.pieces.regions import Regions


@pytest.mark.parametrize("wraps", [(False, False), (True, False), (False, True)])
@pytest.mark.parametrize("seed", range(3))
def test_the_costliest_region_is_that_of_all_however_often_it_was_asked_for(wraps, seed):
    rng = np.random.default_rng(seed)
    mosaic = Mosaic([rng.random((1, 30, 30), dtype=np.float32)])
    sheet = Sheet(mosaic, (17, 19), wraps, SeamCost(mosaic))
    regions, extent = Regions(sheet, (5, 4), torch.Generator().manual_seed(seed)), (5, 4)
    assert regions.costliest() is None
    for _ in range(12):
        start = [int(rng.integers(n if w else n - 7)) for n, w in zip(sheet.shape, wraps, strict=True)]
        box = Box(tuple(start), (7, 7)).clipped(sheet.shape, wraps)
        sheet.lay(Patch(0, tuple(int(s) for s in start - rng.integers(0, 20, 2)), box), must=np.ones(box.extent, bool))
        found, costs = regions.costliest(), {}
        sides = zip(sheet.shape, extent, wraps, strict=True)
        for corner in itertools.product(*(range(n if w else n - e + 1) for n, e, w in sides)):
            costs[corner] = sum(int(seams[sheet.indices(Box(corner, extent))].sum()) for seams in sheet.seams)
            costs[corner] *= float(regions.tried[corner])
        if max(costs.values()) > 0:
            assert found == Box(max(costs, key=costs.__getitem__), extent)  # the first of equals
            regions.rest(found)
