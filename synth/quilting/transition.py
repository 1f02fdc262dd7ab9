"""A transition in a clip: the best pair of similar frames, and the best seam surface around them (thesis 3.5 A).

Frame i + t follows frame j + t smoothly where the two are alike for all t of a window, so the pairs are ranked by the
squared difference averaged over the window, which also asks their motions to agree. For the few best pairs the seam
is cut: in the window each pixel passes from the clip at j + t to the clip at i + t at a time of its own. The cheapest
wins. The loop is the frames from i to j with the window at its end; its length is j - i.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from kwatra.errors import InputError
from synth.quilting.boxes import Box
from synth.quilting.canvas import Canvas, Patch
from synth.quilting.costs import SeamCost
from synth.quilting.growth import Report
from synth.quilting.sources import Sources
from synth.quilting.synthesis import Quilt, QuiltSettings, result_of

LONGEST_WINDOW = 60
MOST_PIXELS = 6_000_000
"""The most pixels in a window: what bounds the memory of a transition."""
CANDIDATES = 5


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
    sources = Sources([clip.numpy()])
    cost = SeamCost(sources, settings.normalized)
    choices = find_loops(clip, frames if loop else None)
    best = None
    for number, choice in enumerate(choices):
        report("cutting transitions", number / len(choices))
        window = _cut_window(sources, cost, choice)
        if best is None or window.total < best[1].total:
            best = choice, window
    assert best is not None
    choice, window = best
    half = choice.window // 2
    canvas = Canvas(sources, (choice.length, *clip.shape[-2:]), (False,) * 3, cost)
    canvas.lay(Patch(0, (-(choice.first + half), 0, 0), Box((0, 0, 0), canvas.shape)))
    canvas.adopt(window, choice.length - choice.window)
    stopped = (
        f"frames {choice.first} to {choice.last} of the clip repeat, joined within a window of {choice.window} frames"
    )
    quilt = result_of(canvas, settings, [canvas.total], stopped)
    return quilt if frames is None else repeated(quilt, frames)


def find_loops(clip: Tensor, multiple: int | None = None) -> list[Loop]:
    """The few best loops of a clip (C, T, H, W), best first; only lengths that divide `multiple`, if given.

    Raises InputError if the clip is shorter than four frames or has no loop of such a length.
    """
    count = clip.shape[1]
    if count < 4:
        raise InputError(f"the clip has {count} frames but a transition needs at least 4; give a longer clip")
    room = MOST_PIXELS // (clip.shape[2] * clip.shape[3])
    half = max(min(LONGEST_WINDOW, count // 3, room) // 2, 1)
    score = _join_scores(clip, half)
    first, last = torch.meshgrid(torch.arange(count), torch.arange(count), indexing="ij")
    length = last - first
    allowed = (first >= half) & (last <= count - half) & (length >= max(2 * half, count // 2))
    if multiple is not None:
        allowed &= (multiple % length.clamp(min=1)) == 0
        if not bool(allowed.any()):
            raise InputError(
                f"frames is {multiple} but no loop of this clip of {count} frames repeats to exactly that; "
                f"leave frames out, or ask for {count // 2} to {count - 2 * half}"
            )
    score[~allowed] = torch.inf
    return [Loop(i, j, 2 * half) for i, j in _lowest(score, half)]


def _join_scores(clip: Tensor, half: int) -> Tensor:
    """(T, T): how unlike the frames around j are those around i, averaged over a window of 2 half frames."""
    count = clip.shape[1]
    small = (
        F.adaptive_avg_pool2d(clip.transpose(0, 1), (min(clip.shape[2], 48), min(clip.shape[3], 48)))
        .flatten(1)
        .double()
    )
    distance = torch.cdist(small, small, compute_mode="donot_use_mm_for_euclid_dist").square()
    score = torch.full((count, count), torch.inf, dtype=torch.float64)
    inner = slice(half, count - half + 1)
    steps = [distance[t : t + count - 2 * half + 1, t : t + count - 2 * half + 1] for t in range(2 * half)]
    score[inner, inner] = torch.stack(steps).mean(0)
    return score


def _lowest(score: Tensor, apart: int) -> list[tuple[int, int]]:
    """The places of the lowest scores, no two within `apart` of each other."""
    score = score.clone()
    found: list[tuple[int, int]] = []
    while len(found) < CANDIDATES and bool(torch.isfinite(score).any()):
        i, j = divmod(int(score.argmin()), score.shape[1])
        found.append((i, j))
        score[max(i - apart, 0) : i + apart + 1, max(j - apart, 0) : j + apart + 1] = torch.inf
    return found


def _cut_window(sources: Sources, cost: SeamCost, loop: Loop) -> Canvas:
    """The frames around the join: they begin as the clip around `last` and end as the clip around `first`."""
    half = loop.window // 2
    canvas = Canvas(sources, (loop.window, *sources.shapes[0][1:]), (False,) * 3, cost)
    whole = Box((0, 0, 0), canvas.shape)
    canvas.lay(Patch(0, (half - loop.last, 0, 0), whole))
    begin, end = np.zeros(canvas.shape, bool), np.zeros(canvas.shape, bool)
    begin[0], end[-1] = True, True
    canvas.lay(Patch(0, (half - loop.first, 0, 0), whole), must=end, must_not=begin)
    return canvas


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
