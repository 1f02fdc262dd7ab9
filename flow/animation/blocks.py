"""The exemplar's square blocks, searched for those that agree with what is known of given ones.

Agreement is the squared difference over the known pixels, for every place at once by correlation, as in entire-patch
matching (thesis section 3.2): first at half the resolution, then around the best place at full resolution.
"""

import math

import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra import Exemplar
from kwatra.base import InputError
from kwatra.source import CHUNK
from kwatra.windows import channels_last, windows_at

_REACH = 2


class Blocks:
    """Blocks of `size` x `size` px, halved until one fits into the exemplar."""

    def __init__(self, exemplar: Exemplar, size: int) -> None:
        while size > 1 and not bool(exemplar.corners((size, size)).any()):
            size //= 2
        if size < 2:
            raise InputError("no 2x2 block fits into the exemplar; its mask leaves too little to copy from")
        self.size, self._exemplar = size, exemplar
        self._share = exemplar.share
        self._valid = exemplar.corners((size, size))
        self._pixels = channels_last(exemplar.canvas)
        coarse = exemplar.coarser((2, 2))
        self._coarse = coarse if size % 2 == 0 and bool(coarse.corners((size // 2, size // 2)).any()) else None

    def nearest(self, content: Tensor, known: Tensor, used: Tensor, generator: torch.Generator) -> Tensor:
        """Corners (n, 2), x first, of the blocks nearest to contents (n, C, size, size) where known (n, 1, size, size).

        known weighs the pixels, >= 0; of a block of which nothing is known any may come. used: what each pixel of the
        canvas costs, as a mean square difference. Memory: one value per canvas pixel for a few blocks at a time.
        """
        if self._coarse is None:
            found = self._best(self._exemplar, content, known, used)
        else:
            mass = F.avg_pool2d(known, 2)
            mean = F.avg_pool2d(content * known, 2) / mass.clamp(min=1e-12)
            place = self._best(self._coarse, mean, mass, F.avg_pool2d(used[None], 2)[0])
            found = self._refined(2 * place, content, known)
        blank = known.flatten(1).amax(1) == 0
        places = self._valid.nonzero()
        pick = torch.randint(len(places), (len(blank),), generator=generator).to(found.device)
        return torch.where(blank[:, None], places[pick], found).flip(1)

    def _best(self, exemplar: Exemplar, content: Tensor, known: Tensor, used: Tensor) -> Tensor:
        """Corners (n, 2), row first, of the best places at one resolution."""
        size = content.shape[-1]
        valid = exemplar.corners((size, size))
        square = (exemplar.canvas.square() * self._share).sum(0)[None, None]
        again = F.avg_pool2d(used[None], size, 1)[0]
        few = max(CHUNK // valid.numel(), 1)
        found = []
        for part, weight in zip(content.split(few), known.split(few), strict=True):
            cross = F.conv2d(exemplar.canvas[None], part * weight * self._share)[0]
            cost = F.conv2d(square, weight)[0] - 2 * cross + weight.sum((1, 2, 3))[:, None, None] * again
            found.append(_least(torch.where(valid, cost, math.inf)))
        return torch.cat(found)

    def _refined(self, corners: Tensor, content: Tensor, known: Tensor) -> Tensor:
        """The best places (n, 2), row first, within reach of given ones (n, 2)."""
        size = content.shape[-1]
        sides = torch.tensor(self._pixels.shape[:2], device=content.device)
        spans = [min(size + 2 * _REACH, int(side)) for side in sides]
        first = torch.minimum((corners - _REACH).clamp(min=0), sides - torch.tensor(spans, device=content.device))
        around = windows_at(self._pixels, first, (spans[0], spans[1])).movedim(-1, 1)
        cross = _correlated(around, content * known * self._share)
        cost = _correlated((around.square() * self._share).sum(1, keepdim=True), known) - 2 * cross
        rows = first[:, 0, None, None] + torch.arange(cost.shape[1], device=cost.device)[:, None]
        columns = first[:, 1, None, None] + torch.arange(cost.shape[2], device=cost.device)
        return first + _least(torch.where(self._valid[rows, columns], cost, math.inf))


def _least(costs: Tensor) -> Tensor:
    """Where the least of each of costs (n, h, w) is: (n, 2), row first."""
    place = costs.flatten(1).argmin(1)
    return torch.stack([place // costs.shape[2], place % costs.shape[2]], 1)


def _correlated(images: Tensor, kernels: Tensor) -> Tensor:
    """Inner products (n, h, w) of each image (n, C, H, W) with its own kernel (n, C, s, s)."""
    count = len(images)
    return F.conv2d(images.flatten(0, 1)[None], kernels, groups=count)[0]
