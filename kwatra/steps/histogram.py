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
    quantile = ranks(order.shape[1], wanted.shape[1]).to(image.device)
    matched = image.clone()
    matched[:, inside] = torch.empty_like(values).scatter_(1, order, wanted[:, quantile])
    return matched


def ranks(count: int, of: int) -> Tensor:
    """For each of `count` values in order the rank of the same quantile among `of` values: (count,) long, halves even.

    Exact for up to 2^26 values; in float32 they would end at 2^24.
    """
    places = torch.arange(count, dtype=torch.float64) * (of - 1)
    return (places / max(count - 1, 1)).round().long()
