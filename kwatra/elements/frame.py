"""How the frame of a scene grows: what is alike is stretched, and what changes from place to place keeps its size.

The edge that a waterfall goes over takes a few rows. Were all rows of a frame twice as high stretched alike, the edge
would belong into twice as many; copies, which are no larger than in the clip, show it twice then.
"""

import numpy as np
from torch import Tensor

from kwatra.base.tensors import tensor_of

LINES = 32
"""A frame is seen in so many lines across an axis, or in as many as it has pixels. Not tuned."""

CALM = 0.1
"""Where the means of lines change by so much from one to the next, in deviations of the colors, a frame is stretched by
half of what it would be where nothing changes. At twice its size a waterfall goes over one edge with it, for all of the
width; with .3 there is the end of a second, and two where all is stretched alike. Five clips of that size, judged as
compressed films, score .107 stretched alike and .108 with it: smoke gains .006 and the waterfall, of which less is edge
than in its clip, loses .008."""

LITTLE = 1.5
"""What is made so many times longer, or less, is stretched alike: nothing is seen twice then. Five clips, judged as
compressed films, score .094 so, and .097 with lines stretched by what changes."""


def grown(share: Tensor, colors: Tensor, late: Tensor | None, larger: float) -> Tensor:
    """Where along an axis of a frame that is made so many times larger pixels belong (N,), 0 to 1.

    share (N,): where along that axis of their own frame they lie, 0 to 1; colors (C, N). late (N,): which of them are
    of the second half of a video's time: what changes from line to line in both halves is no chance; None for stills.
    The order of lines stays, and the first and last stay at the ends.
    """
    if larger <= LITTLE:
        return share
    at = share.double().cpu().numpy()
    lines = min(LINES, len(np.unique(at)))
    number = np.minimum((at * lines).astype(np.int64), lines - 1)
    first, second = np.diff(_means(colors, number, lines, late))
    step = np.sqrt(np.maximum((first * second).sum(0), 0))
    change = np.maximum(np.append(step, 0), np.insert(step, 0, 0))
    more = 1 / (change + CALM)
    ends = np.insert(np.cumsum(1 + (larger - 1) * more / more.mean()), 0, 0)
    there = np.interp(at * lines, np.arange(lines + 1), ends / ends[-1])
    return tensor_of(there).to(share)


def _means(colors: Tensor, number: np.ndarray, lines: int, late: Tensor | None) -> np.ndarray:
    """Of either half of the time the means over lines (2, 2 C, lines) of colors (C, N), and of how far they are off.

    In deviations of the colors. number (N,): the line of each pixel; late: as in `grown`.
    """
    of_part = number if late is None else number + lines * late.cpu().numpy()
    parts = lines if late is None else 2 * lines
    count, means, variance = np.maximum(np.bincount(of_part, minlength=parts), 1), [], 0.0
    for channel in colors.cpu().numpy():
        apart = channel - channel.mean(dtype=float)
        means += [np.bincount(of_part, power, parts) / count for power in (apart, np.abs(apart))]
        variance += float(np.square(apart).mean())
    halves = np.stack(means).reshape(len(means), -1, lines).swapaxes(0, 1) / max(variance**0.5, 1e-12)
    return np.broadcast_to(halves, (2, len(means), lines))
