"""Which exemplar window explains an output window best (the M-step of thesis algorithm 1).

Windows are compared under the Gaussian falloff G (thesis 5.2). A PCA of weighted exemplar windows gives each window
a short descriptor; describing every exemplar window is a convolution with the principal components, so no table of
windows is ever stored. Candidates come from an index over descriptors - exact, or approximate (inverted lists) for
many windows against many - and from coherence: the match a window had, and those of its grid neighbors, shifted.
The few most promising are compared exactly, with everything terms and usage add, and the cheapest wins.
"""

import math
from collections.abc import Callable, Sequence
from functools import cached_property

import faiss
import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra.base import CONVOLUTION, InputError
from kwatra.exemplar import Exemplar
from kwatra.windows import Feature, Metric, channels_last, windows_at

ROUTES = ("exact", "approximate", "coherent")
CHUNK = 1 << 21
"""Values in one temporary of a pass over windows: bounds its memory to a few times 8 MiB.

Larger ones leave the cache, and malloc gives their pages back each time: with 2^24 a 1024x1024 image took a third
longer, half of all its time in the system."""


class SourceWindows:
    """All windows of an exemplar of one width, described for searching.

    A window is known by its number: its corner (first pixel) counted row by row over the canvas positions
    `positions` = S - width + 1. Memory: `dims` + 1 floats per position, plus the index's copy.
    """

    def __init__(
        self,
        exemplar: Exemplar,
        width: Sequence[int],
        generator: torch.Generator,
        dims: int = 24,
        features: Sequence[Feature] = (),
    ) -> None:
        self.exemplar, self.width = exemplar, tuple(width)
        valid = exemplar.corners(self.width)
        if not bool(valid.any()):
            size = "x".join(map(str, self.width))
            raise InputError(f"no {size} window fits into the exemplar; choose smaller windows or a larger exemplar")
        self.positions = tuple(valid.shape)
        self.device = exemplar.canvas.device
        self.pixels = channels_last(exemplar.canvas)
        self._place = torch.tensor([math.prod(self.positions[i + 1 :]) for i in range(valid.ndim)], device=self.device)
        self.numbers = valid.flatten().nonzero()[:, 0]
        # the nearest position where a window may start, for every position
        nearest = ndimage.distance_transform_edt(~valid.cpu().numpy(), return_distances=False, return_indices=True)
        self._snap = self.number(torch.from_numpy(nearest.astype(np.int64)).to(self.device).flatten(1).T)
        self.metric = Metric(self.width, exemplar.weights, features)
        self._principal_components(dims, generator)

    def number(self, corners: Tensor) -> Tensor:
        """Window numbers of corners (..., n) that are positions."""
        return (corners * self._place).sum(-1)

    def corners(self, numbers: Tensor) -> Tensor:
        """Corners (..., n) of window numbers."""
        shape = torch.tensor(self.positions, device=self.device)
        return (numbers[..., None] // self._place) % shape

    def snapped(self, corners: Tensor) -> Tensor:
        """Numbers of the usable windows nearest to corners (..., n), which may lie anywhere."""
        top = torch.tensor(self.positions, device=self.device) - 1
        return self._snap[self.number(corners.clamp(min=0).minimum(top))]

    def windows(self, numbers: Tensor) -> Tensor:
        """The exemplar's windows of these numbers, (N, *width, C)."""
        return windows_at(self.pixels, self.corners(numbers), self.width)

    def _principal_components(self, dims: int, generator: torch.Generator) -> None:
        count = min(len(self.numbers), 3000)
        pick = torch.randperm(len(self.numbers), generator=generator)[:count].to(self.device)
        sample = self.metric.embed(self.windows(self.numbers[pick]))
        self._mean = sample.mean(0)
        self._basis = _randomized_basis(sample - self._mean, dims, generator)
        components = self.metric.transposed(self._basis.T.contiguous())
        self.descriptors = self._correlated(components).T.contiguous() - self._mean @ self._basis
        # squared length of each centered window, to know what the descriptor leaves out
        length = self._lengths() - (self.descriptors**2).sum(1)
        self.remainder = length.clamp(min=0).sqrt()

    def _correlated(self, kernels: Tensor, squared: bool = False) -> Tensor:
        """Inner products (K, positions) of window-shaped kernels (K, *width, C) with every window of the canvas."""
        canvas = self.exemplar.canvas[None]
        convolve = CONVOLUTION[len(self.width)]
        return convolve(canvas.square() if squared else canvas, kernels.movedim(-1, 1).contiguous())[0].flatten(1)

    def _lengths(self) -> Tensor:
        """|E z - mean|^2 for the window at every position."""
        if self.metric.plain:
            mean = self.metric.transposed(self._mean[None])
            square = self._correlated(self.metric.weight[None], squared=True)[0]
            return square - 2 * self._correlated(mean)[0] + (self._mean**2).sum()
        lengths = self.descriptors.new_zeros(len(self.descriptors))
        for numbers in self.numbers.split(max(CHUNK // self._mean.numel(), 1)):
            lengths[numbers] = (self.metric.embed(self.windows(numbers)) - self._mean).square().sum(1)
        return lengths

    def describe(self, windows: Tensor) -> tuple[Tensor, Tensor]:
        """Descriptors (N, dims) of windows (N, *width, C), and the length (N,) of what they leave out."""
        centered = self.metric.embed(windows) - self._mean
        descriptor = centered @ self._basis
        return descriptor, ((centered**2).sum(1) - (descriptor**2).sum(1)).clamp(min=0).sqrt()

    def completed(self, windows: Tensor, present: Tensor) -> Tensor:
        """Windows (N, *width, C) whose pixels without `present` (N, *width, 1) are replaced by their expected values.

        Expected given the present pixels, for exemplar windows distributed normally in their principal components
        and evenly outside of them: probabilistic PCA with missing data (Tipping and Bishop 1999, appendix B).
        """
        root = self.metric.root
        size = root.numel()
        mean, basis = self._mean[:size], self._basis[:size]
        spread = self.descriptors[self.numbers].square().mean(0)
        noise = self.remainder[self.numbers].square().mean() / max(size - basis.shape[1], 1)
        ridge = torch.diag(noise.clamp(min=1e-9) / spread.clamp(min=1e-12))
        products = (basis[:, :, None] * basis[:, None]).flatten(1)
        result = []
        for part, seen in zip(*(t.split(max(CHUNK // size, 1)) for t in (windows, present)), strict=True):
            weight = seen.expand_as(part).flatten(1)
            system = (weight @ products).view(-1, *ridge.shape) + ridge
            known = weight * ((part * root).flatten(1) - mean)
            expected = mean + torch.linalg.solve(system, (known @ basis)[..., None])[..., 0] @ basis.T
            expected = expected.view_as(part) / root.clamp(min=1e-12)
            result.append(torch.where(seen > 0, part, expected))
        return torch.cat(result)

    def estimate(self, descriptor: Tensor, remainder: Tensor, numbers: Tensor) -> Tensor:
        """Estimated squared distances (N, k) between described windows and exemplar windows (N, k)."""
        between = self.descriptors[numbers] - descriptor[:, None]
        return (between**2).sum(-1) + (self.remainder[numbers] - remainder[:, None]) ** 2

    @cached_property
    def _exact(self) -> faiss.Index:
        index = faiss.IndexFlatL2(self.descriptors.shape[1])
        index.add(self._indexed())
        return index

    @cached_property
    def _approximate(self) -> faiss.Index:
        table = self._indexed()
        lists = max(min(int(2 * math.sqrt(len(table))), len(table) // 39), 1)
        index = faiss.IndexIVFFlat(faiss.IndexFlatL2(table.shape[1]), table.shape[1], lists)
        index.cp.niter, index.cp.seed, index.cp.max_points_per_centroid = 6, 1, 64
        index.train(table)
        index.add(table)
        index.nprobe = max(lists // 128, 4)
        return index

    def _indexed(self) -> np.ndarray:
        return np.ascontiguousarray(self.descriptors[self.numbers].cpu().numpy())

    def nearest(self, descriptors: Tensor, k: int, route: str) -> Tensor:
        """Numbers (N, k) of the exemplar windows nearest to descriptors (N, dims), nearest first."""
        index = self._exact if route == "exact" else self._approximate
        _, found = index.search(np.ascontiguousarray(descriptors.cpu().numpy()), min(k, len(self.numbers)))
        found = np.where(found < 0, found[:, :1], found)
        return self.numbers[torch.from_numpy(found).to(self.device)]


def _randomized_basis(rows: Tensor, dims: int, generator: torch.Generator) -> Tensor:
    """Leading right singular vectors (D, <= dims) of rows (N, D) by randomized subspace iteration (Halko 2011, 4.4).

    Orthonormal bases come from eigenvectors of small Gram matrices: unlike a QR of the tall matrix, these are the
    same bits for any number of threads.
    """
    dims = min(dims, *rows.shape)
    probe = torch.randn(rows.shape[1], min(dims + 8, *rows.shape), generator=generator).to(rows)
    for _ in range(2):
        probe = _orthonormal(rows.T @ (rows @ probe))
    reduced = (rows @ probe).double()
    _, vectors = torch.linalg.eigh(reduced.T @ reduced)
    return probe @ vectors.flip(1)[:, :dims].to(rows)


def _orthonormal(columns: Tensor) -> Tensor:
    """An orthonormal basis of what the columns span; directions lost to rounding become zero."""
    columns = columns.double()
    columns = columns / columns.norm(dim=0).clamp(min=1e-30)
    values, vectors = torch.linalg.eigh(columns.T @ columns)
    scale = torch.where(values > 1e-9 * values[-1], values.clamp(min=1e-30).rsqrt(), 0.0)
    return (columns @ (vectors * scale)).float()


def cheapest(
    source: SourceWindows, candidates: Tensor, cost: Callable[[Tensor], tuple[Tensor, Tensor]]
) -> tuple[Tensor, Tensor]:
    """Choose among candidates (N, k) by exact cost; the first of equals wins.

    `cost` maps exemplar windows (N, *width, C) to what is compared (N,) and to squared distances (N,). Returns the
    chosen numbers (N,) and their squared distances (N,).
    """
    best = candidates[:, 0]
    least, distance = cost(source.windows(best))
    for column in candidates.T[1:]:
        c, d = cost(source.windows(column))
        better = c < least
        best = torch.where(better, column, best)
        distance = torch.where(better, d, distance)
        least = torch.where(better, c, least)
    return best, distance
