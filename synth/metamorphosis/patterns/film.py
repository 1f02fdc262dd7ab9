"""The frames: both textures warped to where the patterns are at a time, and dissolved (Liu et al. 2002, 4.3, 4.4)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from scipy.spatial import KDTree
from torch import Tensor

from flow.warps import REPEATS, free_form, pixel_coordinates, warp
from synth.metamorphosis.patterns.correspondence import Correspondence

_PHASE = 0.2
"""Part of the time in which crowded patterns are scaled down before they move, and again up after."""
_LEAST, _CROWDED = 0.5, 0.8
"""Patterns that pass each other at .8 of their distance need no scaling: stones and pebbles judge better without."""
_STEPS = 11
_FINEST = 5.0
"""Px of the finest lattice: landmarks that contradict each other swirl in finer ones (stones, pebbles)."""


@dataclass(frozen=True)
class Warping:
    """How the frame is warped through landmarks: tile, that it is periodic; touching, see `touching`.

    Where patterns touch, landmarks of neighbors contradict each other: each lattice is then fitted once. Of the pairs
    of `Search`, pebbles and stones score .061 and .064 so by the outside judge, and .119 and .141 with repetitions.
    """

    tile: bool
    touching: bool

    def displacement(self, here: Tensor, there: Tensor, size: tuple[int, int] | torch.Size) -> Tensor:
        """The displacement (2, H, W) through points (N, 2) that move from here to there."""
        repeats = 1 if self.touching else REPEATS
        return free_form(here, there - here, size, finest=_FINEST, wrap=self.tile, repeats=repeats).float()

    def moved(self, image: Tensor, there: Tensor, now: Tensor) -> Tensor:
        """An image (C, H, W) moved so that what is at points `there` (N, 2) comes to be at points `now` (N, 2).

        Beyond the border the image is mirrored, or goes on where it tiles.
        """
        size = image.shape[1:]
        places = pixel_coordinates(size) + self.displacement(now, there, size)
        if not self.tile:
            places = torch.stack([_mirrored(places[0], size[1]), _mirrored(places[1], size[0])])
        return warp(image, places, "bicubic", wrap=self.tile).clamp(0, 1)


def touching(ways: Correspondence) -> bool:
    """Whether at an end of the way most patterns are nearer to another than a cell of the finest lattice."""
    return any(float(np.median(_gaps(ends[: ways.pairs]))) < _FINEST for ends in (ways.in_a, ways.in_b))


def crowding(ways: Correspondence) -> float:
    """The scale at which most patterns come no nearer to each other on their way than at its ends; 1 from 0.8 on."""
    near = [_nearest(ways.at(k / (_STEPS - 1))[: ways.pairs].mean(1)) for k in range(_STEPS)]
    ends = np.minimum(near[0], near[-1])
    squeezed = np.min(near, axis=0) / np.maximum(ends, 1e-9)
    scale = float(np.quantile(squeezed, 0.1))
    return max(_LEAST, scale) if scale < _CROWDED else 1.0


def phases(t: float, scale: float) -> tuple[float, float]:
    """How far patterns have moved, and their scale, at time t: scaled down first, moved, and scaled up last.

    With a scale of 1 they move all the time.
    """
    if scale == 1:
        return t, 1.0
    small = min(1.0, min(t, 1 - t) / _PHASE)
    return float(np.clip((t - _PHASE) / (1 - 2 * _PHASE), 0, 1)), 1 + (scale - 1) * small


def within(t: float, interval: tuple[float, float]) -> float:
    """How much of an interval of time is over at time t, 0 to 1."""
    begin, end = interval
    return float(np.clip((t - begin) / (end - begin), 0, 1))


def median(frames: Sequence[Tensor], count: int) -> list[Tensor]:
    """Each frame as the pixels' median over `count` frames around it; fewer, as many before as after, at the ends."""
    smoothed = []
    for number in range(len(frames)):
        reach = min(count // 2, number, len(frames) - 1 - number)
        smoothed.append(torch.stack(list(frames[number - reach : number + reach + 1])).median(0).values)
    return smoothed


def _mirrored(places: Tensor, size: int) -> Tensor:
    period = 2 * max(1, size - 1)
    folded = places.remainder(period)
    return torch.minimum(folded, period - folded)


def _nearest(centers: np.ndarray) -> np.ndarray:
    """The distance of each of some centers (n, 2) to the nearest other one."""
    away = np.linalg.norm(centers[:, None] - centers[None], axis=2)
    np.fill_diagonal(away, np.inf)
    return away.min(1)


def _gaps(patterns: np.ndarray) -> np.ndarray:
    """The least distance of the landmarks of each pattern (n, m, 2) to another's; infinite for a single one."""
    count, landmarks = patterns.shape[:2]
    if count < 2:
        return np.full(count, np.inf)
    points, own = patterns.reshape(-1, 2), np.repeat(np.arange(count), landmarks)
    away, others = KDTree(points).query(points, landmarks + 1)  # one of so many is another pattern's
    return np.asarray(np.where(own[others] != own[:, None], away, np.inf).min(1).reshape(count, -1).min(1))
