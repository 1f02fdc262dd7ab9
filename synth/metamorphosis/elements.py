"""The elements of a texture: which pixels belong to them, and one by one.

Colors are split into two clusters (2-means). Where light is uneven, brightness against its surroundings splits
better; where elements are of several tones on one ground, the darkest or the brightest of three classes does, that is
the ground. So several splits are tried, and the one is kept whose parts are most like elements: many, compact, cleanly
bounded, and of like sizes.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage, stats
from scipy.cluster.vq import kmeans2
from skimage import filters, measure, morphology, segmentation

Image = NDArray[np.float64]
Mask = NDArray[np.bool_]
Labels = NDArray[np.int64]

SPECK = 20
"""Px: what is smaller is no element."""
_SMOOTHING = (0.7, 1.5)
"""Px by which images are smoothed before they are split; both are tried. Not tuned."""
_FLAT = 1e-3
"""What varies by less is one color, or one brightness: classes need more values than rounding makes."""
_MERGED = 0.9
"""Solidity below which elements are taken to touch; that of two discs that do is .88."""
_TINY = 0.1
"""Share of the median element below which a part is a crumb."""
_ENOUGH = 12
"""So many elements count as many."""


@dataclass(frozen=True)
class Elements:
    """The elements of an image (H, W, C).

    mask (H, W): True in elements. labels (H, W): 0 between elements, 1 to count within. sure: 0 to 1, how much like
    elements they are.
    """

    mask: Mask
    labels: Labels
    sure: float

    @property
    def count(self) -> int:
        """How many there are."""
        return int(self.labels.max())


def elements(image: Image) -> Elements:
    """The elements of an image (H, W, C) in [0, 1], by the split that shows them best; none where nothing splits."""
    tried = [of_mask(mask, image) for mask in _splits(image)]
    none = Elements(np.zeros(image.shape[:2], bool), np.zeros(image.shape[:2], np.int64), 0.0)
    return max(tried, key=lambda found: found.sure, default=none)


def of_mask(mask: Mask, image: Image) -> Elements:
    """The elements of an image (H, W, C) given their mask (H, W): without specks, parted where they touch."""
    mask = without_specks(mask)
    labels = labeled(mask)
    return Elements(labels > 0, labels, _sureness(labels, image))


def two_colors(image: Image) -> Mask:
    """Where an image (H, W, C) belongs to the smaller of its two clusters of colors; nowhere if it has one color."""
    if _contrast(image) == 0:
        return np.zeros(image.shape[:2], bool)
    pixels = image.reshape(-1, image.shape[2])
    centered = pixels - pixels.mean(0)
    along = centered @ np.linalg.eigh(centered.T @ centered)[1][:, -1]
    ends = [pixels[along <= np.quantile(along, 0.1)], pixels[along >= np.quantile(along, 0.9)]]
    _, cluster = kmeans2(pixels, np.stack([end.mean(0) for end in ends]), minit="matrix")
    one = cluster.reshape(image.shape[:2]) == 1
    return one if one.mean() <= 0.5 else ~one


def _contrast(image: Image) -> float:
    """The most that a channel of an image (H, W, C) varies by."""
    return float(np.ptp(image, (0, 1)).max())


def without_specks(mask: Mask) -> Mask:
    """A mask (H, W) without parts, and without holes, of fewer than SPECK px."""
    kept = morphology.remove_small_objects(mask, max_size=SPECK - 1)
    return morphology.remove_small_holes(kept, max_size=SPECK - 1)


def _splits(image: Image) -> Iterator[Mask]:
    for sigma in _SMOOTHING:
        smooth = filters.gaussian(image, sigma, channel_axis=-1, mode="reflect")
        if _contrast(smooth) < _FLAT:
            return
        colors = two_colors(smooth)
        yield colors
        yield ~colors
        gray = smooth.mean(-1)
        if np.ptp(gray) < _FLAT:
            continue
        around = filters.gaussian(gray, max(gray.shape) / 12, mode="reflect")
        for mask in (gray > filters.threshold_otsu(gray), gray > around):
            yield mask
            yield ~mask
        lower, upper = filters.threshold_multiotsu(gray, 3)
        yield gray > lower
        yield gray <= upper


def labeled(mask: Mask) -> Labels:
    """The elements of a mask (H, W), numbered from 1 on: what is not convex is cut at its waists, crumbs go."""
    labels = measure.label(mask, connectivity=1)
    touching = [part.label for part in measure.regionprops(labels) if part.solidity < _MERGED]
    if touching:
        inside = np.isin(labels, touching)
        deep = filters.gaussian(ndimage.distance_transform_edt(inside), 1.0)
        tops = morphology.h_maxima(deep, 0.5)
        cut = segmentation.watershed(-deep, measure.label(tops), mask=inside, watershed_line=True)
        labels = measure.label((labels > 0) & ~(inside & (cut == 0)), connectivity=1)
    area = np.bincount(labels.ravel())
    least = max(SPECK, _TINY * float(np.median(area[1:]))) if len(area) > 1 else SPECK
    kept = np.where(np.isin(labels, np.flatnonzero(area < least)), 0, labels)
    return segmentation.relabel_sequential(kept)[0].astype(np.int64)


def _sureness(labels: Labels, image: Image) -> float:
    """How much like elements parts are: many, compact, alike in size, with an edge of the image all around them."""
    parts = measure.regionprops(labels)
    if len(parts) < 2:
        return 0.0
    area = np.array([part.area for part in parts], float)
    many = min(1.0, len(parts) / _ENOUGH)
    compact = float(np.average([part.solidity for part in parts], weights=area))
    alike = 1 / (1 + float(np.std(np.log(area))))
    return many * compact**2 * alike * _edged(labels, image) * _spread(area, labels.size)


def _edged(labels: Labels, image: Image) -> float:
    """How far the edge strength along the outlines stands out: 0 as anywhere, 1 stronger than all elsewhere.

    That is how often a pixel there beats one elsewhere, less how often it loses (Mann and Whitney's statistic).
    """
    smooth = filters.gaussian(image, 0.7, channel_axis=-1)
    edges = np.mean([filters.sobel(channel) for channel in np.moveaxis(smooth, -1, 0)], 0)
    outline = segmentation.find_boundaries(labels, mode="thick")
    if outline.all() or not outline.any():
        return 0.0
    ranks = stats.rankdata(edges).reshape(edges.shape)[outline]
    beaten = (ranks.mean() - (ranks.size + 1) / 2) / (edges.size - ranks.size)
    return float(max(0.0, 2 * beaten - 1))


def _spread(area: NDArray[np.float64], pixels: int) -> float:
    """Lower where elements cover little of the image, or one of them covers most of it."""
    cover, largest = area.sum() / pixels, area.max() / pixels
    return float(np.clip(cover / 0.2, 0, 1) * np.clip(2 - 6 * largest, 0, 1))
