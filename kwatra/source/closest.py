"""The nearest of many points, where the tensors are: a search for devices that faiss does not reach."""

import torch
from torch import Tensor

from kwatra.source.protocol import chunk


def closest(points: Tensor, wanted: Tensor, k: int) -> Tensor:
    """The numbers (N, k) of the points (M, D) nearest to each of those wanted (N, D), by exhaustive search.

    Memory: `chunk` distances, and the result.
    """
    lengths, found = points.square().sum(1), []
    for part in wanted.split(max(chunk(points.device) // len(points), 1)):
        squared = torch.addmm(lengths[None], part, points.T, alpha=-2)  # but for the length of what is wanted
        found.append(squared.topk(min(k, len(points)), 1, largest=False).indices)
    return torch.cat(found)
