"""What terms wish of pixels, as laying blocks sees it."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor

from kwatra.base import total
from kwatra.exemplar import Exemplar
from kwatra.pieces.seams import Array, each
from kwatra.terms import Wish

MOST = 1000.0
"""What a pixel may miss of a wish, in variances; more counts as this, so that costs stay whole numbers of 32 bits."""


class Wished(NamedTuple):
    """Values that pixels should have, in the units in which blocks are compared, and how much that counts; (C, *S).

    share (C, 1, ...): how much each channel counts.
    """

    weight: Array
    value: Array
    share: Array

    @classmethod
    def of(cls, wish: Wish | None, middle: Tensor, root: Tensor) -> "Wished | None":
        """A wish whose values are taken relative to `middle` and times `root`, the root of the channels' share.

        None if nothing is wished for.
        """
        if wish is None or not bool((wish.weight > 0).any()):
            return None
        value = ((wish.value.cpu() - middle) * root).numpy()
        weight = np.broadcast_to(wish.weight.cpu().double().numpy(), value.shape)
        return cls(weight, value, root.square().numpy())

    @property
    def guides(self) -> Array:
        """Which channels (C,) are wished for everywhere: guidance, or an image that all should be like."""
        guides: Array = np.all(self.weight > 0, axis=tuple(range(1, self.weight.ndim)))
        return guides

    @property
    def everywhere(self) -> bool:
        """Whether something is wished for everywhere."""
        return bool(self.guides.any())

    @property
    def guided(self) -> bool:
        """Whether there are channels of guidance, beside those that are copied for what they look like."""
        return bool(self.guides.any() and not self.guides.all())

    def at(self, at: Any) -> tuple[Array, Array, float]:
        """Weights and values (C, *E) at some pixels (open mesh), and how many pixels that counts as."""
        weight, value = self.weight[each(at)], self.value[each(at)]
        return weight, value, float((np.where(weight > 0, np.maximum(weight, 1), 0) * self.share).sum())

    def anything(self, at: Any) -> bool:
        """Whether anything is wished for at some pixels."""
        return bool((self.weight[each(at)] > 0).any())

    def missed(self, at: Any, shown: Array, variance: float) -> Array:
        """What each of some pixels misses that shows colors (C, *E), in variances."""
        weight, value = self.weight[each(at)], self.value[each(at)]
        missed: Array = ((weight * (shown - value) ** 2).sum(0) / variance).clip(max=MOST)
        return missed


def unguided(exemplar: Exemplar, wish: Wished | None) -> Exemplar:
    """The exemplar without channels of guidance, which says where a texture goes, not what it looks like."""
    if wish is None or not wish.guided:
        return exemplar
    seen = torch.from_numpy(~wish.guides).to(exemplar.canvas.device)
    return replace(exemplar, canvas=exemplar.canvas[seen], weights=exemplar.weights[seen])


def variance(exemplar: Exemplar, wish: Wished | None) -> float:
    """The variance of what is copied, guidance left out."""
    each_channel = exemplar.variances.cpu() * exemplar.share.cpu().flatten()
    if wish is not None and not wish.guides.all():
        each_channel = each_channel[torch.from_numpy(~wish.guides)]
    return max(float(total(each_channel)), 1e-8)
