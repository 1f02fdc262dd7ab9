"""A warp through scattered points: multilevel free-form deformation.

A lattice of cubic B-splines is laid over the frame; its control points are the weighted means of what the points
near them ask for (Lee, Wolberg and Shin, Scattered Data Interpolation with Multilevel B-Splines, 1997, equations 3 to
5). What a lattice leaves unmet the next one, half as wide, is fitted to. The warp is the composition of the points'
mean shift and all lattices.

A lattice whose control points move by less than 0.48 of its spacing along each axis is one-to-one (Lee, Chwa and
Shin, Image Metamorphosis Using Snakes and Free-Form Deformations, 1995), and so is a composition of such; control
points are held to that, and lattices are repeated for what they could not reach at once. Nothing folds; but where
much is squeezed between two pixels, their samples of the warp may cross.
"""

from dataclasses import dataclass

import torch
from torch import Tensor

from flow.warps.warp import pixel_coordinates
from kwatra.base import InputError

BOUND = 0.48
"""Share of a lattice's spacing that control points may move without a fold."""

REPEATS = 8
"""So often a lattice is fitted at most to what its bound kept it from."""

_GAIN = 0.98
"""And as long as less than this share of it is left by each."""


def free_form(
    points: Tensor,
    displacements: Tensor,
    shape: tuple[int, int] | torch.Size,
    tolerance: float = 0.5,
    finest: float = 1.0,
    wrap: bool = False,
    repeats: int = REPEATS,
) -> Tensor:
    """The displacement (2, H, W) of every pixel of a frame, x first, that meets the displacements of some points.

    points (N, 2) and displacements (N, 2): x and y in pixels; points may lie outside of the frame, where the border's
    displacement holds. shape: (height, width). tolerance: px; lattices are refined, from one cell as wide as the frame
    down to cells of `finest` px, until every point arrives so near to where it should. wrap: the frame is periodic.
    repeats: so often a lattice is fitted at most, until its bound keeps nothing back any more. With 1, points that
    contradict each other within a cell are met in part; each repetition meets them better and swirls what lies between.
    Points that ask for a fold are met as far as none results.

    Raises InputError if points and displacements are not finite and of one shape (N, 2), or N is 0.
    """
    if points.shape != displacements.shape or points.ndim != 2 or points.shape[1] != 2 or not len(points):
        raise InputError(
            f"points have shape {tuple(points.shape)} and displacements {tuple(displacements.shape)}; give (N, 2) each"
        )
    if not bool(torch.isfinite(points + displacements).all()):
        raise InputError("some points or displacements are NaN or infinite; leave those out")
    shift = displacements.double().mean(0)
    place, target = points.double() + shift, points.double() + displacements.double()
    pixels = pixel_coordinates(shape, points.device).flatten(1).T.double()
    moved, extent = pixels + shift, torch.tensor([shape[1], shape[0]], dtype=torch.float64, device=points.device)
    for lattice in _lattices(place, target, extent if wrap else extent - 1, tolerance, finest, wrap, repeats):
        moved = moved + lattice(moved)
    return (moved - pixels).T.reshape(2, *shape).to(points.dtype)


@dataclass(frozen=True)
class _Lattice:
    """Displacements by uniform cubic B-splines over [0, extent]; control (cells_x * cells_y or more, 2)."""

    control: Tensor
    spacing: Tensor
    cells: tuple[int, int]
    wrap: bool

    def __call__(self, place: Tensor) -> Tensor:
        """The displacements (N, 2) of places (N, 2)."""
        index, weight = _support(place, self.spacing, self.cells, self.wrap)
        moved = torch.zeros_like(place)
        for k in range(16):
            moved.addcmul_(self.control.index_select(0, index[k]), weight[k, :, None])
        return moved


def _lattices(
    place: Tensor, target: Tensor, extent: Tensor, tolerance: float, finest: float, wrap: bool, repeats: int
) -> list[_Lattice]:
    """Lattices, coarse to fine, each repeated while that brings the points (N, 2) nearer to their targets."""
    lattices: list[_Lattice] = []
    width = float(extent.max())
    far = float((target - place).norm(dim=1).max())
    while width >= finest and far > tolerance:
        cells = tuple(max(1, round(float(side) / width)) for side in extent)
        for _ in range(repeats):
            lattice = _fitted(place, target - place, extent, (cells[0], cells[1]), wrap)
            nearer = place + lattice(place)
            rest, before = ((target - p).square().sum() for p in (nearer, place))
            if rest > _GAIN * before:
                break
            lattices.append(lattice)
            place, far = nearer, float((target - nearer).norm(dim=1).max())
            if far <= tolerance:
                break
        width /= 2
    return lattices


def _fitted(place: Tensor, wanted: Tensor, extent: Tensor, cells: tuple[int, int], wrap: bool) -> _Lattice:
    """The lattice for displacements (N, 2) wanted at places (N, 2), its control points held to the bound."""
    spacing = extent / torch.tensor(cells, device=extent.device)
    index, weight = _support(place, spacing, cells, wrap)
    count = cells[0] * cells[1] if wrap else (cells[0] + 3) * (cells[1] + 3)
    share = weight.square()
    asked = (weight / share.sum(0))[..., None] * wanted
    below = torch.bincount(index.flatten(), share.flatten(), count)
    sums = [torch.bincount(index.flatten(), (share * asked[..., axis]).flatten(), count) for axis in range(2)]
    control = torch.stack(sums, 1) / below.clamp(min=torch.finfo(below.dtype).tiny)[:, None]
    limit = BOUND * spacing
    return _Lattice(torch.maximum(torch.minimum(control, limit), -limit), spacing, cells, wrap)


def _support(place: Tensor, spacing: Tensor, cells: tuple[int, int], wrap: bool) -> tuple[Tensor, Tensor]:
    """The 16 control points that move each place (N, 2), as indices and weights (16, N)."""
    scaled = place / spacing
    most = torch.tensor(cells, device=place.device, dtype=place.dtype)
    scaled = scaled.remainder(most) if wrap else torch.minimum(scaled.clamp(min=0), most)
    cell = torch.minimum(scaled.floor(), most - 1)
    f = scaled - cell
    square, cube = f * f, f * f * f
    basis = torch.stack([(1 - f) ** 3, 3 * cube - 6 * square + 4, -3 * cube + 3 * square + 3 * f + 1, cube]) / 6
    at = cell.long() + torch.arange(4, device=place.device)[:, None, None]
    columns = cells[0] if wrap else cells[0] + 3
    x, y = (at[..., axis] % cells[axis] if wrap else at[..., axis] for axis in range(2))
    index = y[:, None] * columns + x[None]
    weight = basis[:, None, :, 1] * basis[None, :, :, 0]
    return index.flatten(0, 1), weight.flatten(0, 1)
