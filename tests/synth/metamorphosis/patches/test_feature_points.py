"""Feature pixels thinned: few, even, the same ones in patches that overlap."""

import pytest
import torch

from kwatra import InputError
from synth.metamorphosis.patches.feature_points import feature_points


def some_map() -> torch.Tensor:
    down, across = torch.meshgrid(torch.arange(40), torch.arange(60), indexing="ij")
    return (((down - 20) ** 2 + (across - 30) ** 2).float().sqrt() % 9 < 2) & (across < 50)


def test_points_are_feature_pixels_of_their_patch():
    features, corners = some_map(), torch.tensor([[0, 0], [3, 27], [23, 40], [5, 43]])
    points = feature_points(features, corners, 17, 300)
    for corner, places, there in zip(corners, *points, strict=True):
        inside = features[corner[0] : corner[0] + 17, corner[1] : corner[1] + 17]
        found = torch.zeros_like(inside)
        x, y = places[there].long().unbind(1)
        found[y, x] = True
        assert torch.equal(found, inside)
        assert int(there.sum()) == int(inside.sum())
        assert float(places[~there].abs().sum()) == 0


def test_few_points_are_spread_evenly():
    """No feature pixel is far from a point, and no two points are near; a grid of as many could do little better."""
    features = torch.ones(64, 64, dtype=torch.bool)
    places, there = feature_points(features, torch.tensor([[0, 0], [31, 20]]), 33, 30)
    pixels = torch.cartesian_prod(torch.arange(33.0), torch.arange(33.0))
    assert bool(there.all())
    for patch in places:
        apart = torch.cdist(patch, patch) + 100 * torch.eye(30)
        assert float(apart.min()) > 3.5
        assert float(torch.cdist(pixels, patch).amin(1).max()) < 8


def test_patches_that_overlap_agree_and_most_is_kept():
    features = some_map()
    first, second = feature_points(features, torch.tensor([[2, 4], [4, 5]]), 33, 20).places + torch.tensor(
        [[[4.0, 2.0]], [[5.0, 4.0]]]
    )
    shared = (torch.cdist(first, second) == 0).sum()
    assert int(shared) >= 16
    few, many = (feature_points(features, torch.tensor([[2, 4]]), 33, most) for most in (10, 20))
    assert few.places.shape == (1, 10, 2)
    assert torch.equal(few.places, many.places[:, :10])


def test_no_feature_is_no_point():
    points = feature_points(torch.zeros(20, 20, dtype=torch.bool), torch.tensor([[0, 0], [3, 3]]), 17, 8)
    assert not bool(points.there.any())
    assert points.places.shape == (2, 8, 2)
    with pytest.raises(InputError, match=r"shape \(20, 20\) and type torch.float32; give booleans"):
        feature_points(torch.zeros(20, 20), torch.tensor([[0, 0]]), 17, 8)
    with pytest.raises(InputError, match="at least 33x33"):
        feature_points(torch.zeros(20, 20, dtype=torch.bool), torch.tensor([[0, 0]]), 33, 8)
