"""Hiding what seams remain (thesis section 3.3), after the cut and without touching it.

    feathering:  x(p) = sum_L w_L(p) P_L(p) / sum_L w_L(p),   w_L = G_s * [label = L]
    splining:    the same in each frequency band, the band of scale s blended over a width of about s

P_L is patch L continued past its seams, in so far as its source reaches; w_L falls off towards the source's border,
where the patch ends, so that it ends gently. Feathering suits small misfits in colour; it is wider along time, where a
seam flat across it would change many pixels in one frame, but not where patches differ much. Splining hides strong
misfits, and takes contrast away where patches are small.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy import ndimage

from kwatra.pieces.boxes import Box
from kwatra.pieces.seams import LEVELS, Mosaic
from kwatra.pieces.sheet import Sheet

SPLINE_SIGMAS = (1.0, 2.0, 4.0, 8.0)
"""The octaves that are splined, in px."""
ALIKE = 0.3
"""A difference, as a part of the colour range, with which a patch still has a good third of its weight in other frames:
mixed with what it is not like, it would be seen as a ghost."""
HARD_FRAMES = 0.5
"""How wide feathering is along time, in frames, where patches are not alike."""
FADING = 2.0
"""How many widths of the blending before its source ends a patch begins to lose its weight."""
FRAMES_PER_PIXEL = 2.0
"""How much wider feathering is along time, in frames, than across the picture, in pixels. Smoke of 12 frames made twice
as long steps by 1.05 times its source's largest step, by 1.30 where seams are not spread; 3 leaves ghosts in flames."""


def feather(sheet: Sheet[Mosaic], sigma: float) -> np.ndarray:
    """The sheet as an image (C, *shape), seams blended by a Gaussian of `sigma` pixels, twice as many frames."""
    time = [FRAMES_PER_PIXEL * sigma] * (len(sheet.shape) - 2)
    return _blend(sheet, [(*time, sigma, sigma)], bands=False)


def spline(sheet: Sheet[Mosaic]) -> np.ndarray:
    """The sheet as an image (C, *shape), blended across seams by multi-resolution splining."""
    time = [FRAMES_PER_PIXEL] * (len(sheet.shape) - 2)
    return _blend(sheet, [(*time, sigma, sigma) for sigma in SPLINE_SIGMAS], bands=True)


def blending_reach(sigma: float) -> int:
    """How far from a seam, in pixels or frames, a Gaussian of this width changes anything."""
    return int(np.ceil(3 * sigma))


def ending_reach(dims: int, sigma: float, splined: bool) -> tuple[int, ...]:
    """How far, per axis, a patch must lie from its source's border to have its full weight."""
    time, across = (FRAMES_PER_PIXEL, max(SPLINE_SIGMAS)) if splined else (FRAMES_PER_PIXEL * sigma, sigma)
    return (int(np.ceil(FADING * time)),) * (dims - 2) + (int(np.ceil(FADING * across)),) * 2


