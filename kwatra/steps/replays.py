"""What a video's search charges for windows that would make one copy run on in time: a clip played again.

Blocks are laid so that none goes on where the one before ends, but the search joins them. Of three that follow each
other in time the middle one is left few windows that lie within it: where the first or the last fits as well they are
matched with what comes there of that one, and it runs on through all three.
"""

import math

import torch
from torch import Tensor

from kwatra.source import Placed
from kwatra.windows import Layout
from kwatra.windows.flat import starts

LONGEST = 8
"""So many frames of one copy are free. Longer ones are seen to be the clip again (`kwatra.scoring.replay`)."""

PRICE = 0.05
"""What a window of a longer one costs, in variances of the exemplar. Of smoke half as large again .159 is replayed
where it is 0, .157 with .002, .148 with .01 and .119 with .05 (three seeds)."""


class Replays:
    """A charge for where windows come from (`PlaceCharge`), given the matches (N,) that all windows of a layout have.

    A window is charged `price`, as squared colors, if, matched with what comes from a place, it and those before and
    after it in time would be one copy of more than LONGEST frames.
    """

    def __init__(self, layout: Layout, source: Placed, matches: Tensor) -> None:
        exemplar, corners = source.exemplar, layout.corners
        self.price = PRICE * exemplar.variance
        times = torch.bincount(corners[:, 0]).nonzero()[:, 0]
        step = int(times.diff().median()) if len(times) > 1 else 1  # the last may be less
        self.free = max((LONGEST - layout.width[0]) // step + 1, 1)  # so many windows hold LONGEST frames
        self._extent = exemplar.shape
        self._number = torch.full(layout.shape, -1, device=corners.device)
        self._number[tuple(corners.T)] = torch.arange(len(corners), device=corners.device)
        there, onward = starts(source.corners(matches), exemplar.shape, 1), step * math.prod(self._extent[1:])
        self._joined = [self._beside(corners, sign * step, layout.wraps[0], there, sign * onward) for sign in (-1, 1)]

    def __call__(self, corners: Tensor, there: Tensor) -> Tensor:
        """What windows at corners (N, n) cost that come from corners (N, k, n) of the canvas, (N, k)."""
        window, place = self._number[tuple(corners.T)], starts(there, self._extent, 1)
        windows = torch.ones(place.shape, dtype=torch.float32, device=place.device)
        for wanted, lengths in self._joined:
            windows += lengths[window, None] * (place == wanted[window, None])
        return self.price * (windows > self.free).float()

    def _beside(self, corners: Tensor, step: int, around: bool, there: Tensor, onward: int) -> tuple[Tensor, Tensor]:
        """Where windows (N,) have to come from to go on with the one a step before or after, and how many it goes on.

        Counted are as many windows, from that one on, as are free; none where there is no window. there (N,): where
        windows come from, as numbers that grow by `onward` with each step in one copy.
        """
        time, frames = corners[:, 0] + step, len(self._number)
        beside = self._number[(time % frames, *corners[:, 1:].T)]
        exists = beside >= 0 if around else (beside >= 0) & (time >= 0) & (time < frames)
        wanted = there[beside] - onward
        on, lengths = exists & (there == wanted), torch.ones_like(beside)
        for _ in range(self.free - 1):
            lengths = torch.where(on, lengths[beside] + 1, 1)
        return wanted, (lengths[beside] * exists).float()
