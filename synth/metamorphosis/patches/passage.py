"""Neighborhoods that lead from where they lie in one picture to where they lie in others, so that ends are exact.

Neighborhoods matched by likeness alone may come from anywhere: what A turns into by them is a texture of B, not B. Here
each has its place in all pictures, which have one size at a common scale. A smooth velocity of least energy (see
`synth.metamorphosis.velocity`) brings one picture onto another, in colors halfway between all and in the distance to
features; a window of A and the one of B that lies where it comes to are partners, likewise from B, and their features
are then matched as in any neighborhood. At weights w each lies at the mean of its places, by the weights: all laid in
one sum are A where A has all the weight, and so on. In between it is a picture whose windows need not agree: what a
texture is wanted to be like. Weights may differ from place to place.

If elements of one picture are larger than those of another, frames zoom about their middle from the scale of one to
that of the other, and elements grow. Pictures whose elements are larger must then show more around the middle.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import torch
import torch.nn.functional as F
from torch import Tensor

from flow.warps import displacement
from kwatra import FreeWindows
from kwatra.base import InputError
from kwatra.windows.metric import falloff
from synth.metamorphosis.method import Report
from synth.metamorphosis.patches.centers import spread
from synth.metamorphosis.patches.detail import dilated, strength
from synth.metamorphosis.patches.model import Making, Matched, bends
from synth.metamorphosis.patches.neighborhoods import Neighborhoods
from synth.metamorphosis.patches.textures import Texture
from synth.metamorphosis.patches.weighting import Weighting
from synth.metamorphosis.recolor import Colors, barycenter, recolored
from synth.metamorphosis.velocity import Mismatch, Search

SIGMA = 1.08
"""How far A and B may be from matching, in standard deviations. More leaves double exposures, less moves more than the
eye can follow: looked at from .85 to 1.5 on three pairs, brick, onyx and pebbles, and on made stones."""

FEATURES = 1.0
"""What the distance to features counts there beside all colors. Of .5, 1 and 2, 1 leaves the fewest double exposures on
made stones of any color; on bricks and pebbles 2 leaves fewer, but moves more."""

FAINT = 0.64
"""Pictures cancel each other whose sum has less of every octave of their detail, beside what n unlike ones have,
1 / sqrt(n). Of eleven pairs of photographs white hexagons with dark joints and orange ones with light joints have .38,
the others .89 or more."""

_MOST = 1 << 15
"""Neighborhoods that are laid at once."""

_SAME = 0.5 / 255
"""Colors that differ by less are the same."""

_ROUNDS = 6
"""So often it is asked which weights a neighborhood has where it comes to, and so where that is."""


@dataclass(frozen=True)
class Passage:
    """Neighborhoods of two or more pictures in their places; `Passage.of` these.

    matched: their centers are pixels of the pictures, which are continued on all sides. shape: of frames. The middles
    of all pictures are that of frames.
    """

    matched: Matched
    shape: tuple[int, int]
    wrap: bool

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
        factor: int = 1,
        units: Sequence[float] | None = None,
    ) -> "Passage":
        """That of pictures (C, H, W) with maps (H, W) of their features; wrap: they tile.

        width: of windows. factor: velocities are looked for so many times coarser, and no finer. units: how many pixels
        of each picture make one of the common scale, by default 1 of all. There all have one size; frames have that of
        the smallest.
        """
        units = (1.0,) * len(images) if units is None else tuple(units)
        textures = [Texture.of(image, each, unit, 1) for image, each, unit in zip(images, maps, units, strict=True)]
        shape = min((image.shape[1], image.shape[2]) for image in images)
        ground = (round(shape[0] / min(units)), round(shape[1] / min(units)))
        common = [texture.common(ground) for texture in textures]
        ways = _ways([each.image for each in common], [each.features for each in common], search, wrap, report, factor)
        corners = spread(ground, (width, width), (wrap, wrap), making.cells).corners
        places = [
            torch.stack([corners if way is None else _moved(corners, way, width, wrap) for way in row], 1)
            for row in ways
        ]
        margin = 2 * width
        seen, textures = ([_continued(each, margin, wrap) for each in kind] for kind in (common, textures))
        there, back = bends(seen, [place + margin for place in places], width, making)
        anchor = torch.arange(len(images)).repeat_interleave(len(corners))
        away = torch.cat(places) + width // 2 - _middle(ground)
        centers = _middles(textures) + torch.tensor(units, dtype=torch.float32)[:, None] * away
        found = Neighborhoods(width, units, anchor, centers, there, back)
        colors = tuple(Colors.of(image) for image in images)
        return cls(Matched((1, width), making.feature_weight, tuple(textures), found, colors), shape, wrap)

    @property
    def pictures(self) -> tuple[Tensor, ...]:
        """The pictures (C, H, W), as frames show each that has all the weight."""
        return tuple(part[:-1] for part in self._parts())

    @cached_property
    def same(self) -> Tensor:
        """Where all pictures are the same, as far around as windows reach, so that nothing is to be made: (H, W)."""
        first, *others = self.pictures
        apart = torch.stack([(other - first).abs().amax(0) for other in others]).amax(0)
        return ~dilated(apart > _SAME, self.matched.level[1])

    @cached_property
    def cancels(self) -> bool:
        """Whether the pictures cancel each other where they lie over each other, such as dark lines and light ones."""
        count = len(self.pictures)
        even = (1 / count,) * count
        left = strength(self.at(Weighting.even(even, self.shape))[:-1], self.pictures, even)
        return left * count**0.5 < FAINT

    def at(self, weighting: Weighting) -> Tensor:
        """The sum at these weights: colors and distance, (C + 1, H, W). Memory: a few pictures, bands of windows.

        What has its middle beyond the frame is left out. InputError where scales would differ within the frame.
        """
        chosen, place = self._placed(weighting)
        sides, width = torch.tensor(self.shape), self.matched.level[1]
        corner = place.round() if self.wrap else place.round().clamp(min=0).minimum(sides - width)
        total = torch.zeros(len(self.matched.colors[0].center) + 2, *self.shape, dtype=torch.float32)
        rows = (corner[:, 0] % self.shape[0]).long()
        middle = place + width // 2
        there = ((middle > -1) & (middle < sides)).all(1) | self.wrap
        order = rows.argsort(stable=True)
        for band in order[there[order]].split(_MOST):
            top, last = int(rows[band[0]]), int(rows[band[-1]])
            windows = self._windows(band, chosen[band], (corner - place)[band], weighting)
            within = torch.stack([rows[band] - top, corner[band, 1].long()], 1)
            layout = FreeWindows((last - top + width, self.shape[1]), (width, width), within, (False, self.wrap))
            lines = (top + torch.arange(last - top + width)) % self.shape[0]
            total.index_add_(1, lines, layout.scatter(windows))
        mass = total[-1:]
        if bool((mass > 0).all()):
            return total[:-1] / mass
        faded = self._faded(weighting)  # all windows may have left a corner
        return torch.where(mass > 0, total[:-1] / mass.clamp(min=1e-12), faded)

    def _placed(self, weighting: Weighting) -> tuple[Tensor, Tensor]:
        """Of each neighborhood the number of its weights in the palette (N,), and where its first pixel lies (N, 2)."""
        width, sides, found = self.matched.level[1], torch.tensor(self.shape), self.matched.neighborhoods
        places = (found.centers - _middles(self.matched.textures)) / torch.tensor(found.units, dtype=torch.float32)[
            :, None
        ]
        way = places - places[:, :1]
        way = (way + sides // 2) % sides - sides // 2 if self.wrap else way
        known, zoom, first = (
            torch.tensor(weighting.palette, dtype=torch.float32),
            self._zoom(weighting),
            _middle(self.shape) - width // 2,
        )
        share = known.mean(0).expand(len(places), -1)
        for _ in range(_ROUNDS if len(known) > 1 else 1):
            place = first + zoom * (places[:, 0] + (share[..., None] * way).sum(1))
            chosen = weighting.at(place.round().long(), width)
            share = known[chosen]
        return chosen, first + zoom * (places[:, 0] + (share[..., None] * way).sum(1))

    def _zoom(self, weighting: Weighting) -> float:
        """How much larger elements are than at the common scale."""
        zooms = {self.matched.neighborhoods.scale(weights) for weights in weighting.palette}
        if len(zooms) > 1:
            raise InputError("pictures at several scales are given several weights in one frame; give units of 1")
        return zooms.pop()

    def _windows(self, numbers: Tensor, chosen: Tensor, moved: Tensor, weighting: Weighting) -> Tensor:
        """Neighborhoods by number (M,) in between, read `moved` (M, 2) further on so that whole pixels do not show.

        Returned with their falloff, which they are multiplied by, as last channel: (M, w, w, C + 2).
        """
        width = self.matched.level[1]
        weight = falloff((width, width))[..., None]
        made = torch.empty(len(numbers), width, width, len(self.matched.colors[0].center) + 2, dtype=torch.float32)
        made[..., -1:] = weight
        for number in chosen.unique().tolist():
            some = (chosen == number).nonzero()[:, 0]
            own = self.matched.neighborhoods.taken(numbers[some])
            own = replace(own, centers=own.centers + moved[some, None])
            weights = weighting.palette[number]
            made[some, ..., :-1] = own.windows(self.matched.shown(weights), weights) * weight
        return made

    def _faded(self, weighting: Weighting) -> Tensor:
        """The textures where they lie, blended: (C + 1, H, W)."""
        return (weighting.values[:, None] * torch.stack(self._parts())).sum(0)

    def _parts(self) -> list[Tensor]:
        """Colors and distance of each picture (C + 1, H, W)."""
        parts = []
        for texture in self.matched.textures:
            cuts = [(own - side) // 2 for own, side in zip(texture.image.shape[1:], self.shape, strict=True)]
            rows, columns = (slice(at, at + side) for at, side in zip(cuts, self.shape, strict=True))
            parts.append(texture.channels[:, rows, columns])
        return parts


def _ways(
    images: Sequence[Tensor], maps: Sequence[Tensor], search: Search, wrap: bool, report: Report, factor: int
) -> list[list[Tensor | None]]:
    """How far (2, H, W), x first, each pixel of one picture is from where it comes to in another; None: in its own."""
    colors = [Colors.of(image) for image in images]
    textures = [Texture.of(image, each, 1.0, factor) for image, each in zip(images, maps, strict=True)]
    compared = _compared(textures, colors)
    search = replace(search, alpha=search.alpha / factor, gamma=search.gamma * factor)
    found: list[list[Tensor | None]] = [[None] * len(images) for _ in images]
    for one in range(len(images)):
        for other in range(one + 1, len(images)):
            both = compared[[one, other]]
            velocity = search.velocity(both, lambda pair: Mismatch(pair, SIGMA, wrap), wrap, report).velocity
            for begin, end, ends in ((one, other, (0, 1)), (other, one, (1, 0))):
                way = displacement(velocity, *ends, wrap)
                found[begin][end] = factor * F.interpolate(way[None], images[0].shape[1:], mode="bilinear")[0]
    return found


def _compared(textures: Sequence[Texture], colors: Sequence[Colors]) -> Tensor:
    """What is to match, (n, C + 1, H, W): colors halfway and distances, each of variance 1 in all, times its weight."""
    middle = barycenter(colors, (1 / len(colors),) * len(colors))
    seen = [recolored(texture.image, own, middle) for texture, own in zip(textures, colors, strict=True)]
    spread = middle.covariance.diagonal().sum().sqrt().to(seen[0])
    away = torch.stack([texture.distance for texture in textures])
    return torch.cat([torch.stack(seen) / spread, FEATURES * away / away.std().clamp(min=1e-3)], 1)


def _middle(shape: Sequence[int]) -> Tensor:
    """The middle (2,) of an image of some height and width, row and column; between pixels of even sides."""
    return (torch.tensor(shape, dtype=torch.float32) - 1) / 2


def _middles(textures: Sequence[Texture]) -> Tensor:
    """Those of textures, (n, 2)."""
    return torch.stack([_middle(texture.image.shape[1:]) for texture in textures])


def _moved(corners: Tensor, way: Tensor, width: int, wrap: bool) -> Tensor:
    """Where windows with first pixels (N, 2) come to by a displacement (2, H, W), x first: first pixels (N, 2).

    Where pictures do not tile, their middles stay on the picture.
    """
    sides = torch.tensor(way.shape[1:])
    middle = (corners + width // 2) % sides
    moved = corners + way[:, middle[:, 0], middle[:, 1]].T.flip(1).round().long()
    return moved % sides if wrap else moved.clamp(min=-(width // 2)).minimum(sides - 1 - width // 2)


def _continued(texture: Texture, margin: int, wrap: bool) -> Texture:
    """A texture continued by a margin on all sides: as it tiles, or by its outermost values, without features."""
    if wrap:  # once around or several times
        rows, columns = (torch.arange(-margin, side + margin) % side for side in texture.image.shape[1:])
        channels, features = (each[..., rows[:, None], columns] for each in (texture.channels, texture.features))
    else:
        channels = F.pad(texture.channels[None], (margin,) * 4, "replicate")[0]
        features = F.pad(texture.features, (margin,) * 4)
    return replace(texture, image=channels[:-1], distance=channels[-1:], features=features)
