"""What is known of several textures before any frame is made: their neighborhoods, matched and warped, by level."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import torch
from torch import Tensor

from kwatra.base import InputError, generator_of
from kwatra.source import Bag
from kwatra.windows import channels_last, windows_at
from synth.metamorphosis.patches.centers import CELLS
from synth.metamorphosis.patches.correspondence import nearest, transported
from synth.metamorphosis.patches.feature_points import feature_points
from synth.metamorphosis.patches.neighborhoods import Neighborhoods, Weights, lattice, similarity
from synth.metamorphosis.patches.point_matching import match
from synth.metamorphosis.patches.textures import Texture
from synth.metamorphosis.recolor import Colors, barycenter, recolored

ANCHORS = 2000
"""So many windows of each texture are anchors, at most."""

_FEWEST = 100
"""No texture has fewer anchors at a level."""

LARGEST_BAG = 6 * 10**7
"""Values in the windows of a level, 240 MB: where many weightings are told apart, there are fewer anchors."""


@dataclass(frozen=True)
class Making:
    """How neighborhoods are made.

    feature_weight: what the distance to features counts beside all colors together. transport: partners by optimal
    transport, or else nearest ones. partners: so many each window has in another texture, k of section 4.1; with more,
    more should be rejected. warped: features are moved onto each other. scaled: elements are brought to one size.
    anchors: so many windows of each texture are, at most. cells: windows of pictures that lead into each other lie so
    many times closer together than they are wide. points: so many of a window's features are matched, at most.
    """

    feature_weight: float = 1.0
    transport: bool = True
    partners: int = 1
    warped: bool = True
    scaled: bool = True
    anchors: int = ANCHORS
    cells: int = CELLS
    points: int = 32

    def bounded(self, textures: int, channels: int, width: int, weightings: int) -> "Making":
        """These with so few anchors that the windows of so many weightings fit into memory."""
        values = width**2 * (channels + 1 + textures) * self.partners * textures * weightings
        return replace(self, anchors=min(self.anchors, max(LARGEST_BAG // values, _FEWEST)))


@dataclass(frozen=True)
class Matched:
    """Neighborhoods of one level (how many times coarser, and how wide windows are), and the textures they are of."""

    level: tuple[int, int]
    feature_weight: float
    textures: tuple[Texture, ...]
    neighborhoods: Neighborhoods
    colors: tuple[Colors, ...]

    def kept(self, weights: Weights, rejected: float) -> Tensor:
        """The numbers (K,) of neighborhoods, without those of each texture that fit worst.

        rejected: their share halfway between all textures; where one has all the weight none is left out.
        """
        left_out = rejected * (1 - max(weights)) / (1 - 1 / len(weights))
        if left_out == 0:
            return torch.arange(len(self.neighborhoods))
        return _best(self.neighborhoods.anchor, self._fit, 1 - left_out)

    @cached_property
    def _fit(self) -> Tensor:
        """How well each neighborhood fits (N,): see `similarity`."""
        count = len(self.textures)
        return similarity(self.neighborhoods, self.shown((1 / count,) * count), self.feature_weight)

    def shown(self, weights: Weights) -> list[Tensor]:
        """The textures (C + 1, h, w) with the colors of those in between, and distances."""
        target = barycenter(self.colors, weights)
        return [
            torch.cat([recolored(texture.image, own, target).clamp(0, 1), texture.distance])
            for texture, own in zip(self.textures, self.colors, strict=True)
        ]

    def windows(self, numbers: Tensor, weights: Weights) -> Tensor:
        """The neighborhoods of these numbers (M,) in between, (M, w, w, C + 1): colors and distance."""
        return self.neighborhoods.taken(numbers).windows(self.shown(weights), weights)


def matched(
    images: Sequence[Tensor], maps: Sequence[Tensor], units: Sequence[float], level: tuple[int, int], making: Making
) -> Matched:
    """The neighborhoods of a level of textures (C, H, W) with feature maps (H, W)."""
    factor, width = level
    textures = tuple(Texture.of(i, m, u, factor) for i, m, u in zip(images, maps, units, strict=True))
    colors = tuple(Colors.of(image) for image in images)
    middle = barycenter(colors, (1 / len(images),) * len(images))
    common = [texture.common() for texture in textures]
    shown = [
        torch.cat([recolored(texture.image, own, middle), texture.distance])
        for texture, own in zip(common, colors, strict=True)
    ]
    corners = [_anchors(tuple(image.shape[1:]), width, making.anchors) for image in shown]
    bags = [_bag(image, at, width, making.feature_weight) for image, at in zip(shown, corners, strict=True)]
    partners = _partners(bags, making.transport, min(making.partners, *map(len, corners)))
    anchor = torch.cat([torch.full((len(row[0]),), number) for number, row in enumerate(partners)])
    centers = torch.cat([_centers(row, textures, corners, width) for row in partners])
    first = [torch.stack([at[own] for at, own in zip(corners, row, strict=True)], 1) for row in partners]
    there, back = bends(common, first, width, making)
    found = Neighborhoods(width, tuple(units), anchor, centers, there, back)
    return Matched(level, making.feature_weight, textures, found, colors)


def _anchors(shape: tuple[int, ...], width: int, most: int) -> Tensor:
    """First pixels (N, 2) of at most `most` windows, evenly spread, and the outermost."""
    if min(shape) < width:
        raise InputError(
            f"windows are {width} px wide but a texture at the common scale is {shape[1]}x{shape[0]}; give larger ones"
        )
    rows, columns = (size - width + 1 for size in shape)
    step = 1
    while math.prod(-(-(count - 1) // step) + 1 for count in (rows, columns)) > most:
        step += 1
    lines = (torch.cat([torch.arange(0, count - 1, step), torch.tensor([count - 1])]) for count in (rows, columns))
    return torch.cartesian_prod(*lines)


def _bag(image: Tensor, corners: Tensor, width: int, feature_weight: float) -> Bag:
    windows = windows_at(channels_last(image), corners, (width, width))
    weights = torch.tensor([1 / (len(image) - 1)] * (len(image) - 1) + [feature_weight], dtype=torch.float32)
    return Bag(windows, weights, generator_of(0))


def _partners(bags: Sequence[Bag], transport: bool, count: int) -> list[list[Tensor]]:
    """For each texture's anchors, each `count` times, the numbers of partners in every texture; in their own, they."""
    found: list[list[Tensor]] = [[bag.numbers.repeat_interleave(count) for _ in bags] for bag in bags]
    for one, first in enumerate(bags):
        for other, second in enumerate(bags[:one]):
            if transport:
                there, back = transported(first, second, count)
            else:
                there = nearest(first.windows(first.numbers), second, count)
                back = nearest(second.windows(second.numbers), first, count)
            found[one][other], found[other][one] = there.flatten(), back.flatten()
    return found


