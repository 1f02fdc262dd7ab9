"""Light that goes on evenly where pieces of a video meet in time.

Pieces may agree in every detail and yet differ a little in brightness, and over a large area a step as small is seen.
So the video x gets a smooth correction c, the least of

    sum_t |G (x_t+1 + c_t+1 - x_t - c_t - g_t)|^2 + SHORT |G c_t|^2,

with G a blur in space and g what the exemplar's own light changes by where each pixel comes from: a Poisson equation in
time alone, as images are blended by their gradients (Perez, Gangnet and Blake 2003). Details are not touched. Where the
exemplar's frames have little to do with each other a step says as little: c counts as much as a frame's light is told
by the one before, or flames would take on colors that no flame has.
"""

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra import Exemplar
from kwatra.base import mean
from kwatra.source import look_up

AROUND = 3.0
"""Light is color blurred by so many px: 5 or 8 leave more of its restlessness."""

SHORT = 0.5
"""A correction fades within so many frames as the inverse of this has a root. Of smoke, whose light is too restless by
.34 (mean log amplitude of its spectra) where nothing is corrected, .15 is left with .5 and .13 with .1, with which
corrections are twice as large and leave the exemplar's colors."""


def evened(
    video: Tensor, where: Tensor, exemplar: Exemplar, wrap: tuple[bool, ...], held: Tensor | None = None
) -> Tensor:
    """A video (C, T, H, W) whose light goes on as the exemplar's does, where the map (3, T, H, W) says it comes from.

    The map's places are on the exemplar's canvas. wrap: whether time, rows and columns are periodic. held (T,): True
    for frames to leave alone.
    """
    from scipy import sparse  # stills need none of it
    from scipy.sparse.linalg import splu

    frames = video.shape[1]
    free = np.ones(frames, bool) if held is None else ~held.cpu().numpy()
    if frames < 2 or not free.any() or exemplar.shape[0] < 2:
        return video
    pairs = frames if wrap[0] else frames - 1
    missing = _wanted(where, exemplar, pairs) - (video.roll(-1, 1) - video)[:, :pairs]
    modes = ["wrap" if around else "nearest" for around in wrap[1:]]
    step = sparse.eye(pairs, frames, 1) - sparse.eye(pairs, frames)
    if wrap[0]:
        step = step + sparse.eye(pairs, frames, 1 - frames)
    system = (step.T @ step + SHORT * sparse.eye(frames)).tocsr()[free][:, free]
    solved, corrected, lasting = splu(system.tocsc()), video.clone(), _lasting(exemplar)
    for channel, lack in zip(corrected, missing.cpu().numpy(), strict=True):
        smooth = ndimage.gaussian_filter(lack, AROUND, mode=modes, axes=(1, 2)).reshape(pairs, -1)
        light = solved.solve(np.asfortranarray((step.T @ smooth)[free], np.float64))
        channel[torch.from_numpy(free)] += lasting * torch.from_numpy(light).to(channel).view(-1, *channel.shape[1:])
    return corrected


def _lasting(exemplar: Exemplar) -> float:
    """How far light is told by the frame before, 0 to 1: 1 less its mean square step in units of that between frames
    at unrelated times, which is twice the variance. It is .20 of flames and .93 of smoke.
    """
    smooth = ndimage.gaussian_filter(exemplar.canvas.cpu().numpy(), AROUND, mode="nearest", axes=(2, 3))
    light, owner = torch.from_numpy(smooth), exemplar.owner.cpu()
    known = owner >= 0
    step = light.diff(dim=1).square().sum(0)[known[1:] & (owner[1:] == owner[:-1])]
    count = known.sum(0)
    apart = (light - (light * known).sum(1, keepdim=True) / count.clamp(min=1)) * known
    variance = (apart.square().sum((0, 1)) / (count - 1).clamp(min=1))[count > 1]
    unrelated = 2 * mean(variance) if len(variance) else torch.zeros(())
    return max(1 - float(mean(step) / unrelated), 0.0) if len(step) and float(unrelated) > 0 else 0.0


def _wanted(where: Tensor, exemplar: Exemplar, pairs: int) -> Tensor:
    """What each pixel should change by to the next frame, (C, pairs, H, W): as its source does, and as the next's did.

    It is the mean of the two. At the end of a clip what changed before goes on, and so it does back from its beginning.
    """
    step = exemplar.canvas.diff(dim=1)
    same = (exemplar.owner[1:] == exemplar.owner[:-1]) & (exemplar.owner[1:] >= 0)
    none, never = torch.zeros_like(step[:, :1]), torch.zeros_like(same[:1])
    ahead, goes = torch.cat([step, none], 1), torch.cat([same, never])
    back, came = torch.cat([none, step], 1), torch.cat([never, same])
    onward, hither = torch.where(goes, ahead, back * came), torch.where(came, back, ahead * goes)
    return (look_up(onward, where[:, :pairs]) + look_up(hither, where.roll(-1, 1)[:, :pairs])) / 2
