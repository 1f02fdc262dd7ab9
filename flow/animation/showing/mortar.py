"""Mortar along the torn seams of a wall that flows.

Copies of a wall slide past each other, and blocks that enter it end within bricks: along such a seam a brick is grown
onto a part of another. So what lies beside it is shown as what lies beside a joint of the exemplar: at each distance
from the seam the exemplar is read as far from the middle of the joint that is nearest to what the copy shows there. A
brick that is torn is then seen as a shorter one, and what is narrower than a joint is mortar. The copies themselves,
which are carried on, stay as they are.

What is just torn, or just long enough to count, is so in one frame and not in the next, and seams go from pixel to
pixel as they flow: the distance is a mean over frames, carried along.
"""

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from flow.animation.carrying import parted, turned
from flow.animation.film import Film, nearest_pixels
from flow.warps import Lookup, warp
from kwatra import Exemplar
from kwatra.elements.parting import Array
from kwatra.elements.splits import RIM

_JOINTS = 0.75
"""Places less deep in elements than so many px are joints: those next to a joint are 1 px deep, and joints that were
looked for at half the size .5 px."""

_REACH, _HALF, _BEYOND = 0.25, 0.5, 2.0
"""Joints reach up to so much of an element's size from their middles: so many times as far as where half is left of
what they and elements differ by, as their rims are shaded. Not tuned."""

_ONE = 0.25
"""Two elements make up one where they lie upon each other but for so much of their size. Not tuned."""

_ALIKE, _AS_FAR = 0.7, 1.4
"""A seam is not seen at which copies differ by less than so many standard deviations, and lie as far from a joint but
for so many px, as those of one that goes on in step: a weave has no mortar then, and stills of walls hardly any. By
eye, of a weave and three walls.
"""

_SHORT = 0.25
"""Torn seams of less than so much of an element's size are left alone: what is torn there is hardly seen, and comes and
goes."""

_LONGER = 3
"""So many px a torn seam goes on into what is not torn, so that its joint meets others. Not tuned."""

_SMOOTH = 1.0
"""Over so many px, as a Gaussian has it, joints are straighter than the seams that they follow; 2 is as good."""

_BROAD = 0.75
"""Up to so many px from a seam the very middle of a joint is shown: joints of two pixels have a middle of as many, and
the least of a mean over frames is no 0.
"""

_KEPT = 0.5
"""What the frame before counts in the mean over frames. Walls made in code, of yellow brick and skimage's, 40 frames in
a pair of vortices, flicker by .117 with 0, .114 with .6, .111 with .75, and .108 without mortar; with 0 mortar is seen
to blink. But what is new comes late: of bricks of 24 px that turn .17 are grown onto others with 0, .20 with .5, .25
with .6, .31 without mortar.
"""

_AFTER = ((0, 1), (1, 0))
"""The steps, in rows and columns, to the pixels after one along the axes."""


