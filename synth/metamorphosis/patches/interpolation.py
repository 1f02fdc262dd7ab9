"""Textures between several: what is prepared once, a texture at some weights, and the one that it becomes at others."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from string import ascii_uppercase

import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra import SoftPixels
from kwatra.base import InputError
from synth.metamorphosis.bands import Bands, settled
from synth.metamorphosis.method import silent
from synth.metamorphosis.patches.arrangement import Arrangement
from synth.metamorphosis.patches.centers import spread
from synth.metamorphosis.patches.detail import Detail, Restoring, dilated
from synth.metamorphosis.patches.feature_maps import GIVEN, FoundFeatures, checked_map, find_features
from synth.metamorphosis.patches.model import Making, Matched, matched
from synth.metamorphosis.patches.neighborhoods import Weights
from synth.metamorphosis.patches.passage import Passage
from synth.metamorphosis.patches.scales import common_units
from synth.metamorphosis.patches.statistics import Statistics, mixed, step
from synth.metamorphosis.patches.synthesis import Synthesis
from synth.metamorphosis.patches.weighting import Weighting, continued, cut
from synth.metamorphosis.recolor import barycenter
from synth.metamorphosis.velocity import Search

Pyramid = tuple[tuple[int, int], ...]
"""Levels: how many times coarser, and how wide windows are, odd."""

PUBLISHED: Pyramid = ((2, 33), (2, 17), (1, 17))
"""Those of section 4.4."""

_COARSE = 192
"""Pixels of the shorter side from which on velocities are looked for at half the resolution: a fourth of the cost."""

_FILM, _MAP, _PURE = 5.0, 0.8, 3.0
"""How much frames of films, and of maps, are wanted as the passage shows them, beside the texture; and how much more
where one texture has all the weight. With less they are more of one piece. Looked at on two pairs of photographs, brick
and pebbles, at .8 and 5."""

_ENDS = 3.0
"""How much a map that is made as published is wanted like the picture it begins with, where one texture has nearly all
the weight. Few of its windows are in the bag of a map, so without this its grain was lost. Looked at on bricks and on
made stones, at 3 and 10, and to the power of 8 and 16 of how nearly: to that of 8 double exposures showed."""

_BEGUN = "fast"
"""By this preset textures are synthesized that a frame as published only begins with: with "default" stills of four
pairs at three times are the same by our figures."""

_ALIKE = 0.1
"""The most that a map changes within windows of a coarse level, which have one weighting each and so carry lines of one
texture into others: else it is left out. Looked at on triangles of bricks, gravel and stones: of windows that see .07,
.13 and .26, the fewer the better. Twice as much where elements differ in size: else made tiles grow less evenly."""


@dataclass(frozen=True)
class Frame:
    """An image (C, H, W), what belongs where in it, and, if it was made of neighborhoods alone, what lies where."""

    image: Tensor
    weighting: Weighting
    arrangement: Arrangement | None = None


@dataclass(frozen=True)
class Interpolation:
    """Two or more textures (C, H, W) of any sizes, and how what is between them is made.

    features: for each a map (H, W) or (K, H, W) above a half where features are, or None: found. shape: (height, width)
    of frames. wrap: they tile. synthesis: of a frame as published; carrying: of one that the one before becomes;
    following: of one that is like what a passage shows. statistics: detail that blends take away is given back. search:
    how thoroughly textures are brought onto each other. preset: with which they are synthesized at the size of frames.
    weightings: how many are told apart in one frame. Raises InputError for maps or textures that will not do.
    """

    images: tuple[Tensor, ...]
    features: tuple[Tensor, ...] | None
    shape: tuple[int, int]
    wrap: bool
    making: Making
    synthesis: Synthesis
    carrying: Synthesis
    following: Synthesis
    pyramid: Pyramid
    seed: int
    statistics: bool
    search: Search
    preset: str = "default"
    weightings: int = 1
    _known: dict[tuple[int, int], Matched] = field(default_factory=dict, init=False)

    def __post_init__(self) -> None:
        least, width = min(min(self.shape), *(min(image.shape[1:]) for image in self.images)), self.pyramid[-1][1]
        if least < width:
            raise InputError(f"a texture or frame is only {least} px wide; by patches, give at least {width}x{width}")

    @cached_property
    def found(self) -> FoundFeatures:
        """The maps that are used, given or found."""
        if self.features is None:
            return find_features(self.images)
        maps = tuple(
            checked_map(m, tuple(i.shape[1:]), n)
            for m, i, n in zip(self.features, self.images, ascii_uppercase, strict=False)
        )
        return FoundFeatures(maps, GIVEN, (1.0,) * len(maps))

    @cached_property
    def finest(self) -> Matched:
        """The neighborhoods of the last level."""
        return self._matched(self.pyramid[-1])

    def levels(self, weighting: Weighting) -> tuple[Matched, ...]:
        """The neighborhoods of all levels whose windows fit, and see weights that are nearly alike, coarse to fine."""
        sides = [min(image.shape[1:]) / max(unit, 1.0) for image, unit in zip(self.images, self.units, strict=True)]
        most = min(*self.shape, *sides, _ALIKE * min(len(set(self.units)), 2) / max(weighting.slope, 1e-9))
        coarse = ((factor, width) for factor, width in self.pyramid[:-1] if most // factor >= width)
        return (*map(self._matched, coarse), self.finest)

    @cached_property
    def units(self) -> tuple[float, ...]:
        """How many pixels of each texture make one of the common scale; 1 where its windows would not fit there."""
        units = common_units(self.images, self.found.maps) if self.making.scaled else (1.0,) * len(self.images)
        fits = (min(i.shape[1:]) / unit >= self.pyramid[-1][1] for i, unit in zip(self.images, units, strict=True))
        return units if all(fits) else (1.0,) * len(units)

    def led(self, weighting: Weighting, before: Frame | None = None) -> Frame:
        """The textures of a weighting: like what the passage shows between pictures of each, of the frame's size.

        A texture that is alone is its picture: itself if that has the frame's size, or else synthesized. before: a
        frame that becomes this one; away from where weights change it stays as it is, to the bit.
        """
        stays = torch.zeros(self.shape, dtype=torch.bool) if before is None else self._unchanged(before, weighting)
        pictures, alone = self.passage.pictures, self._alone(weighting)
        if alone is not None and not bool(stays.any()):
            return Frame(pictures[alone], weighting)
        start, kept = self.passage.at(weighting), self.passage.same | stays
        for picture, values in zip(pictures, weighting.values, strict=True):
            there = ~dilated(values < 1, self._reach)
            kept, start[:-1] = kept | there, torch.where(there, picture, start[:-1])
        if before is not None:
            start[:-1] = torch.where(stays, before.image, start[:-1])
        return self._settled(self.following, (self.finest,), weighting, start, kept, self._wanted(weighting))

    def published(self, weighting: Weighting) -> Frame:
        """The textures of a weighting on all levels, as in the paper, begun with the one that weighs most anywhere."""
        alone = self._alone(weighting)
        if alone is not None:
            image, lying = self._laid(alone, weighting.palette[0], self.preset)
            return Frame(image, weighting, lying)
        heaviest, start = weighting.values.argmax(0), None
        for number in heaviest.unique().tolist():
            _, lying = self._laid(number, _mean(weighting, heaviest == number), _BEGUN)
            shown = cut(lying.pasted(weighting.continued(self._margin)), self._margin)
            start = shown if start is None else torch.where(heaviest == number, shown, start)
        assert start is not None
        wanted = _ENDS * weighting.purity(self._reach, self.wrap) ** 16 if len(weighting.palette) > 1 else None
        return self._settled(self.synthesis, self.levels(weighting), weighting, start, wanted=wanted)

    def carried(self, frame: Frame, weighting: Weighting) -> Frame:
        """What a frame becomes at other weights: its neighborhoods shown where they lie, and then textures again.

        Away from where weights change it stays as it is, to the bit.
        """
        assert frame.arrangement is not None
        below = continued(torch.cat([frame.image, torch.ones_like(frame.image[:1])]), self._margin)
        start = cut(frame.arrangement.pasted(weighting.continued(self._margin), below), self._margin)
        kept = self._unchanged(frame, weighting)
        start[:-1] = torch.where(kept, frame.image, start[:-1])
        known = frame.arrangement.layout.corners
        return self._settled(self.carrying, (self.finest,), weighting, start, kept, known=known)

    def _laid(self, number: int, weights: Weights, preset: str) -> tuple[Tensor, Arrangement]:
        """A picture of one texture, its elements as large as at these weights, and the neighborhoods that it is of."""
        found = self.finest.neighborhoods
        where, image = self._picture(number, preset, found.scale(weights) / found.units[number])
        shape, cells = tuple(side + 2 * self._margin for side in self.shape), self.making.cells
        layout = spread(shape, (self._reach,) * 2, (self.wrap,) * 2, cells)
        return image, Arrangement.of(self.finest, number, where, layout, self.shape[0] / where.shape[1], self._margin)

    def _alone(self, weighting: Weighting) -> int | None:
        """The number of the texture that has all the weight, or that all with any weight are the same as; else None."""
        if len(weighting.palette) > 1:
            return None
        first, *others = (number for number, weight in enumerate(weighting.palette[0]) if weight > 0)
        return first if all(torch.equal(self.images[first], self.images[other]) for other in others) else None

    def _unchanged(self, frame: Frame, weighting: Weighting) -> Tensor:
        """Where (H, W) a frame stays at another weighting: as far from any change as windows reach."""
        return ~dilated((frame.weighting.values != weighting.values).any(0), self._reach)

    @cached_property
    def passage(self) -> Passage:
        """What leads from picture to picture: each texture at the size of frames."""
        pictures, maps = [], []
        for number in range(len(self.images)):
            where, image = self._picture(number, self.preset)
            pictures.append(image)
            maps.append(self.found.maps[number][tuple(where)])
        coarse = min(self.shape) >= _COARSE and not (self.wrap and any(side % 2 for side in self.shape))
        return Passage.of(pictures, maps, self._reach, self.making, self.search, self.wrap, silent, 1 + coarse)

    def along(self, passage: Passage, time: float) -> Tensor:
        """The image (C, H, W) of a film from A to B at a time between both: a texture like what the passage shows."""
        weighting = Weighting.even((1 - time, time), self.shape)
        shown = passage.at(weighting)
        wanted = torch.full_like(shown[:1], _FILM)
        return self._settled(self.following, (self.finest,), weighting, shown, passage.same, wanted).image

    def _wanted(self, weighting: Weighting) -> Tensor:
        """How much each pixel (1, H, W) is wanted as the passage shows it: more where one texture has most weight.

        Little where weights jump: there the textures do not go on into each other, and new ones must.
        """
        return _MAP * (1 + _PURE * weighting.purity(self._reach, self.wrap) ** 4)

    @property
    def _reach(self) -> int:
        """The width of the last windows."""
        return self.pyramid[-1][1]

    @property
    def _margin(self) -> int:
        """Pixels by which frames that do not tile are continued beyond their borders while they are made.

        Where fewer windows lie, less is averaged, and what is given back everywhere would be too much.
        """
        return 0 if self.wrap else self._reach // 2

    def _settled(
        self,
        synthesis: Synthesis,
        levels: Sequence[Matched],
        weighting: Weighting,
        start: Tensor,
        kept: Tensor | None = None,
        wanted: Tensor | None = None,
        known: Tensor | None = None,
    ) -> Frame:
        """Textures of a weighting, begun with colors and distance (C + 1, H, W), and like them as far as is wanted.

        wanted (1, H, W): how far, or None: not at all. kept (H, W): pixels that stay as they are, or None. known: first
        pixels of windows in the continued frame, see `Synthesis`.
        """
        there, begun = weighting.continued(self._margin), continued(start, self._margin)
        held = None if kept is None else continued(kept[None].float(), self._margin)[0] > 0
        wish = None
        if wanted is not None:
            target = torch.cat([begun, there.values]) if len(there.palette) > 1 else begun
            wish = SoftPixels(target, continued(wanted, self._margin), "wish")
        inside = F.pad(torch.ones(self.shape, dtype=torch.float32), (self._margin,) * 4) if self._margin else None
        detail = Detail.of(self._restoring, self._center, there, held, inside)
        image, arrangement = synthesis(levels, there, begun, self.wrap, self.seed, detail, held, known, wish)
        return Frame(cut(settled(image, detail.given_to), self._margin), weighting, arrangement)

    @cached_property
    def bands(self) -> tuple[Bands, ...]:
        """How strong each texture's detail is."""
        return tuple(Bands.of(image, self.wrap) for image in self.images)

    @cached_property
    def _statistics(self) -> tuple[Statistics, ...]:
        return tuple(Statistics.of(image, self.wrap) for image in self.images)

    def _restoring(self, weights: Weights) -> Restoring:
        """What gives an image the detail between the textures at some weights."""
        if not self.statistics:
            return lambda image, share: image
        target = mixed(self._statistics, weights)
        return lambda image, share: step(image, target, self.wrap, share)

    def _center(self, weights: Weights) -> Tensor:
        """The mean color (C, 1) between the textures at some weights."""
        return barycenter(self.finest.colors, weights).center

    def _matched(self, level: tuple[int, int]) -> Matched:
        if level not in self._known:
            making = self.making.bounded(len(self.images), len(self.images[0]), level[1], self.weightings)
            self._known[level] = matched(self.images, self.found.maps, self.units, level, making)
        return self._known[level]

    def _picture(self, number: int, preset: str, zoom: float = 1.0) -> tuple[Tensor, Tensor]:
        """A picture of one texture, by a preset, `zoom` times smaller than frames; first where (2, h, w) it is from."""
        from synth.texture.images import synthesize

        image, least = self.images[number], self.pyramid[-1][1]
        shape = (max(round(self.shape[0] / zoom), least), max(round(self.shape[1] / zoom), least))
        if shape == tuple(image.shape[1:]):
            lines = torch.meshgrid(*map(torch.arange, shape), indexing="ij")
            return torch.stack(lines), image
        made = synthesize(image, shape, tile=self.wrap, preset=preset, seed=self.seed)
        return torch.as_tensor(made.source)[1:].long(), made.image


def _mean(weighting: Weighting, where: Tensor) -> tuple[float, ...]:
    """The mean weights where a mask is True."""
    return tuple(weighting.values[:, where].double().mean(1).tolist())
