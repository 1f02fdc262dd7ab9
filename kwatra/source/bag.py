"""Sources that are no exemplar: bags of made-up windows."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import torch
from torch import Tensor

from kwatra.base import InputError, product
from kwatra.source.described import DIMS, Described
from kwatra.source.protocol import chunk
from kwatra.windows import Feature, Metric


class Bag(Described):
    """A set of windows (N, *width, C) without places: matched and copied, but there is no canvas they come from.

    weights (C,): how much each channel counts in matching; a channel of weight 0 is carried along. `held` are the
    windows. Memory: these and their descriptors. Raises InputError for windows that are none, or not finite.
    """

    def __init__(
        self,
        windows: Tensor,
        weights: Tensor,
        generator: torch.Generator,
        dims: int = DIMS,
        features: Sequence[Feature] = (),
    ) -> None:
        if windows.ndim not in (4, 5) or 0 in windows.shape or not bool(windows.isfinite().all()):
            raise InputError(
                f"a bag of windows has shape {tuple(windows.shape)}; give finite (N, h, w, C) or (N, t, h, w, C), "
                "at least one"
            )
        self.held = windows.float().contiguous()
        metric = Metric(windows.shape[1:-1], weights.to(windows.device), features)
        super().__init__(metric, torch.arange(len(windows), device=windows.device), dims, generator)

    @property
    def count(self) -> int:
        """See `Source.count`."""
        return len(self.held)

    def windows(self, numbers: Tensor) -> Tensor:
        """See `Source.windows`."""
        return self.held[numbers]

    def values(self, numbers: Tensor, inside: Sequence[Tensor]) -> Tensor:
        """See `Source.values`."""
        return self.held[(numbers, *inside)].movedim(-1, 0)

    def projections(self, basis: Tensor, mean: Tensor) -> Iterator[tuple[Tensor, Tensor]]:
        """See `Described.projections`."""
        for part in self.held.split(max(chunk(self.held.device) // mean.numel(), 1)):
            embedded = self.metric.embed(part)
            yield product(embedded, basis), (embedded - mean).square().sum(1)


@dataclass(frozen=True)
class Bags:
    """A texture that is known by windows alone: for each level of an optimization a bag of its own.

    windows: by (factor, width) of a level, windows (N, width, width, C) at that resolution, coarse to fine and large
    to small. weights (C,): see `Bag`; left out, or none of them, all are alike. An optimization of bags needs no other
    levels than these.
    """

    windows: Mapping[tuple[int, int], Tensor]
    weights: Tensor = field(default_factory=lambda: torch.empty(0, dtype=torch.float32))

    def __post_init__(self) -> None:
        if not self.windows:
            raise InputError("there is no bag of windows; give one for each level, by (factor, width)")
        channels = {bag.shape[-1] for bag in self.windows.values()}
        if len(channels) > 1 or len(self.weights) not in (0, *channels):
            raise InputError(
                f"bags have {sorted(channels)} channels and {len(self.weights)} weights; give all the same number"
            )
        if not len(self.weights):
            object.__setattr__(self, "weights", torch.ones(channels.pop(), dtype=torch.float32))

    @property
    def device(self) -> torch.device:
        """Where the windows are."""
        return next(iter(self.windows.values())).device

    @property
    def exemplar(self) -> None:
        """A bag has none."""
        return None

    def source(
        self, factors: Sequence[int], width: Sequence[int], generator: torch.Generator, features: Sequence[Feature] = ()
    ) -> Bag:
        """The bag of a level; InputError where there is none."""
        key = (factors[-1], width[-1])
        if key not in self.windows:
            raise InputError(
                f"there is no bag for factor {key[0]} and width {key[1]}; give one, or leave out the level"
            )
        return Bag(self.windows[key], self.weights, generator, features=features)
