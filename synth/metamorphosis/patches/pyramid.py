"""A steerable pyramid (plenoptic's) of images of any size: octaves, and in those complex bands of 4 orientations."""

from functools import lru_cache
from typing import Any

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

_ORIENTATIONS = 4
"""As many as Portilla and Simoncelli (2000) have."""
_MARGIN = 16
"""Pixels by which an image is continued at every border, at least: filters see no border."""


class Pyramid:
    """An image's bands: `finest` (C, h, w), `bands` (C, O, h, w), one per octave, fine to coarse, and what is left.

    The image was continued; `inside` leaves that out.
    """

    def __init__(self, filters: Any, made: dict[Any, Tensor], frame: tuple[int, ...], share: Tensor | None) -> None:
        self._filters, self._frame, self._share = filters, frame, share
        self.finest, self._rest = made.pop("residual_highpass")[0], made.pop("residual_lowpass")[0]
        self.bands = [made[number][0] for number in range(len(made))]

    @classmethod
    def of(cls, image: Tensor, wrap: bool, octaves: int, share: Tensor | None) -> "Pyramid":
        """That of an image (C, H, W), which may be periodic; share (H, W): how much each pixel counts, or None."""
        unit = 2**octaves
        continued = image
        for axis in (1, 2):
            size = image.shape[axis]
            wide = (_MARGIN, _MARGIN + -size % unit)
            index = torch.from_numpy(np.pad(np.arange(size), wide, mode="wrap" if wrap else "symmetric"))
            continued = continued.index_select(axis, index.to(image.device))
        filters = _filters((continued.shape[1], continued.shape[2]), octaves, str(image.device))
        return cls(filters, dict(filters(continued[None])), tuple(image.shape[1:]), share)

    def inside(self, band: Tensor) -> Tensor:
        """What of a band (..., h, w) the image itself holds, not its continuation, flat: (..., n)."""
        coarse = self.finest.shape[-1] // band.shape[-1]
        margin, (height, width) = _MARGIN // coarse, (size // coarse for size in self._frame)
        return band[..., margin : margin + height, margin : margin + width].flatten(-2)

    def counted(self, band: Tensor) -> tuple[Tensor, Tensor | None]:
        """What is inside, and how much each place of it counts, (n,); None: all alike."""
        if self._share is None:
            return self.inside(band), None
        coarse = self.finest.shape[-1] // band.shape[-1]
        return self.inside(band), F.avg_pool2d(self._share[None].to(self.finest), coarse).flatten()

    def image(self) -> Tensor:
        """The image (C, H, W) that has these bands."""
        whole: dict[str | int, Tensor] = {number: band[None] for number, band in enumerate(self.bands)}
        whole |= {"residual_highpass": self.finest[None], "residual_lowpass": self._rest[None]}
        height, width = self._frame
        made: Tensor = self._filters.recon_pyr(whole)[0]
        return made[:, _MARGIN : _MARGIN + height, _MARGIN : _MARGIN + width]


@lru_cache(maxsize=8)
def _filters(shape: tuple[int, int], octaves: int, device: str) -> Any:
    """The steerable pyramid for images of a shape; its bands are as strong as the image, whatever their octave."""
    from plenoptic.process import SteerablePyramidFreq  # heavy: only where statistics are wanted

    order = _ORIENTATIONS - 1
    return SteerablePyramidFreq(shape, height=octaves, order=order, is_complex=True, tight_frame=True).to(device)
