"""Whether a texture prefers directions: bricks lie and words run from left to right, pebbles look alike when turned."""

import math
from collections.abc import Sequence

import torch
from scipy import ndimage
from torch import Tensor

from kwatra.base import atan2, total
from kwatra.elements.correlation import pictures
from kwatra.elements.kept import kept
from kwatra.elements.size import LOOKED_AT, element_size
from kwatra.exemplar import Exemplar

HARMONICS = 6
"""Directions are compared with themselves turned by up to so many parts of a whole turn: hexagons have six."""

SCALES = (1.0, 1 / 12)
"""Edges are sought in pictures blurred by so many pixels, and by this share of an element, 1.5 px at least: of words
and of bricks with rough faces the fine edges run anywhere."""

_ROUNDING = 1e-12
"""Slopes with less of a picture's power are rounding."""

CHANCE = 4.0
"""What of a coefficient's square is taken for chance, in its variances: one of a texture without directions exceeds
that once in 55 times (exp -4). Of 16 pictures of made stones of 32 px, 128 px wide, 5 have more than .21 with 0, 2 with
3 and 1 with 4; of 52 pictures one falls below that, of stones in a wall that are a third of it wide."""


@kept
def direction_dependence(exemplar: Exemplar) -> float:
    """How much a still exemplar's edges prefer directions, 0 to 1; 0 for one without edges.

    Of all edges' directions, each counted with the square of its strength, it is the largest of the first six Fourier
    coefficients around the circle, and the larger one of two scales: the first is large where light falls from a side,
    the second where lines run one way, the fourth for a grid, the sixth for hexagons. Of few elements each is large by
    chance, but differs from one element to the next: its variance is told from squares as large as an element, and
    what chance makes is taken off. Of one square alone it is believed as it is. Pictures of more than `LOOKED_AT`
    pixels are looked at coarser, as for the size of their elements.
    """
    exemplar, _ = exemplar.halved_to(LOOKED_AT)
    size = element_size(exemplar)
    return max(_largest(exemplar, sigma, size) for sigma in (SCALES[0], max(SCALES[1] * size, 1.5)))


def _largest(exemplar: Exemplar, sigma: float, size: float) -> float:
    """The largest of the coefficients beyond chance, of edges in pictures blurred by sigma px, elements of a size."""
    sums, power = [torch.zeros(1 + 2 * HARMONICS, 1, dtype=torch.float64)], 0.0
    for picture, present in pictures(exemplar):
        if picture.ndim > 3:
            continue
        down, right, inside = slopes(picture, present, sigma)
        down, right = down[:, inside].double(), right[:, inside].double()
        square, angle = down.square() + right.square(), atan2(down, right)
        turned = [way(k * angle) for way in (torch.cos, torch.sin) for k in range(1, HARMONICS + 1)]
        number = _squares(present.shape, size)[inside]
        weights = [(square * part).sum(0) for part in (torch.ones((), dtype=torch.float32), *turned)]
        sums.append(torch.stack([torch.bincount(number, weight) for weight in weights]))
        power += float(total(picture.square()))
    strength, parts = torch.cat(sums, 1)[:1], torch.cat(sums, 1)[1:]
    parts, strength = parts[:, strength[0] > 0], strength[:, strength[0] > 0]
    whole = float(total(strength))
    if whole <= _ROUNDING * power:
        return 0.0
    share, count = parts.sum(1, keepdim=True) / whole, parts.shape[1]
    off = (parts - share * strength).square().sum(1) * count / max(count - 1, 1) / whole**2
    beyond = share[:, 0].square() - CHANCE * off
    return float(beyond.view(2, HARMONICS).sum(0).max().clamp(min=0).sqrt())


def _squares(shape: Sequence[int], size: float) -> Tensor:
    """The number (H, W) of the square, about so many px wide, in which each pixel of a picture lies."""
    rows, columns = (max(round(side / size), 1) for side in shape)
    down, right = (torch.arange(side) * n // side for side, n in zip(shape, (rows, columns), strict=True))
    return down[:, None] * columns + right


def slopes(picture: Tensor, present: Tensor, sigma: float) -> tuple[Tensor, Tensor, Tensor]:
    """Derivatives (C, H, W) down and to the right of a picture blurred by sigma px, and where (H, W) they are whole."""
    reach = math.ceil(3 * sigma)
    down, right = (
        torch.from_numpy(ndimage.gaussian_filter(picture.numpy(), sigma, order=order, radius=reach, axes=(1, 2)))
        for order in ((1, 0), (0, 1))
    )
    inside = ndimage.minimum_filter(present.numpy(), 2 * reach + 1, mode="constant")
    return down, right, torch.from_numpy(inside) > 0
