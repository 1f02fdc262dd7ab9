"""Tones: what keeps the exemplar's bright and dark parts in proportion while a texture flows.

Texture energy does not mind when all gaps grow and all else shrinks (thesis 4.4 has windows plausible one by one), and
where a flow diverges that is what happens. So pixels are sorted by the tone of the exemplar around their source, in
classes of which the exemplar holds equally much, and a class that the frame shows too often has a price.
"""

import torch
from torch import Tensor

from flow.animation.blur import blurred
from flow.animation.reading import continued
from kwatra import Exemplar
from kwatra.base import mean, total

_CLASSES = 16
"""Tones that are told apart, each shown equally often by the exemplar. Tried: .202 with 8, .203 with 32."""

_BLUR = 2.0
"""A tone is the color's first principal component after a blur of this many px. Tried: .197 with 1 and 4."""


class Tones:
    """An exemplar's tones; `weight`, in its variances, is the price of a class shown e times too often, per pixel."""

    def __init__(self, exemplar: Exemplar, weight: float) -> None:
        self.weight = weight
        known = exemplar.owner >= 0
        smooth = blurred(exemplar.canvas * exemplar.share.sqrt(), known, _BLUR)
        colors = smooth[:, known].double()
        apart = torch.stack([channel - mean(channel) for channel in colors])
        spread = torch.stack([torch.stack([total(one * other) for other in apart]) for one in apart])
        _, directions = torch.linalg.eigh(spread)
        tone = (directions[:, -1:] * colors).sum(0)
        rank = torch.empty_like(tone, dtype=torch.long)
        rank[tone.argsort(stable=True)] = torch.arange(len(tone), device=tone.device)
        tones = torch.zeros_like(known, dtype=torch.long)
        tones[known] = rank * _CLASSES // len(tone)
        self._tone = continued(tones[None], exemplar.owner)[0]

    def of(self, source: Tensor) -> Tensor:
        """The class (*S) of the tone at source coordinates (2, *S), x first."""
        height, width = self._tone.shape
        x, y = source.round().long()
        return self._tone[y.clamp(0, height - 1), x.clamp(0, width - 1)]

    def prices(self, source: Tensor, inside: Tensor) -> Tensor:
        """What a pixel of each class costs, below 0 for those shown too seldom, where inside (H, W) shows source."""
        shown = torch.bincount(self.of(source)[inside], minlength=_CLASSES).float()
        share = _CLASSES * shown / shown.sum().clamp(min=1)
        return self.weight * share.clamp(min=0.1).log()

    def costs(self, prices: Tensor, rows: Tensor) -> Tensor:
        """What the pixels of some rows (r,) of the exemplar's canvas cost at these prices (16,): (r, w)."""
        return prices[self._tone[rows]]
