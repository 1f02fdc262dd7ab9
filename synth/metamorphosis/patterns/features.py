"""What is seen around a pixel: band-pass oriented filters (Liu et al. 2002, 4.2.1).

The filters are Gabor's: a wave under a Gaussian, at two wavelengths that fit the pattern and six orientations. Their
responses are kept with their phase, which tells on which side of an edge a pixel lies, and so finds landmarks to a
pixel.
"""

import numpy as np
from numpy.typing import NDArray
from scipy import signal
from skimage.filters import gabor_kernel

Array = NDArray[np.float64]

_WAVELENGTHS = (0.7, 1.4)
"""In root mean square radii of the pattern: of .5 to 2, on discs and crosses in noise."""
_SHORTEST = 4.0
"""Px: smaller patterns are looked at as if they had this radius, for finer waves hold noise."""
_ORIENTATIONS = 6
"""30 degrees from one wave to the next: not tuned."""
_FAINT = 1e-6
"""What is weaker counts as nothing: a guard against dividing by it."""


def radius(landmarks: Array) -> float:
    """The root mean square distance of landmarks (m, 2) from their centroid."""
    return float(np.sqrt(((landmarks - landmarks.mean(0)) ** 2).sum(1).mean()))


def features(image: Array, size: float) -> Array:
    """Filter responses (K, H, W) of an image (H, W, C) for patterns of root mean square radius `size` px.

    Each is divided by its standard deviation over all pixels of its wavelength.
    """
    maps = []
    for share in _WAVELENGTHS:
        wavelength = max(_SHORTEST * share, share * size)
        bank = [_kernel(wavelength, np.pi * k / _ORIENTATIONS) for k in range(_ORIENTATIONS)]
        responses = np.stack([_filtered(image[..., c], kernel) for c in range(image.shape[2]) for kernel in bank])
        parts = np.concatenate([responses.real, responses.imag])
        strength = parts.std()
        maps.append(parts / strength if strength > _FAINT else np.zeros_like(parts))
    return np.concatenate(maps)


def distances(maps: Array, shapes: Array) -> Array:
    """How unlike pixels are to the landmarks of shapes (n, m, 2), by maps (K, H, W): (m, H, W).

    The distance of the responses from their mean over the shapes, over the length of that: 0 alike, 1 as no response.
    A landmark where nothing responds is unlike everything.
    """
    x, y = np.moveaxis(np.rint(shapes).astype(int), -1, 0)
    own = maps[:, y, x].mean(1).T
    square = (maps**2).sum(0)
    cross = np.tensordot(own, maps, 1)
    length = (own**2).sum(1)[:, None, None]
    apart = np.maximum(square[None] - 2 * cross + length, 0)
    return np.sqrt(np.divide(apart, length, out=np.ones_like(apart), where=length > _FAINT))


def _kernel(wavelength: float, angle: float) -> NDArray[np.complex128]:
    kernel = gabor_kernel(1 / wavelength, theta=angle, bandwidth=1.2, n_stds=2.5)
    envelope = np.abs(kernel)
    return kernel - envelope * (kernel.sum() / envelope.sum())


def _filtered(channel: Array, kernel: NDArray[np.complex128]) -> NDArray[np.complex128]:
    rows, columns = (side // 2 for side in kernel.shape)
    padded = np.pad(channel, ((rows, rows), (columns, columns)), mode="symmetric")
    return signal.fftconvolve(padded, kernel, mode="valid")
