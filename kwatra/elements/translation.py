"""Whether all that a clip shows is one picture that moves: then it can be continued exactly."""

import torch
from torch import Tensor

from kwatra.elements.kept import kept
from kwatra.exemplar import Exemplar


@kept
def translation(exemplar: Exemplar) -> tuple[int, int] | None:
    """The whole pixels (down, right) by which every frame of a single clip is the one before it, moved, to the bit.

    None where there is no such motion, where it is 0, or where it leaves less than half of the frame to be seen.
    """
    from skimage.registration import phase_cross_correlation  # stills need none of it

    canvas = exemplar.canvas
    if canvas.shape[1] < 2 or not bool((exemplar.owner == 0).all()):
        return None
    first, second = (canvas[:, number].mean(0).numpy() for number in (0, 1))
    if first.min() == first.max() or second.min() == second.max():
        return None
    shift = phase_cross_correlation(first - first.mean(), second - second.mean())[0]
    down, right = (-round(float(by)) for by in shift)
    height, width = canvas.shape[2:]
    if (down, right) == (0, 0) or abs(down) > height // 2 or abs(right) > width // 2:
        return None
    before, after = _overlap(canvas[:, :-1], down, right), _overlap(canvas[:, 1:], -down, -right)
    return (down, right) if torch.equal(before, after) else None


def _overlap(frames: Tensor, down: int, right: int) -> Tensor:
    """What of frames (..., H, W) is still seen when they have moved."""
    height, width = frames.shape[-2:]
    rows = slice(max(-down, 0), height - max(down, 0))
    return frames[..., rows, max(-right, 0) : width - max(right, 0)]
