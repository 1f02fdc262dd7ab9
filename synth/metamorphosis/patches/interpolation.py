"""Textures between several: what is prepared once, a texture at some weights, and the one that it becomes at others."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from string import ascii_uppercase

import torch
from torch import Tensor

from kwatra import FreeWindows
from kwatra.base import InputError
from synth.metamorphosis.bands import Bands
from synth.metamorphosis.patches.arrangement import Arrangement
from synth.metamorphosis.patches.centers import quarters
from synth.metamorphosis.patches.detail import Detail, Restoring, dilated
from synth.metamorphosis.patches.feature_maps import GIVEN, FoundFeatures, checked_map, find_features
from synth.metamorphosis.patches.model import Making, Matched, matched
from synth.metamorphosis.patches.neighborhoods import Weights
from synth.metamorphosis.patches.passage import Passage
from synth.metamorphosis.patches.statistics import Statistics, mixed, step
from synth.metamorphosis.patches.synthesis import Synthesis
from synth.metamorphosis.patches.textures import common_units
from synth.metamorphosis.patches.weighting import Weighting

Pyramid = tuple[tuple[int, int], ...]
"""Levels: how many times coarser, and how wide windows are, odd."""

PUBLISHED: Pyramid = ((2, 33), (2, 17), (1, 17))
"""Those of section 4.4."""

_FEWEST = 100
"""No texture has fewer anchors at a level."""


LARGEST_BAG = 6 * 10**7
"""Values in the windows of a level, 240 MB: where many weightings are told apart, there are fewer anchors."""


@dataclass(frozen=True)
class Frame:
    """An image (C, H, W), what belongs where in it, and what lies where."""

    image: Tensor
    weighting: Weighting
    arrangement: Arrangement


@dataclass(frozen=True)
class Interpolation:
    """Two or more textures (C, H, W) of any sizes, and how what is between them is made.

    features: for each a map (H, W) or (K, H, W) above a half where features are, or None: found. shape: (height, width)
    of frames. wrap: they tile. synthesis: of a frame by itself; carrying: of one that the one before becomes.
    statistics: detail that blends take away is given back. weightings: how many are
    told apart in one frame. Raises InputError for maps or textures that will not do.
    """

    images: tuple[Tensor, ...]
    features: tuple[Tensor, ...] | None
    shape: tuple[int, int]
    wrap: bool
    making: Making
    synthesis: Synthesis
    carrying: Synthesis
    pyramid: Pyramid
    seed: int
    statistics: bool
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

    def still(self, weighting: Weighting) -> Frame:
        """The textures of a weighting, begun with the one that weighs most at each pixel.

        A texture that is alone everywhere is itself if frames have its size, or else synthesized.
        """
        alone = len(weighting.palette) == 1 and max(weighting.palette[0]) == 1
        heaviest = weighting.values.argmax(0)
        start, layout = None, self._layout()
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

    def onward(self, frame: Frame, weighting: Weighting) -> Frame:
        """What a frame becomes at another weighting: neighborhoods shown where they lie, and then textures again.

        Where the weighting stays as it was, so does the frame, bit for bit.
        """
        far = torch.ones_like(frame.image[:1])
        known = frame.arrangement.layout.corners
        start = frame.arrangement.pasted(weighting, torch.cat([frame.image, far]))
        changed = (frame.weighting.values != weighting.values).any(0)
        if bool(changed.all()):
            return self._settled(self.carrying, (self.finest,), weighting, start, None, known)
        if not bool(changed.any()):
            return frame
        kept = ~dilated(changed, self.finest.level[1])
        start[:-1] = torch.where(kept, frame.image, start[:-1])
        return self._settled(self.carrying, (self.finest,), weighting, start, kept, known)

    def along(self, passage: Passage, time: float) -> Tensor:
        """The image (C, H, W) of a film from A to B at a time between both: a texture like what the passage shows."""
        weighting, shown = Weighting.even((1 - time, time), self.shape), passage.at(time)
        placed = replace(self.carrying, free_centers=False)  # beside a wish free ones gain nothing
        return self._settled(placed, (self.finest,), weighting, shown, wished=shown).image

    def _settled(
        self,
        synthesis: Synthesis,
        levels: Sequence[Matched],
        weighting: Weighting,
        start: Tensor,
        kept: Tensor | None = None,
        known: Tensor | None = None,
        wished: Tensor | None = None,
    ) -> Frame:
        detail = Detail.of(self._restoring, weighting, kept)
        image, arrangement = synthesis(levels, weighting, start, self.wrap, self.seed, detail, kept, known, wished)
        return Frame(detail.settled(image), weighting, arrangement)

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

    def _matched(self, level: tuple[int, int]) -> Matched:
        values = level[1] ** 2 * (len(self.images[0]) + 1 + len(self.images)) * len(self.images) * self.weightings
        anchors = min(self.making.anchors, max(LARGEST_BAG // values, _FEWEST))
        return matched(self.images, self.found.maps, self.units, level, replace(self.making, anchors=anchors))

    def _layout(self) -> FreeWindows:
        width = self.pyramid[-1][1]
        return quarters(self.shape, (width, width), (self.wrap, self.wrap))

    def _picture(self, number: int, zoom: float) -> tuple[Tensor, Tensor]:
        """A picture of one texture, `zoom` times smaller than frames; first where (2, h, w) in the texture it lies."""
        from synth.texture.images import synthesize

        image, least = self.images[number], self.pyramid[-1][1]
        shape = (max(round(self.shape[0] / zoom), least), max(round(self.shape[1] / zoom), least))
        if shape == tuple(image.shape[1:]):
            lines = torch.meshgrid(*map(torch.arange, shape), indexing="ij")
            return torch.stack(lines), image
        made = synthesize(image.cpu(), shape, tile=self.wrap, seed=self.seed)
        return torch.as_tensor(made.source)[1:].long(), made.image.to(image)


def _mean(weighting: Weighting, where: Tensor) -> tuple[float, ...]:
    """The mean weights where a mask is True."""
    return tuple(weighting.values[:, where].double().mean(1).tolist())
