"""What a texture is like, scale by scale, and making an image like that: the statistics of Portilla and Simoncelli.

A steerable pyramid (see `pyramid`) splits an image into octaves and those into complex bands of 4 orientations, which
have a sign and a magnitude at every place (Portilla and Simoncelli, A parametric texture model based on joint
statistics of complex wavelet coefficients, 2000). Of what that paper measures these are kept, with color as Ruiters et
al. (Patch-based Texture Interpolation, 2010, section 4.5) add it:

- the values: the mean and covariance of all colors;
- the bands: how strong each is and how the channels go together in it, as a covariance;
- the magnitudes: how those of all orientations and channels go together, and with those of the next coarser octave.

Left to the patches that an image is made of: how bands repeat in space, the phase between octaves, and the skewness,
kurtosis and range of values. These, given as quantiles, made frames between dark lines on light and light lines on dark
stranger, and others no better. Nor is it worth its cost to have all: where stills halfway between three pairs of
photographs (bricks, pebbles, stones) were brought to plenoptic's whole `PortillaSimoncelli` of each color, by 40 steps
of descent, squared differences fell from 31 to 39 to 2 to 7, yet distances to both textures changed by .003 and the
strength of octaves by .008 at most, and stones got colored rims. All of it in place of the parts above, 8 steps after
each iteration, left an octave of the stones half as strong as it should be.

Channels are first turned by the cosine transform into brightness and colors (for three channels the axes of Ohta,
Kanade and Sakai, Color information for region segmentation, 1980): nearly uncorrelated, and the same for all textures,
so that statistics of several can be mixed linearly, as in the paper; by optimal transport they are no better. Only the
values' are mixed by optimal transport.

`step` projects an image onto them once, in closed form, coarse to fine: what magnitudes are, given the coarser ones',
as one Gaussian is moved to another; then bands, as their covariances are (see `recolor`); and all values,
likewise. Each changes no more than it must: an image that is right stays as it is.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
import torch.nn.functional as F
from scipy.fft import dct
from torch import Tensor

from kwatra.base import InputError, total
from synth.metamorphosis.patches.pyramid import Pyramid
from synth.metamorphosis.recolor import Colors, barycenter, recolored, transport

LEAST = 16
"""Pixels that an image needs along each axis."""
_OCTAVES, _COARSEST = 4, 8
"""At most so many octaves, as Portilla and Simoncelli take, the coarsest at least so many values along an axis."""
_GAIN = 2.0
"""The most by which a step strengthens anything, and weakens it: what is hardly there is noise."""
_UNSEEN = 1e-6
"""A variance that is not seen: of half a step in 8 bits."""
_LEAST_VARIANCE = 1e-5
"""What `recolor` takes for none."""
_RIDGE = 1e-3
"""What is added to variances, relative to their mean, before they are inverted. A guard, not tuned."""
_ROW = 192
"""Summands of a product: so few are not split among threads."""


@dataclass(frozen=True)
class Octave:
    """The bands of an octave, of O orientations and C channels; K = O C magnitudes.

    bands (O, C, C): covariances of the channels. means (K,) and magnitudes (K, K): means and covariances of the
    magnitudes, first those of a channel; with those of the next coarser octave after them, (2 K,) and (2 K, 2 K), where
    there is one. In double precision.
    """

    bands: Tensor
    means: Tensor
    magnitudes: Tensor


@dataclass(frozen=True)
class Statistics:
    """A texture's statistics; `Statistics.of` an exemplar.

    values: those of all pixels. finest (C, C): the covariance of what is finer than the bands. octaves: fine to coarse.
    All of brightness and colors as channels, in double precision.
    """

    values: Colors
    finest: Tensor
    octaves: tuple[Octave, ...]

    @classmethod
    def of(cls, image: Tensor, wrap: bool = False) -> "Statistics":
        """Those of an image (C, H, W), of any size from 16x16 on; larger ones have more octaves, up to 4.

        wrap: it is periodic. Else, and where a size does not divide, it is continued by its mirror image; what lies
        there is not counted. Raises InputError if it is smaller.
        """
        _check(image)
        turned = _turned(image)
        pyramid = Pyramid.of(turned, wrap, _octaves(image.shape[1:]), None)
        magnitudes = [band.abs() for band in pyramid.bands]
        octaves = []
        for number, band in enumerate(pyramid.bands):
            own = _together(magnitudes[number], magnitudes[number + 1 :][:1])
            octaves.append(Octave(_channels(pyramid.inside(band)), *_moments(pyramid.inside(own))))
        return cls(_values(turned), _covariance(pyramid.inside(pyramid.finest)), tuple(octaves))

    @property
    def channels(self) -> int:
        """C."""
        return len(self.finest)


def mixed(parts: Sequence[Statistics], weights: Sequence[float]) -> Statistics:
    """The mixture of textures' statistics, linear but for `values`; with as many octaves as all have.

    Raises InputError if there is no weight for each, they do not sum to 1, or the numbers of channels differ.
    """
    if len(parts) != len(weights) or abs(sum(weights) - 1) > 1e-4:
        raise InputError(f"{len(parts)} statistics have weights {tuple(weights)}; give one for each, of sum 1")
    if len({part.channels for part in parts}) > 1:
        counts = ", ".join(str(part.channels) for part in parts)
        raise InputError(f"statistics are of images of {counts} channels; give images of as many channels each")

    def mean(values: Sequence[Tensor]) -> Tensor:
        return torch.stack([weight * value for weight, value in zip(weights, values, strict=True)]).sum(0)

    octaves = tuple(
        Octave(*(mean(_as_few([getattr(o, name) for o in one])) for name in ("bands", "means", "magnitudes")))
        for one in zip(*(part.octaves for part in parts), strict=False)
    )
    values = barycenter([part.values for part in parts], weights)
    return Statistics(values, mean([part.finest for part in parts]), octaves)


def step(image: Tensor, target: Statistics, wrap: bool = False, share: Tensor | None = None) -> Tensor:
    """An image (C, H, W) one step nearer to the statistics of textures; it may be of any size from 16x16 on.

    No band is strengthened or weakened by more than a factor of 2 at once. Values may leave [0, 1] a little. wrap: as
    for `Statistics.of`. share (H, W): how much each pixel counts in what statistics the image has, 0 to 1, for images
    that are different textures in different places; all alike by default. On the CPU the same bits for any number of
    threads. Memory: 80 floats per value; cost: 0.15 cpu seconds for 3x256x256.

    Raises InputError if the image is smaller, or has another number of channels than the textures.
    """
    _check(image)
    if len(image) != target.channels:
        raise InputError(f"an image has {len(image)} channels and the statistics {target.channels}; give as many")
    count = min(_octaves(image.shape[1:]), len(target.octaves))
    pyramid = Pyramid.of(_turned(image), wrap, count, share)
    coarser: list[Tensor] = []
    for number in reversed(range(count)):
        goal, band = target.octaves[number], pyramid.bands[number]
        band = band * _strengthened(pyramid, band.abs(), coarser, goal)
        own = _channels(*pyramid.counted(band))
        moves = torch.stack([_move(one, other) for one, other in zip(own, goal.bands, strict=True)])
        band = torch.einsum("ocd,dohw->cohw", moves.to(band), band)
        pyramid.bands[number], coarser = band, [band.abs()]
    move = _move(_covariance(*pyramid.counted(pyramid.finest)), target.finest)
    pyramid.finest = torch.einsum("cd,dhw->chw", move.to(image), pyramid.finest)
    made = pyramid.image()
    return _turned(recolored(made, _values(made, share), target.values), back=True)


def _strengthened(pyramid: Pyramid, magnitudes: Tensor, coarser: Sequence[Tensor], goal: Octave) -> Tensor:
    """By how much to multiply a band's magnitudes (C, O, h, w), given those of the next coarser octave, if any.

    Magnitudes m are B p + e with the coarser ones' p and a rest e that goes with none of them: B becomes the goal's,
    and e is moved as its covariance is.
    """
    both = _together(magnitudes, coarser)
    own_means, own = _moments(*pyramid.counted(both))
    means, wanted = goal.means[: len(own)], goal.magnitudes[: len(own), : len(own)]
    count = magnitudes.shape[0] * magnitudes.shape[1]
    (slope, rest), (wanted_slope, wanted_rest) = _given(own, count), _given(wanted, count)
    move = _move(rest, wanted_rest)
    # m' = move (m - B p) + B' p, as one product
    matrix = torch.cat([move, wanted_slope - move @ slope], 1).to(both)
    shift = means[:count] + move @ (slope @ own_means[count:] - own_means[:count]) - wanted_slope @ means[count:]
    made = torch.addmm(shift.to(both)[:, None], matrix, both.flatten(1)).view_as(magnitudes)
    return (made / magnitudes.clamp(min=_UNSEEN)).clamp(1 / _GAIN, _GAIN)


def _given(covariance: Tensor, count: int) -> tuple[Tensor, Tensor]:
    """Of a Gaussian, the slope of its first values on the others, and the covariance of what is then left of them."""
    first, across, others = covariance[:count, :count], covariance[count:, :count], covariance[count:, count:]
    if not len(others):
        return across.T, first
    ridge = _RIDGE * others.diagonal().mean() + _UNSEEN**2
    slope = torch.linalg.solve(others + ridge * torch.eye(len(others)).to(others), across).T
    along = slope @ across
    return slope, first - along - along.T + slope @ others @ slope.T


def _move(own: Tensor, goal: Tensor) -> Tensor:
    """The matrix that turns values of one covariance into such of another, by the shortest way, but no gain too far."""
    unit, floor = _LEAST_VARIANCE / _UNSEEN, _LEAST_VARIANCE * torch.eye(len(own)).to(own)
    moved = transport(*(covariance * unit + floor for covariance in (own, goal)))
    gains, axes = torch.linalg.eigh((moved + moved.T) / 2)
    return (axes * gains.clamp(1 / _GAIN, _GAIN)) @ axes.T


def _together(magnitudes: Tensor, coarser: Sequence[Tensor]) -> Tensor:
    """Magnitudes (C, O, h, w) and those of the next coarser octave, if any, at their places: (K or 2 K, h, w)."""
    shape = magnitudes.shape[-2:]
    parents = [F.interpolate(one.flatten(0, 1)[None], size=shape, mode="bilinear")[0] for one in coarser]
    return torch.cat([magnitudes.flatten(0, 1), *parents])


def _channels(bands: Tensor, share: Tensor | None = None) -> Tensor:
    """The covariances (O, C, C) of complex bands (C, O, n): the real part. share (n,): how much each place counts."""
    return torch.stack([_covariance(part.real, share) + _covariance(part.imag, share) for part in bands.unbind(1)])


def _moments(values: Tensor, share: Tensor | None = None) -> tuple[Tensor, Tensor]:
    """Means (K,) and covariance (K, K) of values (K, n)."""
    means = _mean_product(values, torch.ones_like(values[:1]), share)[:, 0]
    return means, _covariance(values - means.to(values)[:, None], share)


def _values(image: Tensor, share: Tensor | None = None) -> Colors:
    """The colors of an image (C, H, W)."""
    means, covariance = _moments(image.flatten(1), None if share is None else share.flatten().to(image))
    return Colors(means[:, None], covariance + _LEAST_VARIANCE * torch.eye(len(means)).to(covariance))


def _covariance(values: Tensor, share: Tensor | None = None) -> Tensor:
    """The covariance (K, K) of values (K, n) of mean 0."""
    return _mean_product(values, values, share)


def _mean_product(first: Tensor, second: Tensor, share: Tensor | None) -> Tensor:
    """The mean (K, L) of the products of values (K, n) and (L, n); the same bits for any number of threads."""
    weighted, whole = (second, second.shape[1]) if share is None else (second * share, float(total(share.double())))
    one, other = (
        F.pad(values, (0, -values.shape[1] % _ROW)).view(len(values), -1, _ROW).transpose(0, 1)
        for values in (first, weighted)
    )
    return (one @ other.mT).double().sum(0) / max(whole, _UNSEEN)


def _turned(image: Tensor, back: bool = False) -> Tensor:
    """An image (C, H, W) as brightness and colors, or back."""
    basis = torch.from_numpy(dct(np.eye(len(image)), axis=0, norm="ortho")).to(image)
    return ((basis.T if back else basis) @ image.flatten(1)).view_as(image)


def _as_few(values: Sequence[Tensor]) -> list[Tensor]:
    """Parts of values that all have: statistics of a coarsest octave know of none coarser."""
    least = min(len(value) for value in values)
    return [value[:least, :least] if value.ndim == 2 else value[:least] for value in values]


def _octaves(shape: Sequence[int]) -> int:
    return min(_OCTAVES, int(np.log2(min(shape) / _COARSEST)))


def _check(image: Tensor) -> None:
    if image.ndim != 3 or min(image.shape[1:]) < LEAST or not image.is_floating_point():
        raise InputError(
            f"an image has shape {tuple(image.shape)} and type {image.dtype}; give floats (C, H, W) of at least "
            f"{LEAST}x{LEAST}"
        )
