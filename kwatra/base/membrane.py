"""A surface over part of a picture or video that rises by given steps from pixel to pixel, drawn to 0 elsewhere.

It minimizes the sum over pairs of neighbors of (c_next - c_here - step)^2, and of c^2 / reach^2 over all pixels: what
is added to colors so that they go on across seams (Perez, Gangnet and Blake 2003, "Poisson Image Editing").
"""

from collections.abc import Sequence

import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base.solver import conjugate_gradients


def membrane(
    free: Tensor, pairs: Sequence[Tensor], steps: Sequence[Tensor], reach: float, fixed: Tensor | None = None
) -> Tensor:
    """The surface (C, *S) where pixels are free, 0 elsewhere.

    free: boolean (*S). pairs: for each axis (*S) of 0 and 1, whether a pixel goes together with the next along it,
    the last with the first. steps: for each (C, *S), by how much it rises to that. reach: px, over how many steps are
    spread. fixed (C, *S): its values where pixels are not free; 0 by default.
    """
    flows = [pair * step for pair, step in zip(pairs, steps, strict=True)]
    pulls = [flow - flow.roll(1, axis) for axis, flow in enumerate(flows, 1)]
    count = torch.stack([pair + pair.roll(1, axis) for axis, pair in enumerate(pairs)]).sum(0)
    right = -sum(pulls[1:], pulls[0])
    if fixed is not None:
        held = torch.where(free, 0.0, fixed)
        for axis, pair in enumerate(pairs, 1):
            right += pair * held.roll(-1, axis) + (pair * held).roll(1, axis)
    places = free.flatten().nonzero()[:, 0]
    diagonal, neighbors = count.flatten()[places] + 1 / reach**2, _neighbors(free.shape, places, pairs)

    def system(surface: Tensor) -> Tensor:
        beside = F.pad(surface, (0, 1))  # the last, 0, where a neighbor is not free, or none
        image = diagonal * surface
        for one in neighbors:
            image -= beside.index_select(1, one)
        return image

    right = right.flatten(1)[:, places]
    found = conjugate_gradients(system, right, diagonal, torch.zeros_like(right), 1e-3).x
    return torch.zeros_like(flows[0]).flatten(1).index_copy(1, places, found).view_as(flows[0])


def every_pair(shape: Sequence[int], closed: Sequence[bool] = ()) -> list[Tensor]:
    """For each axis (*S) 1 where a pixel has a next along it: the last the first, of axes that are closed."""
    pairs = [torch.ones(tuple(shape), dtype=torch.float32) for _ in shape]
    for axis, (pair, wraps) in enumerate(zip(pairs, closed or [False] * len(pairs), strict=True)):
        if not wraps:
            pair.select(axis, -1).zero_()
    return pairs


def _neighbors(shape: Sequence[int], places: Tensor, pairs: Sequence[Tensor]) -> Tensor:
    """Which of the free pixels (N,), flat numbers, go together with each, two along each axis; N where none does."""
    number = torch.full(tuple(shape), len(places))
    number.view(-1)[places] = torch.arange(len(places))
    beside = []
    for axis, pair in enumerate(pairs):
        for step in (1, -1):
            joined = (pair if step > 0 else pair.roll(1, axis)) > 0
            beside.append(torch.where(joined, number.roll(-step, axis), len(places)).flatten()[places])
    return torch.stack(beside)
