"""Colors about the curve that an exemplar's colors lie on, so that what is mixed has colors that are there.

A flame is black, red, orange, yellow and white, along a curve; the mean of its black and its white is a gray that no
flame has. So a color is told by where it lies along the colors' first principal axis and by what it differs by,
across that axis, from the exemplar's mean color there; these are mixed. Where the colors lie on a line nothing changes.
"""

import numpy as np
import torch
from torch import Tensor

from kwatra import Exemplar
from kwatra.base import mean, principal_axes

_PARTS = 32
"""Places along the axis at which the mean color is found, with as many of the exemplar's pixels each. Not tuned."""

_SEEN = 1 << 20
"""Pixels from which it is found, about so many at most: a bound on time."""


class ColorCurve:
    """Colors (C, *S) as coordinates about an exemplar's curve, and back: C of them, the first along the axis."""

    def __init__(self, exemplar: Exemplar) -> None:
        known = exemplar.canvas[:, exemplar.owner >= 0].cpu()
        colors = known[:, :: max(known.shape[1] // _SEEN, 1)].double()
        self._axes = principal_axes(colors)
        along, *across = _turned(colors, self._axes)
        order = along.argsort(stable=True).tensor_split(min(_PARTS, len(along)))
        self._along = torch.stack([mean(along[part]) for part in order]).numpy()
        self._across = [torch.stack([mean(values[part]) for part in order]).numpy() for values in across]

    def of(self, colors: Tensor) -> Tensor:
        """The coordinates of colors (C, *S)."""
        turned = _turned(colors, self._axes)
        turned[1:] -= self._mean(turned[0])
        return turned

    def colors(self, coordinates: Tensor) -> Tensor:
        """The colors at coordinates (C, *S)."""
        across = coordinates[1:] + self._mean(coordinates[0])
        return _turned(torch.cat([coordinates[:1], across]), self._axes.T)

    def _mean(self, along: Tensor) -> Tensor:
        """The other coordinates (C - 1, *S) of the mean colors at places (*S) along the axis."""
        places = along.cpu().numpy()
        found = np.array([np.interp(places, self._along, values) for values in self._across])
        return torch.from_numpy(found.reshape(-1, *places.shape)).to(along)


def _turned(values: Tensor, axes: Tensor) -> Tensor:
    """Values (C, *S) along other axes, the rows of (C, C); the same bits for any number of threads."""
    rows = [[float(share) * channel for share, channel in zip(axis, values, strict=True)] for axis in axes]
    return torch.stack([torch.stack(row).sum(0) for row in rows])
