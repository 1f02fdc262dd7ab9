"""Histogram matching: a step between iterations that keeps an image's colors in the exemplar's distribution.

The blend averages and so pulls colors towards the mean; giving each channel the exemplar's sorted values undoes that.
Pass `match_histogram` as `between` to `kwatra.optimize`. Blocks that were copied need it little.
"""

import torch
from torch import Tensor

from kwatra.base import InputError
from kwatra.step import Step


def match_histogram(image: Tensor, step: Step) -> Tensor:
    """The image (C, *S) with each channel's values replaced, by rank, with quantiles of the exemplar's.

    Pixels behind the mask stay as they are and have no rank. Raises InputError where windows come from no exemplar.
    """
    exemplar = step.exemplar
    if exemplar is None:
        raise InputError("a histogram is matched with an exemplar's, but windows come from none; leave it out")
    inside = torch.ones_like(image[0], dtype=torch.bool) if step.mask is None else step.mask
    values = image[:, inside]
    wanted = exemplar.canvas[:, exemplar.owner >= 0].sort(1).values
    order = values.argsort(dim=1, stable=True)
    quantile = (
        torch.linspace(0, wanted.shape[1] - 1, order.shape[1], dtype=torch.float32, device=image.device).round().long()
    )
    matched = image.clone()
    matched[:, inside] = torch.empty_like(values).scatter_(1, order, wanted[:, quantile])
    return matched
