"""The scale that textures share: how much larger the elements of one are than those of another."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np
import torch
from torch import Tensor

from kwatra import Exemplar, element_size
from kwatra.windows import windows_at
from synth.metamorphosis.patches.textures import Texture

LARGEST_RATIO = 2.0
"""Elements whose sizes differ by more are brought no closer than this: beyond, hardly a window would be left."""

_ALIKE = 1.15
"""Sizes that differ by less count as one: the estimate is no better."""

_CLEARLY = 0.93
"""Windows at the common scale are to be as unlike as this, at most, beside windows that are brought apart instead. Of
bricks and gravel and their crops made 1.6 times larger, and bricks of two walls, they are .22, .91 and .37; of four
pairs of photographs whose elements have about one size, but were measured 1.2 to 1.8 times larger, .96 to 1.07."""

_WINDOW, _WINDOWS = 17, 800
"""Px of the windows that are compared, and about how many of each texture are: a bound on time."""


def common_units(images: Sequence[Tensor], maps: Sequence[Tensor]) -> tuple[float, ...]:
    """How many pixels of each texture (C, H, W) make one of a common scale, at which their elements have one size.

    maps: (H, W) of their features. Sizes are measured (see `kwatra.element_size`), which fails for elements of many
    sizes. So they are believed only if windows are then more alike than as they are, and than at scales that differ as
    much the other way, where they lose as much detail.
    """
    ones = (1.0,) * len(images)
    logs = np.log([element_size(Exemplar.of(image)) for image in images])
    apart = np.ptp(logs)
    if apart < np.log(_ALIKE):
        return ones
    logs = (logs - logs.mean()) * min(1.0, np.log(LARGEST_RATIO) / apart)
    units, opposite = (tuple(float(unit) for unit in np.exp(sign * logs)) for sign in (1, -1))
    if min(min(image.shape[1:]) for image in images) / max(*units, *opposite) < _WINDOW:
        return ones
    so, as_given, opposed = (_unlike(images, maps, each) for each in (units, ones, opposite))
    return units if so < min(as_given, _CLEARLY * opposed) else ones


def _unlike(images: Sequence[Tensor], maps: Sequence[Tensor], units: Sequence[float]) -> float:
    """How much windows of textures at a common scale differ from the nearest of the others, both ways."""
    given = zip(images, maps, units, strict=True)
    sets = [_windows(Texture.of(image, features, unit, 1).common()) for image, features, unit in given]
    nearest = []
    for one, other in combinations(sets, 2):
        apart = torch.cdist(one, other).square()
        nearest += [apart.amin(0).mean(), apart.amin(1).mean()]
    return float(torch.stack(nearest).mean())


def _windows(texture: Texture) -> Tensor:
    """Windows, evenly spread, of its brightness and its distance to features, each of variance 1: (N, values)."""
    both = torch.stack([texture.image.mean(0), texture.distance[0]], -1)
    both = (both - both.mean((0, 1))) / both.std((0, 1)).clamp(min=1e-6)
    rows, columns = (side - _WINDOW + 1 for side in both.shape[:2])
    step = max(round((rows * columns / _WINDOWS) ** 0.5), 1)
    corners = torch.cartesian_prod(torch.arange(0, rows, step), torch.arange(0, columns, step))
    return windows_at(both.contiguous(), corners, (_WINDOW, _WINDOW)).flatten(1)
