"""Light that goes on evenly where pieces of a video meet, in space and in time.

Pieces may agree in every detail and yet differ a little in brightness, and over a large area a step as small is seen.
So the video x gets corrections c, first for steps within its frames, then for those from frame to frame, each the least
of

    sum_pq |x_q + c_q - x_p - c_p - g_pq|^2 + f sum_p |c_p|^2

over such steps from p to q, with g what the exemplar's own colors change by where each pixel comes from, and f FADING
or SHORT: Poisson equations, as images are blended by their gradients (Perez, Gangnet and Blake 2003), but for f, with
which they are solved by cosines (Bhat, Curless, Cohen and Zitnick 2008). Within a piece there is nothing to correct.
Corrections of steps within frames should be alike from frame to frame, as sum_pq |c_q - c_p|^2 over such steps asks, or
what is left of details at a seam flickers. From frame to frame all is blurred in space before: details live, and only
light is to go on, and details so far as they do in the exemplar. Where its frames have little to do with each other a
step in time says as little: light counts as much as a frame's is told by the one before, or flames would take on colors
that no flame has, and details as much as theirs are: .7 of smoke, .6 of fish, .02 of water.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra import Exemplar
from kwatra.base import every_pair, mean, membrane
from kwatra.elements.kept import kept
from synth.texture.steps import corrections, lacking

AROUND = 3.0
"""Light is color blurred by so many px: 5 or 8 leave more of its restlessness."""

FINE = 0.75
"""Details are color blurred by so many px, less its light: what is finer only changes anyway.

Without them joints in time were seen in slices through smoke half as large again: where pieces meet it changed by 1.36
and 1.33 times as much from frame to frame as its clip does there, and by .053 more or less from one frame to the next;
by 1.13, 1.10 and .028 with them, .023 in the clip (two seeds). Of its sharpness .007 goes, of flicker 1.16 times the
clip's 1.04 is left. Light blurred by less alone does as much, and makes fish calmer by .015."""

FADING = 0.01
"""A correction fades within so many px and frames as the inverse of this has a root, ten. Steps of brightness within
fish and a fountain half as large again as their clips are hardly seen then; with a hundredth of it dark clouds are."""

SHORT = 0.5
"""A correction fades within so many frames as the inverse of this has a root. Of smoke, whose light is too restless by
.34 (mean log amplitude of its spectra) where nothing is corrected, .15 is left with .5 and .13 with .1, with which
corrections are twice as large and leave the exemplar's colors."""

REACH = 32.0
"""Over so many pixels and frames steps at the border of what is known are spread. In holes of four clips all is off by
28.7 of 255 with 32, and by 29.2 with 8 (root mean square)."""


def evened(
    video: Tensor, where: Tensor, exemplar: Exemplar, wrap: tuple[bool, ...], held: Tensor | None = None
) -> Tensor:
    """A video (C, T, H, W) whose light goes on as the exemplar's does, where the map (3, T, H, W) says it comes from.

    The map's places are on the exemplar's canvas. wrap: whether time, rows and columns are periodic. held (T,): True
    for frames to leave alone.
    """
    free = torch.ones(video.shape[1], dtype=torch.bool) if held is None else ~held.cpu()
    if not bool(free.any()):
        return video
    return _in_time(_in_space(video, where, exemplar, wrap, free), where, exemplar, wrap, free)


def evened_inside(video: Tensor, where: Tensor, exemplar: Exemplar, free: Tensor) -> Tensor:
    """A video (C, T, H, W) in [0, 1] whose light goes on from what is not free (T, H, W) evenly into what is.

    Within frames it goes on as the exemplar does where the map (3, T, H, W) says that pixels come from, and over time
    so far as light lasts. What is not free stays.
    """
    steps = [torch.zeros_like(video) for _ in free.shape]
    for axis, counted in enumerate((lasting(exemplar).light, 1.0, 1.0), 1):
        if min(video.shape[axis], exemplar.shape[axis - 1]) > 1:
            lack = counted * lacking(video, where, exemplar, axis, False)
            steps[axis - 1].narrow(axis, 0, lack.shape[axis]).copy_(lack)
    added = membrane(free, every_pair(free.shape), steps, REACH)
    return torch.where(free, (video + added).clamp(0, 1), video)


