"""How well every placement of an image fits what is there: correlations, by FFT and summed-area tables (thesis 3.2).

    inside: sum over a region of  w(p) |I(x + p) - O(p)|^2,  for every x at which the region lies in the image  (eq. 4)
    under:  sum over the filled part of a stretch of  |I(p) - O(x + p)|^2,  wherever the image lies in it       (eq. 2)

A transform costs its size times its logarithm, however large the region; memory is a few arrays of the image's size or
the stretch's.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from kwatra.base.spans import box_sums
from kwatra.base.transforms import backward, fast, forward


class Fit:
    """An image (C, *S) to be placed, in any number of dimensions; keeps its transforms.

    more: others of the same size, which are placed with it, but compared each for itself.
    """

    def __init__(self, image: np.ndarray, *more: np.ndarray) -> None:
        self.images = [image, *more]
        self._spectra: dict[tuple[int, ...], np.ndarray] = {}
        self._of_channels: np.ndarray | None = None

    def inside(self, content: np.ndarray, weight: np.ndarray) -> np.ndarray:
        """The weighted squared difference of a region's content (C, *E) to each place of the image, (S - E + 1).

        weight: >= 0, (*E), or (C, *E) with a weight for each channel. Where it is 0 content is not looked at.
        """
        there = np.where(weight > 0, content, 0)
        known = there * weight
        ones = np.concatenate([known, weight if weight.ndim == content.ndim else weight[None]])
        constant = (known * there).sum(dtype=np.float64)
        return np.maximum(self.less_energy(ones[None])[0, 0] + constant, 0)

    def less_energy(self, ones: np.ndarray) -> np.ndarray:
        """What `inside` finds of several contents, (b, images, *(S - E + 1)), less their weighted squares.

        ones (b, k, *E): contents, the images' channels one after the other, times their weight, which is last; or of
        one image with a weight for each channel, which are last.
        """
        shape, extent, channels = self.images[0].shape[1:], ones.shape[2:], sum(map(len, self.images))
        size = fast(shape)
        if ones.shape[1] == channels + 1:
            spectrum = _correlated(forward(ones, size), self._spectrum(size), *self._pairs)
        else:
            spectrum = _correlated(forward(ones, size), self._channel_spectrum())
        return backward(spectrum, size, tuple(n - e + 1 for n, e in zip(shape, extent, strict=True)))

    def under(self, content: np.ndarray, mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The squared difference of the image to each part of a stretch (C, *R), (R - S + 1), and on how many pixels.

        mask (*R): 1 where the stretch is filled, 0 where not; content is 0 there.
        """
        shape = self.images[0].shape[1:]
        size = fast(mask.shape)
        spectrum = _correlated(self._spectrum(size)[None], forward(np.concatenate([content, mask[None]]), size))
        room = tuple(n - s + 1 for n, s in zip(mask.shape, shape, strict=True))
        cost = backward(spectrum, size, room)[0, 0] + box_sums((content**2).sum(0), shape)
        return np.maximum(cost, 0), box_sums(mask > 0, shape)

    def _spectrum(self, size: tuple[int, ...]) -> np.ndarray:
        """Transforms of minus twice the channels of each image and, after them, of its squared colors."""
        if size not in self._spectra:
            planes = [plane for image in self.images for plane in (*(-2 * image), (image**2).sum(0))]
            self._spectra[size] = forward(np.stack(planes), size)
        return self._spectra[size]

    @cached_property
    def _pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """With which of the contents each of `_spectrum` goes together, and to which image that belongs."""
        channels = [len(image) for image in self.images]
        ends, weight = np.cumsum(channels).tolist(), sum(channels)
        contents = [[*range(end - count, end), weight] for end, count in zip(ends, channels, strict=True)]
        return np.concatenate(contents), np.repeat(np.arange(len(channels)), np.array(channels) + 1)

    def _channel_spectrum(self) -> np.ndarray:
        """Transforms of minus twice the channels, and of the squares of each, at the image's own size."""
        if self._of_channels is None:
            image, size = self.images[0], fast(self.images[0].shape[1:])
            self._of_channels = forward(np.concatenate([-2 * image, image**2]), size)
        return self._of_channels


def totals(values: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """The sums (..., R - S + 1) of values (..., *S) over what a mask (*R) has under them wherever they lie in it."""
    size = fast(mask.shape)
    room = tuple(n - s + 1 for n, s in zip(mask.shape, values.shape[-mask.ndim :], strict=True))
    return backward(np.conj(forward(values, size)) * forward(mask, size), size, room)


def _correlated(
    ones: np.ndarray, others: np.ndarray, which: np.ndarray | None = None, into: np.ndarray | None = None
) -> np.ndarray:
    """Transforms (b, sums, *size) of summed correlations of ones (b, k, *size) with others (n, *size), all transforms.

    which (n,): of the ones, goes with each of the others; into (n,): which sum. None: in their order, into one.
    """
    from kwatra.pieces.loops import correlate

    which = np.arange(len(others)) if which is None else which
    into = np.zeros(len(others), int) if into is None else into
    total = np.empty((len(ones), int(into.max()) + 1, *others.shape[1:]), np.result_type(ones, others))
    flat = others.reshape(len(others), -1)
    correlate(ones.reshape(*ones.shape[:2], -1), flat, which, into, total.reshape(*total.shape[:2], -1))
    return total
