"""Sequences whose last frame leads into their first.

The animation is run forward from its first frame and, for the last stretch, also backward from it: that is what leads
into the first frame exactly. During that stretch the one turns into the other region by region, each as large as the
blocks that are renewed and at a time of its own that is carried along with it, the seam around it a minimum cut that
leads through the gaps between elements, where there are any. So the end differs from the rest by a few more regions
renewed per frame, and the join is a pair of frames like any other. Of a video both ways may show other parts of a scene
there, which no cut parts unseen: they pass over into each other around a region, details as strong as in both.

Of made stones of 48 px in a pair of vortices (240x240, loops of 24 and 36 frames of 256x256) 8 and 9 px of seams lie
within stones of both ways in a frame of the turn, 299 and 255 if regions of 48 px are parted by what colors differ by,
within 6 px of where they meet. As more passes over at once, optical flow then finds motion off by 1.42 and 1.00 px
there, not .94 and .73; what changes beside the motion is as much in all.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from flow.animation.asked import Mask
from flow.animation.carrying import blurred
from flow.animation.film import nearest_pixels
from flow.animation.sequence import Frame, Motion
from flow.animation.settings import Renewing
from flow.animation.showing import Fading
from flow.animation.state import State
from flow.fields import Field, Shape
from flow.warps import lookup, pixel_coordinates, warp
from kwatra import Exemplar, InputError, Settings
from kwatra.base import generator_of, is_whole, nearest_known
from kwatra.elements import anisotropy, easier
from kwatra.pieces import Box, Mosaic, Patch, SeamCost, Sheet
from kwatra.pieces.seams import eased

_STRETCH = 24
"""The turn takes at most so many frames, and at most half of the loop: a bound, not tuned."""

_BAND = 1 / 4
"""How far, in sides of a region, a seam may move from where regions meet. Of radishes in a pair of vortices 1/8 leaves
straight edges; with 1/2 regions turn no longer at their own times, but many at once, or back again. Of a video it is
the deviation of the Gaussian by which it passes over: with half of that a fountain that rotates shows regions."""


def loop(
    exemplar: Exemplar | Tensor,
    field: Field,
    shape: Shape = (256, 256),
    *,
    frames: int,
    first: Tensor | None = None,
    mask: Mask = None,
    renewing: Renewing | None = None,
    synthesis: Settings | None = None,
    seed: int = 0,
    after: State | None = None,
    also: Exemplar | Tensor | None = None,
    turn: bool | None = None,
) -> Iterator[Frame]:
    """The frames, of `shape` (H, W), of a texture that flows along a field and comes back to its first frame.

    As `flow.animate`, but frame `frames` would be frame 0 again. A field that changes in time should be periodic, too.
    after: go on after this state of a frame that was made; what leads back is made anew, the same bits.

    Memory: a frame's coordinates and picture for each of the last 24 frames. Raises InputError as `animate` does, or
    for fewer than 2 frames.
    """
    if not is_whole(frames, 2):
        raise InputError(f"a loop is to have {frames} frames; give a whole number, at least 2")
    synthesis = synthesis or Settings()
    motion = Motion.of(exemplar, field, shape, mask, None, renewing, synthesis, seed, after, also, turn)
    return _frames(motion, int(frames), first, synthesis, after)


def _frames(
    motion: Motion, frames: int, first: Tensor | None, synthesis: Settings, after: State | None
) -> Iterator[Frame]:
    start = motion.begin(first, synthesis)
    back = _Back(motion, start, frames)
    frame = start if after is None else motion.resumed(after)
    if after is None:
        yield start
    while frame.state.number + 1 < frames:
        frame = motion.step(frame.state)
        yield back.joined(frame)


@dataclass(frozen=True)
class _Stop:
    """A frame on the way back: the frame, and from which frame on (H, W) its pixels are shown."""

    frame: Frame
    since: Tensor


class _Back:
    """The frames that lead into the first one, from the last stretch of a loop of `frames`."""

    def __init__(self, motion: Motion, start: Frame, frames: int) -> None:
        self.motion = motion
        reverse = Motion(
            motion.film.backward,
            _reversed(motion.field, frames),
            motion.shape,
            (lambda k: motion.allowed(frames - k if k else 0)),
            None,
            motion.renewing,
            motion.seed,
        )
        stretch = max(min(_STRETCH, frames // 2), 1)
        self._sides = [min(b, -(-n // 2)) for b, n in zip(motion.renewal.blocks.sides, motion.shape, strict=True)]
        self._band = _BAND * min(self._sides)
        since = _times(motion.shape, frames - stretch + 1, frames, self._sides, motion.seed)
        frame, self._stops = start, {}
        for k in range(1, stretch):
            flow = reverse.field(k - 1, motion.shape)
            since = warp(since[None], lookup(flow).coordinates, "nearest")[0]
            frame = reverse.step(frame.state)
            self._stops[frames - k] = _Stop(frame, since)

    def joined(self, ahead: Frame) -> Frame:
        """A frame of the way ahead, with those regions of the way back that are shown by then."""
        number = ahead.state.number
        if number not in self._stops:
            return ahead
        stop = self._stops[number]
        back = stop.frame
        turned = (stop.since <= number) & back.state.inside
        share = (self._seam if self.motion.film.motion is None else self._feathered)(turned, ahead, back)
        take = share > 0.5
        if self.motion.cells or self.motion.mortar:  # elements that are cut where both ways meet are made whole, too
            source = torch.where(take, back.state.source, ahead.state.source)
            inside = torch.where(take, back.state.inside, ahead.state.inside)
            whole = self.motion.shown(self.motion.whole(source, inside), inside)
            return replace(ahead, image=whole.image, also=whole.also, source=whole.source, where=whole.where)
        maps = None if ahead.also is None or back.also is None else torch.where(take, back.also, ahead.also)
        return replace(
            ahead, image=self._mixed(share, ahead, back), also=maps,
            source=torch.where(take, back.source, ahead.source), where=torch.where(take, back.where, ahead.where),
        )  # fmt: skip

    def _mixed(self, share: Tensor, ahead: Frame, back: Frame) -> Tensor:
        """What is seen (C, H, W) where so much (H, W), 0 to 1, is shown of the way back; details stay as strong."""
        copied, passes = torch.where(share > 0.5, back.image, ahead.image), (share > 0) & (share < 1)
        if not bool(passes.any()):
            return copied
        fading = replace(Fading.nothing(back.state.source, back.image), share=1 - share)
        mixed = fading.shown(back.image, ahead.image, ahead.state.inside & back.state.inside, len(back.image))
        return torch.where(passes, self.motion.film.read.within(mixed), copied)

    def _feathered(self, turned: Tensor, ahead: Frame, back: Frame) -> Tensor:
        """How much (H, W), 0 to 1, is shown of the way back of a video: all within the regions turned (H, W)."""
        both = ahead.state.inside & back.state.inside
        share = blurred(turned[None].float(), both, self._band)[0]
        return torch.where(both, share, turned.float())

    def _seam(self, turned: Tensor, ahead: Frame, back: Frame) -> Tensor:
        """Which pixels (H, W) show the way back, 1 or 0: the regions turned, but for a cut near their edges."""
        regions = turned.cpu().numpy()
        free = np.full_like(regions, regions.any() and not regions.all())
        for part in (regions, ~regions):
            free &= ndimage.distance_transform_edt(~part, _units(self._sides)) <= self._band
        far = ahead.state.inside.cpu().numpy() & ~free
        mosaic = Mosaic([frame.image.cpu().numpy() for frame in (ahead, back)])
        cost = self._cost(mosaic, [frame.state.source for frame in (ahead, back)])
        sheet, whole = Sheet(mosaic, regions.shape, (False, False), cost), Box((0, 0), regions.shape)
        sheet.lay(Patch(0, (0, 0), whole))
        sheet.lay(Patch(1, (0, 0), whole), must=far & regions, must_not=far & ~regions)
        return torch.from_numpy(sheet.label == 1).to(ahead.image)

    def _cost(self, mosaic: Mosaic, sources: Sequence[Tensor]) -> SeamCost:
        """What seams of a mosaic of frames cost, given their source coordinates (2, H, W).

        They cost more through elements; or, where the texture runs along an axis, less beside its lines.
        """
        film = self.motion.film
        hidden = film.hidden
        if hidden is None:
            return eased(mosaic, easier(anisotropy(film.strip), film.along))
        places = [nearest_pixels(source, hidden.depth.shape).numpy() for source in sources]
        return hidden.cost(mosaic, [tuple(place) for place in places], mosaic.deviation)


def _reversed(field: Field, frames: int) -> Field:
    """The field of a sequence of `frames` played backward: at time k from frame `frames - k` to the one before."""

    @lru_cache(1)
    def at(k: float, shape: Shape) -> Tensor:
        return lookup(field(frames - 1 - k, shape)).coordinates - pixel_coordinates(shape)

    return Field((lambda k, shape: at(0.0, shape)) if field.steady else at, field.steady)


def _units(sides: Sequence[int]) -> list[float]:
    """How far it is from a pixel to the next along each axis, so that regions of these sides (px) are as wide as high.

    Along the shorter side it is 1.
    """
    return [min(sides) / side for side in sides]


def _times(shape: Shape, first: int, last: int, sides: Sequence[int], seed: int) -> Tensor:
    """The frame (H, W), from `first` to `last`, since which each region of about these sides (px) is to be shown."""
    generator = generator_of(seed)
    rows, columns = (-(-n // side) for n, side in zip(shape, sides, strict=True))
    y, x = torch.meshgrid(torch.arange(rows), torch.arange(columns), indexing="ij")
    corner = torch.stack([y, x]).flatten(1) + torch.rand(2, rows * columns, dtype=torch.float32, generator=generator)
    place = [(corner[axis] * sides[axis]).long().clamp(max=shape[axis] - 1) for axis in range(2)]
    order = torch.randperm(rows * columns, generator=generator)
    time = first + order * (last - first + 1) // len(order)
    point = torch.zeros(shape, dtype=torch.float32)
    point[place[0], place[1]] = 1.0
    value = torch.zeros(shape, dtype=torch.float32)
    value[place[0], place[1]] = time.float()
    rows, columns = nearest_known(point > 0, _units(sides))
    return value[rows, columns]
