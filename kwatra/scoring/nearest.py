"""All windows of some images or videos as one set, and the nearest of them to any window.

The windows of a coarse scale are not cut from a shrunk image: shrinking keeps one phase of the
sampling grid, and an exemplar moved by one pixel then looks foreign to itself. Here a window of
scale s has its pixels s apart, each the mean of s x s pixels, and one stands at every position of
the full-size image, so all phases are in the set.

`Nearest` searches in the leading principal components. The length of what they miss of a window is
one more coordinate, which makes the searched distance a lower bound of the true one; the best few
candidates are then measured in full. So a distance returned is that of a real window, never too
small. Against exhaustive search on six photographs and their syntheses the mean distance was too
large by 0.3% on average and by 2% at most; sampling the queries costs about as much.
"""

import functools
import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from threading import Lock
from typing import Any, ParamSpec, TypeVar

import faiss
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base import by_one_thread

WINDOW = 7
"""Pixels to a side of the windows that figures compare: this and what follows define them, and are tuned on nothing."""

QUERIES = 2000
"""About so many windows are looked up for a distance."""

COMPONENTS = 32
"""Principal components that windows are searched by."""

PART = 2**16
"""Windows held at a time, as rows and in the index: the bound on memory."""

SAMPLE = 2**13
"""Windows that the principal components and the index's lists are learned from."""

LISTS, PROBED = 128, 8
"""Lists that a large set is divided into, a very large one into four times as many; lists searched."""

Arguments = ParamSpec("Arguments")
Value = TypeVar("Value")


