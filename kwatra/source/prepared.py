"""An exemplar with its windows described for the search, kept from one optimization to the next.

Describing the windows of all levels costs as much as some iterations. Where one exemplar serves many optimizations,
such as the frames of an animation, `Prepared` is given to `kwatra.optimize` in the exemplar's place.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import torch
from torch import Tensor

from kwatra.exemplar import Exemplar
from kwatra.source.canvas import SourceWindows
from kwatra.source.protocol import Source
from kwatra.windows import Feature


class Texture(Protocol):
    """What an optimization copies from: at every level a source of windows."""

    @property
    def exemplar(self) -> Exemplar | None:
        """The exemplar, where there is one: whole pieces are copied from it, and levels planned for it."""

    @property
    def weights(self) -> Tensor:
        """How much each channel counts in matching, (C,)."""

    @property
    def device(self) -> torch.device:
        """Where it is, and where the work is done."""

    def source(
        self, factors: Sequence[int], width: Sequence[int], generator: torch.Generator, features: Sequence[Feature] = ()
    ) -> Source:
        """The windows of `width` where pixels are `factors` times coarser."""


@dataclass(frozen=True)
class _Kept:
    source: SourceWindows
    before: Tensor
    after: Tensor


class Prepared:
    """An exemplar that keeps its described windows: one set per resolution, window width and features.

    Results are the same bits as without it: what is random in the description is drawn from the optimization's
    generator, so a kept set serves only where the generator stands as it did. Frames that are given a start image and
    one seed share theirs; another seed, or another shape that is started from blocks, describes anew.
    """

    def __init__(self, exemplar: Exemplar) -> None:
        self.exemplar = exemplar
        self.weights, self.device = exemplar.weights, exemplar.canvas.device
        self._kept: dict[tuple[object, ...], _Kept] = {}

    def source(
        self, factors: Sequence[int], width: Sequence[int], generator: torch.Generator, features: Sequence[Feature] = ()
    ) -> SourceWindows:
        """See `Texture.source`; the generator moves on as if the windows were described anew."""
        key = (tuple(factors), tuple(width), tuple(features))
        before = generator.get_state()
        kept = self._kept.get(key)
        if kept is None or not torch.equal(kept.before, before):
            source = SourceWindows(self.exemplar.coarser(factors), width, generator, features=features)
            kept = self._kept[key] = _Kept(source, before, generator.get_state())
        generator.set_state(kept.after)
        return kept.source
