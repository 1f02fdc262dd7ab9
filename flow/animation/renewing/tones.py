"""Tones: what keeps the exemplar's bright and dark parts in proportion while a texture flows.

Texture energy does not mind when all gaps grow and all else shrinks (thesis 4.4 has windows plausible one by one), and
where a flow diverges that is what happens. So pixels are sorted by the tone of the exemplar around their source, in
classes of which the exemplar holds equally much, and a class that the frame shows too often has a price. In videos what
a class's share varies by from frame to frame anyway is free: a flame flares up and goes dark. And a tone's pixels are
sorted by their grain: where nothing is seen twice a smooth block agrees best with any other, and one by one all drops
of a fountain would be replaced by mist.
"""

import torch
from torch import Tensor

from flow.animation.carrying import blurred
from flow.animation.film import nearest_pixels, where_inside
from kwatra import Exemplar
from kwatra.base import continued, over_channels, principal_axes
from kwatra.source import look_up

_CLASSES = 16
"""Tones that are told apart, each shown equally often by the exemplar. Tried: .202 with 8, .203 with 32."""

_TONES, _GRAINS = 8, 4
"""Tones that are told apart in videos, and grades of grain in each. Of a fountain that moves by 2 px a frame .91 of the
sharpness is left after 60 frames, of one that turns .96; .73 and .84 without grades (blocks come from anywhere in all,
and seams are not feathered)."""

_BLUR = 2.0
"""A tone is the color's first principal component after a blur of this many px. Tried: .197 with 1 and 4."""


class Tones:
    """An exemplar's tones; `weight`, in its variances, is the price of a class shown e times too often, per pixel.

    grain: how grainy the exemplar is at every pixel, (h, w); None where that does not count. frames: how many the
    exemplar is made of, all known in the same places; e up to the deviation of its logarithm in them has no price.
    """

    def __init__(self, exemplar: Exemplar, weight: float, grain: Tensor | None = None, frames: int = 1) -> None:
        self.weight = weight
        known = exemplar.owner >= 0
        smooth = blurred(exemplar.canvas * exemplar.share.sqrt(), known, _BLUR)
        colors = smooth[:, known].double()
        tone = over_channels(principal_axes(colors)[0, :, None] * colors)
        classes, self._count = _sorted(tone, _CLASSES if grain is None else _TONES), _CLASSES
        if grain is not None:
            grades, self._count = torch.empty_like(classes), _TONES * _GRAINS
            for one in range(_TONES):
                grades[classes == one] = _sorted(grain[known][classes == one], _GRAINS)
            classes = classes * _GRAINS + grades
        shown = torch.stack([torch.bincount(frame, minlength=self._count) for frame in classes.view(frames, -1)])
        self._own = self._excess(shown).std(0, correction=0)
        tones = torch.zeros_like(known, dtype=torch.long)
        tones[known] = classes
        self._tone = continued(tones[None], exemplar.owner)[0]

    def of(self, source: Tensor) -> Tensor:
        """The class (*S) of the tone at source coordinates (2, *S), x first."""
        return look_up(self._tone[None], nearest_pixels(source, self._tone.shape))[0]

    def prices(self, shown: Tensor, inside: Tensor) -> Tensor:
        """What a pixel of each class costs, below 0 for those shown too seldom, where classes (H, W) are inside."""
        excess = self._excess(torch.bincount(where_inside(shown, inside), minlength=self._count))
        return self.weight * (excess - excess.clamp(-self._own, self._own))

    def _excess(self, shown: Tensor) -> Tensor:
        """By which factor, as a logarithm, classes shown by so many pixels (*B, n) are shown too often."""
        share = self._count * shown.float() / shown.sum(-1, keepdim=True).clamp(min=1)
        return share.clamp(min=0.1).log()

    def costs(self, prices: Tensor, rows: Tensor) -> Tensor:
        """What the pixels of some rows (r,) of the exemplar's canvas cost, (r, w), at the prices of classes (n,)."""
        return prices[self._tone[rows]]


def _sorted(values: Tensor, count: int) -> Tensor:
    """The class (N,) of each of some values (N,), lowest first, where all of so many classes hold equally many."""
    rank = torch.empty_like(values, dtype=torch.long)
    rank[values.argsort(stable=True)] = torch.arange(len(values), device=values.device)
    return rank * count // max(len(values), 1)
