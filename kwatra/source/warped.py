"""What an image shows at places between its pixels."""

import numpy as np
import torch
from scipy import ndimage
from torch import Tensor

from kwatra.source.sourcemap import look_up

SMOOTH = 1.5
"""px over which detail differs from its surroundings. By eye, on granite and made stones."""


def read_between(pixels: Tensor, places: Tensor) -> Tensor:
    """The values (C, H, W) of an image at places (2, H, W) between pixels, float64, row first, and exact where on one.

    By cubic splines, kept within the four pixels around. It is done on the CPU.
    """
    last = torch.tensor(pixels.shape[1:], device=places.device).view(2, 1, 1) - 1
    places = torch.minimum(places.clamp(min=0), last)
    read, between = look_up(pixels, places.round().long()), (places != places.round()).any(0)
    if not bool(between.any()):
        return read
    some = places[:, between].cpu().numpy()
    first = some.astype(np.int64)
    following = np.minimum(first + 1, np.array(pixels.shape[1:])[:, None] - 1)
    for channel, values in zip(pixels.cpu().numpy(), read, strict=True):
        around = [channel[row, column] for row in (first[0], following[0]) for column in (first[1], following[1])]
        cubic = ndimage.map_coordinates(channel, some, order=3, mode="nearest")
        values[between] = torch.from_numpy(cubic.clip(np.min(around, 0), np.max(around, 0))).to(values)
    return read


def read_warped(pixels: Tensor, places: Tensor, detail: Tensor, share: Tensor) -> Tensor:
    """The same, but for a share (H, W) of the detail, which is read at pixels of its own, `detail` (2, H, W) int64.

    Detail is by what pixels differ from the Gaussian mean around them; values stay within those of the image.
    """
    if not bool((share > 0).any()):
        return read_between(pixels, places)
    smooth = torch.from_numpy(ndimage.gaussian_filter(pixels.cpu().numpy(), SMOOTH, axes=(1, 2))).to(pixels)
    read, apart = read_between(pixels, places), read_between(smooth, places) + look_up(pixels - smooth, detail)
    low, high = (end(pixels, (1, 2), keepdim=True) for end in (torch.amin, torch.amax))
    return torch.where(share > 0, torch.minimum(torch.maximum(read.lerp(apart, share), low), high), read)
