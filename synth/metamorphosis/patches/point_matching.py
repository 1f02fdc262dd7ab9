"""Which feature points of two patches correspond, and the splines that bring one onto the other, and back.

Robust point matching by deterministic annealing (Chui and Rangarajan, A new algorithm for non-rigid point matching,
2000), as patches need it (Ruiters et al., Patch-based Texture Interpolation, 2010, section 4.2). It lowers

    sum_ij m_ij |theta(p_i) - q_j|^2 + R(theta)                                                     (equation 1)

in turns: soft correspondences m for given splines, with a row and a column for outliers, at a temperature T; and
thin-plate splines for given correspondences, stiff in proportion to T. T falls from the square of a part of the
patch's width to that of a part of the spacing of the points. Both directions share the correspondences: how far a pair
is apart is the mean of both, and rows and columns are normalized at once, so nothing depends on which set is first.
All lengths follow the patch's width, so patches of twice the size are matched alike.

Where this goes beyond both papers:
- A point's soft partner is drawn to the middle of the other set, most of all at the border and while T is high. The
  point's soft partner in its own set is drawn alike, so the difference of the two is what the point moves by (as in
  Sinkhorn divergences; Feydy et al., Interpolating between Optimal Transport and MMD, 2019). Sets that are one and the
  same so give exactly the identity, and T need not fall until partners are hard.
- A point that is an outlier in part follows the spline before it in so much. In the last iteration it keeps its own
  place instead, as in the paper of Ruiters et al., and so holds the spline back.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import NamedTuple

import torch
import torch.nn.functional as F
from torch import Tensor

from synth.metamorphosis.patches.feature_points import Points
from synth.metamorphosis.patches.thin_plate import Splines, ThinPlates, squared_distances

# Tuned on patches of 33x33 px: edges (Canny, 2.5 and 4 px) of paving stones, rocks, nuts, bricks and hexagonal tiles,
# and clouds of points, moved by known warps of 1 to 2.5 px (rms) with three parts in ten outliers; and neighborhoods
# of five pairs of textures, by how far edges are apart after warping and that nothing folds. Within a factor of 2
# little changes.
_STEPS = 10
"""Temperatures, one iteration each; twice as many gain nothing."""
_SCALINGS = 2
"""Normalizations of rows and columns per iteration."""
_START = 0.12
"""The square root of the first temperature, in widths of the patch."""
_END = 0.3
"""The square root of the last temperature, in spacings of the points."""
_DENSEST = 0.08
"""A spacing, in widths of the patch, below which points are not told apart: few pixels in a row bend no patch."""
_OUTLIER = 0.12
"""How far apart, in widths of the patch, a pair rather is two outliers."""
_STIFF = 60.0
"""The spline's smoothing per temperature, the same for any number of points: few bend a patch less than many."""
_TILT = 1.0
"""How much rather a spline tilts than bends."""

_CHUNK = 1 << 18
"""Pairs of points, of all problems, that are matched at once."""
_FAINTEST = -30.0
"""The least exponent, so that no sum of pairs is 0."""
_NONE = 1e-6
"""What is less counts as this much: a guard against dividing by 0."""


@dataclass(frozen=True)
class Matching:
    """What `match` found for B pairs of sets.

    there and back: splines whose values are displacements in px, x first: a point p of the first set comes to
    p + there(p) in the second patch, a point q of the second to q + back(q) in the first. correspondences (B, n, m):
    how much each pair is one, 0 to 1; rows and columns sum to 1 at most, and what is missing is outlier. error (B,):
    equation 1, the mean of both directions, in px^2.
    """

    there: Splines
    back: Splines
    correspondences: Tensor
    error: Tensor


