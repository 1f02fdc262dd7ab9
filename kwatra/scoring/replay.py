"""How much of a video is a clip played again.

A place of the output is replayed when the frames about it follow, for RUN frames or more, those of the exemplar at one
offset in space and time. Frames follow when they differ, over a window's pixels, by less than a part of what the
exemplar's next frame differs by there: what is copied one frame late is not copied. Places that stand still are left
out, since they look the same at any time.
"""

import torch
from torch import Tensor

from kwatra.scoring.nearest import Windows

RUN = 8
"""Frames in a row that make a replay."""

LATE = 0.25
"""Part of a frame's change that a copy may be off: seams' feathering and rounding, but no other moment."""

MOVING = 0.5
"""Part of the exemplar's rms change per frame from which a place moves."""


def replay(ours: Windows, numbers: Tensor, theirs: Windows, found: Tensor) -> float:
    """The part, 0..1, of the moving windows `numbers` (n,) of one video that is replayed; `found`: the nearest (n,).

    Both sets of windows are of scale 1. Where videos are shorter than RUN frames, so are the runs.
    """
    run = min(RUN, ours.videos[0].shape[1], max(video.shape[1] for video in theirs.videos))
    frames = torch.arange(ours.depth - run, run)
    here, there = ours.places(numbers), theirs.places(found)
    made, is_made = _tubes(ours, here, frames)
    given, is_given = _tubes(theirs, there, frames)
    steps = (video.diff(dim=1).square().mean((0, 2, 3)) for video in theirs.videos)
    moving = _change(made, is_made) > MOVING * float(torch.cat(list(steps)).mean().sqrt())
    if run < 2 or not moving.any():
        return 0.0
    off = (made - given).square().mean((2, 3, 4)).sqrt()
    follows = is_made & is_given & (off < LATE * _change(given, is_given)[:, None])
    runs = follows.unfold(1, run, 1).all(2).any(1)
    return float(runs[moving].float().mean())


def _tubes(windows: Windows, places: Tensor, frames: Tensor) -> tuple[Tensor, Tensor]:
    """Pixels (n, frames, C, size, size) of frames counted from each place (4, n), and which (n, frames) exist."""
    video_of, first, top, left = places
    when = first[:, None] + frames
    channels, size = windows.videos[0].shape[0], windows.size
    tubes, exist = (
        torch.empty(*when.shape, channels, size, size, dtype=torch.float32),
        torch.empty(when.shape, dtype=torch.bool),
    )
    for number, video in enumerate(windows.videos):
        mine, count = video_of == number, video.shape[1]
        view = video.unfold(2, size, 1).unfold(3, size, 1).permute(1, 2, 3, 0, 4, 5)
        tubes[mine] = view[when[mine].clamp(0, count - 1), top[mine, None], left[mine, None]]
        exist[mine] = (when[mine] >= 0) & (when[mine] < count)
    return tubes, exist


def _change(tubes: Tensor, exist: Tensor) -> Tensor:
    """Rms change per frame (n,) of tubes, over the pairs of frames that exist."""
    pairs = exist[:, 1:] & exist[:, :-1]
    squares = tubes.diff(dim=1).square().mean((2, 3, 4))
    return ((squares * pairs).sum(1) / pairs.sum(1).clamp(min=1)).sqrt()
