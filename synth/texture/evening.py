"""Elements of which a part is known, and the rest copied from others, in one color.

A hole's border cuts elements, and what completes them is seldom of their color. So a color is added to copies which is
that of the known part at the border, goes on evenly over the element, and ends with it: a screened membrane
(`kwatra.base.membrane`) on the insides of elements alone, which also takes steps of color out of elements that several
copies make up. A pixel at an element's rim is in part of the ground's color: of what is added it takes the share by
which its color is the element's, where the ground's is 0.
"""

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra.base import every_pair, membrane, nearest_known
from kwatra.elements import middle_of
from kwatra.pieces import GivenCopies, Parts

REACH = 4.0
"""Over so many elements what is added goes on: over one it is hardly less. Not tuned."""

SMOOTH = 3.0
"""Differences to what is known are averaged over about so many pixels: else noise would be drawn out into lines."""

SOFT = 2.0
"""Steps at the border that are left, as where an element is known and another copied, are spread over so many pixels,
by eye."""

SHADED, DEEP = 0.3, 0.6
"""From the second deep in an element on pixels are of its color whatever theirs is, to the first less and less; by eye,
on stones and mosaics."""

NORMAL = 0.6745
"""The median of the absolute values of what is normally distributed, in standard deviations."""

ALIKE = 0.4
"""Pixels are compared that lie about as deep in their elements: of others one may be shaded and not the other."""

BESIDE = 2.0
"""Those of pixels at most so many from the border: further away copies that go on there agree with less of it."""

RIM = 3.0
"""So far, in pixels, from the inside of an element pixels take their share. Not tuned."""


def evened(canvas: Tensor, parts: Parts, where: Tensor, copied: Tensor, known: Tensor) -> Tensor:
    """The picture (C, H, W) that is copied from places, `where` (2, H, W), of a canvas (C, *S), its elements evened.

    parts: the canvas's elements. copied (2, H, W): where pixels that are known, of colors known (C, H, W), lie on the
    canvas, below 0 for those that are not. Known pixels stay. Colors stay within the canvas's range.
    """
    given = GivenCopies(where.shape[1:], copied)
    there, free = given.covered(where, canvas.shape[1:]), torch.from_numpy(~given.where)
    colors, insides = canvas[:, there[0], there[1]], torch.from_numpy(np.where(parts.core, parts.number, 0))
    own, deep = tuple(torch.where(free, there, copied)), torch.from_numpy(parts.deep)
    inside = insides[own] > 0
    beside = torch.from_numpy(ndimage.distance_transform_edt(given.where) <= BESIDE)
    alike = (deep[own] - deep[tuple(there)]).abs() <= ALIKE
    held = inside & (insides[tuple(there)] > 0) & alike & beside & ~free
    share = _blurred(held.float())
    fixed = torch.where(held, _blurred((known - colors) * held) / share.clamp(min=1e-9), 0.0)
    part = (free & inside) | held
    pairs, steps = zip(*(_joined(canvas, insides, deep, there, part, free, axis) for axis in (0, 1)), strict=True)
    added = membrane(free & inside, pairs, steps, REACH * parts.size, fixed) + fixed
    away, near = ndimage.distance_transform_edt(~part.numpy(), return_indices=True)
    added = added[(slice(None), *torch.from_numpy(near))] * torch.from_numpy(away <= RIM)
    added *= _share(canvas, parts)[tuple(there)]
    added += _softened(known - colors - added, free)
    low, high = canvas.flatten(1).amin(1)[:, None, None], canvas.flatten(1).amax(1)[:, None, None]
    return torch.where(free, torch.minimum(torch.maximum(colors + added, low), high), known)


def _softened(missing: Tensor, free: Tensor) -> Tensor:
    """What is added (C, H, W) to free pixels, so that their border shows no step, given what others are missing."""
    return membrane(free, every_pair(free.shape), [torch.zeros_like(missing)] * 2, SOFT, missing)


def _joined(
    canvas: Tensor, insides: Tensor, deep: Tensor, there: Tensor, part: Tensor, free: Tensor, axis: int
) -> tuple[Tensor, Tensor]:
    """Which pixels (H, W) go together with the next along an axis, and by how much what is added rises (C, H, W).

    They do where both are inside of elements, about as deep, and each of these goes on there, by its number in
    `insides` (*S). It rises by what the colors miss of the mean of both copies' gradients.
    """
    ahead = _beyond(there, axis, 1, insides.shape)
    after = there.roll(-1, axis + 1)
    back = _beyond(after, axis, -1, insides.shape)
    together = part & part.roll(-1, axis) & (free | free.roll(-1, axis))
    for at, beyond in ((there, ahead), (after, back)):
        together &= insides[tuple(at)] == insides[tuple(beyond)]
    together &= (deep[tuple(there)] - deep[tuple(after)]).abs() <= ALIKE
    together.select(axis, -1).fill_(False)
    ours, further, before, theirs = (canvas[(slice(None), *at)] for at in (there, ahead, back, after))
    steps = ((further - ours) + (theirs - before)) / 2 - (theirs - ours)
    return together.float(), steps * (free & free.roll(-1, axis))


def _beyond(there: Tensor, axis: int, step: int, shape: torch.Size) -> Tensor:
    """The places (2, H, W) one step further along an axis, as far as the canvas goes."""
    moved = there.clone()
    moved[axis] = (moved[axis] + step).clamp(0, shape[axis] - 1)
    return moved


def _share(canvas: Tensor, parts: Parts) -> Tensor:
    """By how much each place's color is that of its element (*S), 0 to 1, where the ground's median is 0.

    Deep in an element it is all of that.
    """
    colors, ground = canvas.double().numpy(), canvas.double().numpy()[:, parts.number == 0]
    if ground.size == 0:
        return torch.ones(parts.number.shape)
    middle, spread = middle_of(ground)  # some of it is none
    varied = float(np.square(spread / NORMAL).sum())
    counted = np.where(parts.core, parts.number, 0)
    means = np.stack([ndimage.mean(channel, counted, np.arange(parts.number.max() + 1)) for channel in colors])
    near = nearest_known(torch.from_numpy(parts.number > 0)).numpy()
    apart, own = (means - middle[:, None])[:, parts.number[tuple(near)]], colors - middle[:, None, None]
    share = ((apart * own).sum(0) + varied) / np.maximum(np.square(apart).sum(0) + varied, 1e-12)
    return torch.from_numpy(np.maximum(share, (parts.deep - SHADED) / (DEEP - SHADED)).clip(0, 1).astype(np.float32))


def _blurred(values: Tensor) -> Tensor:
    """Values (..., H, W) averaged over about SMOOTH pixels."""
    sigmas = (*[0.0] * (values.ndim - 2), SMOOTH, SMOOTH)
    return torch.from_numpy(ndimage.gaussian_filter(values.numpy(), sigmas, mode="constant"))
