"""Histogram matching: a step between iterations that keeps an image's colors in the exemplar's distribution.

The blend averages and so pulls colors towards the mean; giving each channel the exemplar's sorted values undoes that.
Pass `match_histogram` as `between` to `kwatra.optimize`. Blocks that were copied need it little.
"""

import torch
from torch import Tensor

from kwatra.exemplar import Exemplar


def match_histogram(image: Tensor, exemplar: Exemplar, mask: Tensor | None = None) -> Tensor:
    """The image (C, *S) with each channel's values replaced, by rank, with quantiles of the exemplar's.

    mask (*S): pixels where it is False have no rank and keep their values.
    """
    inside = torch.ones_like(image[0], dtype=torch.bool) if mask is None else mask
    values, wanted = image[:, inside], exemplar.canvas[:, exemplar.owner >= 0].sort(1).values
    order = values.argsort(dim=1, stable=True)
    quantile = torch.linspace(0, wanted.shape[1] - 1, order.shape[1], device=image.device).round().long()
    matched = image.clone()
    matched[:, inside] = torch.empty_like(values).scatter_(1, order, wanted[:, quantile])
    return matched
