"""Whether a texture prefers directions: bricks lie and words run from left to right, pebbles look alike when turned."""

import math

import torch
from scipy import ndimage
from torch import Tensor

from kwatra.base import total
from kwatra.elements.correlation import pictures
from kwatra.elements.kept import kept
from kwatra.elements.size import element_size
from kwatra.exemplar import Exemplar

HARMONICS = 6
"""Directions are compared with themselves turned by up to so many parts of a whole turn: hexagons have six."""

SCALES = (1.0, 1 / 12)
"""Edges are sought in pictures blurred by so many pixels, and by this share of an element, 1.5 px at least: of words
and of bricks with rough faces the fine edges run anywhere."""


_ROUNDING = 1e-12
"""Slopes with less of a picture's power are rounding."""


@kept
def direction_dependence(exemplar: Exemplar) -> float:
    """How much a still exemplar's edges prefer directions, 0 to 1; 0 for one without edges.

    Of all edges' directions, each counted with the square of its strength, it is the largest of the first six Fourier
    coefficients around the circle, and the larger one of two scales: the first is large where light falls from a side,
    the second where lines run one way, the fourth for a grid, the sixth for hexagons. So few elements as twenty have
    about .15 by chance.
    """
    sigmas = SCALES[0], max(SCALES[1] * element_size(exemplar), 1.5)
    return max(_largest(exemplar, sigma) for sigma in sigmas)


def _largest(exemplar: Exemplar, sigma: float) -> float:
    """The largest of the coefficients, of edges in pictures blurred by sigma px."""
    sums, strength, power = torch.zeros(2, HARMONICS, dtype=torch.float64), 0.0, 0.0
    order = torch.arange(1, HARMONICS + 1, dtype=torch.float64).view(-1, 1)
    for picture, present in pictures(exemplar):
        if picture.ndim > 3:
            continue
        down, right, inside = _slopes(picture, present, sigma)
        square = (down.square() + right.square())[:, inside].flatten()
        turn = order * torch.atan2(down[:, inside].flatten(), right[:, inside].flatten())
        sums += torch.stack([(turn.cos() * square).sum(1), (turn.sin() * square).sum(1)])
        strength, power = strength + float(total(square)), power + float(total(picture.square()))
    return float(sums.square().sum(0).sqrt().max()) / strength if strength > _ROUNDING * power else 0.0


def _slopes(picture: Tensor, present: Tensor, sigma: float) -> tuple[Tensor, Tensor, Tensor]:
    """Derivatives (C, H, W) down and to the right of a picture blurred by sigma px, and where (H, W) they are whole."""
    reach = math.ceil(3 * sigma)
    down, right = (
        torch.from_numpy(ndimage.gaussian_filter(picture.numpy(), sigma, order=order, radius=reach, axes=(1, 2)))
        for order in ((1, 0), (0, 1))
    )
    inside = ndimage.minimum_filter(present.numpy(), 2 * reach + 1, mode="constant")
    return down, right, torch.from_numpy(inside) > 0
