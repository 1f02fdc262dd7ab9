"""Thin-plate splines, thousands of small ones at once: the smoothest displacements that nearly meet those of points.

A spline f(x) = sum_i w_i phi(|x - p_i|) + c + A x with phi(r) = r^2 log r is what minimizes

    sum_i |f(p_i) - v_i|^2 + smoothing * (J(f) + |A|^2 / tilt)

for values v_i at points p_i. J is the bending energy divided by 8 pi (Duchon, Splines minimizing rotation-invariant
semi-norms in Sobolev spaces, 1977; Wahba, Spline Models for Observational Data, 1990, chapter 2), and A the slope of
the plane through f at the corners of a square, so nothing is charged for a shift. Chui and Rangarajan (2000) charge
for the slope as well: points in few places, or nearly on a line, say nothing of it, and what is not charged is
anything there. As tilt grows this is the usual thin-plate spline.

With the plane at the corners taken off, phi is a positive definite kernel; with tilt times the product of places added
it is the whole penalty's, G. Between functions of mean 0 it is decomposed once into its modes (Demmler and Reinsch):
E diag(d) E^T. Any smoothing is then only a gain d / (d + smoothing) for each mode, which is what annealing needs.
"""

from dataclasses import dataclass

import torch
from torch import Tensor

_CHUNK = 1 << 19
"""Kernel values that are held at once where splines are evaluated."""
_TINY = torch.finfo(torch.float32).tiny


@dataclass(frozen=True)
class ThinPlates:
    """Sets of points made ready for splines through them; `ThinPlates.of` points.

    points (B, n, 2); there (B, n): which of them count; corners (4, 2) of the square; tilt: see the module. shares (B,
    n, 4): what the plane through values at the corners is at the points, as a matrix. modes (B, n, n) and stiffness
    (B, n): see the module, 0 where there is none. level (B, 1, n): means of G's columns.
    """

    points: Tensor
    there: Tensor
    corners: Tensor
    tilt: float
    shares: Tensor
    modes: Tensor
    stiffness: Tensor
    level: Tensor

    @classmethod
    def of(cls, points: Tensor, there: Tensor, width: float, tilt: float) -> "ThinPlates":
        """Those of points (B, n, 2), floating, of which the ones that are `there` (B, n) count; no two at one place.

        width: of the square, in px, one corner of which is (0, 0). tilt > 0: see the module.
        """
        counted = there.to(points)[..., None]
        points = points * counted
        corners = width * torch.tensor([[0.0, 0], [1, 0], [0, 1], [1, 1]]).to(points)
        middle = width / 2
        both, apart = counted * counted.mT, points - middle
        shares = counted * (0.25 + apart @ (corners - middle).T / width**2)
        across = shares @ _kernel(corners[None], points)
        around = shares @ _kernel(corners[None], corners[None]) @ shares.mT
        penalty = (_kernel(points, points) - across - across.mT + around + tilt * (apart @ apart.mT)) * both
        level = _mean(penalty, counted)
        centered = penalty - (level + level.mT - _mean(level.mT, counted)) * both
        stiffness, modes = torch.linalg.eigh(centered)
        rounding = torch.finfo(points.dtype).eps * points.shape[1] * stiffness[:, -1:]
        stiffness = stiffness * (stiffness > rounding)
        modes = (modes - _mean(modes, counted)) * counted
        return cls(points, there, corners, tilt, shares, modes, stiffness, level)

    def smoothed(self, values: Tensor, smoothing: Tensor | float) -> Tensor:
        """What the splines for values (B, n, k) are at their own points, (B, n, k); 0 at points that are not there.

        smoothing: from 0 on, in px^2, for all or (B,) for each set; see the module.
        """
        counted = self.there.to(values)[..., None]
        gain = (self.stiffness * self._softness(smoothing))[..., None]
        return self.modes @ (gain * (self.modes.mT @ values)) + _mean(values, counted) * counted

    def splines(self, values: Tensor, smoothing: Tensor | float) -> "Splines":
        """The splines for values (B, n, k) at the points; what is given at points that are not there does not count.

        smoothing: as for `smoothed`. A set of no points has the spline 0, one point a constant.
        """
        bent = self._softness(smoothing)[..., None] * (self.modes.mT @ values)
        weights = self.modes @ bent
        opposed = self.shares.mT @ weights
        around = _kernel(self.corners[None], self.corners[None]) @ opposed
        plane = around - _kernel(self.corners[None], self.points) @ weights  # at the corners
        middle = self.corners.mean(0)
        slope = (self.corners - middle).T @ plane / (2 * middle[0]) ** 2
        slope = slope + self.tilt * ((self.points - middle) * self.there[..., None]).mT @ weights
        shift = _mean(values, self.there.to(values)[..., None]) - self.level @ weights
        level = shift + plane.mean(1, keepdim=True) - (middle[:, None] * slope).sum(1, keepdim=True)
        penalty = (self.stiffness[..., None] * bent.square()).sum((1, 2))
        corners = self.corners.expand(len(weights), -1, -1)
        return Splines(
            torch.cat([self.points, corners], 1),
            torch.cat([weights, -opposed], 1),
            torch.cat([level, slope], 1),
            penalty,
        )

    def _softness(self, smoothing: Tensor | float) -> Tensor:
        """1 / (d + smoothing) for each mode (B, n), 0 for what is none."""
        smoothing = smoothing[:, None] if isinstance(smoothing, Tensor) and smoothing.ndim else smoothing
        return torch.where(self.stiffness > 0, 1 / (self.stiffness + smoothing).clamp(min=_TINY), 0.0)


