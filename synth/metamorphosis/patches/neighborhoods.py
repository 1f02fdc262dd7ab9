"""Neighborhoods of several textures, matched, warped onto each other and blended (Ruiters et al. 2010, section 4.2).

A neighborhood has an anchor: a window of one texture. In each other texture it has a partner, a window whose features
lie alike, and thin-plate splines there and back. With weights w_k of the textures, summing to 1, the one in between is

    N(x) = sum_j w_j I_j(x + u_j(x)),   u_j = (1 - w_j) there_j + sum_(k != j) w_k back_k

where there_j displaces the anchor's features onto those of its partner in texture j, back_k those of the partner in
texture k onto the anchor's, and both are 0 for the anchor's own texture. Of two textures that is the paper's equation;
of more, displacements from one partner to another go by way of the anchor, and add.

Textures whose elements differ in size are brought to a common scale first; what lies in between has a size in between.
The paper hopes for that as future work (section 5).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from flow import warp
from kwatra.source import CHUNK

Weights = tuple[float, ...]

NODES = 9
"""Nodes along each side of the lattice on which displacements are kept; between them they are interpolated."""

_SPAN = 1.5
"""How many times wider than the window the lattice is: at another scale windows see more than their own."""


@dataclass(frozen=True)
class Neighborhoods:
    """N neighborhoods of n textures at one resolution.

    width: of windows, odd, in pixels of that resolution. units (n): how many pixels of a texture make one of the common
    scale. anchor (N,): the texture of each anchor. centers (N, n, 2): the middle pixel, row and column, of each
    anchor and its partners in their own textures. there, back (N, n, NODES^2, 2): displacements at the nodes of
    `lattice`, in pixels of the common scale, x first; None: nothing is warped.
    """

    width: int
    units: tuple[float, ...]
    anchor: Tensor
    centers: Tensor
    there: Tensor | None = None
    back: Tensor | None = None

    def __len__(self) -> int:
        return len(self.anchor)

    def taken(self, numbers: Tensor) -> "Neighborhoods":
        """Those of these numbers (M,)."""
        there, back = (None if way is None else way[numbers] for way in (self.there, self.back))
        return replace(self, anchor=self.anchor[numbers], centers=self.centers[numbers], there=there, back=back)

    def scale(self, weights: Weights) -> float:
        """How much larger than at the common scale elements are in between: the geometric mean of the textures'."""
        logs = torch.tensor(self.units, dtype=torch.float64).log()
        return float((logs * torch.tensor(weights, dtype=torch.float64)).sum().exp())

    def parts(self, images: Sequence[Tensor], weights: Weights) -> Iterator[tuple[slice, Tensor]]:
        """What is blended: for bands of neighborhoods their windows in each texture, warped, (n, M, w, w, C).

        images: each texture (C, h, w) at this resolution.
        """
        offset = torch.arange(self.width, dtype=torch.float32) - (self.width - 1) / 2
        y, x = torch.meshgrid(offset, offset, indexing="ij")
        places = torch.stack([x, y], -1).reshape(-1, 2) / self.scale(weights)
        chunk = max(CHUNK // (len(places) * len(images[0])), 1)
        for first in range(0, len(self), chunk):
            part = slice(first, min(first + chunk, len(self)))
            moved = self._moved(part, places, weights)
            shape = (len(images[0]), part.stop - part.start, self.width, self.width)
            windows = []
            for image, unit, way, center in zip(images, self.units, moved, self.centers[part].unbind(1), strict=True):
                where = center.flip(1)[:, None] + unit * (places + way)
                windows.append(warp(image, where.reshape(-1, 2).T).view(shape).permute(1, 2, 3, 0))
            yield part, torch.stack(windows)

    def windows(self, images: Sequence[Tensor], weights: Weights) -> Tensor:
        """The neighborhoods in between, (N, w, w, C); images as for `parts`. Memory: the result, and bands."""
        shown = [number for number, weight in enumerate(weights) if weight > 0]
        share = torch.tensor(weights, dtype=torch.float32).view(-1, 1, 1, 1, 1).to(images[0])
        result = images[0].new_empty(len(self), self.width, self.width, len(images[0]))
        for part, windows in self.parts(images, weights):
            result[part] = windows[shown[0]] if len(shown) == 1 else (share * windows).sum(0)
        return result

    def _moved(self, part: slice, places: Tensor, weights: Weights) -> Tensor:
        """u_j of each texture at places (m, 2) from the middle of the window, common scale: (n, M, m, 2)."""
        if self.there is None or self.back is None or max(weights) == 1:
            return places.new_zeros(len(weights), part.stop - part.start, 1, 2)
        share = torch.tensor(weights, dtype=torch.float32).view(-1, 1, 1, 1).to(places)
        back = share * self.back[part].transpose(0, 1)
        moved = back.sum(0) - back + (1 - share) * self.there[part].transpose(0, 1)
        return (moved.transpose(2, 3) @ between_nodes(places, self.width)).transpose(2, 3)


def lattice(width: int) -> Tensor:
    """The nodes (NODES^2, 2) of displacements, in pixels from the middle of a window, x first."""
    line = torch.linspace(-0.5, 0.5, NODES, dtype=torch.float32) * _SPAN * width
    y, x = torch.meshgrid(line, line, indexing="ij")
    return torch.stack([x, y], -1).reshape(-1, 2)


def between_nodes(places: Tensor, width: int) -> Tensor:
    """How much each node of the lattice counts at places (m, 2), x first, from a window's middle: (NODES^2, m)."""
    nodes = torch.eye(NODES**2).to(places).view(NODES**2, NODES, NODES)
    return warp(nodes, (places.T / (_SPAN * width) + 0.5) * (NODES - 1))


def similarity(neighborhoods: Neighborhoods, images: Sequence[Tensor], feature_weight: float) -> Tensor:
    """How well the warped windows of each neighborhood fit to each other (N,): higher is better (section 4.2, end).

    The normalized cross-correlation of their colors less `feature_weight` times the mean difference of their
    distances, which are the last channel; a mean over pairs of textures, halfway between all.
    """
    count = len(images)
    found = torch.zeros(len(neighborhoods), dtype=torch.float32)
    for part, windows in neighborhoods.parts(images, (1 / count,) * count):
        flat = windows.flatten(2, 3)
        color = flat[..., :-1] - flat[..., :-1].mean(2, keepdim=True)
        color = color.flatten(2) / color.flatten(2).norm(dim=2, keepdim=True).clamp(min=1e-6)
        for one in range(count):
            for other in range(one):
                apart = (flat[one, ..., -1] - flat[other, ..., -1]).abs().mean(1)
                found[part] += (color[one] * color[other]).sum(1) - feature_weight * apart
    return found / max(count * (count - 1) // 2, 1)
