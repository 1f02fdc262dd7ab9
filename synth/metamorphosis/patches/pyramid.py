"""A steerable pyramid of images of any size: octaves, and in those complex bands of 4 orientations.

It is that of Simoncelli and Freeman (The steerable pyramid: a flexible architecture for multi-scale derivative
computation, 1995) as Portilla and Simoncelli (2000) take it, and plenoptic too, which takes longer to load than a fast
still's statistics take to make. With r the distance from frequency 0, 1 at the highest along an axis, passes

    h(r) = cos(pi / 2 log2 r) from r = 1/2 to 1, 0 below, 1 above,    l(r)^2 = 1 - h(r)^2

part the finest, h(r), from the rest. An octave's bands hold h(2 r) cos(theta - theta_o)^3 of that, on the half plane
where the cosine is positive; l(2 r) of it is left to the next octave, at half the resolution. All together are as
strong as the image, and bands' real parts are enough to have it back.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor
from torch.fft import fftfreq, irfft2, rfft2

from kwatra.base import atan2
from kwatra.base.transforms import of_complex, to_complex

_ORIENTATIONS = 4
"""As many as Portilla and Simoncelli (2000) have."""
_MARGIN = 16
"""Pixels by which an image is continued at every border, at least: filters see no border."""


class Pyramid:
    """An image's bands: `finest` (C, h, w), `bands` (C, O, h, w), one per octave, fine to coarse, and what is left.

    The image was continued; `inside` leaves that out.
    """

    def __init__(self, continued: Tensor, octaves: int, frame: tuple[int, ...], share: Tensor | None) -> None:
        self._frame, self._share = frame, share
        spectrum = of_complex(continued)
        filters = _filters(spectrum)
        self.finest = to_complex(filters.high * spectrum).real
        self.bands = []
        for _ in range(octaves):
            spectrum = filters.low * spectrum
            self.bands.append(to_complex(filters.oriented.clamp(min=0) * (1j * spectrum)[:, None]))
            rows, columns = (_lower(size).to(spectrum.device) for size in spectrum.shape[1:])
            spectrum = spectrum[:, rows[:, None], columns]
            filters = _filters(spectrum)
        self._rest = to_complex(filters.low * spectrum).real

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
        return cls(continued, octaves, tuple(image.shape[1:]), share)

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
        spectrum = _left(_filters(self._rest).low) * rfft2(self._rest, norm="ortho")
        for band in reversed(self.bands):
            filters = _filters(band)
            whole = -1j * (_left(filters.oriented) * rfft2(band.real, norm="ortho")).sum(1)
            whole[:, _lower(band.shape[-2]).to(band.device), : spectrum.shape[-1]] += spectrum
            spectrum = _left(filters.low) * whole
        spectrum = spectrum + _left(_filters(self.finest).high) * rfft2(self.finest, norm="ortho")
        height, width = self._frame
        made = irfft2(spectrum, self.finest.shape[1:], norm="ortho")
        return made[:, _MARGIN : _MARGIN + height, _MARGIN : _MARGIN + width]


class _Filters(NamedTuple):
    """Of the frequencies (h, w) of a resolution: l(r) and h(r), and both sides of what bands hold, (O, h, w)."""

    low: Tensor
    high: Tensor
    oriented: Tensor


def _filters(like: Tensor) -> _Filters:
    """Those of the resolution of an image, or of its spectrum (..., h, w)."""
    return _filters_of(like.shape[-2], like.shape[-1], like.device)


@lru_cache(maxsize=32)
def _filters_of(height: int, width: int, device: torch.device) -> _Filters:
    y, x = torch.meshgrid(*(2 * fftfreq(n, dtype=torch.float64) for n in (height, width)), indexing="ij")
    octave = torch.hypot(x, y).clamp(min=1e-9).log2()
    fall, fall_below = (torch.pi / 2 * (octave + shift).clamp(-1, 0) for shift in (0, 1))
    turn = torch.arange(_ORIENTATIONS, dtype=torch.float32).view(-1, 1, 1) * torch.pi / _ORIENTATIONS
    # 1.6 = 2 / the sum of the squares over all orientations
    oriented = 1.6**0.5 * torch.cos(atan2(y, x) - turn) ** (_ORIENTATIONS - 1) * fall_below.cos()
    return _Filters(*(each.float().to(device) for each in (-fall.sin(), fall.cos(), oriented)))


def _lower(size: int) -> Tensor:
    """Where along an axis of a spectrum the frequencies of half the resolution are."""
    return (fftfreq(size // 2) * (size // 2)).round().long() % size


def _left(filters: Tensor) -> Tensor:
    """Of filters (..., h, w), what a real image's spectrum is kept for: (..., h, w // 2 + 1)."""
    return filters[..., : filters.shape[-1] // 2 + 1]
