"""Lines that run obliquely: how steeply, and how much faster a still changes across than along them.

Both are read from the structure tensor, the mean product of slopes; its smaller eigenvalue is what changes along the
lines. Slopes are of smoothed pixels: differences to the next pixel do not see beyond the grid that lines are drawn on.
"""

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra.base import total
from kwatra.elements.correlation import pictures
from kwatra.elements.direction import slopes
from kwatra.elements.kept import kept
from kwatra.exemplar import Exemplar

SIGMA = 1.0
"""Slopes are of pictures blurred by so many pixels, as is usual."""

SLOPES = ((0, 1), (1, 4), (1, 3), (1, 2), (2, 3), (3, 4), (1, 1))
"""How steeply lines may run, as pixels aside for pixels on: by small numbers, for copies are moved by multiples of the
second. No angle is further than 7 degrees from one of these."""


@dataclass(frozen=True)
class Slant:
    """Lines go `aside` pixels along the other axis for each `on` along the axis `along` (0 down, 1 to the right).

    anisotropy: how many times as fast the still changes across as along them.
    """

    along: int
    aside: int
    on: int
    anisotropy: float

    def moved(self, size: int) -> Tensor:
        """By how many whole pixels a line has gone aside, (size,) long, after 0, 1, ... pixels on."""
        return torch.div(torch.arange(size) * self.aside, self.on, rounding_mode="floor")


@kept
def find_slant(exemplar: Exemplar) -> Slant:
    """How the lines of a still run. Its anisotropy is 1 where no direction is preferred; of one color, too."""
    xx, yy, xy = 0.0, 0.0, 0.0
    for picture, present in pictures(exemplar):
        down, right, inside = slopes(picture, present, SIGMA)
        xx += float(total(right.square() * inside))
        yy += float(total(down.square() * inside))
        xy += float(total(right * down * inside))
    middle, away = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
    least = max(middle - away, 0.0)
    much = math.sqrt((middle + away) / least) if least > 0 else math.inf if middle > 0 else 1.0
    slope = -math.tan(math.atan2(2 * xy, xx - yy) / 2)  # to the right for each pixel down
    along = 0 if abs(slope) <= 1 else 1
    slope = slope if along == 0 else 1 / slope
    aside, on = min(SLOPES, key=lambda step: abs(math.atan(step[0] / step[1]) - math.atan(abs(slope))))
    return Slant(along, aside if slope > 0 else -aside, on, much)
