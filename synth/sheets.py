"""Frames in one picture: side by side, and as slices through time, where motion is seen for what it is.

In a slice a line of pixels is shown as it changes over time. What stands still draws straight stripes along time, what
moves slanted ones; a cut in time is a straight edge, flicker is noise, what is played again repeats.
"""

from collections.abc import Sequence

import torch
import torch.nn.functional as F
from torch import Tensor

COLUMNS, GAP = 6, 4


def contact_sheet(frames: Sequence[Tensor], columns: int = COLUMNS) -> Tensor:
    """Frames (C, H, W) of one size in rows, from left to right, with white gaps: (C, H', W'), white is 1."""
    columns = min(columns, len(frames))
    cells = [F.pad(frame, (0, GAP, 0, GAP), value=1.0) for frame in frames]
    cells += [torch.ones_like(cells[0])] * (-len(cells) % columns)
    rows = [torch.cat(cells[begin : begin + columns], 2) for begin in range(0, len(cells), columns)]
    return torch.cat(rows, 1)[:, :-GAP, :-GAP]


def row_in_time(video: Tensor) -> Tensor:
    """The middle row of pixels of a video (C, T, H, W) over time, which runs down: (C, T, W)."""
    return video[:, :, video.shape[2] // 2]


def column_in_time(video: Tensor) -> Tensor:
    """The middle column of pixels of a video (C, T, H, W) over time, which runs to the right: (C, H, T)."""
    return video[..., video.shape[3] // 2].transpose(1, 2)


def video_sheet(video: Tensor, count: int = COLUMNS) -> Tensor:
    """A video (C, T, H, W) in one picture (C, H', W'), to be looked at: white gaps are 1.

    Above, up to `count` frames spread evenly over time, the first and the last among them; below, the middle row in
    time, then the middle column in time. A frame is as many pixels long in the slices as makes them about as long as a
    frame is wide.
    """
    length, height, width = video.shape[1:]
    shown = torch.linspace(0, length - 1, min(count, length), dtype=torch.float32).round().long()
    row = row_in_time(video).repeat_interleave(max(1, round(height / length)), 1)
    column = column_in_time(video).repeat_interleave(max(1, round(width / length)), 2)
    return stacked([contact_sheet(video[:, shown].unbind(1), count), _beside(row, column)])


def stacked(pictures: Sequence[Tensor]) -> Tensor:
    """Pictures (C, H, W) of any size under each other, with white gaps."""
    widest = max(picture.shape[2] for picture in pictures)
    padded = [F.pad(picture, (0, widest - picture.shape[2], 0, GAP), value=1.0) for picture in pictures]
    return torch.cat(padded, 1)[:, :-GAP]


def _beside(*pictures: Tensor) -> Tensor:
    """Pictures (C, H, W) of any size in a row, with white gaps."""
    return stacked([picture.transpose(1, 2) for picture in pictures]).transpose(1, 2)
