"""Fourier transforms of several axes, of which no two complex ones are done at once.

MKL, by which torch transforms, does several complex axes at once, and of some sizes it then writes beyond a buffer of
its own: of 15 x 675 in single precision, of 16 x 216 in double (torch 2.13; seen by valgrind, which finds nothing along
one axis, of sizes up to 900). What was overwritten is found out later and elsewhere: video quilting crashed.
"""

from collections.abc import Sequence

import numpy as np
import torch
from scipy import fft
from torch import Tensor

from kwatra.base.threads import by_one_thread


def of_real(values: Tensor, size: Sequence[int]) -> Tensor:
    """Transforms (..., *size[:-1], size[-1] // 2 + 1) of real values (..., *S) and zeros up to a size (*S)."""
    spectrum = torch.fft.rfftn(values, size[-2:])  # of which one is complex
    for axis in range(-len(size), -2):
        spectrum = torch.fft.fft(spectrum, size[axis], dim=axis)
    return spectrum


def to_real(spectrum: Tensor, size: Sequence[int], room: Sequence[int]) -> Tensor:
    """The first values (..., *room) of those of a size (*S) that transforms, as of `of_real`, are of."""
    for axis in range(-len(size), -2):
        spectrum = torch.fft.ifft(spectrum, dim=axis).narrow(axis, 0, room[axis])
    return torch.fft.irfftn(spectrum, size[-2:])[(..., *(slice(r) for r in room))]


def of_complex(values: Tensor) -> Tensor:
    """Orthonormal transforms (..., H, W) of values, real or complex, along the last two axes."""
    return torch.fft.fft(torch.fft.fft(values, norm="ortho"), dim=-2, norm="ortho")


def to_complex(spectrum: Tensor) -> Tensor:
    """The values (..., H, W), complex, that transforms as of `of_complex` are of."""
    return torch.fft.ifft(torch.fft.ifft(spectrum, norm="ortho"), dim=-2, norm="ortho")


def fast(extent: Sequence[int]) -> tuple[int, ...]:
    """Sizes of at least so many values along each axis whose transforms take little time."""
    return tuple(fft.next_fast_len(n, real=True) for n in extent)


def forward(values: np.ndarray, size: Sequence[int]) -> np.ndarray:
    """As `of_real`, of arrays and by one thread: to wake another takes as long."""
    with by_one_thread():
        spectrum: np.ndarray = of_real(torch.from_numpy(values), size).numpy()
    return spectrum


def backward(spectrum: np.ndarray, size: Sequence[int], room: Sequence[int]) -> np.ndarray:
    """As `to_real`, of arrays and by one thread."""
    with by_one_thread():
        values: np.ndarray = to_real(torch.from_numpy(spectrum), size, room).numpy()
    return values