def match(first: Points, second: Points, width: int) -> Matching:
    """Match B pairs of sets of points, n and m of them at most, of patches `width` px wide.

    What, after all bending, has no partner within an eighth of the width is an outlier. A set without points gives the
    identity. Memory: what is returned, and 40 MB. Cost: 2 cpu seconds for 4000 pairs of 32 points on one thread.
    """
    step = max(_CHUNK // max(first.there.shape[1] * second.there.shape[1], 1), 1)
    rows, columns = first.there.shape[1], second.there.shape[1]
    first, second = (_never_empty(side) for side in (first, second))
    parts = []
    for low in range(0, max(len(first.there), 1), step):
        one, two = (Points(*(tensor[low : low + step] for tensor in side)) for side in (first, second))
        parts.append(_Annealing(one, two, width).matched())
    return Matching(
        _joined([part.there for part in parts]),
        _joined([part.back for part in parts]),
        torch.cat([part.correspondences for part in parts])[:, :rows, :columns],
        torch.cat([part.error for part in parts]),
    )


class _Softassign:
    """Soft correspondences of pairs of sets, or of sets with themselves, with room for outliers.

    The factors of rows and columns are kept from one temperature to the next, so a few normalizations each are enough.
    """

    def __init__(self, first: Points, second: Points, outlier: float) -> None:
        self._alike, self._outlier = first is second, outlier
        self._both = (first.there[:, :, None] & second.there[:, None]).to(first.places)
        self._row = torch.ones_like(self._both[:, :, :1])
        self._column = torch.ones_like(self._both[:, :1].mT)

    def __call__(self, square: Tensor, temperature: Tensor) -> Tensor:
        """Those (B, n, m) of points whose squared distances are given, at a temperature (B,), in px^2."""
        spread = (2 * temperature)[:, None, None]
        kernel = (square / -spread).clamp_(min=_FAINTEST).exp_().mul_(self._both)
        outlier = (-self._outlier / (2 * spread)).exp()
        for _ in range(_SCALINGS):  # half a step each, so that neither comes first
            row = (self._row / (kernel @ self._column + outlier)).sqrt()
            other = row if self._alike else (self._column / (kernel.mT @ self._row + outlier)).sqrt()
            self._row, self._column = row, other
        soft = kernel.mul_(self._row).mul_(self._column.mT)
        excess = torch.maximum(soft.sum(2, keepdim=True), soft.sum(1, keepdim=True)).clamp_(min=1)
        return soft.div_(excess)


class _Side:
    """One set of each pair, ready for splines and for being matched with itself."""

    def __init__(self, points: Points, width: int, outlier: float) -> None:
        self.places, self.plates = points.places, ThinPlates.of(*points, width, _TILT)
        self._square = squared_distances(points.places, points.places)
        self._softassign = _Softassign(points, points, outlier)

    def own(self, temperature: Tensor) -> Tensor:
        """The set's soft correspondences (B, n, n) with itself."""
        return self._softassign(self._square, temperature)


class _Goal(NamedTuple):
    """Where a set should go: displacements (B, n, 2), already less where a point is an outlier; inlying (B, n, 1)."""

    displacements: Tensor
    inlying: Tensor


class _Annealing:
    """Pairs of sets, from the first temperature to the last."""

    def __init__(self, first: Points, second: Points, width: int) -> None:
        outlier = (_OUTLIER * width) ** 2
        self._sides = (_Side(first, width, outlier), _Side(second, width, outlier))
        self._softassign = _Softassign(first, second, outlier)
        spacing = torch.stack([_spacing(side, width) for side in (first, second)]).mean(0)
        start, end = (_START * width) ** 2, (_END * spacing.clamp(min=_DENSEST * width)) ** 2
        self._temperatures = [start * (end / start) ** (k / (_STEPS - 1)) for k in range(_STEPS)]

    def matched(self) -> Matching:
        """The matching at the last temperature."""
        moved = [torch.zeros_like(side.places) for side in self._sides]
        for temperature in self._temperatures[:-1]:
            _, goals = self._corresponding(moved, temperature)
            moved = [
                side.plates.smoothed(goal.displacements + (1 - goal.inlying) * at, _STIFF * temperature)
                for side, goal, at in zip(self._sides, goals, moved, strict=True)
            ]
        last = self._temperatures[-1]
        correspondences, goals = self._corresponding(moved, last)
        error, splines = torch.zeros_like(last), []
        for side, goal in zip(self._sides, goals, strict=True):
            splines.append(side.plates.splines(goal.displacements, _STIFF * last))
            error += _STIFF * last * splines[-1].penalty / 2
        moved = [spline(side.places) for spline, side in zip(splines, self._sides, strict=True)]
        error += (correspondences * self._apart(moved)).sum((1, 2))
        return Matching(splines[0], splines[1], correspondences, error)

    def _corresponding(self, moved: Sequence[Tensor], temperature: Tensor) -> tuple[Tensor, list[_Goal]]:
        """Correspondences (B, n, m) of points that were moved by (B, n, 2) and (B, m, 2), and what both sets want."""
        soft = self._softassign(self._apart(moved), temperature)
        first, second = self._sides
        return soft, [
            _goal(partners, side.own(temperature), side.places, other.places)
            for side, other, partners in ((first, second, soft), (second, first, soft.mT))
        ]

    def _apart(self, moved: Sequence[Tensor]) -> Tensor:
        """How far apart pairs are (B, n, m), squared: the mean of both directions."""
        p, q = (side.places for side in self._sides)
        return (squared_distances(p + moved[0], q) + squared_distances(p, q + moved[1])) / 2


def _goal(partners: Tensor, own: Tensor, places: Tensor, others: Tensor) -> _Goal:
    """What points (B, n, 2) want that correspond to others (B, m, 2) by (B, n, m), and to themselves by (B, n, n)."""
    mass, whole = partners.sum(2, keepdim=True), own.sum(2, keepdim=True).clamp(min=_NONE)
    apart = (partners @ others) / mass.clamp(min=_NONE) - (own @ places) / whole
    inlying = (mass / whole).clamp(max=1)
    return _Goal(inlying * apart, inlying)


def _spacing(points: Points, width: int) -> Tensor:
    """The mean distance (B,) to the nearest neighbor, a quarter of the width at most; that for sets of less than 2."""
    both = points.there[:, :, None] & points.there[:, None]
    same = torch.eye(both.shape[1], dtype=torch.bool, device=both.device)
    square = squared_distances(points.places, points.places).masked_fill(~both | same, float("inf"))
    near = square.clamp(min=_NONE, max=(width / 4) ** 2).sqrt().amin(2) if both.shape[1] else square.sum(2)
    count = points.there.sum(1)
    return torch.where(count > 1, (near * points.there).sum(1) / count.clamp(min=1), width / 4)


def _never_empty(points: Points) -> Points:
    """With one point that is not there, where there is no room for any."""
    places, there = points
    return Points(F.pad(places, (0, 0, 0, 1)), F.pad(there, (0, 1))) if not there.shape[1] else points


def _joined(parts: Sequence[Splines]) -> Splines:
    return Splines(*(torch.cat([getattr(part, field.name) for part in parts]) for field in fields(Splines)))
