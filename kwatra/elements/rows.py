"""The rows of a texture that repeats across them alone: courses of bricks of many lengths, lines of text, stripes.

Along rows colors are alike on and on, more than in any other direction; across them this likeness comes and goes. So
rows run in the direction in which the mean autocorrelation is highest, and their period is read from its mean over all
lags at one distance from that line.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra.elements.correlation import Correlation, of_colors
from kwatra.elements.kept import kept
from kwatra.elements.lattice import AS_GOOD, SHORTEST
from kwatra.elements.size import radial, unlike
from kwatra.exemplar import Exemplar

ALIKE = 0.17
"""Least mean correlation along rows. Of 52 photographs walls have .23 to .63, text .27, cloth .51 and what has none
at most .15; set on these."""

CLEAR = 0.9
"""By so much of that the correlation rises, from half-way between rows to whole periods, at least. The same photographs
have 1.0 and more; a picture of wood, with lines but no rows, hardly .6."""

BEYOND = 1.5
"""Lags along rows count from so many times on as colors become unlike: nearer ones are alike in any direction."""

PERIODS = 3
"""At least so many whole periods are compared."""


@dataclass(frozen=True)
class Rows:
    """Rows side by side that look alike, as told by what lies across them.

    across (2,) float64, (down, right) in pixels: from a row to the next, at right angles to both.
    """

    across: Tensor

    @property
    def shortest(self) -> float:
        """The period in pixels."""
        return float(self.across.norm())

    def rest(self, offsets: Tensor) -> Tensor:
        """What is left (2, ...) of offsets (2, ...) in pixels without whole periods and moves along rows."""
        across = self.across.view(2, *[1] * (offsets.ndim - 1))
        times = (across * offsets).sum(0) / self.across.square().sum()
        return across * (times - times.round())

    def coarser(self, factor: float) -> "Rows":
        """The same where pixels are a factor coarser."""
        return Rows(self.across / factor)

    def closed(self, shape: Sequence[int], wraps: Sequence[bool]) -> "Rows":
        """The nearest rows of which whole periods go around an output of a shape where it wraps.

        These where around no axis of it half a period goes.
        """
        often = self.across / self.across.square().sum()
        sizes = torch.tensor(shape, dtype=torch.float64)
        whole = torch.where(torch.tensor(wraps), (often * sizes).round() / sizes, often)
        return Rows(whole / whole.square().sum()) if bool(whole.any()) else self


@kept
def find_rows(exemplar: Exemplar) -> Rows | None:
    """The rows of an exemplar's texture, None where it has none.

    Three periods have to be seen and a tenth of one more. The direction is found to a tenth of a degree, the period to
    a hundredth of a pixel.
    """
    found = of_colors(exemplar)
    beyond = BEYOND * unlike(radial(found))
    angle = 0.0
    for reach, step in ((90.0, 1.0), (1.0, 0.1)):
        angles = angle + np.deg2rad(np.arange(-reach, reach + step / 2, step))
        angle = float(angles[np.argmax(_along(found, angles, beyond))])
    value, overlap = _across(found, angle, beyond)
    if not len(value) or value[0] < ALIKE:
        return None
    period = _period(value / value[0], overlap)
    if period is None:
        return None
    return Rows(period * torch.tensor([math.cos(angle), -math.sin(angle)], dtype=torch.float64))


def _along(found: Correlation, angles: np.ndarray, beyond: float) -> list[float]:
    """The mean correlation at lags in directions, `angles` (n,) below that to the right, from a lag on."""
    middle, lines = np.array(found.reach)[:, None], list[np.ndarray]()
    for angle in angles.tolist():
        step = np.array([[math.sin(angle)], [math.cos(angle)]])
        far = min(reach / abs(s) for reach, s in zip(found.reach, step[:, 0], strict=True) if abs(s) > 1e-9)
        lines.append(middle + step * np.arange(beyond, far))
    places, ends = np.concatenate(lines, 1), np.cumsum([line.shape[1] for line in lines])[:-1]
    parts = (ndimage.map_coordinates(part.numpy(), places, order=1) for part in (found.value, found.overlap))
    pairs = zip(*(np.split(part, ends) for part in parts), strict=True)
    return [float((value * overlap).sum() / max(overlap.sum(), 1e-9)) for value, overlap in pairs]


def _across(found: Correlation, angle: float, beyond: float) -> tuple[np.ndarray, np.ndarray]:
    """The mean correlation (D,) by distance from the line in a direction, up to where it is known, and the overlap."""
    down, right = (torch.arange(-r, r + 1, dtype=torch.float64) for r in found.reach)
    along = down[:, None] * math.sin(angle) + right * math.cos(angle)
    across = down[:, None] * math.cos(angle) - right * math.sin(angle)
    seen = replace(found, overlap=torch.where(along.abs() >= beyond, found.trusted().overlap, 0.0))
    value, overlap = (part.numpy() for part in seen.mean_by(across.abs(), min(found.reach)))
    known = np.flatnonzero(overlap).max(initial=-1) + 1
    return value[:known], overlap[:known]


def _period(curve: np.ndarray, overlap: np.ndarray) -> float | None:
    """The period of a curve (D,) that is 1 at 0, None where it has none: the finest that is about as clear as any."""
    coarse = np.arange(SHORTEST, (len(curve) - 1) / PERIODS, 0.1)
    clear = np.array([_clear(curve, overlap, one) for one in coarse])
    if not len(clear) or clear.max() < CLEAR:
        return None
    at = int(np.argmax(clear >= AS_GOOD * clear.max()))
    while at + 1 < len(clear) and clear[at + 1] > clear[at]:
        at += 1
    fine = coarse[at] + np.arange(-0.1, 0.105, 0.01)
    return float(fine[np.argmax([_clear(curve, overlap, one) for one in fine])])


def _clear(curve: np.ndarray, overlap: np.ndarray, period: float) -> float:
    """How much higher a curve is at whole periods than half-way between, in the mean."""
    lags = np.arange(len(curve))
    whole = period * np.arange(1, int(lags[-1] / period) + 1)
    weight = np.interp(whole, lags, overlap)
    rise = np.interp(whole, lags, curve) - np.interp(whole - period / 2, lags, curve)
    return float((weight * rise).sum() / weight.sum())
