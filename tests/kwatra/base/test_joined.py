"""Regions of joined pixels, beside those that scipy finds."""

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from kwatra.base import joined


@pytest.mark.parametrize("share", [0.0, 0.3, 0.5, 0.6, 1.0])
@pytest.mark.parametrize("shape", [(17, 23), (1, 9), (9, 1), (1, 1)])
def test_regions_are_those_of_a_graph_in_the_order_of_their_first_pixels(shape: tuple[int, int], share: float) -> None:
    rng, pixel = np.random.default_rng(3), np.arange(shape[0] * shape[1]).reshape(shape)
    down, right = (rng.random(np.diff(pixel, axis=axis).shape) < share for axis in range(2))
    one = np.concatenate([pixel[:-1][down], pixel[:, :-1][right]])
    other = np.concatenate([pixel[1:][down], pixel[:, 1:][right]])
    graph = sparse.coo_matrix((np.ones(len(one)), (one, other)), (pixel.size,) * 2)
    wanted, of = connected_components(graph, directed=False)
    count, number = joined(down, right)
    assert count == wanted
    first, ranked = np.unique(number, return_index=True)
    assert np.array_equal(first, np.arange(count))
    assert (np.diff(ranked) > 0).all()
    assert len(np.unique(np.stack([number.ravel(), of]), axis=1).T) == count
