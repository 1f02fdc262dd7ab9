"""Seams of videos whose frames tell little of each other are feathered: what meets there passes over into each other.

Pieces of flames agree nowhere, wherever they are cut: of a seam nothing is hidden by what is around, and by what comes
next as little. So a pixel shows the mean of what the pieces around it would show there if they went on, by a Gaussian
within its frame; colors are mixed about the curve on which they lie (`flow.animation.showing.colorcurve`). Within a
piece nothing changes, as that would show the same. The less the exemplar's light lasts from frame to frame the wider is
the Gaussian; where it lasts, or is fine, places are found where seams are hidden. Here a pixel's place is a whole one
and tells where its piece goes on; pieces that flow are turned and bent, and are told apart first
(`flow.animation.showing.feathering`).
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra import Exemplar, element_size
from kwatra.base.compiled import Compiled
from synth.texture.light import lasting

WIDTH = 6.0
"""The Gaussian's deviation, in px, where light does not last at all. Chosen by looking at a flame half as large again
as its clip, whose light lasts by .16: without, blocks lie in rows with hard edges. With twice as much all is soft."""

LEAST = 2.5
"""With a narrower Gaussian nothing is feathered: a waterfall, whose light lasts by .42, scored .069 with 2 px, in place
of .067 (two seeds), and looked the same."""

FINE = 0.1
"""The Gaussian is no wider than so much of an element: rings of rain of 4 px, whose light does not last either, kept
.85 of their sharpness with 6 px and keep .90. Flames are of 90 px."""


def passage(exemplar: Exemplar) -> float:
    """How wide seams of an exemplar of videos are to be feathered: the Gaussian's deviation in px, 0 for not at all."""
    width = min(WIDTH * (1 - lasting(exemplar).light) ** 2, FINE * element_size(exemplar))
    return width if width >= LEAST else 0.0


def feathered(
    video: Tensor, where: Tensor, exemplar: Exemplar, width: float, wrap: tuple[bool, ...], free: Tensor
) -> Tensor:
    """A video (C, T, H, W) with its seams feathered, where the map (3, T, H, W) says it comes from.

    The map's places are on the exemplar's canvas. width: the Gaussian's deviation, in px; with 0 nothing changes. wrap:
    whether time, rows and columns are periodic. free (T,): False for frames to leave alone.
    """
    if width == 0:
        return video
    from flow.animation.showing.colorcurve import ColorCurve  # few videos need it

    reach, curve = round(2 * width), ColorCurve(exemplar)
    near = near_seams(where.cpu(), reach, wrap[1:]) & free.cpu().view(-1, 1, 1)
    falloff = torch.exp(-(torch.arange(-reach, reach + 1, dtype=torch.float32) / width).square() / 2)
    colors = (curve.of(exemplar.canvas), curve.of(video))
    canvas, shown, places = (one.cpu().movedim(0, -1).contiguous() for one in (*colors, where))
    _feather(near[..., 0].numel(), canvas, exemplar.owner.cpu(), places, falloff, np.array(wrap[1:]), near, shown)
    soft = curve.colors(shown.movedim(-1, 0)).to(video)
    return torch.where(near.to(video.device), soft, video)


def near_seams(where: Tensor, reach: int, wrap: Sequence[bool]) -> Tensor:
    """Which pixels (T, H, W) of a map (3, T, H, W) have within so many rows and columns one of another piece.

    wrap: whether rows and columns are periodic.
    """
    near = np.zeros(where.shape[1:], bool)
    for axis, around in enumerate(wrap, 1):
        onward = where.roll(-1, axis + 1) - where
        onward[axis] -= 1
        seam = (onward != 0).any(0)  # between a pixel and the next
        if not around:
            seam.select(axis, -1).fill_(False)
        size = [1, 2 * reach + 1, 2 * reach + 1]
        size[axis] = 2 * reach  # seams that lie between so many pixels are one fewer
        modes = ["constant", *("wrap" if one else "constant" for one in wrap)]
        near |= ndimage.maximum_filter(seam.numpy(), size, mode=modes)
    return torch.from_numpy(near)


@Compiled
def _feather(
    canvas: Any, owner: Any, places: Any, falloff: Any, around: Any, near: Any, shown: Any, low: int, high: int
) -> None:
    """Set what is `shown` (T, H, W, C) `near` (T, H, W) seams, in rows from low to before high, counted over frames.

    canvas (t, h, w, C), owner (t, h, w): < 0 where nothing may be copied; places (T, H, W, 3). falloff (k,): along
    either axis; around (2,): which of them wrap.
    """
    reach, rows, columns, colors = len(falloff) // 2, places.shape[1], places.shape[2], shown.shape[3]
    total = np.empty(colors + 1, np.float32)
    for line in range(low, high):
        t, i = line // rows, line % rows
        for j in range(columns):
            if not near[t, i, j]:
                continue
            total[:] = 0
            for down in range(-reach, reach + 1):
                row = (i + down) % rows
                if row != i + down and not around[0]:
                    continue
                for right in range(-reach, reach + 1):
                    column = (j + right) % columns
                    if column != j + right and not around[1]:
                        continue
                    page, y, x = places[t, row, column]
                    y, x = y - down, x - right
                    if not (0 <= y < owner.shape[1] and 0 <= x < owner.shape[2]) or owner[page, y, x] < 0:
                        continue
                    weight = falloff[down + reach] * falloff[right + reach]
                    total[colors] += weight
                    for color in range(colors):
                        total[color] += weight * canvas[page, y, x, color]
            for color in range(colors):
                shown[t, i, j, color] = total[color] / total[colors]
