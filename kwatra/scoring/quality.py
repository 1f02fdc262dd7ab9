"""How good a texture is, in figures.

Two images are alike as textures when their windows are alike. Windows are 7 x 7 pixels at the
scales 1, 2 and 4, and all distances are rms over a window's values, divided by the exemplar's
standard deviation (of its pixels about their mean color; by nothing if it is of one color): 0 is
perfect, 1 is hopeless.

    forward       mean distance from the output's windows to the nearest of the exemplar's: is what
                  is seen plausible? (Kwatra et al. 2005, section 3, as an error.)
    coverage      the same from the exemplar's windows to the output's: does everything appear?
                  (Simakov et al. 2008, completeness.)
    wasserstein   sliced Wasserstein distance between the two sets of windows: does it appear as
                  often? (Rabin et al. 2011.)
    sharpness     mean absolute gradient, output / exemplar: below 1 is blur.
    copy, use     how large the verbatim copies are, and how evenly the exemplar is used.

A low forward distance alone proves nothing (one pebble repeated has it), nor does a low overall
figure with a high `copy`: the exemplar pasted whole is perfect. Distances come from about QUERIES
sampled windows, searched among all windows of the other image a bounded number at a time, on one
thread and without global random state: the same input gives the same bits.
"""

from collections.abc import Callable, Sequence
from itertools import islice

import numpy as np
import torch
from torch import Tensor

from kwatra.base import InputError, tensor_of
from kwatra.scoring.copies import CopyMap, nothing_copied, trace
from kwatra.scoring.nearest import QUERIES, WINDOW, Nearest, Windows, one_thread
from kwatra.scoring.pixels import deviation, gradient, ratio, unit
from kwatra.scoring.sliced import sliced_distance
from kwatra.scoring.video import video_figures

SCALES = (1, 2, 4)
"""How many times coarser windows are looked at: grain, elements, and how these lie."""

COPY_WINDOW = 11
"""Pixels to a side of the windows that count as copied where they are found again."""

Images = Tensor | Sequence[Tensor]


@one_thread
def measure(output: Tensor, exemplar: Images) -> dict[str, float]:
    """All figures of an output against its exemplar.

    output: (C, H, W) float, any units, or a video (C, T, H, W). exemplar: the same, or several of one texture.
    Where both are videos, those of `kwatra.scoring.video`, of how they move as well. Where the output alone is one, the
    figures of its frames are averaged; where the exemplar alone is, its frames are so many images.
    Scales whose windows are longer than half the smallest side are left out; scale 1 never is.

    Returns forward, coverage, wasserstein (at least 0, means over the scales), sharpness (1 is
    right), copy and use (0..1), and overall: the mean of forward, coverage, wasserstein and
    |1 - sharpness|, to rank by; lower is better. For videos: forward, coverage, wasserstein, sharpness, change,
    flicker, tempo, order, direction, replay, loop, and overall.

    Raises InputError for sides under 7 pixels, channel counts that differ, and values that are not
    finite floating-point numbers.
    """
    frames, images = read(output, exemplar)
    several = [exemplar] if isinstance(exemplar, Tensor) else exemplar
    if output.ndim == 4 and all(each.ndim == 4 for each in several):
        one = iter(images)
        clips = [torch.stack(list(islice(one, each.shape[1])), 1) for each in several]
        return video_figures(torch.stack(frames, 1), clips, carried_scales(output, exemplar))
    figures = [_measure_image(frame, images) for frame in frames]
    return {name: sum(f[name] for f in figures) / len(figures) for name in figures[0]}


def _measure_image(output: Tensor, exemplar: list[Tensor]) -> dict[str, float]:
    scales = carried_scales(output, exemplar)

    def mean(energy: Callable[..., float]) -> float:
        return sum(energy(output, exemplar, scale=scale) for scale in scales) / len(scales)

    distances = {
        "forward": mean(forward_energy),
        "coverage": mean(coverage_energy),
        "wasserstein": mean(sliced_wasserstein),
    }
    ratio = sharpness(output, exemplar)
    copies = copy_map(output, exemplar)
    overall = (sum(distances.values()) + abs(1 - ratio)) / 4
    others = {"sharpness": ratio, "copy": copies.size, "use": copies.use, "overall": overall}
    return distances | others


def carried_scales(output: Tensor, exemplar: Images) -> tuple[int, ...]:
    """The scales at which two windows fit side by side in every image; always the first."""
    frames, images = read(output, exemplar)
    shortest = min(min(image.shape[1:]) for image in frames + images)
    return SCALES[:1] + tuple(s for s in SCALES[1:] if 2 * WINDOW * s <= shortest)