class Mortar:
    """The joints of an exemplar, to be shown where seams tear its elements.

    exemplar: of a picture, (H, W). joints (H, W): where it has joints, somewhere; size: that of its elements, in px.
    """

    def __init__(self, exemplar: Exemplar, joints: Array, size: float) -> None:
        self._inside = exemplar.owner.numpy() >= 0
        deep = ndimage.distance_transform_edt(joints)
        middle = self._inside & joints & (deep == ndimage.maximum_filter(deep, 3))
        away, self._nearest = ndimage.distance_transform_edt(~middle, return_indices=True)
        self._joints, self._reach = joints, _reach_of(exemplar, away, _REACH * size)
        self._one, self._short = _ONE * size, _SHORT * size
        self._center = _centers(joints)
        colors = exemplar.canvas * (exemplar.share / max(exemplar.variance, 1e-9)).sqrt()
        self._looks = np.concatenate([colors.numpy() / _ALIKE, away[None] / _AS_FAR])

    @classmethod
    def of(cls, film: Film) -> "Mortar | None":
        """That of a picture whose long elements are parted by a net of joints; None of others, and of videos."""
        hidden = film.hidden
        if hidden is None or not hidden.long:
            return None
        depth = (hidden.depth - hidden.depth.min()) / hidden.hides
        return cls(film.strip, depth * RIM * hidden.size < _JOINTS, hidden.size)

    def torn(self, source: Tensor, inside: Tensor, look: Lookup | None = None, before: Tensor | None = None) -> Tensor:
        """How far in px (H, W) pixels of source coordinates (2, H, W), x first, are from seams that tear elements.

        A little beyond what joints reach at most. inside (H, W): where there is texture. before (H, W): the same of the
        frame before, which is carried as `look` says; by default each frame stands for itself.
        """
        away = _away(*self._seams(source, inside), self._short, self._reach + 1)
        if look is None or before is None:
            return away
        carried = warp(before[None], look.coordinates, "bilinear")[0]
        return torch.where(look.known, away + _KEPT * (carried - away), away)

    def shown(self, source: Tensor, inside: Tensor, torn: Tensor) -> Tensor:
        """Where to read what is shown of source coordinates (2, H, W) inside (H, W), torn (H, W) as above.

        What is farther from torn seams than joints reach, or shows a joint, or is nearer to one, stays bit for bit.
        """
        if not bool((torn < self._reach).any()):
            return source
        row, column = self._pixels(source)
        place = torch.from_numpy(np.stack([self._nearest[1][row, column], self._nearest[0][row, column]])).float()
        beside, near = source - place, (torn - _BROAD).clamp(min=0)
        far = beside.square().sum(0).sqrt()
        moved = place + beside * (near / far.clamp(min=1e-6))
        within = torch.from_numpy(~self._joints[row, column] & self._inside[self._pixels(moved)]) & inside
        return torch.where(within & (torn < self._reach) & (near < far), moved, source)

    def _pixels(self, source: Tensor) -> tuple[Array, Array]:
        """The exemplar's rows and columns, (H, W) each, nearest to source coordinates (2, H, W)."""
        row, column = nearest_pixels(source, self._joints.shape).numpy()
        return row, column

    def _seams(self, source: Tensor, inside: Tensor) -> tuple[Array, Array]:
        """Pixels (H, W) beside seams of source coordinates (2, H, W), and beside those that tear elements.

        A joint that is beside a seam parts what it would tear, and what is not seen tears nothing.
        """
        found, goes_on = parted(source, inside, turned(source, inside), _AFTER)
        row, column = self._pixels(source)
        joint, torn = self._joints[row, column], np.zeros(found.shape, bool)
        for step, seam, onward, tears in zip(_AFTER, found.numpy(), goes_on, torn, strict=True):
            here = np.nonzero(seam)
            there = tuple(at + by for at, by in zip(here, step, strict=True))
            own, other = (np.stack([row[at], column[at]]) for at in (here, there))
            beyond = onward[:, torch.from_numpy(seam)]
            shift = (beyond - source[:, torch.from_numpy(seam)]).numpy()
            beside = ndimage.maximum_filter1d(joint, 2 * round(self._reach) + 1, 0 if step[0] else 1)
            one = np.linalg.norm(shift - self._center[:, *other] + self._center[:, *own], axis=0) < self._one
            unseen = np.linalg.norm(self._looks[:, *own] - self._looks[:, *self._pixels(beyond)], axis=0) < 1
            tears[here] = ~(beside[here] | beside[there] | one | unseen)
        return _beside(*found.numpy()), _beside(*torn)


def _centers(joints: Array) -> Array:
    """The center of the box around the element that each place shows, (2, H, W), x first; joints (H, W)."""
    number, _ = ndimage.label(~joints)
    boxes = [(slice(0, 0), slice(0, 0)), *ndimage.find_objects(number)]
    centers = np.array([[(part.start + part.stop - 1) / 2 for part in reversed(box)] for box in boxes], np.float32)
    return centers.T[:, number]


def _beside(right: Array, down: Array) -> Array:
    """Pixels (H, W) on both sides of seams to the pixels on their right (H, W), and below."""
    beside: Array = right | down
    beside[:, 1:] |= right[:, :-1]
    beside[1:] |= down[:-1]
    return beside


def _away(seams: Array, torn: Array, short: float, most: float) -> Tensor:
    """How far in px pixels (H, W) are from seams that are torn, at most `most`, given those beside seams (H, W).

    They go on along seams that are not torn, by _LONGER; those of fewer than `short` px are left out. They are
    smoothed: the square of the distance from a straight one is blurred to itself and the blur's variance.
    """
    around = np.ones((3, 3))
    longer = ndimage.binary_dilation(torn, around, _LONGER, mask=seams) if torn.any() else torn
    number, _ = ndimage.label(longer, around)
    long = np.bincount(number[torn], minlength=number.max() + 1) >= 2 * short
    if not long.any():
        return torch.full(torn.shape, most)
    squared = (ndimage.distance_transform_edt(~long[number]).astype(np.float32) + 0.5) ** 2
    away = torch.from_numpy(ndimage.gaussian_filter(squared, _SMOOTH) - _SMOOTH**2).clamp(min=0).sqrt()
    return away.clamp(max=most)


def _reach_of(exemplar: Exemplar, away: Array, most: float) -> float:
    """How far in px from the middle of joints places look like joints, at most `most`, by mean colors.

    away (H, W): how far they are from it.
    """
    colors = (exemplar.canvas * exemplar.share.sqrt()).flatten(1).double().numpy()
    number = np.minimum(away.ravel().round(), int(most) + 1).astype(np.int64)
    count = np.maximum(np.bincount(number, minlength=int(most) + 2), 1)
    means = np.stack([np.bincount(number, channel, minlength=len(count)) / count for channel in colors])
    off = np.linalg.norm(means - means[:, -1:], axis=0)
    return min(_BEYOND * max(int(np.argmax(off <= _HALF * off[0])), 1), most)
