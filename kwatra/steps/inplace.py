"""Windows compared and summed where they lie in their images: the same as elsewhere, without copying any of them out.

For sources on a canvas, plain colors and the CPU: the case in which an optimization spends its time. A comparison ends
as soon as it costs more than the best so far.
"""

from typing import Any, NamedTuple, TypeGuard

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base.compiled import Compiled, inlined, jitted
from kwatra.source import Source, SourceWindows
from kwatra.windows import Layout
from kwatra.windows.flat import folded, row_starts, strides

TINY = 1e-30
"""What divides instead of 0."""

FARTHEST = np.float32(3e38)
"""What no squared distance comes to."""

BAND = 1 << 18
"""About so many values a band of rows has in which windows are summed: they stay in the cache."""


def fits(source: Source) -> TypeGuard[SourceWindows]:
    """Whether windows of this source can be worked on in place."""
    return isinstance(source, SourceWindows) and source.metric.plain and source.pixels.device.type == "cpu"


class Lines(NamedTuple):
    """A channels-last image as loops see windows of it.

    values (N,): one after the other. rows (r,): where each row of a window begins, from its first value; steps (axes,):
    how many values further the next pixel along each axis is.
    """

    values: Any
    rows: Any
    steps: Any

    @classmethod
    def of(cls, pixels: Tensor, width: tuple[int, ...]) -> "Lines":
        """Those of windows of a width in a contiguous image (*S, C)."""
        *shape, channels = pixels.shape
        steps = strides(tuple(shape), channels)
        return cls(pixels.view(-1).numpy(), row_starts(tuple(shape), width, channels).numpy(), steps.numpy())


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
    choice = torch.empty(len(candidates), dtype=torch.long)
    squared = torch.empty(len(candidates), dtype=torch.float32)
    _nearest(
        len(candidates),
        corners.contiguous(),
        Lines.of(pixels, source.width),
        Lines.of(source.pixels, source.width),
        room_of(source),
        candidates.contiguous(),
        by_rows(source.metric.weight),
        torch.zeros(candidates.shape, dtype=torch.float32) if away is None else away.contiguous(),
        settled,
        choice,
        squared,
    )
    if away is not None:
        squared = (squared - away.gather(1, choice[:, None])[:, 0]).clamp(min=0)
    return candidates.gather(1, choice[:, None])[:, 0], squared


def room_of(source: SourceWindows) -> Any:
    """In how many places along each axis (axes,) a source's windows are, which are numbered row by row."""
    return np.array(source.positions)


def by_rows(weight: Tensor) -> Tensor:
    """What values of a window (*width, C) count, row by row: (r, values)."""
    return weight.flatten(0, -3).flatten(1).contiguous()


def means_in_place(layout: Layout, source: SourceWindows, matches: Tensor, weights: Tensor) -> tuple[Tensor, Tensor]:
    """Weighted means (C, *S) of the matched windows under the falloff, 0 where there are none, and masses (1, *S).

    Weights are summed as one more channel, which is 1 everywhere. Memory beside the result: a band of rows a thread.
    """
    pixels = F.pad(source.pixels, (0, 1), value=1.0)
    past = [width - 1 if wraps else 0 for width, wraps in zip(layout.width, layout.wraps, strict=True)]
    shape, channels = tuple(s + p for s, p in zip(layout.shape, past, strict=True)), pixels.shape[-1]
    line = int(strides(shape, channels)[0])
    height = max(BAND // line, 1)
    reach = np.full((2, -(-shape[0] // height)), len(layout)) * [[1], [0]]
    _reach(layout.corners[:, 0].contiguous().numpy(), layout.width[0], height, *reach)
    value, mass = torch.empty(*shape, channels - 1, dtype=torch.float32), torch.empty(*shape, 1, dtype=torch.float32)
    _means(
        shape[0],
        Lines.of(pixels, layout.width),
        room_of(source),
        matches.contiguous(),
        layout.corners.contiguous(),
        row_starts(shape, layout.width, channels),
        strides(shape, channels),
        by_rows(source.metric.falloff.expand(*layout.width, channels)),
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


@inlined
def start_of(number: int, room: Any, steps: Any) -> Any:
    """The first value of the window with a number, where windows are in so much `room` (axes,), row by row."""
    start = np.int64(0)
    for axis in range(len(room) - 1, 0, -1):
        start += number % room[axis] * steps[axis]
        number //= room[axis]
    return start + number * steps[0]


@inlined
def difference(
    ours: Any, at: int, rows: Any, theirs: Any, start: int, their_rows: Any, weight: Any, least: Any, besides: Any
) -> Any:
    """The squared difference of windows that begin at two values of `Lines`, and what is added; or at least the least.

    It is not summed up further once it comes to as much.
    """
    distance = besides
    for r in range(len(rows)):
        a, b = at + rows[r], start + their_rows[r]
        for i in range(weight.shape[1]):  # unsigned: else each is asked whether it counts from the end
            apart = ours[np.uint64(a + i)] - theirs[np.uint64(b + i)]
            distance += weight[r, i] * apart * apart
        if distance >= least:
            break
    return distance


@inlined
def first_of(corners: Any, window: int, steps: Any) -> Any:
    """The first value of a window, given the corners (N, axes) of all."""
    start = np.int64(0)
    for axis in range(len(steps)):
        start += corners[window, axis] * steps[axis]
    return start


@Compiled
def _nearest(
    corners: Any, here: Any, there: Any, room: Any, candidates: Any, weight: Any, away: Any, settled: float,
    choice: Any, squared: Any, low: int, high: int,
) -> None:  # fmt: skip
    (ours, rows, steps), (theirs, their_rows, their_steps) = here, there
    for window in range(low, high):
        at, least, best = first_of(corners, window, steps), FARTHEST, 0
        for k in range(candidates.shape[1]):
            number = candidates[window, k]
            if k > 0 and (least <= settled or number == candidates[window, best]):
                continue
            start, besides = start_of(number, room, their_steps), away[window, k]
            distance = difference(ours, at, rows, theirs, start, their_rows, weight, least, besides)
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
    canvas: Any, room: Any, matches: Any, corners: Any, rows: Any, steps: Any, falloff: Any, weights: Any, first: Any,
    past: Any, height: int, line: int, value: Any, mass: Any, low: int, high: int,
) -> None:  # fmt: skip
    """Rows low to high, a band at a time; all positions are numbers of values in images with one more channel."""
    pixels, canvas_rows, canvas_steps = canvas
    channels = value.shape[1] + 1
    band = np.empty(height * line, np.float32)
    for number in range(low // height, (high - 1) // height + 1):
        begin, end = max(low, number * height) * line, min(high, (number + 1) * height) * line
        band[: end - begin] = 0
        for window in range(first[number], past[number]):
            weight, pixel = weights[window], first_of(corners, window, steps) - begin
            if pixel >= end - begin or pixel + rows[-1] < 0:
                continue
            source = start_of(matches[window], room, canvas_steps)
            for r in range(len(rows)):
                into, out = pixel + rows[r], source + canvas_rows[r]
                if 0 <= into < end - begin:
                    for i in range(falloff.shape[1]):
                        band[np.uint64(into + i)] += weight * falloff[r, i] * pixels[np.uint64(out + i)]
        for at in range((end - begin) // channels):
            pixel = begin // channels + at
            sum_ = band[np.uint64((at + 1) * channels - 1)]
            mass[pixel] = sum_
            for channel in range(channels - 1):
                value[pixel, channel] = band[np.uint64(at * channels + channel)] / max(sum_, TINY)
