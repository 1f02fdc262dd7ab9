"""Whether what is seen depends on where it is seen: a scene has its places, a texture is everywhere alike."""

import torch.nn.functional as F
from torch import Tensor

from kwatra.base import mean
from kwatra.elements.correlation import edges, pictures
from kwatra.elements.kept import kept
from kwatra.exemplar import Exemplar

CELLS = 8
"""The frame is seen in so many cells across and down, or in as many as it has pixels."""


@kept
def place_dependence(exemplar: Exemplar) -> float:
    """How much a video's statistics depend on the place in the frame, -1 to 1; 0 for images and videos of one frame.

    The frame's cells have mean colors and mean strengths of edges, over the first half of the video's time and over the
    second. It is the correlation of both: near 0 where what passes here may pass anywhere, near 1 for a flame or a
    fountain. Of clips shorter than the memory of what they show it is near 1 as well: nobody can tell.
    """
    together = first = second = 0.0
    for picture, present in pictures(exemplar):
        if picture.ndim < 4 or picture.shape[1] < 2:
            continue
        half = picture.shape[1] // 2
        for quantity in (*picture, *edges(picture, present)):
            begin, end = (_cells(quantity[part]) for part in (slice(0, half), slice(-half, None)))
            scale = max(float(mean((quantity - mean(quantity)).square())), 1e-12)
            together += float(mean(begin * end)) / scale
            first, second = first + float(mean(begin.square())) / scale, second + float(mean(end.square())) / scale
    return together / max((first * second) ** 0.5, 1e-12)


def _cells(frames: Tensor) -> Tensor:
    """The mean of frames (T, H, W) over time in each cell of the frame, less the mean of all cells."""
    seen = frames.mean(0)
    size = (min(CELLS, seen.shape[0]), min(CELLS, seen.shape[1]))
    cells = F.adaptive_avg_pool2d(seen[None, None], size)[0, 0]
    return cells - mean(cells)