@one_thread
def forward_energy(output: Tensor, exemplar: Images, *, scale: int = 1) -> float:
    """Mean distance from output windows to the nearest exemplar windows, in standard deviations.

    Shapes and errors as in `measure`. scale: 7 * scale pixels must fit in every image.
    """
    frames, images = read(output, exemplar, scale)
    return _mean_distance(frames, images, scale) / unit(images)


@one_thread
def coverage_energy(output: Tensor, exemplar: Images, *, scale: int = 1) -> float:
    """Mean distance from exemplar windows to the nearest output windows, in standard deviations.

    Shapes and errors as in `forward_energy`.
    """
    frames, images = read(output, exemplar, scale)
    return _mean_distance(images, frames, scale) / unit(images)


def _mean_distance(images: list[Tensor], others: list[Tensor], scale: int) -> float:
    queries = Windows.of(images, WINDOW, scale)
    nearest = Nearest(Windows.of(others, WINDOW, scale))
    distance, _ = nearest.search(queries.rows(queries.sample(QUERIES)))
    return float(distance.mean())


@one_thread
def sliced_wasserstein(output: Tensor, exemplar: Images, *, scale: int = 1) -> float:
    """Sliced Wasserstein-1 distance between the sets of windows, in standard deviations.

    The mean over random unit directions of the distance between the projected sets, by their
    quantiles. Shapes and errors as in `forward_energy`.
    """
    frames, images = read(output, exemplar, scale)
    sets = (Windows.of(side, WINDOW, scale) for side in (frames, images))
    return sliced_distance(*(windows.rows(windows.sample(4 * QUERIES)) for windows in sets)) / unit(images)


@one_thread
def sharpness(output: Tensor, exemplar: Images) -> float:
    """Mean absolute gradient of the output divided by the exemplar's.

    Where the exemplar has none: 1 plus the output's, so that 1 stays the right answer. Shapes and
    errors as in `measure`.
    """
    frames, images = read(output, exemplar)
    return ratio(gradient(frames), gradient(images))


@one_thread
def copy_map(output: Tensor, exemplar: Images, *, tolerance: float = 0.1) -> CopyMap:
    """The regions of an output (C, H, W) that were copied verbatim, and from where.

    tolerance: how far, in standard deviations of the exemplar and rms over an 11 x 11 window, a
    copy may be from its original. exemplar and errors as in `measure`. In images with sides under
    11 pixels the window is as large as fits. An exemplar of one color has no places to tell apart:
    nothing counts as copied, and the use as even.
    """
    frames, images = read(output, exemplar)
    if len(frames) > 1:
        raise InputError(f"output has {len(frames)} frames; a copy map is of one image, (C, H, W)")
    tolerance *= deviation(images)
    if tolerance == 0:
        return nothing_copied(frames[0].shape[1:])
    window = min(COPY_WINDOW, *(side for image in frames + images for side in image.shape[1:]))
    return trace(frames[0], images, window, tolerance)


def read(output: Tensor, exemplar: Images, scale: int = 1) -> tuple[list[Tensor], list[Tensor]]:
    """Both sides as lists of images (C, H, W) float32 on the CPU, checked."""
    if scale < 1:
        raise InputError(f"scale is {scale}; give a whole number from 1")
    several = [exemplar] if isinstance(exemplar, (Tensor, np.ndarray)) else list(exemplar)
    if not several:
        raise InputError("exemplar is an empty list; give at least one image")
    frames = _frames(output, "output", scale)
    images = [frame for each in several for frame in _frames(each, "exemplar", scale)]
    for image in images:
        if image.shape[0] != frames[0].shape[0]:
            raise InputError(
                f"exemplar has {image.shape[0]} channels and output has {frames[0].shape[0]}; give both as many"
            )
    return frames, images


def _frames(images: Tensor, name: str, scale: int) -> list[Tensor]:
    images = tensor_of(images)
    if images.ndim not in (3, 4) or not images.is_floating_point():
        raise InputError(
            f"{name} is {images.dtype} of shape {tuple(images.shape)}; "
            "give floating-point (C, H, W), or (C, T, H, W) for a video"
        )
    if min(images.shape) < 1 or min(images.shape[-2:]) < WINDOW * scale:
        raise InputError(
            f"{name} is {images.shape[-1]}x{images.shape[-2]} pixels; "
            f"windows of {WINDOW} pixels at scale {scale} need at least {WINDOW * scale} each way"
        )
    if not images.isfinite().all():
        raise InputError(f"{name} holds NaN or infinite values; replace them before measuring")
    plain = images.detach().to("cpu", torch.float32)
    return [plain] if plain.ndim == 3 else list(plain.unbind(1))
