"""Seams of videos that flow are feathered: near one, what is shown passes over from one copy to the other.

Copies agree in the frame in which a cut parted them, and less from frame to frame as each lives on, so that seams, and
the straight sides of blocks most of all, come to be seen. Therefore a pixel shows, besides its own copy, what the
copies around it would show there if they went on, each by its share of what lies around. Within a copy nothing changes,
as it would show the same. The mean of copies that do not agree is flat; its details get back the variance that mixing
takes from them (`fading`), up to that which the exemplar has, on average, where the copies come from: what lies beyond
a seam often is a mean of several copies itself, and tells too little.
"""

from dataclasses import replace

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from flow.animation.carrying import angles, changes, onward
from flow.animation.film import Reading
from flow.animation.showing.fading import strengthened, strengths
from kwatra import Exemplar
from kwatra.base import joined, nearest_known

BEYOND = "bicubic"
"""How copies, colors and maps, are to be read beyond seams: bilinearly .42 of a fountain's gradients are left there."""

_LEAST = 32
"""Copies of fewer pixels are crumbs: what is around goes on over them. It saves most of the time where copies fray."""


def strengths_of(exemplar: Exemplar) -> Reading:
    """How strong details are at each place of an exemplar, a channel for each scale (`fading`)."""
    return Reading(replace(exemplar, canvas=strengths(exemplar.canvas, exemplar.owner >= 0)), "bilinear")


def feathered(
    image: Tensor, source: Tensor, inside: Tensor, read: Reading, reach: int, details: Reading | None
) -> Tensor:
    """A frame (C, H, W) that shows an exemplar at source coordinates (2, H, W), its seams feathered.

    inside (H, W): where there is texture. read: what the exemplar has at coordinates. reach >= 0: up to so many px from
    a seam the copy beyond it is seen, by a Gaussian of half as many; with 0 nothing changes, nor does a frame of one
    copy. A copy goes on from its nearest pixel, turned as it is there. details: how strong they are in the
    exemplar (`strengths_of`), and stay; None for maps, of which nothing is made up.
    """
    if reach == 0:
        return image
    copy = _numbered(source, inside)
    if (np.bincount(copy.ravel())[1:] > 0).sum() < 2:
        return image
    rest, at, nearest, weights = (torch.from_numpy(one) for one in _shares(copy, reach))
    beyond = onward(source[:, *nearest], angles(source)[*nearest], *(at - nearest))

    def mean(own: Tensor, other: Tensor, power: int = 1) -> Tensor:
        """What each pixel's own copy (N, H, W) and the copies beyond (N, M) have, times a power of their shares."""
        beside = torch.zeros_like(own)
        for channel, values in zip(beside.flatten(1), weights**power * other, strict=True):
            channel.index_add_(0, at[0] * own.shape[2] + at[1], values)  # in the order of the copies
        return torch.where(rest > 0, (1 - rest) ** power * own + rest**power * beside, own)

    shown = mean(image, read(beyond))
    if details is not None:
        strong = details(source), details(beyond)
        shown = strengthened(shown, mean(*strong), mean(*strong, 2), inside)
    return torch.where(inside, read.within(shown), image)


def _shares(copy: np.ndarray, reach: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """What is seen of the copies beyond seams, where copies (H, W) are numbered, and 0 where there is none.

    The share (H, W) of all of them; and of each, for each pixel (2, N) that sees it, the nearest that it has (2, N),
    row first, and its part (N,) of that share.
    """
    sizes, whole, own = np.bincount(copy.ravel()), np.zeros(copy.shape, np.float32), np.zeros(copy.shape, np.float32)
    pixels, nearest, weights = [np.zeros((2, 0), np.int64)], [np.zeros((2, 0), np.int64)], [np.zeros(0, np.float32)]
    for number, box in enumerate(ndimage.find_objects(copy), 1):
        if sizes[number] < _LEAST:
            continue
        part = tuple(slice(max(side.start - reach, 0), side.stop + reach) for side in box)
        here = copy[part] == number
        share = ndimage.gaussian_filter(here.astype(np.float32), reach / 2, mode="constant", radius=reach)
        whole[part] += share
        own[part] += share * here
        beyond = (share > 0) & ~here & (copy[part] > 0)
        if beyond.any():
            there = nearest_known(torch.from_numpy(here)).numpy()
            corner = [[side.start] for side in part]
            pixels.append(np.array(beyond.nonzero()) + corner)
            nearest.append(there[:, beyond] + corner)
            weights.append(share[beyond])
    at, rest = np.concatenate(pixels, 1), whole - own
    return rest / whole.clip(1e-9), at, np.concatenate(nearest, 1), np.concatenate(weights) / rest[*at]


def _numbered(source: Tensor, inside: Tensor) -> np.ndarray:
    """The number of the copy that each pixel belongs to, (H, W), and 0 where not inside; not all numbers are used."""
    (_, down), (_, right) = changes(source)
    links = down & inside[1:] & inside[:-1], right & inside[:, 1:] & inside[:, :-1]
    _, copies = joined(*(link.numpy() for link in links))
    numbered: np.ndarray = np.where(inside.numpy(), copies + 1, 0)
    return numbered
