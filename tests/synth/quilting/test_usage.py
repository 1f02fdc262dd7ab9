import numpy as np
import pytest

from kwatra.pieces import Box, Mosaic, Patch, SeamCost, Sheet
from synth.quilting.usage import Usage


@pytest.mark.parametrize("wraps", [(False, False), (True, False)])
def test_usage_is_that_of_all_that_is_shown_however_often_it_was_asked_for(wraps):
    rng = np.random.default_rng(0)
    mosaic = Mosaic([rng.random((1, 30, 30), dtype=np.float32), rng.random((1, 24, 28), dtype=np.float32)])
    sheet = Sheet(mosaic, (17, 19), wraps, SeamCost(mosaic))
    sheet.lay(Patch(0, (-3, -4), Box((2, 3), (4, 5))))
    usage, area = Usage(sheet), 30 * 30 + 24 * 28
    for number in (0, 1, 1, 0, 1):
        start = [int(rng.integers(n if w else n - 7)) for n, w in zip(sheet.shape, wraps, strict=True)]
        shift = tuple(int(s) for s in start - rng.integers(0, 15, 2))
        sheet.lay(Patch(number, shift, Box(tuple(start), (7, 7)).clipped(sheet.shape, wraps)))
        found = usage.relative()
        source, at = mosaic.coordinates(sheet.places[sheet.filled])
        for k, shape in enumerate(mosaic.shapes):
            count = np.zeros(shape)
            np.add.at(count, tuple(at[:, source == k]), 1)
            assert np.allclose(found[k], count / (np.count_nonzero(sheet.filled) / area), rtol=1e-6)
    assert found[1].max() > 0
