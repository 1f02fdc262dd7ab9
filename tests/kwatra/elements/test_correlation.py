"""Autocorrelations, against their definition lag by lag."""

import pytest
import torch
from torch import Tensor

from kwatra import Exemplar
from kwatra.elements.correlation import LEAST_OVERLAP, Correlation, of_colors


def picture(*shape: int) -> Tensor:
    return torch.rand(shape, generator=torch.Generator().manual_seed(3))


def by_definition(frames: list[Tensor], masks: list[Tensor], down: int, right: int) -> tuple[float, float]:
    """The correlation of what overlaps, of all channels and frames, at one lag, and on how many pixels."""
    products, pixels = torch.zeros(3, dtype=torch.double), 0
    for frame, mask in zip(frames, masks, strict=True):
        places = mask.nonzero()
        further = places + torch.tensor([down, right])
        there = ((further >= 0) & (further < torch.tensor(mask.shape))).all(1)
        places, further = places[there], further[there]
        both = mask[*further.T]
        one, other = (frame[:, *at[both].T] for at in (places, further))
        one, other = (part - part.mean(1, keepdim=True) for part in (one, other))
        products += torch.stack([(one * other).sum(), one.square().sum(), other.square().sum()])
        pixels += int(both.sum())
    return float(products[0] / (products[1] * products[2]).sqrt()), float(pixels)


@pytest.mark.parametrize("shape", [(1, 14, 19), (3, 15, 12), (2, 3, 12, 13)])
@pytest.mark.parametrize("hole", [False, True])
def test_a_lag_has_the_correlation_of_what_overlaps(shape: tuple[int, ...], hole: bool) -> None:
    image, mask = picture(*shape), torch.ones(shape[1:], dtype=torch.bool)
    if hole:
        mask[..., 2:6, 3:9] = False
    images, masks = [image], [mask]
    if image.ndim == 3:  # a smaller picture beside it, which has fewer lags
        images.append(picture(shape[0], 8, 9))
        masks.append(torch.ones(8, 9, dtype=torch.bool))
    found = of_colors(Exemplar.of(images, masks=masks))
    frames = [frame.double() for one in images for frame in one.reshape(shape[0], -1, *one.shape[-2:]).unbind(1)]
    masks = [frame for one in masks for frame in one.reshape(-1, *one.shape[-2:])]
    for down, right in [(0, 0), (1, 0), (0, -4), (-3, 2), (5, 6), (found.reach[0], -found.reach[1])]:
        at = found.reach[0] + down, found.reach[1] + right
        value, overlap = by_definition(frames, masks, down, right)
        assert float(found.value[at]) == pytest.approx(value, abs=1e-9)
        assert float(found.overlap[at]) == overlap
    assert found.reach == tuple(int((1 - LEAST_OVERLAP) * side) for side in shape[-2:])


def test_means_by_distance_weigh_by_overlap_and_by_nearness_to_whole_distances():
    found = Correlation(torch.tensor([[0.2, 0.6, 1.0]]), torch.tensor([[1.0, 3.0, 2.0]]))
    mean, overlap = found.mean_by(torch.tensor([[0.0, 0.25, 2.0]]), 3)
    assert overlap.tolist() == pytest.approx([1 + 2.25, 0.75, 2])
    assert mean.tolist() == pytest.approx([(0.2 + 2.25 * 0.6) / 3.25, 0.6, 1.0])
    assert found.mean_by(torch.tensor([[0.0, 0.25, 2.0]]), 1)[0].shape == (1,)


def test_what_hardly_overlaps_is_not_trusted():
    found = Correlation(torch.tensor([[0.5, 1.0, 0.5]]), torch.tensor([[0.9, 10.0, 1.0]])).trusted()
    assert (found.value.tolist(), found.overlap.tolist()) == ([[0.0, 1.0, 0.5]], [[0.0, 10.0, 1.0]])
