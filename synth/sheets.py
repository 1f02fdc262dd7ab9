"""All frames of a metamorphosis in one picture."""

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
