"""Light that goes on evenly over seams: what copies of a video differ by in brightness shows as edges of blocks.

Copies get corrections c, the least of

    sum_pq |c_q - c_p - r_pq|^2 + |c|^2 / reach^2

over neighbors p and q. Within a copy r is 0; at a seam it is what the step between the two copies lacks to the mean of
those that the copies themselves have there, averaged along the seam. That is a Poisson equation, as images are blended
by their gradients (Perez, Gangnet and Blake 2003), held so that a correction fades within `reach` px: an edge becomes a
slope, and details stay. On a frame's rectangle cosine transforms solve it at once.
"""

import numpy as np
import torch
from scipy import fft, ndimage
from torch import Tensor

from flow.animation.copies import changes, offsets
from flow.animation.reading import Reading

_ALONG = 5.0
"""Steps of light are averaged along a seam over so many px: what single drops differ by is none. With 3 light is
restless, with 8 some edges stay."""


def evened(image: Tensor, source: Tensor, inside: Tensor, read: Reading, reach: float) -> Tensor:
    """A frame (C, H, W) that shows an exemplar at source coordinates (2, H, W), its light evened over seams.

    inside (H, W): where there is texture. reach >= 0, in px; with 0 nothing changes, nor does a frame without seams.
    """
    if reach == 0:
        return image
    (_, down), (_, right) = changes(offsets(source))
    seams = ~down & inside[1:] & inside[:-1], ~right & inside[:, 1:] & inside[:, :-1]
    if not any(bool(seam.any()) for seam in seams):
        return image
    force = np.zeros(image.shape)
    for axis, seam in enumerate(seams, 1):
        lack = _lacking(source, seam, read, axis).cpu().double().numpy()
        ahead, back = [slice(None)] * 3, [slice(None)] * 3
        ahead[axis], back[axis] = slice(1, None), slice(None, -1)
        force[tuple(ahead)] += lack
        force[tuple(back)] -= lack
    waves = [2 - 2 * np.cos(np.pi * np.arange(side) / side) for side in image.shape[1:]]
    spectrum = fft.dctn(force, axes=(1, 2), norm="ortho") / (waves[0][:, None] + waves[1] + reach**-2)
    light = torch.from_numpy(fft.idctn(spectrum, axes=(1, 2), norm="ortho")).to(image)
    return torch.where(inside, read.within(image + light), image)


def _lacking(source: Tensor, seam: Tensor, read: Reading, axis: int) -> Tensor:
    """r of each pair of neighbors along an axis, (C, H - 1, W) or (C, H, W - 1); 0 but where seam says there is one."""
    side = source.shape[axis]
    one, other = source.narrow(axis, 0, side - 1)[:, seam], source.narrow(axis, 1, side - 1)[:, seam]
    step = torch.zeros(2, 1, device=source.device)
    step[2 - axis] = 1.0  # x first
    show_one, show_other = read(one), read(other)
    own = (read(one + step) - show_one + show_other - read(other - step)) / 2
    lack = torch.zeros(len(own), *seam.shape, device=source.device)
    lack[:, seam] = own - (show_other - show_one)
    weight = _blurred(seam[None].float()).clamp(min=1e-6)
    return torch.where(seam, _blurred(lack) / weight, 0.0)


def _blurred(values: Tensor) -> Tensor:
    smooth = ndimage.gaussian_filter(values.cpu().numpy(), _ALONG, mode="nearest", axes=(1, 2))
    return torch.from_numpy(smooth).to(values.device)
