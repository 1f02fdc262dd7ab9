import itertools

import numpy as np
import pytest

from kwatra.pieces import Box, Mosaic, Patch, SeamCost, Sheet
from kwatra.pieces.sheet.stations import Stations


@pytest.mark.parametrize("wraps", [(False, False), (True, False), (True, True)])
def test_regions_are_filled_as_their_pixels_are_however_often_that_was_asked_for(wraps):
    rng = np.random.default_rng(1)
    mosaic = Mosaic([rng.random((1, 30, 30), dtype=np.float32)])
    sheet, extent = Sheet(mosaic, (17, 19), wraps, SeamCost(mosaic)), (5, 4)
    stations = Stations(sheet, extent)
    assert [list(line[:3]) for line in stations.lines] == [[0, 2, 4], [0, 2, 4]]
    assert [line[-1] for line in stations.lines] == [16 if wraps[0] else 12, 18 if wraps[1] else 15]
    assert (stations.counts() == 0).all()
    for _ in range(6):
        start = [int(rng.integers(n if w else n - 6)) for n, w in zip(sheet.shape, wraps, strict=True)]
        sheet.lay(Patch(0, (0, 0), Box(tuple(start), (6, 3)).clipped(sheet.shape, wraps)))
        corners = itertools.product(*stations.lines)
        filled = [sheet.filled_at(sheet.indices(Box(corner, extent))).sum() for corner in corners]
        assert list(stations.counts().ravel()) == filled