@dataclass(frozen=True)
class Splines:
    """Splines that were fitted; call them to evaluate them.

    points (B, m, 2), those of the sets and the corners, and the weights (B, m, k) of their kernels; plane (B, 3, k):
    what is multiplied by 1, x and y. penalty (B,): J + |A|^2 / tilt of the module, summed over the k dimensions.
    """

    points: Tensor
    weights: Tensor
    plane: Tensor
    penalty: Tensor

    def __call__(self, places: Tensor) -> Tensor:
        """The splines at places (m, 2) common to all, or (B, m, 2) of each: (B, m, k). Memory: a few times that."""
        count, each = len(self.points), places.shape[-2] * self.points.shape[1]
        common = places.to(self.weights).expand(count, -1, -1)
        made = common @ self.plane[:, 1:] + self.plane[:, :1]
        step = max(_CHUNK // max(each, 1), 1)
        for some in (slice(low, low + step) for low in range(0, count, step)):
            made[some].baddbmm_(_kernel(common[some], self.points[some]), self.weights[some])
        return made


def squared_distances(first: Tensor, second: Tensor) -> Tensor:
    """|x - y|^2 (B, m, n) between places (B, m, 2) and (B, n, 2), exact for whole pixels; rounding may leave it < 0."""
    one, other = first.square().sum(2, keepdim=True), second.square().sum(2, keepdim=True)
    left = torch.cat([one, torch.ones_like(one), first], 2)
    right = torch.cat([torch.ones_like(other), other, -2 * second], 2)
    return left @ right.mT


def _kernel(first: Tensor, second: Tensor) -> Tensor:
    """phi(|x - y|) (B, m, n) between places (B, m, 2) and (B, n, 2); a B of 1 stands for any."""
    square = squared_distances(first, second).clamp_(min=_TINY)
    return square.log().mul_(square).mul_(0.5)


def _mean(values: Tensor, counted: Tensor) -> Tensor:
    """The mean (B, 1, k) of values (B, n, k) that are counted (B, n, 1)."""
    return (values * counted).sum(1, keepdim=True) / counted.sum(1, keepdim=True).clamp(min=1)
