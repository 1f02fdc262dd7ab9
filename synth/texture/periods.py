"""Sizes that hold whole periods of a texture that repeats: only at these can it tile without a break.

A texture with a lattice tiles in a size where moving it by the height, and by the width, moves it onto itself: both
are lattice vectors, up to what a few elements can give way. One with rows tiles where both move rows onto rows. Cloth
tiles in whole cells, to the pixel: its lines run through.
"""

from collections.abc import Sequence
from functools import partial

import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra import Exemplar, Lattice, find_lattice
from kwatra.elements import Rows, find_rows, weave_beside

GIVE = 0.1
"""What a size may be off whole periods, as a part of the shortest one: elements of near-regular textures vary by as
much. One pixel is always allowed."""

QUICKLY = 2**18
"""Pictures with more pixels are searched for a lattice only where that is worth the time: these take two seconds."""


def whole_size(
    pictures: Sequence[Tensor], size: Sequence[int], axes: str = "xy", *, crop: bool = False, quickly: bool = False
) -> tuple[int, int] | None:
    """The size (height, width) nearest to `size` that holds whole periods of a texture along "x", "y" or "xy".

    pictures: of the texture, (C, H, W). crop: it is no larger than `size`. quickly: give up on large pictures. None for
    a texture with neither lattice nor rows that is no cloth, and where no size from half to one and a half of the given
    will do.
    """
    if quickly and sum(picture[0].numel() for picture in pictures) > QUICKLY:
        return None
    exemplar = Exemplar.of(list(pictures))
    lattice = find_lattice(exemplar)
    weave = weave_beside(lattice, exemplar)
    if weave is not None:
        nearest = [partial(_whole, cell.length) for cell in weave.cells]
    elif (repeats := lattice or find_rows(exemplar)) is not None:
        nearest = [partial(_nearest, repeats, axis) for axis in (0, 1)]
    else:
        return None
    height, width = size
    down = nearest[0](height, crop) if "y" in axes else height
    across = nearest[1](width, crop) if "x" in axes else width
    return None if down is None or across is None else (down, across)


def _whole(length: int, size: int, crop: bool) -> int | None:
    """The multiple of a length that is nearest to a size."""
    times = size // length if crop else max(round(size / length), 1)
    return times * length if size / 2 <= times * length <= 1.5 * size else None


def _nearest(repeats: Lattice | Rows, axis: int, size: int, crop: bool) -> int | None:
    """The nearest good size along an axis (0 down, 1 across); of several with as many periods the best is meant."""
    give = max(1.0, GIVE * repeats.shortest)
    if float(_off(repeats, torch.tensor([size]), axis)) <= give or _along(repeats, axis, size):
        return size
    sizes = torch.arange(max(size // 2, 4), (size if crop else size * 3 // 2) + 1)
    off = _off(repeats, sizes, axis)
    best = off <= F.pad(off, (1, 1), value=torch.inf).unfold(0, 3, 1).amin(1)
    good = sizes[(off <= give) & best]
    return int(good[(good - size).abs().argmin()]) if len(good) else None


def _along(repeats: Lattice | Rows, axis: int, size: int) -> bool:
    """Whether an axis runs along rows, so that no size near the given holds a period, and each does as well."""
    return isinstance(repeats, Rows) and repeats.shortest**2 > 1.5 * size * abs(float(repeats.across[axis]))


def _off(repeats: Lattice | Rows, sizes: Tensor, axis: int) -> Tensor:
    """How far moves by `sizes` (N,) pixels along an axis are from the nearest one in step, in pixels."""
    moves = torch.zeros(2, len(sizes), dtype=torch.float32)
    moves[axis] = sizes
    return repeats.rest(moves).norm(dim=0)
