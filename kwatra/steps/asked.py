"""What is asked of the matches of some windows: to be like them, and to be what terms want (thesis 26 and 31)."""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor

from kwatra.source import Placed, Source
from kwatra.terms import Charge, PlaceCharge, Wish
from kwatra.windows import Layout, Metric


@dataclass(frozen=True)
class Wants:
    """What terms want of an image: a wish for each pixel, or None, and what they charge candidates.

    charges: for what they hold; places: for where they come from.
    """

    wish: Wish | None = None
    charges: Sequence[Charge] = ()
    places: Sequence[PlaceCharge] = ()

    def away(self, corners: Tensor, source: Source, candidates: Tensor) -> Tensor | None:
        """What candidates (N, k) cost windows at corners (N, n) for their places, (N, k); None where nothing does."""
        if not self.places or not isinstance(source, Placed):
            return None
        there = source.corners(candidates)
        costs = [place(corners, there) for place in self.places]
        return sum(costs[1:], costs[0])


@dataclass(frozen=True)
class Asked:
    """What is asked of the matches of some windows.

    windows (N, *width, C): to be like these; present (N, *width, 1) of 0 and 1, or None: at these pixels. weight and
    value (N, *width, C): what terms wish for, or None. corners (N, n): where they lie; charges: what terms charge.
    """

    windows: Tensor
    present: Tensor | None
    weight: Tensor | None
    value: Tensor | None
    corners: Tensor
    charges: Sequence[Charge] = ()

    @classmethod
    def of(cls, layout: Layout, image: Tensor, wants: Wants, mask: Tensor | None) -> "Asked":
        """What is asked of the windows of a layout; the mask (1, *S) as an image."""
        present = None if mask is None else layout.gather(mask.float())
        wish = wants.wish
        weight, value = (None, None) if wish is None else (layout.gather(wish.weight), layout.gather(wish.value))
        return cls(layout.gather(image), present, weight, value, layout.corners, wants.charges)

    def __getitem__(self, pick: Tensor) -> "Asked":
        """Some of the windows."""
        present, weight, value = (None if p is None else p[pick] for p in (self.present, self.weight, self.value))
        return Asked(self.windows[pick], present, weight, value, self.corners[pick], self.charges)

    @property
    def wanted(self) -> Tensor:
        """Of which windows (N,) terms want something."""
        if self.charges:
            return torch.ones(len(self.windows), dtype=torch.bool, device=self.windows.device)
        if self.weight is None:
            return torch.zeros(len(self.windows), dtype=torch.bool, device=self.windows.device)
        return (self.weight > 0).flatten(1).any(1)

    def squared(self, metric: Metric, there: Tensor) -> Tensor:
        """Squared distances (N,) to exemplar windows (N, *width, C): a mean over the unmasked pixels."""
        if self.present is None:
            return metric.squared(self.windows - there)
        return metric.squared(self.present * (self.windows - there)) / self._share(metric)

    def cost(self, metric: Metric, there: Tensor) -> tuple[Tensor, Tensor]:
        """What source windows (N, *width, C) cost with all that terms want, and squared distances (N,)."""
        squared = self.squared(metric, there)
        return squared + self.wanting(metric, there), squared

    def wanting(self, metric: Metric, there: Tensor) -> Tensor:
        """What source windows (N, *width, C) cost the terms, (N,) or a scalar 0 (thesis equations 26 and 31).

        The wish counts by the same falloff as likeness: so much does a window contribute to a pixel.
        """
        cost = metric.weight.new_zeros(())
        if self.weight is not None and self.value is not None:
            wish = (metric.weight * self.weight * (there - self.value) ** 2).flatten(1).sum(1)
            cost = cost + wish / self._share(metric)
        for charge in self.charges:
            cost = cost + charge(self.corners, there)
        return cost

    def pleasing(self, metric: Metric, there: Tensor) -> tuple[Tensor, Tensor]:
        """What source windows (N, *width, C) cost the terms alone, (N,), twice: nothing is compared with an image."""
        cost = self.wanting(metric, there).expand(len(there))
        return cost, cost

    def _share(self, metric: Metric) -> Tensor:
        """The part (N,) of each window that is not masked, by weight."""
        if self.present is None:
            return metric.weight.new_ones(())
        return (metric.falloff * self.present).flatten(1).sum(1).clamp(min=1e-12)

    def target(self, source: Source, matches: Tensor | None) -> Tensor:
        """The windows (N, *width, C) to look for.

        With a wish (w, c) that is (x + w c) / (1 + w), where the sum of both distances is least; what is masked is
        filled in from the `matches` (N,), if any, or by expectation.
        """
        wanted = self.windows
        if self.weight is not None and self.value is not None:
            wanted = (wanted + self.weight * self.value) / (1 + self.weight)
        if self.present is None:
            return wanted
        if matches is not None:
            return torch.where(self.present > 0, wanted, source.windows(matches))
        partial = (self.present == 0).flatten(1).any(1)
        if bool(partial.any()):
            wanted = wanted.clone()
            wanted[partial] = source.completed(wanted[partial], self.present[partial])
        return wanted
