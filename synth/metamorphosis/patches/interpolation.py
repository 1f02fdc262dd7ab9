"""Textures between several: what is prepared once, a texture at some weights, and the one that it becomes at others."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from string import ascii_uppercase

import torch
from scipy.ndimage import uniform_filter
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
from synth.metamorphosis.patches.statistics import Statistics, mixed, step
from synth.metamorphosis.patches.synthesis import Synthesis
from synth.metamorphosis.patches.textures import at_size, common_units, placed
from synth.metamorphosis.patches.weighting import Weighting, continued
from synth.metamorphosis.recolor import barycenter
from synth.metamorphosis.velocity import Search

Pyramid = tuple[tuple[int, int], ...]
"""Levels: how many times coarser, and how wide windows are, odd."""

PUBLISHED: Pyramid = ((2, 33), (2, 17), (1, 17))
"""Those of section 4.4."""

_FEWEST = 100
"""No texture has fewer anchors at a level."""

_COARSE = 192
"""Pixels of the shorter side from which on velocities are looked for at half the resolution: a fourth of the cost."""

_FILM, _STILL, _PURE = 5.0, 0.8, 3.0
"""How much frames of films, and others, are wanted as the passage shows them, beside the texture; and how much more
where one texture has all the weight. Stills have nothing to follow: with less they are more of one piece. Looked at on
two pairs of photographs, brick and pebbles, at .8 and 5."""

LARGEST_BAG = 6 * 10**7
"""Values in the windows of a level, 240 MB: where many weightings are told apart, there are fewer anchors."""


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
    following: of one that is like what a passage shows.
    statistics: detail that blends take away is given back. search: how thoroughly textures are brought onto each other.
    preset: with which they are synthesized at the size of frames.
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

    @cached_property
    def levels(self) -> tuple[Matched, ...]:
        """The neighborhoods of all levels whose windows fit, coarse to fine."""
        sides = [min(image.shape[1:]) / max(unit, 1.0) for image, unit in zip(self.images, self.units, strict=True)]
        least = min(*self.shape, *sides)
        return (*(self._matched((f, w)) for f, w in self.pyramid[:-1] if least // f >= w), self.finest)

    @cached_property
    def units(self) -> tuple[float, ...]:
        """How many pixels of each texture make one of the common scale; 1 where its windows would not fit there."""
        units = common_units(self.images) if self.making.scaled else (1.0,) * len(self.images)
        fits = (min(i.shape[1:]) / unit >= self.pyramid[-1][1] for i, unit in zip(self.images, units, strict=True))
        return units if all(fits) else (1.0,) * len(units)

    def led(self, weighting: Weighting, passage: Passage) -> Frame:
        """The textures of a weighting: like what a passage shows between pictures of each, of the frame's size.

        A texture that is alone is its picture: itself if that has the frame's size, or else synthesized.
        """
        return self._between(weighting, passage)

    def onward(self, frame: Frame, weighting: Weighting) -> Frame:
        """What a frame becomes at another weighting; away from where that changes it stays as it is, to the bit."""
        stays = self._unchanged(frame, weighting)
        return self._between(weighting, self.passage, (stays, frame.image) if bool(stays.any()) else None)

    def published(self, weighting: Weighting) -> Frame:
        """The textures of a weighting on all levels, as in the paper, begun with the one that weighs most anywhere."""
        alone = len(weighting.palette) == 1 and max(weighting.palette[0]) == 1
        heaviest = weighting.values.argmax(0)
        start, layout = None, spread(self.shape, (self._reach,) * 2, (self.wrap,) * 2)
        for number in heaviest.unique().tolist():
            scale = self.finest.neighborhoods.scale(_mean(weighting, heaviest == number))
            where, image = self._picture(number, scale / self.finest.neighborhoods.units[number])
            zoom = self.shape[0] / where.shape[1]
            begun = Arrangement.of(self.finest, number, where, layout, zoom)
            if alone:
                return Frame(image, weighting, begun)
            shown = begun.pasted(weighting)
            start = shown if start is None else torch.where(heaviest == number, shown, start)
        assert start is not None
        return self._settled(self.synthesis, self.levels, weighting, start)

    def carried(self, frame: Frame, weighting: Weighting) -> Frame:
        """What a frame becomes at other weights: its neighborhoods shown where they lie, and then textures again.

        Away from where weights change it stays as it is, to the bit.
        """
        assert frame.arrangement is not None
        far = torch.ones_like(frame.image[:1])
        known = frame.arrangement.layout.corners
        start = frame.arrangement.pasted(weighting, torch.cat([frame.image, far]))
        kept = self._unchanged(frame, weighting)
        start[:-1] = torch.where(kept, frame.image, start[:-1])
        return self._settled(self.carrying, (self.finest,), weighting, start, kept, known)

    def _unchanged(self, frame: Frame, weighting: Weighting) -> Tensor:
        """Where (H, W) a frame stays at another weighting: as far from any change as windows reach."""
        return ~dilated((frame.weighting.values != weighting.values).any(0), self._reach)

    @cached_property
    def passage(self) -> Passage:
        """What leads from picture to picture: each texture at the size of frames."""
        return self._leading([1.0] * len(self.images))

    def sized(self, weighting: Weighting) -> Passage:
        """The same, but where weights are the same everywhere elements have a size in between, as in `Neighborhoods`.

        Its pictures are others at other weights, so it is for a still and leads through no film.
        """
        if len(weighting.palette) > 1 or len(set(self.units)) == 1:
            return self.passage
        scale = self.finest.neighborhoods.scale(weighting.palette[0])
        return self._leading([scale / unit for unit in self.units])

    def _leading(self, zooms: Sequence[float]) -> Passage:
        """What leads from picture to picture of the size of frames, each `zoom` times larger than its texture."""
        pictures, maps = [], []
        for number, zoom in enumerate(zooms):
            where, image = self._picture(number, zoom)
            pictures.append(at_size(image, self.shape))
            maps.append(placed(self.found.maps[number][tuple(where)], self.shape))
        coarse = min(self.shape) >= _COARSE and not (self.wrap and any(side % 2 for side in self.shape))
        factor = 2 if coarse else 1
        return Passage.of(pictures, maps, self._reach, self.making, self.search, self.wrap, silent, factor)

    def along(self, passage: Passage, time: float) -> Tensor:
        """The image (C, H, W) of a film from A to B at a time between both: a texture like what the passage shows."""
        weighting = Weighting.even((1 - time, time), self.shape)
        shown = passage.at(weighting)
        return self._followed(weighting, shown, torch.full_like(shown[:1], _FILM), passage.same).image

    def _between(self, weighting: Weighting, passage: Passage, before: tuple[Tensor, Tensor] | None = None) -> Frame:
        """The textures of a weighting; before: a mask (H, W), True where pixels are known, and those (C, H, W)."""
        pictures, palette = passage.pictures, weighting.palette
        if before is None and len(palette) == 1 and max(palette[0]) == 1:
            return Frame(pictures[palette[0].index(1)], weighting)
        start = passage.at(weighting)
        kept = passage.same
        for picture, values in zip(pictures, weighting.values, strict=True):
            alone = ~dilated(values < 1, self._reach)
            kept, start[:-1] = kept | alone, torch.where(alone, picture, start[:-1])
        if before is not None:
            kept, start[:-1] = kept | before[0], torch.where(before[0], before[1], start[:-1])
        return self._followed(weighting, start, self._wanted(weighting), kept)

    def _wanted(self, weighting: Weighting) -> Tensor:
        """How much each pixel (1, H, W) is wanted as the passage shows it: more where one texture has most weight.

        Little where weights jump: there the textures do not go on into each other, and new ones must.
        """
        around = (0, self._reach, self._reach)
        most = uniform_filter(weighting.values.numpy(), around, mode="wrap" if self.wrap else "nearest").max(0)
        purity = (torch.from_numpy(most) * len(self.images) - 1) / (len(self.images) - 1)
        return _STILL * (1 + _PURE * purity.clamp(min=0)[None] ** 4)

    def _followed(self, weighting: Weighting, shown: Tensor, wanted: Tensor, kept: Tensor) -> Frame:
        """Textures of a weighting like what is shown (C + 1, H, W), as far as that is wanted (1, H, W), or kept (H, W).

        Frames that do not tile are continued beyond their borders meanwhile: where fewer windows lie, less is averaged,
        and what is given back everywhere would be too much.
        """
        margin = 0 if self.wrap else self._reach // 2
        there = weighting.continued(margin)
        start, wanted = (continued(each, margin) for each in (shown, wanted))
        held = continued(kept[None].float(), margin)[0] > 0
        wish = SoftPixels(torch.cat([start, there.values]) if len(there.palette) > 1 else start, wanted, "wish")
        image = self._settled(self.following, (self.finest,), there, start, held, wish=wish).image
        rows, columns = (slice(margin, margin + side) for side in self.shape)
        return Frame(image[:, rows, columns], weighting)

    @property
    def _reach(self) -> int:
        """The width of the last windows."""
        return self.pyramid[-1][1]

    def _settled(
        self,
        synthesis: Synthesis,
        levels: Sequence[Matched],
        weighting: Weighting,
        start: Tensor,
        kept: Tensor | None = None,
        known: Tensor | None = None,
        wish: SoftPixels | None = None,
    ) -> Frame:
        detail = Detail.of(self._restoring, self._center, weighting, kept)
        image, arrangement = synthesis(levels, weighting, start, self.wrap, self.seed, detail, kept, known, wish)
        return Frame(settled(image, detail.given_to), weighting, arrangement)

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
        values = level[1] ** 2 * (len(self.images[0]) + 1 + len(self.images)) * len(self.images) * self.weightings
        anchors = min(self.making.anchors, max(LARGEST_BAG // values, _FEWEST))
        return matched(self.images, self.found.maps, self.units, level, replace(self.making, anchors=anchors))

    def _picture(self, number: int, zoom: float) -> tuple[Tensor, Tensor]:
        """A picture of one texture, `zoom` times smaller than frames; first where (2, h, w) in the texture it lies."""
        from synth.texture.images import synthesize

        image, least = self.images[number], self.pyramid[-1][1]
        shape = (max(round(self.shape[0] / zoom), least), max(round(self.shape[1] / zoom), least))
        if shape == tuple(image.shape[1:]):
            lines = torch.meshgrid(*map(torch.arange, shape), indexing="ij")
            return torch.stack(lines), image
        made = synthesize(image.cpu(), shape, tile=self.wrap, preset=self.preset, seed=self.seed)
        return torch.as_tensor(made.source)[1:].long(), made.image.to(image)


def _mean(weighting: Weighting, where: Tensor) -> tuple[float, ...]:
    """The mean weights where a mask is True."""
    return tuple(weighting.values[:, where].double().mean(1).tolist())
