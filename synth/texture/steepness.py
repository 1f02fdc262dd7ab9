"""Details of a video are as strong as those of what it is copied from.

Where copies do not agree, most of all where pieces meet in time, what is shown is a mean of them, and details of a mean
are weaker than those of each: frames there were seen to be soft. So a pixel's details are enlarged until colors around
it are as steep as those around where the pixels come from (variance-preserving blending, see Heitz and Neyret 2018).
Within a piece they are, and nothing changes; nothing is made weaker. Steps across a clip's border say nothing.
"""

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra import Exemplar
from kwatra.base import over_channels
from kwatra.source import look_up

MOST = 2**0.5
"""Details are enlarged up to so many times, which those of a mean of two copies that have nothing in common need. Fish
of twice the frames keep .957 of the sharpness in place of .952 (three seeds); smoke flickers by .03 more (two)."""

WIDE = 11
"""Details are what colors differ by from the mean of so many rows and columns: finer than light
(`synth.texture.light`), which is blurred as far."""

_TINY = 1e-6
"""A mean square step, colors in [0, 1], that is none."""


def steepened(
    video: Tensor, where: Tensor, exemplar: Exemplar, wrap: tuple[bool, ...], held: Tensor | None = None
) -> Tensor:
    """A video (C, T, H, W) with details as strong as the exemplar's, where the map (3, T, H, W) says it comes from.

    The map's places are on the exemplar's canvas. wrap: whether time, rows and columns are periodic. held (T,): True
    for frames to leave alone.
    """
    modes = ["wrap" if around else "nearest" for around in wrap[1:]]
    steps, inside = _squared_steps(exemplar.canvas, exemplar.share), _inside(exemplar.owner)
    result, within = video.clone(), _inside(torch.zeros_like(where[0, :1]))[:, 0]
    for frame in range(video.shape[1]):
        if held is not None and bool(held[frame]):
            continue
        shown, place = video[:, frame], where[:, frame]
        known = look_up(inside, place) * within
        here = _squared_steps(shown[:, None], exemplar.share)[:, 0]
        wanted, found = (_around((known * each).sum(0).cpu().numpy(), modes) for each in (look_up(steps, place), here))
        gain = np.sqrt((wanted + _TINY) / (found + _TINY)).clip(1, MOST)
        colors = shown.cpu().numpy()
        details = colors - _around(colors, modes)
        result[:, frame] += torch.from_numpy((gain - 1) * details).to(video)
    return result


def _around(values: np.ndarray, modes: list[str]) -> np.ndarray:
    """The mean of values (..., H, W) around each."""
    mean: np.ndarray = ndimage.uniform_filter(values, WIDE, mode=modes, axes=(-2, -1))
    return mean


def _inside(owner: Tensor) -> Tensor:
    """Which steps (2, T, H, W) to the next row and column begin and end with the same owner (T, H, W), 1 or 0."""
    inside = torch.zeros(2, *owner.shape, dtype=torch.float32, device=owner.device)
    inside[0, :, :-1] = owner.diff(dim=1) == 0
    inside[1, :, :, :-1] = owner.diff(dim=2) == 0
    return inside


def _squared_steps(colors: Tensor, share: Tensor) -> Tensor:
    """The squared steps (2, T, H, W) of colors (C, T, H, W) to the next row and column."""
    steps = torch.zeros(2, *colors.shape[1:], dtype=torch.float32, device=colors.device)
    steps[0, :, :-1] = over_channels(colors.diff(dim=2).square() * share)
    steps[1, :, :, :-1] = over_channels(colors.diff(dim=3).square() * share)
    return steps
