"""What is shown of a frame's copies, and of the frame before.

Of a picture that is the blend of the copies and x+, the frame before carried along, which makes the flow term least
(`flow.animation.term`); of a video copies that were replaced live on below those that took their place, and what is
shown is of both (`fading`), its colors mixed about the curve on which they lie, and its seams feathered.
"""

from dataclasses import replace

import torch
from torch import Tensor

from flow.animation.carrying import replaced
from flow.animation.film import Film, Reading
from flow.animation.settings import Renewing
from flow.animation.showing.colorcurve import ColorCurve
from flow.animation.showing.fading import Fading, left_of, shaded
from flow.animation.showing.feathering import BEYOND, feathered, strengths_of
from flow.animation.state import State
from flow.animation.term import lasting
from flow.warps import Lookup, filled, warp
from kwatra.base import over_channels

_SEEN = 1 / 512
"""Of what fades seams are feathered where more than this share of it is still shown: half of one of 256 levels."""


class Showing:
    """Shows copies of an exemplar, whose colors vary by `variance`, on the CPU.

    Pictures are its colors (C, H, W), `channels` of them, and of maps that go along (C + M, H, W).
    """

    def __init__(self, film: Film, renewing: Renewing, variance: float) -> None:
        self.film, self.renewing, self._variance = film, renewing, variance
        self.channels = len(film.strip.canvas)
        self._curve = None if film.motion is None else ColorCurve(film.strip)
        strip = film.strip
        if self._curve is not None:
            strip = replace(strip, canvas=self._curve.of(strip.canvas))
        ways, also = (renewing.interpolation, BEYOND), film.also
        self.read, self._beyond = (Reading(strip, way) for way in ways)
        self._read_also, self._beyond_also = (None if also is None else Reading(also, way) for way in ways)
        self._details = strengths_of(strip)

    def first(self, source: Tensor, inside: Tensor) -> Tensor:
        """What a first frame shows, of copies at source coordinates (2, H, W), x first, inside (H, W)."""
        return self._colors(self.picture(source, inside))

    def next(
        self, before: State, look: Lookup, source: Tensor, new: Tensor, inside: Tensor, image: Tensor | None
    ) -> tuple[Tensor, Tensor | None]:
        """What the frame after a state shows, carried as `look` says, and what then fades (`State.fading`).

        source (2, H, W): where its copies were read before they were renewed; new (2, H, W): where they are seen after.
        inside (H, W): where there is texture. image (C', H, W): the exemplar at new coordinates, its colors first, if
        these are known.
        """
        copies = self.picture(new, inside, None if image is None else image[: self.channels])
        if self.film.motion is None:
            return self._blended(copies, before, look), None
        shown, fading = self._dissolved(copies, before, look, source, new)
        return self._colors(shown), fading.packed

    def picture(self, source: Tensor, inside: Tensor, colors: Tensor | None = None) -> Tensor:
        """What source coordinates show: colors (C, H, W), unless they are known, and below them the maps."""
        reach, also = self.renewing.feather, self._beyond_also
        if reach:  # softened seams would stay in them as thin lines
            colors = feathered(self.read(source), source, inside, self._beyond, reach, self._details)
        elif colors is None or self._curve is not None:
            colors = self.read.picture(source, inside)
        if self._read_also is None or also is None:
            return colors
        maps = self._read_also(source) if reach else self._read_also.picture(source, inside)
        return torch.cat([colors, feathered(maps, source, inside, also, reach, None)])

    def _blended(self, copies: Tensor, before: State, look: Lookup) -> Tensor:
        """A frame (C, H, W) that shows its copies, and still some of the one before where both are alike.

        Maps below the colors go the same way.
        """
        if self.renewing.inertia == 0 or not bool(look.known.any()):
            return copies
        image = filled(before.image, before.inside)
        carried = filled(warp(image, look.coordinates, self.renewing.interpolation), look.known)
        apart = (carried - copies)[: self.channels].square()
        off = over_channels(apart * self.film.strip.share) / self._variance
        share = lasting(off, self.renewing.inertia) * look.known
        return self._within(copies + share * (carried - copies))

    def _dissolved(
        self, copies: Tensor, before: State, look: Lookup, source: Tensor, new: Tensor
    ) -> tuple[Tensor, Fading]:
        """A frame (C, H, W) of a video whose copies at source coordinates (2, H, W) were replaced by new ones.

        It comes with what fades below them.
        """
        known = look.known & before.inside
        if not bool(look.known.any()):
            return copies, Fading.nothing(new, copies)
        old = Fading.nothing(before.source, copies) if before.fading is None else Fading.unpacked(before.fading)
        old = old.onward(self.film, look, before.inside)
        changed = known & replaced(new, source) & self.read.usable(source)
        above, below = self.picture(source, known), self.picture(old.below, known & (old.share > _SEEN))
        wanted = old.mixed(above, below) + old.shade
        fading = old.replaced(source, changed, left_of(self.film, self.renewing.inertia))
        image = fading.shown(copies, torch.where(changed, above, below), known, self.channels)
        shade = shaded(wanted, image, known, self.renewing.shades)
        shade[self.channels :] = 0
        return self._within(image + shade), replace(fading, shade=shade)

    def _within(self, shown: Tensor) -> Tensor:
        """Colors, and maps below them, within the exemplar's range."""
        colors, maps = shown.tensor_split([self.channels])
        colors = self.read.within(colors)
        return colors if self._read_also is None else torch.cat([colors, self._read_also.within(maps)])

    def _colors(self, shown: Tensor) -> Tensor:
        """The colors, and maps below them, of a picture (C, H, W): those of a video are mixed about their curve."""
        if self._curve is None:
            return shown
        mixed, maps = shown.tensor_split([self.channels])
        return torch.cat([self.film.read.within(self._curve.colors(mixed)), maps])
