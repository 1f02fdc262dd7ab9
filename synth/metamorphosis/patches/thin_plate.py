"""Thin-plate splines, thousands of small ones at once: the smoothest displacements that nearly meet those of points.

A spline f(x) = sum_i w_i phi(|x - p_i|) + c + A x, with phi(r) = r^2 log r and the w_i orthogonal to all linear
functions, is what minimizes

    sum_i |f(p_i) - v_i|^2 + smoothing * w^T Phi w + slope * |A'|^2

for values v_i at points p_i (Duchon, Splines minimizing rotation-invariant semi-norms in Sobolev spaces, 1977; Wahba,
Spline Models for Observational Data, 1990, chapter 2). w^T Phi w is the bending energy divided by 8 pi; A' is the slope
of the plane that is nearest to f at the points, so that nothing is charged for a shift.

Phi between functions orthogonal to planes is decomposed once into its modes (Demmler and Reinsch): E diag(d) E^T. Any
smoothing is then only a gain d / (d + smoothing) for each mode, which is what annealing needs.
"""

from dataclasses import dataclass

import torch
from torch import Tensor

_CHUNK = 1 << 19
"""Kernel values that are held at once where splines are evaluated."""
_NOTHING = 1e-5
"""Modes softer than this share of the stiffest, and extents below this share of the largest, are rounding."""


@dataclass(frozen=True)
class ThinPlates:
    """Sets of points made ready for splines through them; `ThinPlates.of` points.

    points (B, n, 2), there (B, n): which of them count. planes (B, n, 3): an orthonormal basis of linear functions at
    the points: the constant, and those along the set's two principal axes (B, 2, 2), one per row, around its center
    (B, 1, 2), whose root sums of squares are extent (B, 2); where the points have no extent along an axis its column
    is 0. modes (B, n, n) and stiffness (B, n): see the module; 0 where there is none.
    """

    points: Tensor
    there: Tensor
    center: Tensor
    axes: Tensor
    extent: Tensor
    planes: Tensor
    modes: Tensor
    stiffness: Tensor

    @classmethod
    def of(cls, points: Tensor, there: Tensor) -> "ThinPlates":
        """Those of points (B, n, 2), floating, of which the ones that are `there` (B, n) count; no two at one place."""
        counted = there.to(points)
        points = points * counted[..., None]
        center = points.sum(1, keepdim=True) / counted.sum(1).clamp(min=1)[:, None, None]
        apart = (points - center) * counted[..., None]
        axes = _principal_axes(apart)
        along = apart @ axes.mT
        extent = along.square().sum(1).sqrt()
        extent = extent * (extent > _NOTHING * extent[:, :1])
        constant = counted / counted.sum(1, keepdim=True).clamp(min=1).sqrt()
        planes = torch.cat([constant[..., None], along * _inverse(extent)[:, None]], 2)
        projected = _without(planes, _without(planes, _kernel(points, points)).mT)
        stiffness, modes = torch.linalg.eigh(projected * counted[:, :, None] * counted[:, None])
        stiffness = stiffness * (stiffness > _NOTHING * stiffness[:, -1:])
        modes = _without(planes, modes)  # far from the points, what rounding leaves would grow
        return cls(points, there, center, axes, extent, planes, modes, stiffness)

    def smoothed(self, values: Tensor, smoothing: Tensor | float, slope: Tensor | float = 0.0) -> Tensor:
        """What the splines for values (B, n, k) are at their own points, (B, n, k); 0 at points that are not there.

        smoothing and slope: from 0 on, in px^2, for all or (B,) for each set; see the module.
        """
        gain = self.stiffness * self._softness(smoothing)
        bent = self.modes @ (gain[..., None] * (self.modes.mT @ values))
        return bent + self.planes @ (self._tilt(slope) * (self.planes.mT @ values))

    def splines(self, values: Tensor, smoothing: Tensor | float, slope: Tensor | float = 0.0) -> "Splines":
        """The splines for values (B, n, k) at the points; what is given at points that are not there does not count.

        smoothing and slope: as for `smoothed`. A set of no points has the spline 0; one point a constant; points on
        a line do not bend or tilt it across.
        """
        bent = self._softness(smoothing)[..., None] * (self.modes.mT @ values)
        weights = self.modes @ bent
        linear = self._tilt(slope) * (self.planes.mT @ values)
        linear = linear - self.planes.mT @ (_kernel(self.points, self.points) @ weights)
        bending = (self.stiffness[..., None] * bent.square()).sum((1, 2))
        return Splines(self.points, weights, self._plane(linear), bending)

    def _plane(self, linear: Tensor) -> Tensor:
        """The linear function (B, 3, k) of (1, x, y) that is a mixture of `planes`."""
        tilted = self.axes.mT @ (linear[:, 1:] * _inverse(self.extent)[..., None])
        level = linear[:, :1] * _inverse(self.there.sum(1).to(linear)).sqrt()[:, None, None]
        return torch.cat([level - self.center @ tilted, tilted], 1)

    def _softness(self, smoothing: Tensor | float) -> Tensor:
        """1 / (d + smoothing) for each mode (B, n), 0 for what is none."""
        return _inverse(self.stiffness + _column(smoothing)) * (self.stiffness > 0)

    def _tilt(self, slope: Tensor | float) -> Tensor:
        """What is left of each linear function (B, 3, 1)."""
        square = self.extent.square()
        left = square * _inverse(square + _column(slope))
        return torch.cat([torch.ones_like(left[:, :1]), left], 1)[..., None]


@dataclass(frozen=True)
class Splines:
    """Splines that were fitted; call them to evaluate them.

    points (B, n, 2) and the weights (B, n, k) of their kernels; plane (B, 3, k): what is multiplied by 1, x and y.
    bending (B,): w^T Phi w, summed over the k dimensions.
    """

    points: Tensor
    weights: Tensor
    plane: Tensor
    bending: Tensor

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
    """phi(|x - y|) (B, m, n) between places (B, m, 2) and (B, n, 2)."""
    square = squared_distances(first, second).clamp_(min=torch.finfo(first.dtype).tiny)
    return square.log().mul_(square).mul_(0.5)


def _principal_axes(apart: Tensor) -> Tensor:
    """Unit vectors (B, 2, 2), one per row, along which vectors (B, n, 2) are largest and smallest."""
    x, y = apart.unbind(2)
    angle = 0.5 * torch.atan2(2 * (x * y).sum(1), (x.square() - y.square()).sum(1))
    across, down = angle.cos(), angle.sin()
    return torch.stack([torch.stack([across, down], 1), torch.stack([-down, across], 1)], 1)


def _without(planes: Tensor, columns: Tensor) -> Tensor:
    """Columns (B, n, m) less what of them is linear."""
    return columns - planes @ (planes.mT @ columns)


def _inverse(values: Tensor) -> Tensor:
    """1 / values, 0 where they are 0."""
    return torch.where(values > 0, 1 / values.clamp(min=torch.finfo(values.dtype).tiny), 0.0)


def _column(value: Tensor | float) -> Tensor | float:
    return value[:, None] if isinstance(value, Tensor) and value.ndim else value
