"""Autocorrelations, against their definition lag by lag."""

import pytest
import torch
from torch import Tensor

from kwatra import Exemplar
from kwatra.elements.correlation import LEAST_OVERLAP, of_colors


def picture(*shape: int) -> Tensor:
    return torch.rand(shape, generator=torch.Generator().manual_seed(3))


def by_definition(frames: list[Tensor], masks: list[Tensor], down: int, right: int) -> tuple[float, float]:
    """The correlation of what overlaps, of all channels and frames, at one lag, and on how many pixels."""
    inside = torch.cat([frame[:, mask] for frame, mask in zip(frames, masks, strict=True)], 1)
    middle, products, pixels = inside.mean(1)[:, None], torch.zeros(3, dtype=torch.double), 0
    for frame, mask in zip(frames, masks, strict=True):
        height, width = mask.shape
        rows, columns = (slice(max(-lag, 0), size - max(lag, 0)) for lag, size in ((down, height), (right, width)))
        further = tuple(
            slice(part.start + lag, part.stop + lag) for part, lag in zip((rows, columns), (down, right), strict=True)
        )
        both = mask[rows, columns] & mask[further]
        one, other = frame[:, rows, columns][:, both] - middle, frame[:, *further][:, both] - middle
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
    found = of_colors(Exemplar.of(image, masks=[mask]))
    frames = [*image.double().reshape(shape[0], -1, *shape[-2:]).unbind(1)]
    masks = [*mask.reshape(-1, *shape[-2:])]
    for down, right in [(0, 0), (1, 0), (0, -4), (-3, 2), (5, 6), (found.reach[0], -found.reach[1])]:
        at = found.reach[0] + down, found.reach[1] + right
        value, overlap = by_definition(frames, masks, down, right)
        assert float(found.value[at]) == pytest.approx(value, abs=1e-9)
        assert float(found.overlap[at]) == overlap
    assert found.reach == tuple(int((1 - LEAST_OVERLAP) * side) for side in shape[-2:])
