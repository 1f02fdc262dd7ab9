"""How good a metamorphosis is, in figures, from its frames alone.

ends        mean absolute difference of the first frame from A and the last from B, the larger.       0
near        worst frame of (d(x, A) + d(x, B)) / d(A, B), d the sliced Wasserstein distance of
            windows: how far from the way between the textures.                                       1
progress    largest |p - t|, where p = d(x, A) / (d(x, A) + d(x, B)).            0; a hard cut 0.5
sharpness   worst frame's mean absolute gradient over that of A and B, mixed by time.       1; less is blur
ghost       double exposure: of 32x32 px blocks, high-passed, the part that A and B explain together
            and the better of them does not, over the same of a cross-dissolve.        0; a cross-dissolve 1
steps       largest over mean change of consecutive frames.                               1; a rush is more
coherence   change of consecutive frames that optical flow does not explain, summed, over the
            difference of A and B.                                            up to 1.5; frames made anew 4
overall     mean of what is lost by each: near - 1, progress, |1 - sharpness|, ghost, (steps - 1) / 2,
            coherence / 4, and 10 ends.                                                               0
"""

from collections.abc import Sequence
from itertools import pairwise

import torch
from scipy.ndimage import gaussian_filter
from torch import Tensor

from flow import lookup, seen, warp
from kwatra.base import InputError, mean
from kwatra.scoring.quality import carried_scales, sharpness, sliced_wasserstein

BLOCK = 32
"""Px of the blocks of which ghost is judged: it defines the figure."""


def judge(frames: Sequence[Tensor], times: Sequence[float], a: Tensor, b: Tensor) -> dict[str, float]:
    """All figures of frames (C, H, W) in [0, 1] at times from 0 (A) to 1 (B); all of one size, at least 32x32 px.

    Raises InputError for fewer than three frames, or sizes that differ.
    """
    if len(frames) < 3 or len(frames) != len(times):
        raise InputError(f"there are {len(frames)} frames at {len(times)} times; give at least three, each with a time")
    if any(image.shape != a.shape for image in (*frames, b)) or min(a.shape[1:]) < BLOCK:
        raise InputError(f"frames, A and B must have one size of at least {BLOCK}x{BLOCK} px; A is {tuple(a.shape)}")
    figures = {"ends": max(float(mean((x - end).abs())) for x, end in ((frames[0], a), (frames[-1], b)))}
    figures |= _place(frames, times, a, b)
    end = sharpness(b, a)
    figures["sharpness"] = min(sharpness(x, a) / (1 - t + t * end) for x, t in zip(frames, times, strict=True))
    figures["ghost"] = _ghost(frames, times, a, b)
    changes = [_size(y - x) for x, y in pairwise(frames)]
    figures["steps"] = max(changes) / max(sum(changes) / len(changes), 1e-9)
    figures["coherence"] = sum(_unexplained(x, y) for x, y in pairwise(frames)) / max(_size(a - b), 1e-9)
    lost = [figures["near"] - 1, figures["progress"], abs(1 - figures["sharpness"]), figures["ghost"]]
    lost += [(figures["steps"] - 1) / 2, figures["coherence"] / 4, 10 * figures["ends"]]
    return figures | {"overall": sum(max(part, 0.0) for part in lost) / len(lost)}


def _place(frames: Sequence[Tensor], times: Sequence[float], a: Tensor, b: Tensor) -> dict[str, float]:
    """How near the way between the textures frames are, and how evenly they go it."""
    apart = max(_distance(a, b), 1e-9)
    away = [(_distance(x, a), _distance(x, b)) for x in frames]
    parts = [p / max(p + q, 1e-9) for p, q in away]
    progress = max(abs(part - time) for part, time in zip(parts, times, strict=True))
    return {"near": max(p + q for p, q in away) / apart, "progress": progress}


def _distance(x: Tensor, exemplar: Tensor) -> float:
    """Sliced Wasserstein distance in units of color, so that distances to A and to B compare."""
    scales = carried_scales(x, exemplar)
    unit = exemplar.flatten(1).double().var(1, correction=0).mean().sqrt()
    return sum(sliced_wasserstein(x, exemplar, scale=s) for s in scales) / len(scales) * (float(unit) or 1.0)


def _ghost(frames: Sequence[Tensor], times: Sequence[float], a: Tensor, b: Tensor) -> float:
    faded = sum(_doubled(torch.lerp(a, b, time), a, b) for time in times)
    return sum(_doubled(x, a, b) for x in frames) / max(faded, 1e-9)


def _doubled(x: Tensor, a: Tensor, b: Tensor) -> float:
    """Part of the energy of high-passed blocks that A and B at the same place explain only together."""
    x, a, b = (_blocks(image) for image in (x, a, b))
    both = torch.stack([a, b], -1)
    weights = torch.linalg.lstsq(both, x[..., None]).solution[..., 0].clamp(min=0)
    left = (x - (both * weights[:, None]).sum(-1)).square().sum(1)
    alone = torch.stack([_left(x, a), _left(x, b)]).amin(0)
    return float((alone - left).clamp(min=0).sum() / x.square().sum().clamp(min=1e-12))


def _left(x: Tensor, other: Tensor) -> Tensor:
    """Energy of each block that the other's, at its best positive strength, leaves."""
    strength = ((x * other).sum(1) / other.square().sum(1).clamp(min=1e-12)).clamp(min=0)
    return (x - strength[:, None] * other).square().sum(1)


def _blocks(image: Tensor) -> Tensor:
    """High-passed blocks (N, C * 32 * 32), in double precision, with a trace of noise so that none is empty."""
    high = image.double() - torch.from_numpy(gaussian_filter(image.double().cpu().numpy(), (0, 3, 3))).to(image.device)
    noise = torch.randn(high.shape, dtype=torch.float64, generator=torch.Generator().manual_seed(0)).to(high)
    blocks = (high + 1e-6 * noise).unfold(1, BLOCK, BLOCK).unfold(2, BLOCK, BLOCK)
    return blocks.permute(1, 2, 0, 3, 4).flatten(2).flatten(0, 1)


def _unexplained(before: Tensor, after: Tensor) -> float:
    """Change that remains when optical flow has moved the first frame onto the second, or without it where less."""
    moved = warp(before, lookup(seen(before, after)).coordinates)
    return min(_size((after - moved)[:, 4:-4, 4:-4]), _size(after - before))


def _size(change: Tensor) -> float:
    return float(mean(change.square()).sqrt())
