"""The motion that is seen between two images, and how far it is from the motion that was wanted."""

from importlib import import_module
from typing import Any

import torch
from torch import Tensor

from flow.checks import check_vectors
from kwatra.base import InputError, check_mask, is_whole, mean

BORDER = 16
"""Px at each border of the frame where optical flow is not to be trusted: it sees half of its windows there."""


def seen(first: Tensor, second: Tensor) -> Tensor:
    """The forward flow (2, H, W) that leads from one image (C, H, W) to the next, colors in [0, 1].

    Dense inverse search at OpenCV's medium preset (Kroeger, Timofte, Dai and Van Gool, Fast Optical Flow using Dense
    Inverse Search, 2016) on the mean of the channels, in 8 bits; images of at least 16x16 px. Raises InputError if the
    images differ in size or are smaller.
    """
    if first.shape != second.shape or first.ndim != 3 or min(first.shape[1:]) < BORDER:
        raise InputError(
            f"images have shapes {tuple(first.shape)} and {tuple(second.shape)}; give two (C, H, W) of one size, at "
            f"least {BORDER}x{BORDER}"
        )
    cv2: Any = import_module("cv2")  # its stubs do not know the search
    search = cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_MEDIUM)
    flow = search.calc(_gray(first), _gray(second), None)
    return torch.from_numpy(flow).permute(2, 0, 1).contiguous().to(first.device)


def end_point_error(flow: Tensor, truth: Tensor, known: Tensor | None = None, border: int = BORDER) -> float:
    """Mean distance in px between the ends of the vectors of two flows (2, H, W).

    known (H, W): only pixels that are True count. border: so many pixels at each side of the frame do not count.

    Raises InputError if the sizes differ or no pixel is left to count.
    """
    check_vectors(truth)
    check_vectors(flow, truth.shape[1:])
    if not is_whole(border, 0):
        raise InputError(f"the border is {border}; give a whole number of pixels from 0 on")
    counted = torch.zeros(flow.shape[1:], dtype=torch.bool, device=flow.device)
    counted[border : flow.shape[1] - border, border : flow.shape[2] - border] = True
    if known is not None:
        check_mask(known, flow.shape[1:])
        counted &= known
    if not bool(counted.any()):
        raise InputError(f"no vector is known farther than {border} px from the border; count a smaller border")
    return float(mean((flow - truth).detach().norm(dim=0)[counted]))


def _gray(image: Tensor) -> Any:
    if image.ndim != 3 or not image.is_floating_point():
        raise InputError(
            f"an image has shape {tuple(image.shape)} and type {image.dtype}; give floats (C, H, W), 0 to 1"
        )
    return (image.detach().mean(0).clamp(0, 1) * 255).byte().cpu().numpy()
