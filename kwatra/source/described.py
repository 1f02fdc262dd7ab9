"""Windows described by their principal components, and found by them.

Windows are compared under the metric's embedding E. A PCA of E z over a sample of them gives each window a short
descriptor; with the length of what it leaves out, distances are estimated. An index over descriptors, exact or with
inverted lists (faiss), finds the nearest; on other devices than the CPU, where faiss is not, all are compared. Memory:
`dims` + 1 floats per window, plus the index's copy.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from functools import cached_property

import faiss
import numpy as np
import torch
from torch import Tensor

from kwatra.base import product
from kwatra.source.closest import closest
from kwatra.source.components import random_probe, randomized_basis
from kwatra.source.protocol import Description, chunk
from kwatra.windows import Metric

DIMS = 24
"""Principal components of a descriptor. Stills of four textures score the same with half and twice as many."""

_SAMPLE = 3000
"""So many windows the components are learned from."""


class Described(ABC):
    """A `Source` that is searched by descriptors; a kind of source says what its windows are.

    A kind calls this `__init__` last. Windows are described when that is first asked for, from what is drawn before.
    """

    def __init__(self, metric: Metric, numbers: Tensor, dims: int, generator: torch.Generator) -> None:
        self.metric, self.numbers, self.device = metric, numbers, numbers.device
        self._dims = dims
        self._pick = torch.randperm(len(numbers), generator=generator)[:_SAMPLE]
        self._probe = random_probe((len(self._pick), metric.size), dims, generator)

    @cached_property
    def _components(self) -> tuple[Tensor, Tensor]:
        """The mean (M,) of windows as the metric embeds them, and a basis (M, K) of how they differ from it."""
        sample = self.metric.embed(self.windows(self.numbers[self._pick.to(self.device)]))
        mean = sample.mean(0)
        return mean, randomized_basis(sample - mean, self._dims, self._probe)

    @cached_property
    def _description(self) -> Description:
        """All windows below `count` described: where windows are only compared as they are it is not asked for."""
        mean, basis = self._components
        shift, count, first = product(mean[None], basis), self.count, 0
        every, remainder = mean.new_empty(count, basis.shape[1]), mean.new_empty(count)
        for along, length in self.projections(basis, mean):
            some = slice(first, first := first + len(along))
            descriptors = torch.sub(along, shift, out=every[some])
            # squared length of each centered window, to know what the descriptor leaves out
            remainder[some] = (length - descriptors.square().sum(1)).clamp(min=0).sqrt()
        return Description(every, remainder)

    @property
    def descriptors(self) -> Tensor:
        """The descriptor (count, K) of every window."""
        return self._description.descriptor

    @property
    def remainder(self) -> Tensor:
        """The length (count,) of what each descriptor leaves out."""
        return self._description.remainder

    @property
    @abstractmethod
    def count(self) -> int:
        """See `Source.count`."""

    @abstractmethod
    def windows(self, numbers: Tensor) -> Tensor:
        """See `Source.windows`."""

    @abstractmethod
    def values(self, numbers: Tensor, inside: Sequence[Tensor]) -> Tensor:
        """See `Source.values`."""

    @abstractmethod
    def projections(self, basis: Tensor, mean: Tensor) -> Iterator[tuple[Tensor, Tensor]]:
        """Every window z below `count` seen under E, the metric's embedding, in order, some at a time.

        basis (M, K), mean (M,). Gives (E z)^T basis (n, K) and |E z - mean|^2 (n,) of the next n.
        """

    def describe(self, windows: Tensor) -> Description:
        """See `Source.describe`."""
        mean, basis = self._components
        centered = self.metric.embed(windows) - mean
        descriptor = product(centered, basis)
        return Description(descriptor, ((centered**2).sum(1) - (descriptor**2).sum(1)).clamp(min=0).sqrt())

    def projected(self, windows: Tensor) -> Description:
        """Windows (N, *width, C) as `describe` has them, but for rounding, with remainders of 0: all that a search for
        the nearest looks at, at a third of the cost. The metric has no features.
        """
        (mean, basis), root = self._components, self.metric.root.flatten()[:, None]
        descriptor = product(windows.flatten(1), root * basis[: len(root)]) - product(mean[None], basis)
        return Description(descriptor, torch.zeros_like(descriptor[:, 0]))

    def completed(self, windows: Tensor, present: Tensor) -> Tensor:
        """Windows (N, *width, C) whose pixels without `present` (N, *width, 1) are replaced by their expected values.

        Expected given the present pixels, for exemplar windows distributed normally in their principal components
        and evenly outside of them: probabilistic PCA with missing data (Tipping and Bishop 1999, appendix B).
        """
        root = self.metric.root
        size = root.numel()
        mean, basis = (part[:size] for part in self._components)
        spread = self.descriptors[self.numbers].square().mean(0)
        noise = self.remainder[self.numbers].square().mean() / max(size - basis.shape[1], 1)
        ridge = torch.diag(noise.clamp(min=1e-9) / spread.clamp(min=1e-12))
        products = (basis[:, :, None] * basis[:, None]).flatten(1)
        result = []
        for part, seen in zip(*(t.split(max(chunk(self.device) // size, 1)) for t in (windows, present)), strict=True):
            weight = seen.expand_as(part).flatten(1)
            system = (weight @ products).view(-1, *ridge.shape) + ridge
            known = weight * ((part * root).flatten(1) - mean)
            expected = mean + torch.linalg.solve(system, (known @ basis)[..., None])[..., 0] @ basis.T
            expected = expected.view_as(part) / root.clamp(min=1e-12)
            result.append(torch.where(seen > 0, part, expected))
        return torch.cat(result)

    def estimate(self, described: Description, numbers: Tensor) -> Tensor:
        """See `Source.estimate`."""
        between = self.descriptors[numbers] - described.descriptor[:, None]
        return (between**2).sum(-1) + (self.remainder[numbers] - described.remainder[:, None]) ** 2

    @cached_property
    def _exact(self) -> faiss.Index:
        index = faiss.IndexFlatL2(self.descriptors.shape[1])
        index.add(self._searched.numpy())
        return index

    @cached_property
    def _approximate(self) -> faiss.Index:
        table = self._searched.numpy()
        lists = max(min(int(2 * math.sqrt(len(table))), len(table) // 39), 1)
        index = faiss.IndexIVFFlat(faiss.IndexFlatL2(table.shape[1]), table.shape[1], lists)
        index.cp.niter, index.cp.seed, index.cp.max_points_per_centroid = 6, 1, 64
        index.cp.min_points_per_centroid = 1  # or faiss prints a warning
        index.train(table)
        index.add(table)
        index.nprobe = max(lists // 128, 4)
        return index

    @property
    def _searched(self) -> Tensor:
        return self.descriptors[self.numbers]

    def nearest(self, described: Description, k: int, route: str) -> Tensor:
        """See `Source.nearest`."""
        if self.device.type != "cpu":
            return self.numbers[closest(self._searched, described.descriptor, k)]
        index = self._exact if route == "exact" else self._approximate
        _, found = index.search(np.ascontiguousarray(described.descriptor.numpy()), min(k, len(self.numbers)))
        found = np.where(found < 0, found[:, :1], found)
        return self.numbers[torch.from_numpy(found)]