def _in_space(video: Tensor, where: Tensor, exemplar: Exemplar, wrap: tuple[bool, ...], free: Tensor) -> Tensor:
    """A video whose light goes on evenly within each of its `free` (T,) frames, which follow each other."""
    corrected, pull = video.clone(), torch.zeros_like(video)
    for axis in (2, 3):
        lack = lacking(video, where, exemplar, axis, wrap[axis - 1])
        if not wrap[axis - 1]:
            lack = torch.cat([lack, torch.zeros_like(lack.narrow(axis, 0, 1))], axis)
        pull += lack.roll(1, axis) - lack
    around = (wrap[0] and bool(free.all()), *wrap[1:])
    for channel, one in zip(corrected, pull[:, free.to(pull.device)].cpu().numpy(), strict=True):
        channel[free] += torch.from_numpy(corrections(one, around, FADING)).to(channel)
    return corrected


def _in_time(video: Tensor, where: Tensor, exemplar: Exemplar, wrap: tuple[bool, ...], free: Tensor) -> Tensor:
    """A video whose light goes on evenly from each frame to the next; only `free` (T,) ones are touched."""
    from scipy import sparse  # stills need none of it
    from scipy.sparse.linalg import splu

    frames = video.shape[1]
    if frames < 2 or exemplar.shape[0] < 2:
        return video
    missing = lacking(video, where, exemplar, 1, wrap[0])
    pairs, modes = missing.shape[1], ["wrap" if around else "nearest" for around in wrap[1:]]
    step = sparse.eye(pairs, frames, 1) - sparse.eye(pairs, frames)
    if wrap[0]:
        step = step + sparse.eye(pairs, frames, 1 - frames)
    able = free.numpy()
    system = (step.T @ step + SHORT * sparse.eye(frames)).tocsr()[able][:, able]
    solved, corrected = splu(system.tocsc()), video.clone()
    lasts = lasting(exemplar)
    for channel, lack in zip(corrected, missing.cpu().numpy(), strict=True):
        light, details = _parted(lack, modes)
        counted = (lasts.light * light + lasts.details * details).reshape(pairs, -1)
        found = solved.solve(np.asfortranarray((step.T @ counted)[able], np.float64))
        channel[free] += torch.from_numpy(found).to(channel).view(-1, *channel.shape[1:])
    return corrected


class Lasting(NamedTuple):
    """How far light and details are told by the frame before, 0 to 1."""

    light: float
    details: float


@kept
def lasting(exemplar: Exemplar) -> Lasting:
    """1 less the mean square step of each, in units of that between frames at unrelated times, which is twice the
    variance. Of light it is .20 of flames and .93 of smoke.
    """
    light, details = _parted(exemplar.canvas.numpy(), "nearest")
    return Lasting(_told(light, exemplar.owner), _told(details, exemplar.owner))


def _parted(values: np.ndarray, modes: str | Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
    """The light of values (..., H, W), and their details; modes: how they go on beyond their borders, as in scipy."""
    light, both = (ndimage.gaussian_filter(values, around, mode=modes, axes=(-2, -1)) for around in (AROUND, FINE))
    return light, both - light


def _told(canvas: np.ndarray, owner: Tensor) -> float:
    """How far a canvas (C, T, H, W), of whose pixels an owner (T, H, W) has each, is told by the frame before."""
    values = torch.from_numpy(canvas)
    known = owner >= 0
    step = values.diff(dim=1).square().sum(0)[known[1:] & (owner[1:] == owner[:-1])]
    count = known.sum(0)
    apart = (values - (values * known).sum(1, keepdim=True) / count.clamp(min=1)) * known
    variance = (apart.square().sum((0, 1)) / (count - 1).clamp(min=1))[count > 1]
    unrelated = 2 * mean(variance) if len(variance) else torch.zeros((), dtype=torch.float32)
    return max(1 - float(mean(step) / unrelated), 0.0) if len(step) and float(unrelated) > 0 else 0.0