def _centers(partners: Sequence[Tensor], textures: Sequence[Texture], corners: Sequence[Tensor], width: int) -> Tensor:
    """The middles (N, n, 2) of anchors and their partners, in pixels of their own textures; their windows fit in."""
    middles = []
    for row, texture, at in zip(partners, textures, corners, strict=True):
        last = torch.tensor(texture.image.shape[1:]) - width
        middle = ((at[row].float() + width / 2) * texture.unit - 0.5).round().long()
        middles.append((middle - width // 2).clamp(min=0).minimum(last) + width // 2)
    return torch.stack(middles, 1)


def bends(
    textures: Sequence[Texture], corners: Sequence[Tensor], width: int, making: Making
) -> tuple[Tensor | None, Tensor | None]:
    """See `Neighborhoods.there` and `back`, None unless warped.

    corners: for each of n textures (N, n, 2), the first pixels of N of its windows, and of their partners in all.
    """
    if not making.warped:
        return None, None
    there, back = zip(
        *(_bends_of(number, textures, own, width, making.points) for number, own in enumerate(corners)), strict=True
    )
    return torch.cat(there), torch.cat(back)


def _bends_of(
    number: int, textures: Sequence[Texture], corners: Tensor, width: int, most: int
) -> tuple[Tensor, Tensor]:
    """Those of the windows of one texture, by number."""
    nodes = lattice(width)
    points = [
        feature_points(each.features, at, width, most) for each, at in zip(textures, corners.unbind(1), strict=True)
    ]
    pairs = [torch.zeros(2, len(corners), len(nodes), 2, dtype=torch.float32) for _ in textures]
    for other in range(len(textures)):
        if other != number:
            found = match(points[number], points[other], width)
            pairs[other] = torch.stack([way(nodes + (width - 1) / 2) for way in (found.there, found.back)])
    there, back = torch.stack(pairs, 2)
    return there, back


def _best(anchor: Tensor, fit: Tensor, share: float) -> Tensor:
    """The numbers of the neighborhoods of each texture that fit best."""
    kept = []
    for number in anchor.unique():
        own = (anchor == number).nonzero()[:, 0]
        order = fit[own].argsort(descending=True, stable=True)
        kept.append(own[order[: max(round(share * len(own)), 1)]])
    return torch.cat(kept).sort().values
