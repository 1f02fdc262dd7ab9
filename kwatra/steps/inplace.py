"""Windows compared and summed where they lie in their images: the same as elsewhere, without copying any of them out.

For sources on a canvas, plain colors and the CPU: the case in which an optimization spends its time. A comparison ends
as soon as it costs more than the best so far.
"""

from typing import Any, TypeGuard

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base.compiled import Compiled
from kwatra.source import Source, SourceWindows
from kwatra.windows import Layout
from kwatra.windows.flat import folded, row_starts, starts, strides


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


def sums_in_place(layout: Layout, source: SourceWindows, matches: Tensor, weights: Tensor) -> tuple[Tensor, Tensor]:
    """Weighted sums (C, *S) of the matched windows under the falloff, and of their weights (1, *S).

    Weights are summed as one more channel, which is 1 everywhere.
    """
    pixels = F.pad(source.pixels, (0, 1), value=1.0)
    channels, canvas = pixels.shape[-1], tuple(pixels.shape[:-1])
    past = [width - 1 if wraps else 0 for width, wraps in zip(layout.width, layout.wraps, strict=True)]
    shape = tuple(s + p for s, p in zip(layout.shape, past, strict=True))
    total = torch.zeros(*shape, channels, dtype=torch.float32)
    _sums(
        shape[0],
        pixels.view(-1),
        starts(source.corners(matches), canvas, channels),
        row_starts(canvas, layout.width, channels),
        starts(layout.corners, shape, channels),
        row_starts(shape, layout.width, channels),
        source.metric.falloff.expand(*layout.width, channels).flatten(0, -3).flatten(1).contiguous(),
        weights.contiguous(),
        int(strides(shape, channels)[0]),
        total.view(-1),
    )
    sums = folded(total, layout).movedim(-1, 0)
    return sums[:-1], sums[-1:]


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


@Compiled
def _sums(
    canvas: Any, there: Any, canvas_rows: Any, first: Any, rows: Any, falloff: Any, weights: Any, stride: int,
    total: Any, low: int, high: int,
) -> None:  # fmt: skip
    begin, end = low * stride, high * stride
    for window in range(len(first)):
        if first[window] >= end or first[window] + rows[-1] < begin:
            continue
        weight, here, other = weights[window], first[window], there[window]
        for r in range(len(rows)):
            pixel, source = here + rows[r], other + canvas_rows[r]
            if begin <= pixel < end:
                for i in range(falloff.shape[1]):
                    total[np.uint64(pixel + i)] += weight * falloff[r, i] * canvas[np.uint64(source + i)]