def one_thread(function: Callable[Arguments, Value]) -> Callable[Arguments, Value]:
    """Run `function` on one thread: sums shared by threads change in their last bits with their number."""

    @functools.wraps(function)
    def alone(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Value:
        threads = faiss.omp_get_max_threads()
        faiss.omp_set_num_threads(1)
        try:
            with by_one_thread():
                return function(*args, **kwargs)
        finally:
            faiss.omp_set_num_threads(threads)

    return alone


@dataclass(frozen=True)
class Windows:
    """The windows of some videos, `depth` frames of size x size pixels, numbered video by video and as pixels are.

    videos: (C, T, H, W) float32 each, an image being a video of one frame; already averaged over scale x scale pixels.
    scale: how many pixels the neighbors within a window are apart; frames are never left out.
    """

    videos: tuple[Tensor, ...]
    size: int
    scale: int = 1
    depth: int = 1

    @classmethod
    def of(cls, videos: Sequence[Tensor], size: int, scale: int = 1, depth: int = 1) -> "Windows":
        """The windows of images (C, H, W) or videos (C, T, H, W) with at least size * scale pixels to a side."""
        several = (video[:, None] if video.ndim == 3 else video for video in videos)
        return cls(tuple(F.avg_pool2d(video, scale, stride=1) for video in several), size, scale, depth)

    @property
    def span(self) -> int:
        """Pixels from a window's first to its last, both included."""
        return (self.size - 1) * self.scale + 1

    @property
    def grids(self) -> list[tuple[int, int, int]]:
        """Windows along time, down and across in each video."""
        margins = self.depth - 1, self.span - 1, self.span - 1
        return [
            (frames - margins[0], height - margins[1], width - margins[2])
            for _, frames, height, width in (video.shape for video in self.videos)
        ]

    def __len__(self) -> int:
        return sum(map(math.prod, self.grids))

    def places(self, numbers: Tensor) -> Tensor:
        """Video, frame, row and column (4, n) of the first, top left pixels of the windows numbered (n,)."""
        places = torch.empty(4, len(numbers), dtype=torch.long)
        first = 0
        for video, (frames, height, width) in enumerate(self.grids):
            mine = (numbers >= first) & (numbers < first + frames * height * width)
            rest = numbers[mine] - first
            # torch.unravel_index loads a compiler that is not used, for a third of a second
            found = rest // (height * width), rest // width % height, rest % width
            places[:, mine] = torch.stack([torch.full_like(rest, video), *found])
            first += frames * height * width
        return places

    def rows(self, numbers: Tensor) -> Tensor:
        """The windows numbered (n,), one a row (n, C * depth * size * size)."""
        from kwatra.scoring.loops import read_windows

        video_of, *places = self.places(numbers)
        rows = torch.empty(len(numbers), self.videos[0].shape[0] * self.depth * self.size**2, dtype=torch.float32)
        for number, video in enumerate(self.videos):
            mine = (video_of == number).nonzero()[:, 0]
            there = torch.stack(places)[:, mine].contiguous()
            read_windows(len(mine), video.contiguous(), there, self.depth, self.size, self.scale, mine, rows)
        return rows

    def sample(self, about: int) -> Tensor:
        """Numbers of about `about` windows, always the same: a random one from each cell of a grid."""
        long = min((len(self) / about) ** (1 / 3), max(frames for frames, _, _ in self.grids))
        side = math.sqrt(len(self) / about / long)
        if side <= 1:
            return torch.arange(len(self))
        generator = torch.Generator().manual_seed(0)
        numbers, first = [], 0
        for grid in self.grids:
            numbers.append(first + _one_per_cell(grid, (long, side, side), generator))
            first += math.prod(grid)
        return torch.cat(numbers).unique()

    def strips(self) -> Iterator[tuple[int, Tensor]]:
        """Parts (C, t, h, W) of the videos that hold about PART windows each, and their first windows' numbers."""
        first = 0
        for video, (frames, height, width) in zip(self.videos, self.grids, strict=True):
            long = max(1, PART // (height * width))
            high = height if long > 1 else max(1, PART // width)
            for frame, top in itertools.product(range(0, frames, long), range(0, height, high)):
                part = video[:, frame : frame + long + self.depth - 1, top : top + high + self.span - 1]
                yield first + (frame * height + top) * width, part
            first += frames * height * width


def _one_per_cell(grid: Sequence[int], cell: Sequence[float], generator: torch.Generator) -> Tensor:
    """Numbers of random places of a grid (frames, rows, columns), one in each of equal boxes of a cell's size."""
    counts = [math.ceil(extent / side) for extent, side in zip(grid, cell, strict=True)]
    down, right, later = torch.rand(3, *counts, generator=generator, dtype=torch.float64)
    corners = torch.meshgrid(*map(torch.arange, counts), indexing="ij")
    frame, row, column = (
        ((corner + within) * extent / count).long()
        for corner, within, extent, count in zip(corners, (later, down, right), grid, counts, strict=True)
    )
    return ((frame * grid[1] + row) * grid[2] + column).flatten()


@dataclass(frozen=True)
class Projection:
    """Principal components of windows: mean (d,), leading directions (d, components), deviations (components,)."""

    mean: Tensor
    directions: Tensor
    deviations: Tensor

    @classmethod
    def learned_from(cls, rows: Tensor, components: int = COMPONENTS) -> "Projection":
        """The components of rows (n, d), in double precision."""
        mean = rows.mean(0, dtype=torch.float64)
        centered = rows.double() - mean
        squares, vectors = torch.linalg.eigh(centered.T @ centered)
        deviations = (squares[-components:].clamp(min=0) / len(rows)).sqrt()
        return cls(mean.float(), vectors[:, -components:].float(), deviations.float())

    def __call__(self, rows: Tensor) -> Tensor:
        """Coordinates (n, components + 1) of rows (n, d), the last the length of what is missed."""
        centered = rows - self.mean
        leading = centered @ self.directions
        missed = centered.square().sum(1) - leading.square().sum(1)
        return torch.cat((leading, missed.clamp(min=0).sqrt()[:, None]), 1)

    def whitened(self, rows: Tensor) -> Tensor:
        """Coordinates (n, components) of rows (n, d), in the deviations of what the components were learned from.

        Components that vary less than a thousandth of the first are rounding, and stay as they are.
        """
        leading = (rows - self.mean) @ self.directions
        least = 1e-3 * self.deviations.max()
        return leading / torch.where(self.deviations > least, self.deviations, 1.0)

    def all_windows(self, video: Tensor, windows: Windows) -> Tensor:
        """The same coordinates of all windows of a part (C, t, h, w) of a video, in order, by convolution."""
        channels, shape = video.shape[0], (windows.depth, windows.size, windows.size)
        convolve = functools.partial(F.conv3d, dilation=(1, windows.scale, windows.scale))
        mean = self.mean.reshape(channels, -1)
        color = mean.mean(1, keepdim=True)  # without it the squares lose half their digits
        video, mean = video - color[..., None, None], (mean - color).flatten()
        filters = torch.cat((self.directions, mean[:, None]), 1).T
        along = convolve(video[None], filters.reshape(-1, channels, *shape))[0]
        squares = convolve(video.square().sum(0)[None, None], torch.ones(1, 1, *shape, dtype=torch.float32))[0]
        leading = along[:-1] - (mean @ self.directions)[:, None, None, None]
        missed = squares - 2 * along[-1:] + mean.square().sum() - leading.square().sum(0)
        return torch.cat((leading, missed.clamp(min=0).sqrt())).flatten(1).T.contiguous()


class Learned:
    """What a search learns from windows: so many principal `components`, and where lists of windows have centers."""

    def __init__(self, windows: Windows, components: int) -> None:
        rows = windows.rows(windows.sample(SAMPLE))
        self.project = Projection.learned_from(rows, components)
        self.points = self.project(rows)
        self._lists = min(LISTS if len(windows) <= 4 * PART else 4 * LISTS, len(rows))

    @functools.cached_property
    def centers(self) -> Any:
        """The centers (lists, components + 1) of lists, as an index; small sets need none, so found when asked for."""
        flat = faiss.IndexFlatL2(self.points.shape[1])
        index = faiss.IndexIVFFlat(flat, flat.d, self._lists)
        index.cp.niter = 6
        index.cp.min_points_per_centroid = 1  # or faiss prints a warning
        index.train(self.points.numpy())
        return flat


class Nearest:
    """Finds the nearest of `windows`; holds PART of them at a time, whatever their number.

    Threads that search at once wait for each other, for what is held changes while one searches.
    """

    def __init__(self, windows: Windows, like: "Nearest | None" = None, components: int = COMPONENTS) -> None:
        """like: of windows much the same: what was learned from them serves here too. components: as in `Learned`."""
        self.windows = windows
        self.learned: Learned = Learned(windows, components) if like is None else like.learned
        self.project = self.learned.project
        self._index = self._empty_index()
        self._held, self._holding = -1, Lock()

    def search(self, rows: Tensor, candidates: int = 8) -> tuple[Tensor, Tensor]:
        """Rms distance (n,) from rows (n, d) to their nearest windows, and the numbers (n,) of these.

        candidates: how many to measure in full for each row; few are enough to find exact copies.
        """
        points = self.project(rows).numpy()
        bound = torch.full((len(rows), candidates), torch.inf, dtype=torch.float32)
        number = torch.zeros(len(rows), candidates, dtype=torch.long)
        for first, strip in self.windows.strips():
            with self._holding:
                self._hold(first, strip)
                lower, found = map(torch.from_numpy, self._index.search(points, candidates))
            number = torch.cat((number, found.clamp(min=0) + first), 1)
            bound, best = torch.cat((bound, lower), 1).topk(candidates, largest=False)
            number = number.gather(1, best)
        measured = [self._distance(rows, column) for column in number.T]
        distance, best = torch.stack(measured).min(0)
        return distance, number.gather(1, best[:, None])[:, 0]

    def _distance(self, rows: Tensor, numbers: Tensor) -> Tensor:
        return (self.windows.rows(numbers) - rows).square().mean(1).sqrt()

    def _empty_index(self) -> Any:
        if len(self.windows) <= SAMPLE:
            return faiss.IndexFlatL2(self.learned.points.shape[1])
        centers = self.learned.centers  # kept there, for the index does not keep them alive by itself
        index = faiss.IndexIVFFlat(centers, centers.d, centers.ntotal)
        index.nprobe = PROBED
        return index

    def _hold(self, first: int, strip: Tensor) -> None:
        """Fill the index with the windows of a strip, unless it holds them already."""
        if first != self._held:
            self._index.reset()
            points = self.project.all_windows(strip, self.windows)
            self._index.add(points.numpy())
            self._held = first