def _blend(sheet: Sheet[Mosaic], widths: list[tuple[float, ...]], bands: bool) -> np.ndarray:
    """Blended by Gaussians of `widths`, one for each band but the last, or one in all; each per axis."""
    channels = len(sheet.sources.planes)
    levels = len(widths) + (1 if bands else 0)
    total = np.zeros((levels, channels, *sheet.shape), np.float32)
    weights = np.zeros((levels, *sheet.shape), np.float32)
    margin = tuple(blending_reach(width) for width in widths[-1])
    plain = sheet.sources.originals(sheet.places)
    for label in np.unique(sheet.label[sheet.filled]):
        box = _around(sheet, int(label), margin)
        at = sheet.indices(box)
        image, depth = _patch_image(sheet, int(label), box)
        own = (sheet.label[at] == label).astype(np.float32)
        masks = [_blurred(own, width) for width in widths]
        if not bands and len(at) > 2:
            there = np.stack([plane[at] for plane in plain])
            misfit = np.abs(image - there).mean(0) / (sheet.sources.step * LEVELS)
            masks = [_where_alike(masks[0], misfit, own, widths[0])]
        masks = [mask * _ending(depth, width) for mask, width in zip(masks, widths, strict=True)]
        layers = _bands(image, widths) if bands else [image]
        for level, layer in enumerate(layers):
            mask = masks[min(level, len(masks) - 1)]
            weights[level][at] += mask
            for channel in range(channels):
                total[level, channel][at] += layer[channel] * mask
    # Far from seams a pixel is a copy, and rounding must not say otherwise.
    least = 1e-6 * sheet.sources.step * LEVELS
    for line in range(sheet.shape[0]):  # one at a time, for a video has many
        blended = (total[:, :, line] / np.maximum(weights[:, None, line], 1e-12)).sum(0)
        np.copyto(plain[:, line], blended, where=np.abs(blended - plain[:, line]) >= least)
    return plain


def _where_alike(mask: np.ndarray, misfit: np.ndarray, own: np.ndarray, width: tuple[float, ...]) -> np.ndarray:
    """The mask where the patch is like what is there; elsewhere one that hardly reaches into other frames."""
    narrow = _blurred(own, (*[HARD_FRAMES] * (len(width) - 2), *width[-2:]))
    blended: np.ndarray = narrow + np.exp(-np.square(misfit / ALIKE)) * (mask - narrow)
    return blended


def _around(sheet: Sheet[Mosaic], label: int, margin: tuple[int, ...]) -> Box:
    """The pixels within `margin` per axis of a patch's; on an axis that wraps, at most once around."""
    box = sheet.patches[label].box
    start, extent = [], []
    for s, e, n, wraps, most in zip(box.start, box.extent, sheet.shape, sheet.periodic, margin, strict=True):
        reach = min(most, (n - e) // 2) if wraps else most
        start.append(s - reach)
        extent.append(e + 2 * reach)
    return Box(tuple(start), tuple(extent)).clipped(sheet.shape, sheet.periodic)


def _patch_image(sheet: Sheet[Mosaic], label: int, box: Box) -> tuple[np.ndarray, list[np.ndarray]]:
    """Patch `label` over `box`, its border repeated outside the source, and how many pixels deep inside, per axis."""
    patch = sheet.patches[label]
    image = sheet.sources.images[patch.number]
    depth = []
    for axis, (start, stop, shift) in enumerate(zip(box.start, box.stop, patch.shift, strict=True)):
        at = np.arange(start, stop) - shift
        count = sheet.sources.shapes[patch.number][axis]
        image = np.take(image, np.clip(at, 0, count - 1), axis + 1)
        depth.append(np.clip(np.minimum(at + 1, count - at), 0, None).astype(np.float32))
    return image, depth


def _ending(depth: list[np.ndarray], width: tuple[float, ...]) -> np.ndarray:
    """What is left of a patch's weight near its source's border: all of it from FADING times the width on."""
    weight = np.ones((), np.float32)
    for line in np.ix_(*[np.minimum(inside / (FADING * w), 1) for inside, w in zip(depth, width, strict=True)]):
        weight = np.minimum(weight, line)
    return weight


def _blurred(values: np.ndarray, width: tuple[float, ...]) -> np.ndarray:
    result: np.ndarray = ndimage.gaussian_filter(values, width, mode="nearest", truncate=3)
    return result


def _bands(image: np.ndarray, widths: list[tuple[float, ...]]) -> list[np.ndarray]:
    """Band-pass layers of each frame from fine to coarse that sum to the image: what moves is not a fine detail."""
    still = [(*[0.0] * (len(width) - 2), *width[-2:]) for width in widths]
    smooth = [image] + [np.stack([_blurred(plane, width) for plane in image]) for width in still]
    return [a - b for a, b in pairwise(smooth)] + [smooth[-1]]
