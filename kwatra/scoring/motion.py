"""How videos change and move, by their variograms in space and time.

A video is split into bands of ever coarser detail (differences between one smoothing and the next), and in each band
the mean square step is taken (the variogram of geostatistics; Cressie and Huang 1999),

    gamma(d, k) = mean over p, t of |x(p + d, t + k) - x(p, t)|^2 .

gamma(0, k) says how fast what is at one place changes: 0 in a still, the same for all k where frames have nothing to do
with each other. gamma(d, 1) is least where d is how far things move in a frame. Its odd part,

    a(d) = (gamma(d, 1) - gamma(-d, 1)) / (gamma(d, 1) + gamma(-d, 1)),

changes its sign when time runs backwards: it is what correlation detectors of motion see (Reichardt 1961).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import torch
import torch.nn.functional as F
from torch import Tensor

LAGS = (1, 2, 4, 8)
"""Frames apart that are compared."""

MOST_BANDS = 5
"""Octaves of detail that are looked at, where a frame has so many."""

BLOCK = 16
"""Frames held at a time, beside those that the longest lag reaches: the bound on memory."""

FLOOR = 1e-3
"""Steps below this part of a band's mean square step in space are rounding."""

UNDIRECTED = 0.02
"""About what a(d) of the halves of one clip, 15 frames each, differ by: so much is chance where nothing has a way."""

_DIRECTIONS = ((0, 1), (1, 0), (1, 1), (1, -1))


@dataclass(frozen=True)
class Variogram:
    """Mean square steps by band.

    still (bands, lags): gamma(0, k), NaN for lags that no video has. odd (bands, 8): a(d) for four directions of d,
    1 and 2 pixels long in the first band, twice as long in each that follows. even (bands,): mean of gamma(d, 1) over
    them. Both 0 for videos of one frame.
    """

    still: Tensor
    odd: Tensor
    even: Tensor

    @classmethod
    def of(cls, videos: Sequence[Tensor], bands: int) -> "Variogram":
        """Of all steps in some videos (C, T, H, W) together."""
        sums = torch.zeros(2, bands, len(LAGS) + 4 * len(_DIRECTIONS), dtype=torch.float64)
        for part in (part for video in videos for part in _parts(video)):
            for number, band in enumerate(_bands(part, bands)):
                for column, steps in _steps(band, 2**number):
                    sums[0, number, column] += steps.square().sum(dtype=torch.float64)
                    sums[1, number, column] += steps.numel()
        gamma = sums[0] / sums[1]
        still, moved = gamma[:, : len(LAGS)], gamma[:, len(LAGS) :]
        forth, back = moved[:, 0::2], moved[:, 1::2]
        return cls(still, torch.nan_to_num((forth - back) / (forth + back)), torch.nan_to_num(moved.mean(1)))


def count_of_bands(videos: Sequence[Tensor]) -> int:
    """Bands whose displacements are at most a quarter of every side; at least one."""
    shortest = min(min(video.shape[2:]) for video in videos)
    return min(MOST_BANDS, max(1, int(math.log2(shortest / 4))))


def tempo(output: Variogram, exemplar: Variogram) -> float:
    """Mean |log| of the ratio of rms steps over the lags, in all bands: 0 is right, 0.1 is off by 10%."""
    floor = FLOOR * exemplar.even[:, None] + torch.finfo(torch.float32).tiny
    log_ratio = ((output.still + floor) / (exemplar.still + floor)).log() / 2
    return float(torch.nan_to_num(log_ratio.abs().nanmean()))


def order(output: Variogram, exemplar: Variogram) -> float:
    """Largest difference, over the bands, in what one frame changes as a part of what many change (mean squares).

    0 is right; near 1 frames that do not follow from each other, or that are all the same.
    """
    return float(torch.nan_to_num(_memory(output, exemplar) - _memory(exemplar, output)).abs().max())


def direction(output: Variogram, exemplar: Variogram) -> float:
    """Difference of the odd parts as a part of the exemplar's: 0 is right, 1 no direction, 2 the opposite one."""
    off, own = (odd.square().mean().sqrt() for odd in (output.odd - exemplar.odd, exemplar.odd))
    return float(off / (own + UNDIRECTED))


def _memory(one: Variogram, other: Variogram) -> Tensor:
    """gamma(0, 1) / gamma(0, k) for the longest lag k that both have, by band."""
    both = ~(one.still + other.still).isnan().any(0)
    if not both.any():
        return torch.zeros(len(one.still), dtype=torch.float32)
    return one.still[:, 0] / (one.still[:, both][:, -1] + torch.finfo(torch.float32).tiny)


def _parts(video: Tensor) -> Iterator[Tensor]:
    """Frames BLOCK by BLOCK, each with as many after them as the longest lag reaches."""
    return (video[:, first : first + BLOCK + LAGS[-1]] for first in range(0, video.shape[1], BLOCK))


def _bands(video: Tensor, count: int) -> Iterator[Tensor]:
    for number in range(count):
        smoother = _smoothed(video, 2**number)
        yield video - smoother if number < count - 1 else video
        video = smoother


def _smoothed(video: Tensor, step: int) -> Tensor:
    """Averaged with neighbors `step` pixels away, weights 1/4, 1/2, 1/4 down and across; edges repeat."""
    padded = F.pad(video, [step] * 4, mode="replicate")
    down = 0.5 * padded[:, :, step:-step] + 0.25 * (padded[:, :, : -2 * step] + padded[:, :, 2 * step :])
    return 0.5 * down[..., step:-step] + 0.25 * (down[..., : -2 * step] + down[..., 2 * step :])


def _steps(band: Tensor, unit: int) -> Iterator[tuple[int, Tensor]]:
    """Numbers of columns, and the steps from the first BLOCK frames: lags, then displacements there and back."""
    for column, lag in enumerate(LAGS):
        later = band[:, lag : lag + BLOCK]
        yield column, later - band[:, : later.shape[1]]
    then = band[:, 1 : 1 + BLOCK]
    now = band[:, : then.shape[1]]
    moves = [(y * length, x * length) for length in (unit, 2 * unit) for y, x in _DIRECTIONS]
    for column, (y, x) in enumerate(moves):
        yield len(LAGS) + 2 * column, _shifted(then, y, x) - _shifted(now, -y, -x)
        yield len(LAGS) + 2 * column + 1, _shifted(then, -y, -x) - _shifted(now, y, x)


def _shifted(video: Tensor, y: int, x: int) -> Tensor:
    """What is (y, x) pixels from each pixel of which that and the opposite are inside or at the border."""
    height, width = video.shape[2:]
    return video[:, :, max(y, 0) : height + min(y, 0), max(x, 0) : width + min(x, 0)]
