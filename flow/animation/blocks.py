"""The exemplar's square blocks, searched for those that agree with what is known of given ones.

Agreement is the squared difference over the known pixels, for every place at once by correlation, as in entire-patch
matching (thesis section 3.2).
"""

import numpy as np
import torch
from torch import Tensor

from kwatra import Exemplar
from kwatra.base import InputError, mean
from kwatra.pieces import Fit, box_sums


class Blocks:
    """Blocks of `size` x `size` px, halved until one fits into the exemplar."""

    def __init__(self, exemplar: Exemplar, size: int) -> None:
        while size > 2 and not bool(exemplar.corners((size, size)).any()):
            size = max(size // 2, 2)
        if size < 2 or not bool(exemplar.corners((size, size)).any()):
            raise InputError("no 2x2 block fits into the exemplar; its mask leaves too little to copy from")
        self.size = size
        self._valid = exemplar.corners((size, size)).cpu().numpy()
        self._root = exemplar.share.sqrt()
        known = exemplar.owner >= 0
        self._middle = torch.stack([mean(channel[known]) for channel in exemplar.canvas]).view(-1, 1, 1)
        self._fit = Fit(self._scaled(torch.where(known, exemplar.canvas, self._middle)))

    def _scaled(self, colors: Tensor) -> np.ndarray:
        scaled: np.ndarray = ((colors - self._middle) * self._root).double().cpu().numpy()
        return scaled

    def nearest(self, content: Tensor, known: Tensor, used: Tensor, generator: torch.Generator) -> Tensor:
        """Corners (n, 2), x first, of the blocks nearest to contents (n, C, size, size) where known (n, 1, size, size).

        known weighs the pixels, >= 0; of a block of which nothing is known any may come. used: what each pixel of the
        canvas costs, as a mean square difference.
        """
        places = np.argwhere(self._valid)
        again = box_sums(used.double().cpu().numpy(), (self.size, self.size)) / self.size**2
        weights = known[:, 0].double().cpu().numpy()
        pick = iter(torch.randint(len(places), (int((weights.max((1, 2)) == 0).sum()),), generator=generator).tolist())
        found = []
        for block, weight in zip(content, weights, strict=True):
            if weight.max() == 0:
                found.append(places[next(pick)])
                continue
            cost = self._fit.inside(self._scaled(block), weight) + weight.sum() * again
            found.append(np.unravel_index(np.where(self._valid, cost, np.inf).argmin(), cost.shape))
        return torch.from_numpy(np.array(found)).flip(1).to(content.device)
