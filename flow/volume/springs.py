"""Springs between the pixels of a video: each pulls a pixel and the place that the flow carries it to together.

Thesis equation 29, sum over (p, i) of (x(p, i) - x(q, i + 1))^2 with q = f_i(p), is |S x|^2 for a sparse matrix S with
a row for each spring. Frame by frame its rows are K_i (E_i - W_i E_{i+1}): E_i picks a frame, W_i reads the next one
where the flow leads (`flow.Warp`, bilinear), and K_i leaves out what flows beyond the frame, or to or from behind a
mask. What engine and search need are products with F = S^T S, its diagonal, and how pixels of one frame are coupled.
"""

from collections.abc import Iterator
from functools import cached_property
from itertools import combinations

import torch
from torch import Tensor

from flow.warps import Warp, pixel_coordinates
from kwatra.base import LARGEST, coarse_shape, resized

_EDGE = 1e-3
"""Px by which a place may lie beyond the centers of the border's pixels: rounding."""

PAIRS = ((0, 1), (1, -1), (1, 0), (1, 1))
"""Rows and columns from a pixel to another one that the same spring reads, for half of the pairs."""


class Springs:
    """The springs of a video of `shape` (T, H, W) along flows (T - 1, 2, H, W), x first, in pixels per frame.

    With T flows the last frame leads to the first. wrap: frames are periodic. mask (T, H, W): True where there is
    texture. Memory: about 40 floats per pixel.
    """

    def __init__(
        self, flows: Tensor, shape: tuple[int, int, int], wrap: bool = False, mask: Tensor | None = None
    ) -> None:
        self.shape, self.wrap, self.loop = shape, wrap, len(flows) == shape[0]
        self._warps: list[Warp] = []
        self.known = torch.zeros(len(flows), *shape[1:], dtype=torch.bool, device=flows.device)
        for frame, flow in enumerate(flows):
            places = pixel_coordinates(flow.shape[1:], flow.device) + flow
            counts, places = _seen(places, wrap)
            if mask is not None:
                counts = counts & mask[frame]
                behind = (~mask[(frame + 1) % shape[0]])[None].to(flow)
                counts = counts & (Warp(places, shape[1:], "bilinear", wrap)(behind)[0] == 0)
            self.known[frame] = counts
            self._warps.append(Warp(places, shape[1:], "bilinear", wrap, counts))

    def _frames(self) -> Iterator[tuple[int, int, Warp]]:
        """Every frame, the one after it, and the warp between."""
        for frame, warp in enumerate(self._warps):
            yield frame, (frame + 1) % self.shape[0], warp

    def times(self, x: Tensor) -> Tensor:
        """F x of a video (C, T, H, W)."""
        pulled = torch.zeros_like(x)
        for frame, after, warp in self._frames():
            stretch = self.known[frame] * x[:, frame] - warp(x[:, after])
            pulled[:, frame] += stretch
            pulled[:, after] -= warp.transposed(stretch)
        return pulled

    @cached_property
    def diagonal(self) -> Tensor:
        """The diagonal of F, (1, T, H, W)."""
        diagonal = torch.zeros(1, *self.shape, dtype=torch.float32, device=self.known.device)
        for frame, after, warp in self._frames():
            ones = self.known[frame][None].to(diagonal)
            diagonal[:, frame] += ones
            diagonal[:, after] += warp.diagonal(ones)
        return diagonal

    @cached_property
    def readings(self) -> tuple[Tensor, Tensor]:
        """For each spring the 4 pixels (4, T, H, W) of the next frame that it reads, counted row by row, and their
        weights, 0 where there is no spring.
        """
        pixels = torch.zeros(4, *self.shape, dtype=torch.long, device=self.known.device)
        weights = torch.zeros(pixels.shape, dtype=torch.float32, device=pixels.device)
        for frame, _, warp in self._frames():
            pixels[:, frame], weights[:, frame] = warp.entries()
        return pixels, weights

    @cached_property
    def couplings(self) -> Tensor:
        """F between every pixel and its neighbors `PAIRS` of the same frame, (4, T, H, W)."""
        coupled = torch.zeros(
            len(PAIRS), self.shape[0], self.shape[1] * self.shape[2], dtype=torch.float32, device=self.known.device
        )
        pixels, weights = (values.flatten(2) for values in self.readings)
        # entries run over two rows of two columns
        places = [divmod(entry, 2) for entry in range(4)]
        for one, other in combinations(range(4), 2):
            offset = (places[other][0] - places[one][0], places[other][1] - places[one][1])
            for frame, after, _ in self._frames():
                both = weights[one, frame] * weights[other, frame]
                coupled[PAIRS.index(offset), after].index_add_(0, pixels[one, frame], both)
        return coupled.view(len(PAIRS), *self.shape)


def _seen(places: Tensor, wrap: bool) -> tuple[Tensor, Tensor]:
    """Which places (2, H, W) lie in the frame, (H, W), and all of them, moved into it."""
    if wrap:
        return torch.ones_like(places[0], dtype=torch.bool), places
    last = places.new_tensor([places.shape[2] - 1, places.shape[1] - 1]).view(2, 1, 1)
    inside = ((places >= -_EDGE) & (places <= last + _EDGE)).all(0)
    return inside, places.clamp(min=0).minimum(last)


def coarser(flows: Tensor, factor: tuple[int, ...], mask: Tensor | None) -> Tensor:
    """Flows (N, 2, H, W) where pixels are `factor` (rows, columns) times coarser: means over blocks, in those pixels.

    mask (T, H, W): flows count where it is True.
    """
    shape = coarse_shape(flows.shape[2:], factor)
    scale = torch.tensor(factor[::-1], device=flows.device).view(2, 1, 1)
    if mask is None:
        return torch.stack([resized(flow, factor, shape) / scale for flow in flows])
    counts = mask[: len(flows), None].to(flows)
    share = torch.stack([resized(count, factor, shape) for count in counts]).clamp(min=1e-12)
    return torch.stack([resized(flow, factor, shape) / scale for flow in torch.where(counts > 0, flows, 0.0)]) / share


def coarser_mask(mask: Tensor, factor: tuple[int, ...]) -> Tensor:
    """A mask (T, H, W) of blocks: True where any pixel of the block is, as in the engine."""
    return LARGEST[3](mask[None, None].float(), factor, ceil_mode=True)[0, 0] > 0
