"""A transition in a clip: the best pair of similar frames, and the best seam surface around them (thesis 3.5 A).

Frame i + t follows frame j + t smoothly where the two are alike for all t of a window, so the pairs are ranked by the
squared difference averaged over the window, which also asks their motions to agree. For the best pairs the seam is cut
on small frames, and for the one where it is cheapest again at full size: in the window each pixel passes from the clip
at j + t to the clip at i + t at a time of its own. The loop is the frames from i to j with the window at its end; its
length is j - i, and the window may be as long.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.base import InputError
from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import Mosaic, SeamCost
from kwatra.pieces.sheet import Patch, Sheet
from synth.quilting.growth import Report
from synth.quilting.synthesis import Quilt, QuiltSettings, result_of

LONGEST_WINDOW = 60
"""The most frames in a window, if they are small: a bound on time."""
MOST_PIXELS = 6_000_000
"""The most pixels in a window: what bounds the memory of a transition."""
CANDIDATES = 8
"""Of so many transitions that look best on small frames the seams are compared: time grows with it."""
SMALL = 48
"""Side, in pixels, of the frames on which transitions are compared."""


@dataclass(frozen=True)
class Loop:
    """Frames `first` to `last` - 1 repeat, the `window` frames around the join being cut."""

    first: int
    last: int
    window: int

    @property
    def length(self) -> int:
        """Frames in one period."""
        return self.last - self.first


def seam_transition(clip: Tensor, frames: int | None, loop: bool, settings: QuiltSettings, report: Report) -> Quilt:
    """The clip's best loop, repeated to `frames` frames (once by default); with `loop`, whole periods only."""
    report("comparing frames", 0.0)
    choices = find_loops(clip, frames if loop else None)
    small = Mosaic([shrunk(clip, SMALL).numpy()])
    cost = settings.cost_of(small)
    totals = []
    for number, choice in enumerate(choices):
        report("comparing transitions", number / len(choices))
        totals.append(_joined(small, cost, choice).total)
    best = choices[int(np.argmin(totals))]
    report("cutting the transition", 0.0)
    sources = Mosaic([clip.numpy()])
    sheet = _joined(sources, settings.cost_of(sources), best)
    stopped = f"frames {best.first} to {best.last} of the clip repeat, joined within a window of {best.window} frames"
    quilt = result_of(sheet, settings, [sheet.total], stopped, first=1)
    return quilt if frames is None else repeated(quilt, frames)


def shrunk(clip: Tensor, side: int) -> Tensor:
    """The clip (C, T, H, W) with each frame averaged down to at most `side` pixels in height and in width."""
    size = min(clip.shape[2], side), min(clip.shape[3], side)
    return F.adaptive_avg_pool2d(clip.transpose(0, 1), size).transpose(0, 1)


def find_loops(clip: Tensor, multiple: int | None = None) -> list[Loop]:
    """Good loops of a clip (C, T, H, W), with short windows and with long; only lengths that divide `multiple`.

    Raises InputError if the clip is shorter than four frames or has no loop of such a length.
    """
    count = clip.shape[1]
    if count < 4:
        raise InputError(f"the clip has too few frames ({count}): a transition needs at least 4; give a longer clip")
    most = min(LONGEST_WINDOW, MOST_PIXELS // (clip.shape[2] * clip.shape[3]))
    first, last = torch.meshgrid(torch.arange(count), torch.arange(count), indexing="ij")
    length = last - first
    found = []
    # A short window leaves more pairs to choose from, a long one more times for each pixel to pass.
    for half in sorted({max(min(most, count // part) // 2, 1) for part in (2, 3)}):
        allowed = (first >= half) & (last <= count - half) & (length >= max(2 * half, count // 2))
        if multiple is not None:
            allowed &= (multiple % length.clamp(min=1)) == 0
        score = torch.where(allowed, _join_scores(clip, half), torch.inf)
        found += [Loop(i, j, 2 * half) for i, j in _lowest(score, half)]
    if not found:
        raise InputError(
            f"frames is {multiple} but no loop of this clip of {count} frames repeats to exactly that; "
            f"leave frames out, or ask for {count // 2} to {count - 2 * max(count // 6, 1)}"
        )
    return found


def _join_scores(clip: Tensor, half: int) -> Tensor:
    """(T, T): how unlike the frames around j are those around i, averaged over a window of 2 half frames."""
    count = clip.shape[1]
    small = shrunk(clip, SMALL).transpose(0, 1).flatten(1).double()
    distance = torch.cdist(small, small, compute_mode="donot_use_mm_for_euclid_dist").square()
    score = torch.full((count, count), torch.inf, dtype=torch.float64)
    inner = slice(half, count - half + 1)
    steps = [distance[t : t + count - 2 * half + 1, t : t + count - 2 * half + 1] for t in range(2 * half)]
    score[inner, inner] = torch.stack(steps).mean(0)
    return score


def _lowest(score: Tensor, apart: int) -> list[tuple[int, int]]:
    """The places of the lowest scores, no two within half of `apart` of each other."""
    score, apart = score.clone(), apart // 2
    found: list[tuple[int, int]] = []
    while len(found) < CANDIDATES and bool(torch.isfinite(score).any()):
        i, j = divmod(int(score.argmin()), score.shape[1])
        found.append((i, j))
        score[max(i - apart, 0) : i + apart + 1, max(j - apart, 0) : j + apart + 1] = torch.inf
    return found


def _joined(sources: Mosaic, cost: SeamCost, loop: Loop) -> Sheet[Mosaic]:
    """The loop, before it the frame that is also its last; its window begins as the clip around `last`."""
    half = loop.window // 2
    sheet = Sheet(sources, (loop.length + 1, *sources.shapes[0][1:]), (False,) * 3, cost)
    late = 1 - loop.first - half
    sheet.lay(Patch(0, (late, 0, 0), Box((0, 0, 0), sheet.shape)))
    window = Box((loop.length + 1 - loop.window, 0, 0), (loop.window, *sheet.shape[1:]))
    end = np.zeros(window.extent, bool)
    end[-1] = True
    sheet.lay(Patch(0, (late + loop.length, 0, 0), window), must=end)
    return sheet


def repeated(quilt: Quilt, frames: int) -> Quilt:
    """A loop's Quilt played on to `frames` frames."""
    period = quilt.image.shape[1]
    at = torch.arange(frames) % period
    offset = quilt.offset[:, at].clone()
    offset[0] -= (torch.arange(frames) - at).to(torch.int32)[:, None, None]
    seams = quilt.seams[:, at].clone()
    return dataclasses.replace(
        quilt,
        image=quilt.image[:, at],
        source=quilt.source[at],
        offset=offset,
        patch=quilt.patch[at],
        seams=seams,
        cost=float(seams.sum(dtype=torch.float64)),
    )
