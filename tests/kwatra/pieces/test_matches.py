"""The matching cost of a window's pairs, compiled, against its definition."""

import numpy as np
import pytest

from kwatra.pieces.mosaic import Mosaic
from kwatra.pieces.stock import Stock


@pytest.mark.parametrize("shape", [(7, 9), (1, 6), (4, 5, 6)])
def test_compiled_matches_are_those_of_any_stock(shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(len(shape))
    mosaic = Mosaic([rng.random((3, *shape)), rng.random((3, *shape))])
    old, new = rng.integers(0, mosaic.planes.shape[1], (2, *(2 * n for n in shape))).astype(mosaic.place_type)
    found, expected = mosaic.matches(old, new), Stock.matches(mosaic, old, new)
    assert len(found) == len(shape)
    for one, other in zip(found, expected, strict=True):
        for a, b in zip(one, other, strict=True):
            assert a.dtype == b.dtype
            np.testing.assert_array_equal(a, b)


def test_a_match_is_the_sum_of_what_differs_at_both_pixels() -> None:
    image = np.array([[[0.0, 1.0, 4.0, 9.0]]])
    mosaic = Mosaic([image])
    old, new = (mosaic.places_of([np.zeros((1, 2), int), np.array([line])]) for line in ([0, 1], [2, 3]))
    only_second, only_first = mosaic.matches(old, new)[1]
    values = mosaic.planes[0][mosaic.places_of([np.zeros(4, int), np.arange(4)])].astype(int)
    differs = abs(values[0] - values[2]) + abs(values[1] - values[3])
    assert only_second.item() == only_first.item() == differs
