"""Neighborhoods that lead from where they lie in A to where they lie in B, so that a film begins in A and ends in B.

Neighborhoods matched by likeness alone may come from anywhere: what A turns into by them is a texture of B, not B. Here
each has its place in both pictures, which have one size. A smooth velocity of least energy (see
`synth.metamorphosis.velocity`) brings A onto B, in colors halfway between both and in the distance to features; a
window of A and the one of B that lies where it comes to are partners, likewise from B, and their features are then
matched as in any neighborhood. At time t each lies a part t of its way on. All are laid in one sum, which at t = 0 is A
and at t = 1 is B. In between it is a picture whose windows need not agree: what a texture is wanted to be like.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import torch
import torch.nn.functional as F
from torch import Tensor

from flow.warps import displacement
from kwatra import FreeWindows
from kwatra.windows.metric import falloff
from synth.metamorphosis.method import Report
from synth.metamorphosis.patches.centers import quarters
from synth.metamorphosis.patches.feature_points import feature_points
from synth.metamorphosis.patches.model import POINTS, Making, Matched
from synth.metamorphosis.patches.neighborhoods import Neighborhoods, lattice
from synth.metamorphosis.patches.point_matching import match
from synth.metamorphosis.patches.textures import Texture
from synth.metamorphosis.recolor import Colors, barycenter, recolored
from synth.metamorphosis.velocity import Mismatch, Search

SIGMA = 0.85
"""How far A and B may be from matching, in standard deviations; tuned from .85 to 1.5 on three pairs: brick, onyx and
pebbles. More leaves double exposures, less moves more than the eye can follow."""

FEATURES = 0.5
"""What the distance to features counts there beside all colors; 0 to 1 were tried on the same pairs."""

_MOST = 4096
"""Neighborhoods that are laid at once."""


@dataclass(frozen=True)
class Passage:
    """Neighborhoods of A and of B in their places; `Passage.of` two pictures.

    matched: their centers are pixels of A and of B, which are continued by `margin` on all sides. shape: of both.
    """

    matched: Matched
    shape: tuple[int, int]
    wrap: bool
    margin: int

    @classmethod
    def of(
        cls,
        images: Sequence[Tensor],
        maps: Sequence[Tensor],
        width: int,
        making: Making,
        search: Search,
        wrap: bool,
        report: Report,
    ) -> "Passage":
        """That of two pictures (C, H, W) with maps (H, W) of their features; wrap: they tile. width: of windows."""
        shape = (images[0].shape[1], images[0].shape[2])
        colors = tuple(Colors.of(image) for image in images)
        textures = tuple(Texture.of(image, each, 1.0, 1) for image, each in zip(images, maps, strict=True))
        compared = _compared(textures, colors)
        velocity = search.velocity(compared, lambda both: Mismatch(both, SIGMA, wrap), wrap, report).velocity
        corners = quarters(shape, (width, width), (wrap, wrap)).corners
        there, back = (_moved(corners, displacement(velocity, *ends, wrap), width, wrap) for ends in ((0, 1), (1, 0)))
        places = torch.stack([torch.cat([corners, back]), torch.cat([there, corners])], 1)
        margin = 2 * width
        textures = tuple(_continued(texture, margin, wrap) for texture in textures)
        ways = _ways(textures, places + margin, width) if making.warped else (None, None)
        anchor = torch.zeros(len(places), dtype=torch.long)
        found = Neighborhoods(width, (1.0, 1.0), anchor, places + margin + width // 2, *ways)
        return cls(Matched((1, width), making.feature_weight, textures, found, colors), shape, wrap, margin)

    def at(self, time: float) -> Tensor:
        """The sum at a time: colors and distance, (C + 1, H, W). Memory: a few pictures, and bands of windows."""
        weights = (1 - time, time)
        shown = self.matched.shown(weights)
        weight = falloff((self.matched.level[1],) * 2)[..., None]
        mass, total = torch.zeros(1, *self.shape), torch.zeros(len(shown[0]), *self.shape)
        for some, layout in self._laid(time):
            mass = layout.scatter(weight.expand(len(layout), *weight.shape).contiguous(), mass)
            total = layout.scatter(some.windows(shown, weights) * weight, total)
        rows, columns = (slice(self.margin, self.margin + side) for side in self.shape)
        faded = torch.lerp(shown[0][:, rows, columns], shown[1][:, rows, columns], time)
        return torch.where(mass > 0, total / mass.clamp(min=1e-12), faded)  # all windows may have left a corner

    def _laid(self, time: float) -> Iterator[tuple[Neighborhoods, FreeWindows]]:
        """Bands of neighborhoods and where they lie at a time; their centers moved so that whole pixels do not show."""
        all_of_them, width = self.matched.neighborhoods, self.matched.level[1]
        sides = torch.tensor(self.shape)
        for numbers in torch.arange(len(all_of_them)).split(_MOST):
            some = all_of_them.taken(numbers)
            first, second = (some.centers - self.margin - width // 2).unbind(1)
            way = second - first
            way = (way + sides // 2) % sides - sides // 2 if self.wrap else way
            place = first + time * way
            corner = place.round() if self.wrap else place.round().clamp(min=0).minimum(sides - width)
            layout = FreeWindows(self.shape, (width, width), corner.long(), (self.wrap, self.wrap))
            yield replace(some, centers=some.centers + (corner - place)[:, None]), layout


def _compared(textures: Sequence[Texture], colors: Sequence[Colors]) -> Tensor:
    """What is to match, (2, C + 1, H, W): colors halfway and distances, each of variance 1 in all, times its weight."""
    middle = barycenter(colors, (0.5, 0.5))
    seen = [recolored(texture.image, own, middle) for texture, own in zip(textures, colors, strict=True)]
    spread = middle.covariance.diagonal().sum().sqrt().to(seen[0])
    away = torch.stack([texture.distance for texture in textures])
    return torch.cat([torch.stack(seen) / spread, FEATURES * away / away.std().clamp(min=1e-3)], 1)


def _moved(corners: Tensor, way: Tensor, width: int, wrap: bool) -> Tensor:
    """Where windows with first pixels (N, 2) come to by a displacement (2, H, W), x first: first pixels (N, 2).

    Where pictures do not tile, their middles stay on the picture.
    """
    sides = torch.tensor(way.shape[1:])
    middle = (corners + width // 2) % sides
    moved = corners + way[:, middle[:, 0], middle[:, 1]].T.flip(1).round().long().cpu()
    return moved % sides if wrap else moved.clamp(min=-(width // 2)).minimum(sides - 1 - width // 2)


def _continued(texture: Texture, margin: int, wrap: bool) -> Texture:
    """A texture continued by a margin on all sides: as it tiles, or by its outermost values, without features."""
    ways = ("circular", "circular") if wrap else ("replicate", "constant")
    channels = F.pad(texture.channels[None], (margin,) * 4, ways[0])[0]
    features = F.pad(texture.features[None, None].float(), (margin,) * 4, ways[1])[0, 0] > 0
    return replace(texture, image=channels[:-1], distance=channels[-1:], features=features)


def _ways(textures: Sequence[Texture], corners: Tensor, width: int) -> tuple[Tensor, Tensor]:
    """See `Neighborhoods.there` and `back`; corners (N, 2, 2): first pixels in A and in B."""
    nodes = lattice(width)
    own, other = (
        feature_points(texture.features, at, width, POINTS)
        for texture, at in zip(textures, corners.unbind(1), strict=True)
    )
    found = match(own, other, width)
    there, back = (way(nodes + (width - 1) / 2) for way in (found.there, found.back))
    none = torch.zeros_like(there)
    return torch.stack([none, there], 1), torch.stack([none, back], 1)
