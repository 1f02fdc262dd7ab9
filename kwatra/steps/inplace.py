"""Windows compared and summed where they lie in their images: the same as elsewhere, without copying any of them out.

For sources on a canvas, plain colors and the CPU: the case in which an optimization spends its time. A comparison ends
as soon as it costs more than the best so far.
"""

from typing import Any, TypeGuard

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base.compiled import Compiled, jitted
from kwatra.source import Source, SourceWindows
from kwatra.windows import Layout
from kwatra.windows.flat import folded, row_starts, starts, strides

TINY = 1e-30
"""What divides instead of 0."""

BAND = 1 << 18
"""About so many values a band of rows has in which windows are summed: they stay in the cache."""


def fits(source: Source) -> TypeGuard[SourceWindows]:
    """Whether windows of this source can be worked on in place."""
    return isinstance(source, SourceWindows) and source.metric.plain and source.pixels.device.type == "cpu"


def nearest_in_place(
    pixels: Tensor,
    corners: Tensor,
    source: SourceWindows,
    candidates: Tensor,
    settled: float = 0.0,
    away: Tensor | None = None,
) -> tuple[Tensor, Tensor]:
    """Of candidates (N, k) the nearest to each window at corners (N, n), the first of equals: numbers (N,).

    pixels: a channels-last image, `continued` where it wraps. Also gives their squared distances (N,). What is no
    further than `settled` is taken without a look at the candidates after it. away (N, k): what each candidate costs
    besides, which is not part of the squared distance.
    """
    channels, shape = pixels.shape[-1], tuple(pixels.shape[:-1])
    canvas = tuple(source.pixels.shape[:-1])
    rows, canvas_rows = (row_starts(sides, source.width, channels) for sides in (shape, canvas))
    choice = torch.empty(len(candidates), dtype=torch.long)
    squared = torch.empty(len(candidates), dtype=torch.float32)
    _nearest(
        len(candidates),
        pixels.view(-1),
        starts(corners, shape, channels),
        rows,
        source.pixels.view(-1),
        starts(source.corners(candidates), canvas, channels),
        canvas_rows,
        source.metric.weight.flatten(0, -3).flatten(1).contiguous(),
        torch.zeros(candidates.shape, dtype=torch.float32) if away is None else away.contiguous(),
        settled,
        choice,
        squared,
    )
    if away is not None:
        squared = (squared - away.gather(1, choice[:, None])[:, 0]).clamp(min=0)
    return candidates.gather(1, choice[:, None])[:, 0], squared


def means_in_place(layout: Layout, source: SourceWindows, matches: Tensor, weights: Tensor) -> tuple[Tensor, Tensor]:
    """Weighted means (C, *S) of the matched windows under the falloff, 0 where there are none, and masses (1, *S).

    Weights are summed as one more channel, which is 1 everywhere. Memory beside the result: a band of rows a thread.
    """
    pixels = F.pad(source.pixels, (0, 1), value=1.0)
    channels, canvas = pixels.shape[-1], tuple(pixels.shape[:-1])
    past = [width - 1 if wraps else 0 for width, wraps in zip(layout.width, layout.wraps, strict=True)]
    shape = tuple(s + p for s, p in zip(layout.shape, past, strict=True))
    line = int(strides(shape, channels)[0])
    height = max(BAND // line, 1)
    reach = np.full((2, -(-shape[0] // height)), len(layout)) * [[1], [0]]
    _reach(layout.corners[:, 0].contiguous().numpy(), layout.width[0], height, *reach)
    value, mass = torch.empty(*shape, channels - 1, dtype=torch.float32), torch.empty(*shape, 1, dtype=torch.float32)
    _means(
        shape[0],
        pixels.view(-1),
        starts(source.corners(matches), canvas, channels),
        row_starts(canvas, layout.width, channels),
        starts(layout.corners, shape, channels),
        row_starts(shape, layout.width, channels),
        source.metric.falloff.expand(*layout.width, channels).flatten(0, -3).flatten(1).contiguous(),
        weights.contiguous(),
        *reach,
        height,
        line,
        value.view(-1, channels - 1),
        mass.view(-1),
    )
    if any(layout.wraps):
        total, mass = folded(value * mass, layout), folded(mass, layout)
        value = total / mass.clamp(min=TINY)
    return value.movedim(-1, 0), mass.movedim(-1, 0)


@Compiled
def _nearest(
    image: Any, first: Any, rows: Any, canvas: Any, there: Any, canvas_rows: Any, weight: Any, away: Any,
    settled: float, choice: Any, squared: Any, low: int, high: int,
) -> None:  # fmt: skip
    for window in range(low, high):
        least, best = weight[0, 0] * 0 + 3e38, 0
        for k in range(there.shape[1]):
            if k > 0 and (least <= settled or there[window, k] == there[window, best]):
                continue
            distance = away[window, k]
            for r in range(len(rows)):
                a, b = first[window] + rows[r], there[window, k] + canvas_rows[r]
                for i in range(weight.shape[1]):  # unsigned: else each is asked whether it counts from the end
                    apart = image[np.uint64(a + i)] - canvas[np.uint64(b + i)]
                    distance += weight[r, i] * apart * apart
                if distance >= least:
                    break
            if distance < least:
                least, best = distance, k
        choice[window], squared[window] = best, least


@jitted
def _reach(top: Any, height: int, band: int, first: Any, past: Any) -> None:
    """Of the windows `height` rows high whose tops are given, the first and the one past the last in each band."""
    for window in range(len(top)):
        for b in range(top[window] // band, (top[window] + height - 1) // band + 1):
            first[b], past[b] = min(first[b], window), window + 1


@Compiled
def _means(
    canvas: Any, there: Any, canvas_rows: Any, here: Any, rows: Any, falloff: Any, weights: Any, first: Any, past: Any,
    height: int, line: int, value: Any, mass: Any, low: int, high: int,
) -> None:  # fmt: skip
    """Rows low to high, a band at a time; all positions are numbers of values in images with one more channel."""
    channels = value.shape[1] + 1
    band = np.empty(height * line, np.float32)
    for number in range(low // height, (high - 1) // height + 1):
        begin, end = max(low, number * height) * line, min(high, (number + 1) * height) * line
        band[: end - begin] = 0
        for window in range(first[number], past[number]):
            weight, pixel, source = weights[window], here[window] - begin, there[window]
            if pixel >= end - begin or pixel + rows[-1] < 0:
                continue
            for r in range(len(rows)):
                into, out = pixel + rows[r], source + canvas_rows[r]
                if 0 <= into < end - begin:
                    for i in range(falloff.shape[1]):
                        band[np.uint64(into + i)] += weight * falloff[r, i] * canvas[np.uint64(out + i)]
        for at in range((end - begin) // channels):
            pixel = begin // channels + at
            sum_ = band[np.uint64((at + 1) * channels - 1)]
            mass[pixel] = sum_
            for channel in range(channels - 1):
                value[pixel, channel] = band[np.uint64(at * channels + channel)] / max(sum_, TINY)
