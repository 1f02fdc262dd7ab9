import itertools

import numpy as np
import pytest
import torch

from kwatra.pieces import Box, Mosaic, SeamCost, Sheet
from synth.quilting.placement import Placer, Rule


@pytest.mark.parametrize("periodic", [(False, False), (False, True)])
@pytest.mark.parametrize("apart", [None, (3, 2)])
def test_offsets_near_used_ones_are_taken(periodic, apart):
    mosaic = Mosaic([np.random.default_rng(0).random((1, 9, 8), dtype=np.float32)] * 2)
    sheet = Sheet(mosaic, (12, 10), periodic, SeamCost(mosaic))
    placer = Placer(sheet, Rule("whole", 1.0, (4, 4), apart=apart), torch.Generator().manual_seed(0))
    placer.used = {(0, (-4, 3)), (0, (6, 9)), (0, (2, -2)), (0, (40, 3)), (1, (0, 0))}
    span = Box((-3, -2), (10, 11))
    found = placer._taken(0, span)
    for row, column in itertools.product(range(10), range(11)):
        near = False
        for _, shift in sorted(placer.used - {(1, (0, 0))}):
            gaps = [abs(row - 3 - shift[0]), abs(column - 2 - shift[1])]
            gaps = [min(g % n, -g % n) if wraps else g for g, n, wraps in zip(gaps, sheet.shape, periodic, strict=True)]
            near |= all(gap < a for gap, a in zip(gaps, apart or (1, 1), strict=True))
        assert found[row, column] == near
    assert found.any()
