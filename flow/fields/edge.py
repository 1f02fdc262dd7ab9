"""The edge of what a mask leaves out, and keeping a flow from crossing it."""

import numpy as np
import torch
import torch.nn.functional as F
from scipy import ndimage
from torch import Tensor

from flow.warps import pixel_coordinates, warp

_CLEARANCE = 0.4
"""Px that flowing pixels keep from a wall: less than the half px that the centers of those beside it are away."""

_PUSHES = 8
"""So often they are pushed away from it, at most."""

_TINY = 1e-30
"""What divides instead of 0."""


class Edge:
    """How far from an obstacle each pixel of a mask (H, W; False = obstacle) is, and which way leads out of it."""

    def __init__(self, mask: Tensor) -> None:
        free = mask.cpu().numpy()
        # px from pixels' centers to the edge, negative inside; farther than the frame where there is none
        distance = np.full(free.shape, float(sum(free.shape)))
        if not free.all():
            distance = ndimage.distance_transform_edt(free) - ndimage.distance_transform_edt(~free)
            distance -= 0.5 * np.sign(distance)
        self.mask = mask.cpu()
        self.distance = torch.from_numpy(distance).float()[None]
        outward = np.gradient(ndimage.gaussian_filter(distance, 1.0))[::-1]
        self.outward = F.normalize(torch.from_numpy(np.stack(outward)).float(), dim=0)

    def keep_out(self, flow: Tensor) -> Tensor:
        """A flow (2, H, W) that carries no pixel's center into the obstacle: what would land there is pushed out.

        Nothing gets faster than the fastest pixel was. What no push frees rests, and so does the obstacle.
        """
        flow = flow * self.mask
        pixels = pixel_coordinates(flow.shape[1:])
        fastest = flow.norm(dim=0).max()
        for _ in range(_PUSHES):
            place = pixels + flow
            lacking = (_CLEARANCE - warp(self.distance, place, "bilinear")).clamp(min=0) * self.mask
            pushed = flow + lacking * warp(self.outward, place, "bilinear")
            flow = pushed * ((fastest / pushed.norm(dim=0).clamp(min=_TINY)).clamp(max=1))
        landing = warp(self.mask[None].float(), pixels + flow, "nearest")
        return flow * landing
