"""Holes in cloth whose lines run through: each line goes on as it does beside the hole.

What a row and a column are like is known from the rest of them. A hole is filled from where all of it lies after one
move: what lines do not tell, as the threads of the cloth, comes from there, and what the lines there differ by from
those that cross the hole is added. Of all moves that is taken after which they differ least.
"""

from collections.abc import Callable

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra import Exemplar, Progress, Result
from kwatra.elements import find_weave, lines_through
from kwatra.pieces import totals
from kwatra.source import sourcemap

FEW, NEAR = 16, 96
"""Where there are more holes than so many each is filled from so many pixels about it: a bound on time, not tuned."""


def filled_by_lines(
    picture: Tensor, missing: Tensor, source: Exemplar, callback: Callable[[Progress], None] | None
) -> Result | None:
    """A picture (C, H, W) whose missing pixels (H, W) are filled from the rest of it, its `source` as an exemplar.

    All around a picture its lines go on as in a larger one. None where it is no cloth, nothing is known of a line and
    there are other holes, or a hole is found nowhere to be filled from.
    """
    where = _around(picture, missing)
    if where is not None:
        return _result(picture[:, where[0], where[1]], where, source, callback)
    lines = lines_through(picture, ~missing)
    return None if lines is None else _beside(picture, missing, *lines, source, callback)


def _around(picture: Tensor, missing: Tensor) -> Tensor | None:
    """The source map (2, H, W) of a picture that is missing all around a rectangle of cloth; None for any other."""
    sides = [(~missing).any(1 - axis).nonzero()[:, 0] for axis in (0, 1)]
    box = tuple(slice(int(side[0]), int(side[-1]) + 1) for side in sides)
    weave = None if bool(missing[box].any()) else find_weave(Exemplar.of(picture[(slice(None), *box)].contiguous()))
    if weave is None:
        return None
    lines = list[Tensor]()
    for cell, side, size in zip(weave.cells, box, missing.shape, strict=True):
        line = torch.arange(size) - side.start
        beyond = (line < 0) | (line >= side.stop - side.start)
        lines.append(side.start + torch.where(beyond, cell.first + (line - cell.first) % cell.length, line))
    return torch.stack(torch.meshgrid(*lines, indexing="ij"))


def _beside(
    picture: Tensor,
    missing: Tensor,
    rows: Tensor,
    columns: Tensor,
    source: Exemplar,
    callback: Callable[[Progress], None] | None,
) -> Result | None:
    """The same where something is known of each row (C, H) and column (C, W)."""
    where, (holes, count) = torch.from_numpy(np.indices(missing.shape)), ndimage.label(missing.numpy(), np.ones((3, 3)))
    for number, box in enumerate(ndimage.find_objects(holes), 1):
        about = tuple(
            slice(max(side.start - NEAR, 0), side.stop + NEAR) if count > FEW else slice(None) for side in box
        )
        hole = torch.from_numpy(holes[about] == number)
        move = _move(hole, missing[about], rows[:, about[0]], columns[:, about[1]])
        if move is None:
            return None
        where[(slice(None), *about)][:, hole] += torch.tensor(move)[:, None]
    below, beside = where
    told = rows[:, :, None] - rows[:, below] + columns[:, None] - columns[:, beside]
    image = (picture[:, below, beside] + told.to(picture)).clamp(picture.min(), picture.max())
    return _result(image, where, source, callback)


def _result(image: Tensor, where: Tensor, source: Exemplar, callback: Callable[[Progress], None] | None) -> Result:
    if callback is not None:
        callback(Progress(1.0, 0, 0, 0.0, image))
    there = where.to(source.canvas.device)
    return Result(image, sourcemap.look_up(source.origin, there), there, [], [], "all lines go on")


def _move(hole: Tensor, missing: Tensor, rows: Tensor, columns: Tensor) -> tuple[int, int] | None:
    """The move (down, right) of a hole (H, W) to where nothing is missing after which its lines differ least."""
    place = hole.nonzero()
    (top, left), (bottom, right) = place.amin(0).tolist(), (place.amax(0) + 1).tolist()
    inner = hole[top:bottom, left:right]
    lost = totals(inner.double().numpy(), missing.double().numpy()) > 0.5
    down, across = (
        _differ(line, share, first) for line, share, first in ((rows, inner.sum(1), top), (columns, inner.sum(0), left))
    )
    cost = torch.where(torch.from_numpy(lost), torch.inf, down[:, None] + across)
    low = int(cost.argmin())
    if not bool(cost.flatten()[low].isfinite()):
        return None
    return low // cost.shape[1] - top, low % cost.shape[1] - left


def _differ(lines: Tensor, share: Tensor, first: int) -> Tensor:
    """How much lines (C, n) from each on differ from those from the first on, of which so much counts (m,)."""
    apart = lines.unfold(1, len(share), 1) - lines[:, None, first : first + len(share)]
    return (apart.square() * share).sum((0, 2))
